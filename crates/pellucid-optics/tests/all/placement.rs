//! Tables against the curves themselves, where even nodes would miss something: parts that are narrow for the data's
//! range, jumps, matter beside none, values that no voxel has.

use pellucid_optics::{
    Bend, Color, ColorPoint, ColorSpace, DataRange, Interpolation, OpacityPoint, PreIntegration, StepTable, Table,
    TransferFunction, Visibility,
};
use proptest::prelude::*;

fn opacities(points: &[(f64, f32)]) -> TransferFunction {
    let points = points.iter().map(|&(value, opacity)| OpacityPoint::new(value, opacity)).collect();
    TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap()
}

fn floats(low: f64, high: f64) -> DataRange {
    DataRange { low, high, level_spacing: None }
}

fn levels(low: f64, high: f64) -> DataRange {
    DataRange { low, high, level_spacing: Some(1.0) }
}

/// The opacity of the mean extinction from one value to another along straight pieces, in closed form: the mean of
/// `-ln(1 - a)` for a from p to q.
fn exact_opacity(points: &[(f64, f32)], front: f64, back: f64, ratio: f64) -> f64 {
    let (low, high) = (front.min(back), front.max(back));
    let antiderivative = |a: f64| if a < 1.0 { a + (1.0 - a) * (1.0 - a).ln() } else { 1.0 };
    let depth_of = |from: f64, to: f64| {
        let middle = 0.5 * (from + to);
        let above = points.partition_point(|point| point.0 <= middle);
        if above == 0 || above == points.len() {
            let a = f64::from(points[above.saturating_sub(1)].1);
            return -(1.0 - a).ln() * (to - from);
        }
        let [(x, p), (y, q)] = [points[above - 1], points[above]];
        let at = |v: f64| f64::from(p) + f64::from(q - p) * (v - x) / (y - x);
        let (p, q) = (at(from), at(to));
        let mean =
            if (q - p).abs() < 1e-9 { -(1.0 - p).ln() } else { (antiderivative(q) - antiderivative(p)) / (q - p) };
        mean * (to - from)
    };
    let mut edges = vec![low];
    edges.extend(points.iter().map(|point| point.0).filter(|value| (low..high).contains(value)));
    edges.push(high);
    let depth: f64 = edges.windows(2).filter(|e| e[0] < e[1]).map(|e| depth_of(e[0], e[1])).sum();
    if high > low { -(-ratio * depth / (high - low)).exp_m1() } else { f64::NAN }
}

#[test]
fn peaks_of_a_millionth_of_the_range_are_there() {
    for (low, high) in [(0.0, 1e6), (-1e6, 1e6), (0.0, 1e7), (-4e5, 2e9)] {
        for at in [1.0, 700.25, 123_456.0] {
            let points = [(at - 0.5, 0.0), (at, 0.5), (at + 0.5, 0.0), (3e5, 0.0), (4e5, 0.9)];
            let table = Table::for_data(&opacities(&points), &floats(low, high)).unwrap();
            let found = |value: f64| table.lookup(value as f32)[3];
            // To the f32 next to the place.
            let rounding = 4.0 * f32::EPSILON * at as f32;
            for (value, exact) in [(at, 0.5), (at - 0.25, 0.25), (at + 0.375, 0.125), (at - 0.5, 0.0), (at + 0.5, 0.0)]
            {
                assert!((found(value) - exact).abs() < 1e-3 + rounding, "{at} of {low} to {high}: {}", found(value));
            }
            for value in [low, at - 0.6, at + 0.6, at + 40.0, 2e5, 3e5] {
                assert_eq!(found(value), 0.0, "beside {at} of {low} to {high}: {value}");
            }
            assert!((found(3.5e5) - 0.45).abs() < 1e-3 && (found(high) - 0.9).abs() < 1e-3);
            let visible = Visibility::of_table(&table);
            assert!(!visible.any_opacity(at as f32 + 0.75, 3e5) && visible.any_opacity(at as f32 - 0.25, 3e5));
        }
    }
}

#[test]
fn nothing_is_seen_before_the_first_point() {
    // 0.001 and 0.7 are no numbers of single precision: one is rounded up, the other down.
    for at in [0.001, 0.7] {
        let tf = opacities(&[(at, 0.0), (at + 0.01, 0.05), (at + 0.1, 0.1), (at + 0.1, 0.5), (at + 0.2, 0.0)]);
        let table = Table::for_data(&tf, &floats(-1.0, 1.0)).unwrap();
        for value in [-1.0, 0.0, at as f32, at as f32 + 0.2] {
            assert!(value > at as f32 && value < 1.0 || table.lookup(value)[3] == 0.0, "{at}: {value}");
        }
        assert!(!Visibility::of_table(&table).any_opacity(-1.0, at as f32 - 1e-4));
        let segments = PreIntegration::for_data(&tf, &floats(-1.0, 1.0), 1.0).unwrap();
        assert_eq!(segments.lookup(-1.0, at as f32 - 1e-4), [0.0; 4]);
        assert_eq!(segments.lookup(1.0, 0.95), [0.0; 4]);
    }
}

