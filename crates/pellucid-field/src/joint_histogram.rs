//! Two-dimensional histogram of value and gradient magnitude.

use glam::DVec3;
use rayon::prelude::*;

use crate::gradient::{Gradient, world_gradient};
use crate::{FieldError, Filter, Reconstruct, Sampler, Volume, parallel, thread_count, with_reconstruction};

/// How often voxels have a data value together with a gradient magnitude: material boundaries
/// appear as arches between the values of their two sides.
#[derive(Clone, Debug, PartialEq)]
pub struct JointHistogram {
    dims: [usize; 2],
    value_range: [f64; 2],
    largest_magnitude: f64,
    counts: Vec<u64>,
}

/// Value range and largest magnitude over some voxels.
type Extent = ([f64; 2], f64);

impl JointHistogram {
    /// The usual number of bins: 256 values by 256 magnitudes.
    pub const DEFAULT_DIMS: [usize; 2] = [256, 256];

    /// Counts the voxels of one component; absent ones are skipped. The bins divide the range of
    /// its finite values and the gradient magnitudes from 0 to the largest, in data units per world
    /// unit, with `gradient` taken at the voxels.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if there is no such component, if `dims` are not 1 to 65536 bins
    /// per axis, or as [`Gradient::validate`].
    pub fn new(volume: &Volume, component: usize, gradient: Gradient, dims: [usize; 2]) -> Result<Self, FieldError> {
        gradient.validate()?;
        if let Some(&found) = dims.iter().find(|n| !(1..=1 << 16).contains(*n)) {
            let expected = "must be 1 to 65536 bins";
            return Err(FieldError::Parameter { name: "histogram dims", found: found as f64, expected });
        }
        let sampler = Sampler::new(volume, component, Filter::Nearest)?;
        Ok(with_reconstruction!(&sampler, field => count(&field, volume, gradient, dims)))
    }

    /// Bins per axis: values, magnitudes.
    pub fn dims(&self) -> [usize; 2] {
        self.dims
    }

    /// Lower edge of the first and upper edge of the last value bin (both 0 without voxels).
    pub fn value_range(&self) -> [f64; 2] {
        self.value_range
    }

    /// Upper edge of the last magnitude bin; the first begins at 0.
    pub fn largest_magnitude(&self) -> f64 {
        self.largest_magnitude
    }

    /// Voxels per bin, values fastest.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Voxels counted: all that are present.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Position in [`JointHistogram::counts`] of a value and a magnitude; those beyond the edges
    /// belong to the outer bins.
    pub fn bin(&self, value: f64, magnitude: f64) -> usize {
        let place = |x: f64, [low, high]: [f64; 2], bins: usize| {
            let fraction = if high > low { (x - low) / (high - low) } else { 0.0 };
            ((fraction * bins as f64) as usize).min(bins - 1)
        };
        let value_bin = place(value, self.value_range, self.dims[0]);
        value_bin + self.dims[0] * place(magnitude, [0.0, self.largest_magnitude], self.dims[1])
    }
}

/// Two passes, so that no gradient has to be kept: one for the ranges and one to count.
fn count(field: &impl Reconstruct, volume: &Volume, gradient: Gradient, dims: [usize; 2]) -> JointHistogram {
    let [nx, ny, nz] = volume.grid().dims();
    let for_slab = |z: usize, visit: &mut dyn FnMut(f64, f64)| {
        for (y, x) in (0..ny).flat_map(|y| (0..nx).map(move |x| (y, x))) {
            let index = DVec3::new(x as f64, y as f64, z as f64);
            let value = field.value(index);
            if value.is_finite() {
                visit(value, world_gradient(volume.grid(), field.gradient(gradient, index, value)).length());
            }
        }
    };
    let nothing: Extent = ([f64::INFINITY, f64::NEG_INFINITY], 0.0);
    let join = |a: Extent, b: Extent| ([a.0[0].min(b.0[0]), a.0[1].max(b.0[1])], a.1.max(b.1));
    let slab_extent = |z: usize| {
        let mut extent = nothing;
        for_slab(z, &mut |value, magnitude| extent = join(extent, ([value, value], magnitude)));
        extent
    };
    let extents = || (0..nz).into_par_iter().map(slab_extent).reduce(|| nothing, join);
    let (value_range, largest_magnitude) = parallel(extents);
    let value_range = if value_range[0] <= value_range[1] { value_range } else { [0.0, 0.0] };
    let bins = dims[0] * dims[1];
    let mut histogram = JointHistogram { dims, value_range, largest_magnitude, counts: Vec::new() };
    let count_slab = |mut counts: Vec<u64>, z: usize| {
        for_slab(z, &mut |value, magnitude| counts[histogram.bin(value, magnitude)] += 1);
        counts
    };
    // A few long runs of slabs: every run has its own table.
    let run = nz.div_ceil(2 * thread_count());
    let add = |mut a: Vec<u64>, b: Vec<u64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    let runs = || (0..nz).into_par_iter().with_min_len(run).fold(|| vec![0; bins], count_slab).reduce_with(add);
    histogram.counts = parallel(runs).unwrap_or_else(|| vec![0; bins]);
    histogram
}
