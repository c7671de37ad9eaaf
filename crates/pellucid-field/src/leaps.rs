//! How far a straight way may go on from every block before it can meet one that can contribute.

use rayon::prelude::*;

use crate::parallel;

/// For every block and each of the eight octants of directions, how many blocks a side a cube has that begins at
/// this block, extends in the octant's direction and has nothing live in it (7.3-6). A way out of what is live has
/// long leaps from its first block on, where a distance to all sides ([`distances`](crate::distances)) still sees
/// what lies behind.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaps {
    dims: [usize; 3],
    sides: [Vec<u8>; 8],
}

impl Leaps {
    /// Those among `dims` blocks, x fastest, of which some are live. Nothing is live outside.
    pub fn new(dims: [usize; 3], live: impl Fn(usize) -> bool + Sync) -> Self {
        let mut sides = [const { Vec::new() }; 8];
        let fill = |(octant, sides): (usize, &mut Vec<u8>)| *sides = of_octant(dims, octant, &live);
        parallel(|| sides.par_iter_mut().enumerate().for_each(fill));
        Self { dims, sides }
    }

    /// Blocks per axis.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The sides of the cubes, at most 255 blocks and 0 where the block itself is live, for directions that go down
    /// the axes whose bits are set in `octant` (x is bit 0) and up the others, or across them.
    ///
    /// # Panics
    /// If there is no such octant.
    #[inline(always)]
    pub fn octant(&self, octant: usize) -> &[u8] {
        &self.sides[octant]
    }

    /// The Chebyshev distance of a block to the nearest one that is live, as in [`distances`](crate::distances).
    ///
    /// # Panics
    /// If there is no such block.
    pub fn distance(&self, block: usize) -> u8 {
        self.sides.iter().fold(u8::MAX, |nearest, sides| nearest.min(sides[block]))
    }
}

/// A cube is one larger than the smallest of the seven that begin at its block's neighbours, in the octant's
/// direction.
fn of_octant([nx, ny, nz]: [usize; 3], octant: usize, live: impl Fn(usize) -> bool) -> Vec<u8> {
    // In coordinates in which the octant's direction goes up, with a border behind the last blocks.
    let stride = [nx + 1, (nx + 1) * (ny + 1)];
    let mut padded = vec![u8::MAX; stride[1] * (nz + 1)];
    let mut sides = vec![0; nx * ny * nz];
    let own = |axis: usize, n: usize, i: usize| if octant >> axis & 1 == 1 { n - 1 - i } else { i };
    let neighbours =
        [stride[0], stride[0] + 1, stride[1], stride[1] + 1, stride[1] + stride[0], stride[1] + stride[0] + 1];
    for (z, y) in (0..nz).rev().flat_map(|z| (0..ny).rev().map(move |y| (z, y))) {
        let (row, start) = (nx * (own(1, ny, y) + ny * own(2, nz, z)), stride[0] * y + stride[1] * z);
        let mut next = u8::MAX;
        for x in (0..nx).rev() {
            let (block, at) = (row + own(0, nx, x), start + x);
            let least = neighbours.iter().fold(next, |least, offset| least.min(padded[at + offset]));
            next = if live(block) { 0 } else { least.saturating_add(1) };
            (padded[at], sides[block]) = (next, next);
        }
    }
    sides
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::distances;

    proptest! {
        #[test]
        fn cubes_are_the_largest_that_are_empty(
            dims in [1usize..8, 1usize..8, 1usize..8],
            seed in 0u64..1000,
            rarity in 1u64..60,
        ) {
            let [nx, ny, nz] = dims;
            let hash = |block: usize| (block as u64 + 7).wrapping_mul(0x9E37_79B9_7F4A_7C15 ^ seed) >> 40;
            let live: Vec<bool> = (0..nx * ny * nz).map(|block| hash(block) % rarity == 0).collect();
            let leaps = Leaps::new(dims, |block| live[block]);
            let position = |b: usize| [b % nx, b / nx % ny, b / (nx * ny)];
            for block in 0..live.len() {
                let from = position(block);
                for octant in 0..8 {
                    // The nearest live block in the octant, by the furthest axis.
                    let ahead = |other: usize| {
                        let to = position(other);
                        (0..3).try_fold(0, |most: usize, axis| {
                            let [low, high] = if octant >> axis & 1 == 1 { [to, from] } else { [from, to] };
                            Some(most.max(high[axis].checked_sub(low[axis])?))
                        })
                    };
                    let exact = (0..live.len()).filter(|&other| live[other]).filter_map(ahead).min().unwrap_or(255);
                    prop_assert_eq!(usize::from(leaps.octant(octant)[block]), exact, "{:?}, octant {}", from, octant);
                }
            }
            let nearest = distances(dims, |block| live[block]);
            prop_assert!((0..live.len()).all(|block| leaps.distance(block) == nearest[block]));
        }
    }
}
