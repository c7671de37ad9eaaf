//! Projections: what a ray makes of its values without an order (1.4-10, 1.4-11).

use pellucid_field::Reconstruct;
use pellucid_optics::{StepTable, Table, correct_opacity, extinction};

use crate::integrator::{Integrator, Tally, Traced};
use crate::lattice::Lattice;
use crate::probe::Probe;
use crate::samples::each_sample;
use crate::skip::{BlockMap, SkipGrid};
use crate::span::Span;

/// The largest or the smallest value.
pub struct Extreme<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// The transfer function, applied once to the extreme.
    pub table: &'a Table,
    /// Blocks, if those that cannot change the extreme are leapt over.
    pub skip: Option<BlockMap<'a>>,
    /// Smallest instead of largest.
    pub minimum: bool,
    /// Opacity 1 wherever there is a value (slices) instead of the table's.
    pub opaque: bool,
}

impl<R: Reconstruct> Integrator for Extreme<'_, R> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        let mut best = f64::NAN;
        let mut depth = f64::INFINITY;
        let mut k = 0;
        while k < lattice.count {
            let (dead, next) = self.skip.as_ref().map_or((false, lattice.count), |map| {
                let (block, next) = map.run(span, lattice, k);
                let dead = map.range(block).is_none_or(|[low, high]| {
                    if self.minimum { best <= f64::from(low) } else { best >= f64::from(high) }
                });
                (dead, next)
            });
            if dead {
                tally.skipped += (next - k) as u64;
                k = next;
                continue;
            }
            for k in k..next {
                let t = lattice.sample(k);
                tally.samples += 1;
                let value = self.probe.value(span.index_at(t));
                let better = if self.minimum { value < best } else { value > best };
                if better || (best.is_nan() && !value.is_nan()) {
                    best = value;
                    depth = t;
                }
            }
            k = next;
        }
        classified(self.table, best, depth, self.opaque, tally)
    }
}

/// The mean value.
pub struct Average<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// The transfer function, applied once to the mean.
    pub table: &'a Table,
    /// Opacity 1 wherever there is a value (slices) instead of the table's.
    pub opaque: bool,
}

impl<R: Reconstruct> Integrator for Average<'_, R> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        let (mut sum, mut length) = (0.0, 0.0);
        for k in 0..lattice.count {
            tally.samples += 1;
            let value = self.probe.value(span.index_at(lattice.sample(k)));
            if !value.is_nan() {
                sum += value * lattice.ratio(k);
                length += lattice.ratio(k);
            }
        }
        // An empty ray divides zero by zero: NaN, which is absent.
        classified(self.table, sum / length, f64::INFINITY, self.opaque, tally)
    }
}

/// Colour and opacity of one value for a whole ray; opacity is not corrected for any length.
pub fn classified(table: &Table, value: f64, depth: f64, opaque: bool, tally: &mut Tally) -> Traced {
    if value.is_nan() {
        return Traced::NOTHING;
    }
    tally.visible += 1;
    let [r, g, b, a] = table.lookup(value as f32);
    let a = if opaque { 1.0 } else { a };
    Traced { color: [r * a, g * a, b * a, a], depth, ..Traced::NOTHING }
}

/// Emission without absorption (1.2-7, model 2): the medium of the transfer function gives its
/// light `q = kappa c` and takes none away. The picture adds to what is behind it.
pub struct Additive<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// Colour and opacity per unit distance.
    pub table: &'a Table,
    /// Step in unit distances.
    pub step_ratio: f64,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<SkipGrid<'a>>,
}

impl<R: Reconstruct> Integrator for Additive<'_, R> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        /// Opacity 1 would shine infinitely; this one emits 9.2 times its colour per unit distance.
        const BRIGHTEST: f64 = 0.9999;
        let mut sum = [0.0f64; 3];
        each_visible(&self.probe, self.skip.as_ref(), span, lattice, tally, |value, ratio| {
            let [r, g, b, a] = self.table.lookup(value as f32);
            let length = extinction(f64::from(a).min(BRIGHTEST), 1.0) * self.step_ratio * ratio;
            for (sum, c) in sum.iter_mut().zip([r, g, b]) {
                *sum += f64::from(c) * length;
            }
            a > 0.0
        });
        let [r, g, b] = sum.map(|c| c as f32);
        Traced { color: [r, g, b, 0.0], ..Traced::NOTHING }
    }
}

/// A radiograph (1.2-7, model 1; 1.4-11): the share of light held back, in white.
pub struct XRay<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// Opacity of one step.
    pub table: &'a StepTable,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<SkipGrid<'a>>,
}

impl<R: Reconstruct> Integrator for XRay<'_, R> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        let mut through = 1.0f32;
        each_visible(&self.probe, self.skip.as_ref(), span, lattice, tally, |value, ratio| {
            let alpha = self.table.lookup(value as f32)[3];
            through *= 1.0 - correct_opacity(alpha, ratio as f32);
            alpha > 0.0
        });
        Traced { color: [1.0 - through; 4], ..Traced::NOTHING }
    }
}

/// Visits the present samples of blocks that can contribute, with their length in steps; the
/// visitor says whether the sample added anything.
fn each_visible<R: Reconstruct>(
    probe: &Probe<R>,
    skip: Option<&SkipGrid>,
    span: &Span,
    lattice: &Lattice,
    tally: &mut Tally,
    mut visit: impl FnMut(f64, f64) -> bool,
) {
    each_sample(skip, span, lattice, tally, |k, t, tally| {
        let value = probe.value(span.index_at(t));
        if !value.is_nan() && visit(value, lattice.ratio(k)) {
            tally.visible += 1;
        }
        false
    });
}
