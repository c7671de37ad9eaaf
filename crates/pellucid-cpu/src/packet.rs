//! Rays that are followed side by side.

use crate::lanes::*;

/// One number a lane.
pub type PerLane = [f32; MOST_LANES];

/// As many rays as the instruction set has lanes, or fewer; the rest are rays that met nothing.
///
/// Distances along a ray count steps from its entry: positions then keep their precision however
/// far the eye is, and nothing overflows whatever the units of the world are.
#[derive(Clone, Debug)]
pub struct Packet {
    /// Continuous voxel index of the entry.
    pub origin: [PerLane; 3],
    /// Index-space direction, per step.
    pub direction: [PerLane; 3],
    /// Unit direction in the world.
    pub world_direction: [PerLane; 3],
    /// Where in a step its sample lies, `[0, 1)`.
    pub jitter: PerLane,
    /// Number of segments; 0 if there is no ray.
    pub count: PerLane,
    /// Length of the last segment, in steps.
    pub last_ratio: PerLane,
    /// Distance from the eye to the entry, in world units.
    pub entry: [f64; MOST_LANES],
}

impl Packet {
    /// A packet without rays, whose samples lie in the middle of their steps.
    pub const NOTHING: Self = Self {
        origin: [[0.0; MOST_LANES]; 3],
        direction: [[0.0; MOST_LANES]; 3],
        world_direction: [[0.0; MOST_LANES]; 3],
        jitter: [0.5; MOST_LANES],
        count: [0.0; MOST_LANES],
        last_ratio: [1.0; MOST_LANES],
        entry: [0.0; MOST_LANES],
    };
}

impl Packet {
    /// Unit vectors of the world to where the rays come from.
    #[inline(always)]
    pub fn to_eye<S: Lanes>(&self, s: S) -> Vec3<S> {
        xyz!(I => -load(s, &self.world_direction[I]))
    }

    /// Length of the ray in a lane that has one, in steps.
    pub fn length(&self, lane: usize) -> f64 {
        f64::from(self.count[lane] - 1.0) + f64::from(self.last_ratio[lane])
    }
}

/// One over directions, very large along axes that they do not move on.
#[inline(always)]
pub fn inverse<S: Lanes>(s: S, direction: &Vec3<S>) -> Vec3<S> {
    xyz!(I => {
        let slow = direction[I].abs().simd_lt(splat(s, 1e-12));
        splat(s, 1.0) / slow.select(splat(s, 1e-12), direction[I])
    })
}

/// A packet in vectors.
pub struct Rays<S: Lanes> {
    /// Continuous voxel index of the entry.
    pub origin: Vec3<S>,
    /// Index-space direction, per step.
    pub direction: Vec3<S>,
    /// One over the direction, very large along axes that the ray does not move on.
    pub inverse: Vec3<S>,
    /// Where in a step its sample lies.
    pub jitter: F32<S>,
    /// Number of segments.
    pub count: F32<S>,
    /// Length of the last segment, in steps.
    pub last_ratio: F32<S>,
}

impl<S: Lanes> Rays<S> {
    /// The vectors of a packet.
    #[inline(always)]
    pub fn new(s: S, packet: &Packet) -> Self {
        let direction = xyz!(I => load(s, &packet.direction[I]));
        Self {
            origin: xyz!(I => load(s, &packet.origin[I])),
            direction,
            inverse: inverse(s, &direction),
            jitter: load(s, &packet.jitter),
            count: load(s, &packet.count),
            last_ratio: load(s, &packet.last_ratio),
        }
    }

    /// Rays from index positions, so many steps long: none where that is 0.
    #[inline(always)]
    pub fn from(s: S, origin: Vec3<S>, direction: Vec3<S>, length: F32<S>) -> Self {
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        // A remainder below the precision of positions is no segment.
        let count = (length - 1e-4).ceil().max(one);
        Self {
            origin,
            direction,
            inverse: inverse(s, &direction),
            jitter: splat(s, 0.5),
            count: length.simd_gt(zero).select(count, zero),
            last_ratio: (length - (count - 1.0)).min(one),
        }
    }

    /// The index position at a distance.
    #[inline(always)]
    pub fn at(&self, distance: F32<S>) -> Vec3<S> {
        xyz!(I => self.direction[I].mul_add(distance, self.origin[I]))
    }

    /// Whether there is a segment k.
    #[inline(always)]
    pub fn has(&self, k: F32<S>) -> Mask<S> {
        k.simd_lt(self.count)
    }

    /// Whether there is a segment behind node n.
    #[inline(always)]
    pub fn has_node(&self, n: F32<S>) -> Mask<S> {
        n.simd_le(self.count)
    }

    /// Whether segment k is the last one, or beyond.
    #[inline(always)]
    pub fn is_last(&self, k: F32<S>) -> Mask<S> {
        k.simd_ge(self.count - 1.0)
    }

    /// Length of segment k, in steps: 1 but for the last.
    #[inline(always)]
    pub fn ratio(&self, s: S, k: F32<S>) -> F32<S> {
        self.is_last(k).select(self.last_ratio, splat(s, 1.0))
    }

    /// Distance of segment k's sample.
    #[inline(always)]
    pub fn sample(&self, s: S, k: F32<S>) -> F32<S> {
        self.jitter.mul_add(self.ratio(s, k), k)
    }

    /// Length of the segment behind node n, in steps; n from 0 to `count`.
    #[inline(always)]
    pub fn segment_length(&self, s: S, n: F32<S>) -> F32<S> {
        let first = n.simd_lt(splat(s, 1.0));
        let inner = self.jitter.mul_add(self.ratio(s, n) - 1.0, splat(s, 1.0));
        let length = first.select(self.jitter * self.ratio(s, n), inner);
        n.simd_ge(self.count).select((splat(s, 1.0) - self.jitter) * self.last_ratio, length)
    }

    /// Length of a segment of `stride` steps from segment k on, or what is left of the ray.
    #[inline(always)]
    pub fn stride(&self, k: F32<S>, stride: F32<S>) -> F32<S> {
        (self.count - 1.0 - k + self.last_ratio).min(stride)
    }

    /// Distance of the exit.
    #[inline(always)]
    pub fn length(&self) -> F32<S> {
        self.count - 1.0 + self.last_ratio
    }

    /// Nodes of the piecewise linear view of a ray: the entry, then every sample, then the exit;
    /// n from 0 to `count + 1`.
    #[inline(always)]
    pub fn node(&self, s: S, n: F32<S>) -> F32<S> {
        let inner = n.simd_gt(self.count).select(self.length(), self.sample(s, n - 1.0));
        n.simd_lt(splat(s, 1.0)).select(splat(s, 0.0), inner)
    }
}
