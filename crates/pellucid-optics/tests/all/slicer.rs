//! Volume properties of 3D Slicer, read and written.

use pellucid_optics::{
    Color, ColorPoint, ColorSpace, Interpolation, Material, OpacityPoint, OpticsError, TransferFunction, VolumeProperty,
};
use proptest::prelude::*;

/// A file as the schema describes it, with curves and further fields put in.
fn file(component: &str, property: &str) -> String {
    format!(
        r##"{{ "@schema": "https://raw.githubusercontent.com/Slicer/Slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#",
        "volumeProperties": [{{ {property} "effectiveRange": [-1000, 5000], "isoSurfaceValues": [], "independentComponents": true,
            "interpolationType": "linear", "useClippedVoxelIntensity": false, "clippedVoxelIntensity": -1e10, "scatteringAnisotropy": 0.0,
            "components": [{{ {component}, "componentWeight": 1.0 }}] }}] }}"##
    )
}

const CURVES: &str = r#"
    "scalarOpacity": { "points": [
        { "x": -3024, "y": 0, "midpoint": 0.5, "sharpness": 0 },
        { "x": 143.5, "y": 0.2, "midpoint": 0.5, "sharpness": 0 },
        { "x": 30000, "y": 0.8, "midpoint": 0.5, "sharpness": 0 }] },
    "rgbTransferFunction": { "points": [
        { "x": -3024, "color": [0, 0, 0], "midpoint": 0.5, "sharpness": 0 },
        { "x": 640, "color": [1, 0.5, 0.25], "midpoint": 0.5, "sharpness": 0 }] }"#;

#[test]
fn a_file_is_read_with_all_its_points() {
    let lighting = r#""shade": true, "lighting": { "ambient": 0.1, "diffuse": 0.9, "specular": 0.2, "specularPower": 10 },
        "scalarOpacityUnitDistance": 0.89, "gradientOpacity": { "points": [
            { "x": 0, "y": 1, "midpoint": 0.5, "sharpness": 0 }, { "x": 255, "y": 1, "midpoint": 0.5, "sharpness": 0 }] },"#;
    let (properties, warnings) = VolumeProperty::from_slicer(&file(&format!("{lighting} {CURVES}"), "")).unwrap();
    assert_eq!(warnings, []);
    let [property] = &properties[..] else { panic!("{properties:?}") };
    // Far outside any CT, and kept.
    assert_eq!(property.transfer_function.hull(), [-3024.0, 30_000.0]);
    assert_eq!(property.transfer_function.opacities()[1], OpacityPoint::new(143.5, 0.2));
    assert_eq!(property.transfer_function.colors()[1], ColorPoint::new(640.0, Color::new([1.0, 0.5, 0.25]).unwrap()));
    assert_eq!(property.transfer_function.unit_distance(), Some(0.89));
    assert_eq!(property.transfer_function.color_space(), ColorSpace::Srgb);
    assert_eq!(property.gradient_opacity, [OpacityPoint::new(0.0, 1.0), OpacityPoint::new(255.0, 1.0)]);
    assert!(property.shading);
    let expected = Material { ambient: 0.1, diffuse: 0.9, specular: 0.2, shininess: 10.0, ..Material::default() };
    assert_eq!(property.material, expected);
    // Defaults of the schema, where they differ from ours.
    let (properties, _) = VolumeProperty::from_slicer(&file(CURVES, "")).unwrap();
    assert_eq!((properties[0].material.diffuse, properties[0].material.shininess), (0.7, 10.0));
    assert_eq!((properties[0].shading, properties[0].transfer_function.unit_distance()), (false, Some(1.0)));
}

/// Midpoint and sharpness of the way to the next point.
type Way = (f64, f64);

