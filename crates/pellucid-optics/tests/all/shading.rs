//! Materials, lights and shading against hand computation and the laws of light.

use glam::{DAffine3, DVec3, Vec3};
use pellucid_optics::{
    Color, Falloff, Frame, GradientWeight, Incident, Light, LightKind, Lighting, Material, blinn_phong,
};
use proptest::prelude::*;

const UP: Vec3 = Vec3::Z;

/// A direction in the xz plane, at this angle from +z.
fn tilted(degrees: f32) -> Vec3 {
    Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos())
}

fn white(to_light: Vec3) -> Incident {
    Incident { to_light, radiance: [1.0; 3], specular: true }
}

fn shaded(material: &Material, normal: Vec3, to_eye: Vec3, light: Incident) -> [f32; 3] {
    blinn_phong(material, [1.0, 0.5, 0.25], normal, to_eye, 0.3, [light])
}

#[test]
fn hand_computed_vectors() {
    let usual = Material::default();
    let sharp = |shininess| Material { shininess, ..usual };
    let one_sided = Material { two_sided: false, ..usual };
    let red = Incident { radiance: [0.5, 0.0, 0.0], ..white(UP) };
    let fill = Incident { specular: false, ..white(UP) };
    let glowing = Material { emission: 0.7, ..usual };
    // In each: 0.1 * 0.3 of the base, 0.6 cos(n, l) of it, 0.2 cos(n, h)^shininess of white.
    let cases = [
        ("head-on", usual, UP, UP, white(UP), [0.83, 0.515, 0.3575]),
        ("light at 60 degrees", sharp(2.0), UP, UP, white(tilted(60.0)), [0.48, 0.315, 0.2325]),
        ("mirror direction", usual, UP, tilted(-60.0), white(tilted(60.0)), [0.53, 0.365, 0.2825]),
        // cos 22.5^4 = 0.728553, cos 45 = 0.707107
        ("light at 45 degrees", sharp(4.0), UP, UP, white(tilted(45.0)), [0.599_974_8, 0.372_842_7, 0.259_276_7]),
        ("grazing light", usual, UP, UP, white(Vec3::X), [0.03, 0.015, 0.0075]),
        ("light behind", one_sided, UP, UP, white(-UP), [0.03, 0.015, 0.0075]),
        ("normal turned, two-sided", usual, -UP, UP, white(UP), [0.83, 0.515, 0.3575]),
        ("normal turned, one-sided", one_sided, -UP, UP, white(UP), [0.03, 0.015, 0.0075]),
        ("fill light", usual, UP, UP, fill, [0.63, 0.315, 0.1575]),
        ("dim red light", usual, UP, UP, red, [0.43, 0.015, 0.0075]),
        ("no gradient", usual, Vec3::ZERO, UP, white(UP), [0.03, 0.015, 0.0075]),
        ("no gradient, emission", glowing, Vec3::ZERO, UP, white(UP), [0.73, 0.365, 0.1825]),
        ("eye opposite to light", one_sided, UP, -UP, white(UP), [0.63, 0.315, 0.1575]),
    ];
    for (name, material, normal, to_eye, light, expected) in cases {
        let found = shaded(&material, normal, to_eye, light);
        for channel in 0..3 {
            assert!((found[channel] - expected[channel]).abs() < 1e-6, "{name}: {found:?}, expected {expected:?}");
        }
    }
    assert_eq!(shaded(&usual, Vec3::NAN, UP, white(UP)), shaded(&usual, Vec3::ZERO, UP, white(UP)));
}

