//! What rays leap over that look for surfaces of any isovalue.

use std::sync::{Arc, OnceLock};

use pellucid_field::Blocks;
use pellucid_plan::{BlockContent, LevelBlocks};

use crate::skip::SkipGrid;

/// Grids for intervals of isovalues, each made when a ray first asks for it.
pub struct LevelGrids {
    levels: LevelBlocks,
    each: Vec<OnceLock<Option<SkipGrid>>>,
}

impl LevelGrids {
    /// Of the ranges of values in blocks.
    pub fn new(blocks: Arc<Blocks>) -> Self {
        let levels = LevelBlocks::new(blocks);
        let each = (0..levels.count()).map(|_| OnceLock::new()).collect();
        Self { levels, each }
    }

    /// Whether they are of these blocks.
    pub fn are_of(&self, blocks: &Arc<Blocks>) -> bool {
        self.levels.are_of(blocks)
    }

    /// What is leapt over on the way to surfaces of an isovalue.
    pub fn at(&self, level: f32) -> Option<&SkipGrid> {
        let interval = self.levels.interval(level);
        let made = || {
            let blocks = self.levels.map(interval);
            match &blocks.content {
                BlockContent::Distances(distances) => Some(SkipGrid::new(&blocks, distances)),
                BlockContent::Extremes(_) => None,
            }
        };
        self.each[interval].get_or_init(made).as_ref()
    }
}
