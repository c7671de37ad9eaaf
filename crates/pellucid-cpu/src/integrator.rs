//! What a mode is: something that turns the samples of one ray into a pixel.

use glam::DVec3;

use crate::lattice::Lattice;
use crate::span::Span;

/// What one ray found.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    /// Associated linear RGBA.
    pub color: [f32; 4],
    /// Distance along the ray; infinite where nothing was met.
    pub depth: f64,
    /// Unit world normal at that depth, or zero.
    pub normal: DVec3,
}

impl Traced {
    /// A ray that met nothing.
    pub const NOTHING: Self = Self { color: [0.0; 4], depth: f64::INFINITY, normal: DVec3::ZERO };
}

/// Counts of one or many rays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Field samples taken.
    pub samples: u64,
    /// Samples that added opacity.
    pub visible: u64,
    /// Lattice samples leapt over.
    pub skipped: u64,
    /// Rays stopped because they were opaque.
    pub terminated: u64,
}

impl Tally {
    /// Adds another tally.
    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.visible += other.visible;
        self.skipped += other.skipped;
        self.terminated += other.terminated;
    }
}

/// A mode, ready to trace rays.
pub trait Integrator: Sync {
    /// Follows one ray over its span.
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced;
}
