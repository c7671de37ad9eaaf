//! What a mode is: something that turns the samples of a packet of rays into pixels.

use crate::lanes::*;
use crate::packet::{Packet, PerLane, Rays};

/// What the rays of a packet found.
#[derive(Clone, Debug)]
pub struct Traced {
    /// Associated linear RGBA.
    pub color: [PerLane; 4],
    /// What is held back of each colour from behind, where that is told of each.
    pub opacities: [PerLane; 3],
    /// Distance from the entry in steps; infinite where nothing was met.
    pub depth: PerLane,
    /// Unit world normal at that depth, or zero.
    pub normal: [PerLane; 3],
    /// Field samples taken.
    pub samples: PerLane,
}

impl Traced {
    /// Rays that met nothing.
    pub const NOTHING: Self = Self {
        color: [[0.0; MOST_LANES]; 4],
        opacities: [[0.0; MOST_LANES]; 3],
        depth: [f32::INFINITY; MOST_LANES],
        normal: [[0.0; MOST_LANES]; 3],
        samples: [0.0; MOST_LANES],
    };

    /// What the ray in a lane found, where a step is so many world units.
    pub fn ray(&self, lane: usize, packet: &Packet, step: f64) -> Found {
        Found {
            color: self.color.map(|lanes| lanes[lane]),
            opacities: self.opacities.map(|lanes| lanes[lane]),
            depth: (packet.entry[lane] + f64::from(self.depth[lane]) * step) as f32,
            normal: self.normal.map(|lanes| lanes[lane]),
            samples: self.samples[lane] as u32,
        }
    }

    /// Writes down colours.
    #[inline(always)]
    pub fn set_color<S: Lanes>(&mut self, color: [F32<S>; 4]) {
        for (place, lanes) in self.color.iter_mut().zip(color) {
            store::<S>(lanes, place);
        }
    }

    /// Writes down what is held back of each colour from behind.
    #[inline(always)]
    pub fn set_opacities<S: Lanes>(&mut self, opacities: [F32<S>; 3]) {
        for (place, lanes) in self.opacities.iter_mut().zip(opacities) {
            store::<S>(lanes, place);
        }
    }

    /// Writes down a depth and its normals, both only in the lanes that met something.
    #[inline(always)]
    pub fn set_surface<S: Lanes>(&mut self, s: S, met: Mask<S>, depth: F32<S>, normal: [F32<S>; 3]) {
        store::<S>(met.select(depth, splat(s, f32::INFINITY)), &mut self.depth);
        for (place, lanes) in self.normal.iter_mut().zip(normal) {
            store::<S>(met.select(lanes, splat(s, 0.0)), place);
        }
    }
}

/// What one ray found.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Associated linear RGBA.
    pub color: [f32; 4],
    /// What is held back of each colour from behind, where that is told of each.
    pub opacities: [f32; 3],
    /// Distance from the eye in world units; infinite where nothing was met.
    pub depth: f32,
    /// Unit world normal at that depth, or zero.
    pub normal: [f32; 3],
    /// Field samples taken.
    pub samples: u32,
}

/// Counts of one or many packets.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Paths followed, by techniques that take as many as they need.
    pub paths: u64,
    /// Field samples taken.
    pub samples: u64,
    /// Samples that added opacity.
    pub visible: u64,
    /// Lattice samples leapt over.
    pub skipped: u64,
    /// Rays stopped because they were opaque.
    pub terminated: u64,
    /// Luminance that paths brought, and what of it was held back as too bright.
    pub light: [f64; 2],
}

impl Tally {
    /// Adds another tally.
    pub fn add(&mut self, other: &Self) {
        self.paths += other.paths;
        self.samples += other.samples;
        self.visible += other.visible;
        self.skipped += other.skipped;
        self.terminated += other.terminated;
        self.light = [self.light[0] + other.light[0], self.light[1] + other.light[1]];
    }
}

/// The counts of a packet while it is traced.
pub struct Counter<S: Lanes> {
    samples: F32<S>,
    skipped: F32<S>,
    visible: u64,
    terminated: u64,
}

impl<S: Lanes> Counter<S> {
    /// Nothing yet.
    #[inline(always)]
    pub fn new(s: S) -> Self {
        Self { samples: splat(s, 0.0), skipped: splat(s, 0.0), visible: 0, terminated: 0 }
    }

    /// One sample in each of these lanes.
    #[inline(always)]
    pub fn sample(&mut self, lanes: Mask<S>) {
        self.samples = lanes.select(self.samples + 1.0, self.samples);
    }

    /// These samples added something.
    #[inline(always)]
    pub fn see(&mut self, lanes: Mask<S>) {
        self.visible += count::<S>(lanes);
    }

    /// So many samples were leapt over, in each lane.
    #[inline(always)]
    pub fn skip(&mut self, samples: F32<S>) {
        self.skipped += samples;
    }

    /// These rays are opaque.
    #[inline(always)]
    pub fn terminate(&mut self, lanes: Mask<S>) {
        self.terminated += count::<S>(lanes);
    }

    /// Writes the counts down.
    #[inline(always)]
    pub fn finish(self, traced: &mut Traced, tally: &mut Tally) {
        store::<S>(self.samples, &mut traced.samples);
        tally.samples += self.samples.as_slice().iter().sum::<f32>() as u64;
        tally.skipped += self.skipped.as_slice().iter().sum::<f32>() as u64;
        tally.visible += self.visible;
        tally.terminated += self.terminated;
    }
}

/// A mode, ready to trace rays.
pub trait Integrator: Sync {
    /// How many rays are followed at once.
    fn width(&self) -> usize;

    /// Follows the rays of packets side by side in the picture; there are as many of `traced`, and
    /// they come as [`Traced::NOTHING`].
    ///
    /// Of several layers there are as many packets more to each of `traced`: first one for all layers, which says where
    /// their lattice begins, then one for each.
    ///
    /// Packets of a wave may be followed in turns, so that they read the same voxels while these
    /// are near.
    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally);
}

/// Follows the packets of a wave one after the other, with the instruction set switched on.
#[inline(always)]
pub fn one_by_one<S: Lanes>(
    s: S,
    wave: &[Packet],
    traced: &mut [Traced],
    tally: &mut Tally,
    mut follow: impl FnMut(&Packet, &Rays<S>, &mut Traced, &mut Counter<S>),
) {
    s.vectorize(
        #[inline(always)]
        || {
            for (packet, traced) in wave.iter().zip(traced) {
                let (rays, mut counter) = (Rays::new(s, packet), Counter::new(s));
                follow(packet, &rays, traced, &mut counter);
                counter.finish(traced, tally);
            }
        },
    );
}
