//! Shadow rays are those of the CPU backend, whose pictures are held to closed forms there.

mod common;

use common::{LEVEL, difference, draw, gpu, sample, side, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::VoxelType;
use pellucid_gpu::{Ceiling, GpuError};
use pellucid_scene::Control;

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

#[test]
fn a_volume_in_bricks_has_no_shadow_rays() {
    let volume = sample("wavelet", [24, 20, 28], VoxelType::F32);
    let lit = stage(&volume, "shading = true\n[lighting.shadows]\nrays = {}\n", [40, 34]);
    let refused = gpu(&side(16)).render(&lit, &Control::default()).unwrap_err();
    assert!(matches!(&refused, GpuError::Budget { advice, .. } if advice.contains("cpu")), "{refused}");
}
