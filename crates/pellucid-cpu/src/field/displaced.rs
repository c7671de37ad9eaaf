//! A field whose values come from beside where they are drawn (K-24).

use glam::{DMat3, DVec3};
use pellucid_field::{Gradient, Reconstruct, Sampler, SplineCell, index_gradient};
use pellucid_optics::Displacer;

use super::turbulence::turbulence;
use super::{Bounds, Corners, Field, Knots, Near};
use crate::lanes::*;

/// Another field, displaced. Values are asked at one's own position for whether it is clipped, and at the
/// displaced one for what is there.
pub struct Displaced<'a, F> {
    inner: F,
    displacer: &'a Displacer,
    bounds: Bounds,
    /// Turns a gradient per index step into one per world unit.
    world_from_index_gradient: [[f32; 3]; 3],
}

impl<'a, F> Displaced<'a, F> {
    /// A field, displaced inside its bounds.
    pub fn new(inner: F, displacer: &'a Displacer, bounds: Bounds, world_from_index_gradient: DMat3) -> Self {
        let world_from_index_gradient = world_from_index_gradient.as_mat3().to_cols_array_2d();
        Self { inner, displacer, bounds, world_from_index_gradient }
    }

    /// Where values come from: the vectors' form of [`Displacer::source`].
    #[inline(always)]
    fn source<S: Lanes>(&self, s: S, index: &Vec3<S>, lanes: Mask<S>) -> Vec3<S>
    where
        F: Field<S>,
    {
        let (zero, one, by) = (splat(s, 0.0), splat(s, 1.0), self.displacer);
        let mut part = one;
        if let Some([none, full]) = by.between {
            let value = self.inner.values(s, *index, lanes);
            let t = (value - none) / (full - none);
            let t = value.is_finite().select(t, zero).max(zero).min(one);
            part = t * t * (splat(s, 3.0) - t * 2.0);
            if !(lanes & part.simd_gt(zero)).any_true() {
                return *index;
            }
        }
        let noise = turbulence::<S, 3>(s, by.turbulence(), index);
        xyz!(I => {
            let p = index[I];
            let room = (p - by.low[I]).min(splat(s, by.high[I]) - p).max(zero) / by.reach[I];
            (part * room.min(one) * by.amplitude[I]).mul_add(noise[I], p)
        })
    }
}

impl<S: Lanes, F: Field<S>> Field<S> for Displaced<'_, F> {
    #[inline(always)]
    fn values(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> F32<S> {
        let source = self.source(s, &index, lanes);
        self.inner.values(s, source, lanes)
    }

    #[inline(always)]
    fn corners(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Option<Corners<S>> {
        self.inner.corners(s, self.source(s, &index, lanes), lanes)
    }

    #[inline(always)]
    fn gradients(&self, s: S, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        let (_, near) = self.values_near(s, index, lanes);
        self.gradients_near(s, &near, lanes)
    }

    #[inline(always)]
    fn prefetch(&self, s: S, index: Vec3<S>) {
        self.inner.prefetch(s, index);
    }

    /// Noise moves what is drawn by less than it bends on the way between two voxels.
    fn knots(&self) -> Knots {
        Knots::VOXELS
    }

    #[inline(always)]
    fn gradients_near(&self, s: S, near: &Near<S>, lanes: Mask<S>) -> Vec3<S> {
        let zero = splat(s, 0.0);
        let Near { index, value: center, .. } = *near;
        let lanes = lanes & center.is_finite();
        let mut gradient = [zero; 3];
        if !lanes.any_true() {
            return gradient;
        }
        for (axis, slope) in gradient.iter_mut().enumerate() {
            let step = self.displacer.spacing[axis];
            let (mut before, mut after) = (index, index);
            before[axis] -= step;
            after[axis] += step;
            let [left, right] = [before, after].map(
                #[inline(always)]
                |p| {
                    let there = lanes & self.bounds.contain(s, &p);
                    let value = self.values(s, p, there);
                    (value, there & value.is_finite())
                },
            );
            // An absent tap is the point reflection of its opposite.
            let up = right.1.select(right.0 - center, zero);
            let down = left.1.select(center - left.0, up);
            let up = right.1.select(up, down);
            *slope = (up + down) * (0.5 / step);
        }
        let [x, y, z] = &self.world_from_index_gradient;
        xyz!(I => lanes.select(gradient[0] * x[I] + gradient[1] * y[I] + gradient[2] * z[I], zero))
    }
}

/// The field at one position in f64, displaced if there is a displacement.
pub struct Moved<'a> {
    /// The field that is displaced.
    pub sampler: Sampler<'a>,
    /// What moves it.
    pub displacer: Option<&'a Displacer>,
}

