//! Pre-integration against closed forms, brute force and the published numbers of 4.5 and 4.6.

use pellucid_optics::{
    Color, ColorPoint, ColorSpace, DataRange, OpacityPoint, PreIntegration, StepTable, Table, TransferFunction,
    Visibility, correct_associated, over,
};
use proptest::prelude::*;

/// A transfer function with linear-light grey levels and opacities at given values.
fn grey(levels: &[(f64, f32)], opacities: &[(f64, f32)]) -> TransferFunction {
    let color = |&(value, level): &(f64, f32)| ColorPoint::new(value, Color::new([level; 3]).unwrap());
    let opacity = |&(value, opacity): &(f64, f32)| OpacityPoint::new(value, opacity);
    TransferFunction::new(levels.iter().map(color).collect(), opacities.iter().map(opacity).collect())
        .unwrap()
        .with_color_space(ColorSpace::Linear)
}

/// Opacity of one unit distance at extinction `kappa`.
fn alpha(kappa: f64) -> f32 {
    -(-kappa).exp_m1() as f32
}

/// The integral of 4.3 and 4.4 with `steps` midpoints of constant medium.
fn brute_force(tf: &TransferFunction, front: f64, back: f64, ratio: f64, steps: usize) -> [f64; 4] {
    let (mut color, mut transparency) = ([0.0; 3], 1.0);
    for i in 0..steps {
        let value = front + (back - front) * (i as f64 + 0.5) / steps as f64;
        let kept = (1.0 - tf.opacity(value) as f64).powf(ratio / steps as f64);
        let rgb = tf.color(value);
        (0..3).for_each(|c| color[c] += transparency * (1.0 - kept) * rgb[c] as f64);
        transparency *= kept;
    }
    [color[0], color[1], color[2], 1.0 - transparency]
}

fn assert_close(found: [f32; 4], expected: [f64; 4], tolerance: f64, what: &str) {
    let worst = (0..4).map(|c| (found[c] as f64 - expected[c]).abs()).fold(0.0, f64::max);
    assert!(worst <= tolerance, "{what}: {found:?}, expected {expected:?}");
}

#[test]
fn ramp_of_emission_in_constant_extinction() {
    // 4.5-1: extinction 2, emission s = extinction * s / 2, length 1.
    let tf = grey(&[(0.0, 0.0), (1.0, 0.5)], &[(0.0, alpha(2.0))]);
    let table = PreIntegration::build(&tf, [0.0, 1.0], 256, 1.0).unwrap();
    let e2 = (-2.0f64).exp();
    assert_close(table.lookup(0.0, 1.0), [(1.0 - 3.0 * e2) / 4.0; 4].map_alpha(1.0 - e2), 1e-6, "0 to 1");
    assert_close(table.lookup(1.0, 0.0), [0.28383; 4].map_alpha(0.86466), 1e-5, "1 to 0");
    assert_close(table.lookup(0.0, 1.0), [0.14850; 4].map_alpha(0.86466), 1e-5, "0 to 1, as printed");
}

trait WithAlpha {
    fn map_alpha(self, alpha: f64) -> Self;
}

impl WithAlpha for [f64; 4] {
    fn map_alpha(mut self, alpha: f64) -> Self {
        self[3] = alpha;
        self
    }
}

#[test]
fn constant_color_is_color_times_opacity() {
    // 4.5-2, for both tables, whatever the opacity does.
    let tf = grey(&[(0.0, 0.7)], &[(0.0, 0.0), (0.2, 0.9), (0.3, 1.0), (0.4, 0.1), (1.0, 0.5)]);
    for table in [PreIntegration::build, PreIntegration::fast].map(|build| build(&tf, [0.0, 1.0], 64, 0.8).unwrap()) {
        for entry in table.entries() {
            assert!((entry[0] - 0.7 * entry[3]).abs() < 1e-5, "{entry:?}");
        }
    }
}

#[test]
fn diagonal_is_post_classification_and_opacity_is_symmetric() {
    // 4.6-1, corrected mode.
    let tf = grey(&[(0.0, 0.1), (1.0, 0.9)], &[(0.0, 0.0), (0.31, 0.8), (0.6, 0.05), (1.0, 1.0)]);
    let n = 128;
    let table = PreIntegration::build(&tf, [0.0, 1.0], n, 0.4).unwrap();
    let post = StepTable::new(&Table::build(&tf, [0.0, 1.0], n).unwrap(), 0.4).unwrap();
    for i in 0..n {
        assert_eq!(table.entries()[i + n * i], post.entries()[i]);
        for j in 0..i {
            let [a, b] = [table.entries()[i + n * j], table.entries()[j + n * i]];
            assert!((a[3] - b[3]).abs() < 1e-6);
            // 4.5-5: never brighter than the brightest colour at this opacity.
            assert!(a[0] <= 0.9 * a[3] + 1e-6 && b[0] <= 0.9 * b[3] + 1e-6);
        }
    }
    let constant = grey(&[(0.0, 1.0)], &[(0.0, 26.0 / 255.0)]);
    for table in [PreIntegration::build, PreIntegration::fast].map(|f| f(&constant, [0.0, 255.0], 64, 1.0).unwrap()) {
        for entry in table.entries() {
            entry.iter().for_each(|v| assert!((v - 26.0 / 255.0).abs() < 1e-6, "{entry:?}"));
        }
    }
}

