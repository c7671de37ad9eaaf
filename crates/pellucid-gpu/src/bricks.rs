//! How a volume is cut when it does not fit into one texture, or into memory, at once (3.3-6).
//!
//! A brick owns a range of cells: the samples in them are taken while its voxels are in a texture. It
//! has a border of further voxels, so that whatever is read around those samples is there. Rays visit
//! bricks in the order in which they pass them and keep their state in between, so the picture is the
//! one of the whole volume.

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::{Mode, Stage};

use crate::texture::Part;
use crate::{GpuError, kernels};

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
/// modes that look at segments their length.
pub fn border(stage: &Stage, grid: &Grid) -> usize {
    use pellucid_scene::Classification::PreIntegrated;
    let segments = match stage.mode() {
        Mode::Isosurface(_) => true,
        Mode::Composite => stage.quality.classification == PreIntegrated,
        _ => false,
    };
    let step = (stage.step / grid.smallest_spacing()).ceil() as usize;
    kernels::reach(stage.quality.filter, stage.quality.gradient) + if segments { step } else { 0 }
}

/// Cuts a grid into the fewest bricks of at most `side` voxels per axis whose textures have at most
/// `bytes` in all, each voxel having so many.
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
    let view = &stage.viewpoint;
    let eye = if view.perspective {
        grid.index_from_world().transform_point3(view.eye)
    } else {
        // Parallel rays come from infinitely far; an axis that they do not move along orders nothing.
        let along = grid.index_from_world().transform_vector3(view.forward);
        DVec3::from_array(along.to_array().map(|v| if v == 0.0 { 0.0 } else { f64::INFINITY * -v }))
    };
    // The place of the eye among the bricks: that of the last brick that begins before it.
    let mut home = [0; 3];
    for brick in bricks.iter() {
        for axis in 0..3 {
            if brick.core.low[axis] as f64 <= eye[axis] {
                home[axis] = home[axis].max(brick.place[axis]);
            }
        }
    }
    bricks.sort_by_key(|brick| (0..3).map(|axis| brick.place[axis].abs_diff(home[axis])).sum::<usize>());
}
