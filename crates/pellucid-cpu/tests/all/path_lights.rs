//! Lights with a size and skies in the path tracer: chance finds what choice does, and both what geometry says.

use std::f64::consts::PI;

use crate::common::paths::*;
use crate::common::{homogeneous, render, set_mode, stage, transfer_function, unit_volume};
use pellucid_cpu::CpuRenderer;
use pellucid_optics::{Color, Environment, Light, LightKind, Phase, SkyImage, SkyMap, SkySource};
use pellucid_scene::{Classification, Control, Frame, Mode, PathTrace, RayCast, Technique};

/// A point, a ball and a face beside the cube, each in its full strength at the middle of the cube.
fn lamps(radius: f64) -> [Light; 3] {
    let falloff = pellucid_optics::Falloff::InverseSquare { reference: 8.0 };
    let side = radius * 2.0;
    let edges = [[0.0, side, 0.0], [0.0, 0.0, side]];
    [
        Light { radius: radius.min(40.0), ..directional([1.0, 0.3, 0.2]) },
        Light { radius, ..Light::new(LightKind::Point { position: [-4.0, 4.0, 4.0], falloff }) },
        Light::new(LightKind::Rectangle { center: [-4.0, 4.0, 4.0], edges, two_sided: false, falloff }),
    ]
}

#[test]
fn lights_of_any_size_are_found_by_choice_and_by_chance_alike() {
    let drawn = |light: Light, g: f32, samples| {
        let settings = PathTrace { samples, bounces: 3, ..PathTrace::default() };
        traced(cube(8), 0.15, settings, |scene| {
            scene.lighting.lights = vec![light];
            scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g }, 0.9);
        })
        .1
    };
    for (number, (large, small)) in lamps(3.0).into_iter().zip(lamps(1e-3)).enumerate() {
        for g in [0.0, 0.85] {
            // Lights that make no highlights are asked by choice alone.
            let (both, choice) = (drawn(large, g, 256), drawn(Light { specular: false, ..large }, g, 256));
            agree(&both, &choice, &format!("light {number}, g = {g}"));
        }
        let point = match small.kind {
            // A face shines less to its sides, which a point does not: it is held to itself, larger.
            LightKind::Rectangle { .. } => lamps(1e-2)[2],
            _ => Light { radius: 0.0, ..small },
        };
        agree(&drawn(small, 0.5, 256), &drawn(point, 0.5, 256), &format!("light {number}, small"));
    }
    // Chance helps where the phase function is the narrower one.
    let noise = |frame: &Frame| frame.noise.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
    let behind = Light { radius: 60.0, ..directional([0.0, -1.0, 0.0]) };
    let (both, choice) = (drawn(behind, 0.97, 256), drawn(Light { specular: false, ..behind }, 0.97, 256));
    agree(&both, &choice, "a narrow lobe");
    assert!(noise(&both) * 2.0 < noise(&choice), "{} and {}", noise(&both), noise(&choice));
}

#[test]
fn two_suns_of_half_the_sky_are_a_furnace() {
    let settings = PathTrace { samples: 256, ..PathTrace::default() };
    let (_, frame) = traced(blobs(12), 0.0, settings, |scene| {
        scene.volumes[0].transfer_function = Some(transfer_function(&[(0.0, 0x336699)], &[(0.0, 0.0), (1.0, 0.6)]));
        scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g: 0.6 }, 1.0);
        // A hemisphere of radiance 1 brings pi.
        let half = |z| Light { radius: 90.0, ..directional([0.2, 0.1, z]) };
        scene.lighting.lights =
            vec![half(1.0), Light { kind: LightKind::Directional { direction: [-0.2, -0.1, -1.0] }, ..half(1.0) }];
    });
    agrees(mean(&frame, |c| f64::from(c[0]) + 1.0 - f64::from(c[3])), 1.0, "two halves of a furnace");
}