#[test]
fn a_spike_between_samples_is_not_missed() {
    // 4.5-3: extinction 50 where 0.495 < s < 0.505, along a ramp of length 1; opacities are given
    // over 1/64 of it.
    let unit = 1.0 / 64.0;
    let peak = alpha(50.0 * unit);
    let tf = grey(&[(0.0, 1.0)], &[(0.0, 0.0), (0.495, 0.0), (0.495, peak), (0.505, peak), (0.505, 0.0), (1.0, 0.0)]);
    let exact = 1.0 - (-0.5f64).exp();
    let data = DataRange { low: 0.0, high: 1.0, level_spacing: None };
    let march = |samples: usize, sample: &dyn Fn(f32, f32) -> [f32; 4]| {
        let at = |k: usize| (k as f32 + 0.37) / samples as f32;
        (0..samples - 1).fold([0.0; 4], |sum, k| over(sum, sample(at(k), at(k + 1))))[3] as f64
    };
    let step_ratio = |samples: usize| 1.0 / (samples as f64 * unit);
    let table = PreIntegration::for_data(&tf, &data, step_ratio(8)).unwrap();
    let pre = march(8, &|front, back| table.lookup(front, back));
    assert!((pre - exact).abs() < 1e-4, "{pre} for {exact}");
    let post = |samples: usize| {
        let table = StepTable::new(&Table::for_data(&tf, &data).unwrap(), step_ratio(samples) as f32).unwrap();
        march(samples, &|front, _| table.lookup(front))
    };
    for samples in [8, 16, 32, 64] {
        assert_eq!(post(samples), 0.0, "{samples} samples");
    }
    assert!((post(1024) - exact).abs() > 3e-3, "{}", post(1024));
    assert!((post(4096) - exact).abs() < 2e-3, "{}", post(4096));
}

#[test]
fn a_peak_far_narrower_than_a_cell_is_kept() {
    let tf = grey(&[(0.0, 1.0)], &[(0.0, 0.0), (0.5001, 0.0), (0.50011, 0.9), (0.50012, 0.0)]);
    let table = PreIntegration::build(&tf, [0.0, 1.0], 64, 1000.0).unwrap();
    // The mean of -ln(1 - a) for a rising from 0 to 0.9, over both flanks.
    let mean = 1.0 - 0.1 / 0.9 * 10f64.ln();
    let exact = 1.0 - (-mean * 2e-5 * 1000.0f64).exp();
    let found = table.lookup(0.0, 1.0)[3] as f64;
    assert!((found / exact - 1.0).abs() < 5e-3, "{found} for {exact}");
    let visible = Visibility::of_segments(&tf, table.nodes());
    assert!(visible.any_opacity(0.49, 0.51) && !visible.any_opacity(0.0, 0.4));
}

#[test]
fn fast_table_has_exact_opacity_and_the_stated_error_of_color() {
    let wild = grey(&[(0.0, 0.0), (1.0, 1.0)], &[(0.0, 0.0), (0.3, 0.6), (0.35, 0.0), (0.7, 0.99), (1.0, 0.2)]);
    let [full, fast] = [PreIntegration::build, PreIntegration::fast].map(|f| f(&wild, [0.0, 1.0], 256, 1.5).unwrap());
    for (a, b) in full.entries().iter().zip(fast.entries()) {
        assert!((a[3] - b[3]).abs() < 1e-5);
    }
    for depth in [0.01, 0.1, 0.5, 1.0] {
        let ramp = grey(&[(0.0, 0.0), (1.0, 1.0)], &[(0.0, alpha(depth))]);
        let table = PreIntegration::fast(&ramp, [0.0, 1.0], 64, 1.0).unwrap();
        let found = table.lookup(0.0, 1.0)[0] as f64;
        let exact = (1.0 - (1.0 + depth) * (-depth).exp()) / depth;
        let excess = found / exact - 1.0;
        assert!((excess / (depth / 6.0) - 1.0).abs() < 0.01 + 0.17 * depth, "depth {depth}: {excess}");
        // 4.5-4: the law of the book's form, whose colour is that of `found` times depth / alpha.
        let book = depth / table.lookup(0.0, 1.0)[3] as f64 - 1.0;
        let law = [(0.01, 0.005), (0.1, 0.05), (0.5, 0.27), (1.0, 0.58)].iter().find(|l| l.0 == depth).unwrap().1;
        assert!((book - law).abs() < 0.005, "depth {depth}: {book}");
    }
}

