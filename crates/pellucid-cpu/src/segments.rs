//! The walk over segments between the nodes of a lattice, for modes that look at pairs of values.

use pellucid_field::Reconstruct;

use crate::integrator::Tally;
use crate::lattice::Lattice;
use crate::probe::Probe;
use crate::skip::SkipGrid;
use crate::span::Span;

/// A piece of a ray between two nodes.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Distances of its ends.
    pub t: [f64; 2],
    /// Data values at its ends; NaN where absent.
    pub value: [f64; 2],
}

/// Visits the segments that can contribute, nearest first, until the visitor says that the ray is
/// done. The value at a segment's end is carried over to the next: one fetch a segment (4.6-7).
#[inline(always)]
pub fn each_segment<R: Reconstruct>(
    probe: &Probe<R>,
    skip: Option<&SkipGrid>,
    span: &Span,
    lattice: &Lattice,
    tally: &mut Tally,
    mut visit: impl FnMut(Segment, &mut Tally) -> bool,
) {
    let last = lattice.count + 1;
    let mut carried = None;
    let mut n = 1;
    while n <= last {
        let (live, next) = skip.map_or((true, last + 1), |skip| skip.run_of_segments(span, lattice, n));
        if !live {
            tally.skipped += (next - n) as u64;
            n = next;
            carried = None;
            continue;
        }
        for n in n..next {
            let t = [lattice.node(n - 1, span.exit), lattice.node(n, span.exit)];
            let front = carried.unwrap_or_else(|| {
                tally.samples += 1;
                probe.value(span.index_at(t[0]))
            });
            tally.samples += 1;
            let back = probe.value(span.index_at(t[1]));
            carried = Some(back);
            if visit(Segment { t, value: [front, back] }, tally) {
                tally.terminated += 1;
                return;
            }
        }
        n = next;
    }
}
