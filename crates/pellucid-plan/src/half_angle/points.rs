//! Where the light in a volume is remembered (6.1-2).

use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::{FieldError, Grid};
use pellucid_scene::Stage;

use super::around;

/// Most points of all light volumes of a scene: a gibibyte.
const MOST_POINTS: usize = 1 << 28;

/// Most texels along a light's picture for them: above, what follows its rays takes more than the points.
const MOST_TEXELS: f64 = 2048.0;

/// The points of a light volume over a grid's box.
pub struct LightPoints {
    /// The points as a grid.
    pub grid: Grid,
    /// Texels along the light's picture, about as far apart as the points.
    pub texels: u32,
    /// Points for each voxel and axis: as asked for, or fewer, so that there are not too many.
    pub resolution: f64,
}

impl LightPoints {
    /// The points of a light volume around all volumes, if what is lit asks for one: at most `side` along an axis, those
    /// of all lights along the last.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of(stage: &Stage, side: usize) -> Result<Option<Self>, FieldError> {
        let points = |resolution| Self::new(&around(stage)?, resolution, stage.lights.len(), side);
        stage.light_resolution().map(points).transpose()
    }

    /// With `resolution` points for each voxel and axis, for each of so many lights, or as many as there can be: points
    /// of all lights lie one behind the other along the last axis, and no axis has more than `side`.
    ///
    /// # Errors
    /// [`FieldError`] if the grid of the points is none.
    pub fn new(grid: &Grid, resolution: f64, lights: usize, side: usize) -> Result<Self, FieldError> {
        Self::within(grid, resolution, [MOST_POINTS / lights.max(1), side, side / lights.max(1)])
    }

    fn within(grid: &Grid, asked: f64, [most, side, depth]: [usize; 3]) -> Result<Self, FieldError> {
        let (low, high) = grid.index_bounds();
        let voxels = high - low;
        let dims = |resolution: f64| voxels.to_array().map(|n| (n * resolution).ceil().max(1.0) as usize + 1);
        let mut resolution = asked;
        loop {
            let [nx, ny, nz] = dims(resolution).map(|n| n as f64);
            // A share of each axis, as far as points have to be fewer.
            let room = (most as f64 / (nx * ny * nz)).cbrt();
            let room = room.min(side as f64 / nx.max(ny)).min(depth as f64 / nz);
            // Two points at each end are the fewest there can be.
            if room >= 1.0 || nx.max(ny).max(nz) <= 2.0 {
                break;
            }
            resolution *= room.min(0.99);
        }
        let dims = dims(resolution);
        let spacing = voxels / DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let index_from_point = DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: low };
        let points = Grid::with_affine(dims, grid.world_from_index() * index_from_point)?;
        let [near, far] = [points.smallest_spacing(), grid.world_corners()[0].distance(grid.center()) * 2.0];
        let texels = (far / near).ceil().clamp(16.0, MOST_TEXELS) as u32;
        Ok(Self { grid: points, texels, resolution })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn points_are_as_many_as_asked_for_or_as_there_can_be(
            dims in [1usize..3000, 1usize..3000, 1usize..3000],
            asked in 0.05f64..4.0,
            most in 8usize..1 << 24,
            side in 2usize..5000,
        ) {
            let grid = Grid::new(dims).unwrap();
            let found = LightPoints::within(&grid, asked, [most, side, side]).unwrap();
            let points = found.grid.dims();
            prop_assert!(found.grid.len() <= most && points.iter().all(|n| *n <= side), "{points:?}");
            if found.resolution < asked {
                // Ten in a hundred more along each axis, and what is rounded up, would be too many.
                let more = points.map(|n| (n as f64 * 1.1).ceil() as usize + 1);
                prop_assert!(more.iter().product::<usize>() > most || more.iter().any(|n| *n > side), "{points:?}");
            }
        }
    }
}
