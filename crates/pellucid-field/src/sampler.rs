//! Reconstruction: the value of a volume between its voxels.
//!
//! [`Nearest`], [`Linear`] and [`Wide`] are concrete types for inner loops, all of them a
//! [`Reconstruct`] over a typed [`ComponentView`]. [`Sampler`] chooses among them at run time, and
//! [`with_reconstruction!`](crate::with_reconstruction) hands its choice to generic code.
//!
//! One set of rules holds for all:
//!
//! - A position outside the grid's box (by more than 1e-6 voxels) has no value: NaN. Inside,
//!   kernels that reach over the border meet the border voxel again.
//! - A sample whose nearest voxel is absent is absent. Any other sample sees the value of its
//!   nearest voxel wherever its kernel meets an absent one, so that holes neither grow nor leak.
//! - At a voxel, an interpolating filter returns that voxel, bit for bit.

use std::borrow::Cow;

use glam::DVec3;

use crate::filter::Cubic;
use crate::gradient::{self, Gradient, SplineCell};
use crate::{FieldError, Filter, ValueMap, Volume, Voxel, prefilter};

/// How far outside the box a position may be, in voxels: the rounding of affines and ray
/// parameters must not cut off the last sample of a ray.
const TOLERANCE: f64 = 1e-6;

/// A continuous scalar field over a grid.
pub trait Reconstruct: Sync {
    /// The data value at a continuous index position (voxel (i, j, k) is the sample at (i, j, k)),
    /// or NaN where the field is absent.
    fn value(&self, index: DVec3) -> f64;

    /// The 4x4x4 voxels around a position for derivatives of their cubic B-spline, or `None` if
    /// not all of them exist and are finite.
    fn spline(&self, index: DVec3) -> Option<SplineCell>;

    /// The gradient per index step, where `center` is the (finite) value there. For
    /// [`Gradient::BSpline`] this reads voxels, where [`gradient::index_gradient`] has to sample.
    fn gradient(&self, kind: Gradient, index: DVec3, center: f64) -> DVec3 {
        if kind == Gradient::BSpline {
            if let Some(cell) = self.spline(index) {
                return cell.gradient();
            }
            return gradient::index_gradient(Gradient::Central, index, center, |p| self.value(p));
        }
        gradient::index_gradient(kind, index, center, |p| self.value(p))
    }
}

impl<R: Reconstruct + ?Sized> Reconstruct for &R {
    #[inline]
    fn value(&self, index: DVec3) -> f64 {
        (**self).value(index)
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        (**self).spline(index)
    }
}

/// One component of a volume as an array of numbers of type `T`.
#[derive(Clone, Copy, Debug)]
pub struct ComponentView<'a, T> {
    data: &'a [T],
    dims: [usize; 3],
    stride: [usize; 3],
    low: DVec3,
    high: DVec3,
    last: DVec3,
    map: ValueMap,
}

impl<'a, T: Voxel> ComponentView<'a, T> {
    /// Component `component` of `volume`, whose typed voxels are `data`.
    ///
    /// # Panics
    /// If `data` does not have the volume's length or it has no such component.
    pub fn new(volume: &Volume, data: &'a [T], component: usize) -> Self {
        let (grid, components) = (volume.grid(), volume.components());
        assert!(data.len() == volume.voxels().len() && component < components);
        let dims = grid.dims();
        let (low, high) = grid.index_bounds();
        Self {
            data: &data[component..],
            dims,
            stride: [components, components * dims[0], components * dims[0] * dims[1]],
            low: low - TOLERANCE,
            high: high + TOLERANCE,
            last: DVec3::from_array(dims.map(|n| (n - 1) as f64)),
            map: volume.value_map(),
        }
    }

    /// The numbers, from the component's first on.
    pub fn data(&self) -> &'a [T] {
        self.data
    }

    /// Voxels per axis.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Distance in [`ComponentView::data`] of neighbours along each axis.
    pub fn stride(&self) -> [usize; 3] {
        self.stride
    }

    /// From stored numbers to data values.
    pub fn value_map(&self) -> ValueMap {
        self.map
    }

    /// The position within the grid that stands for `index`, or `None` outside the box.
    #[inline(always)]
    fn locate(&self, index: DVec3) -> Option<DVec3> {
        let inside = index.cmpge(self.low).all() && index.cmple(self.high).all();
        inside.then(|| index.max(DVec3::ZERO).min(self.last))
    }

    #[inline(always)]
    fn stored(&self, offset: usize) -> f64 {
        self.data[offset].to_f64()
    }

    /// The stored number of the voxel nearest to a located position; not finite if absent.
    #[inline(always)]
    fn nearest(&self, p: DVec3) -> f64 {
        let offset: usize = (0..3).map(|axis| split(p[axis] + 0.5).0 * self.stride[axis]).sum();
        self.stored(offset)
    }

    /// The data value of a blend of stored numbers that met an absent one: `blend`, given what
    /// reads a number, is run again with the nearest voxel in place of those. Finite data never
    /// pays for holes.
    #[cold]
    #[inline(never)]
    fn repaired(&self, p: DVec3, blend: impl Fn(&dyn Fn(usize) -> f64) -> f64) -> f64 {
        let nearest = self.nearest(p);
        if !nearest.is_finite() {
            return f64::NAN;
        }
        let present = |offset| Some(self.stored(offset)).filter(|v| v.is_finite()).unwrap_or(nearest);
        self.map.value(blend(&present))
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        SplineCell::gather(index, |voxel| {
            let inside = (0..3).all(|axis| voxel[axis] >= 0.0 && voxel[axis] <= self.last[axis]);
            if inside { self.map.value(self.nearest(voxel)) } else { f64::NAN }
        })
    }
}

