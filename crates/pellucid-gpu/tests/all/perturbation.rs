//! Noise does to volumes what it does on the CPU backend, whose formulas are held to closed forms.

use crate::common::{LEVEL, difference, draw, gpu, sample, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::VoxelType;
use pellucid_gpu::Ceiling;
use pellucid_scene::Control;

#[test]
fn noise_does_what_it_does_on_the_cpu() {
    let volume = sample("ball", [20, 24, 22], VoxelType::F32);
    let moved = "[volumes.perturbation]\nseed = 3\n[volumes.perturbation.displacement]\namplitude = 0.15\n\
         octaves = [{ frequency = 0.3, offset = [0.1, 0.7, 0.3] }, { frequency = 0.8, weight = -0.5 }]\n";
    let furry =
        "[volumes.perturbation.displacement]\namplitude = 0.2\noctaves = [{ frequency = 0.4 }]\nbetween = [0.9, 0.4]\n";
    let varied = "[volumes.perturbation.optics]\nopacity = 0.8\ncolor = 0.7\ntransport = 0.6\noctaves = [{ frequency = 0.2, weight = 2 }]\n";
    let lights = "lights = [{ kind.directional.direction = [0.8, 0.4, -0.5] }]\n";
    let techniques = [
        format!("[lighting]\n{lights}"),
        format!("[quality]\nclassification = \"pre\"\n[lighting]\n{lights}"),
        format!("[quality]\nclassification = \"pre_integrated\"\n[lighting]\nshadows.rays = {{}}\n{lights}"),
        format!("[quality]\nfilter = {{ bc = {{ b = 0.3, c = 0.3 }} }}\n[lighting]\nshadows.rays = {{}}\n{lights}"),
        "[technique.ray_cast]\nmode = \"maximum\"\n".to_owned(),
        "[[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = 0.5\n".to_owned(),
        format!("[technique.half_angle]\nresolution = 48\n[lighting]\n{lights}"),
    ];
    for noise in [moved, furry, varied, &format!("{moved}{varied}")] {
        for technique in &techniques {
            let document = |noise: &str| {
                format!(
                    "shading = true\nunit_distance = 0.1\n[volumes.transfer_function]\n\
                     colors = [[0, \"#3050e0\"], [1, \"#e0a020\"]]\nopacities = [[0.3, 0], [0.7, 0.4]]\n\
                     [volumes.scattering]\ntransport = [[0, \"#f0c080\"]]\n{noise}{technique}"
                )
            };
            let noisy = stage(&volume, &document(noise), [40, 36]);
            let expected = CpuRenderer::default().render(&noisy, &Control::default()).unwrap();
            let mut renderer = gpu(&Ceiling::default());
            let found = draw(&mut renderer, &noisy);
            let pairs = expected.color.as_flattened().iter().zip(found.color.as_flattened());
            let far = pairs.filter(|(a, b)| (*a - *b).abs() > LEVEL).count();
            let apart = difference(&expected, &found);
            // Where the ball is flat, a slope that is nothing but rounding has a direction: a pixel may be lit by it.
            assert!(far <= 4, "{noise}{technique}: {far} farther than a level, {apart}");
            let plain = draw(&mut renderer, &stage(&volume, &document(""), [40, 36]));
            let is_data = technique.contains("mode") && noise == varied;
            assert!(is_data || difference(&plain, &found) > 0.02, "{noise}{technique} changes nothing");
        }
    }
}
