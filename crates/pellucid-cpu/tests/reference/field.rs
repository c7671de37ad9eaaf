//! "What is the field here?", in f64.

use std::borrow::Cow;

use glam::DVec3;
use pellucid_field::{Filter, Gradient, Grid, SplineCell, Volume, index_gradient, spline_coefficients};
use pellucid_scene::{Region, Stage};

/// What the definition leaves to rounding. Where a picture jumps, as where a gradient's tap leaves
/// the volume, an engine that computes positions in f32 may be on either side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// Added to every index position, in voxels.
    pub shift: DVec3,
    /// How far outside the box or a clip a gradient's tap may be and still count, in voxels; and the
    /// plane of a slice, in steps.
    pub slack: f64,
}

/// The field of a stage's only volume.
pub struct Field<'a> {
    /// What the filter weighs: the volume, or its spline coefficients.
    volume: Cow<'a, Volume>,
    component: usize,
    filter: Filter,
    gradient: Gradient,
    region: &'a Region,
    /// How it is read.
    pub reading: Reading,
    /// Largest difference of two values.
    range: f64,
}

impl<'a> Field<'a> {
    /// The field as the stage reconstructs it.
    pub fn new(stage: &'a Stage, reading: Reading) -> Self {
        let staged = &stage.volumes[0];
        let volume = &*staged.volume;
        let statistics = volume.statistics();
        let (volume, component) = match stage.quality.filter {
            Filter::BSpline { prefilter: true } => {
                (Cow::Owned(spline_coefficients(volume, staged.component).unwrap()), 0)
            }
            _ => (Cow::Borrowed(volume), staged.component),
        };
        Self {
            volume,
            component,
            filter: stage.quality.filter,
            gradient: stage.quality.gradient,
            region: &staged.region,
            reading,
            range: statistics.max - statistics.min,
        }
    }

    fn grid(&self) -> &Grid {
        self.volume.grid()
    }

    /// The largest difference of two values of the field.
    pub fn range(&self) -> f64 {
        self.range
    }

    /// The index position of a world point, in the box.
    pub fn index(&self, world: DVec3) -> DVec3 {
        let (low, high) = self.grid().index_bounds();
        (self.grid().index_from_world().transform_point3(world) + self.reading.shift).max(low).min(high)
    }

    /// The voxels that count at a position along an axis, with their weights; those over the border
    /// are the border voxel again.
    pub fn taps(&self, axis: usize, x: f64) -> Vec<(usize, f64)> {
        let last = (self.grid().dims()[axis] - 1) as f64;
        let x = x.clamp(0.0, last);
        let weights = match self.filter {
            Filter::Linear => vec![1.0 - x.fract(), x.fract()],
            wide => wide.weights(x.fract()).to_vec(),
        };
        let first = x.floor() + 1.0 - (weights.len() / 2) as f64;
        let voxel = |i: usize| (first + i as f64).clamp(0.0, last) as usize;
        weights.iter().enumerate().map(|(i, &weight)| (voxel(i), weight)).collect()
    }

    /// The data value of a voxel.
    pub fn voxel(&self, voxel: [usize; 3]) -> f64 {
        self.volume.value(voxel, self.component)
    }

    /// The value at an index position of the box; NaN where the nearest voxel is absent. Other
    /// absent voxels have the value of the nearest one.
    pub fn value(&self, p: DVec3) -> f64 {
        let dims = self.grid().dims();
        let nearest = self.voxel([0, 1, 2].map(|axis| ((p[axis] + 0.5).max(0.0) as usize).min(dims[axis] - 1)));
        if !nearest.is_finite() {
            return f64::NAN;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| self.taps(axis, p[axis]));
        // Summed about the nearest value, so that a flat field is flat to the bit.
        let mut sum = 0.0;
        for (k, wz) in &z {
            for (j, wy) in &y {
                for (i, wx) in &x {
                    let value = self.voxel([*i, *j, *k]);
                    sum += wx * wy * wz * if value.is_finite() { value - nearest } else { 0.0 };
                }
            }
        }
        nearest + sum
    }