#[test]
fn what_single_precision_merges_is_told() {
    assert_eq!(opacities(&[(1e6, 0.0), (1e6 + 0.01, 0.5), (1e6 + 1.0, 0.0)]).merged_points(), Some([1e6, 1e6 + 0.01]));
    assert_eq!(opacities(&[(1e6, 0.0), (1e6, 0.5), (1e6 + 1.0, 0.0)]).merged_points(), None);
}

#[test]
fn thin_media_have_narrow_peaks_too() {
    // What is seen through ten thousand voxels.
    let table = Table::for_data(&opacities(&[(0.5, 0.0), (1.0, 2e-5), (1.5, 0.0), (1e6, 0.0)]), &floats(0.0, 1e6));
    assert!((table.unwrap().lookup(1.0)[3] / 2e-5 - 1.0).abs() < 1e-3);
}

#[test]
fn peaks_between_levels_are_there() {
    // Interpolated integers have values between levels.
    for data in [levels(0.0, 255.0), levels(-32_768.0, 32_767.0), levels(0.0, 4e9)] {
        let tf = opacities(&[(100.1, 0.0), (100.5, 0.8), (100.9, 0.0), (200.0, 0.0)]);
        let table = Table::for_data(&tf, &data).unwrap();
        for (value, exact) in [(100.0, 0.0), (100.1, 0.0), (100.3, 0.4), (100.5, 0.8), (101.0, 0.0), (150.0, 0.0)] {
            let found = table.lookup(value)[3];
            assert!((found - exact).abs() < 1e-4, "{data:?} at {value}: {found}");
        }
    }
}

#[test]
fn jumps_are_jumps_and_the_upper_side_holds() {
    let interpolations = [Interpolation::Linear, Interpolation::Step];
    for (data, interpolation) in [floats(-10.0, 1e5), levels(-10.0, 100.0), levels(-32_768.0, 32_767.0)]
        .into_iter()
        .flat_map(|data| interpolations.map(|interpolation| (data, interpolation)))
    {
        for at in [-3.0, 0.0, 0.3, 7.0, 41.7] {
            let point = |value, opacity| OpacityPoint { value, opacity, interpolation };
            let points = vec![point(-5.0, 0.1), point(at, 0.1), point(at, 0.9), point(90.0, 0.9)];
            let tf = TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap();
            let table = Table::for_data(&tf, &data).unwrap();
            let at = at as f32;
            let below = at.next_down().min(at - f32::MIN_POSITIVE);
            for (value, exact) in
                [(below, 0.1), (at - 0.01, 0.1), (-8.0, 0.1), (at, 0.9), (at + 0.01, 0.9), (95.0, 0.9)]
            {
                let found = table.lookup(value)[3];
                assert!((found - exact).abs() < 1e-5, "{data:?}, jump at {at}, {interpolation:?}: {value} has {found}");
            }
        }
    }
}

#[test]
fn colors_jump_as_well() {
    let color = |value, hex| ColorPoint::new(value, Color::hex(hex));
    let colors = vec![color(0.0, 0xff0000), color(0.4, 0xff0000), color(0.4, 0x0000ff), color(1.0, 0x00ffff)];
    let tf = TransferFunction::new(colors, vec![OpacityPoint::new(0.0, 1.0)]).unwrap();
    let tf = tf.with_color_space(ColorSpace::Linear);
    let table = Table::for_data(&tf, &floats(0.0, 1.0)).unwrap();
    for (value, exact) in [(0.4f32.next_down(), [1.0, 0.0, 0.0, 1.0]), (0.4, [0.0, 0.0, 1.0, 1.0])] {
        let found = table.lookup(value);
        assert!((0..4).all(|c| (found[c] - exact[c]).abs() < 1e-6), "{value}: {found:?}");
    }
    assert!((table.lookup(0.7)[1] - 0.5).abs() < 1e-4);
}

#[test]
fn few_levels_keep_even_nodes() {
    // Found fastest, and exact: nothing is between the levels that is not on the lines between them.
    let ramp = opacities(&[(10.0, 0.0), (100.0, 0.4), (200.0, 0.9)]);
    for data in [levels(0.0, 255.0), levels(0.0, 4095.0), floats(0.0, 255.0)] {
        assert!(Table::for_data(&ramp, &data).unwrap().nodes().knots().is_empty(), "{data:?}");
    }
    assert!(
        PreIntegration::for_data(&opacities(&[(0.0, 0.0), (100.0, 0.4), (255.0, 0.9)]), &levels(0.0, 255.0), 1.0)
            .unwrap()
            .nodes()
            .knots()
            .is_empty()
    );
}

