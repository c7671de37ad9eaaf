//! Rays of the eye and of lights, as they cross slabs.
//!
//! Both are followed in the order of the slabs, away from the light. What a ray passes of a slab is a
//! segment of its own length, cut where the ray enters and leaves the field, with one sample in it: so a
//! homogeneous medium has its exact transmittance at any thickness and angle.

use std::ops::Range;

use pellucid_field::Grid;
use pellucid_plan::half_angle::Slabs;

use crate::lanes::*;
use crate::packet::{Packet, PerLane, inverse};

/// Slabs that are looked at before it is asked again whether the next ones are empty.
pub const UNASKED: usize = 8;

/// Rays that cross the same slabs, side by side. Places along them are coordinates of slabs.
#[derive(Clone, Debug)]
pub struct Crossing {
    /// Continuous voxel index where the ray enters, in the order of slabs.
    origin: [PerLane; 3],
    /// Index-space direction, per slab.
    direction: [PerLane; 3],
    /// Where the ray enters and leaves.
    from: PerLane,
    to: PerLane,
    /// Length of the ray in a slab, in steps.
    stretch: PerLane,
    /// Where in a segment its sample lies.
    jitter: PerLane,
}

impl Crossing {
    /// No rays.
    pub const NOTHING: Self = Self {
        origin: [[0.0; MOST_LANES]; 3],
        direction: [[0.0; MOST_LANES]; 3],
        from: [0.0; MOST_LANES],
        to: [0.0; MOST_LANES],
        stretch: [1.0; MOST_LANES],
        jitter: [0.5; MOST_LANES],
    };

    /// Takes up the rays of a packet, `step` world units to a step. Returns 1 for those that travel against the
    /// order of slabs, else 0.
    pub fn take<S: Lanes>(&mut self, s: S, packet: &Packet, slabs: &Slabs, grid: &Grid, step: f64) -> PerLane {
        // A ray that lies in a slab crosses it very slowly.
        const SLOWEST: f64 = 1e-6;
        let world = grid.world_from_index();
        // The coordinate of slabs, by index position.
        let slope = world.matrix3.transpose() * slabs.axis / slabs.thickness;
        let (start, slowest) = (slabs.coordinate(world.translation), SLOWEST * step / slabs.thickness);
        s.vectorize(
            #[inline(always)]
            || {
                self.jitter = packet.jitter;
                let mut backward = [0.0; MOST_LANES];
                // One plain loop over plain arrays, of which the compiler makes vectors.
                for lane in 0..MOST_LANES {
                    let origin = xyz!(I => f64::from(packet.origin[I][lane]));
                    let direction = xyz!(I => f64::from(packet.direction[I][lane]));
                    let steps = f64::from(packet.count[lane] - 1.0) + f64::from(packet.last_ratio[lane]);
                    let steps = if packet.count[lane] > 0.0 { steps } else { 0.0 };
                    let advance = slope.x * direction[0] + slope.y * direction[1] + slope.z * direction[2];
                    let is_backward = advance < 0.0;
                    let speed = if advance.abs() > slowest { advance.abs() } else { slowest };
                    let first = if is_backward { steps } else { 0.0 };
                    let along = if is_backward { -1.0 / speed } else { 1.0 / speed };
                    let entry = xyz!(I => origin[I] + direction[I] * first);
                    let from = start + slope.x * entry[0] + slope.y * entry[1] + slope.z * entry[2];
                    let to = from + steps * speed;
                    let (from, end) = (if from > 0.0 { from } else { 0.0 }, slabs.count as f64);
                    for axis in 0..3 {
                        self.origin[axis][lane] = entry[axis] as f32;
                        self.direction[axis][lane] = (direction[axis] * along) as f32;
                    }
                    self.from[lane] = from as f32;
                    self.to[lane] =
                        if steps > 0.0 { if to < end { to as f32 } else { end as f32 } } else { from as f32 };
                    self.stretch[lane] = (1.0 / speed) as f32;
                    backward[lane] = if is_backward { 1.0 } else { 0.0 };
                }
                backward
            },
        )
    }

    /// The lanes that have a ray.
    pub fn lanes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..MOST_LANES).filter(|&lane| self.from[lane] < self.to[lane])
    }

    /// The slabs that any of its rays meets.
    pub fn slabs(&self) -> Range<usize> {
        let lanes = || self.lanes();
        let first = lanes().map(|lane| self.from[lane]).fold(f32::INFINITY, f32::min);
        let last = lanes().map(|lane| self.to[lane]).fold(0.0, f32::max);
        first.min(last) as usize..last.ceil() as usize
    }
}

/// A crossing in vectors.
pub struct Crossings<S: Lanes> {
    origin: Vec3<S>,
    direction: Vec3<S>,
    /// One over the direction.
    pub inverse: Vec3<S>,
    from: F32<S>,
    to: F32<S>,
    stretch: F32<S>,
    jitter: F32<S>,
}

/// What rays pass of one slab, or of a piece of it.
pub struct Passage<S: Lanes> {
    /// Coordinate of the sample.
    pub place: F32<S>,
    /// Its index position.
    pub index: Vec3<S>,
    /// Length of the segment, in steps.
    pub ratio: F32<S>,
    /// Lanes that meet it.
    pub lanes: Mask<S>,
}

