//! Fields under wide filters and every gradient, on lanes (1.5-9, 5.3-6).

use pellucid_field::{ComponentView, Filter, Gradient, Kernel, Sampler};

use super::cube::Cubes;
use super::general::{gradient_of_each, value_of_each};
use super::knots::{course_sampled, highest_sampled};
use super::taps::Bounds;
use super::{Corners, Course, Field, Knots, Probe, Texel, Trilinear};
use crate::lanes::*;

/// A volume of voxels of type `T` under a filter and a gradient estimator whose weights are products
/// of one per axis.
///
/// Lanes that meet an absent voxel are asked again one by one, and so are gradients that reach over
/// a border or a clip.
pub struct Separable<'a, T> {
    voxels: Cubes<'a, T>,
    values: Reading<'a, T>,
    knots: Knots,
    /// Across an axis and along it.
    gradient: [Kernel; 2],
    /// Whether gradients are those at the nearest voxel.
    rounded: bool,
    scale: f32,
    offset: f32,
    bounds: Bounds,
    /// From differences of stored numbers per index step to data units per world unit.
    gradient_map: [[f32; 3]; 3],
    exact: Probe<'a, Sampler<'a>>,
}

/// How values are made of voxels.
enum Reading<'a, T> {
    Nearest,
    Linear(Box<Trilinear<'a, T>>),
    Sum(Kernel),
}

impl<'a, T: Texel> Separable<'a, T> {
    /// The field of a component that `exact` answers for, with the trilinear field of the same voxels;
    /// `None` if it cannot be read with vectors, or if the sums are wider than the grid or
    /// [`MOST_TAPS`](super::kernel::MOST_TAPS).
    pub fn new(
        view: ComponentView<'a, T>,
        bounds: Bounds,
        gradient: Gradient,
        trilinear: Trilinear<'a, T>,
        knots: Knots,
        exact: Probe<'a, Sampler<'a>>,
    ) -> Option<Self> {
        let (filter, voxels) = (exact.field().filter(), Cubes::new(&view)?);
        let values = match filter {
            Filter::Nearest => Reading::Nearest,
            Filter::Linear => Reading::Linear(Box::new(trilinear)),
            _ => Reading::Sum(Kernel::of_filter(filter).filter(|kernel| voxels.hold(kernel.taps()))?),
        };
        let kernels = Kernel::of_gradient(filter, gradient);
        if !voxels.hold(kernels[0].taps()) {
            return None;
        }
        let map = view.value_map();
        let matrix = (exact.world_from_index_gradient() * map.scale).as_mat3().transpose();
        Some(Self {
            voxels,
            values,
            knots,
            gradient: kernels,
            rounded: filter == Filter::Nearest && gradient != Gradient::BSpline,
            scale: map.scale as f32,
            offset: map.offset as f32,
            bounds,
            gradient_map: matrix.to_cols_array_2d(),
            exact,
        })
    }
}

impl<S: Lanes, T: Texel> Field<S> for Separable<'_, T> {
    #[inline(always)]
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        let stored = match &self.values {
            Reading::Linear(field) => return field.values(s, index, lanes),
            Reading::Nearest => self.voxels.nearest(s, &index),
            Reading::Sum(kernel) => self.voxels.sum(s, &index, kernel),
        };
        let value = stored.mul_add(splat(s, self.scale), splat(s, self.offset));
        if !T::TYPE.is_integer() {
            let holes = lanes & !stored.is_finite();
            if holes.any_true() {
                return holes.select(value_of_each(s, &self.exact, index, holes), value);
            }
        }
        value
    }

    #[inline(always)]
    fn corners(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Option<Corners<S>> {
        match &self.values {
            Reading::Linear(field) => field.corners(s, index, lanes),
            _ => None,
        }
    }

    #[inline(always)]
    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        let taps = self.gradient[0].taps();
        let mut inside = lanes & self.voxels.surround(s, &index, taps);
        if !self.bounds.is_box() {
            inside &= self.bounds.surround(s, &index, (taps / 2) as f32);
        }
        let mut found = [splat(s, 0.0); 3];
        if inside.any_true() {
            let position = if self.rounded { xyz!(I => (index[I] + 0.5).floor()) } else { index };
            let slopes = self.voxels.gradient(s, &position, &self.gradient);
            let matrix = &self.gradient_map;
            found = xyz!(I => dot::<S>(xyz!(J => splat(s, matrix[I][J])), slopes));
            inside &= (found[0] + found[1] + found[2]).is_finite();
        }
        let others = lanes & !inside;
        if others.any_true() {
            let exact = gradient_of_each(s, &self.exact, index, others);
            found = xyz!(I => others.select(exact[I], found[I]));
        }
        found
    }

    #[inline(always)]
    fn prefetch(&self, s: S, index: Vec3<S>) {
        if let Reading::Linear(field) = &self.values {
            field.prefetch(s, index);
        }
    }

    fn knots(&self) -> Knots {
        self.knots
    }

    #[inline(always)]
    fn highest(&self, s: S, piece: &[Vec3<S>; 2], sign: f32, above: F32<S>, lanes: Mask<S>) -> [F32<S>; 2] {
        match &self.values {
            Reading::Linear(field) => field.highest(s, piece, sign, above, lanes),
            Reading::Nearest | Reading::Sum(_) => highest_sampled(s, self, piece, sign, lanes),
        }
    }

    #[inline(always)]
    fn course(&self, s: S, piece: &[Vec3<S>; 2], range: [F32<S>; 2], lanes: Mask<S>) -> Course<S> {
        match &self.values {
            Reading::Linear(field) => field.course(s, piece, range, lanes),
            Reading::Nearest | Reading::Sum(_) => course_sampled(s, self, piece, lanes),
        }
    }
}
