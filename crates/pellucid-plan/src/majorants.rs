//! Bounds of the extinction in blocks of the data, for paths that look for their next collision.

use pellucid_field::{Blocks, Leaps};
use pellucid_optics::ExtinctionBounds;

/// The least and the largest extinction in every block.
#[derive(Clone, Debug)]
pub struct MajorantGrid {
    /// Cells of the data along a side of a block; infinite if there is only one.
    pub size: f32,
    /// Per world unit, x fastest.
    pub bounds: Vec<[f32; 2]>,
    /// How far it is to the next block where there is extinction.
    pub leaps: Leaps,
}

impl MajorantGrid {
    /// Those of blocks, or one that bounds everything if nothing is known of blocks. Extinctions vary by
    /// `factors`; where some values are absent, there may be none anywhere.
    pub(crate) fn new(
        blocks: Option<&Blocks>,
        extinctions: &ExtinctionBounds,
        factors: [f32; 2],
        is_whole: bool,
    ) -> Self {
        let bound = |low, high| {
            let [least, most] = extinctions.over(low, high);
            [if is_whole { least * factors[0] } else { 0.0 }, most * factors[1]]
        };
        let of_block = |&range: &[f32; 2]| {
            let [low, high] = Blocks::interpolated(range);
            if range == Blocks::ABSENT { [0.0; 2] } else { bound(low, high) }
        };
        let (dims, size, bounds) = match blocks {
            Some(blocks) => (blocks.dims(), blocks.size() as f32, blocks.ranges().iter().map(of_block).collect()),
            None => ([1; 3], f32::INFINITY, vec![bound(f32::MIN, f32::MAX)]),
        };
        let leaps = Leaps::new(dims, |block| bounds[block][1] > 0.0);
        Self { size, bounds, leaps }
    }
}
