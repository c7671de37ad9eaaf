//! Displaced and varied volumes in pictures: every technique meets the same field (K-21 to K-24, MOD-08 to
//! MOD-11).

use crate::common::{render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_field::Volume;
use pellucid_optics::{
    Albedo, Color, ColorPoint, Displacement, Interpolation, Light, LightKind, LightModel, Lighting, Material, Octave,
    Perturbation, PropertyNoise, ShadowRays, ShadowVolume, Shadows, TransferFunction,
};
use pellucid_scene::{
    Classification, Clip, Frame, HalfAngle, Isosurface, Isovalue, Majorants, Mode, PathTrace, Scene, Stage, Technique,
};

/// Two smooth balls of different size in emptiness.
fn balls() -> Volume {
    unit_volume([33, 29, 31], |p| {
        let ball = |x: f64, y: f64, z: f64, r: f64| (1.0 - (p - DVec3::new(x, y, z)).length() / r).max(0.0);
        ball(10.0, 12.0, 11.0, 7.0) + ball(24.0, 17.0, 22.0, 5.0)
    })
}

fn thick() -> TransferFunction {
    transfer_function(&[(0.0, 0x4080ff), (0.5, 0xffc040)], &[(0.05, 0.0), (0.5, 0.5)])
}

fn displaced() -> Perturbation {
    let octaves = vec![Octave::new(2.0, 1.0), Octave::new(5.0, 0.5)];
    Perturbation { displacement: Displacement { amplitude: 0.12, octaves, between: None }, ..Perturbation::default() }
}

fn everything() -> Perturbation {
    let optics = PropertyNoise { opacity: 0.8, color: 0.6, transport: 0.7, ..PropertyNoise::default() };
    Perturbation { optics, ..displaced() }
}

fn perturbed(perturbation: &Perturbation, edit: impl FnOnce(&mut Scene)) -> Stage {
    stage(balls(), thick(), |scene| {
        scene.image.width = 40;
        scene.image.height = 40;
        let transport = ColorPoint { value: 0.0, color: Color::hex(0xe0f0ff), interpolation: Interpolation::Linear };
        scene.volumes[0].scattering.transport = Some(vec![transport]);
        scene.volumes[0].perturbation = perturbation.clone();
        edit(scene);
    })
}

fn rmse(a: &Frame, b: &Frame) -> f64 {
    let squares = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
    (a.color.iter().zip(&b.color).map(squares).sum::<f64>() / a.color.len() as f64).sqrt()
}

/// A light from above, with shadows.
fn sun(scene: &mut Scene) {
    let kind = LightKind::Directional { direction: [0.3, 0.5, -1.0] };
    scene.lighting = Lighting { lights: vec![Light::new(kind)], ..Lighting::dark() };
    scene.lighting.model = LightModel::Scattering;
    scene.lighting.shadows = Shadows::Rays(ShadowRays::default());
}

/// What makes a technique of a scene.
type Setting = Box<dyn Fn(&mut Scene)>;

/// Every way of the processor to look at a field.
fn techniques() -> Vec<(&'static str, Setting)> {
    fn mode(mode: Mode) -> Setting {
        Box::new(move |scene| set_mode(scene, mode.clone()))
    }
    let isosurface = Isosurface::new(vec![Isovalue { value: 0.3, color: None, opacity: 1.0, volume: None }]);
    vec![
        ("composite", mode(Mode::Composite)),
        ("maximum", mode(Mode::Maximum)),
        ("minimum", mode(Mode::Minimum)),
        ("average", mode(Mode::Average)),
        ("x-ray", mode(Mode::XRay)),
        ("isosurface", mode(Mode::Isosurface(isosurface))),
        ("pre-classified", Box::new(|scene| scene.quality.classification = Classification::Pre)),
        ("pre-integrated", Box::new(|scene| scene.quality.classification = Classification::PreIntegrated)),
        ("lit", Box::new(|scene| scene.volumes[0].shading = Some(true))),
        ("clipped", Box::new(|scene| scene.clips = vec![Clip::Plane { point: [12.0; 3], normal: [1.0, 1.0, 0.2] }])),
        ("shadow rays", Box::new(sun)),
        (
            "shadow volume",
            Box::new(|scene| {
                sun(scene);
                scene.lighting.shadows = Shadows::Volume(ShadowVolume::default());
            }),
        ),
        (
            "half-angle",
            Box::new(|scene| {
                sun(scene);
                scene.lighting.shadows = Shadows::None;
                scene.technique = Technique::HalfAngle(HalfAngle::default());
            }),
        ),
    ]
}

/// A displacement too small to move anything changes no bit: all of the way through the code but gradients.
#[test]
fn next_to_nothing_is_nothing() {
    let mut still = displaced();
    still.displacement.amplitude = 1e-30;
    for (name, edit) in techniques().into_iter().filter(|(name, _)| !["lit", "isosurface"].contains(name)) {
        let unlit = |scene: &mut Scene| {
            edit(scene);
            scene.volumes[0].shading = Some(false);
        };
        let plain = render(&perturbed(&Perturbation::default(), unlit));
        let found = render(&perturbed(&still, unlit));
        // Extremes of fields that noise may bend are looked for, and not known from the voxels.
        let most = if ["maximum", "minimum"].contains(&name) { 1e-4 } else { 0.0 };
        assert!(rmse(&plain, &found) <= most, "{name}: {}", rmse(&plain, &found));
    }
}

#[test]
fn everything_sees_the_noise() {
    // The least along any ray is emptiness, displaced or not.
    for (name, edit) in techniques().into_iter().filter(|(name, _)| *name != "minimum") {
        let plain = render(&perturbed(&Perturbation::default(), &edit));
        let found = render(&perturbed(&displaced(), &edit));
        assert!(rmse(&plain, &found) > 0.003, "{name}: {}", rmse(&plain, &found));
    }
}

/// Blocks know how far the noise reaches.
#[test]
fn skipping_changes_no_bit() {
    let mut fur = everything();
    fur.displacement.between = Some([0.4, 0.1]);
    for perturbation in [everything(), fur] {
        for (name, edit) in techniques() {
            let drawn = |skip| {
                render(&perturbed(&perturbation, |scene| {
                    edit(scene);
                    scene.quality.empty_space_skipping = skip;
                }))
            };
            assert_eq!(drawn(true).color, drawn(false).color, "{name}");
        }
    }
}

/// K-22, MOD-11: whole periods are the same picture, and a little later is a little different.
#[test]
fn noise_moves_in_time() {
    let at = |time: f64| {
        let mut perturbation = everything();
        for octave in perturbation.displacement.octaves.iter_mut().chain(&mut perturbation.optics.octaves) {
            octave.offset = [time, 2.0 * time, 0.0];
        }
        render(&perturbed(&perturbation, sun))
    };
    let (first, whole) = (at(0.25), at(-6.75));
    assert_eq!(first.color, whole.color);
    let ratio = rmse(&first, &at(0.252)) / rmse(&first, &at(0.251));
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

/// Mean of a channel over a picture, and the standard error of that mean if pixels are independent.
fn difference(a: &Frame, b: &Frame, channel: usize) -> (f64, f64) {
    let n = a.color.len() as f64;
    let each: Vec<f64> = a.color.iter().zip(&b.color).map(|(a, b)| f64::from(a[channel] - b[channel])).collect();
    let mean = each.iter().sum::<f64>() / n;
    let variance = each.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Noise that is smooth from pixel to pixel: paths go through all of a pixel, rays through its middle.
fn smooth(mut perturbation: Perturbation) -> Perturbation {
    perturbation.displacement.octaves = vec![Octave::new(0.5, 1.0)];
    perturbation.optics.octaves = vec![Octave::new(0.25, 2.0)];
    perturbation
}

/// Without scattering, paths estimate what the ray caster adds up: the same field, the same extinction and the
/// same colours, under majorants that bound them.
#[test]
fn paths_meet_the_same_medium() {
    let glowing = |scene: &mut Scene| {
        scene.volumes[0].shading = Some(true);
        let material = Material { emission: 1.0, ambient: 0.0, diffuse: 0.0, specular: 0.0, ..Material::default() };
        scene.volumes[0].material = Some(material);
        scene.lighting = Lighting::dark();
        scene.quality.step = 0.1;
    };
    let cast = render(&perturbed(&smooth(everything()), glowing));
    let unvaried = render(&perturbed(&smooth(displaced()), glowing));
    for majorants in [Majorants::Local, Majorants::Global] {
        let traced = render(&perturbed(&smooth(everything()), |scene| {
            glowing(scene);
            scene.technique =
                Technique::PathTrace(PathTrace { samples: 512, bounces: 0, majorants, ..PathTrace::default() });
        }));
        for channel in 0..3 {
            let (mean, error) = difference(&traced, &cast, channel);
            // Four standard errors, and what a step of a tenth of a voxel leaves.
            assert!(mean.abs() < 4.0 * error + 2e-4, "channel {channel}: {mean} with error {error}");
        }
        // The mean could not tell variation that is as often more as less: how much of it is missing?
        let [mut missing, mut all] = [0.0, 0.0];
        for ((traced, cast), unvaried) in traced.color.iter().zip(&cast.color).zip(&unvaried.color) {
            for channel in 0..3 {
                let variation = f64::from(unvaried[channel] - cast[channel]);
                missing += f64::from(traced[channel] - cast[channel]) * variation;
                all += variation * variation;
            }
        }
        assert!((missing / all).abs() < 0.1, "{}", missing / all);
    }
}

/// Scattered once, paths see the light that shadow rays let through.
#[test]
fn paths_see_the_same_shadows() {
    let lit = |scene: &mut Scene| {
        sun(scene);
        scene.volumes[0].scattering.albedo = Albedo::Constant(0.8);
        scene.quality.step = 0.2;
        scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.2 });
    };
    let cast = render(&perturbed(&smooth(everything()), lit));
    let traced = render(&perturbed(&smooth(everything()), |scene| {
        lit(scene);
        scene.technique = Technique::PathTrace(PathTrace { samples: 256, bounces: 1, ..PathTrace::default() });
    }));
    for channel in 0..3 {
        let (mean, error) = difference(&traced, &cast, channel);
        assert!(mean.abs() < 4.0 * error + 1e-3, "channel {channel}: {mean} with error {error}");
    }
}

/// Property weights are asked one by one.
#[test]
fn properties_vary_alone() {
    let one = |properties: PropertyNoise| Perturbation { optics: properties, ..Perturbation::default() };
    let half_angle = |scene: &mut Scene| {
        sun(scene);
        scene.lighting.shadows = Shadows::None;
        scene.technique = Technique::HalfAngle(HalfAngle::default());
    };
    let drawn = |properties: PropertyNoise| render(&perturbed(&one(properties), half_angle));
    let plain = drawn(PropertyNoise::default());
    let opacity = drawn(PropertyNoise { opacity: 0.5, ..PropertyNoise::default() });
    let color = drawn(PropertyNoise { color: 0.5, ..PropertyNoise::default() });
    let transport = drawn(PropertyNoise { transport: 1.0, ..PropertyNoise::default() });
    let alpha = |frame: &Frame| frame.color.iter().map(|color| color[3]).collect::<Vec<_>>();
    assert_ne!(alpha(&plain), alpha(&opacity));
    for (name, frame) in [("color", &color), ("transport", &transport)] {
        assert_eq!(alpha(&plain), alpha(frame), "{name}");
        assert!(rmse(&plain, frame) > 1e-4, "{name}: {}", rmse(&plain, frame));
    }
}
