//! Shadow rays are those of the CPU backend, whose pictures are held to closed forms there.

use std::sync::Arc;

use crate::common::{LEVEL, difference, draw, gpu, sample, side, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuError, Part};
use pellucid_plan::half_angle::LightError;
use pellucid_scene::{Control, RenderWarning};

const LIGHTS: &str = "lights = [{ kind.directional.direction = [0.8, 0.4, -0.5] }, \
    { kind.point = { position = [-20, -15, 18], falloff = \"none\" }, intensity = 0.5 }]";

#[test]
fn shadows_are_those_of_the_cpu() {
    let volume = sample("wavelet", [24, 20, 28], VoxelType::F32);
    let medium = "unit_distance = 1.0\n[volumes.transfer_function]\ncolors = [[80, \"#3050e0\"], [260, \"#e04020\"]]\n\
         opacities = [[90, 0], [140, 0.1], [170, 0.0], [190, 0.25], [270, 0.9]]\n";
    let surfaces =
        "[technique.ray_cast.mode.isosurface]\nisovalues = [{ value = 150, opacity = 0.4 }, { value = 210 }]\n";
    let clip = "[[clips]]\nplane = { point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }\n";
    let cases = [
        ("shading = true", medium.to_owned(), "shadows.rays = {}\n"),
        ("shading = true", format!("{medium}{clip}[quality]\nclassification = \"pre\"\n"), "shadows.rays.step = 0.6\n"),
        (
            "shading = true",
            format!("{medium}[quality]\nclassification = \"pre_integrated\"\nempty_space_skipping = false\n"),
            "shadows.rays = {}\n",
        ),
        (
            "shading = false",
            format!("{medium}[volumes.scattering]\nphase.henyey_greenstein.g = 0.5\n"),
            "shadows.rays = {}\nmodel = \"scattering\"\n",
        ),
        (
            "shading = false",
            format!("{medium}[volumes.scattering]\nextinction_color = \"#ffbc40\"\n"),
            "shadows.rays = {}\nmodel = \"scattering\"\n",
        ),
        (
            "shading = true",
            format!("{medium}[volumes.scattering]\nextinction_color = \"#00bcff\"\n"),
            "shadows.rays = {}\n",
        ),
        ("shading = true", format!("{surfaces}{clip}"), "shadows.rays = {}\n"),
        ("shading = true", surfaces.to_owned(), "shadows.volume = {}\n"),
        ("shading = true", medium.to_owned(), "shadows.volume = {}\n"),
        (
            "shading = true",
            format!("{medium}{clip}[quality]\nclassification = \"pre\"\n"),
            "shadows.volume.resolution = 1.3\n",
        ),
        (
            "shading = true",
            format!("{medium}[quality]\nclassification = \"pre_integrated\"\nempty_space_skipping = false\n"),
            "shadows.volume.resolution = 0.2\n",
        ),
        (
            "shading = false",
            format!("{medium}[volumes.scattering]\nphase.henyey_greenstein.g = 0.5\nalbedo.constant = 0.6\n"),
            "shadows.volume = {}\nmodel = \"scattering\"\n",
        ),
        (
            "shading = true",
            format!("{medium}[quality]\nadaptive_tolerance = 0.01\nfilter = {{ bc = {{ b = 0.3333, c = 0.3333 }} }}\n"),
            "shadows.volume = {}\n",
        ),
    ];
    for (volume_settings, rest, lighting) in cases {
        let document = |lighting: &str| format!("{volume_settings}\n{rest}[lighting]\n{lighting}{LIGHTS}\n");
        let lit = stage(&volume, &document(lighting), [40, 34]);
        let expected = CpuRenderer::default().render(&lit, &Control::default()).unwrap();
        let found = draw(&mut gpu(&Ceiling::default()), &lit);
        let apart = difference(&expected, &found);
        // Where a shadow ray grazes a surface, either side of it may be right.
        let is_surface = rest.contains("isosurface");
        let pairs = expected.color.as_flattened().iter().zip(found.color.as_flattened());
        let far = pairs.filter(|(a, b)| (*a - *b).abs() > LEVEL).count();
        let allowed = if is_surface { expected.color.len() * 4 / 500 } else { 0 };
        assert!(far <= allowed, "{lighting} {rest}: {apart}, {far} farther than a level");
        let dark = document(lighting).replace("shadows", "# shadows");
        let unshadowed = draw(&mut gpu(&Ceiling::default()), &stage(&volume, &dark, [40, 34]));
        assert!(difference(&unshadowed, &found) > 0.05, "{lighting} {rest}: no shadow");
    }
}

