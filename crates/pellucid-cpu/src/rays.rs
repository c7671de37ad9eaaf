//! The rays of a picture: where they meet the field, and where on them samples are taken.
//!
//! A ray is cut where it enters and leaves the grid's box and the clip region. The sample positions
//! are defined here, once, whatever the mode and whatever is skipped: from the entry on the interval
//! is cut into segments of one step, the last one shorter; segment k has its sample at
//! `(k + jitter)` steps; in the last segment the sample keeps its place relative to the segment's
//! length, so that the interval is covered exactly and a homogeneous slab has its exact transmittance
//! at any step (1.4-13, Appendix E2).

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::{Jitter, Region, Stage, blue_noise};

use crate::lanes::{InstructionSet, Lanes, MOST_LANES, dispatch, width};
use crate::packet::Packet;

/// One number a lane, in f64: far from the volume f32 would blur the entry.
type Wide = [f64; MOST_LANES];

/// A vector that changes linearly over the picture: at its middle, and per unit to the right and up.
struct Linear {
    middle: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Linear {
    #[inline(always)]
    fn at(&self, axis: usize, a: f64, b: f64) -> f64 {
        self.middle[axis] + self.right[axis] * a + self.up[axis] * b
    }
}

/// A clip plane as rays see it.
struct Plane {
    /// How much a ray rises above the plane per unit of world length, over the picture.
    slope: [f64; 3],
    /// How far above it the ray starts, over the picture.
    above: [f64; 3],
}

/// Makes packets of the rays of a stage.
pub struct Emitter {
    set: InstructionSet,
    perspective: bool,
    /// The middle of the picture in pixels.
    middle: [f64; 2],
    /// Length of a pixel's side.
    pixel: f64,
    /// Rays in index space, and their directions in the world; both per unit of world length once
    /// divided by the length of the latter.
    origin: Linear,
    direction: Linear,
    world_direction: Linear,
    low: DVec3,
    high: DVec3,
    planes: Vec<Plane>,
    step: f64,
    jitter: Jitter,
}

impl Emitter {
    /// For the camera and quality of a stage, a grid, and what clips leave of it.
    pub fn new(stage: &Stage, grid: &Grid, region: &Region, set: InstructionSet) -> Self {
        let view = &stage.viewpoint;
        let index = |v: DVec3| grid.index_from_world().transform_vector3(v);
        let eye = grid.index_from_world().transform_point3(view.eye);
        let nothing = DVec3::ZERO;
        // Rays of a perspective leave one point, others one direction.
        let (to, from) = if view.perspective {
            ([view.right, view.up], [nothing; 2])
        } else {
            ([nothing; 2], [view.right, view.up])
        };
        let plane = |&(normal, offset): &(DVec3, f64)| Plane {
            slope: [normal.dot(view.forward), normal.dot(to[0]), normal.dot(to[1])],
            above: [normal.dot(view.eye) - offset, normal.dot(from[0]), normal.dot(from[1])],
        };
        let (low, high) = grid.index_bounds();
        // Rounding must not make rays along a face of the box miss it.
        let room = (high - low).max_element() * 1e-12;
        let (low, high) = (low - room, high + room);
        Self {
            set,
            perspective: view.perspective,
            middle: [view.width as f64 / 2.0 - view.shift.x, view.height as f64 / 2.0 - view.shift.y],
            pixel: 2.0 * view.half_height / view.height as f64,
            origin: Linear { middle: eye, right: index(from[0]), up: index(from[1]) },
            direction: Linear { middle: index(view.forward), right: index(to[0]), up: index(to[1]) },
            world_direction: Linear { middle: view.forward, right: to[0], up: to[1] },
            low,
            high,
            planes: region.half_spaces().iter().map(plane).collect(),
            step: stage.step,
            jitter: stage.quality.jitter,
        }
    }

    /// Rays through picture positions, in pixels from the top left; the lanes without a `true` stay
    /// empty. `sub` is the number of the ray within its pixel. Returns how many met the field.
    pub fn emit(&self, x: &Wide, y: &Wide, wanted: &[bool; MOST_LANES], sub: usize, packet: &mut Packet) -> u64 {
        dispatch!(self.set, s => self.emit_in(s, x, y, wanted, packet));
        if let Jitter::BlueNoise { seed } = self.jitter {
            for lane in 0..MOST_LANES {
                // The rays of one pixel differ by the golden ratio, which spreads any number evenly.
                const GOLDEN: f64 = 0.618_033_988_749_894_9;
                let noise = blue_noise(x[lane] as usize, y[lane] as usize, seed) + sub as f64 * GOLDEN;
                packet.jitter[lane] = noise.fract() as f32;
            }
        }
        packet.count.iter().filter(|&&count| count > 0.0).count() as u64
    }