#[test]
fn other_lengths_by_opacity_correction() {
    // 7.3-4: a constant field cut in any way has the same opacity.
    let constant = grey(&[(0.0, 0.5)], &[(0.0, 0.4)]);
    let table = PreIntegration::build(&constant, [0.0, 1.0], 64, 1.0).unwrap();
    let march = |lengths: &[f32]| {
        lengths.iter().fold([0.0; 4], |sum, &l| over(sum, correct_associated(table.lookup(0.3, 0.3), l)))
    };
    let (even, uneven) = (march(&[1.0; 4]), march(&[0.125, 1.5, 0.375, 1.75, 0.25]));
    assert!((even[3] - uneven[3]).abs() < 1e-5 && (even[0] - uneven[0]).abs() < 1e-5);
    // Correcting instead of a third dimension: opacity exact, colour off by the order of colours.
    let tf = grey(&[(0.0, 0.0), (1.0, 1.0)], &[(0.0, 0.1), (0.5, 0.8), (1.0, 0.3)]);
    let [whole, half] = [1.0, 0.5].map(|ratio| PreIntegration::build(&tf, [0.0, 1.0], 64, ratio).unwrap());
    let mut worst = 0.0f32;
    for (a, b) in whole.entries().iter().zip(half.entries()) {
        let corrected = correct_associated(*a, 0.5);
        assert!((corrected[3] - b[3]).abs() < 1e-5);
        worst = worst.max((corrected[0] - b[0]).abs());
    }
    assert!((0.001..0.03).contains(&worst), "colour differs by {worst}");
}

#[test]
fn segments_beyond_the_domain_are_cut_at_it() {
    let tf = grey(&[(0.0, 0.2), (1.0, 0.9)], &[(0.0, 0.05), (0.5, 0.9), (1.0, 0.3)]);
    let table = PreIntegration::build(&tf, [0.0, 1.0], 256, 1.0).unwrap();
    for (front, back) in
        [(-9.0, 1.0), (1.0, -9.0), (-3.0, 0.5), (0.25, 40.0), (-1.0, 2.0), (2.0, -7.0), (-5.0, -2.0), (3.0, 8.0)]
    {
        let expected = brute_force(&tf, front, back, 1.0, 20_000);
        // The colour of a shortened segment is not exact, its opacity is.
        assert_close(table.lookup(front as f32, back as f32), expected, 1e-2, &format!("{front} to {back}"));
        assert!((table.lookup(front as f32, back as f32)[3] as f64 - expected[3]).abs() < 1e-4, "{front} to {back}");
    }
    assert_eq!(table.lookup(f32::NAN, 0.5), [0.0; 4]);
    assert_eq!(table.lookup(0.5, f32::INFINITY), [0.0; 4]);
}

#[test]
fn settings_are_checked() {
    let tf = grey(&[(0.0, 1.0)], &[(0.0, 0.5)]);
    for (domain, size, ratio) in [
        ([0.0, 1.0], 63, 1.0),
        ([0.0, 1.0], 1025, 1.0),
        ([1.0, 0.0], 64, 1.0),
        ([0.0, 1.0], 64, -1.0),
        ([0.0, 1.0], 64, f64::NAN),
    ] {
        assert!(PreIntegration::build(&tf, domain, size, ratio).is_err());
    }
    // A volume of one value has an interval without width.
    let data = DataRange { low: 3.0, high: 3.0, level_spacing: None };
    let entry = PreIntegration::for_data(&tf, &data, 1.0).unwrap().lookup(3.0, 3.0);
    assert!((entry[3] - 0.5).abs() < 1e-6 && (entry[0] - 0.5).abs() < 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn full_table_equals_brute_force(
        levels in prop::collection::vec((0.0f64..1.0, 0.0f32..=1.0), 1..5),
        opacities in prop::collection::vec((0.0f64..1.0, 0.0f32..=0.999), 1..6),
        ratio in 0.05f64..4.0,
        ends in prop::collection::vec((0usize..64, 0usize..64), 8),
    ) {
        let sorted = |mut points: Vec<(f64, f32)>| {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points.dedup_by_key(|point| point.0);
            points
        };
        let tf = grey(&sorted(levels), &sorted(opacities));
        let table = PreIntegration::build(&tf, [0.0, 1.0], 64, ratio).unwrap();
        for (front, back) in ends {
            let expected = brute_force(&tf, front as f64 / 63.0, back as f64 / 63.0, ratio, 8_000);
            assert_close(table.entries()[front + 64 * back], expected, 1e-3, &format!("{front} to {back}"));
        }
    }
}