impl Moved<'_> {
    /// Where what is drawn at a position comes from.
    pub fn source(&self, index: DVec3) -> DVec3 {
        let Some(displacer) = self.displacer else { return index };
        let source = displacer.source(index.as_vec3().to_array(), || self.sampler.value(index) as f32);
        DVec3::from_array(source.map(f64::from))
    }
}

impl Reconstruct for Moved<'_> {
    fn value(&self, index: DVec3) -> f64 {
        self.sampler.value(self.source(index))
    }

    fn spline(&self, index: DVec3) -> Option<SplineCell> {
        if self.displacer.is_some() { None } else { self.sampler.spline(index) }
    }

    fn gradient(&self, kind: Gradient, index: DVec3, center: f64) -> DVec3 {
        let Some(displacer) = self.displacer else { return self.sampler.gradient(kind, index, center) };
        let step = DVec3::from_array(displacer.spacing.map(f64::from));
        index_gradient(Gradient::Central, index / step, center, |p| self.value(p * step)) / step
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use pellucid_field::{Filter, Grid, Noise, Volume};
    use pellucid_optics::{Displacement, Octave, Perturbation};
    use pellucid_scene::Region;

    use super::*;
    use crate::field::{Any, Entered, General, Probe, lane_position};
    use crate::lanes::{InstructionSet, dispatch};

    fn check<S: Lanes>(s: S, volume: &Volume, region: &Region, displacer: &Displacer) {
        let (grid, sampler) = (volume.grid(), Sampler::new(volume, 0, Filter::Linear).unwrap());
        let plain: Any<S> =
            Box::new(Entered(General(Probe::new(sampler.clone(), grid, region, Gradient::Central), Knots::VOXELS)));
        let bounds = Bounds::new(grid, region);
        let field = Entered(Displaced::new(plain, displacer, bounds, grid.world_from_index_gradient()));
        let moved = Moved { sampler, displacer: Some(displacer) };
        let step = DVec3::from_array(displacer.spacing.map(f64::from));
        let probe = Probe::new(moved, grid, region, Gradient::Central).with_spacing(step);
        let share = |k: usize, root: f64| (k as f64 * root.sqrt()).fract() as f32;
        for k in 0..200 {
            let lane = |k: usize| [share(k, 2.0) * 16.0, share(k, 3.0) * 12.0, share(k, 5.0) * 9.0];
            let index = xyz!(I => F32::<S>::from_fn(s, |n| lane(16 * k + n)[I]));
            let values = field.values(s, index, all(s, true));
            let gradients = field.gradients(s, index, all(s, true));
            for n in 0..width::<S>() {
                let p = lane_position::<S>(&index, n);
                if !region.contains(grid.world_from_index().transform_point3(p)) {
                    continue;
                }
                // A tap that lies in the border but for a rounding is there for lanes, and absent in f64.
                let (low, high) = grid.index_bounds();
                let gaps = [p + step - high, p - step - low].map(|gap| gap.abs().min_element());
                if gaps[0].min(gaps[1]) < 2e-4 {
                    continue;
                }
                let (value, gradient) = (probe.value(p), probe.gradient(p));
                // Positions are rounded to 1e-6 of a voxel, and values change by up to 2 a voxel, gradients' taps
                // are 1/16 of a voxel apart at the least.
                assert!((f64::from(values[n]) - value).abs() < 2e-5, "{} and {value} at {p}", values[n]);
                let found = DVec3::from_array([0, 1, 2].map(|axis| f64::from(gradients[axis][n])));
                assert!((found - gradient).length() < 1e-3, "{found} and {gradient} at {p}");
            }
        }
    }

    /// Lanes compute what the statement in f64 says, on every instruction set, clipped or not.
    #[test]
    fn lanes_do_as_one_position_does() {
        let grid = Grid::with_spacing([17, 13, 10], [1.0, 1.5, 0.8], [1.0, 2.0, 3.0]).unwrap();
        let value = |i: usize| (i % 17) as f32 * 0.1 + ((i / 17) as f32 * 0.7).sin();
        let volume = Volume::new(grid, (0..17 * 13 * 10).map(value).collect::<Vec<f32>>()).unwrap();
        let mut clipped = Region::from_clips(&[]);
        clipped.keep(DVec3::new(1.0, 1.0, 0.5), DVec3::new(5.0, 7.0, 5.0));
        let noise = Arc::new(Noise::new(5));
        for between in [None, Some([1.5, -0.5])] {
            let octaves = vec![Octave::new(1.0, 1.0), Octave { offset: [0.3, -0.2, 0.9], ..Octave::new(3.0, -0.5) }];
            let displacement = Displacement { amplitude: 0.2, octaves, between };
            let perturbation = Perturbation { displacement, ..Perturbation::default() };
            let displacer = Displacer::new(&perturbation, &noise, &grid).unwrap();
            for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
                for region in [&Region::from_clips(&[]), &clipped] {
                    dispatch!(set, s => check(s, &volume, region, &displacer));
                }
            }
        }
    }
}