#[test]
fn a_plate_casts_the_penumbra_of_the_sun() {
    // A plate over half of the volume, and below it thin fog, on which the sun of 25 degrees shines from above.
    const RADIUS: f64 = 25.0;
    let (plate, fog) = (20.0, 6.0);
    let volume = unit_volume([33, 9, 25], |p| match p.z {
        z if z == plate && p.x < 16.5 => 1.0,
        z if z == fog => 0.25,
        _ => 0.0,
    });
    let tf = transfer_function(
        &[(0.0, 0xffffff)],
        &[(0.0, 0.0), (0.12, 0.0), (0.13, 0.01), (0.27, 0.01), (0.4, 0.0), (0.5, 0.0), (0.51, 1.0)],
    );
    let settings = PathTrace { samples: 4096, bounces: 1, ..PathTrace::default() };
    let (stage, frame) = traced(volume, 0.0, settings, |scene| {
        scene.volumes[0].transfer_function = Some(tf);
        scene.volumes[0].scattering = scattering(Phase::Isotropic, 1.0);
        scene.lighting.lights = vec![Light { radius: RADIUS, ..directional([0.0, 0.0, -1.0]) }];
        (scene.image.width, scene.image.height) = (48, 32);
    });
    // The plate is opaque to halfway between its last voxel and the next; light comes by its other ends, too.
    // The fog is as deep as the plate, and lit alike all along.
    let visible = |x: f64| {
        const SIDE: usize = 120;
        const DEPTHS: usize = 32;
        let height = 1.0 - RADIUS.to_radians().cos();
        let past = (0..SIDE * SIDE * DEPTHS).filter(|k| {
            let cosine = 1.0 - height * ((k % SIDE) as f64 + 0.5) / SIDE as f64;
            let turn = 2.0 * PI * ((k / SIDE % SIDE) as f64 + 0.5) / SIDE as f64;
            let y = 8.0 * ((k / SIDE / SIDE) as f64 + 0.5) / DEPTHS as f64;
            let way = (1.0 - cosine * cosine).sqrt() / cosine * (plate - fog);
            let (x, y) = (x + way * turn.cos(), y + way * turn.sin());
            !((0.0..16.5).contains(&x) && (0.0..8.0).contains(&y))
        });
        past.count() as f64 / (SIDE * SIDE * DEPTHS) as f64
    };
    let (mut columns, mut partly) = (0, 0);
    let full = 0.25 * 2.0 / (1.0 + RADIUS.to_radians().cos());
    for column in 0..48 {
        let x = stage.viewpoint.ray(column as f64 + 0.5, 16.0).origin.x;
        if !(2.0..30.0).contains(&x) {
            continue;
        }
        let rows: Vec<usize> =
            (0..32).filter(|row| (5.0..7.0).contains(&stage.viewpoint.ray(0.5, *row as f64 + 0.5).origin.z)).collect();
        let sum =
            |channel: usize| rows.iter().map(|row| f64::from(frame.color[row * 48 + column][channel])).sum::<f64>();
        let error = rows.iter().map(|row| f64::from(frame.noise[row * 48 + column]).powi(2)).sum::<f64>().sqrt();
        let (found, expected) = (sum(0) / sum(3) / full, visible(x));
        // The fog is a voxel thick and half sees the plate's lower side: a few hundredths.
        assert!((found - expected).abs() < 4.0 * error / sum(3) / full + 0.04, "{x}: {found}, not {expected}");
        columns += 1;
        partly += usize::from((0.1..0.9).contains(&expected));
    }
    assert!(columns > 20 && partly > 8, "{columns} columns, {partly} in the penumbra");
}

#[test]
fn techniques_that_draw_points_say_so() {
    let sized = vec![directional([1.0, 0.0, 0.0]), Light { radius: 2.0, ..directional([1.0, 0.0, 0.0]) }];
    let warnings = |technique| {
        let drawn = stage(cube(4), homogeneous(0.2), |scene| {
            scene.technique = technique;
            scene.lighting.lights = sized.clone();
        });
        render(&drawn).warnings
    };
    let found = warnings(Technique::RayCast(RayCast::default()));
    assert_eq!(found.len(), 1);
    assert!(found[0].to_string().contains("lighting.lights[1] has a size"), "{}", found[0]);
    // Integrals over segments hold all colours back alike, and sums of samples have no extinction to colour.
    for (classification, mode, told) in [
        (Classification::Post, Mode::Composite, None),
        (Classification::PreIntegrated, Mode::Composite, Some("extinction_color is drawn with post-classification")),
        (Classification::Post, Mode::Additive, Some("extinction_color is not drawn")),
    ] {
        let drawn = stage(cube(4), homogeneous(0.2), |scene| {
            scene.volumes[0].scattering.extinction_color = Some(Color::hex(0xff8080));
            scene.quality.classification = classification;
            set_mode(scene, mode);
        });
        let warnings = render(&drawn).warnings;
        assert_eq!(warnings.len(), usize::from(told.is_some()), "{warnings:?}");
        assert!(told.is_none_or(|told| warnings[0].to_string().contains(told)), "{warnings:?}");
    }
    assert!(warnings(Technique::PathTrace(PathTrace { samples: 4, ..PathTrace::default() })).is_empty());
}

