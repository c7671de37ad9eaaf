//! The transfer function: curves by hand, documents, messages.

use pellucid_optics::{
    Color, ColorPoint, ColorSpace, Interpolation, OpacityPoint, OpticsError, TransferFunction, srgb_decode,
};
use proptest::prelude::*;

fn parse(json: &str) -> Result<TransferFunction, serde_json::Error> {
    serde_json::from_str(json)
}

fn white(opacities: Vec<OpacityPoint>) -> Result<TransferFunction, OpticsError> {
    TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], opacities)
}

#[test]
fn defaults_are_as_documented() {
    let tf = parse(r##"{ "colors": [[0, "#ffffff"]], "opacities": [[0, 0.5]] }"##).unwrap();
    assert_eq!(tf.color_space(), ColorSpace::Srgb);
    assert_eq!(tf.unit_distance(), None);
    assert_eq!(tf.opacities()[0].interpolation, Interpolation::Linear);
    assert_eq!(Interpolation::default(), Interpolation::Linear);
    assert_eq!(ColorSpace::default(), ColorSpace::Srgb);
}

#[test]
fn curves_have_the_values_computed_by_hand() {
    let tf = parse(
        r##"{ "colors": [[0, "#000000"], [100, "#ffffff"]],
             "opacities": [[0, 0], { "value": 10, "opacity": 0.4, "interpolation": "step" },
                           { "value": 20, "opacity": 0.2, "interpolation": "smooth" }, [30, 1], [30, 0.1], [40, 0.3]] }"##,
    )
    .unwrap();
    for (value, opacity) in [
        (-1e9, 0.0),
        (5.0, 0.2),
        (10.0, 0.4),
        (19.999, 0.4),
        (20.0, 0.2),
        (22.5, 0.2 + 0.8 * 0.15625), // smoothstep(1/4) = 5/32
        (25.0, 0.6),
        (30.0, 0.1), // the upper side of the jump
        (35.0, 0.2),
        (40.0, 0.3),
        (1e9, 0.3),
    ] {
        assert!((tf.opacity(value) - opacity).abs() < 1e-6, "{value}: {}", tf.opacity(value));
    }
    assert!((tf.opacity(30.0 - 1e-9) - 1.0).abs() < 1e-6);
    // Halfway between black and white on the screen, 0.214 in light; half in light if linear.
    assert!((tf.color(50.0)[1] - 0.214_041_14).abs() < 1e-6);
    assert!((tf.clone().with_color_space(ColorSpace::Linear).color(50.0)[1] - 0.5).abs() < 1e-6);
    assert_eq!(tf.hull(), [0.0, 100.0]);
    for absent in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!((tf.opacity(absent), tf.color(absent)), (0.0, [0.0; 3]));
    }
}