    fn emit_in<S: Lanes>(&self, s: S, x: &Wide, y: &Wide, wanted: &[bool; MOST_LANES], packet: &mut Packet) {
        s.vectorize(
            #[inline(always)]
            || {
                // One plain loop over plain arrays after the other: the compiler makes vectors of them.
                let n = width::<S>();
                let (mut a, mut b, mut unit) = ([0.0; MOST_LANES], [0.0; MOST_LANES], [1.0; MOST_LANES]);
                let (mut t0, mut t1) = ([0.0; MOST_LANES], [f64::INFINITY; MOST_LANES]);
                let (mut origin, mut direction) = ([[0.0; MOST_LANES]; 3], [[0.0; MOST_LANES]; 3]);
                for lane in 0..n {
                    a[lane] = (x[lane] - self.middle[0]) * self.pixel;
                    b[lane] = (self.middle[1] - y[lane]) * self.pixel;
                }
                if self.perspective {
                    for lane in 0..n {
                        unit[lane] = 1.0 / (1.0 + a[lane] * a[lane] + b[lane] * b[lane]).sqrt();
                    }
                }
                for axis in 0..3 {
                    for lane in 0..n {
                        let o = self.origin.at(axis, a[lane], b[lane]);
                        let d = self.direction.at(axis, a[lane], b[lane]) * unit[lane];
                        (origin[axis][lane], direction[axis][lane]) = (o, d);
                        let inverse = 1.0 / nonzero(d);
                        let (near, far) = ((self.low[axis] - o) * inverse, (self.high[axis] - o) * inverse);
                        t0[lane] = larger(t0[lane], smaller(near, far));
                        t1[lane] = smaller(t1[lane], larger(near, far));
                    }
                }
                for Plane { slope, above } in &self.planes {
                    for lane in 0..n {
                        let slope = (slope[0] + slope[1] * a[lane] + slope[2] * b[lane]) * unit[lane];
                        let above = above[0] + above[1] * a[lane] + above[2] * b[lane];
                        let crossing = -above / nonzero(slope);
                        t0[lane] = if slope >= 0.0 { larger(t0[lane], crossing) } else { t0[lane] };
                        t1[lane] = if slope < 0.0 { smaller(t1[lane], crossing) } else { t1[lane] };
                    }
                }
                for lane in 0..n {
                    let whole = (t1[lane] - t0[lane]) / self.step;
                    // A remainder below the precision of the interval is no segment.
                    let count = larger((whole - 1e-9).ceil(), 1.0);
                    packet.count[lane] = if t0[lane] < t1[lane] { count as f32 } else { 0.0 };
                    packet.last_ratio[lane] = smaller(whole - (count - 1.0), 1.0) as f32;
                    packet.entry[lane] = t0[lane];
                }
                for axis in 0..3 {
                    for lane in 0..n {
                        let entry = origin[axis][lane] + direction[axis][lane] * t0[lane];
                        packet.origin[axis][lane] = finite(entry) as f32;
                        packet.direction[axis][lane] = finite(direction[axis][lane] * self.step) as f32;
                        let world = self.world_direction.at(axis, a[lane], b[lane]) * unit[lane];
                        packet.world_direction[axis][lane] = world as f32;
                    }
                }
                for lane in 0..n {
                    packet.count[lane] = if wanted[lane] { packet.count[lane] } else { 0.0 };
                }
            },
        );
    }
}

/// The larger number: one instruction, as nothing is said of NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller number.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// A number to divide by: a ray along a plane is on one side of it by the sign of a huge number.
#[inline(always)]
fn nonzero(x: f64) -> f64 {
    if x.abs() < 1e-200 { 1e-200 } else { x }
}

/// A number of voxels that f32 can hold; none is ever that large.
#[inline(always)]
fn finite(x: f64) -> f64 {
    const FAR: f64 = 1e30;
    larger(smaller(x, FAR), -FAR)
}
