//! Half-angle light through several volumes.

use super::*;

/// Half-angle light through two volumes.
fn by_half_angles(scene: &mut Scene) {
    scene.technique = Technique::HalfAngle(HalfAngle { resolution: 96, ..HalfAngle::default() });
    scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [-0.3, 0.4, -1.0] })];
}

/// Without blur and light, what is left of half-angle slices is absorption: the closed form of opacities.
#[test]
fn half_angle_slices_meet_all_volumes() {
    let opacities = [0.12, 0.3];
    for swapped in [false, true] {
        let mut layers = boxes(opacities);
        if swapped {
            layers.reverse();
        }
        for direction in [[-0.3, 0.4, -1.0], [0.2, -1.0, 0.1]] {
            let stage = stage(&layers, |scene| {
                by_half_angles(scene);
                scene.lighting.lights = vec![Light::new(LightKind::Directional { direction })];
            });
            let frame = render(&stage);
            let mut both = 0;
            for (pixel, found) in frame.color.iter().enumerate() {
                let met = intervals(&stage, pixel);
                let exact = closed_form(met, kappas(opacities), |kappa| kappa)[3];
                both += usize::from(met.iter().all(Option::is_some));
                let apart = (f64::from(found[3]) - exact).abs();
                assert!(apart < 1e-4, "pixel {pixel}: {found:?}, exact {exact}");
            }
            assert!(both > 50, "only {both} rays meet both boxes");
        }
    }
}

/// The same matter in two volumes, half as dense each, is what one volume of all of it is.
#[test]
fn two_halves_are_lit_as_one_whole() {
    let [(volume, _), _] = balls();
    let tf = |share: f32| {
        let opacity = |alpha: f32| 1.0 - (1.0 - alpha).powf(share);
        // Even between its points: extinction, not opacity, is what halves.
        transfer_function(&[(0.0, 0x4060ff), (1.0, 0xffffff)], &[(0.1, 0.0), (0.1, opacity(0.25))])
    };
    for (direct, indirect) in [(1.0, 0.0), (0.7, 0.8)] {
        let draw = |layers: &[(Arc<Volume>, TransferFunction)]| {
            render(&stage(layers, |scene| {
                by_half_angles(scene);
                for entry in &mut scene.volumes {
                    entry.scattering.phase = Phase::Isotropic;
                    entry.scattering.phase_normalization = PhaseNormalization::Renormalised;
                }
                let settings = HalfAngle { resolution: 96, direct, indirect, ..HalfAngle::default() };
                scene.technique = Technique::HalfAngle(settings);
                scene.camera.projection = Projection::Orthographic { height: Some(18.0) };
            }))
        };
        let halves = draw(&[(volume.clone(), tf(0.5)), (volume.clone(), tf(0.5))]);
        // Beside a volume of next to nothing light is looked at in the same texels; alone, in others.
        for (layers, limit) in [
            (vec![(volume.clone(), tf(1.0)), (volume.clone(), tf(1e-6))], 1e-3),
            (vec![(volume.clone(), tf(1.0))], 0.1),
        ] {
            let (mut mean, mut most, mut seen) = (0.0, 0.0f32, 0);
            let whole = draw(&layers);
            for (a, b) in whole.color.iter().zip(&halves.color) {
                for channel in 0..4 {
                    mean += f64::from((a[channel] - b[channel]).abs()) / (4 * whole.color.len()) as f64;
                    most = most.max((a[channel] - b[channel]).abs());
                }
                seen += usize::from(a[3] > 0.3 && a[0] > 0.02);
            }
            assert!(seen > 30 && mean < 2e-3 && most < limit, "{seen} pixels; {mean} in the mean, {most} at most");
        }
    }
}

#[test]
fn half_angle_light_knows_no_order_of_the_list() {
    let layers = three();
    let draw = |layers: &[(Arc<Volume>, TransferFunction)]| render(&stage(layers, by_half_angles));
    let frame = draw(&layers);
    assert!(frame.color.iter().any(|pixel| pixel[3] > 0.3));
    let [a, b, c] = <[_; 3]>::try_from(layers).unwrap();
    same(&draw(&[c, a, b]), &frame, "another order");
}

/// A dense plate between the light and a volume darkens it by its transmittance.
#[test]
fn half_angle_light_comes_through_other_volumes() {
    let plate = solid([17, 17, 2], DVec3::new(0.0, 0.0, 10.0), DVec3::ONE);
    let block = solid([17, 17, 3], DVec3::ZERO, DVec3::ONE);
    let draw = |dense: f32| {
        let layers = [(block.clone(), homogeneous(0.01)), (plate.clone(), homogeneous(dense))];
        let stage = stage(&layers, |scene| {
            by_half_angles(scene);
            scene.technique = Technique::HalfAngle(HalfAngle { indirect: 0.0, ..HalfAngle::default() });
            for entry in &mut scene.volumes {
                let phase_normalization = PhaseNormalization::Renormalised;
                entry.scattering = Scattering { phase: Phase::Isotropic, phase_normalization, ..Scattering::default() };
            }
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] })];
            let target = Some([8.0, 8.0, 1.0]);
            scene.camera.view =
                View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, target, distance: Some(60.0), ..Orbit::default() });
            scene.camera.projection = Projection::Orthographic { height: Some(0.5) };
            scene.quality.step = 0.25;
        });
        center(&render(&stage))[0]
    };
    let (dark, lit) = (draw(0.5), draw(0.0));
    let share = 0.5;
    assert!(lit > 0.05 && (dark / lit / share - 1.0).abs() < 0.01, "{} of the light, exact {share}", dark / lit);
}
