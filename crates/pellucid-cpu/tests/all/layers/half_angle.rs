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

/// The same of matter that a rule chooses where boxes overlap, whose borders cut slabs anywhere.
#[test]
fn half_angle_slices_meet_what_rules_choose() {
    let opacities = [0.12, 0.3];
    let larger = |[a, b]: [f64; 2]| if a > b { [a, 0.0] } else { [0.0, b] };
    let first = |[a, b]: [f64; 2]| if a > 0.0 { [a, 0.0] } else { [0.0, b] };
    let second = |[a, b]: [f64; 2]| if b > 0.0 { [0.0, b] } else { [a, 0.0] };
    type Rule = fn([f64; 2]) -> [f64; 2];
    let cases: [(Overlap, bool, Rule); 5] = [
        (Overlap::Maximum, false, larger),
        (Overlap::Maximum, true, larger),
        (Overlap::Priority, false, first),
        (Overlap::Priority, true, second),
        (Overlap::Fused { color: 1, opacity: 0 }, false, |[a, _]| [a, 0.0]),
    ];
    for (overlap, swapped, rule) in cases {
        for direction in [[-0.3, 0.4, -1.0], [0.2, -1.0, 0.1]] {
            let mut layers = boxes(opacities);
            if swapped {
                layers.reverse();
            }
            let chosen = stage(&layers, |scene| {
                by_half_angles(scene);
                scene.overlap = overlap;
                scene.lighting.lights = vec![Light::new(LightKind::Directional { direction })];
            });
            // What is fused has lost the colours that boxes are told by.
            let plain = stage(&layers, |_| ());
            let (frame, mut both) = (render(&chosen), 0);
            for (pixel, found) in frame.color.iter().enumerate() {
                let met = intervals(&plain, pixel);
                let exact = closed_form(met, kappas(opacities), rule)[3];
                both += usize::from(met.iter().all(Option::is_some));
                let apart = (f64::from(found[3]) - exact).abs();
                assert!(apart < 1e-4, "{overlap:?}, pixel {pixel}: {found:?}, exact {exact}");
            }
            assert!(both > 50, "{overlap:?}: only {both} rays meet both boxes");
        }
    }
}

#[test]
fn half_angle_light_knows_no_order_of_the_list() {
    for overlap in [Overlap::Add, Overlap::Maximum] {
        let layers = three();
        let draw = |layers: &[(Arc<Volume>, TransferFunction)], skipping| {
            render(&stage(layers, |scene| {
                by_half_angles(scene);
                (scene.overlap, scene.quality.empty_space_skipping) = (overlap, skipping);
            }))
        };
        let frame = draw(&layers, true);
        assert!(frame.color.iter().any(|pixel| pixel[3] > 0.3));
        same(&draw(&layers, false), &frame, &format!("{overlap:?} without skipping"));
        let [a, b, c] = <[_; 3]>::try_from(layers).unwrap();
        same(&draw(&[c, a, b], true), &frame, &format!("another order of {overlap:?}"));
    }
}

/// A volume twice in the same place is that volume once, where one of them is chosen.
#[test]
fn half_angle_light_meets_a_volume_once_where_rules_choose() {
    let [(volume, tf), _] = balls();
    for overlap in [Overlap::Maximum, Overlap::Priority] {
        let draw = |second: TransferFunction| {
            render(&stage(&[(volume.clone(), tf.clone()), (volume.clone(), second)], |scene| {
                by_half_angles(scene);
                scene.overlap = overlap;
                scene.camera.projection = Projection::Orthographic { height: Some(18.0) };
                // What is seen of nothing would move the eye.
                let (target, distance) = (Some([0.0; 3]), Some(40.0));
                scene.camera.view = View::Orbit(Orbit { target, distance, ..Orbit::default() });
            }))
        };
        let (twice, once) = (draw(tf.clone()), draw(homogeneous(0.0)));
        assert!(once.color.iter().filter(|pixel| pixel[3] > 0.3 && pixel[0] > 0.02).count() > 30);
        same(&twice, &once, &format!("a volume twice by {overlap:?}"));
    }
}

