//! The rays of a picture: where they meet the field, and where on them samples are taken.
//!
//! A ray is cut where it enters and leaves the grid's box and the clip region. The sample positions
//! are defined here, once, whatever the mode and whatever is skipped: from the entry on the interval
//! is cut into segments of one step, the last one shorter; segment k has its sample at
//! `(k + jitter)` steps; in the last segment the sample keeps its place relative to the segment's
//! length, so that the interval is covered exactly and a homogeneous slab has its exact transmittance
//! at any step (1.4-13, Appendix E2).

use glam::DVec3;
use pellucid_plan::blue_noise;
use pellucid_plan::half_angle::LightFrame;
use pellucid_scene::{Jitter, Stage};

use crate::lanes::{InstructionSet, Lanes, MOST_LANES, dispatch, width};
use crate::lines::{Lines, larger, smaller};
use crate::packet::Packet;
use crate::solid::Solid;
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

/// Makes packets of the rays of a picture, which come from an eye or from a light.
pub struct Emitter {
    set: InstructionSet,
    /// Whether they leave one point.
    perspective: bool,
    /// How far to the right and up the picture's corner (0, 0) is, at distance 1 or in world units.
    corner: [f64; 2],
    /// How far it is from there to the next pixel on the right, and below.
    pixel: [f64; 2],
    origin: Linear,
    /// Directions of any length.
    direction: Linear,
    step: f64,
    jitter: Jitter,
}

impl Emitter {
    /// Of the eye, for the camera and quality of a stage.
    pub fn of_eye(stage: &Stage, set: InstructionSet) -> Self {
        let view = &stage.viewpoint;
        let pixel = 2.0 * view.half_height / view.height as f64;
        let middle = [view.width as f64 / 2.0 - view.shift.x, view.height as f64 / 2.0 - view.shift.y];
        let (corner, pixel) = ([-middle[0] * pixel, middle[1] * pixel], [pixel, -pixel]);
        let (step, jitter) = (stage.step, stage.quality.jitter);
        let from = [view.eye, view.forward, view.right, view.up];
        Self { jitter, ..Self::new(from, view.perspective, [corner, pixel], step, set) }
    }

    /// Of a light, through the texels of its picture.
    pub fn of_light(frame: &LightFrame, step: f64, set: InstructionSet) -> Self {
        let from = [frame.origin, frame.forward, frame.right, frame.up];
        let picture = [frame.low.to_array(), frame.texel.to_array()];
        Self::new(from, !frame.is_directional, picture, step, set)
    }

    fn new(
        [position, forward, right, up]: [DVec3; 4],
        perspective: bool,
        [corner, pixel]: [[f64; 2]; 2],
        step: f64,
        set: InstructionSet,
    ) -> Self {
        // Rays of a perspective leave one point, others one direction.
        let (same, differing) =
            (|middle| Linear { middle, right: DVec3::ZERO, up: DVec3::ZERO }, |middle| Linear { middle, right, up });
        let (origin, direction) =
            if perspective { (same(position), differing(forward)) } else { (differing(position), same(forward)) };
        Self { set, perspective, corner, pixel, origin, direction, step, jitter: Jitter::Centered }
    }

    /// Rays through pixels of a tile whose first is at `[left, top]`, so many of `lanes` side by side; `sub` is the
    /// number of the ray within its pixel, which has `n` times `n`. Returns how many met any of the solids, of each of
    /// which there is a packet.
    pub fn emit_pixels(
        &self,
        tile: &Tile,
        [left, top]: [usize; 2],
        [lanes, columns]: [usize; 2],
        (sub, n): (usize, usize),
        (solids, packets): (&[Solid], &mut [Packet]),
    ) -> u64 {
        let (mut x, mut y, mut wanted) = ([0.0; MOST_LANES], [0.0; MOST_LANES], [false; MOST_LANES]);
        let inside = |cell: usize| (cell as f64 + 0.5) / n as f64;
        for lane in 0..lanes {
            let (column, row) = (left + lane % columns, top + lane / columns);
            x[lane] = (tile.x + column) as f64 + inside(sub % n);
            y[lane] = (tile.y + row) as f64 + inside(sub / n);
            wanted[lane] = column < tile.width && row < tile.height;
        }
        self.emit(&x, &y, &wanted, sub, (solids, packets))
    }