#[test]
fn documented_defaults() {
    let material: Material = serde_json::from_str("{}").unwrap();
    assert_eq!(material, Material::default());
    assert_eq!((material.emission, material.ambient, material.diffuse, material.specular), (0.0, 0.1, 0.6, 0.2));
    assert_eq!((material.shininess, material.two_sided), (30.0, true));
    // Half brightness of the highlight: cos(angle)^shininess = 1/2.
    let tilt = |shininess: f32| 0.5f32.powf(1.0 / shininess).acos().to_degrees();
    assert!((tilt(30.0) - 12.0).abs() < 0.5 && (tilt(100.0) - 7.0).abs() < 0.5);

    let light: Light = serde_json::from_str(r#"{ "kind": { "point": { "position": [1, 2, 3] } } }"#).unwrap();
    assert_eq!(light, Light::new(LightKind::Point { position: [1.0, 2.0, 3.0], falloff: Falloff::None }));
    assert_eq!((light.color, light.intensity, light.frame, light.specular), (Color::WHITE, 1.0, Frame::World, true));

    let lighting: Lighting = serde_json::from_str("{}").unwrap();
    assert_eq!(lighting, Lighting::headlight());
    assert_eq!(lighting.ambient, 0.3);
    // 5.4-3: fill lights instead of ambient light, without highlights.
    let rig = Lighting::three_point();
    assert_eq!(rig.ambient, 0.0);
    assert!(rig.lights.iter().filter(|light| !light.specular).count() >= 2);
}

#[test]
fn documents_round_trip_and_reject_what_they_do_not_know() {
    let spot = r##"{ "kind": { "spot": { "position": [0, 0, 9], "direction": [0, 0, -1], "inner_angle": 10,
        "outer_angle": 20, "falloff": { "inverse_square": { "reference": 9 } } } }, "color": "#ff8000", "frame": "camera" }"##;
    let light: Light = serde_json::from_str(spot).unwrap();
    assert_eq!(serde_json::from_str::<Light>(&serde_json::to_string(&light).unwrap()).unwrap(), light);
    for bad in [
        r#"{ "kind": { "directional": { "direction": [0, 0, 1], "position": [0, 0, 0] } } }"#,
        r#"{ "kind": { "sun": {} } }"#,
        r#"{ "kind": { "directional": { "direction": [0, 0, 1] } }, "colour": "red" }"#,
    ] {
        assert!(serde_json::from_str::<Light>(bad).is_err(), "{bad}");
    }
    assert!(serde_json::from_str::<Material>(r#"{ "difuse": 1 }"#).is_err());
    let schema = serde_json::to_value(schemars::schema_for!(Lighting)).unwrap();
    assert_eq!(schema["properties"]["ambient"]["default"], serde_json::json!(0.3f32));
}

fn resolved(kind: LightKind) -> pellucid_optics::ResolvedLight {
    Light::new(kind).resolve(DAffine3::IDENTITY).unwrap()
}

#[test]
fn point_light_is_even_and_falls_off_with_the_square() {
    let at = |falloff| resolved(LightKind::Point { position: [1.0, 2.0, 3.0], falloff });
    let (plain, physical) = (at(Falloff::None), at(Falloff::InverseSquare { reference: 2.0 }));
    for direction in [Vec3::X, -Vec3::Y, Vec3::new(0.6, 0.0, -0.8)] {
        for distance in [0.5f32, 2.0, 8.0] {
            let point = Vec3::new(1.0, 2.0, 3.0) + direction * distance;
            assert!((plain.incident(point).to_light + direction).length() < 1e-5);
            assert_eq!(plain.incident(point).radiance, [1.0; 3]);
            let expected = 4.0 / (distance * distance);
            assert!((physical.incident(point).radiance[0] / expected - 1.0).abs() < 1e-5);
        }
    }
    for light in [plain, physical] {
        let there = light.incident(Vec3::new(1.0, 2.0, 3.0));
        assert_eq!((there.to_light, there.radiance), (Vec3::ZERO, [0.0; 3]));
        assert!(light.incident(Vec3::new(1.0 + 1e-6, 2.0, 3.0)).radiance[0].is_finite());
    }
}

#[test]
fn directional_light_is_a_point_light_far_away() {
    let direction = DVec3::new(1.0, -2.0, 0.5);
    let sun = resolved(LightKind::Directional { direction: direction.to_array() });
    let far =
        resolved(LightKind::Point { position: (direction.normalize() * -1e4).to_array(), falloff: Falloff::None });
    for point in [Vec3::ZERO, Vec3::ONE, Vec3::new(-3.0, 1.0, 2.0)] {
        assert!((sun.incident(point).to_light - far.incident(point).to_light).length() < 1e-3);
    }
}

#[test]
fn spot_light_has_a_soft_edge() {
    let spot = resolved(LightKind::Spot {
        position: [0.0; 3],
        direction: [0.0, 0.0, -3.0],
        inner_angle: 20.0,
        outer_angle: 30.0,
        falloff: Falloff::None,
    });
    let strength = |degrees: f32| spot.incident(-tilted(degrees) * 5.0).radiance[0];
    for (degrees, expected) in [(0.0, 1.0), (19.99, 1.0), (30.01, 0.0), (90.0, 0.0), (180.0, 0.0)] {
        assert_eq!(strength(degrees), expected, "{degrees} degrees");
    }
    assert!((0.2..0.8).contains(&strength(25.0)));
    assert!(strength(20.05) > 0.999 && strength(29.95) < 0.001);
    let falling: Vec<f32> = (0..=40).map(|i| strength(i as f32)).collect();
    assert!(falling.windows(2).all(|pair| pair[0] >= pair[1]));
}

#[test]
fn headlight_follows_the_camera() {
    // A camera at (0, 0, 10) that looks along +x, z up: columns right, up, back.
    let rotation = glam::DMat3::from_cols(DVec3::NEG_Y, DVec3::Z, DVec3::NEG_X);
    let camera = DAffine3 { matrix3: rotation, translation: DVec3::new(0.0, 0.0, 10.0) };
    let [headlight] = Lighting::headlight().lights[..] else { panic!("one light") };
    let incident = headlight.resolve(camera).unwrap().incident(Vec3::ZERO);
    assert!((incident.to_light - Vec3::NEG_X).length() < 1e-6);
    let lamp =
        Light { frame: Frame::Camera, ..Light::new(LightKind::Point { position: [0.0; 3], falloff: Falloff::None }) };
    assert!((lamp.resolve(camera).unwrap().incident(Vec3::ZERO).to_light - UP).length() < 1e-6);
    // The colour is decoded: half on the screen is 0.214 in light.
    let grey = Light { color: Color::new([0.5; 3]).unwrap(), intensity: 2.0, ..headlight };
    assert!((grey.resolve(camera).unwrap().incident(UP).radiance[0] - 0.428_082_3).abs() < 1e-6);
}

#[test]
fn settings_are_checked() {
    let directional = |direction| Light::new(LightKind::Directional { direction });
    let spot = |inner_angle, outer_angle| {
        let (position, direction) = ([0.0; 3], [0.0, 0.0, 1.0]);
        Light::new(LightKind::Spot { position, direction, inner_angle, outer_angle, falloff: Falloff::None })
    };
    let point = |position, falloff| Light::new(LightKind::Point { position, falloff });
    for bad in [
        directional([0.0; 3]),
        directional([f64::NAN, 0.0, 1.0]),
        Light { intensity: -1.0, ..directional([0.0, 0.0, 1.0]) },
        Light { intensity: f32::NAN, ..directional([0.0, 0.0, 1.0]) },
        spot(30.0, 20.0),
        spot(-1.0, 20.0),
        spot(10.0, 181.0),
        point([0.0, f64::INFINITY, 0.0], Falloff::None),
        point([0.0; 3], Falloff::InverseSquare { reference: 0.0 }),
    ] {
        assert!(bad.resolve(DAffine3::IDENTITY).is_err(), "{bad:?}");
    }
    assert!(directional([0.0, 0.0, 1e-100]).resolve(DAffine3::IDENTITY).is_ok());
    assert!(Material::default().validate().is_ok());
    for bad in [
        Material { ambient: 1.1, ..Material::default() },
        Material { diffuse: -0.1, ..Material::default() },
        Material { specular: f32::NAN, ..Material::default() },
        Material { shininess: 0.0, ..Material::default() },
        Material { emission: f32::INFINITY, ..Material::default() },
    ] {
        assert!(bad.validate().is_err(), "{bad:?}");
    }
    assert!(GradientWeight { low: 1.0, high: 2.0 }.validate().is_ok());
    assert!(GradientWeight { low: 2.0, high: 2.0 }.validate().is_err());
    assert!(GradientWeight { low: -1.0, high: 2.0 }.validate().is_err());
}

#[test]
fn gradient_weight_mixes_lit_and_unlit() {
    let weight = GradientWeight { low: 10.0, high: 30.0 };
    for (magnitude, expected) in
        [(0.0, 0.0), (10.0, 0.0), (15.0, 0.15625), (20.0, 0.5), (30.0, 1.0), (1e9, 1.0), (f32::NAN, 0.0)]
    {
        assert_eq!(weight.weight(magnitude), expected, "{magnitude}");
    }
    assert_eq!(weight.mix(20.0, [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]), [0.5; 3]);
}

fn unit() -> impl Strategy<Value = Vec3> {
    (-1.0f32..1.0, 0.0f32..std::f32::consts::TAU).prop_map(|(z, turn)| {
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * turn.cos(), r * turn.sin(), z)
    })
}

