//! How a volume is cut when it does not fit into one texture, or into memory, at once (3.3-6).
//!
//! A brick owns a range of cells: the samples in them are taken while its voxels are in a texture. It
//! has a border of further voxels, so that whatever is read around those samples is there. Rays visit
//! bricks in the order in which they pass them and keep their state in between, so the picture is the
//! one of the whole volume.

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::Stage;

use crate::texture::Part;
use crate::{GpuError, kernels, optics};

/// A piece of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brick {
    /// The cells whose samples are its own.
    pub core: Part,
    /// The voxels of its texture.
    pub voxels: Part,
    /// Its place among the bricks.
    pub place: [usize; 3],
}

/// Voxels beyond a brick's cells that its samples need: those that filter and gradient reach for, and for
/// modes that look at segments their length: `stride` steps (3.3-6).
pub fn border(stage: &Stage, grid: &Grid, stride: f64) -> usize {
    let step = (stage.step * stride / grid.smallest_spacing()).ceil() as usize;
    kernels::reach(stage.quality.filter, stage.quality.gradient) + if optics::is_of_segments(stage) { step } else { 0 }
}

/// Cuts a grid into bricks of at most `side` voxels per axis; if it has more than `bytes`, so that none
/// of them has. One brick is the whole grid.
///
/// # Errors
/// [`GpuError::Budget`] if not even a brick of one cell fits.
pub fn cut(
    dims: [usize; 3],
    border: usize,
    side: usize,
    voxel_bytes: usize,
    bytes: u64,
) -> Result<Vec<Brick>, GpuError> {
    let cells = dims.map(|n| (n - 1).max(1));
    let whole = dims.iter().map(|&n| n as u64).product::<u64>() * voxel_bytes as u64;
    let mut most = cells;
    if dims.iter().any(|&n| n > side) || whole > bytes {
        let extra = 2 * border + 1;
        let cube = ((bytes / voxel_bytes as u64) as f64).cbrt().floor() as usize;
        let room = side.min(cube);
        if room <= extra {
            let needed = ((extra + 1) as u64).pow(3) * voxel_bytes as u64;
            let what = format!("a brick of one cell with a border of {border} voxels");
            let advice = "allow more memory or larger textures, or take shorter steps";
            return Err(GpuError::Budget { what, needed, budget: bytes, advice });
        }
        most = cells.map(|n| n.min(room - extra));
    }
    let counts = [0, 1, 2].map(|axis| cells[axis].div_ceil(most[axis]));
    let mut bricks = Vec::with_capacity(counts.iter().product());
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                let place = [x, y, z];
                let low = [0, 1, 2].map(|axis| place[axis] * most[axis]);
                let high = [0, 1, 2].map(|axis| (low[axis] + most[axis]).min(cells[axis]));
                let voxels = Part {
                    low: low.map(|v| v.saturating_sub(border)),
                    high: [0, 1, 2].map(|axis| (high[axis] + 1 + border).min(dims[axis])),
                };
                bricks.push(Brick { core: Part { low, high }, voxels, place });
            }
        }
    }
    Ok(bricks)
}

/// Puts bricks in an order in which no ray passes one before another that is nearer (8.2): a ray only
/// moves away from the eye along every axis, so the number of bricks it has passed never falls.
pub fn sort(bricks: &mut [Brick], stage: &Stage, grid: &Grid) {
    sort_boxes(bricks, stage, grid, |brick| (brick.core.low, brick.place));
}

