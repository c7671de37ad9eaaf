//! The sample positions of a ray: defined once, whatever the mode and whatever is skipped.
//!
//! The interval is cut into segments of one step from the entry on, the last one shorter. Segment
//! k has its sample at `entry + (k + jitter) * step`; in the last segment the sample keeps its
//! place relative to the segment's length, so that the interval is covered exactly and a
//! homogeneous slab has its exact transmittance at any step (1.4-13, Appendix E2).

use crate::span::Span;

/// Segments along a span.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    entry: f64,
    step: f64,
    jitter: f64,
    /// Number of segments.
    pub count: usize,
    last_ratio: f64,
}

impl Lattice {
    /// Cuts a span into segments of `step` world units; `jitter` in `[0, 1)`.
    pub fn new(span: &Span, step: f64, jitter: f64) -> Self {
        let whole = span.length() / step;
        // A remainder below the precision of the interval is no segment.
        let count = ((whole - 1e-9).ceil()).max(1.0) as usize;
        Self { entry: span.entry, step, jitter, count, last_ratio: (whole - (count - 1) as f64).min(1.0) }
    }

    /// Distance of segment k's sample.
    #[inline(always)]
    pub fn sample(&self, k: usize) -> f64 {
        self.entry + (k as i64 as f64 + self.jitter * self.ratio(k)) * self.step
    }

    /// Length of segment k in steps: 1 but for the last.
    #[inline(always)]
    pub fn ratio(&self, k: usize) -> f64 {
        if k + 1 == self.count { self.last_ratio } else { 1.0 }
    }

    /// The first segment whose sample lies at or beyond distance t, at most [`Lattice::count`].
    #[inline(always)]
    pub fn first_at(&self, t: f64) -> usize {
        let k = ((t - self.entry) / self.step - self.jitter).ceil();
        (k.max(0.0) as i64 as usize).min(self.count)
    }

    /// Nodes of the piecewise linear view of the span: the entry, then every sample, then the
    /// exit; node n is at [`Lattice::node`], n from 0 to `count + 1`.
    #[inline(always)]
    pub fn node(&self, n: usize, exit: f64) -> f64 {
        match n {
            0 => self.entry,
            n if n <= self.count => self.sample(n - 1),
            _ => exit,
        }
    }

    /// The step, in world units.
    pub fn step(&self) -> f64 {
        self.step
    }
}