/// [`Filter::Nearest`] over voxels of type `T`.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<'a, T>(pub ComponentView<'a, T>);

impl<T: Voxel> Reconstruct for Nearest<'_, T> {
    #[inline]
    fn value(&self, index: DVec3) -> f64 {
        let value = self.0.locate(index).map_or(f64::NAN, |p| self.0.nearest(p));
        if value.is_finite() { self.0.map.value(value) } else { f64::NAN }
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        self.0.spline(index)
    }
}

/// [`Filter::Linear`] over voxels of type `T`: seven lerps (1.5-10).
#[derive(Clone, Copy, Debug)]
pub struct Linear<'a, T>(pub ComponentView<'a, T>);

impl<T: Voxel> Reconstruct for Linear<'_, T> {
    #[inline]
    fn value(&self, index: DVec3) -> f64 {
        let view = &self.0;
        let Some(p) = view.locate(index) else { return f64::NAN };
        let [x, y, z] = [split(p.x), split(p.y), split(p.z)];
        let (cell, u) = ([x.0, y.0, z.0], DVec3::new(x.1, y.1, z.1));
        // At the last voxel of an axis u is 0 and the right neighbour is the voxel itself.
        let step: [usize; 3] =
            std::array::from_fn(|axis| if cell[axis] + 1 < view.dims[axis] { view.stride[axis] } else { 0 });
        let base: usize = (0..3).map(|axis| cell[axis] * view.stride[axis]).sum();
        let fast = trilinear(base, step, u, |offset| view.stored(offset));
        if fast.is_finite() {
            return view.map.value(fast);
        }
        view.repaired(p, |present| trilinear(base, step, u, present))
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        self.0.spline(index)
    }
}

/// The voxel to the left of a coordinate that is not negative, and the fraction of the way to the
/// next one. By way of a signed number, which processors convert faster than an unsigned one.
#[inline(always)]
fn split(x: f64) -> (usize, f64) {
    let cell = x as i64;
    (cell as usize, x - cell as f64)
}

/// Seven lerps: along x, then y, then z.
#[inline(always)]
fn trilinear(base: usize, [dx, dy, dz]: [usize; 3], u: DVec3, at: impl Fn(usize) -> f64) -> f64 {
    let x00 = lerp(u.x, at(base), at(base + dx));
    let x10 = lerp(u.x, at(base + dy), at(base + dy + dx));
    let x01 = lerp(u.x, at(base + dz), at(base + dz + dx));
    let x11 = lerp(u.x, at(base + dz + dy), at(base + dz + dy + dx));
    lerp(u.z, lerp(u.y, x00, x10), lerp(u.y, x01, x11))
}

/// `a + u (b - a)`: exactly `a` at `u = 0`, and not finite if either end is not.
#[inline(always)]
fn lerp(u: f64, a: f64, b: f64) -> f64 {
    a + u * (b - a)
}

/// Every wider filter over voxels of type `T`: the sum over the tensor product of its weights
/// (1.5-9, 9.2-4).
#[derive(Clone, Copy, Debug)]
pub struct Wide<'a, T> {
    view: ComponentView<'a, T>,
    filter: Filter,
    cubic: Option<Cubic>,
}

/// Offset into the data and weight of a tap along one axis.
type Tap = (usize, f64);

impl<'a, T: Voxel> Wide<'a, T> {
    /// The field of any filter. A [`Filter::BSpline`] takes the voxels for its coefficients
    /// whatever its `prefilter` says.
    pub fn new(view: ComponentView<'a, T>, filter: Filter) -> Self {
        Self { view, filter, cubic: filter.cubic() }
    }

    /// The taps along one axis with the weights at a fraction, clamped to the grid.
    #[inline(always)]
    fn taps<const N: usize>(&self, axis: usize, x: f64, half: usize, weight: impl Fn(f64) -> [f64; N]) -> [Tap; N] {
        let (cell, u) = split(x);
        let weights = weight(u);
        let (last, stride) = (self.view.dims[axis] - 1, self.view.stride[axis]);
        std::array::from_fn(|i| (((cell + 1 + i).saturating_sub(half)).min(last) * stride, weights[i]))
    }

