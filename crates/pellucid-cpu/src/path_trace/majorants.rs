//! Bounds of the extinction in blocks of the data, and the walk through them.

use glam::Vec3;
use pellucid_field::{Blocks, distances};
use pellucid_optics::Visibility;

use super::extinction::Extinctions;

/// The largest extinction in every block.
pub struct Majorants {
    dims: [usize; 3],
    /// Cells of the data along a side of a block.
    size: f32,
    /// Per world unit, x fastest.
    values: Vec<f32>,
    /// How many blocks away the next one is where there is extinction; 0 if there is some in the block.
    distances: Vec<u8>,
}

impl Majorants {
    /// Those of blocks, or one that bounds everything if nothing is known of blocks; `factor` is the most by
    /// which the extinction of a value varies.
    pub fn new(blocks: Option<&Blocks>, extinctions: &Extinctions, visibility: &Visibility, factor: f32) -> Self {
        let bound = |low, high| extinctions.of_opacity(visibility.max_opacity(low, high)) * factor;
        let Some(blocks) = blocks else {
            let values = vec![bound(f32::MIN, f32::MAX)];
            return Self { dims: [1; 3], size: f32::INFINITY, values, distances: vec![0] };
        };
        let of_block = |&range: &[f32; 2]| {
            let [low, high] = Blocks::interpolated(range);
            if range == Blocks::ABSENT { 0.0 } else { bound(low, high) }
        };
        let values: Vec<f32> = blocks.ranges().iter().map(of_block).collect();
        let distances = distances(blocks.dims(), |block| values[block] > 0.0);
        Self { dims: blocks.dims(), size: blocks.size() as f32, values, distances }
    }

    /// The blocks that a flight of `length` passes, from its origin on.
    #[inline]
    pub fn walk(&self, origin: Vec3, direction: Vec3, length: f32) -> Walk<'_> {
        let inverse = direction.recip();
        let block = [0, 1, 2].map(|axis| {
            let block = (origin[axis] / self.size).max(0.0) as i32;
            block.min(self.dims[axis] as i32 - 1)
        });
        let mut walk = Walk { majorants: self, origin, direction, inverse, block, exits: [0.0; 3], length };
        walk.exits = [0, 1, 2].map(|axis| walk.exit(axis, 0));
        walk
    }
}

/// A walk from block to block (Amanatides and Woo 1987).
pub struct Walk<'a> {
    majorants: &'a Majorants,
    origin: Vec3,
    direction: Vec3,
    inverse: Vec3,
    block: [i32; 3],
    /// Where the flight leaves the block along each axis; infinite if it stays in the last one.
    exits: [f32; 3],
    length: f32,
}

impl Walk<'_> {
    /// Where the flight leaves the blocks up to so many beyond its own along an axis. From their number,
    /// not step by step: no error adds up.
    #[inline(always)]
    fn exit(&self, axis: usize, beyond: i32) -> f32 {
        let forward = self.inverse[axis] > 0.0;
        let room = if forward { self.majorants.dims[axis] as i32 - 1 - self.block[axis] } else { self.block[axis] };
        if beyond >= room {
            return f32::INFINITY;
        }
        let side = self.block[axis] + if forward { beyond + 1 } else { -beyond };
        let exit = (side as f32 * self.majorants.size - self.origin[axis]) * self.inverse[axis];
        // Along the side itself 0 * inf is NaN: the flight stays in the block.
        if exit.is_nan() { f32::INFINITY } else { exit }
    }

    #[inline(always)]
    fn number(&self) -> usize {
        let [x, y, z] = self.block.map(|b| b as usize);
        let [nx, ny, _] = self.majorants.dims;
        x + nx * (y + ny * z)
    }

    /// The majorant of the block that the flight is in, and where it leaves it.
    #[inline(always)]
    pub fn block(&self) -> (f32, f32) {
        let exit = self.exits[0].min(self.exits[1]).min(self.exits[2]).min(self.length);
        (self.majorants.values[self.number()], exit)
    }

    /// Goes on to the next block, or over all those that are known to be empty, and tells where the flight
    /// enters; `None` if it ends before.
    #[inline(always)]
    pub fn advance(&mut self) -> Option<f32> {
        let beyond = i32::from(self.majorants.distances[self.number()]) - 1;
        if beyond > 0 {
            return self.leap(beyond);
        }
        let axis = first(self.exits);
        let exit = self.exits[axis];
        if exit >= self.length {
            return None;
        }
        self.block[axis] += self.step(axis);
        self.exits[axis] = self.exit(axis, 0);
        Some(exit)
    }

    /// Leaves the cube of blocks up to so many beyond its own.
    fn leap(&mut self, beyond: i32) -> Option<f32> {
        let exits = [0, 1, 2].map(|axis| self.exit(axis, beyond));
        let axis = first(exits);
        let exit = exits[axis];
        if exit >= self.length {
            return None;
        }
        let left = self.block[axis] + self.step(axis) * (beyond + 1);
        let at = (self.origin + self.direction * exit) / self.majorants.size;
        self.block = [0, 1, 2].map(|other| {
            // Rounding must not lead out of the cube, nor out of the grid.
            let [low, high] = [self.block[other] - beyond, self.block[other] + beyond];
            (at[other].floor() as i32).clamp(low, high).clamp(0, self.majorants.dims[other] as i32 - 1)
        });
        self.block[axis] = left;
        self.exits = [0, 1, 2].map(|axis| self.exit(axis, 0));
        Some(exit)
    }

    #[inline(always)]
    fn step(&self, axis: usize) -> i32 {
        if self.inverse[axis] > 0.0 { 1 } else { -1 }
    }
}

/// The axis with the nearest exit.
#[inline(always)]
fn first([x, y, z]: [f32; 3]) -> usize {
    if x <= y && x <= z {
        0
    } else if y <= z {
        1
    } else {
        2
    }
}
