//! The sample positions of a ray: defined once, whatever the mode and whatever is skipped.
//!
//! The interval is cut into segments of one step from the entry on, the last one shorter. Segment
//! k has its sample at `entry + (k + jitter) * step`; in the last segment the sample keeps its
//! place relative to the segment's length, so that the interval is covered exactly and a
//! homogeneous slab has its exact transmittance at any step (1.4-13, Appendix E2). The vectors'
//! form of this is [`Rays`](crate::packet::Rays).

use crate::span::Span;

/// Segments along a span.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Length of a segment in world units.
    pub step: f64,
    /// Where in a segment its sample lies, `[0, 1)`.
    pub jitter: f64,
    /// Number of segments, at least 1.
    pub count: usize,
    /// Length of the last segment in steps.
    pub last_ratio: f64,
}

impl Lattice {
    /// Cuts a span into segments of `step` world units; `jitter` in `[0, 1)`.
    pub fn new(span: &Span, step: f64, jitter: f64) -> Self {
        let whole = span.length() / step;
        // A remainder below the precision of the interval is no segment.
        let count = ((whole - 1e-9).ceil()).max(1.0) as usize;
        Self { step, jitter, count, last_ratio: (whole - (count - 1) as f64).min(1.0) }
    }
}