    #[inline(always)]
    fn blend(&self, p: DVec3, x: &[Tap], y: &[Tap], z: &[Tap]) -> f64 {
        let fast = tensor_sum(x, y, z, |offset| self.view.stored(offset));
        if fast.is_finite() {
            return self.view.map.value(fast);
        }
        self.view.repaired(p, |present| tensor_sum(x, y, z, present))
    }
}

#[inline(always)]
fn tensor_sum(x: &[Tap], y: &[Tap], z: &[Tap], at: impl Fn(usize) -> f64) -> f64 {
    let row = |offset: usize| x.iter().map(|&(dx, w)| w * at(offset + dx)).sum::<f64>();
    let slice = |offset: usize| y.iter().map(|&(dy, w)| w * row(offset + dy)).sum::<f64>();
    z.iter().map(|&(dz, w)| w * slice(dz)).sum()
}

impl<T: Voxel> Reconstruct for Wide<'_, T> {
    #[inline]
    fn value(&self, index: DVec3) -> f64 {
        let Some(p) = self.view.locate(index) else { return f64::NAN };
        let half = self.filter.half_width();
        if let Some(cubic) = self.cubic {
            let [x, y, z] = std::array::from_fn(|axis| self.taps(axis, p[axis], 2, |u| cubic.weights(u)));
            self.blend(p, &x, &y, &z)
        } else {
            let [x, y, z] =
                std::array::from_fn(|axis| self.taps(axis, p[axis], half, |u| self.filter.weights(u).padded()));
            self.blend(p, &x[..2 * half], &y[..2 * half], &z[..2 * half])
        }
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        self.view.spline(index)
    }
}

/// A field whose voxel type and filter are chosen at run time, for work outside inner loops; those
/// get the concrete type from [`with_reconstruction!`](crate::with_reconstruction).
#[derive(Clone, Debug)]
pub struct Sampler<'a> {
    source: Cow<'a, Volume>,
    component: usize,
    filter: Filter,
}

impl<'a> Sampler<'a> {
    /// Component `component` of a volume under a filter. With [`Filter::BSpline`]'s `prefilter`
    /// the coefficients are computed here and kept; a renderer that makes a sampler per frame
    /// computes them once with [`spline_coefficients`](crate::spline_coefficients) and samples
    /// those under `BSpline { prefilter: false }`.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if the filter's parameters are out of range or there is no such
    /// component.
    pub fn new(volume: &'a Volume, component: usize, filter: Filter) -> Result<Self, FieldError> {
        filter.validate()?;
        volume.check_component(component)?;
        if filter == (Filter::BSpline { prefilter: true }) {
            let source = Cow::Owned(prefilter::spline_coefficients(volume, component)?);
            return Ok(Self { source, component: 0, filter });
        }
        Ok(Self { source: Cow::Borrowed(volume), component, filter })
    }

    /// The volume whose numbers are weighted: the sampled one, or its spline coefficients.
    pub fn source(&self) -> &Volume {
        &self.source
    }

    /// The component of [`Sampler::source`] that is sampled.
    pub fn component(&self) -> usize {
        self.component
    }

    /// The filter.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// The data value at a continuous index position, or NaN where the field is absent.
    pub fn value(&self, index: DVec3) -> f64 {
        crate::with_reconstruction!(self, field => field.value(index))
    }

    /// The data value at a position in the world, or NaN where the field is absent.
    pub fn value_world(&self, position: DVec3) -> f64 {
        self.value(self.source.grid().index_from_world().transform_point3(position))
    }
}

impl Reconstruct for Sampler<'_> {
    fn value(&self, index: DVec3) -> f64 {
        self.value(index)
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        crate::with_reconstruction!(self, field => field.spline(index))
    }
}

/// Runs an expression with the concrete field of a [`Sampler`]:
/// `with_reconstruction!(&sampler, field => expr)`, where `field` is a [`Reconstruct`] of whichever
/// type suits its voxels and filter. The expression is compiled once per type: let it be a call of
/// a generic function.
#[macro_export]
macro_rules! with_reconstruction {
    ($sampler:expr, $field:ident => $body:expr) => {{
        let sampler: &$crate::Sampler<'_> = $sampler;
        $crate::for_voxels!(sampler.source().voxels(), data => {
            let view = $crate::ComponentView::new(sampler.source(), data, sampler.component());
            match sampler.filter() {
                $crate::Filter::Nearest => {
                    let $field = $crate::Nearest(view);
                    $body
                }
                $crate::Filter::Linear => {
                    let $field = $crate::Linear(view);
                    $body
                }
                filter => {
                    let $field = $crate::Wide::new(view, filter);
                    $body
                }
            }
        })
    }};
}
