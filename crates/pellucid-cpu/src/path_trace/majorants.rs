//! The walk through blocks of the data.

use glam::{Vec3, Vec3A};
use pellucid_field::Leaps;

use super::space::Flight;

/// A walk from block to block (Amanatides and Woo 1987), along all axes at once. Positions are in blocks, ways along
/// the flight in world units.
pub struct Walk<'a> {
    /// Of the octant that the flight goes to.
    leaps: &'a [u8],
    dims: [usize; 3],
    origin: Vec3A,
    direction: Vec3A,
    inverse: Vec3A,
    /// 1 along axes that the flight goes up or stays at, -1 along others.
    sign: Vec3A,
    /// From the origin to the side of block 0 at which the flight leaves it; infinite where it never does.
    side: Vec3A,
    last: Vec3A,
    /// In whole numbers, and the number it has.
    block: Vec3A,
    number: usize,
    length: f32,
}

impl<'a> Walk<'a> {
    /// The blocks, of so many cells a side, that a flight passes from its origin on.
    #[inline(always)]
    pub fn new(leaps: &'a Leaps, size: f32, flight: &Flight) -> Self {
        let blocks = |v: Vec3| Vec3A::from(v) * size.recip();
        let (origin, direction) = (blocks(flight.origin), blocks(flight.direction));
        let (is_down, is_still) = (direction.cmplt(Vec3A::ZERO), direction.cmpeq(Vec3A::ZERO));
        let side = Vec3A::select(is_down, Vec3A::ZERO, Vec3A::ONE) - origin;
        let dims = leaps.dims();
        let last = Vec3A::new((dims[0] - 1) as f32, (dims[1] - 1) as f32, (dims[2] - 1) as f32);
        let mut walk = Self {
            leaps: leaps.octant(is_down.bitmask() as usize),
            dims,
            origin,
            direction,
            // Of either zero: times an infinite way it is one.
            inverse: Vec3A::select(is_still, Vec3A::INFINITY, direction.recip()),
            sign: Vec3A::select(is_down, Vec3A::NEG_ONE, Vec3A::ONE),
            side: Vec3A::select(is_still, Vec3A::INFINITY, side),
            last,
            block: origin.max(Vec3A::ZERO).trunc().min(last),
            number: 0,
            length: flight.length,
        };
        walk.number = walk.number();
        walk
    }

    #[inline(always)]
    fn number(&self) -> usize {
        let [x, y, z] = self.block.to_array();
        let [nx, ny, _] = self.dims;
        // By way of i32: processors convert to signed numbers in one instruction.
        x as i32 as usize + nx * (y as i32 as usize + ny * z as i32 as usize)
    }

    /// Where the flight leaves the blocks up to so many beyond its own, along each axis. From their number, not step
    /// by step: no error adds up.
    #[inline(always)]
    fn exits(&self, beyond: f32) -> Vec3A {
        (self.block + self.sign * beyond + self.side) * self.inverse
    }

    /// The number of the block that the flight is in.
    #[inline(always)]
    pub fn block(&self) -> usize {
        self.number
    }

    /// Whether that block is live.
    #[inline(always)]
    pub fn is_live(&self) -> bool {
        self.leaps[self.number] == 0
    }

    /// Where the flight leaves it, or ends in it.
    #[inline(always)]
    pub fn exit(&self) -> f32 {
        self.exits(0.0).min_element().min(self.length)
    }

