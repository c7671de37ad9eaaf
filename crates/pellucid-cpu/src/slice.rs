//! A plane through the volume, at any orientation.

use glam::DVec3;
use pellucid_field::Reconstruct;
use pellucid_optics::Table;

use crate::integrator::{Integrator, Tally, Traced};
use crate::lattice::Lattice;
use crate::probe::Probe;
use crate::projection::classified;
use crate::span::Span;

/// The field on a plane, coloured at full opacity. (A slab of some thickness is a projection over
/// a span between two planes.)
pub struct Plane<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// The transfer function.
    pub table: &'a Table,
    /// A world position on the plane.
    pub point: DVec3,
    /// Unit normal of the plane.
    pub normal: DVec3,
}

impl<R: Reconstruct> Integrator for Plane<'_, R> {
    fn trace(&self, span: &Span, _: &Lattice, tally: &mut Tally) -> Traced {
        let t = (self.point - span.ray.origin).dot(self.normal) / span.ray.direction.dot(self.normal);
        // Also false for the NaN and infinity of a ray along the plane.
        if !(t >= span.entry && t <= span.exit) {
            return Traced::NOTHING;
        }
        tally.samples += 1;
        let value = self.probe.value(span.index_at(t));
        Traced { normal: self.normal, ..classified(self.table, value, t, true, tally) }
    }
}
