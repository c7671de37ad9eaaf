//! Empty-space skipping over min-max blocks (7.3-6).
//!
//! Leaps go from lattice sample to lattice sample and only over samples that add exactly nothing,
//! so the picture is the same to the bit with skipping on and off.

use glam::DVec3;
use pellucid_field::Blocks;

use crate::lattice::Lattice;
use crate::span::Span;

/// The blocks of a volume as a ray sees them.
pub struct BlockMap<'a> {
    ranges: &'a [[f32; 2]],
    size: f64,
    dims: [usize; 3],
}

impl<'a> BlockMap<'a> {
    /// A map over min-max blocks.
    pub fn new(blocks: &'a Blocks) -> Self {
        Self { ranges: blocks.ranges(), size: blocks.size() as f64, dims: blocks.dims() }
    }

    /// Value range of a block; `None` if it is wholly absent.
    #[inline(always)]
    pub fn range(&self, block: usize) -> Option<[f32; 2]> {
        Some(self.ranges[block]).filter(|range| *range != Blocks::ABSENT)
    }

    /// The block of lattice sample k, and the first sample after k that may lie in another.
    #[inline(always)]
    pub fn run(&self, span: &Span, lattice: &Lattice, k: usize) -> (usize, usize) {
        let (block, until) = self.stay(span, lattice.sample(k));
        (block, lattice.first_at(until).max(k + 1))
    }

    /// The block at distance t, and the distance up to which the ray surely stays in it.
    #[inline(always)]
    fn stay(&self, span: &Span, t: f64) -> (usize, f64) {
        let index = span.index_at(t);
        let block: [usize; 3] =
            std::array::from_fn(|axis| ((index[axis].max(0.0) / self.size) as i64 as usize).min(self.dims[axis] - 1));
        let until = t + self.leave(index, block, span.index_direction());
        (block[0] + self.dims[0] * (block[1] + self.dims[1] * block[2]), until)
    }

    /// Distance from a position to the border of its block, a little short of it so that rounding
    /// never leaps over a sample of the next block.
    fn leave(&self, index: DVec3, block: [usize; 3], direction: DVec3) -> f64 {
        const MARGIN: f64 = 1e-6;
        let mut nearest = f64::INFINITY;
        for axis in 0..3 {
            let d = direction[axis];
            let last = block[axis] + 1 == self.dims[axis];
            let border = if d > 0.0 && !last {
                (block[axis] + 1) as f64 * self.size - MARGIN
            } else if d < 0.0 && block[axis] > 0 {
                block[axis] as f64 * self.size + MARGIN
            } else {
                continue;
            };
            nearest = nearest.min((border - index[axis]) / d);
        }
        nearest.max(0.0)
    }
}

/// The blocks of a volume, and which of them can contribute at all.
pub struct SkipGrid<'a> {
    map: BlockMap<'a>,
    live: Vec<bool>,
}

impl<'a> SkipGrid<'a> {
    /// Blocks whose value range satisfies `live` can contribute; wholly absent ones never do.
    pub fn new(blocks: &'a Blocks, live: impl Fn(f32, f32) -> bool) -> Self {
        let map = BlockMap::new(blocks);
        let flag = |block| map.range(block).is_some_and(|[low, high]| live(low, high));
        let live = (0..map.ranges.len()).map(flag).collect();
        Self { map, live }
    }

    /// Whether sample k may contribute, and the first sample after it that may lie in another block.
    #[inline(always)]
    pub fn run(&self, span: &Span, lattice: &Lattice, k: usize) -> (bool, usize) {
        let (block, next) = self.map.run(span, lattice, k);
        (self.live[block], next)
    }

    /// Whether segment n between nodes may contribute, and the first segment after it that may
    /// differ. A segment that crosses from block to block always may contribute.
    #[inline(always)]
    pub fn run_of_segments(&self, span: &Span, lattice: &Lattice, n: usize) -> (bool, usize) {
        let (block, until) = self.map.stay(span, lattice.node(n - 1, span.exit));
        // Sample s is node s + 1; nodes up to s lie inside the block, and so do segments up to s.
        let next = lattice.first_at(until) + 1;
        (self.live[block] || next <= n, next.max(n + 1))
    }
}