/// `GetValue` of VTK 9.7's opacity and (red) colour functions at 0.1, 0.2, ... 0.9 between a
/// point of 0 at 0 with this midpoint and sharpness and one of 1 at 1.
#[rustfmt::skip]
const VTK: [(Way, [[f64; 9]; 2]); 6] = [
    ((0.5, 0.0), [
        [0.10000, 0.20000, 0.30000, 0.40000, 0.50000, 0.60000, 0.70000, 0.80000, 0.90000],
        [0.10000, 0.20000, 0.30000, 0.40000, 0.50000, 0.60000, 0.70000, 0.80000, 0.90000],
    ]),
    ((0.2, 0.0), [
        [0.25000, 0.50000, 0.56250, 0.62500, 0.68750, 0.75000, 0.81250, 0.87500, 0.93750],
        [0.25000, 0.50000, 0.56250, 0.62500, 0.68750, 0.75000, 0.81250, 0.87500, 0.93750],
    ]),
    ((0.25, 1.0), [
        [0.00000, 0.00538, 0.86127, 0.99462, 0.99990, 1.00000, 1.00000, 1.00000, 1.00000],
        [0.00000, 0.00000, 1.00000, 1.00000, 1.00000, 1.00000, 1.00000, 1.00000, 1.00000],
    ]),
    ((0.5, 0.98), [
        [0.00000, 0.00000, 0.00005, 0.00665, 0.50000, 0.99335, 0.99995, 1.00000, 1.00000],
        [0.00000, 0.00000, 0.00005, 0.00665, 0.50000, 0.99335, 0.99995, 1.00000, 1.00000],
    ]),
    ((0.7, 0.3), [
        [0.00015, 0.00234, 0.01206, 0.03978, 0.10503, 0.24268, 0.50000, 0.92266, 0.99564],
        [0.00015, 0.00234, 0.01206, 0.03978, 0.10503, 0.24268, 0.50000, 0.92266, 0.99564],
    ]),
    ((0.2, 0.05), [
        [0.17207, 0.50000, 0.59295, 0.67908, 0.75765, 0.82793, 0.88909, 0.94006, 0.97894],
        [0.17207, 0.50000, 0.59295, 0.67908, 0.75765, 0.82793, 0.88909, 0.94006, 0.97894],
    ]),
];

