//! An extinction of its own for each colour (K-13), on all ways of light.

use crate::common::{center, render, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_optics::{
    Color, ColorSpace, Light, LightKind, LightModel, Phase, PhaseNormalization, Scattering, ShadowRays, Shadows,
    srgb_encode,
};
use pellucid_scene::{
    Background, Frame, HalfAngle, InScatter, Orbit, PathTrace, Projection, RayCast, Scene, Stage, Technique, View,
};

/// A colour of these linear factors.
fn factors(linear: [f32; 3]) -> Color {
    Color::new(linear.map(srgb_encode)).unwrap()
}

/// A volume looked at along y from below, as it is.
fn along_y(scene: &mut Scene, extinction: Option<Color>) {
    scene.volumes[0].scattering.extinction_color = extinction;
    scene.volumes[0].shading = Some(false);
    scene.camera.view = View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() });
    scene.camera.projection = Projection::Orthographic { height: None };
    scene.quality.early_termination = 1.0;
    (scene.image.width, scene.image.height) = (16, 16);
}

/// Two layers of a colour each: of what is behind, each colour is seen through its own extinction in front.
#[test]
fn layers_hide_each_colour_in_their_own_way() {
    for linear in [[1.0, 0.5, 0.25], [0.03, 1.0, 0.0], [0.3, 0.3, 0.3]] {
        let layers = |p: DVec3| if p.y < 15.5 { 1.0 } else { 2.0 };
        // A unit holds back 0.1 in front and 0.2 behind; opacities jump between the layers.
        let tf = transfer_function(&[(1.49, 0xff8040), (1.51, 0x4080ff)], &[(1.49, 0.1), (1.51, 0.2)]);
        let frame = render(&stage(unit_volume([9, 31, 9], layers), tf, |scene| along_y(scene, Some(factors(linear)))));
        let found = center(&frame);
        let mut coverage = 0.0;
        for channel in 0..3 {
            let factor = f64::from(linear[channel]);
            let [front, behind] = [0xff8040, 0x4080ff].map(|hex| Color::hex(hex).to_linear(ColorSpace::Srgb)[channel]);
            let [near, far] = [(0.9f64, 15.5), (0.8, 14.5)].map(|(unit, length)| unit.powf(length * factor));
            let exact = f64::from(front) * (1.0 - near) + near * f64::from(behind) * (1.0 - far);
            let error = (f64::from(found[channel]) - exact).abs();
            // The step between the layers has samples of both.
            assert!(error < 0.004, "{linear:?}, {channel}: {}, exact {exact}", found[channel]);
            coverage += (1.0 - near * far) / 3.0;
        }
        assert!((f64::from(found[3]) - coverage).abs() < 0.004, "{linear:?}: {}, exact {coverage}", found[3]);
    }
}

/// Over a background each colour of that comes through its own extinction, and none of it is gained; what a
/// transparent one is left with is the mean.
#[test]
fn each_colour_of_a_background_comes_through_in_its_own_way() {
    let linear = [1.0f32, 0.3, 0.05];
    let techniques = [
        Technique::RayCast(RayCast::default()),
        Technique::HalfAngle(HalfAngle::default()),
        Technique::PathTrace(PathTrace { samples: 4096, noise: 0.0, bounces: 0, ..PathTrace::default() }),
    ];
    for technique in techniques {
        let tolerance = if matches!(technique, Technique::PathTrace(_)) { 0.03 } else { 1e-4 };
        let tf = transfer_function(&[(0.0, 0x000000)], &[(0.0, 0.2)]);
        let stage = stage(unit_volume([9, 11, 9], |_| 1.0), tf, |scene| {
            along_y(scene, Some(factors(linear)));
            (scene.image.width, scene.image.height) = (4, 4);
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.3, 1.0, 0.2] })];
            scene.lighting.ambient = 0.0;
            scene.image.background = Background::Color(Color::new([1.0, 0.8, 0.9]).unwrap());
            scene.technique = technique.clone();
        });
        let frame = render(&stage);
        let found = frame.composited(5, &stage.image);
        let background = stage.image.background.at(1, 4);
        let left = linear.map(|factor| 0.8f64.powf(10.0 * f64::from(factor)) as f32);
        for channel in 0..3 {
            // Black matter gives no light of its own.
            let exact = background[channel] * left[channel];
            let error = (found[channel] - exact).abs();
            assert!(error < tolerance, "{}, {channel}: {}, exact {exact}", technique.name(), found[channel]);
        }
        let covered = 1.0 - left.iter().sum::<f32>() / 3.0;
        assert!((frame.color[5][3] - covered).abs() < tolerance, "{}: {:?}", technique.name(), frame.color[5]);
    }
}

