//! Tables, step tables and visibility against the exact curves and brute force.

use pellucid_optics::{
    Color, ColorPoint, ColorSpace, DataRange, ExtinctionBounds, Interpolation, OpacityPoint, StepTable, Table,
    TransferFunction, Visibility, correct_opacity, path_extinction,
};
use proptest::prelude::*;

fn opacities(points: &[(f64, f32)]) -> TransferFunction {
    let white = vec![ColorPoint::new(points[0].0, Color::WHITE)];
    let points = points.iter().map(|&(value, opacity)| OpacityPoint::new(value, opacity)).collect();
    TransferFunction::new(white, points).unwrap()
}

const FLOATS: DataRange = DataRange { low: 0.0, high: 1.0, level_spacing: None };

#[test]
fn identity_is_exact_at_every_node() {
    // 4.1-4, and between the nodes too: the identity is straight.
    let tf = opacities(&[(0.0, 0.0), (1.0, 1.0)]);
    for entries in [2, 256, 4096, 65_536] {
        let table = Table::build(&tf, [0.0, 1.0], entries).unwrap();
        for i in 0..entries {
            let value = i as f32 / (entries - 1) as f32;
            assert!((table.lookup(value)[3] - value).abs() < 1e-6);
            assert!((table.entries()[i][3] - value).abs() < 1e-6);
        }
        assert!((table.lookup(0.123_456)[3] - 0.123_456).abs() < 1e-6);
        assert_eq!(table.lookup(-5.0)[3], 0.0);
        assert_eq!(table.lookup(5.0)[3], 1.0);
    }
}

#[test]
fn invisible_samples_lend_no_color() {
    // 3.2-8: between transparent red and opaque blue.
    let red_to_blue = [ColorPoint::new(0.0, Color::hex(0xff0000)), ColorPoint::new(1.0, Color::hex(0x0000ff))];
    let alpha = vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, 1.0)];
    let tf = TransferFunction::new(red_to_blue.to_vec(), alpha).unwrap().with_color_space(ColorSpace::Linear);
    let table = Table::build(&tf, [0.0, 1.0], 2).unwrap();
    assert_eq!(table.lookup(0.5), [0.5, 0.0, 0.5, 0.5]);
    let step = StepTable::new(&table, 1.0).unwrap();
    assert_eq!(step.lookup(0.5), [0.0, 0.0, 0.5, 0.5]);
    // Over black, the non-associated midpoint would have shown red.
    let [r, g, b, a] = table.lookup(0.5);
    assert_eq!([r * a, g * a, b * a], [0.25, 0.0, 0.25]);
}

#[test]
fn step_table_holds_the_opacity_of_a_step() {
    let tf = opacities(&[(0.0, 0.0), (0.4, 0.3), (1.0, 1.0)]);
    let table = Table::for_data(&tf, &FLOATS).unwrap();
    let step = StepTable::new(&table, 0.25).unwrap();
    for value in [0.0f32, 0.1, 0.4, 0.77, 1.0] {
        let expected = correct_opacity(tf.opacity(value as f64), 0.25);
        assert!((step.lookup(value)[3] - expected).abs() < 1e-3, "{value}");
        assert_eq!(step.lookup(value)[0], step.lookup(value)[3]);
    }
    for absent in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(step.lookup(absent), [0.0; 4]);
        assert_eq!(table.lookup(absent), [0.0; 4]);
    }
    assert!(StepTable::new(&table, -1.0).is_err() && StepTable::new(&table, f32::NAN).is_err());
}

