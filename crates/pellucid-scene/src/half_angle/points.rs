//! Where the light in a volume is remembered (6.1-2).

use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::{FieldError, Grid};

/// The points of a light volume over a grid's box.
pub struct LightPoints {
    /// The points as a grid.
    pub grid: Grid,
    /// Index position of the first.
    pub low: DVec3,
    /// Voxels from one to the next.
    pub spacing: DVec3,
    /// Texels along the light's picture, about as far apart as the points.
    pub texels: u32,
}

impl LightPoints {
    /// With `resolution` points for each voxel and axis.
    ///
    /// # Errors
    /// [`FieldError`] if they are too many.
    pub fn new(grid: &Grid, resolution: f64) -> Result<Self, FieldError> {
        let (low, high) = grid.index_bounds();
        let dims = (high - low).to_array().map(|voxels| (voxels * resolution).ceil().max(1.0) as usize + 1);
        let spacing = (high - low) / DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let index_from_point = DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: low };
        let points = Grid::with_affine(dims, grid.world_from_index() * index_from_point)?;
        let [near, far] = [points.smallest_spacing(), grid.world_corners()[0].distance(grid.center()) * 2.0];
        let texels = (far / near).ceil().clamp(16.0, 4096.0) as u32;
        Ok(Self { grid: points, low, spacing, texels })
    }
}