#[test]
fn midpoint_and_sharpness_are_those_of_vtk() {
    for ((midpoint, sharpness), [opacity, red]) in VTK {
        let way = format!(r#""midpoint": {midpoint}, "sharpness": {sharpness}"#);
        let end = r#""midpoint": 0.5, "sharpness": 0"#;
        let curve = format!(
            r#""scalarOpacity": {{ "points": [{{ "x": 0, "y": 0, {way} }}, {{ "x": 1, "y": 1, {end} }}] }},
              "grayTransferFunction": {{ "points": [{{ "x": 0, "y": 0, {way} }}, {{ "x": 1, "y": 1, {end} }}] }}"#
        );
        let (properties, warnings) = VolumeProperty::from_slicer(&file(&curve, "")).unwrap();
        let tf = properties[0].transfer_function.clone().with_color_space(ColorSpace::Linear);
        for i in 0..9 {
            let x = (i + 1) as f64 / 10.0;
            let found = [tf.opacity(x), tf.color(x)[0]].map(|v| v as f64);
            let what = format!("midpoint {midpoint}, sharpness {sharpness} at {x}");
            assert!((found[0] - opacity[i]).abs() < 1.1e-3, "{what}: {found:?}, VTK {}", opacity[i]);
            assert!((found[1] - red[i]).abs() < 1.1e-3, "{what}: {found:?}, VTK {}", red[i]);
        }
        // Straight ways, and steps of colours, are exact.
        let lists: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let expected = if sharpness == 0.0 {
            0
        } else if sharpness == 1.0 {
            1
        } else {
            2
        };
        assert_eq!(lists.len(), expected, "{lists:?}");
    }
}

#[test]
fn steps_and_jumps_survive() {
    let point = |value, opacity, interpolation| OpacityPoint { value, opacity, interpolation };
    use Interpolation::{Linear, Step};
    let points = vec![
        point(-1.0, 0.3, Linear),
        point(0.0, 0.1, Linear),
        point(0.0, 0.8, Step),
        point(2.0, 0.5, Step),
        point(3.0, 0.4, Linear),
        point(3.0, 0.9, Linear),
        point(4.0, 0.0, Linear),
    ];
    let tf = TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap();
    let property = VolumeProperty {
        transfer_function: tf.clone(),
        gradient_opacity: Vec::new(),
        material: Material::default(),
        shading: false,
    };
    let (text, _) = VolumeProperty::to_slicer(&[property], 1.0).unwrap();
    // VTK keeps one point per value.
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let written = document["volumeProperties"][0]["components"][0]["scalarOpacity"]["points"].as_array().unwrap();
    let values: Vec<f64> = written.iter().map(|point| point["x"].as_f64().unwrap()).collect();
    assert!(values.windows(2).all(|pair| pair[0] < pair[1]), "{values:?}");
    let (back, warnings) = VolumeProperty::from_slicer(&text).unwrap();
    assert_eq!(warnings, []);
    for i in -150..=450 {
        for x in [i as f64 / 100.0, i as f64 / 100.0 - 1e-9] {
            assert!((back[0].transfer_function.opacity(x) - tf.opacity(x)).abs() < 1e-6, "{x}");
        }
    }
}

#[test]
fn what_is_not_understood_is_said() {
    let lighting =
        r#""lighting": { "ambient": 1.5, "diffuse": 0.7, "specular": 0.2, "specularPower": 0 }, "sparkle": 3,"#;
    let text = file(&format!("{lighting} {CURVES}"), r#""isoSurfaceValues2": [7],"#).replace("\"linear\"", "\"cubic\"");
    let (_, warnings) = VolumeProperty::from_slicer(&text).unwrap();
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let expected = [
        "interpolationType = \"cubic\" is ignored",
        "isoSurfaceValues2 = [7] is ignored",
        "sparkle = 3 is ignored",
        "ambient 1.5 is read as 1",
        "specularPower 0 is read as 1",
    ];
    assert_eq!(said, expected);
}

#[test]
fn files_that_cannot_be_used_are_errors() {
    let unsorted = CURVES.replace("143.5", "-5000");
    let opaque = CURVES.replace("\"y\": 0.8", "\"y\": 8");
    let bright = CURVES.replace("0.25", "2.5");
    for (text, expected) in [
        ("{", "line 1"),
        (
            "{ \"@schema\": \"markups-schema-v1.0.3.json\", \"volumeProperties\": [] }",
            "expected volume-property-schema",
        ),
        (&file("\"shade\": true", ""), "has no points"),
        (&file(&unsorted, ""), "opacities, point 1 (value -5000)"),
        (&file(&opaque, ""), "opacity is 8"),
        (&file(&bright, ""), "rgbTransferFunction, point 1"),
        (&file(&format!("\"scalarOpacityUnitDistance\": 0, {CURVES}"), ""), "unit_distance is 0"),
    ] {
        let message = VolumeProperty::from_slicer(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn what_cannot_be_written_is_said() {
    let smooth = OpacityPoint { interpolation: Interpolation::Smooth, ..OpacityPoint::new(0.0, 0.1) };
    let jump = [OpacityPoint::new(3.0, 0.2), OpacityPoint::new(3.0, 0.9)];
    let colors = vec![ColorPoint::new(0.0, Color::BLACK), ColorPoint::new(1.0, Color::new([0.214_041_14; 3]).unwrap())];
    let tf = TransferFunction::new(colors, [&[smooth][..], &[OpacityPoint::new(2.0, 0.8)], &jump].concat()).unwrap();
    let property = VolumeProperty {
        transfer_function: tf.clone().with_color_space(ColorSpace::Linear),
        gradient_opacity: Vec::new(),
        material: Material { emission: 1.0, two_sided: false, ..Material::default() },
        shading: true,
    };
    let (text, warnings) = VolumeProperty::to_slicer(&[property], 0.4).unwrap();
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let expected = [
        "emission of a material cannot be written",
        "a one-sided material cannot be written",
        "interpolation of colours in linear light cannot be written",
        "scalarOpacity, point 0: the curve to the next point is now straight lines, within 1/1000",
    ];
    assert_eq!(said, expected);
    let (back, _) = VolumeProperty::from_slicer(&text).unwrap();
    let back = &back[0].transfer_function;
    assert_eq!(back.unit_distance(), Some(0.4));
    // Half in light is 0.5 on the screen; points keep their colour.
    assert!((back.colors()[1].color.rgb()[0] - 0.5).abs() < 1e-6);
    for i in 0..=400 {
        let x = i as f64 / 100.0;
        assert!((back.opacity(x) - tf.opacity(x)).abs() < 2e-3, "{x}");
    }
    assert!(matches!(VolumeProperty::to_slicer(&[], 0.0), Err(OpticsError::Parameter { .. })));
}

proptest! {
    #[test]
    fn round_trip(
        colors in prop::collection::btree_map(-4000i32..4000, [0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0], 1..6),
        opacities in prop::collection::btree_map(-4000i32..4000, 0.0f32..=1.0, 1..6),
        gradient in prop::collection::btree_map(0i32..400, 0.0f32..=1.0, 0..3),
        unit in 0.001f64..100.0, diffuse in 0.0f32..=1.0, shininess in 1.0f32..=200.0, shading: bool,
    ) {
        let colors = colors.into_iter().map(|(x, rgb)| ColorPoint::new(x as f64 / 3.0, Color::new(rgb).unwrap()));
        let opacities = opacities.into_iter().map(|(x, y)| OpacityPoint::new(x as f64 / 3.0, y));
        let tf = TransferFunction::new(colors.collect(), opacities.collect()).unwrap();
        let property = VolumeProperty {
            transfer_function: tf.with_unit_distance(Some(unit)).unwrap(),
            gradient_opacity: gradient.into_iter().map(|(x, y)| OpacityPoint::new(x as f64, y)).collect(),
            material: Material { diffuse, shininess, ..Material::default() },
            shading,
        };
        let both = [property.clone(), property];
        let (text, warnings) = VolumeProperty::to_slicer(&both, 1.0).unwrap();
        prop_assert_eq!(warnings, []);
        let (back, warnings) = VolumeProperty::from_slicer(&text).unwrap();
        prop_assert_eq!(warnings, []);
        prop_assert_eq!(&back[..], &both);
    }
}