    /// Goes on to the next block, or over all those ahead that are known not to be live, and tells where the flight
    /// enters; `None` if it ends before.
    #[inline(always)]
    pub fn advance(&mut self) -> Option<f32> {
        let beyond = f32::from(self.leaps[self.number].max(1) - 1);
        let exits = self.exits(beyond);
        let exit = exits.min_element();
        // What is no number ends the flight as well.
        if exit.is_nan() || exit >= self.length {
            return None;
        }
        // Rounding must not lead out of the cube of these blocks, nor back, nor out of the grid.
        let furthest = self.block + self.sign * beyond;
        let at = (self.origin + self.direction * exit).trunc();
        let at = at.clamp(self.block.min(furthest), self.block.max(furthest)).min(self.last);
        self.block = Vec3A::select(exits.cmple(Vec3A::splat(exit)), furthest + self.sign, at);
        if self.block.clamp(Vec3A::ZERO, self.last) != self.block {
            return None;
        }
        self.number = self.number();
        Some(exit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path_trace::random::Random;

    /// The live blocks of a walk with where the flight enters and leaves them.
    fn met(leaps: &Leaps, size: f32, flight: &Flight) -> Vec<(usize, [f32; 2])> {
        let mut walk = Walk::new(leaps, size, flight);
        let (mut entry, mut met) = (0.0, Vec::new());
        loop {
            if walk.is_live() {
                met.push((walk.block(), [entry, walk.exit()]));
            }
            let Some(next) = walk.advance() else { return met };
            entry = next;
        }
    }

    #[test]
    fn walks_meet_every_live_block_where_it_is() {
        const DIMS: [usize; 3] = [7, 5, 6];
        const SIZE: f32 = 4.0;
        let mut random = Random::new([1, 2], 3, 4);
        let mut checked = [0; 2];
        for number in 0..3000 {
            // Some grids are nearly empty, some full.
            let share = [0.01, 0.1, 0.3, 1.0][number % 4];
            let live: Vec<bool> = (0..DIMS.iter().product()).map(|_| random.number() < share).collect();
            let leaps = Leaps::new(DIMS, |block| live[block]);
            let high = Vec3::new(DIMS[0] as f32, DIMS[1] as f32, DIMS[2] as f32) * SIZE;
            let mut vector = || Vec3::new(random.number(), random.number(), random.number());
            let (mut origin, mut direction) = (vector() * high, vector() * 2.0 - 1.0);
            // Along axes and planes, and from the sides of blocks and of the grid.
            match number % 7 {
                0 => direction.x = 0.0,
                1 => (direction.y, direction.z) = (-0.0, 0.0),
                2 => origin = (origin / SIZE).round() * SIZE,
                3 => (origin.x, direction.x) = (if direction.x > 0.0 { 0.0 } else { high.x }, -direction.x),
                _ => {}
            }
            let sides = Vec3::select(direction.cmpgt(Vec3::ZERO), high, Vec3::ZERO);
            let exits = Vec3::select(direction.cmpeq(Vec3::ZERO), Vec3::INFINITY, (sides - origin) / direction);
            let length = exits.min_element();
            let met = met(&leaps, SIZE, &Flight { origin, direction, length });
            for k in 0..100 {
                let way = length * (k as f32 + 0.5) / 100.0;
                let at = (origin + direction * way) / SIZE;
                // Which of two blocks is met on their common side is for roundings to say.
                if (at - at.round()).abs().min_element() < 1e-4 {
                    continue;
                }
                let block = at.x as usize + DIMS[0] * (at.y as usize + DIMS[1] * at.z as usize);
                let is_met = met.iter().any(|(own, [from, to])| *own == block && (*from..=*to).contains(&way));
                assert_eq!(is_met, live[block], "flight {number}: {origin} along {direction}, at {at}");
                checked[usize::from(is_met)] += 1;
            }
        }
        assert!(checked.iter().all(|count| *count > 20_000), "{checked:?}");
    }

    #[test]
    fn one_block_without_an_end_is_met_whole() {
        let leaps = Leaps::new([1; 3], |_| true);
        let flight = Flight { origin: Vec3::splat(3.0), direction: Vec3::new(0.5, -1.0, 0.0), length: 7.0 };
        assert_eq!(met(&leaps, f32::INFINITY, &flight), [(0, [0.0, 7.0])]);
        // What is no number ends at once.
        let lost = Flight { direction: Vec3::NAN, ..flight };
        assert_eq!(met(&leaps, 4.0, &lost).len(), 1);
    }
}