#[test]
fn mistakes_are_named() {
    let message = |points: &[(f64, f32)]| {
        let points = points.iter().map(|&(value, opacity)| OpacityPoint::new(value, opacity)).collect();
        white(points).unwrap_err().to_string()
    };
    assert_eq!(message(&[]), "opacities has no points: at least one is needed");
    assert_eq!(
        message(&[(0.0, 0.1), (5.0, 255.0)]),
        "opacities, point 1 (value 5): opacity is 255: expected 0 to 1 (not 0 to 255)"
    );
    assert!(message(&[(0.0, f32::NAN)]).contains("point 0"));
    assert!(message(&[(0.0, 0.0), (f64::NAN, 0.0)]).contains("point 1 (value NaN): the value must be finite"));
    assert!(message(&[(0.0, 0.0), (1e300, 0.0)]).contains("finite"));
    assert!(message(&[(2.0, 0.0), (1.0, 0.0)]).contains("must ascend, the one before is at 2"));
    assert!(message(&[(1.0, 0.0), (1.0, 0.0), (1.0, 0.5)]).contains("point 2 (value 1): a third point"));
    for (json, expected) in [
        (r##"{ "colors": [[0, "tartan"]], "opacities": [[0, 1]] }"##, "#rrggbb"),
        (r##"{ "colors": [[0, "whitr"]], "opacities": [[0, 1]] }"##, "did you mean white?"),
        (
            r##"{ "colors": [[0, "#ffffff"]], "opacities": [[0, 1, 2]] }"##,
            "invalid length 3, expected [value, opacity]",
        ),
        (r##"{ "colors": [[0, "#ffffff"]], "opacities": [{ "value": 0, "opactiy": 1 }] }"##, "unknown field `opactiy`"),
        (r##"{ "colors": [[0, "#ffffff"]], "opacities": [0.5] }"##, "[value, opacity]"),
        (r##"{ "colors": [[0, "#ffffff"]], "opacities": [[0, 2]] }"##, "opacities, point 0"),
        (r##"{ "colors": [[0, "#ffffff"]], "opacities": [[0, 1]], "unit_distance": 0 }"##, "unit_distance is 0"),
        (r##"{ "colors": [[0, "#ffffff"]], "opacities": [[0, 1]], "colour_space": "srgb" }"##, "colour_space"),
    ] {
        let message = parse(json).unwrap_err().to_string();
        assert!(message.contains(expected), "{json}: {message}");
    }
}

#[test]
fn remap_moves_the_curve_with_its_window() {
    let tf =
        white(vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(0.25, 1.0), OpacityPoint::new(1.0, 0.5)]).unwrap();
    let moved = tf.clone().with_unit_distance(Some(2.0)).unwrap().remap([0.0, 1.0], [-1000.0, 3000.0]).unwrap();
    assert_eq!(moved.unit_distance(), Some(2.0));
    assert_eq!(moved.hull(), [-1000.0, 3000.0]);
    for t in [-0.5, 0.0, 0.1, 0.25, 0.6, 1.0, 7.0] {
        assert!((moved.opacity(-1000.0 + 4000.0 * t) - tf.opacity(t)).abs() < 1e-6);
    }
    assert!(tf.clone().remap([0.0, 0.0], [0.0, 1.0]).is_err());
    assert!(tf.clone().remap([0.0, 1.0], [1.0, 0.0]).is_err());
    assert!(tf.remap([0.0, 1e-30], [0.0, 1e30]).is_err());
}

#[test]
fn the_schema_describes_both_forms() {
    let schema = serde_json::to_value(schemars::schema_for!(TransferFunction)).unwrap();
    assert_eq!(schema["required"], serde_json::json!(["colors", "opacities"]));
    assert_eq!(schema["additionalProperties"], false);
    let definitions = &schema["$defs"];
    assert_eq!(definitions["Color"]["anyOf"][0]["pattern"], "^(#[0-9a-fA-F]{6}|#[0-9a-fA-F]{3}|[a-zA-Z]+)$");
    assert_eq!(definitions["Color"]["anyOf"][1]["maxItems"], 3);
    assert_eq!(definitions["Color"]["anyOf"][1]["items"]["maximum"], 1.0);
    for (point, property) in [("ColorPoint", "color"), ("OpacityPoint", "opacity")] {
        let text = definitions.to_string();
        assert!(definitions[point]["anyOf"].as_array().is_some_and(|forms| forms.len() == 2), "{text}");
        assert!(text.contains(&format!("\"{property}\"")));
    }
}

fn any_point<T: std::fmt::Debug + Clone>(
    of: impl Strategy<Value = T>,
) -> impl Strategy<Value = (f64, T, Interpolation)> {
    let interpolation =
        prop_oneof![Just(Interpolation::Linear), Just(Interpolation::Step), Just(Interpolation::Smooth)];
    (-1e6f64..1e6, of, interpolation)
}

proptest! {
    #[test]
    fn documents_round_trip(
        mut colors in prop::collection::vec(any_point([0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0]), 1..6),
        mut opacities in prop::collection::vec(any_point(0.0f32..=1.0), 1..6),
        linear: bool,
        unit_distance in prop::option::of(1e-6f64..1e6),
        value in -1.1e6f64..1.1e6,
    ) {
        colors.sort_by(|a, b| a.0.total_cmp(&b.0));
        opacities.sort_by(|a, b| a.0.total_cmp(&b.0));
        let color = |(value, rgb, interpolation)| ColorPoint { value, color: Color::new(rgb).unwrap(), interpolation };
        let opacity = |(value, opacity, interpolation)| OpacityPoint { value, opacity, interpolation };
        let tf = TransferFunction::new(colors.into_iter().map(color).collect(), opacities.into_iter().map(opacity).collect())
            .unwrap()
            .with_color_space(if linear { ColorSpace::Linear } else { ColorSpace::Srgb })
            .with_unit_distance(unit_distance)
            .unwrap();
        prop_assert_eq!(&parse(&serde_json::to_string(&tf).unwrap()).unwrap(), &tf);
        // Results stay in range whatever the points.
        prop_assert!((0.0..=1.0).contains(&tf.opacity(value)));
        prop_assert!(tf.color(value).iter().all(|v| (0.0..=1.0).contains(v)));
    }
}

#[test]
fn srgb_points_are_decoded_once() {
    let tf = parse(r##"{ "colors": [[0, "#804020"]], "opacities": [[0, 1]] }"##).unwrap();
    assert_eq!(tf.color(3.0), [128.0 / 255.0, 64.0 / 255.0, 32.0 / 255.0].map(srgb_decode));
}