    /// Rays through picture positions, in pixels from the top left; the lanes without a `true` stay
    /// empty. `sub` is the number of the ray within its pixel. Returns how many met any of the solids, of each of which
    /// there is a packet.
    pub fn emit(
        &self,
        x: &Wide,
        y: &Wide,
        wanted: &[bool; MOST_LANES],
        sub: usize,
        (solids, packets): (&[Solid], &mut [Packet]),
    ) -> u64 {
        dispatch!(self.set, s => self.emit_in(s, x, y, wanted, (solids, packets)));
        if let Jitter::BlueNoise { seed } = self.jitter {
            for lane in 0..MOST_LANES {
                // The rays of one pixel differ by the golden ratio, which spreads any number evenly.
                const GOLDEN: f64 = 0.618_033_988_749_894_9;
                let noise = blue_noise(x[lane] as usize, y[lane] as usize, seed) + sub as f64 * GOLDEN;
                for packet in &mut *packets {
                    packet.jitter[lane] = noise.fract() as f32;
                }
            }
        }
        (0..MOST_LANES).filter(|&lane| packets.iter().any(|packet| packet.count[lane] > 0.0)).count() as u64
    }

    /// A packet that says where the lattice begins that rays have in all of these packets together.
    pub fn around(&self, own: &[Packet]) -> Packet {
        let mut whole = Packet { world_direction: own[0].world_direction, jitter: own[0].jitter, ..Packet::NOTHING };
        for lane in 0..MOST_LANES {
            let met = || own.iter().filter(|packet| packet.count[lane] > 0.0);
            let entry = met().map(|packet| packet.entry[lane]).fold(f64::INFINITY, f64::min);
            let exit = met().map(|packet| packet.entry[lane] + packet.length(lane) * self.step);
            let length = (exit.fold(f64::NEG_INFINITY, f64::max) - entry) / self.step;
            if length > 0.0 {
                (whole.entry[lane], whole.count[lane]) = (entry, length.ceil() as f32);
            }
        }
        whole
    }

    fn emit_in<S: Lanes>(
        &self,
        s: S,
        x: &Wide,
        y: &Wide,
        wanted: &[bool; MOST_LANES],
        (solids, packets): (&[Solid], &mut [Packet]),
    ) {
        s.vectorize(
            #[inline(always)]
            || {
                let n = width::<S>();
                let world = self.lines(n, x, y);
                for (solid, packet) in solids.iter().zip(packets) {
                    let mut lines = solid.carry(n, &world);
                    solid.cut(n, &mut lines);
                    self.pack(n, &world, &lines, packet);
                    for lane in 0..n {
                        packet.count[lane] = if wanted[lane] { packet.count[lane] } else { 0.0 };
                    }
                }
            },
        );
    }

    /// The rays of the world through picture positions.
    #[inline(always)]
    fn lines(&self, n: usize, x: &Wide, y: &Wide) -> Lines<MOST_LANES> {
        let (mut a, mut b, mut unit) = ([0.0; MOST_LANES], [0.0; MOST_LANES], [1.0; MOST_LANES]);
        for lane in 0..n {
            a[lane] = x[lane] * self.pixel[0] + self.corner[0];
            b[lane] = y[lane] * self.pixel[1] + self.corner[1];
        }
        if self.perspective {
            for lane in 0..n {
                unit[lane] = 1.0 / (1.0 + a[lane] * a[lane] + b[lane] * b[lane]).sqrt();
            }
        }
        let mut lines = Lines::UNDIRECTED;
        for axis in 0..3 {
            for lane in 0..n {
                lines.origin[axis][lane] = self.origin.at(axis, a[lane], b[lane]);
                lines.direction[axis][lane] = self.direction.at(axis, a[lane], b[lane]) * unit[lane];
            }
        }
        lines
    }

    /// Writes down rays of the world that lie so in a solid.
    #[inline(always)]
    fn pack(&self, n: usize, world: &Lines<MOST_LANES>, lines: &Lines<MOST_LANES>, packet: &mut Packet) {
        let [t0, t1] = &lines.ends;
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
                let entry = lines.origin[axis][lane] + lines.direction[axis][lane] * t0[lane];
                packet.origin[axis][lane] = finite(entry) as f32;
                packet.direction[axis][lane] = finite(lines.direction[axis][lane] * self.step) as f32;
                packet.world_direction[axis][lane] = world.direction[axis][lane] as f32;
            }
        }
    }
}

/// A number of voxels that f32 can hold; none is ever that large.
#[inline(always)]
fn finite(x: f64) -> f64 {
    const FAR: f64 = 1e30;
    larger(smaller(x, FAR), -FAR)
}