/// The same of boxes in a lattice: `of` tells the first cell of one and its place in the lattice.
pub fn sort_boxes<T>(boxes: &mut [T], stage: &Stage, grid: &Grid, of: impl Fn(&T) -> ([usize; 3], [usize; 3])) {
    let view = &stage.viewpoint;
    let eye = if view.perspective {
        grid.index_from_world().transform_point3(view.eye)
    } else {
        // Parallel rays come from infinitely far; an axis that they do not move along orders nothing.
        let along = grid.index_from_world().transform_vector3(view.forward);
        DVec3::from_array(along.to_array().map(|v| if v == 0.0 { 0.0 } else { f64::INFINITY * -v }))
    };
    // The place of the eye among them: that of the last one that begins before it.
    let mut home = [0; 3];
    for (low, place) in boxes.iter().map(&of) {
        for axis in 0..3 {
            if low[axis] as f64 <= eye[axis] {
                home[axis] = home[axis].max(place[axis]);
            }
        }
    }
    boxes.sort_by_key(|item| (0..3).map(|axis| of(item).1[axis].abs_diff(home[axis])).sum::<usize>());
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use pellucid_scene::{Format, Scene, Stage};
    use proptest::prelude::*;

    /// How often every element of a box lies in one of the parts.
    fn covered(parts: impl Iterator<Item = Part>, dims: [usize; 3]) -> Vec<u32> {
        let mut counts = vec![0; dims.iter().product()];
        for Part { low, high } in parts {
            for (z, y, x) in (low[2]..high[2])
                .flat_map(|z| (low[1]..high[1]).flat_map(move |y| (low[0]..high[0]).map(move |x| (z, y, x))))
            {
                counts[x + dims[0] * (y + dims[1] * z)] += 1;
            }
        }
        counts
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn cores_tile_the_cells_and_borders_are_there(
            dims in prop::array::uniform3(1usize..40),
            border in 1usize..5,
            side in 4usize..64,
            voxel_bytes in prop::sample::select(vec![1usize, 2, 4]),
            bytes in prop_oneof![Just(1u64 << 40), 100u64..100_000],
        ) {
            let whole = dims.iter().product::<usize>() as u64 * voxel_bytes as u64;
            let bricks = match cut(dims, border, side, voxel_bytes, bytes) {
                Ok(bricks) => bricks,
                Err(GpuError::Budget { needed, .. }) => {
                    // Only where a cell with its border is too large for the limits.
                    let least = 2 * border + 2;
                    prop_assert!(side < least || bytes < needed);
                    prop_assert_eq!(needed, (least as u64).pow(3) * voxel_bytes as u64);
                    return Ok(());
                }
                Err(error) => panic!("{error}"),
            };
            let cells = dims.map(|n| (n - 1).max(1));
            prop_assert!(covered(bricks.iter().map(|brick| brick.core), cells).iter().all(|&n| n == 1));
            if dims.iter().all(|&n| n <= side) && whole <= bytes {
                prop_assert_eq!(bricks.len(), 1);
            }
            for Brick { core, voxels, .. } in &bricks {
                prop_assert!(voxels.dims().iter().all(|&n| n <= side));
                prop_assert!(voxels.dims().iter().product::<usize>() as u64 * voxel_bytes as u64 <= bytes);
                for axis in 0..3 {
                    // Voxels of the cells, and as many more to both sides as there are.
                    prop_assert_eq!(voxels.low[axis], core.low[axis].saturating_sub(border));
                    prop_assert_eq!(voxels.high[axis], (core.high[axis] + 1 + border).min(dims[axis]));
                }
            }
        }

        #[test]
        fn no_ray_meets_a_brick_after_one_behind_it(
            dims in prop::array::uniform3(2usize..30),
            side in 4usize..12,
            eye in prop::array::uniform3(-40.0..70.0f64),
            aims in prop::collection::vec(prop::array::uniform3(0.0..1.0f64), 1..20),
            perspective: bool,
        ) {
            let grid = Grid::with_spacing(dims, [1.0, -0.7, 2.0], [3.0, 1.0, -5.0]).unwrap();
            let target = grid.center();
            let position = grid.world_from_index().transform_point3(DVec3::from_array(eye));
            prop_assume!((position - target).length() > 0.1);
            let stage = stage(&grid, position, target, perspective);
            let mut bricks = cut(dims, 1, side, 1, 1 << 40).unwrap();
            sort(&mut bricks, &stage, &grid);
            for aim in aims {
                // A ray through a point of the box, walked in small steps.
                let (low, high) = grid.index_bounds();
                let through = low + (high - low) * DVec3::from_array(aim);
                let forward = grid.index_from_world().transform_vector3(stage.viewpoint.forward);
                let from = DVec3::from_array(eye);
                let way = if perspective { (through - from).normalize() } else { forward.normalize() };
                let first = if perspective { from } else { through - way * 200.0 };
                let mut last = 0;
                for step in 0..8000 {
                    let p = first + way * (f64::from(step) * 0.05);
                    if p.cmplt(low).any() || p.cmpgt(high).any() {
                        continue;
                    }
                    let cell = [0, 1, 2].map(|axis| (p[axis] as usize).min(dims[axis] - 2));
                    let here = bricks.iter().position(|brick| {
                        (0..3).all(|axis| (brick.core.low[axis]..brick.core.high[axis]).contains(&cell[axis]))
                    });
                    let here = here.unwrap();
                    prop_assert!(here >= last, "brick {here} after {last} at {p}");
                    last = here;
                }
            }
        }
    }

    pub(crate) fn stage(grid: &Grid, eye: DVec3, target: DVec3, perspective: bool) -> Stage {
        let projection = if perspective { "perspective.vertical_fov = 40" } else { "orthographic = {}" };
        let (eye, target) = (eye.to_array(), target.to_array());
        let text = format!(
            "[[volumes]]\nsource = \"memory\"\n[camera]\nprojection.{projection}\n\
             view.look_at = {{ position = {eye:?}, target = {target:?} }}"
        );
        let scene = Scene::parse(&text, Format::Toml).unwrap();
        let volume = pellucid_field::Volume::new(*grid, vec![0u8; grid.len()]).unwrap();
        scene.resolve(&[std::sync::Arc::new(volume)]).unwrap().0
    }
}