    /// The value at an index position, NaN outside the box and the clips by more than the slack.
    fn tap(&self, p: DVec3) -> f64 {
        let (low, high) = self.grid().index_bounds();
        let slack = self.reading.slack + 1e-6;
        let inside = p.cmpge(low - slack).all() && p.cmple(high + slack).all();
        let affine = self.grid().world_from_index();
        let kept = self.region.half_spaces().iter().all(|(normal, offset)| {
            let index_slope = (affine.matrix3.transpose() * *normal).length();
            normal.dot(affine.transform_point3(p)) - offset >= -self.reading.slack * index_slope
        });
        if inside && kept { self.value(p.max(low).min(high)) } else { f64::NAN }
    }

    /// The gradient in data units per world unit, with `center` the value at the position. A tap
    /// that is absent is the point reflection of its opposite.
    pub fn gradient(&self, p: DVec3, center: f64) -> DVec3 {
        if !center.is_finite() {
            return DVec3::ZERO;
        }
        let slope = |axis: DVec3| {
            let (right, left) = (self.tap(p + axis), self.tap(p - axis));
            match (right.is_finite(), left.is_finite()) {
                (true, true) => (right - left) / 2.0,
                (true, false) => right - center,
                (false, true) => center - left,
                (false, false) => 0.0,
            }
        };
        let central = || DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        let index_gradient = match self.gradient {
            Gradient::Central => central(),
            // Of the voxels themselves, whatever the filter.
            Gradient::BSpline => {
                let voxel = |q: DVec3| {
                    if self.tap(q).is_nan() { f64::NAN } else { self.voxel(q.to_array().map(|x| x as usize)) }
                };
                SplineCell::gather(p, voxel).map_or_else(central, |cell| cell.gradient())
            }
            kind => index_gradient(kind, p, center, |p| self.tap(p)),
        };
        self.grid().index_from_world().matrix3.transpose() * index_gradient
    }

    /// Gradients that rounding cannot tell from this one at a position: a little longer and shorter along every axis;
    /// and in a flat place, one beside it, where the end of what a sum of voxels sees passes by, and rounding decides
    /// whether there is a slope at all, of whatever direction. Samples of one ray may be rounded to different sides,
    /// which no single [`Reading`] says.
    pub fn doubtful_gradients(&self, p: DVec3, center: f64, gradient: DVec3) -> Vec<DVec3> {
        /// Voxels.
        const ASIDE: f64 = 1e-5;
        /// What single precision makes of differences of two values and of sums of hundreds, in ranges of values.
        const ROUNDING: [f64; 2] = [2e-6, 6e-6];
        let corners =
            (0..8).map(|bits| DVec3::from_array([0, 1, 2].map(|axis| f64::from(bits >> axis & 1) * 2.0 - 1.0)));
        let world_from_index_gradient = self.grid().index_from_world().matrix3.transpose();
        let is_wide = self.filter != Filter::Linear || self.gradient != Gradient::Central;
        let rounding = ROUNDING[usize::from(is_wide)] * self.range * world_from_index_gradient;
        let rounded = corners.clone().map(|corner| gradient + rounding * corner);
        let index_gradient = self.grid().world_from_index().matrix3.transpose() * gradient;
        if !is_wide || index_gradient.length() > 1e-6 * self.range {
            return rounded.collect();
        }
        let beside = corners.map(|corner| self.gradient(p + corner * ASIDE, center));
        let far = beside.max_by(|a, b| a.length().total_cmp(&b.length())).filter(|beside| *beside != gradient);
        rounded.chain(far).collect()
    }

    /// The unit normal towards lower values of a gradient in the world, zero where the field is flat; `None` where the
    /// gradient is too short for its direction to be more than rounding.
    pub fn normal_of(&self, gradient: DVec3) -> Option<DVec3> {
        let index_gradient = self.grid().world_from_index().matrix3.transpose() * gradient;
        let certain = gradient == DVec3::ZERO || index_gradient.length() > 2e-3 * self.range;
        certain.then(|| -gradient.try_normalize().unwrap_or(DVec3::ZERO))
    }

    /// Whether values are interpolated between eight voxels.
    pub fn is_trilinear(&self) -> bool {
        self.filter == Filter::Linear
    }

    /// Whether the nearest voxel is the value.
    pub fn is_of_nearest_voxels(&self) -> bool {
        self.filter == Filter::Nearest
    }

    /// Whether some voxels are absent.
    pub fn has_holes(&self) -> bool {
        let statistics = self.volume.statistics();
        statistics.nan + statistics.infinite > 0
    }
}
