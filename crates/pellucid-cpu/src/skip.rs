//! Empty-space skipping over min-max blocks (7.3-6).
//!
//! Leaps go from lattice sample to lattice sample and only over samples that add exactly nothing,
//! so the picture is the same to the bit with skipping on and off.

use pellucid_plan::BlockMap;

use crate::cells::Cells;
use crate::lanes::*;
use crate::packet::Rays;

/// Where the blocks of a volume are.
#[derive(Clone, Copy)]
struct Layout {
    dims: [usize; 3],
    size: f32,
    /// The last position along each axis that lies in a block.
    last: [f32; 3],
}

/// Blocks as lanes meet them.
struct Met<S: Lanes> {
    /// Block coordinates.
    block: [I32<S>; 3],
    /// Number of the block.
    number: I32<S>,
}

impl Layout {
    fn new(blocks: &BlockMap) -> Self {
        let (dims, size) = (blocks.dims, blocks.size);
        debug_assert!(size.is_power_of_two(), "or products with its inverse are rounded");
        Self { dims, size: size as f32, last: dims.map(|n| ((n * size) as f32).next_down()) }
    }

    /// The block that holds the cell of a position.
    #[inline(always)]
    fn meet<S: Lanes>(&self, s: S, p: &Vec3<S>) -> Met<S> {
        let block = xyz!(I => {
            let inside = within(s, p[I], self.last[I]);
            // Whole cells, so that the block is the one of the voxels that are read.
            (inside.trunc() * (1.0 / self.size)).to_int::<I32<S>>()
        });
        let [nx, ny] = [self.dims[0] as i32, self.dims[1] as i32];
        let number = block[0] + (block[1] + block[2] * ny) * nx;
        Met { block, number }
    }

    /// Steps from a position to the surface of the cube around its block that reaches `reach`
    /// blocks to every side, its own included: a little short of it, so that rounding never
    /// leaps over a sample beyond.
    #[inline(always)]
    fn leave<S: Lanes>(&self, s: S, p: &Vec3<S>, met: &Met<S>, reach: F32<S>, inverse: &Vec3<S>) -> F32<S> {
        const MARGIN: f32 = 2e-3;
        let size = splat(s, self.size);
        let mut nearest = splat(s, f32::INFINITY);
        for axis in 0..3 {
            let block = met.block[axis].to_float::<F32<S>>();
            let high = (block + reach).mul_add(size, splat(s, -MARGIN));
            let low = (block - reach + 1.0).mul_add(size, splat(s, MARGIN));
            let border = inverse[axis].simd_gt(splat(s, 0.0)).select(high, low);
            nearest = nearest.min((border - p[axis]) * inverse[axis]);
        }
        nearest
    }
}

/// The blocks of a volume, and how far each is from one that can contribute.
pub struct SkipGrid {
    layout: Layout,
    /// With room to read a word at the last one.
    distance: Vec<u8>,
}

/// The level of the stride that every block allows.
pub struct Levels {
    layout: Layout,
    /// With room to read a word at the last one.
    levels: Vec<u8>,
}

impl Levels {
    /// The levels of blocks, if they are not all 0.
    pub fn new(blocks: &BlockMap) -> Option<Self> {
        let levels = blocks.levels.as_deref()?;
        Some(Self { layout: Layout::new(blocks), levels: with_room(levels) })
    }

    /// The levels of the blocks at index positions.
    #[inline(always)]
    pub fn at<S: Lanes>(&self, s: S, p: &Vec3<S>) -> I32<S> {
        let met = self.layout.meet(s, p);
        // SAFETY: `meet` limits positions to the grid, every cell of which has its block; three
        // more bytes follow the last.
        let words: I32<S> = unsafe { s.gather::<1>(self.levels.as_ptr(), met.number) }.bitcast();
        words & 0xff
    }
}

impl SkipGrid {
    /// Blocks that are so many blocks away from one that can contribute.
    pub fn new(blocks: &BlockMap, distances: &[u8]) -> Self {
        Self { layout: Layout::new(blocks), distance: with_room(distances) }
    }

    /// How many samples from the one at a position on, itself included, certainly add nothing, where
    /// neighbours are `1 / inverse` apart; 0 where that one may.
    #[inline(always)]
    pub fn clear<S: Lanes>(&self, s: S, p: &Vec3<S>, inverse: &Vec3<S>) -> F32<S> {
        let met = self.layout.meet(s, p);
        let reach = self.distance(s, &met);
        let steps = self.layout.leave(s, p, &met, reach, inverse).ceil().max(splat(s, 1.0));
        reach.simd_gt(splat(s, 0.0)).select(steps, splat(s, 0.0))
    }

    #[inline(always)]
    fn distance<S: Lanes>(&self, s: S, met: &Met<S>) -> F32<S> {
        // SAFETY: `meet` limits positions to the grid, every cell of which has its block; three
        // more bytes follow the last.
        let words = unsafe { s.gather::<1>(self.distance.as_ptr(), met.number) };
        let words: I32<S> = words.bitcast();
        (words & 0xff).to_float()
    }

    /// How many steps lead from a position to where something may be, or a little less; 0 where something may be
    /// here.
    #[inline(always)]
    pub fn way<S: Lanes>(&self, s: S, p: &Vec3<S>, inverse: &Vec3<S>) -> F32<S> {
        let met = self.layout.meet(s, p);
        let (reach, zero) = (self.distance(s, &met), splat(s, 0.0));
        reach.simd_gt(zero).select(self.layout.leave(s, p, &met, reach, inverse).max(zero), zero)
    }

