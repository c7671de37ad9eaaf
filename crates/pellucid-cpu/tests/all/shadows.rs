//! What is left of lights on their way to samples has closed forms (6.1, K-03, K-04).

use crate::common::{center, homogeneous, render, set_mode, stage, transfer_function, unit_volume};
use glam::DVec3;
use pellucid_cpu::{CpuRenderer, RenderError};
use pellucid_field::Volume;
use pellucid_optics::{
    Color, ColorSpace, Light, LightKind, LightModel, Phase, PhaseNormalization, Scattering, ShadowRays, ShadowVolume,
    Shadows, TransferFunction,
};
use pellucid_plan::half_angle::LightError;
use pellucid_scene::{Classification, Control, Isosurface, Isovalue, Mode, Orbit, Projection, Scene, Stage, View};

/// A ball above a plate, as distances: positive inside the ball, far below -100 in the plate.
fn ball_and_plate(plate: impl Fn(DVec3) -> bool) -> Volume {
    unit_volume([64; 3], |p| if plate(p) { -200.0 } else { RADIUS - (p - CENTER).length() })
}

const RADIUS: f64 = 12.0;
const CENTER: DVec3 = DVec3::new(31.5, 31.5, 40.0);
/// Opacity of the ball per unit.
const OPACITY: f32 = 0.05;

/// A plate so thin that what it shows is the light on it, under a ball of constant extinction.
fn plate_function() -> TransferFunction {
    transfer_function(&[(0.0, 0xffffff)], &[(-150.0, 1e-4), (-149.0, 0.0), (0.0, 0.0), (0.0, OPACITY)])
}

/// Samples that scatter all light evenly, and one light from above.
fn lit(scene: &mut Scene, shadows: Shadows) {
    let renormalised = PhaseNormalization::Renormalised;
    scene.volumes[0].scattering =
        Scattering { phase: Phase::Isotropic, phase_normalization: renormalised, ..Scattering::default() };
    scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] })];
    scene.lighting.ambient = 0.0;
    scene.lighting.model = LightModel::Scattering;
    scene.lighting.shadows = shadows;
}

/// The light on the plate and the distance from the shadow's middle, for every pixel that shows nothing else.
fn light_on_plate(shadows: Shadows, edit: impl Fn(&mut Scene)) -> Vec<(f64, f64)> {
    colors_on_plate(shadows, edit).into_iter().map(|(offset, [red, _, _])| (offset, red)).collect()
}

