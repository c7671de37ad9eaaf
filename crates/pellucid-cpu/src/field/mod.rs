//! "What is the field here?": one answer for samples, gradients and surfaces, for all lanes.

mod cube;
mod cubic;
mod displaced;
mod general;
mod kernel;
mod knots;
mod probe;
mod separable;
mod taps;
mod trilinear;
mod turbulence;
mod voxel;
mod word;

pub use cubic::{Course, Cubic};
pub use displaced::{Displaced, Moved};
pub use general::{Any, Entered, General, lane_position};
pub use knots::Knots;
pub use probe::Probe;
pub use separable::Separable;
pub use taps::Bounds;
pub use trilinear::Trilinear;
pub use turbulence::turbulence;
pub use voxel::{Quad, Texel};
pub use word::fits;

use crate::lanes::*;

/// What was read for values that gradients at the same positions can use.
pub struct Near<S: Lanes> {
    index: Vec3<S>,
    /// The values.
    value: F32<S>,
    /// The rows of the cell at (y, z), each with the voxel before and after; see [`Texel::quad`].
    rows: Option<[Quad<S>; 4]>,
}

/// The voxels at the corners of cells.
pub struct Corners<S: Lanes> {
    /// Data values, x fastest.
    pub values: [F32<S>; 8],
    /// Positions within the cells.
    pub u: Vec3<S>,
}

/// A reconstructed field inside its clip region; what is clipped is absent.
pub trait Field<S: Lanes>: Sync {
    /// Data values at index positions inside the region, NaN where absent. Positions are finite;
    /// those outside the grid's box are moved to its border. Positions on a ray's span are inside
    /// by construction, so no clip is asked here. What the lanes without a `true` give is not
    /// specified.
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S>;

    /// Asks for the voxels around index positions that will be looked at soon.
    #[inline(always)]
    fn prefetch(&self, _: S, _: Vec3<S>) {}

    /// Gradients in data units per world unit, one-sided beside whatever is absent or clipped. What
    /// the lanes without a `true` give is not specified.
    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S>;

    /// The eight voxels that samples lie between, x fastest, as data values, and where between them; `None` if the field
    /// is not made of these alone. Absent voxels are NaN.
    #[inline(always)]
    fn corners(&self, _: S, _: Vec3<S>, _: Mask<S>) -> Option<Corners<S>> {
        None
    }

    /// As [`values`](Field::values), where [gradients](Field::gradients_near) are likely to be asked
    /// for next.
    #[inline(always)]
    fn values_near(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> (F32<S>, Near<S>) {
        let value = self.values(s, index, lanes);
        (value, Near { index, value, rows: None })
    }

    /// As [`gradients`](Field::gradients) at the positions of values, for the same lanes or fewer.
    #[inline(always)]
    fn gradients_near(&self, s: S, near: &Near<S>, lanes: Mask<S>) -> Vec3<S> {
        self.gradients(s, near.index, lanes)
    }

    /// The planes between which the field is smooth along any ray.
    fn knots(&self) -> Knots;

    /// The largest of the values on pieces of rays, each between two index positions with no [knot](Field::knots)
    /// between them, and which part of the way it is on: of all values times `sign`, which is 1 or -1. Negative
    /// infinity where none is present or, possibly, where none is more than `above`.
    #[inline(always)]
    fn highest(&self, s: S, piece: &[Vec3<S>; 2], sign: f32, _above: F32<S>, lanes: Mask<S>) -> [F32<S>; 2] {
        knots::highest_sampled(s, self, piece, sign, lanes)
    }

    /// The cubic that the field is on such a piece, at least where any of its values lies within a range, ends included. Of
    /// [trilinear](pellucid_scene::Stage::is_trilinear) fields, which are cubics there (5.5-8, G-03).
    #[inline(always)]
    fn course(&self, s: S, piece: &[Vec3<S>; 2], _range: [F32<S>; 2], lanes: Mask<S>) -> Course<S> {
        knots::course_sampled(s, self, piece, lanes)
    }
}