/// A light volume is kept, but never longer than what it was made of.
#[test]
fn light_volumes_are_those_of_the_stage() {
    let volume = sample("wavelet", [24, 20, 28], VoxelType::F32);
    let document = |light: &str, opacity: f64, resolution: f64, rest: &str| {
        format!(
            "shading = true\nunit_distance = 1.0\n[volumes.transfer_function]\ncolors = [[80, \"#3050e0\"]]\n\
             opacities = [[90, 0], [270, {opacity}]]\n{rest}\
             [lighting]\nshadows.volume.resolution = {resolution}\nlights = [{{ kind.{light} }}]\n"
        )
    };
    let side = "directional.direction = [0.8, 0.4, -0.5]";
    let clip = "[[clips]]\nplane = { point = [1, 0, 0], normal = [0.6, 0.2, -0.7] }\n";
    let documents = [
        document(side, 0.5, 0.5, ""),
        document(side, 0.5, 0.5, "[camera.view.orbit]\nazimuth = 70.0\n"),
        document("directional.direction = [-0.8, 0.4, -0.5]", 0.5, 0.5, ""),
        document("directional.direction = [-0.8, 0.4, -0.5]", 0.2, 0.5, ""),
        document("directional.direction = [-0.8, 0.4, -0.5]", 0.2, 0.25, ""),
        document("directional.direction = [-0.8, 0.4, -0.5]", 0.2, 0.25, clip),
        document(side, 0.5, 0.5, ""),
    ];
    let mut kept = gpu(&Ceiling::default());
    let frames: Vec<_> = documents.iter().map(|text| draw(&mut kept, &stage(&volume, text, [40, 34]))).collect();
    for (frame, text) in frames.iter().zip(&documents) {
        let fresh = draw(&mut gpu(&Ceiling::default()), &stage(&volume, text, [40, 34]));
        assert!(frame.color == fresh.color, "{text}: {}", difference(frame, &fresh));
    }
    for pair in frames.windows(2) {
        assert!(difference(&pair[0], &pair[1]) > 2.0 * LEVEL);
    }
    // Voxels that change are seen by light, too.
    let cube = |value: f32| {
        let dims = [16; 3];
        let is_in = |i: usize| [i % 16, i / 16 % 16, i / 256].iter().all(|v| (5..11).contains(v));
        let voxels: Vec<f32> = (0..4096).map(|i| if is_in(i) { value } else { 100.0 }).collect();
        Arc::new(Volume::new(Grid::with_spacing(dims, [1.0; 3], [0.0; 3]).unwrap(), voxels).unwrap())
    };
    let (thin, dense) = (cube(120.0), cube(260.0));
    let text = document(side, 0.5, 0.5, "");
    draw(&mut kept, &stage(&thin, &text, [40, 34]));
    kept.update(&dense, Part { low: [5; 3], high: [11; 3] }).unwrap();
    let stage = stage(&dense, &text, [40, 34]);
    assert!(draw(&mut kept, &stage).color == draw(&mut gpu(&Ceiling::default()), &stage).color);
}

#[test]
fn a_light_volume_needs_lights_outside_and_room() {
    let volume = sample("wavelet", [24, 20, 28], VoxelType::F32);
    let draw = |lighting: &str| {
        let text = format!("shading = true\n[lighting]\n{lighting}\n");
        gpu(&side(40)).render(&stage(&volume, &text, [40, 34]), &Control::default())
    };
    let inside = "shadows.volume = {}\nlights = [{ kind.point = { position = [1, 2, 3], falloff = \"none\" } }]";
    assert_eq!(draw(inside).unwrap_err(), GpuError::Light(LightError::Inside { light: 0 }));
    // Where there is less room, points are further apart; two for each light are the fewest.
    let light = "{ kind.directional.direction = [1, 0, 0] }";
    let large = draw(&format!("shadows.volume.resolution = 2.0\nlights = [{light}]")).unwrap();
    let is_told =
        |warning: &RenderWarning| matches!(warning, RenderWarning::Memory { reason } if reason.contains("not 2"));
    assert!(large.warnings.iter().any(is_told), "{:?}", large.warnings);
    let many = draw(&format!("shadows.volume = {{}}\nlights = [{}]", [light; 21].join(", "))).unwrap_err();
    assert!(matches!(&many, GpuError::Budget { advice, .. } if advice.contains("resolution")), "{many}");
}

#[test]
fn a_volume_in_bricks_has_no_shadow_rays() {
    let volume = sample("wavelet", [24, 20, 28], VoxelType::F32);
    let lit = stage(&volume, "shading = true\n[lighting.shadows]\nrays = {}\n", [40, 34]);
    let refused = gpu(&side(16)).render(&lit, &Control::default()).unwrap_err();
    assert!(matches!(&refused, GpuError::Budget { advice, .. } if advice.contains("cpu")), "{refused}");
}
