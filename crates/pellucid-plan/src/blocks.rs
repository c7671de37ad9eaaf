//! What blocks of the data tell rays: where nothing can be seen (7.3-6), where nothing exceeds what was
//! found, and where longer steps will do (7.3-3).

use std::sync::Arc;

use pellucid_field::{Blocks, distances};

/// What rays ask of blocks, x fastest.
pub struct BlockMap {
    /// Blocks per axis.
    pub dims: [usize; 3],
    /// Cells per block and axis.
    pub size: usize,
    /// What is known of each.
    pub content: BlockContent,
    /// The level of the stride that each allows, `2^level` steps, if steps adapt to the data.
    pub levels: Option<Vec<u8>>,
}

impl BlockMap {
    /// Blocks by how far they are from those whose range of values satisfies `live`.
    pub(crate) fn where_any(blocks: &Blocks, live: impl Fn(f32, f32) -> bool) -> Self {
        let content = BlockContent::distances(blocks, live);
        Self { dims: blocks.dims(), size: blocks.size(), content, levels: None }
    }
}

/// What is known of blocks.
pub enum BlockContent {
    /// How many blocks away the next one is that can contribute; 0 if the block itself can.
    Distances(Vec<u8>),
    /// The largest value, or the smallest with its sign turned; negative infinity where there is none.
    Extremes(Arc<Vec<f32>>),
}

impl BlockContent {
    /// Blocks whose range of values satisfies `live` can contribute; wholly absent ones never do.
    pub(crate) fn distances(blocks: &Blocks, live: impl Fn(f32, f32) -> bool) -> Self {
        Self::Distances(distances(blocks.dims(), |block| {
            let range = blocks.ranges()[block];
            range != Blocks::ABSENT && {
                let [low, high] = Blocks::interpolated(range);
                live(low, high)
            }
        }))
    }

    /// The largest values, or the smallest with their signs turned.
    pub(crate) fn extremes(blocks: &Blocks, minimum: bool) -> Arc<Vec<f32>> {
        let extreme = |&range: &[f32; 2]| {
            let [low, high] = Blocks::interpolated(range);
            if minimum { -low } else { high }
        };
        Arc::new(blocks.ranges().iter().map(extreme).collect())
    }
}
