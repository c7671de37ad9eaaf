//! Value and gradient magnitude counted together.

use glam::DVec3;
use pellucid_field::{FieldError, Filter, Gradient, Grid, JointHistogram, Sampler, Volume};

use crate::{Random, volume, voxels};

/// Central differences by hand, one-sided beside absence and the border.
fn magnitude(volume: &Volume, voxel: [usize; 3], spacing: [f64; 3]) -> f64 {
    let value = |voxel: [usize; 3]| {
        let inside = (0..3).all(|axis| voxel[axis] < volume.grid().dims()[axis]);
        Some(voxel).filter(|_| inside).map(|voxel| volume.value(voxel, 0)).filter(|v| v.is_finite())
    };
    let center = value(voxel).unwrap();
    let slope = |axis: usize| {
        let moved = |step: usize| {
            let mut moved = voxel;
            moved[axis] = moved[axis].wrapping_add(step);
            value(moved)
        };
        let difference = match (moved(1), moved(usize::MAX)) {
            (Some(right), Some(left)) => (right - left) / 2.0,
            (Some(right), None) => right - center,
            (None, Some(left)) => center - left,
            (None, None) => 0.0,
        };
        difference / spacing[axis]
    };
    (0..3).map(|axis| slope(axis).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn counts_agree_with_brute_force() {
    let (dims, spacing) = ([9, 8, 7], [0.5, 1.0, 3.0]);
    let mut random = Random(40);
    let values: Vec<f32> = (0..504).map(|_| random.next() as f32).map(|v| if v < 0.1 { f32::NAN } else { v }).collect();
    let volume = Volume::new(Grid::with_spacing(dims, spacing, [1.0; 3]).unwrap(), values).unwrap();
    let histogram = JointHistogram::new(&volume, 0, Gradient::Central, [16, 12]).unwrap();
    let present: Vec<(f64, f64)> = (0..504)
        .map(|i| [i % 9, i / 9 % 8, i / 72])
        .filter(|&voxel| volume.value(voxel, 0).is_finite())
        .map(|voxel| (volume.value(voxel, 0), magnitude(&volume, voxel, spacing)))
        .collect();
    let fold =
        |f: fn(f64, f64) -> f64, start: f64, pick: fn(&(f64, f64)) -> f64| present.iter().map(pick).fold(start, f);
    let (low, high) = (fold(f64::min, f64::INFINITY, |p| p.0), fold(f64::max, 0.0, |p| p.0));
    let steepest = fold(f64::max, 0.0, |p| p.1);
    assert_eq!(histogram.value_range(), [low, high]);
    assert!((histogram.largest_magnitude() - steepest).abs() < 1e-12);
    let mut expected = vec![0u64; 16 * 12];
    for (value, magnitude) in &present {
        let i = ((value - low) / (high - low) * 16.0).min(15.0) as usize;
        let j = (magnitude / steepest * 12.0).min(11.0) as usize;
        expected[i + 16 * j] += 1;
    }
    assert_eq!(histogram.counts(), expected);
    assert_eq!(histogram.total(), present.len() as u64);
}

/// The boundary of a blurred step is an arch: steepest midway between the two materials.
#[test]
fn a_boundary_is_an_arch() {
    let step = volume([40, 4, 4], |p| 100.0 / (1.0 + (-(p.x - 19.5) / 2.0).exp()));
    let histogram = JointHistogram::new(&step, 0, Gradient::Central, [32, 32]).unwrap();
    let [bins, rows] = histogram.dims();
    let filled = |bin: usize| (0..rows).rev().find(|row| histogram.counts()[bin + bins * row] > 0).unwrap_or(0);
    let height = |range: std::ops::Range<usize>| range.map(filled).max().unwrap();
    assert_eq!(height(12..20), rows - 1);
    assert!(height(0..2) < rows / 4 && height(bins - 2..bins) < rows / 4);
    assert!(height(5..9) > height(0..4) && height(23..27) > height(28..32));
}

#[test]
fn degenerate_volumes() {
    let constant = JointHistogram::new(&volume([3; 3], |_| 5.0), 0, Gradient::Sobel, [4, 4]).unwrap();
    assert_eq!((constant.total(), constant.counts()[0], constant.value_range()), (27, 27, [5.0, 5.0]));
    let nothing = JointHistogram::new(&volume([3; 3], |_| f64::NAN), 0, Gradient::Central, [4, 4]).unwrap();
    assert_eq!((nothing.total(), nothing.value_range()), (0, [0.0, 0.0]));
    let line = volume([1, 1, 5], |p| p.z);
    let line = JointHistogram::new(&line, 0, Gradient::Central, JointHistogram::DEFAULT_DIMS).unwrap();
    assert_eq!((line.total(), line.largest_magnitude(), line.dims()), (5, 1.0, [256, 256]));
    let error = JointHistogram::new(&volume([2; 3], |p| p.x), 0, Gradient::Central, [0, 4]).unwrap_err();
    assert!(matches!(error, FieldError::Parameter { name: "histogram dims", .. }));
}

#[test]
fn one_component_is_counted() {
    let values: Vec<f32> = voxels([4; 3], |p| p.x).into_iter().flat_map(|v| [1000.0, v]).collect();
    let volume = Volume::with_components(Grid::new([4; 3]).unwrap(), values, 2).unwrap();
    let histogram = JointHistogram::new(&volume, 1, Gradient::Central, [4, 2]).unwrap();
    assert_eq!(histogram.value_range(), [0.0, 3.0]);
    let place = histogram.bin(2.0, 1.0);
    assert_eq!(histogram.counts()[place], 16);
    assert!(JointHistogram::new(&volume, 2, Gradient::Central, [4, 2]).is_err());
    assert_eq!(Sampler::new(&volume, 1, Filter::Nearest).unwrap().value(DVec3::X), 1.0);
}