    /// Goes on to the first cells, in open lanes, that may contribute, from the face by which one is entered, which is not
    /// looked at if the cell is left. Returns the lanes that have leapt, and how far, in steps.
    #[inline(always)]
    pub fn leap_cells<S: Lanes>(&self, s: S, rays: &Rays<S>, cells: &mut Cells<S>, open: Mask<S>) -> (Mask<S>, F32<S>) {
        let (begin, mut leapt) = (cells.ends[0], all(s, false));
        loop {
            let from = cells.ends[0];
            let to = from + self.way(s, &rays.at(from), &rays.inverse);
            let leaps = open & cells.are_there() & to.simd_gt(cells.ends[1]);
            cells.leap(s, to, leaps);
            // Rounding may leave a ray where it is.
            let moved = leaps & cells.ends[0].simd_gt(from);
            if !moved.any_true() {
                return (leapt, cells.ends[0].min(rays.length()).max(begin) - begin);
            }
            leapt |= moved;
        }
    }

    /// The first sample or node from number k on, in every open lane, that may contribute, or one
    /// beyond the last.
    #[inline(always)]
    pub fn leap<S: Lanes>(&self, s: S, rays: &Rays<S>, mut k: F32<S>, open: Mask<S>, over: Leap) -> F32<S> {
        loop {
            let (lanes, distance) = match over {
                Leap::Samples => (open & rays.has(k), rays.sample(s, k)),
                Leap::Segments => (open & rays.has_node(k), rays.node(s, k)),
            };
            let p = rays.at(distance);
            let met = self.layout.meet(s, &p);
            let reach = self.distance(s, &met);
            let empty = lanes & reach.simd_gt(splat(s, 0.0));
            if !empty.any_true() {
                return k;
            }
            let steps = self.layout.leave(s, &p, &met, reach, &rays.inverse).ceil();
            let far = match over {
                Leap::Samples => steps.max(splat(s, 1.0)),
                // To the last node inside the cube.
                Leap::Segments => (steps - 1.0).max(splat(s, 0.0)),
            };
            let empty = empty & far.simd_gt(splat(s, 0.0));
            if !empty.any_true() {
                return k;
            }
            k = empty.select(k + far, k);
        }
    }
}

/// Bytes, with room to read a word at the last one.
fn with_room(bytes: &[u8]) -> Vec<u8> {
    [bytes, &[0; 3]].concat()
}

/// What is leapt over.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Leap {
    /// Samples in empty blocks.
    Samples,
    /// Segments whose both ends lie in empty blocks.
    Segments,
}

/// The largest or the smallest values of blocks and of cubes around them, for projections of
/// extremes.
pub struct ExtremeGrid {
    layout: Layout,
    /// Extremes of the cubes that reach [`REACHES`] blocks to every side.
    extremes: Vec<[f32; 4]>,
}

/// How far the cubes of [`ExtremeGrid`] reach, the block itself included.
const REACHES: [f32; 4] = [1.0, 2.0, 3.0, 5.0];

impl ExtremeGrid {
    /// Of the largest values of blocks, or the smallest with their signs turned.
    pub fn new(blocks: &BlockMap, one: &[f32]) -> Self {
        let two = spread(blocks.dims, one);
        let three = spread(blocks.dims, &two);
        let five = spread(blocks.dims, &spread(blocks.dims, &three));
        let extremes = (0..one.len()).map(|b| [one[b], two[b], three[b], five[b]]).collect();
        Self { layout: Layout::new(blocks), extremes }
    }

    /// Goes on to the first cells, in every lane, that may exceed `best`.
    #[inline(always)]
    pub fn leap<S: Lanes>(&self, s: S, rays: &Rays<S>, cells: &mut Cells<S>, best: F32<S>) {
        loop {
            let middle = cells.middle();
            let p = rays.at(middle);
            let met = self.layout.meet(s, &p);
            // SAFETY: `meet` limits positions to the grid, every cell of which has its block.
            let extremes = unsafe { s.gather_rows::<2>(self.extremes.as_ptr().cast(), met.number) };
            let dull = cells.are_there() & extremes[0].simd_le(best);
            if !dull.any_true() {
                return;
            }
            let mut reach = splat(s, 1.0);
            for further in 1..REACHES.len() {
                reach = extremes[further].simd_le(best).select(splat(s, REACHES[further]), reach);
            }
            let steps = self.layout.leave(s, &p, &met, reach, &rays.inverse);
            // To the last cell inside, and over it.
            cells.leap(s, middle + steps.max(splat(s, 0.0)), dull);
            cells.advance(s, dull);
        }
    }
}

/// The largest of every block and its neighbours, corner to corner.
fn spread(dims: [usize; 3], values: &[f32]) -> Vec<f32> {
    let mut values = values.to_vec();
    let mut stride = 1;
    for n in dims {
        let old = values.clone();
        for (i, value) in values.iter_mut().enumerate() {
            let along = i / stride % n;
            if along > 0 {
                *value = value.max(old[i - stride]);
            }
            if along + 1 < n {
                *value = value.max(old[i + stride]);
            }
        }
        stride *= n;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_the_largest_of_all_neighbours() {
        let dims = [4usize, 3, 5];
        let values: Vec<f32> = (0..60).map(|i| (i * 37 % 61) as f32).collect();
        let found = spread(dims, &values);
        let at = |i: usize| [i % 4, i / 4 % 3, i / 12];
        for (i, &largest) in found.iter().enumerate() {
            let near = |&j: &usize| (0..3).all(|axis| at(i)[axis].abs_diff(at(j)[axis]) <= 1);
            let expected = (0..60).filter(near).map(|j| values[j]).fold(f32::NEG_INFINITY, f32::max);
            assert_eq!(largest, expected, "block {i}");
        }
    }
}