impl<S: Lanes> Passage<S> {
    /// The same in some of its lanes.
    #[inline(always)]
    pub fn within(self, lanes: Mask<S>) -> Self {
        Self { lanes: self.lanes & lanes, ..self }
    }
}

impl<S: Lanes> Crossings<S> {
    /// The vectors of a crossing.
    #[inline(always)]
    pub fn new(s: S, crossing: &Crossing) -> Self {
        let direction = xyz!(I => load(s, &crossing.direction[I]));
        Self {
            origin: xyz!(I => load(s, &crossing.origin[I])),
            direction,
            inverse: inverse(s, &direction),
            from: load(s, &crossing.from),
            to: load(s, &crossing.to),
            stretch: load(s, &crossing.stretch),
            jitter: load(s, &crossing.jitter),
        }
    }

    /// The index position at a coordinate.
    #[inline(always)]
    pub fn at(&self, place: F32<S>) -> Vec3<S> {
        let along = place - self.from;
        xyz!(I => self.direction[I].mul_add(along, self.origin[I]))
    }

    /// A sample of one step at coordinates, in the lanes whose rays are in the field there.
    #[inline(always)]
    pub fn sample(&self, s: S, place: F32<S>) -> Passage<S> {
        let lanes = place.simd_ge(self.from) & place.simd_lt(self.to);
        Passage { place, index: self.at(place), ratio: splat(s, 1.0), lanes }
    }

    /// The first border of the field behind coordinates, or what there is otherwise.
    #[inline(always)]
    pub fn border(&self, front: F32<S>, otherwise: F32<S>) -> F32<S> {
        let mut border = otherwise;
        for end in [self.from, self.to] {
            let is_ahead = self.from.simd_lt(self.to) & end.simd_gt(front);
            border = is_ahead.select(end.min(border), border);
        }
        border
    }

    /// How many slabs from slab k on, itself included, have no border of the field within.
    #[inline(always)]
    pub fn uncut(&self, s: S, k: usize) -> usize {
        let border = self.border(splat(s, k as f32), splat(s, f32::INFINITY));
        border.as_slice().iter().copied().fold(f32::INFINITY, f32::min) as usize - k
    }

    /// The same from slab k back.
    #[inline(always)]
    pub fn uncut_back(&self, s: S, k: usize) -> usize {
        let (mut border, end) = (splat(s, 0.0), splat(s, (k + 1) as f32));
        for at in [self.from, self.to] {
            let is_behind = self.from.simd_lt(self.to) & at.simd_lt(end);
            border = is_behind.select(at.max(border), border);
        }
        k + 1 - border.as_slice().iter().copied().fold(0.0, f32::max).ceil() as usize
    }

    /// Where rays come into the field from the eye, and their directions there; `backward` ones leave the slabs there.
    #[inline(always)]
    pub fn entry(&self, backward: Mask<S>) -> [Vec3<S>; 2] {
        let direction = xyz!(I => backward.select(-self.direction[I], self.direction[I]));
        [self.at(backward.select(self.to, self.from)), direction]
    }

    /// What rays pass of slab k.
    #[inline(always)]
    pub fn passage(&self, s: S, k: usize) -> Passage<S> {
        let front = splat(s, k as f32);
        self.between(s, [front, front + 1.0])
    }

    /// What rays pass between two coordinates of a slab.
    #[inline(always)]
    pub fn between(&self, s: S, [front, back]: [F32<S>; 2]) -> Passage<S> {
        // Less of a slab is lost in the rounding of coordinates.
        const SHORTEST: f32 = 1e-6;
        let (enter, leave) = (front.max(self.from), back.min(self.to));
        let length = (leave - enter).max(splat(s, 0.0));
        let lanes = length.simd_gt(splat(s, SHORTEST));
        let place = self.jitter.mul_add(length, enter.min(self.to));
        Passage { place, index: self.at(place), ratio: length * self.stretch, lanes }
    }

    /// How many slabs from slab k on, itself included, certainly add nothing; `clear` tells it of a
    /// sample's position. At most to the end of all rays.
    #[inline(always)]
    pub fn leap(&self, s: S, k: usize, clear: impl FnOnce(&Vec3<S>) -> F32<S>) -> usize {
        self.least(s, k, self.to.simd_gt(splat(s, k as f32)), clear)
    }

    /// The same from slab k back, to where all rays begin.
    #[inline(always)]
    pub fn leap_back(&self, s: S, k: usize, clear: impl FnOnce(&Vec3<S>) -> F32<S>) -> usize {
        self.least(s, k, self.from.simd_lt(splat(s, (k + 1) as f32)), clear)
    }

    #[inline(always)]
    fn least(&self, s: S, k: usize, open: Mask<S>, clear: impl FnOnce(&Vec3<S>) -> F32<S>) -> usize {
        let Passage { index, .. } = self.passage(s, k);
        open.select(clear(&index), splat(s, f32::INFINITY)).reduce_min() as usize
    }
}

/// The slabs that any of some crossings meets.
pub fn slabs_of(crossings: &[Crossing]) -> Range<usize> {
    let slabs = || crossings.iter().map(Crossing::slabs).filter(|slabs| !slabs.is_empty());
    let (first, end) = (slabs().map(|slabs| slabs.start).min(), slabs().map(|slabs| slabs.end).max());
    first.unwrap_or(0)..end.unwrap_or(0)
}