#[test]
fn integer_data_have_a_node_at_every_level() {
    // A CT: stored 12 bit, Hounsfield units from -1024 to 3071, a function of 300 to 1700 HU.
    let smooth = opacities(&[(300.0, 0.0), (301.0, 0.2), (1699.0, 0.9), (1700.0, 0.0)]);
    let ct = DataRange { low: -1024.0, high: 3071.0, level_spacing: Some(1.0) };
    let nodes = Table::for_data(&smooth, &ct).unwrap().nodes().clone();
    assert_eq!((nodes.domain(), nodes.count()), ([299.0, 1701.0], 1403));
    // With a jump and a corner between levels, which have nodes of their own (see placement.rs).
    let jumping = opacities(&[(300.0, 0.0), (300.0, 0.2), (1699.5, 0.9), (1700.0, 0.0)]);
    for tf in [smooth, jumping] {
        let table = Table::for_data(&tf, &ct).unwrap();
        for level in -1024..=3071 {
            assert!((table.lookup(level as f32)[3] - tf.opacity(level as f64)).abs() < 1e-6, "{level}");
        }
    }
    // 8-bit data with a slope, and a mask: levels are subdivided to 256 nodes or more.
    for (low, high, spacing) in [(-1.0, -1.0 + 255.0 * 0.25, 0.25), (0.0, 1.0, 1.0), (7.0, 7.0, 1.0)] {
        let data = DataRange { low, high, level_spacing: Some(spacing) };
        let tf = opacities(&[(-2.0, 0.1), (0.75, 0.8), (90.0, 0.3)]);
        let table = Table::for_data(&tf, &data).unwrap();
        assert!((256..=65_536).contains(&table.nodes().count()));
        let mut level = low;
        while level <= high {
            assert!((table.lookup(level as f32)[3] - tf.opacity(level)).abs() < 1e-6, "{level}");
            level += spacing;
        }
    }
    // All of 16 bit is exactly the largest table.
    let all = DataRange { low: 0.0, high: 65_535.0, level_spacing: Some(1.0) };
    let table = Table::for_data(&opacities(&[(0.0, 0.0), (65_535.0, 1.0)]), &all).unwrap();
    assert_eq!((table.nodes().count(), table.nodes().domain()), (65_536, [0.0, 65_535.0]));
    // More levels than that are treated as a continuum.
    let wide = DataRange { low: 0.0, high: 1e9, level_spacing: Some(1.0) };
    let table = Table::for_data(&opacities(&[(0.0, 0.0), (1e9, 1.0)]), &wide).unwrap();
    assert!((table.lookup(5e8)[3] - 0.5).abs() < 1e-4);
}

#[test]
fn functions_outside_the_data_are_constant_on_it() {
    for (points, expected) in [([(5.0, 0.1), (6.0, 0.9)], 0.1), ([(-5.0, 0.1), (-4.0, 0.9)], 0.9)] {
        for level_spacing in [None, Some(0.25)] {
            let table = Table::for_data(&opacities(&points), &DataRange { level_spacing, ..FLOATS }).unwrap();
            for value in [0.0, 0.25, 0.6, 1.0] {
                assert!((table.lookup(value)[3] - expected).abs() < 1e-6, "{points:?} at {value}");
            }
        }
    }
    assert!(
        Table::for_data(&opacities(&[(0.0, 1.0)]), &DataRange { low: 1.0, high: 0.0, level_spacing: None }).is_err()
    );
    assert!(Table::build(&opacities(&[(0.0, 1.0)]), [0.0, f64::INFINITY], 256).is_err());
    assert!(Table::build(&opacities(&[(0.0, 1.0)]), [0.0, 1.0], 1).is_err());
}

#[test]
fn a_jump_at_the_end_of_the_hull_is_kept() {
    let tf = opacities(&[(0.5, 0.0), (0.5, 0.8)]);
    let table = Table::for_data(&tf, &FLOATS).unwrap();
    assert_eq!(table.lookup(0.4999)[3], 0.0);
    assert!((table.lookup(0.5001)[3] - 0.8).abs() < 1e-6);
}

#[test]
fn visibility_of_a_single_peak() {
    let tf = opacities(&[(0.0, 0.0), (99.0, 0.0), (100.0, 0.5), (101.0, 0.0), (255.0, 0.0)]);
    let data = DataRange { low: 0.0, high: 255.0, level_spacing: Some(1.0) };
    let visibility = Visibility::of_table(&Table::for_data(&tf, &data).unwrap());
    assert!(!visibility.any_opacity(0.0, 99.0) && !visibility.any_opacity(101.0, 255.0));
    assert!(visibility.any_opacity(0.0, 99.01) && visibility.any_opacity(100.5, 100.5));
    assert_eq!(visibility.max_opacity(0.0, 255.0), 0.5);
    assert!(visibility.any_opacity(f32::NEG_INFINITY, f32::INFINITY));
    for (low, high) in [(f32::NAN, 100.0), (100.0, f32::NAN), (101.0, 99.0)] {
        assert!(!visibility.any_opacity(low, high));
    }
}

