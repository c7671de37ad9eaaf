//! Cut faces: matter that a clip, a crop or the box of the data cuts looks like a solid that is cut there.

use std::sync::Arc;

use crate::common::{render, transfer_function};
use glam::DVec3;
use pellucid_field::{Grid, Volume};
use pellucid_optics::{Light, LightKind, NumberPoint, SurfaceShare};
use pellucid_scene::{Classification, Clip, Crop, HalfAngle, Orbit, Projection, Scene, Source, Stage, Technique, View};

/// Solid integer matter of 200 with noise of one level.
fn solid() -> Volume {
    let noise = |i: usize| (i.wrapping_mul(2_654_435_761) >> 13) % 3;
    let values: Vec<u8> = (0..32 * 32 * 32).map(|i| 199 + noise(i) as u8).collect();
    Volume::new(Grid::new([32; 3]).unwrap(), values).unwrap()
}

/// White matter, nearly opaque over a voxel, lit along y and looked at in between.
fn stage(edit: impl FnOnce(&mut Scene)) -> Stage {
    let mut scene = Scene::of(Source::memory());
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(100.0, 0.0), (150.0, 0.95)]);
    scene.volumes[0].transfer_function = Some(tf);
    scene.volumes[0].shading = Some(true);
    scene.volumes[0].material = Some(pellucid_optics::Material {
        ambient: 0.0,
        diffuse: 1.0,
        specular: 0.0,
        two_sided: false,
        ..Default::default()
    });
    scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 1.0, 0.0] })];
    scene.lighting.ambient = 0.0;
    scene.camera.projection = Projection::Orthographic { height: Some(10.0) };
    scene.camera.view = View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() });
    (scene.image.width, scene.image.height) = (16, 16);
    edit(&mut scene);
    scene.resolve(&[Arc::new(solid())]).unwrap().0
}

/// The diffuse light of the whole face is that of its plane.
fn check(what: &str, stage: &Stage, outwards: DVec3, tolerance: f32) {
    check_share(what, stage, outwards, 1.0, tolerance);
}

/// The same of a share of the light.
fn check_share(what: &str, stage: &Stage, outwards: DVec3, share: f32, tolerance: f32) {
    let frame = render(stage);
    let expected = share * (-outwards).dot(DVec3::Y).max(0.0) as f32;
    for color in &frame.color {
        assert!(color[3] > 0.99, "{what}: {color:?}");
        let light = color[1] / color[3];
        assert!((light - expected).abs() < tolerance, "{what}: {light} of {expected}");
    }
}

#[test]
fn a_cut_is_lit_like_a_solid_that_is_cut() {
    let tilted = DVec3::new(0.3, -0.9, 0.3).normalize();
    for classification in [Classification::Post, Classification::Pre, Classification::PreIntegrated] {
        let clipped = stage(|scene| {
            scene.quality.classification = classification;
            scene.clips = vec![Clip::Plane { point: [15.5; 3], normal: (-tilted).to_array() }];
        });
        check("a clip", &clipped, tilted, 0.06);
        let cropped = stage(|scene| {
            scene.quality.classification = classification;
            scene.volumes[0].crop = Some(Crop { from: [3.0, 9.5, 3.0], to: [29.0; 3] });
        });
        check("a crop", &cropped, -DVec3::Y, 0.06);
        check("the box", &stage(|scene| scene.quality.classification = classification), -DVec3::Y, 0.06);
    }
}

/// Requirement 3 and 4 of C-26: what is further inside than the layer is as it was, and the sampling rate changes
/// next to nothing.
#[test]
fn a_cut_does_not_depend_on_the_step() {
    let cut = |step: f64| {
        let clipped = stage(|scene| {
            scene.clips = vec![Clip::Plane { point: [15.5; 3], normal: [-0.3, 0.9, -0.3] }];
            scene.quality.step = step;
        });
        let frame = render(&clipped);
        frame.color.iter().map(|color| color[1]).sum::<f32>() / frame.color.len() as f32
    };
    let [coarse, fine] = [0.5, 0.125].map(cut);
    assert!((coarse - fine).abs() < 0.04 * fine, "{coarse} and {fine}");
}

/// In half-angle light from behind the eye, what is `t` optical depths deep is seen and lit through the same matter, so
/// that half of a plane's light comes back, whatever its tilt: the integral of `exp(-2 t)`.
#[test]
fn half_angle_light_falls_on_a_cut_as_on_a_solid() {
    let tilted = DVec3::new(0.3, -0.9, 0.3).normalize();
    for outwards in [tilted, -DVec3::Y] {
        let clipped = stage(|scene| {
            let direct = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
            scene.technique = Technique::HalfAngle(direct);
            scene.volumes[0].scattering.surface = SurfaceShare::Values(vec![NumberPoint::new(0.0, 1.0)]);
            scene.quality.step = 0.05;
            scene.clips = vec![Clip::Plane { point: [15.5; 3], normal: (-outwards).to_array() }];
        });
        check_share("a clip", &clipped, outwards, 0.5, 0.03);
    }
}