fn colors_on_plate(shadows: Shadows, edit: impl Fn(&mut Scene)) -> Vec<(f64, [f64; 3])> {
    let stage = stage(ball_and_plate(|p| p.z <= 5.0 && p.z >= 3.0), plate_function(), |scene| {
        lit(scene, shadows);
        scene.image.width = 48;
        scene.image.height = 48;
        scene.quality.step = 0.25;
        scene.camera.projection = Projection::Orthographic { height: Some(40.0) };
        let target = Some([CENTER.x, CENTER.y, 4.0]);
        scene.camera.view =
            View::Orbit(Orbit { azimuth: 0.0, elevation: 60.0, target, distance: Some(200.0), ..Orbit::default() });
        edit(scene);
    });
    let frame = render(&stage);
    let mut found = Vec::new();
    for (pixel, color) in frame.color.iter().enumerate() {
        let ray = stage.viewpoint.ray((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
        let at = ray.at((4.0 - ray.origin.z) / ray.direction.z);
        let inside = at.x > 4.0 && at.x < 59.0 && at.y > 4.0 && at.y < 59.0;
        if inside && color[3] > 1e-5 && color[3] < 1e-3 {
            let offset = (at - CENTER).truncate().length();
            found.push((offset, [0, 1, 2].map(|channel| f64::from(color[channel] / color[3]))));
        }
    }
    assert!(found.len() > 500, "{} pixels", found.len());
    found
}

fn shadow_of_ball(offset: f64) -> f64 {
    let chord = 2.0 * (RADIUS * RADIUS - offset * offset).max(0.0).sqrt();
    (1.0 - f64::from(OPACITY)).powf(chord)
}

/// K-03, with the plate's own thickness in the picture: 0.6 voxels to either side at 60 degrees.
#[test]
fn a_ball_shadows_a_plate_by_its_chords() {
    for classification in [Classification::Post, Classification::PreIntegrated] {
        let rays = Shadows::Rays(ShadowRays { step: 0.1 });
        for (offset, light) in light_on_plate(rays, |scene| scene.quality.classification = classification) {
            let exact = shadow_of_ball(offset);
            // At the middle the profile is flat; towards the rim it falls with a root, over which the plate averages.
            let bound = if offset < 1.0 {
                1e-3
            } else if offset < RADIUS - 2.0 {
                1e-2
            } else {
                0.2
            };
            assert!((light - exact).abs() < bound, "{classification:?} at {offset}: {light}, exact {exact}");
            assert!(offset < RADIUS + 1.5 || (light - 1.0).abs() < 1e-3, "unshadowed at {offset}: {light}");
        }
    }
}

/// K-13: of each colour `exp(-f tau)` gets through, and the thin plate shows a share `f` of it; a light volume tells it
/// as far as its points resolve the ball.
#[test]
fn each_colour_has_its_own_shadow() {
    let volume = ShadowVolume { resolution: 1.0 };
    for (shadows, room) in [(Shadows::Rays(ShadowRays { step: 0.1 }), 1.0), (Shadows::Volume(volume), 3.0)] {
        for color in [0xffbc80, 0xbc00ff] {
            let factors = Color::hex(color).to_linear(ColorSpace::Srgb);
            let tinted = |scene: &mut Scene| {
                scene.volumes[0].scattering.extinction_color = Some(Color::hex(color));
                scene.volumes[0].transfer_function = Some(transfer_function(
                    &[(0.0, 0xffffff)],
                    &[(-150.0, 1e-4), (-149.0, 0.0), (0.0, 0.0), (0.0, 0.3)],
                ));
            };
            for (offset, light) in colors_on_plate(shadows, tinted) {
                let chord = 2.0 * (RADIUS * RADIUS - offset * offset).max(0.0).sqrt();
                for channel in 0..3 {
                    let factor = f64::from(factors[channel]);
                    let mean = f64::from(factors.iter().sum::<f32>()) / 3.0;
                    if factor == 0.0 {
                        assert_eq!(light[channel], 0.0);
                        continue;
                    }
                    let exact = 0.7f64.powf(chord * factor);
                    let found = light[channel] * mean / factor;
                    // At the rim the thickness of the plate spreads the shadow's edge.
                    let is_rim = (offset - RADIUS).abs() < 2.0;
                    let bound = if is_rim { 1.0 } else { 0.02 * room };
                    assert!(
                        (found - exact).abs() < bound,
                        "{shadows:?}, {channel} at {offset}: {found}, exact {exact}"
                    );
                }
            }
        }
    }
}

/// What all colours lose alike is the extinction itself, to the bit.
#[test]
fn white_extinction_changes_no_shadow() {
    let drawn = |extinction_color| {
        let stage = stage(ball_and_plate(|p| p.z <= 5.0 && p.z >= 3.0), plate_function(), |scene| {
            lit(scene, Shadows::Rays(ShadowRays { step: 0.5 }));
            scene.volumes[0].scattering.extinction_color = extinction_color;
            scene.camera.view = View::Orbit(Orbit { azimuth: 30.0, elevation: 40.0, ..Orbit::default() });
        });
        render(&stage)
    };
    let [plain, white, tinted] = [None, Some(Color::WHITE), Some(Color::hex(0xff8080))].map(drawn);
    assert_eq!((&plain.color, plain.warnings.len()), (&white.color, white.warnings.len()));
    assert_ne!(plain.color, tinted.color);
    assert!(plain.warnings.is_empty() && tinted.warnings.is_empty(), "{:?}", tinted.warnings);
}

/// A block lit from the eye sends back half of what it holds back of both ways (6.1-1, K-10 without slices).
#[test]
fn a_block_lit_from_the_eye_has_its_closed_form() {
    let tau = -(1.0 - f64::from(OPACITY)).ln();
    for length in [5usize, 20] {
        let stage = stage(unit_volume([12, length + 1, 12], |_| 1.0), homogeneous(OPACITY), |scene| {
            lit(scene, Shadows::Rays(ShadowRays { step: 0.25 }));
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 1.0, 0.0] })];
            scene.quality.step = 0.05;
        });
        let exact = (1.0 - (-2.0 * tau * length as f64).exp()) / 2.0;
        let found = f64::from(center(&render(&stage))[0]);
        assert!((found - exact).abs() < 1e-5, "length {length}: {found}, exact {exact}");
    }
}