/// Fused with what is white a volume is white; with what is red it sends as much red, and nothing else. What gives its
/// colours holds no light back and sends none.
#[test]
fn half_angle_light_is_sent_in_the_colors_of_another_volume() {
    let [(volume, tf), _] = balls();
    // Around all of it.
    let other = solid([4; 3], DVec3::splat(-30.0), DVec3::splat(20.0));
    let draw = |color: u32, opacity: f32| {
        let layers =
            [(volume.clone(), tf.clone()), (other.clone(), transfer_function(&[(0.0, color)], &[(0.0, opacity)]))];
        render(&stage(&layers, |scene| {
            by_half_angles(scene);
            scene.overlap = Overlap::Fused { color: 1, opacity: 0 };
            scene.camera.projection = Projection::Orthographic { height: Some(18.0) };
        }))
    };
    let (white, red) = (draw(0xffffff, 0.0), draw(0xff0000, 0.9));
    assert!(white.color.iter().filter(|pixel| pixel[3] > 0.3 && pixel[0] > 0.02).count() > 30);
    for (white, red) in white.color.iter().zip(&red.color) {
        let [r, g, b, a] = *red;
        assert!((r - white[0]).abs() < 1e-6 && g == 0.0 && b == 0.0 && a == white[3], "{red:?} and {white:?}");
        assert!((white[0] - white[1]).abs() < 1e-6 && (white[0] - white[2]).abs() < 1e-6, "{white:?} is not white");
    }
}

/// Direct light from above on what scatters it evenly, seen from the side below the middle.
fn from_above(scene: &mut Scene, step: f64) {
    by_half_angles(scene);
    scene.technique = Technique::HalfAngle(HalfAngle { indirect: 0.0, ..HalfAngle::default() });
    for entry in &mut scene.volumes {
        let phase_normalization = PhaseNormalization::Renormalised;
        entry.scattering = Scattering { phase: Phase::Isotropic, phase_normalization, ..Scattering::default() };
    }
    scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] })];
    let (target, distance) = (Some([8.0, 8.0, 1.0]), Some(60.0));
    scene.camera.view = View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, target, distance, ..Orbit::default() });
    scene.camera.projection = Projection::Orthographic { height: Some(0.5) };
    scene.quality.step = step;
}

/// A plate within a box holds back as much of the light on its way through both as the rule leaves of them.
#[test]
fn half_angle_light_comes_through_what_rules_choose() {
    let opacities = [0.04, 0.3];
    let block = solid([17, 17, 17], DVec3::ZERO, DVec3::ONE);
    let plate = solid([17, 17, 5], DVec3::new(0.0, 0.0, 6.3), DVec3::ONE);
    let draw = |overlap, swapped: bool, dense: f32| {
        let mut layers = vec![(block.clone(), homogeneous(opacities[0])), (plate.clone(), homogeneous(dense))];
        if swapped {
            layers.reverse();
        }
        let stage = stage(&layers, |scene| {
            from_above(scene, 0.37);
            scene.overlap = overlap;
        });
        center(&render(&stage))[0]
    };
    let [thin, dense] = kappas(opacities);
    for (overlap, swapped, kappa) in [
        (Overlap::Add, false, dense),
        (Overlap::Maximum, false, dense - thin),
        (Overlap::Maximum, true, dense - thin),
        (Overlap::Priority, false, 0.0),
        (Overlap::Priority, true, dense - thin),
        (Overlap::Fused { color: 1, opacity: 0 }, false, 0.0),
    ] {
        let (dark, lit) = (draw(overlap, swapped, opacities[1]), draw(overlap, swapped, 0.0));
        let share = (-4.0 * kappa).exp();
        let found = f64::from(dark / lit);
        assert!(lit > 0.05 && (found / share - 1.0).abs() < 5e-3, "{overlap:?}: {found} of the light, exact {share}");
    }
}

/// A dense plate between the light and a volume darkens it by its transmittance.
#[test]
fn half_angle_light_comes_through_other_volumes() {
    let plate = solid([17, 17, 2], DVec3::new(0.0, 0.0, 10.0), DVec3::ONE);
    let block = solid([17, 17, 3], DVec3::ZERO, DVec3::ONE);
    let draw = |dense: f32| {
        let layers = [(block.clone(), homogeneous(0.01)), (plate.clone(), homogeneous(dense))];
        center(&render(&stage(&layers, |scene| from_above(scene, 0.25))))[0]
    };
    let (dark, lit) = (draw(0.5), draw(0.0));
    let share = 0.5;
    assert!(lit > 0.05 && (dark / lit / share - 1.0).abs() < 0.01, "{} of the light, exact {share}", dark / lit);
}
