//! Settings that are called without effect have none, and all others have one: tried in pairs, by drawing.

use pellucid::gpu::{AdapterChoice, Ceiling, GpuRenderer};
use pellucid::scene::{Control, Scene, Technique};
use pellucid::{Backend, Renderer, load, without_effect};
use serde_json::{Value, json};

/// Settings, each with a value that shows where it counts at all.
fn settings() -> Vec<(&'static str, Value)> {
    vec![
        ("camera.frame", json!("grid")),
        ("camera.view.orbit.zoom", json!(1.5)),
        ("camera.view.orbit.distance", json!(700.0)),
        ("volumes[0].window", json!([200.0, 900.0])),
        ("volumes[0].preset", json!("ct-skin")),
        ("volumes[0].colormap", json!("turbo")),
        ("volumes[0].opacity", json!("sigmoid_3")),
        (
            "volumes[0].transfer_function",
            json!({ "colors": [[-900, "navy"], [600, "orange"]], "opacities": [[-700, 0], [900, 0.7]] }),
        ),
        ("volumes[0].unit_distance", json!(25.0)),
        ("volumes[0].shading", json!(false)),
        ("volumes[0].material", json!({ "ambient": 0.8, "diffuse": 0.3, "specular": 0.0, "shininess": 5.0 })),
        ("volumes[0].gradient_weight", json!({ "low": 10.0, "high": 400.0 })),
        ("volumes[0].scattering.phase", json!({ "henyey_greenstein": { "g": 0.8 } })),
        ("volumes[0].scattering.albedo", json!({ "constant": 0.2 })),
        ("volumes[0].scattering.surface", json!({ "values": [[-200, 0.0], [200, 1.0]] })),
        ("lighting.lights", json!([{ "kind": { "directional": { "direction": [1.0, 0.4, -0.3] } } }])),
        ("lighting.ambient", json!(0.9)),
        ("lighting.model", json!("scattering")),
        ("lighting.shadows", json!({ "rays": { "step": 1.0 } })),
        ("quality.step", json!(2.0)),
        ("quality.gradient", json!("sobel")),
        ("quality.filter", json!("nearest")),
        ("quality.classification", json!("pre_integrated")),
        ("quality.jitter", json!({ "blue_noise": { "seed": 3 } })),
        ("quality.early_termination", json!(0.2)),
        ("quality.adaptive_tolerance", json!(0.9)),
        ("quality.supersampling", json!(3)),
        ("technique.ray_cast.mode.slice.combine", json!("average")),
        ("technique.ray_cast.mode.isosurface.search", json!("sampled")),
        ("technique.ray_cast.mode.isosurface.illumination", json!({ "global": { "samples": 4 } })),
        ("technique.ray_cast.mode.isosurface.illumination.global.resolution", json!(0.5)),
        ("technique.ray_cast.mode.isosurface.illumination.global.interpolation", json!("nearest")),
        ("technique.ray_cast.mode.isosurface.illumination.global.surfaces", json!("own")),
        ("technique.ray_cast.mode.isosurface.illumination.global.basis", json!({ "harmonics": { "bands": 2 } })),
        ("technique.ray_cast.mode.isosurface.illumination.global.bounces", json!(0)),
        ("technique.ray_cast.mode.isosurface.illumination.global.distance", json!(30.0)),
        ("technique.path_trace.focus", json!(200.0)),
        ("technique.path_trace.surface_depth", json!(3.0)),
        ("technique.half_angle.initial_indirect", json!(0.2)),
        ("technique.half_angle.blur_angle", json!(60.0)),
        ("technique.half_angle.seed", json!(9)),
        ("technique.half_angle.ambient", json!(true)),
    ]
}