/// Clips end the ways of light, too: what they remove holds nothing back.
#[test]
fn what_is_clipped_casts_no_shadow() {
    let cut = |scene: &mut Scene| {
        let normal = [0.0, 0.0, -1.0];
        scene.clips = vec![pellucid_scene::Clip::Plane { point: [0.0, 0.0, CENTER.z], normal }];
    };
    for (offset, light) in light_on_plate(Shadows::Rays(ShadowRays { step: 0.1 }), cut) {
        if offset < RADIUS - 2.0 {
            let exact = shadow_of_ball(offset).sqrt();
            assert!((light - exact).abs() < 1e-2, "at {offset}: {light}, exact {exact}");
        }
    }
}

/// A light within the medium is as far as it is.
#[test]
fn the_way_to_a_near_light_ends_there() {
    let stage = stage(unit_volume([41; 3], |_| 1.0), homogeneous(1e-4), |scene| {
        lit(scene, Shadows::Rays(ShadowRays { step: 0.5 }));
        let position = [20.0, 20.0, 30.0];
        scene.lighting.lights = vec![Light::new(LightKind::Point { position, falloff: Default::default() })];
        scene.volumes[0].transfer_function = Some(homogeneous(0.05));
        scene.clips = vec![pellucid_scene::Clip::Box { min: [19.9, 19.9, 9.9], max: [20.1, 20.1, 41.0] }];
        scene.camera.projection = Projection::Orthographic { height: Some(0.05) };
        let target = Some([20.0, 20.0, 10.0]);
        let orbit = Orbit { azimuth: 0.0, elevation: 0.0, target, distance: Some(100.0), ..Orbit::default() };
        scene.camera.view = View::Orbit(orbit);
        scene.quality.step = 0.02;
    });
    let [color, .., alpha] = center(&render(&stage));
    // The light comes down the shaft that the clip leaves: 20 units of the medium.
    let exact = 0.95f64.powf(20.0);
    assert!((f64::from(color / alpha) - exact).abs() < 2e-3, "{} and {exact}", color / alpha);
}

