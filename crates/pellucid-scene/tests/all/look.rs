//! Ready-made light, and the sky behind what is drawn.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Grid, Volume};
use pellucid_optics::{Color, ColorSpace, Environment};
use pellucid_scene::{
    Background, Encoding, Format, Frame, HalfAngle, ImageSettings, Look, Orbit, PathTrace, Projection, RayCast,
    RenderWarning, Scene, Slicing, Source, Technique, View,
};

fn volume() -> Arc<Volume> {
    let value = |k: usize| (k % 16) as f32;
    Arc::new(Volume::new(Grid::new([16; 3]).unwrap(), (0..16 * 16 * 16).map(value).collect::<Vec<_>>()).unwrap())
}

fn techniques() -> [Technique; 4] {
    [
        Technique::RayCast(RayCast::default()),
        Technique::Slicing(Slicing::default()),
        Technique::HalfAngle(HalfAngle::default()),
        Technique::PathTrace(PathTrace::default()),
    ]
}

#[test]
fn looks_are_ordinary_settings_for_any_technique() {
    for (look, technique) in Look::ALL.into_iter().flat_map(|look| techniques().map(|technique| (look, technique))) {
        let mut scene = Scene::of(Source::memory());
        scene.technique = technique.clone();
        let plain = scene.clone();
        look.apply(&mut scene);
        // Light from somewhere, but not from the eye.
        let (stage, choices) = scene.resolve(&[volume()]).unwrap();
        assert!(!choices.iter().any(|choice| choice.setting == "lights"), "{look:?} {choices:?}");
        let lit = stage.path_trace().is_some_and(|settings| settings.environment != Environment::Dark);
        assert!(lit || !stage.lights.is_empty(), "{look:?} {technique:?}");
        for light in &stage.lights {
            let towards = light.incident(glam::Vec3::splat(7.5)).to_light.as_dvec3();
            assert!(towards.dot(-stage.viewpoint.forward) < 0.95, "{look:?}");
        }
        // What is seen, and in which colours, stays.
        let before = plain.resolve(&[volume()]).unwrap().0;
        assert_eq!(before.volumes[0].transfer_function, stage.volumes[0].transfer_function);
        assert_eq!(before.viewpoint, stage.viewpoint);
        assert_eq!(scene.technique.name(), technique.name());
        let text = scene.to_text(Format::Toml).unwrap();
        assert_eq!(Scene::parse(&text, Format::Toml).unwrap(), scene);
        // Again, it is the same; another one leaves nothing of it.
        let mut again = scene.clone();
        Look::Studio.apply(&mut again);
        look.apply(&mut again);
        assert_eq!(again, scene, "{look:?}");
    }
    assert_eq!(Look::by_name("skin"), Ok(Look::Skin));
    assert!(Look::by_name("skiny").unwrap_err().to_string().contains("studio, sky, skin, cloud"));
}

#[test]
fn the_sky_behind_is_that_of_the_direction() {
    let [top, bottom] = [Color::hex(0xff8020), Color::hex(0x204080)];
    let mut scene = Scene::of(Source::memory());
    let environment = Environment::Gradient { top, bottom, intensity: 2.0 };
    scene.technique = Technique::PathTrace(PathTrace { environment, ..PathTrace::default() });
    scene.image = ImageSettings { width: 5, height: 3, background: Background::Environment, ..Default::default() };
    scene.camera.projection = Projection::Perspective { vertical_fov: 90.0 };
    let position = Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() };
    scene.camera.view = View::Orbit(position);
    let stage = scene.resolve(&[volume()]).unwrap().0;
    let sky = stage.backdrop();
    // Rows of a picture of 90 degrees lie at tangents of 2/3, 0 and -2/3; looking along +y, columns at 4/3 to -4/3.
    for (pixel, found) in sky.iter().enumerate() {
        let (x, z) = ((pixel % 5) as f64 - 2.0, 1.0 - (pixel / 5) as f64);
        let direction = DVec3::new(x * 2.0 / 3.0, 1.0, z * 2.0 / 3.0).normalize();
        let share = (0.5 + 0.5 * direction.z) as f32;
        let [a, b] = [top, bottom].map(|color| color.to_linear(ColorSpace::Srgb));
        for channel in 0..3 {
            let exact = 2.0 * (b[channel] + (a[channel] - b[channel]) * share);
            assert!((found[channel] - exact).abs() < 1e-5, "{pixel}: {found:?}");
        }
    }
    assert_eq!(stage.fallbacks().count(), 0);
    // Behind half a pixel of light it is half, exposed as all light is; in codes and in numbers alike.
    let mut frame = Frame::new(5, 3);
    frame.backdrop.clone_from(&sky);
    frame.color[7] = [0.1, 0.2, 0.3, 0.5];
    let image = ImageSettings { encoding: Encoding::Linear, exposure: 0.25, ..scene.image.clone() };
    let expected = [0, 1, 2].map(|channel| (frame.color[7][channel] + 0.5 * sky[7][channel]) * 0.25);
    let [r, g, b, a] = frame.composited(7, &image);
    assert!((0..3).all(|channel| ([r, g, b][channel] - expected[channel]).abs() < 1e-6) && a == 1.0);
    let codes = frame.to_rgba16(&image);
    for channel in 0..3 {
        assert!((f32::from(codes[7 * 4 + channel]) / 65535.0 - expected[channel]).abs() < 1e-4);
    }
    // Other backgrounds are what they were, and other techniques have no sky to be seen.
    let black = ImageSettings { background: Background::default(), ..image };
    assert_eq!(frame.composited(0, &black), [0.0, 0.0, 0.0, 1.0]);
    scene.technique = Technique::RayCast(RayCast::default());
    let stage = scene.resolve(&[volume()]).unwrap().0;
    assert!(stage.backdrop().is_empty());
    let said: Vec<RenderWarning> = stage.fallbacks().collect();
    assert!(
        matches!(said.as_slice(), [RenderWarning::Fallback { reason }] if reason.contains("environment")),
        "{said:?}"
    );
}
