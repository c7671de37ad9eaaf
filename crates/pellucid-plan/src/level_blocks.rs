//! Where isosurfaces of any isovalue may lie: blocks by intervals of isovalues, for rays whose isovalue is that of the place
//! where they start (G-03).

use std::sync::Arc;

use pellucid_field::Blocks;

use crate::blocks::BlockMap;

/// Intervals of isovalues, about as many blocks beginning or ending in each.
pub struct LevelBlocks {
    blocks: Arc<Blocks>,
    /// The ends of intervals, but for the last one.
    ends: Vec<f32>,
}

/// Most intervals: surfaces within one are looked for in the same blocks.
const MOST: usize = 64;

impl LevelBlocks {
    /// Intervals of the values of blocks.
    pub fn new(blocks: Arc<Blocks>) -> Self {
        let there = blocks.ranges().iter().filter(|range| **range != Blocks::ABSENT);
        let mut values: Vec<f32> = there.flat_map(|range| Blocks::interpolated(*range)).collect();
        values.sort_by(f32::total_cmp);
        let mut ends: Vec<f32> = (1..MOST).filter_map(|k| values.get(k * values.len() / MOST)).copied().collect();
        ends.dedup();
        Self { blocks, ends }
    }

    /// Whether they are of these blocks.
    pub fn are_of(&self, blocks: &Arc<Blocks>) -> bool {
        Arc::ptr_eq(&self.blocks, blocks)
    }

    /// How many intervals there are.
    pub fn count(&self) -> usize {
        self.ends.len() + 1
    }

    /// The number of the interval of an isovalue.
    pub fn interval(&self, level: f32) -> usize {
        self.ends.partition_point(|end| *end < level)
    }

    /// How far blocks are from those in which a surface of an interval may lie.
    pub fn map(&self, interval: usize) -> BlockMap {
        let below = interval.checked_sub(1).and_then(|before| self.ends.get(before));
        let low = below.copied().unwrap_or(f32::NEG_INFINITY);
        let high = self.ends.get(interval).copied().unwrap_or(f32::INFINITY);
        BlockMap::where_any(&self.blocks, |least, most| least <= high && low <= most)
    }
}

#[cfg(test)]
mod tests {
    use pellucid_field::{Grid, Volume};

    use super::*;
    use crate::BlockContent;

    #[test]
    fn no_surface_lies_outside_the_blocks_of_its_interval() {
        let dims = [33, 17, 9];
        let count: usize = dims.iter().product();
        let voxels: Vec<f32> = (0..count).map(|k| ((k * 7919) % 1009) as f32 / 9.0 + (k / 600) as f32).collect();
        let grid = Grid::new(dims).unwrap();
        let volume = Volume::new(grid, voxels).unwrap();
        let blocks = Arc::new(Blocks::new(&volume, 0, Blocks::CELLS, 0).unwrap());
        let levels = LevelBlocks::new(blocks.clone());
        assert!(levels.count() > 8, "{}", levels.count());
        for k in 0..=150 {
            let level = k as f32;
            let BlockContent::Distances(distances) = levels.map(levels.interval(level)).content else { panic!() };
            for (range, distance) in blocks.ranges().iter().zip(distances) {
                assert!(distance == 0 || level < range[0] || level > range[1], "{level} in {range:?}");
            }
        }
    }
}