/// The shadow of an isosurface has its outline, and holds back all light or the surface's share of it.
#[test]
fn isosurfaces_cast_shadows() {
    for (opacity, shadows) in [
        (1.0, Shadows::Rays(ShadowRays::default())),
        (0.4, Shadows::Rays(ShadowRays { step: 0.5 })),
        (1.0, Shadows::Volume(ShadowVolume::default())),
    ] {
        let surface = |value, opacity| Isovalue { value, color: None, opacity, volume: None };
        let edit = |scene: &mut Scene, shadows| {
            // The plate reaches below 4, the ball above 100.
            let isovalues = vec![surface(4.0, 1.0), surface(100.0, opacity)];
            set_mode(scene, Mode::Isosurface(Isosurface::new(isovalues)));
            scene.volumes[0].shading = Some(true);
            lit(scene, shadows);
            scene.image.width = 48;
            scene.image.height = 48;
            scene.camera.projection = Projection::Orthographic { height: Some(40.0) };
            let target = Some([CENTER.x, CENTER.y, 4.0]);
            scene.camera.view =
                View::Orbit(Orbit { azimuth: 0.0, elevation: 60.0, target, distance: Some(200.0), ..Orbit::default() });
        };
        // Distances from the plate up to 50, and the ball in it.
        let volume = || {
            unit_volume([64; 3], |p| {
                let ball = RADIUS - (p - CENTER).length();
                if ball > -2.0 { 100.0 + ball } else { p.z.min(50.0) }
            })
        };
        let draw = |shadows| -> Stage { stage(volume(), homogeneous(0.5), |scene| edit(scene, shadows)) };
        let (bright, dark) = (render(&draw(Shadows::None)), render(&draw(shadows)));
        let view = draw(shadows).viewpoint;
        let (mut shadowed, mut lit) = (0, 0);
        for (pixel, (bright, dark)) in bright.color.iter().zip(&dark.color).enumerate() {
            let ray = view.ray((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
            let at = ray.at((4.0 - ray.origin.z) / ray.direction.z);
            let offset = (at - CENTER).truncate().length();
            let clear = (at - ray.direction * 50.0 - CENTER).cross(ray.direction).length() > RADIUS + 3.0;
            if !clear || at.min_element() < 3.0 || at.x.max(at.y) > 60.0 {
                continue;
            }
            // The ball's box of values has a surface on either side.
            let share = dark[0] / bright[0];
            if offset < RADIUS - 1.0 {
                let left = (1.0 - opacity).powi(2);
                assert!((share - left).abs() < 1e-3, "opacity {opacity} at {offset}: {share}");
                shadowed += 1;
            } else if offset > RADIUS + 3.5 {
                assert_eq!(share, 1.0, "at {offset}");
                lit += 1;
            }
        }
        assert!(shadowed > 100 && lit > 100, "{shadowed} {lit}");
    }
}

/// Every sample is lit by what is left of the light, whatever else lights it: a shaded block whose surface
/// turns to a light behind the block.
#[test]
fn shaded_samples_see_shadows() {
    let draw = |shadows| {
        let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (10.0, 0.5)]);
        let stage = stage(unit_volume([24; 3], |p| p.y), tf, |scene| {
            scene.volumes[0].shading = Some(true);
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, -1.0, 0.0] })];
            scene.lighting.ambient = 0.0;
            scene.lighting.shadows = shadows;
            scene.volumes[0].material = Some(pellucid_optics::Material { two_sided: false, ..Default::default() });
        });
        center(&render(&stage))
    };
    // The normal points to lower values, towards the eye; the light comes from behind: nothing at all.
    assert_eq!(draw(Shadows::None)[0], 0.0);
    let draw = |shadows| {
        let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (10.0, 0.5)]);
        let stage = stage(unit_volume([24; 3], |p| p.y), tf, |scene| {
            scene.volumes[0].shading = Some(true);
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 1.0, 0.0] })];
            scene.lighting.ambient = 0.0;
            scene.lighting.shadows = shadows;
        });
        center(&render(&stage))
    };
    let [bright, dark] = [Shadows::None, Shadows::Rays(ShadowRays { step: 0.25 })].map(draw);
    // Both ways are the same, so a share `1 - a / 2` of the light is left on the mean.
    assert!((bright[3] - dark[3]).abs() < 1e-6 && bright[3] > 0.99);
    let share = dark[0] / bright[0];
    assert!((share - 0.5).abs() < 0.02, "{share}");
}

/// The light from above at every height of a thin medium with an opaque plate, one voxel thick, at 40.
fn light_around_plate(edit: impl Fn(&mut Scene)) -> Vec<(f64, f64)> {
    let tf = transfer_function(&[(0.0, 0xffffff)], &[(1.0, 1e-4), (1.4, 1e-4), (1.4, 1.0)]);
    let plate = |p: DVec3| if (39.5..40.5).contains(&p.z) { 2.0 } else { 1.0 };
    let stage = stage(unit_volume([33, 17, 65], plate), tf, |scene| {
        lit(scene, Shadows::None);
        scene.image.width = 8;
        scene.image.height = 256;
        scene.camera.projection = Projection::Orthographic { height: Some(64.0) };
        scene.quality.step = 0.25;
        edit(scene);
    });
    let frame = render(&stage);
    let heights =
        (0..256).map(|row| (64.0 * (1.0 - (f64::from(row) + 0.5) / 256.0), frame.color[row as usize * 8 + 4]));
    let thin = heights.filter(|(_, color)| color[3] > 1e-5 && color[3] < 0.01);
    thin.map(|(height, [r, _, _, a])| (height, f64::from(r / a))).collect()
}