/// What else a scene may be.
fn contexts() -> Vec<(&'static str, Vec<(&'static str, Value)>)> {
    let mode = |mode: Value| ("technique", json!({ "ray_cast": { "mode": mode } }));
    let iso = |rest: Value| mode(json!({ "isosurface": { "isovalues": [rest, { "value": 900.0 }] } }));
    let own = json!({ "isosurface": { "isovalues": [{ "value": 200.0, "color": "ivory" }] } });
    let surface = ("volumes[0].scattering.surface", json!({ "values": [[-200, 0.0], [200, 1.0]] }));
    let half_angle = |rest: Value| ("technique", json!({ "half_angle": rest }));
    let paths = |rest: Value| ("technique", json!({ "path_trace": rest }));
    let lit = |global: Value| {
        let isovalues = json!([{ "value": 200.0, "color": "ivory" }]);
        mode(json!({ "isosurface": { "isovalues": isovalues, "illumination": { "global": global } } }))
    };
    let slope = json!({ "gradient": { "top": "white", "bottom": "black" } });
    let sky = json!({ "constant": { "color": "white", "intensity": 0.3 } });
    vec![
        ("as it is", vec![]),
        ("unlit", vec![("volumes[0].shading", json!(false))]),
        ("maximum", vec![mode(json!("maximum"))]),
        ("average", vec![mode(json!("average"))]),
        ("x-ray", vec![mode(json!("x_ray"))]),
        ("additive", vec![mode(json!("additive"))]),
        ("plane", vec![mode(json!({ "slice": { "normal": [0, 1, 0] } }))]),
        ("slab", vec![mode(json!({ "slice": { "normal": [0, 1, 0], "thickness": 40.0 } }))]),
        ("isosurfaces", vec![iso(json!({ "value": 200.0, "opacity": 0.4 }))]),
        ("isosurface of its own colour", vec![mode(own.clone())]),
        ("isosurface, unlit", vec![mode(own), ("volumes[0].shading", json!(false))]),
        ("isosurface in all light", vec![lit(json!({ "samples": 4, "environment": slope.clone() }))]),
        ("isosurface in all light, at pixels", vec![lit(json!({ "samples": 4, "method": "pixels" }))]),
        (
            "isosurface in all light, not held back",
            vec![lit(json!({ "samples": 4, "shadows": false, "environment": slope }))],
        ),
        ("parallel rays", vec![("camera.projection", json!({ "orthographic": {} }))]),
        ("parallel rays of a height", vec![("camera.projection", json!({ "orthographic": { "height": 300.0 } }))]),
        ("from a distance", vec![("camera.view.orbit.distance", json!(600.0))]),
        (
            "a camera in full",
            vec![("camera.view.orbit.distance", json!(600.0)), ("camera.view.orbit.target", json!([0.0, 0.0, 0.0]))],
        ),
        ("pre-integrated", vec![("quality.classification", json!("pre_integrated"))]),
        ("scattering", vec![("lighting.model", json!("scattering"))]),
        ("scattering, unlit", vec![("lighting.model", json!("scattering")), ("volumes[0].shading", json!(false))]),
        ("a look over a window", vec![("volumes[0].preset", json!("density"))]),
        ("half angles", vec![half_angle(json!({}))]),
        ("half angles, direct light", vec![half_angle(json!({ "indirect": 0.0 }))]),
        ("half angles, one tap", vec![half_angle(json!({ "taps": 1 }))]),
        ("half angles and surfaces", vec![half_angle(json!({})), surface.clone()]),
        ("paths", vec![paths(json!({ "samples": 4, "environment": sky.clone() }))]),
        ("paths and surfaces", vec![paths(json!({ "samples": 4, "environment": sky, "aperture": 9.0 })), surface]),
        ("slices", vec![("technique", json!({ "slicing": {} }))]),
        ("slices of the volume", vec![("technique", json!({ "slicing": { "geometry": "object_aligned" } }))]),
        ("slices from behind", vec![("technique", json!({ "slicing": { "order": "back_to_front" } }))]),
    ]
}

/// Pairs whose second setting has an effect in general and none in this picture.
const BY_CHANCE: &[(&str, &str)] = &[
    // All of the grid is seen.
    ("maximum", "camera.frame"),
    ("average", "camera.frame"),
    ("x-ray", "camera.frame"),
    // Where all directions are alike, so are lights.
    ("scattering", "lighting.lights"),
    ("scattering, unlit", "lighting.lights"),
    // A light at the eye casts no shadow that is seen on what nothing covers.
    ("isosurface of its own colour", "lighting.shadows"),
    // The preset is unlit as it is.
    ("a look over a window", "volumes[0].shading"),
    // A surface head on, which its first and its last sample bracket alike.
    ("isosurface, unlit", "quality.jitter"),
    // The preset's material reflects as much ambient light as the one that stands for none.
    ("scattering", "volumes[0].shading"),
    // Every sample that is seen is a surface.
    ("paths and surfaces", "volumes[0].scattering.phase"),
    ("paths and surfaces", "volumes[0].scattering.albedo"),
];

/// Settings that may change nothing in pictures of so few voxels: no block is uniform enough to take longer steps in.
const RARELY: [&str; 1] = ["quality.adaptive_tolerance"];

