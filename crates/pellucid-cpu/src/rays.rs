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
use pellucid_plan::blue_noise;
use pellucid_plan::half_angle::LightFrame;
use pellucid_scene::{Jitter, Region, Stage};

use crate::lanes::{InstructionSet, Lanes, MOST_LANES, dispatch, width};
use crate::packet::Packet;
use crate::tiles::Tile;

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

/// Where the rays of a picture come from: an eye, or a light.
struct Source {
    position: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// Whether they leave one point.
    perspective: bool,
    /// How far to the right and up the picture's corner (0, 0) is, at distance 1 or in world units.
    corner: [f64; 2],
    /// How far it is from there to the next pixel on the right, and below.
    pixel: [f64; 2],
    jitter: Jitter,
}

/// Makes packets of the rays of a picture.
pub struct Emitter {
    set: InstructionSet,
    perspective: bool,
    corner: [f64; 2],
    pixel: [f64; 2],
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
    /// Of the eye, for the camera and quality of a stage, a grid, and what clips leave of it.
    pub fn of_eye(stage: &Stage, grid: &Grid, region: &Region, set: InstructionSet) -> Self {
        let view = &stage.viewpoint;
        let pixel = 2.0 * view.half_height / view.height as f64;
        let middle = [view.width as f64 / 2.0 - view.shift.x, view.height as f64 / 2.0 - view.shift.y];
        let source = Source {
            position: view.eye,
            forward: view.forward,
            right: view.right,
            up: view.up,
            perspective: view.perspective,
            corner: [-middle[0] * pixel, middle[1] * pixel],
            pixel: [pixel, -pixel],
            jitter: stage.quality.jitter,
        };
        Self::new(source, stage.step, grid, region, set)
    }

    /// Of a light, through the texels of its picture.
    pub fn of_light(frame: &LightFrame, step: f64, grid: &Grid, region: &Region, set: InstructionSet) -> Self {
        let source = Source {
            position: frame.origin,
            forward: frame.forward,
            right: frame.right,
            up: frame.up,
            perspective: !frame.is_directional,
            corner: frame.low.to_array(),
            pixel: frame.texel.to_array(),
            jitter: Jitter::Centered,
        };
        Self::new(source, step, grid, region, set)
    }

    fn new(source: Source, step: f64, grid: &Grid, region: &Region, set: InstructionSet) -> Self {
        let index = |v: DVec3| grid.index_from_world().transform_vector3(v);
        let start = grid.index_from_world().transform_point3(source.position);
        let nothing = DVec3::ZERO;
        // Rays of a perspective leave one point, others one direction.
        let (to, from) = if source.perspective {
            ([source.right, source.up], [nothing; 2])
        } else {
            ([nothing; 2], [source.right, source.up])
        };
        let plane = |&(normal, offset): &(DVec3, f64)| Plane {
            slope: [normal.dot(source.forward), normal.dot(to[0]), normal.dot(to[1])],
            above: [normal.dot(source.position) - offset, normal.dot(from[0]), normal.dot(from[1])],
        };
        let (low, high) = grid.index_bounds();
        // Rounding must not make rays along a face of the box miss it.
        let room = (high - low).max_element() * 1e-12;
        let (low, high) = (low - room, high + room);
        Self {
            set,
            perspective: source.perspective,
            corner: source.corner,
            pixel: source.pixel,
            origin: Linear { middle: start, right: index(from[0]), up: index(from[1]) },
            direction: Linear { middle: index(source.forward), right: index(to[0]), up: index(to[1]) },
            world_direction: Linear { middle: source.forward, right: to[0], up: to[1] },
            low,
            high,
            planes: region.half_spaces().iter().map(plane).collect(),
            step,
            jitter: source.jitter,
        }
    }

    /// Rays through pixels of a tile whose first is at `[left, top]`, so many of `lanes` side by side; `sub` is the
    /// number of the ray within its pixel, which has `n` times `n`. Returns how many met the field.
    pub fn emit_pixels(
        &self,
        tile: &Tile,
        [left, top]: [usize; 2],
        [lanes, columns]: [usize; 2],
        (sub, n): (usize, usize),
        packet: &mut Packet,
    ) -> u64 {
        let (mut x, mut y, mut wanted) = ([0.0; MOST_LANES], [0.0; MOST_LANES], [false; MOST_LANES]);
        let inside = |cell: usize| (cell as f64 + 0.5) / n as f64;
        for lane in 0..lanes {
            let (column, row) = (left + lane % columns, top + lane / columns);
            x[lane] = (tile.x + column) as f64 + inside(sub % n);
            y[lane] = (tile.y + row) as f64 + inside(sub / n);
            wanted[lane] = column < tile.width && row < tile.height;
        }
        self.emit(&x, &y, &wanted, sub, packet)
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

    /// Rays as of [`emit_pixels`](Self::emit_pixels) through several layers: a packet for each, and in front of them one
    /// that says where the lattice of all of them begins. Returns how many rays met any.
    pub fn emit_layers(
        emitters: &[Self],
        tile: &Tile,
        corner: [usize; 2],
        lanes: [usize; 2],
        sub: (usize, usize),
        packets: &mut Vec<Packet>,
    ) -> u64 {
        let first = packets.len();
        packets.push(Packet::NOTHING);
        for emitter in emitters {
            let mut packet = Packet::NOTHING;
            emitter.emit_pixels(tile, corner, lanes, sub, &mut packet);
            packets.push(packet);
        }
        let (whole, own) = packets[first..].split_at_mut(1);
        let (whole, step) = (&mut whole[0], emitters[0].step);
        (whole.world_direction, whole.jitter) = (own[0].world_direction, own[0].jitter);
        for lane in 0..MOST_LANES {
            let met = || own.iter().filter(|packet| packet.count[lane] > 0.0);
            let entry = met().map(|packet| packet.entry[lane]).fold(f64::INFINITY, f64::min);
            let exit = met().map(|packet| packet.entry[lane] + packet.length(lane) * step);
            let length = (exit.fold(f64::NEG_INFINITY, f64::max) - entry) / step;
            if length > 0.0 {
                (whole.entry[lane], whole.count[lane]) = (entry, length.ceil() as f32);
            }
        }
        let hit = whole.count.iter().filter(|&&count| count > 0.0).count() as u64;
        if hit == 0 {
            packets.truncate(first);
        }
        hit
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
                    a[lane] = x[lane] * self.pixel[0] + self.corner[0];
                    b[lane] = y[lane] * self.pixel[1] + self.corner[1];
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