/// K-04, 6.1-2: the interpolated light volume smears light across the plate, over two of its cells at most;
/// shadow rays and half-angle slicing do not.
#[test]
fn shadow_volumes_leak_and_slices_do_not() {
    let sharp = |light: Vec<(f64, f64)>, what: &str| {
        for (height, light) in light {
            let expected = if height > 40.0 { 1.0 } else { 0.0 };
            assert!((light - expected).abs() < 5e-3, "{what} at {height}: {light}");
        }
    };
    sharp(light_around_plate(|scene| scene.lighting.shadows = Shadows::Rays(ShadowRays { step: 0.2 })), "rays");
    let half_angle = pellucid_scene::HalfAngle { indirect: 0.0, ..Default::default() };
    let slices = light_around_plate(|scene| scene.technique = pellucid_scene::Technique::HalfAngle(half_angle.clone()));
    // A slice is lit in front of it, and a slice's depth here is less than half a voxel.
    sharp(slices.into_iter().filter(|(height, _)| (height - 40.0).abs() > 1.0).collect(), "slices");
    for resolution in [1.0, 0.5, 0.25] {
        let volume = Shadows::Volume(ShadowVolume { resolution });
        let light = light_around_plate(|scene| scene.lighting.shadows = volume);
        let cell = 1.0 / resolution;
        let between = |&&(_, light): &&(f64, f64)| (0.01..0.99).contains(&light);
        let band: Vec<f64> = light.iter().filter(between).map(|(height, _)| *height).collect();
        let (low, high) = band.iter().fold((f64::INFINITY, 0.0f64), |(low, high), at| (low.min(*at), high.max(*at)));
        println!("resolution {resolution}: light leaks from {low} to {high}, {:.2} cells", (high - low) / cell);
        // The plate reaches to 40.6, the next point in front of it is at most a cell from its middle.
        assert!(high > 40.6 + 0.5 * (cell - 0.6), "no leak at {resolution}: {low} to {high}");
        assert!(high - low < 2.0 * cell + 1.0, "{resolution}: {low} to {high}");
        for (height, light) in light {
            assert!(height > 40.0 - cell - 1.0 || light < 0.01, "{resolution}: {light} behind, at {height}");
            assert!(height < 40.0 + cell + 1.0 || light > 0.98, "{resolution}: {light} in front, at {height}");
        }
    }
}

/// At the resolution of the data the light volume shows what rays find, for any light and clips.
#[test]
fn shadow_volumes_approach_rays() {
    let point = LightKind::Point { position: [70.0, -10.0, 90.0], falloff: Default::default() };
    let tf = || transfer_function(&[(0.0, 0xffffff)], &[(-20.0, 0.0), (0.0, 0.02), (12.0, 0.2)]);
    let lights = [LightKind::Directional { direction: [0.5, 0.6, -1.0] }, point];
    for light in lights {
        let draw = |shadows| {
            let ball = unit_volume([48; 3], |p| 12.0 - (p - DVec3::new(24.0, 22.0, 26.0)).length());
            render(&stage(ball, tf(), |scene| {
                lit(scene, shadows);
                scene.lighting.lights =
                    vec![Light::new(light), Light::new(LightKind::Directional { direction: [-1.0, 0.1, 0.3] })];
                scene.clips = vec![pellucid_scene::Clip::Plane { point: [24.0; 3], normal: [0.3, -1.0, 0.5] }];
                scene.image.width = 40;
                scene.image.height = 40;
            }))
        };
        let exact = draw(Shadows::Rays(ShadowRays { step: 0.25 }));
        let plain = draw(Shadows::None);
        let error = |frame: &pellucid_scene::Frame| {
            let pairs = frame.color.iter().zip(&exact.color);
            (pairs.map(|(a, b)| f64::from(a[0] - b[0]).powi(2)).sum::<f64>() / 1600.0).sqrt()
        };
        let found = [2.0, 1.0, 0.5].map(|resolution| error(&draw(Shadows::Volume(ShadowVolume { resolution }))));
        println!("{found:?}, without shadows {}", error(&plain));
        assert!(found[0] < 4e-3 && found[1] < 8e-3 && found[2] < 2e-2 && found[0] < found[2], "{found:?}");
        assert!(error(&plain) > 0.2);
    }
}

