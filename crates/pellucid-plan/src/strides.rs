//! Longer steps where nothing is missed: the importance of every block (7.3-3, 7.3-4).

use pellucid_field::{Blocks, distances};
use pellucid_optics::{Bend, Chroma, OpticsError, StepTable, Table};

/// How many samples rays take between two looks at the blocks: asking at every border costs more than
/// the samples it saves.
pub const SAMPLES_PER_LOOK: usize = 8;

/// Strides are powers of two: 1, 2 and 4 steps.
const LEVELS: usize = 3;

/// The level of the stride that every block allows: the stride is `2^level` steps.
///
/// A block has an own level, the largest at which a stride's sample is no further than `tolerance`
/// from the samples it stands for; blocks without opacity have the largest. Rays look at blocks once
/// in [`SAMPLES_PER_LOOK`] samples, so a block allows a stride only if no block within its reach has a smaller
/// level. `step` is the longest step along any axis, in voxels.
pub(crate) fn levels(
    blocks: &Blocks,
    table: &StepTable,
    live: impl Fn(f32, f32) -> bool,
    tolerance: f32,
    step: f64,
) -> Vec<u8> {
    let bend = Bend::of_steps(table);
    let own = |&[low, high]: &[f32; 2]| {
        if !live(low, high) {
            return LEVELS - 1;
        }
        let fits = |level: &usize| {
            // Values may change by a quarter of the block's range over half of a stride of two.
            let stride = (1 << level) as f32;
            stride * bend.over(low, high, (high - low) / 8.0 * stride) <= tolerance
        };
        (1..LEVELS).take_while(fits).last().unwrap_or(0)
    };
    let own: Vec<usize> = blocks.ranges().iter().map(own).collect();
    let mut levels = vec![0; own.len()];
    for level in 1..LEVELS {
        let reach = ((SAMPLES_PER_LOOK << level) as f64 * step / blocks.size() as f64).ceil() as usize;
        let finer = distances(blocks.dims(), |block| own[block] < level);
        for (level_of_block, &distance) in levels.iter_mut().zip(&finer) {
            if usize::from(distance) > reach.min(254) {
                *level_of_block = level as u8;
            }
        }
    }
    levels
}

/// The tables of all strides: a sample of level l looks at the l-th.
pub(crate) fn tables(table: &Table, ratio: f32, chroma: Option<&Chroma>) -> Result<Vec<StepTable>, OpticsError> {
    (0..LEVELS).map(|level| StepTable::of(table, ratio * (1 << level) as f32, chroma)).collect()
}
