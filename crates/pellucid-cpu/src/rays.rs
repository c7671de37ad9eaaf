//! The rays of a picture: where they meet the field, and where on them samples are taken.
//!
//! A ray is cut where it enters and leaves the grid's box and the clip region. The sample positions
//! are defined here, once, whatever the mode and whatever is skipped: from the entry on the interval
//! is cut into segments of one step, the last one shorter; segment k has its sample at
//! `(k + jitter)` steps; in the last segment the sample keeps its place relative to the segment's
//! length, so that the interval is covered exactly and a homogeneous slab has its exact transmittance
//! at any step (1.4-13, Appendix E2).

use pellucid_plan::blue_noise;
use pellucid_plan::half_angle::LightFrame;
use pellucid_scene::{Jitter, Stage};

use crate::lanes::{InstructionSet, Lanes, MOST_LANES, dispatch, width};
use crate::lines::{Lines, larger, smaller};
use crate::packet::Packet;
use crate::solid::Solid;
use crate::source::Source;
use crate::tiles::Tile;

/// One number a lane, in f64: far from the volume f32 would blur the entry.
type Wide = [f64; MOST_LANES];

/// Makes packets of the rays of a picture.
pub struct Emitter {
    set: InstructionSet,
    source: Source,
    step: f64,
    jitter: Jitter,
}

impl Emitter {
    /// Of the eye, for the camera and quality of a stage.
    pub fn of_eye(stage: &Stage, set: InstructionSet) -> Self {
        let (source, step, jitter) = (Source::of_eye(&stage.viewpoint), stage.step, stage.quality.jitter);
        Self { set, source, step, jitter }
    }

    /// Of a light, through the texels of its picture.
    pub fn of_light(frame: &LightFrame, step: f64, set: InstructionSet) -> Self {
        Self { set, source: Source::of_light(frame), step, jitter: Jitter::Centered }
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
                let world = self.source.lines(n, x, y);
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