/// What is kept from frame to frame is of this light, transfer function and volume (6.0-2): whatever changes, a
/// fresh renderer draws the same bits.
#[test]
fn light_that_is_kept_is_this_light() {
    let mut kept = CpuRenderer::new();
    for (round, shadows) in [Shadows::Volume(ShadowVolume::default()), Shadows::Rays(ShadowRays::default())]
        .into_iter()
        .flat_map(|shadows| (0..5).map(move |round| (round, shadows)))
    {
        let opacity = if round == 2 { 0.3 } else { 0.1 };
        let ball = unit_volume([24; 3], |p| 6.0 - (p - DVec3::splat(if round == 3 { 9.0 } else { 12.0 })).length());
        let tf = transfer_function(&[(0.0, 0xffffff)], &[(-4.0, 0.0), (6.0, opacity)]);
        let stage = stage(ball, tf, |scene| {
            lit(scene, shadows);
            if round == 1 {
                scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [1.0, 0.2, 0.0] })];
            }
            if round == 4 {
                scene.clips = vec![pellucid_scene::Clip::Plane { point: [12.0; 3], normal: [0.0, 0.0, 1.0] }];
            }
        });
        let drawn = kept.render(&stage, &Control::default()).unwrap();
        assert!(drawn.color == render(&stage).color, "round {round}");
    }
}

/// A light in the volume has no slabs that it shines through in one order.
#[test]
fn a_shadow_volume_needs_lights_outside() {
    let stage = stage(unit_volume([8; 3], |_| 1.0), homogeneous(0.1), |scene| {
        lit(scene, Shadows::Volume(ShadowVolume::default()));
        let position = [4.0; 3];
        scene.lighting.lights.push(Light::new(LightKind::Point { position, falloff: Default::default() }));
    });
    let error = CpuRenderer::new().render(&stage, &Control::default()).unwrap_err();
    assert_eq!(error, RenderError::Light(LightError::Inside { light: 1 }));
}

/// Without normals noise of a flat region is not seen (6.0-1): a hundredth of the range on every voxel.
#[test]
fn scattering_does_not_see_noise() {
    let noise = |p: DVec3| (p.dot(DVec3::new(12.9898, 78.233, 37.719)).sin() * 43_758.547).fract() * 0.035;
    let spread = |model: LightModel, flat: bool| {
        let tf = transfer_function(&[(0.0, 0x808080), (1.0, 0xffffff)], &[(0.0, 0.3)]);
        let value = |p| if flat { 0.5 } else { 0.5 + noise(p) };
        let stage = stage(unit_volume([24; 3], value), tf, |scene| {
            lit(scene, Shadows::Rays(ShadowRays::default()));
            scene.lighting.model = model;
            scene.lighting.lights = vec![Light::new(LightKind::Directional { direction: [0.0, 1.0, 0.0] })];
            scene.volumes[0].shading = Some(true);
            scene.camera.projection = Projection::Orthographic { height: Some(16.0) };
        });
        let colors: Vec<f64> = render(&stage).color.iter().map(|color| f64::from(color[0])).collect();
        assert!(colors.iter().all(|color| color.is_finite() && *color >= 0.0));
        let mean = colors.iter().sum::<f64>() / colors.len() as f64;
        assert!(flat || mean > 0.01, "{mean}");
        colors.iter().map(|color| (color - mean).powi(2)).sum::<f64>() / colors.len() as f64
    };
    let [surface, cloud] = [LightModel::Surface, LightModel::Scattering].map(|model| spread(model, false));
    assert!(cloud <= surface / 10.0, "{cloud} and {surface}");
    // Where the gradient is zero nothing turns into NaN.
    assert!(spread(LightModel::Surface, true) < 1e-12 && spread(LightModel::Scattering, true) < 1e-4);
}