/// Samples that scatter light evenly, lit along `direction`.
fn lit(scene: &mut Scene, direction: [f64; 3]) {
    let extinction_color = scene.volumes[0].scattering.extinction_color;
    scene.volumes[0].scattering = Scattering {
        phase: Phase::Isotropic,
        phase_normalization: PhaseNormalization::Renormalised,
        extinction_color,
        ..Scattering::default()
    };
    scene.lighting.lights = vec![Light::new(LightKind::Directional { direction })];
    scene.lighting.model = LightModel::Scattering;
    scene.lighting.ambient = 0.0;
}

/// A block lit from the eye or from behind sends back of each colour what its closed form says.
#[test]
fn blocks_send_back_each_colour_in_its_own_way() {
    let linear = [1.0f32, 0.4, 0.08];
    for direction in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]] {
        for half_angle in [false, true] {
            let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.2)]);
            let frame = render(&stage(unit_volume([17, 17, 17], |_| 1.0), tf, |scene| {
                along_y(scene, Some(factors(linear)));
                lit(scene, direction);
                scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.25 });
                scene.quality.step = 0.25;
                if half_angle {
                    let settings = HalfAngle { indirect: 0.0, ..HalfAngle::default() };
                    scene.technique = Technique::HalfAngle(settings);
                }
            }));
            let found = center(&frame);
            for channel in 0..3 {
                let depth = -16.0 * 0.8f64.ln() * f64::from(linear[channel]);
                // The light has come the way that is seen, or what is left of the block.
                let exact =
                    if direction[1] > 0.0 { (1.0 - (-2.0 * depth).exp()) / 2.0 } else { depth * (-depth).exp() };
                let error = (f64::from(found[channel]) - exact).abs();
                let what = format!("{direction:?}, half-angle {half_angle}, {channel}");
                assert!(error < 0.002 + 0.02 * exact, "{what}: {}, exact {exact}", found[channel]);
            }
        }
    }
}

fn cloud(extinction: Option<Color>, opacity: f32, edit: impl Fn(&mut Scene)) -> Stage {
    let ball = |p: DVec3| 1.0 - ((p - DVec3::splat(16.0)).length() / 14.0).min(1.0);
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.1, 0.0), (0.5, opacity)]);
    stage(unit_volume([33; 3], ball), tf, |scene| {
        along_y(scene, extinction);
        lit(scene, [1.0, 0.4, -0.6]);
        edit(scene);
    })
}

fn difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.color.iter().flatten().zip(b.color.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// What all colours lose alike is a thinner medium, direct and indirect light, seen from either side.
#[test]
fn grey_factors_are_a_thinner_medium() {
    for direction in [[1.0, 0.4, -0.6], [1.0, -0.4, -0.6]] {
        for in_scatter in [InScatter::Indirect, InScatter::Direct] {
            let draw = |extinction: Option<Color>, unit: f64| {
                let settings = HalfAngle { in_scatter, ..HalfAngle::default() };
                render(&cloud(extinction, 0.3, |scene| {
                    lit(scene, direction);
                    let tf = scene.volumes[0].transfer_function.take().unwrap();
                    scene.volumes[0].transfer_function = Some(tf.with_unit_distance(Some(unit)).unwrap());
                    scene.technique = Technique::HalfAngle(settings.clone());
                }))
            };
            let (grey, thin, thick) = (draw(Some(factors([0.5; 3])), 1.0), draw(None, 2.0), draw(None, 1.0));
            // Tables interpolate opacities of either length between their nodes.
            assert!(difference(&grey, &thin) < 2e-3, "{}", difference(&grey, &thin));
            assert!(difference(&grey, &thick) > 0.05);
        }
    }
}

/// Half-angle slicing and shadow rays see the same, in front of the light and behind.
#[test]
fn slices_and_rays_agree() {
    let extinction = Some(factors([1.0, 0.3, 0.1]));
    for direction in [[1.0, 0.4, -0.6], [1.0, -0.4, -0.6]] {
        let rays = render(&cloud(extinction, 0.4, |scene| {
            lit(scene, direction);
            scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.25 });
            scene.quality.step = 0.25;
        }));
        let slices = render(&cloud(extinction, 0.4, |scene| {
            lit(scene, direction);
            scene.technique = Technique::HalfAngle(HalfAngle { indirect: 0.0, ..HalfAngle::default() });
            scene.quality.step = 0.25;
        }));
        assert!(difference(&rays, &slices) < 0.01, "{direction:?}: {}", difference(&rays, &slices));
        // And each colour is its own.
        let most = |channel: usize| slices.color.iter().map(|color| color[channel]).fold(0.0, f32::max);
        assert!(most(0) > 1.2 * most(2), "{} {}", most(0), most(2));
    }
}