#[test]
fn no_segment_has_matter_where_there_is_none() {
    // 16 bits: a peak, and a constant beside it (4.6-2).
    let points = [(0.0, 0.0), (30_000.0, 0.0), (30_020.0, 0.9), (30_040.0, 0.0), (65_535.0, 0.0)];
    for (tf, data) in [(opacities(&points), levels(0.0, 65_535.0)), (opacities(&points), floats(0.0, 65_535.0))] {
        let table = PreIntegration::for_data(&tf, &data, 1.0).unwrap();
        for value in [0.0, 500.0, 29_960.0, 29_999.0, 30_000.0, 30_040.0, 30_041.0, 30_060.0, 30_100.0, 65_535.0] {
            assert_eq!(table.lookup(value, value), [0.0; 4], "{data:?} at {value}");
        }
        for (front, back) in [(30_050.0, 30_060.0), (30_041.0, 65_000.0), (29_999.0, 1.0)] {
            assert_eq!(table.lookup(front, back), [0.0; 4], "{data:?} from {front} to {back}");
        }
        assert!((table.lookup(30_020.0, 30_020.0)[3] - 0.9).abs() < 1e-6);
    }
}

#[test]
fn segments_of_narrow_peaks_have_their_integral() {
    let peaks: [&[(f64, f32)]; 4] = [
        &[(0.0, 0.0), (30_000.0, 0.0), (30_020.0, 0.9), (30_040.0, 0.0), (65_535.0, 0.0)],
        &[(0.5, 0.0), (1.0, 0.5), (1.5, 0.0), (60_000.0, 0.0)],
        &[(100.0, 0.0), (100.25, 0.6), (100.5, 0.0), (40_000.0, 0.0), (41_000.0, 0.97), (65_535.0, 0.3)],
        &[(0.0, 0.0), (20_000.0, 0.05), (20_001.0, 0.95), (20_002.0, 0.05), (65_535.0, 0.0)],
    ];
    for points in peaks {
        let tf = opacities(points);
        let ratio = 3.0;
        let table = PreIntegration::for_data(&tf, &floats(0.0, 65_535.0), ratio).unwrap();
        let near = points[1].0;
        let values = [-3.0, -0.3, 0.2, 0.7, 1.1, 2.3, 9.0, 35.0, 41.0, 400.0, 9_000.0].map(|d| near + d);
        for front in values.into_iter().filter(|v| *v >= 0.0) {
            for back in values.into_iter().filter(|v| *v >= 0.0 && *v != front) {
                let (front, back) = (f64::from(front as f32), f64::from(back as f32));
                let exact = exact_opacity(points, front, back, ratio);
                let found = f64::from(table.lookup(front as f32, back as f32)[3]);
                assert!(
                    (found - exact).abs() < 0.005 + 0.02 * exact,
                    "{points:?}, {front} to {back}: {found}, exact {exact}"
                );
            }
        }
    }
}

#[test]
fn a_jump_of_extinction_is_where_it_is_in_segments() {
    // Thin matter from 0.3 on: a segment across has the share of its length that is beyond.
    let tf = opacities(&[(0.3, 0.0), (0.3, 0.4)]);
    let table = PreIntegration::for_data(&tf, &floats(-50.0, 1e4), 1.0).unwrap();
    for (front, back) in [(0.0, 1.0), (1.0, 0.0), (-40.0, 60.0), (0.29, 0.31), (0.0, 9e3), (0.31, 0.4), (0.0, 0.29)] {
        let share =
            if back == front { 1.0 } else { ((back - 0.3f64).max(0.0) - (front - 0.3).max(0.0)) / (back - front) };
        let exact = 1.0 - 0.6f64.powf(share);
        let found = f64::from(table.lookup(front as f32, back as f32)[3]);
        assert!((found - exact).abs() < 1e-4, "{front} to {back}: {found}, exact {exact}");
    }
}

#[test]
fn segments_of_any_length_have_their_own_color() {
    // Extinction 2 a unit, colour the value / 2 (4.5-1): its closed form over any part of the ramp, at any length.
    let alpha = -(-2.0f64).exp_m1() as f32;
    let colors =
        [(0.0, 0.0f32), (1.0, 0.5)].map(|(value, level)| ColorPoint::new(value, Color::new([level; 3]).unwrap()));
    let tf = TransferFunction::new(colors.to_vec(), vec![OpacityPoint::new(0.0, alpha)]).unwrap();
    let tf = tf.with_color_space(ColorSpace::Linear);
    let table = PreIntegration::for_data(&tf, &floats(0.0, 1.0), 1.0).unwrap();
    for (front, back) in [(0.0, 1.0), (1.0, 0.0), (0.2, 0.6), (0.9, 0.1)] {
        for length in [0.01, 0.25, 0.5, 0.75, 1.0, 1.5] {
            let depth: f64 = 2.0 * length;
            let alpha = 1.0 - (-depth).exp();
            let exact = 0.5 * (front * alpha + (back - front) * (alpha - depth * (-depth).exp()) / depth);
            let [red, _, _, found] = table.over_length(front as f32, back as f32, length as f32).map(f64::from);
            assert!(
                (red - exact).abs() < 2e-5 && (found - alpha).abs() < 1e-6,
                "{front} to {back} over {length}: {red} {exact}"
            );
        }
    }
}

