//! Coarser and coarser copies of a volume.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use crate::{FieldError, Grid, Volume, Voxel, Voxels, for_voxels, parallel};

/// The volume followed by ever coarser copies of it, each [`halve`] of the one before, down to a
/// single voxel or until there are `levels` of them (at least 1: the volume itself, whose voxels
/// are shared).
///
/// # Errors
/// As [`halve`].
pub fn pyramid(volume: &Volume, levels: Option<usize>) -> Result<Vec<Volume>, FieldError> {
    let mut pyramid = vec![volume.clone()];
    let mut finest = volume;
    while finest.grid().len() > 1 && levels.is_none_or(|levels| pyramid.len() < levels) {
        pyramid.push(halve(finest)?);
        finest = &pyramid[pyramid.len() - 1];
    }
    Ok(pyramid)
}

/// A copy with half the samples per axis, rounded up, in the same voxel type.
///
/// A sample is the mean of the finite samples it replaces, absent only if all of them are: of two
/// per axis if their number is even. An odd number n has no such pairs; there the axis is cut
/// into equal intervals, and a sample is the mean over one of them, two whole samples and a share
/// of a third (the box filter of Guthe & Heckbert, "Non-Power-of-Two Mipmap Creation", 2005). The
/// centroids of these intervals are equally spaced as well, so that one affine puts every sample
/// where it belongs: linear functions stay what they are and the mean of all samples is kept, for
/// odd numbers too.
///
/// The outermost samples of the copy lie further inside than those of the volume.
///
/// # Errors
/// [`FieldError::Affine`] if the coarser affine overflows.
pub fn halve(volume: &Volume) -> Result<Volume, FieldError> {
    let dims = volume.grid().dims();
    let axes = dims.map(intervals);
    let scale = DVec3::from_array(dims.map(centroid_spacing));
    let first = DVec3::from_array([0, 1, 2].map(|axis| centroid(&axes[axis][0])));
    let fine_from_coarse = DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: first };
    let coarse = [0, 1, 2].map(|axis| axes[axis].len());
    let grid = Grid::with_affine(coarse, volume.grid().world_from_index() * fine_from_coarse)?;
    let voxels: Voxels = for_voxels!(volume.voxels(), data => average(data, volume, &axes).into());
    volume.with_samples(grid, voxels, volume.components())
}

/// The samples that a coarse sample replaces along one axis, and their weights.
type Interval = Vec<(usize, f64)>;

/// Cuts n samples, each one unit long, into ceil(n / 2) equal intervals.
fn intervals(n: usize) -> Vec<Interval> {
    let m = n.div_ceil(2);
    let interval = |i: usize| {
        // In units of 1/m all ends are whole numbers, so weights are exact.
        let (start, end) = (i * n, (i + 1) * n);
        let overlap = |k: usize| (end.min((k + 1) * m) - start.max(k * m)) as f64 / m as f64;
        (start / m..end.div_ceil(m)).map(|k| (k, overlap(k))).collect()
    };
    (0..m).map(interval).collect()
}

fn centroid(interval: &Interval) -> f64 {
    let weight: f64 = interval.iter().map(|(_, weight)| weight).sum();
    interval.iter().map(|(k, weight)| *k as f64 * weight).sum::<f64>() / weight
}

/// Distance between the centroids of neighbouring intervals. For n = 2 m - 1 samples, the centroid
/// of interval i is (4 i + 1) (m - 1) / (2 m - 1).
fn centroid_spacing(n: usize) -> f64 {
    if n == 1 {
        1.0
    } else if n.is_multiple_of(2) {
        2.0
    } else {
        2.0 * (n - 1) as f64 / n as f64
    }
}

fn average<T: Voxel>(data: &[T], volume: &Volume, axes: &[Vec<Interval>; 3]) -> Vec<T> {
    let components = volume.components();
    let [nx, ny, nz] = [0, 1, 2].map(|axis| axes[axis].len());
    let mut voxels = vec![T::zeroed(); nx * ny * nz * components];
    let fill = |(row, voxels): (usize, &mut [T])| {
        // Each row of the volume that takes part: where it begins, and its weight.
        let rows: Vec<(usize, f64)> = axes[2][row / ny]
            .iter()
            .flat_map(|&(z, wz)| axes[1][row % ny].iter().map(move |&(y, wy)| (y, z, wy * wz)))
            .map(|(y, z, weight)| (volume.grid().linear_index([0, y, z]) * components, weight))
            .collect();
        for (index, voxel) in voxels.iter_mut().enumerate() {
            let (x, component) = (index / components, index % components);
            let (mut sum, mut weights) = (0.0, 0.0);
            for &(start, row_weight) in &rows {
                for &(k, weight) in &axes[0][x] {
                    let value = data[start + k * components + component].to_f64();
                    if value.is_finite() {
                        sum += value * (row_weight * weight);
                        weights += row_weight * weight;
                    }
                }
            }
            // 0/0 is NaN: absent. Integers are never absent.
            *voxel = T::from_f64(sum / weights);
        }
    };
    parallel(|| voxels.par_chunks_mut(nx * components).enumerate().for_each(fill));
    voxels
}