#[test]
fn a_point_light_and_a_spot_light_reach_what_they_shine_on() {
    // A thin cube, so that single scattering is albedo kappa P pi E over its depth.
    let light = Light::new(LightKind::Point {
        position: [4.0, -20.0, 4.0],
        falloff: pellucid_optics::Falloff::InverseSquare { reference: 20.0 },
    });
    let settings = PathTrace { samples: 1024, bounces: 1, ..PathTrace::default() };
    let (_, frame) = traced(cube(8), 0.001, settings, |scene| {
        scene.lighting.lights = vec![light];
        scene.volumes[0].scattering = scattering(Phase::Isotropic, 1.0);
    });
    let center = middle(&frame);
    let (covered, _) = mean(&center, |c| f64::from(c[3]));
    let (bright, error) = mean(&center, |c| f64::from(c[0]));
    // The mean over the depth of (20 / (20 + y))^2 is 20 / 28; a quarter of it by an isotropic phase.
    assert!((bright / covered - 0.25 * 20.0 / 28.0).abs() < 4.0 * error / covered + 0.003, "{bright} of {covered}");
}

/// A sky of these texels, which is read.
fn picture(width: usize, height: usize, rotation: f64, texel: impl Fn(usize) -> [f32; 3]) -> Environment {
    let map = SkyMap::new(width, height, (0..width * height).map(texel).collect()).unwrap();
    let map = Some(std::sync::Arc::new(map));
    Environment::Image(SkyImage { source: SkySource::Day, rotation, intensity: 1.0, map })
}

#[test]
fn a_picture_of_the_sky_lights_as_its_texels_do() {
    let drawn = |environment, lights: Vec<Light>, g: f32, bounces| {
        let settings = PathTrace { samples: 256, bounces, environment, ..PathTrace::default() };
        traced(blobs(12), 0.0, settings, |scene| {
            scene.volumes[0].transfer_function = Some(transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.0), (1.0, 0.6)]));
            scene.volumes[0].scattering = scattering(Phase::HenyeyGreenstein { g }, 1.0);
            scene.lighting.lights = lights;
        })
        .1
    };
    let furnace = drawn(picture(16, 8, 30.0, |_| [1.0; 3]), vec![], 0.6, 1000);
    agrees(mean(&furnace, |c| f64::from(c[1]) + 1.0 - f64::from(c[3])), 1.0, "an even picture is a furnace");
    // One bright texel of 256 x 128, turned, is a light from there of its radiance times its solid angle over pi.
    let [column, row] = [200, 40];
    let [top, bottom] = [row, row + 1].map(|side| (PI * side as f64 / 128.0).cos());
    let brightness = (PI / (2.0 * PI / 256.0 * (top - bottom))) as f32;
    let bright = move |k: usize| if k == row * 256 + column { [brightness; 3] } else { [0.0; 3] };
    let turn = ((column as f64 + 0.5) / 256.0 - 0.5) * 2.0 * PI - 40f64.to_radians();
    let (z, across) = ((top + bottom) / 2.0, (1.0 - ((top + bottom) / 2.0f64).powi(2)).sqrt());
    let sun = directional([-turn.sin() * across, -turn.cos() * across, -z]);
    for g in [0.0, 0.7] {
        let [sky, light] =
            [drawn(picture(256, 128, 40.0, bright), vec![], g, 3), drawn(Environment::Dark, vec![sun], g, 3)];
        agree(&sky, &light, "one bright texel");
    }
    // The gradient sky as a picture of many rows.
    let ends = (Color::hex(0xffffff), Color::hex(0x202020));
    let gradient = Environment::Gradient { top: ends.0, bottom: ends.1, intensity: 1.0 };
    let [high, low] = [ends.0, ends.1].map(|color| color.to_linear(pellucid_optics::ColorSpace::Srgb)[0]);
    let rows = move |k: usize| {
        let z = (PI * ((k / 4) as f64 + 0.5) / 256.0).cos() as f32;
        [low + (high - low) * (0.5 + 0.5 * z); 3]
    };
    agree(&drawn(gradient, vec![], 0.5, 1000), &drawn(picture(4, 256, 0.0, rows), vec![], 0.5, 1000), "a gradient");
}

#[test]
fn a_picture_that_was_not_read_is_an_error() {
    let source = SkySource::File("sky.exr".into());
    let environment = Environment::Image(SkyImage { source, rotation: 0.0, intensity: 1.0, map: None });
    let stage = stage(cube(4), homogeneous(0.5), |scene| {
        scene.technique = Technique::PathTrace(PathTrace { environment, ..PathTrace::default() });
    });
    let error = CpuRenderer::new().render(&stage, &Control::default()).unwrap_err();
    assert!(error.to_string().contains("sky.exr has not been read"), "{error}");
}