#[test]
fn ranges_reach_as_far_as_filters() {
    let reached = levels(0.0, 255.0).reaching(-20.3, 280.1);
    assert_eq!(reached, DataRange { low: -21.0, high: 281.0, level_spacing: Some(1.0) });
    assert_eq!(levels(0.0, 255.0).reaching(3.0, 200.0), levels(0.0, 255.0));
    assert_eq!(floats(0.0, 1.0).reaching(-0.25, 1.5), floats(-0.25, 1.5));
    // What is beyond the voxels' values has its own opacity.
    let tf = opacities(&[(-40.0, 1.0), (0.0, 0.2), (255.0, 0.4), (300.0, 0.9)]);
    let table = Table::for_data(&tf, &reached).unwrap();
    for value in [-20.0, -0.5, 0.0, 100.0, 255.0, 271.3, 281.0] {
        assert!((table.lookup(value)[3] - tf.opacity(f64::from(value))).abs() < 2e-4, "{value}");
    }
}

#[test]
fn bends_of_uneven_nodes_are_not_missed() {
    let tf = opacities(&[(0.5, 0.0), (1.0, 0.5), (1.5, 0.0), (1e6, 0.0)]);
    let table = Table::for_data(&tf, &floats(0.0, 1e6)).unwrap();
    let bend = Bend::of_steps(&StepTable::new(&table, 1.0).unwrap());
    assert_eq!(bend.over(2.0, 1e6, 0.25), 0.0);
    assert!(bend.over(0.0, 1e6, 1e5) >= 0.25 && bend.over(0.9, 1.1, 0.2) >= 0.1);
}

/// Points of any spacing, from a billionth of the range to all of it, with jumps.
fn any_function() -> impl Strategy<Value = TransferFunction> {
    let kind = prop_oneof![Just(Interpolation::Linear), Just(Interpolation::Step), Just(Interpolation::Smooth)];
    let point = (-9.0f64..0.0, 0.0f32..=0.99, kind, 0u32..0x100_0000);
    prop::collection::vec(point, 1..12).prop_map(|points| {
        let mut value = 0.0;
        let (mut opacities, mut colors) = (Vec::new(), Vec::new());
        for (i, (distance, opacity, interpolation, hex)) in points.into_iter().enumerate() {
            // Every fourth is a jump.
            if i % 4 != 2 {
                value += 1000.0 * 10f64.powf(distance);
            }
            opacities.push(OpacityPoint { value, opacity, interpolation });
            colors.push(ColorPoint { value, color: Color::hex(hex), interpolation });
        }
        TransferFunction::new(colors, opacities).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn tables_follow_the_curve_wherever_it_goes(
        tf in any_function(),
        shares in prop::collection::vec(0.0f64..1.0, 32),
        spacing in prop_oneof![Just(None), Just(Some(1.0)), Just(Some(0.25))],
    ) {
        let data = DataRange { low: 0.0, high: 2000.0, level_spacing: spacing };
        let table = Table::for_data(&tf, &data).unwrap();
        let points: Vec<f64> = tf.opacities().iter().map(|point| point.value).collect();
        // Where anything can go wrong: between any two points, however near.
        for pair in points.windows(2) {
            // Where single precision has too few numbers, it has no curve.
            if pair[1] - pair[0] < 300.0 * f64::from(f32::EPSILON) * pair[1] {
                continue;
            }
            for share in &shares {
                let value = ((pair[0] + (pair[1] - pair[0]) * share) as f32).min(2000.0);
                // Single precision may not tell which side of a point a value is on.
                if points.iter().any(|point| (point - f64::from(value)).abs() < 4.0 * f64::from(f32::EPSILON * value)) {
                    continue;
                }
                let (found, exact) = (table.lookup(value), tf.opacity(f64::from(value)));
                prop_assert!((found[3] - exact).abs() < 2e-3, "{:?} at {}: {} {}", points, value, found[3], exact);
                let color = tf.color(f64::from(value));
                for c in 0..3 {
                    prop_assert!((found[c] - color[c]).abs() < 1.0 / 128.0, "{:?} at {}: {:?} {:?}", points, value, found, color);
                }
            }
        }
    }
}