proptest! {
    #[test]
    fn lights_add_up_and_never_take_away(
        normal in unit(), to_eye in unit(), base in [0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0],
        lights in prop::collection::vec((unit(), [0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0], any::<bool>()), 0..5),
        two_sided: bool, shininess in 1.0f32..200.0,
    ) {
        let material = Material { two_sided, shininess, ..Material::default() };
        let lights: Vec<Incident> =
            lights.into_iter().map(|(to_light, radiance, specular)| Incident { to_light, radiance, specular }).collect();
        let all = blinn_phong(&material, base, normal, to_eye, 0.3, lights.iter().copied());
        let dark = blinn_phong(&material, base, normal, to_eye, 0.3, []);
        let each: Vec<[f32; 3]> =
            lights.iter().map(|light| blinn_phong(&material, base, normal, to_eye, 0.3, [*light])).collect();
        for channel in 0..3 {
            let sum: f32 = dark[channel] + each.iter().map(|one| one[channel] - dark[channel]).sum::<f32>();
            prop_assert!((all[channel] - sum).abs() < 1e-5);
            prop_assert!(each.iter().all(|one| one[channel] >= dark[channel]));
            let most: f32 = lights.iter().map(|light| 0.8 * light.radiance[channel]).sum();
            prop_assert!(all[channel] <= dark[channel] + most + 1e-5);
        }
    }

    #[test]
    fn diffuse_light_is_the_cosine(angle in 0.0f32..180.0) {
        // 5.4-4
        let matte = Material { ambient: 0.0, specular: 0.0, diffuse: 1.0, two_sided: false, ..Material::default() };
        let found = shaded(&matte, UP, tilted(33.0), white(tilted(angle)))[0];
        prop_assert!((found - angle.to_radians().cos().max(0.0)).abs() < 1e-6);
    }
}