/// A document with a value somewhere in it; tables are made on the way.
fn put(document: &mut Value, place: &str, value: Value) {
    let mut here = document;
    for part in place.split(['.', '[']).map(|part| part.trim_end_matches(']')) {
        here = match part.parse::<usize>() {
            Ok(index) => &mut here[index],
            Err(_) => {
                if !here.is_object() {
                    *here = json!({});
                }
                &mut here[part]
            }
        };
    }
    *here = value;
}

/// The scene that changes make of a small head; `None` if they do not fit together.
fn scene(changes: &[&(&str, Value)]) -> Option<Scene> {
    let mut document = json!({
        "volumes": [{ "source": { "sample": { "name": "head", "dims": [16, 20, 20] } } }],
        "camera": { "view": { "orbit": {} } },
        "image": { "width": 18, "height": 16 },
    });
    for (place, value) in changes {
        put(&mut document, place, value.clone());
    }
    let scene: Scene = serde_json::from_value(document).ok()?;
    scene.validate().ok()?;
    Some(scene)
}

#[test]
fn what_is_called_without_effect_has_none_and_all_else_has_one() {
    let mut cpu = Renderer::new(Backend::Cpu).unwrap();
    let mut gpu: Renderer = GpuRenderer::new(&AdapterChoice::Any, &Ceiling::default()).unwrap().into();
    let mut draw = |scene: &Scene| {
        let (volumes, _) = load(scene, "").unwrap();
        let (stage, _) = scene.resolve(&volumes).ok()?;
        let renderer = if matches!(scene.technique, Technique::Slicing(_)) { &mut gpu } else { &mut cpu };
        let frame = renderer.render(&stage, &Control::default()).ok()?;
        Some((frame.color, stage))
    };
    let (mut idle, mut heeded, mut wrong) = (0, 0, Vec::new());
    for (context, changes) in contexts() {
        let plain: Vec<_> = changes.iter().collect();
        let (before, _) = draw(&scene(&plain).expect(context)).expect(context);
        for setting in settings() {
            let (place, value) = &setting;
            // A technique's own setting means nothing in the document of another.
            let other = place.strip_prefix("technique.").and_then(|rest| rest.split('.').next());
            let fits = other.is_none_or(|other| match other {
                "ray_cast" if place.contains(".slice.") => context == "plane" || context == "slab",
                "ray_cast" if place.contains(".global.") => context.starts_with("isosurface in all light"),
                "ray_cast" => context.starts_with("isosurface"),
                "half_angle" => context.starts_with("half angles"),
                _ => context.starts_with("paths"),
            });
            let Some(changed) = scene(&plain.iter().copied().chain([&setting]).collect::<Vec<_>>()) else { continue };
            if !fits || changes.iter().any(|(place, _)| *place == setting.0) {
                continue;
            }
            // A backend that refuses has said so.
            let Some((after, stage)) = draw(&changed) else { continue };
            let told = without_effect(&changed, &stage, &[place]);
            let told = told.iter().any(|idle| idle.setting == *place);
            let same = before == after;
            match (told, same) {
                (true, true) => idle += 1,
                (false, false) => heeded += 1,
                (false, true) if RARELY.contains(place) || BY_CHANCE.contains(&(context, place)) => {}
                _ => wrong.push(format!("{context} + {place} = {value}: told {told}, same picture {same}")),
            }
        }
    }
    assert!(wrong.is_empty(), "{idle} without effect, {heeded} with one, and wrong:\n{}", wrong.join("\n"));
    assert!(idle > 200 && heeded > 250, "{idle} without effect, {heeded} with one");
}

/// A value that is the default says nothing, unless somebody gave it; what turns off what is off says nothing either.
#[test]
fn defaults_are_no_words() {
    let quiet = scene(&[
        &("technique", json!({ "path_trace": { "samples": 2 } })),
        &("quality.step", json!(0.5)),
        &("volumes[0].shading", json!(false)),
        &("lighting.ambient", json!(0.0)),
    ]);
    let quiet = quiet.unwrap();
    let (volumes, _) = load(&quiet, "").unwrap();
    let (stage, _) = quiet.resolve(&volumes).unwrap();
    assert_eq!(without_effect(&quiet, &stage, &[]), []);
    let told = without_effect(&quiet, &stage, &["quality.step", "volumes[0].material.ambient"]);
    let settings: Vec<&str> = told.iter().map(|idle| idle.setting.as_str()).collect();
    assert_eq!(settings, ["volumes[0].material", "quality.step"]);
    assert!(told[1].to_string().starts_with("quality.step has no effect: "), "{}", told[1]);
}
