//! The walk over the samples of a lattice, for modes that look at one value at a time.

use crate::integrator::Tally;
use crate::lattice::Lattice;
use crate::skip::SkipGrid;
use crate::span::Span;

/// Visits the samples that can contribute, nearest first, as (number, distance), until the visitor
/// says that the ray is done. Whether a block can contribute is asked once per block.
#[inline(always)]
pub fn each_sample(
    skip: Option<&SkipGrid>,
    span: &Span,
    lattice: &Lattice,
    tally: &mut Tally,
    mut visit: impl FnMut(usize, f64, &mut Tally) -> bool,
) {
    let mut k = 0;
    while k < lattice.count {
        let (live, next) = skip.map_or((true, lattice.count), |skip| skip.run(span, lattice, k));
        if !live {
            tally.skipped += (next - k) as u64;
            k = next;
            continue;
        }
        for k in k..next {
            tally.samples += 1;
            if visit(k, lattice.sample(k), tally) {
                tally.terminated += 1;
                return;
            }
        }
        k = next;
    }
}
