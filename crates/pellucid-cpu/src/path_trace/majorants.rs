//! Bounds of the extinction in blocks of the data, and the walk through them.

use glam::Vec3;
use pellucid_field::Blocks;
use pellucid_optics::Visibility;

use super::extinction::Extinctions;

/// The largest extinction in every block.
pub struct Majorants {
    dims: [usize; 3],
    /// Cells of the data along a side of a block.
    size: f32,
    /// Per world unit, x fastest.
    values: Vec<f32>,
}

impl Majorants {
    /// Those of blocks, or one that bounds everything if nothing is known of blocks.
    pub fn new(blocks: Option<&Blocks>, extinctions: &Extinctions, visibility: &Visibility) -> Self {
        let bound = |low, high| extinctions.of_opacity(visibility.max_opacity(low, high));
        let Some(blocks) = blocks else {
            return Self { dims: [1; 3], size: f32::INFINITY, values: vec![bound(f32::MIN, f32::MAX)] };
        };
        let of_block = |&range: &[f32; 2]| {
            let [low, high] = Blocks::interpolated(range);
            if range == Blocks::ABSENT { 0.0 } else { bound(low, high) }
        };
        Self { dims: blocks.dims(), size: blocks.size() as f32, values: blocks.ranges().iter().map(of_block).collect() }
    }

    /// The blocks that a flight of `length` passes, from its origin on.
    #[inline]
    pub fn walk(&self, origin: Vec3, direction: Vec3, length: f32) -> Walk<'_> {
        let inverse = direction.recip();
        let block = [0, 1, 2].map(|axis| {
            let block = (origin[axis] / self.size).max(0.0) as i32;
            block.min(self.dims[axis] as i32 - 1)
        });
        let mut walk = Walk { majorants: self, origin, inverse, block, exits: [0.0; 3], length };
        walk.exits = [0, 1, 2].map(|axis| walk.exit(axis));
        walk
    }
}

/// A walk from block to block (Amanatides and Woo 1987).
pub struct Walk<'a> {
    majorants: &'a Majorants,
    origin: Vec3,
    inverse: Vec3,
    block: [i32; 3],
    /// Where the flight leaves the block along each axis; infinite if it stays in the last one.
    exits: [f32; 3],
    length: f32,
}

impl Walk<'_> {
    /// From the block's number, not step by step: no error adds up.
    #[inline(always)]
    fn exit(&self, axis: usize) -> f32 {
        let forward = self.inverse[axis] > 0.0;
        let last = if forward { self.majorants.dims[axis] as i32 - 1 } else { 0 };
        if self.block[axis] == last {
            return f32::INFINITY;
        }
        let side = (self.block[axis] + i32::from(forward)) as f32 * self.majorants.size;
        let exit = (side - self.origin[axis]) * self.inverse[axis];
        // Along the side itself 0 * inf is NaN: the flight stays in the block.
        if exit.is_nan() { f32::INFINITY } else { exit }
    }

    /// The majorant of the block that the flight is in, and where it leaves it.
    #[inline(always)]
    pub fn block(&self) -> (f32, f32) {
        let [x, y, z] = self.block.map(|b| b as usize);
        let [nx, ny, _] = self.majorants.dims;
        let exit = self.exits[0].min(self.exits[1]).min(self.exits[2]).min(self.length);
        (self.majorants.values[x + nx * (y + ny * z)], exit)
    }

    /// Goes on to the next block; false if the flight ends in this one.
    #[inline(always)]
    pub fn advance(&mut self) -> bool {
        let [x, y, z] = self.exits;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        if self.exits[axis] >= self.length {
            return false;
        }
        self.block[axis] += if self.inverse[axis] > 0.0 { 1 } else { -1 };
        self.exits[axis] = self.exit(axis);
        true
    }
}
