//! Classification: where samples get colour and opacity.

use glam::DVec3;
use pellucid_field::{Filter, Reconstruct, Volume};
use pellucid_optics::StepTable;

use crate::probe::Probe;

/// Classifies single samples: associated colour and opacity for one full step.
pub trait Classify<R>: Sync {
    /// The data value (NaN where absent) and the associated RGBA at an index position.
    fn classify(&self, probe: &Probe<R>, index: DVec3) -> (f64, [f32; 4]);
}

/// The transfer function applied to the interpolated value (4.3-1).
pub struct Post<'a> {
    /// Associated entries for one step.
    pub table: &'a StepTable,
}

impl<R: Reconstruct> Classify<R> for Post<'_> {
    #[inline(always)]
    fn classify(&self, probe: &Probe<R>, index: DVec3) -> (f64, [f32; 4]) {
        let value = probe.value(index);
        if value.is_nan() { (value, [0.0; 4]) } else { (value, self.table.lookup(value as f32)) }
    }
}

/// The transfer function applied to the voxels, interpolating their associated colours (4.2-1,
/// 3.2-8). An absent voxel has neither colour nor opacity.
pub struct Pre<'a> {
    /// Associated entries for one step.
    pub table: &'a StepTable,
    /// The voxels.
    pub volume: &'a Volume,
    /// Which component is classified.
    pub component: usize,
    /// How colours are interpolated.
    pub filter: Filter,
}

impl<R: Reconstruct> Classify<R> for Pre<'_> {
    fn classify(&self, probe: &Probe<R>, index: DVec3) -> (f64, [f32; 4]) {
        let dims = self.volume.grid().dims();
        let reach = self.filter.half_width() as isize;
        let cell: [isize; 3] =
            std::array::from_fn(|axis| index[axis].clamp(0.0, (dims[axis] - 1) as f64).floor() as isize);
        let weights: [_; 3] = std::array::from_fn(|axis| {
            let x = index[axis].clamp(0.0, (dims[axis] - 1) as f64);
            self.filter.weights(x - x.floor())
        });
        let voxel = |axis: usize, tap: usize| {
            (cell[axis] + 1 - reach + tap as isize).clamp(0, dims[axis] as isize - 1) as usize
        };
        let mut sum = [0.0f64; 4];
        for (k, wz) in weights[2].iter().enumerate() {
            for (j, wy) in weights[1].iter().enumerate() {
                for (i, wx) in weights[0].iter().enumerate() {
                    let weight = wx * wy * wz;
                    if weight == 0.0 {
                        continue;
                    }
                    let value = self.volume.value([voxel(0, i), voxel(1, j), voxel(2, k)], self.component);
                    let rgba = self.table.lookup(value as f32);
                    for (sum, channel) in sum.iter_mut().zip(rgba) {
                        *sum += weight * f64::from(channel);
                    }
                }
            }
        }
        // Filters with negative weights overshoot.
        (probe.value(index), sum.map(|channel| channel.clamp(0.0, 1.0) as f32))
    }
}
