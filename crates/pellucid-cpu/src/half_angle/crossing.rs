//! Rays of the eye and of lights, as they cross slabs.
//!
//! Both are followed in the order of the slabs, away from the light. What a ray passes of a slab is a
//! segment of its own length, cut where the ray enters and leaves the field, with one sample in it: so a
//! homogeneous medium has its exact transmittance at any thickness and angle.

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::half_angle::Slabs;
use pellucid_scene::{Ray, Region};

use crate::lanes::*;
use crate::packet::{PerLane, inverse};

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
    pub jitter: PerLane,
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

    /// Puts the part of a ray between two distances into a lane. Returns whether it travels against the
    /// order of slabs.
    pub fn set(&mut self, lane: usize, ray: &Ray, span: (f64, f64), slabs: &Slabs, grid: &Grid, step: f64) -> bool {
        // A ray that lies in a slab crosses it very slowly.
        const SLOWEST: f64 = 1e-6;
        let cosine = slabs.axis.dot(ray.direction);
        let backward = cosine < 0.0;
        let speed = cosine.abs().max(SLOWEST) / slabs.thickness;
        let (first, way) = if backward { (span.1, -ray.direction) } else { (span.0, ray.direction) };
        let entry = ray.origin + ray.direction * first;
        let from = slabs.coordinate(entry);
        let index = grid.index_from_world();
        let (origin, direction) = (index.transform_point3(entry), index.transform_vector3(way / speed));
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis] as f32;
            self.direction[axis][lane] = direction[axis] as f32;
        }
        self.from[lane] = from.max(0.0) as f32;
        self.to[lane] = (from + (span.1 - span.0) * speed).min(slabs.count as f64) as f32;
        self.stretch[lane] = (1.0 / (speed * step)) as f32;
        backward
    }

    /// The lanes that have a ray.
    pub fn lanes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..MOST_LANES).filter(|&lane| self.from[lane] < self.to[lane])
    }

    /// The slabs that any of its rays meets.
    pub fn slabs(&self) -> std::ops::Range<usize> {
        let lanes = || self.lanes();
        let first = lanes().map(|lane| self.from[lane]).fold(f32::INFINITY, f32::min);
        let last = lanes().map(|lane| self.to[lane]).fold(0.0, f32::max);
        first.min(last) as usize..last.ceil() as usize
    }
}

/// The part of a ray inside a grid's box and what clips leave of it, by distances.
pub fn chord(ray: &Ray, from: f64, grid: &Grid, region: &Region) -> Option<(f64, f64)> {
    let index = grid.index_from_world();
    let (origin, direction) = (index.transform_point3(ray.origin), index.transform_vector3(ray.direction));
    let (low, high): (DVec3, DVec3) = grid.index_bounds();
    let (mut t0, mut t1) = (from, f64::INFINITY);
    for axis in 0..3 {
        // A ray along a face is on one side of it by the sign of a huge number.
        let slope = if direction[axis].abs() < 1e-200 { 1e-200 } else { direction[axis] };
        let ends = [(low[axis] - origin[axis]) / slope, (high[axis] - origin[axis]) / slope];
        t0 = t0.max(ends[0].min(ends[1]));
        t1 = t1.min(ends[0].max(ends[1]));
    }
    if t0 < t1 { region.interval(ray, t0, t1) } else { None }
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

/// What rays pass of one slab.
pub struct Passage<S: Lanes> {
    /// Coordinate of the sample.
    pub place: F32<S>,
    /// Its index position.
    pub index: Vec3<S>,
    /// Length of the segment, in steps.
    pub ratio: F32<S>,
    /// Lanes that meet the slab.
    pub lanes: Mask<S>,
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

    /// Length of rays in a slab, in steps.
    #[inline(always)]
    pub fn stretch(&self) -> F32<S> {
        self.stretch
    }

    /// What rays pass of slab k.
    #[inline(always)]
    pub fn passage(&self, s: S, k: usize) -> Passage<S> {
        // Less of a slab is lost in the rounding of coordinates.
        const SHORTEST: f32 = 1e-6;
        let front = splat(s, k as f32);
        let (enter, leave) = (front.max(self.from), (front + 1.0).min(self.to));
        let length = (leave - enter).max(splat(s, 0.0));
        let lanes = length.simd_gt(splat(s, SHORTEST));
        let place = self.jitter.mul_add(length, enter.min(self.to));
        Passage { place, index: self.at(place), ratio: length * self.stretch, lanes }
    }

    /// How many slabs from slab k on, itself included, certainly add nothing; `clear` tells it of a
    /// sample's position. At most to the end of all rays.
    #[inline(always)]
    pub fn leap(&self, s: S, k: usize, clear: impl FnOnce(&Vec3<S>) -> F32<S>) -> usize {
        let Passage { index, .. } = self.passage(s, k);
        let open = self.to.simd_gt(splat(s, k as f32));
        let clear = open.select(clear(&index), splat(s, f32::INFINITY));
        let least = clear.as_slice().iter().copied().fold(f32::INFINITY, f32::min);
        least as usize
    }
}