/// Random points with plateaus of exactly no opacity, ascending, with jumps and every interpolation.
fn any_function() -> impl Strategy<Value = TransferFunction> {
    let interpolation =
        prop_oneof![Just(Interpolation::Linear), Just(Interpolation::Step), Just(Interpolation::Smooth)];
    let point = (0u32..40, prop_oneof![Just(0.0f32), 0.0f32..=1.0], interpolation);
    prop::collection::vec(point, 1..9).prop_map(|mut points| {
        points.sort_by_key(|point| point.0);
        // At most two at one value.
        let mut kept: Vec<OpacityPoint> = Vec::new();
        for (value, opacity, interpolation) in points {
            let value = value as f64 / 40.0;
            if kept.iter().filter(|point| point.value == value).count() < 2 {
                kept.push(OpacityPoint { value, opacity, interpolation });
            }
        }
        TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], kept).unwrap()
    })
}

proptest! {
    #[test]
    fn no_visibility_is_exactly_no_opacity(tf in any_function(), a in -0.1f32..1.1, b in -0.1f32..1.1) {
        // 7.3-6, against every node in the interval and its ends.
        let table = Table::build(&tf, [0.0, 1.0], 301).unwrap();
        let visibility = Visibility::of_table(&table);
        let (low, high) = (a.min(b), a.max(b));
        let nodes = (0..301).map(|i| table.nodes().value(i) as f32).filter(|value| (low..=high).contains(value));
        let most = nodes.chain([low, high]).map(|value| table.lookup(value)[3]).fold(0.0, f32::max);
        prop_assert_eq!(visibility.any_opacity(low, high), most > 0.0);
        prop_assert!(visibility.max_opacity(low, high) >= most);
        // The bound is no looser than the neighbouring nodes.
        let wider = table.lookup(low - 1.0 / 300.0)[3].max(table.lookup(high + 1.0 / 300.0)[3]).max(most);
        let beyond = (0..301).filter(|&i| {
            let value = table.nodes().value(i) as f32;
            value >= low - 1.0 / 300.0 && value <= high + 1.0 / 300.0
        });
        let wider = beyond.map(|i| table.entries()[i][3]).fold(wider, f32::max);
        prop_assert!(visibility.max_opacity(low, high) <= wider + 1e-6);
    }

    #[test]
    fn extinctions_are_bounded_by_the_nodes_around_them(tf in any_function(), a in -0.1f32..1.1, b in -0.1f32..1.1) {
        let table = Table::build(&tf, [0.0, 1.0], 301).unwrap();
        let (low, high) = (a.min(b), a.max(b));
        let [least, most] = ExtinctionBounds::new(&table, 0.5).over(low, high);
        let (first, last) = (table.nodes().clamped_position(low) as usize, table.nodes().clamped_position(high).ceil());
        let nodes = (first..=last as usize).map(|node| path_extinction(table.entries()[node][3], 0.5));
        let (lowest, highest) = nodes.fold((f32::INFINITY, 0.0), |(low, high), v| (v.min(low), v.max(high)));
        prop_assert_eq!([least, most], [lowest, highest]);
        prop_assert_eq!(ExtinctionBounds::new(&table, 0.5).over(high + 1e-3, low), [0.0; 2]);
        prop_assert_eq!(ExtinctionBounds::new(&table, 0.5).over(f32::NAN, low), [0.0; 2]);
    }

    #[test]
    fn chosen_tables_follow_the_curve(tf in any_function(), values in prop::collection::vec(0.0f64..1.0, 64)) {
        let table = Table::for_data(&tf, &FLOATS).unwrap();
        let cell = 1.0 / 16_000.0;
        for value in values {
            // Within one cell of a jump there is a ramp instead.
            let near_jump = (tf.opacity(value - cell) - tf.opacity(value + cell)).abs() > 0.01;
            let error = (table.lookup(value as f32)[3] - tf.opacity(value as f32 as f64)).abs();
            prop_assert!(near_jump || error < 1.5 / 1024.0, "{} entries, error {} at {}", table.nodes().count(), error, value);
        }
    }
}
