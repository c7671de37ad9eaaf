//! Slices through several volumes: what rays see of them, once both are fine; `layers.rs` has their closed form.

use std::sync::Arc;

use crate::common::{difference, draw, gpu};
use crate::layers::{BALL, WAVES, by_cpu, layered, solid, turned};
use pellucid_field::Volume;
use pellucid_gpu::{Ceiling, GpuError, GpuRenderer};
use pellucid_scene::{Control, Frame, Stage};

const HAZE: &str =
    "unit_distance = 1\n[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0.02]]";
const NEAR: &str =
    "[camera]\nprojection.perspective.vertical_fov = 60\nview.orbit = { azimuth = 30, elevation = 20 }\n";
const PARALLEL: &str = "[camera]\nprojection.orthographic = {}\nview.orbit = { azimuth = -60, elevation = -35 }\n";

/// Three volumes, of which the third is a box that stands apart but for a corner.
fn three() -> [(Arc<Volume>, &'static str); 3] {
    let [ball, waves] = turned();
    [(ball, BALL), (waves, WAVES), (solid([4, 5, 6], [-1.0, -9.0, -2.0], [1.7, 2.3, 1.1]), HAZE)]
}

/// Keys of the document, and its tables. Two volumes are fused, or three drawn.
fn stage(keys: &str, technique: &str, quality: &str, camera: &str) -> Stage {
    let rest = format!("{keys}|[quality]\n{quality}\n{technique}\n{camera}");
    layered(&three()[..if keys.contains("fused") { 2 } else { 3 }], &rest, [36, 32])
}

/// Mean difference of colour and opacity.
fn mean(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.color.as_flattened().iter().zip(b.color.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / a.color.as_flattened().len() as f32
}

#[test]
fn slices_show_what_fine_rays_show() {
    let mut renderer = gpu(&Ceiling::default());
    for (keys, quality) in [
        ("", ""),
        ("", "classification = \"pre\""),
        ("", "classification = \"pre_integrated\""),
        ("", "filter = { bc = { b = 0.3, c = 0.3 } }"),
        ("overlap = \"maximum\"", ""),
        ("overlap = \"priority\"", ""),
        ("overlap.fused = { color = 1, opacity = 0 }", ""),
    ] {
        for camera in [NEAR, PARALLEL] {
            let exact = by_cpu(&stage(keys, "", &format!("step = 0.05\nearly_termination = 1\n{quality}"), camera));
            for geometry in ["view_aligned", "shells"] {
                let technique = format!("[technique.slicing]\ngeometry = \"{geometry}\"\n");
                let [coarse, fine] = ["0.4", "0.1"].map(|step| {
                    let quality = format!("step = {step}\nearly_termination = 1\n{quality}");
                    let frame = draw(&mut renderer, &stage(keys, &technique, &quality, camera));
                    let rays = by_cpu(&stage(keys, "", &quality, camera));
                    let (own, other) = (mean(&frame, &exact), mean(&rays, &exact));
                    assert!(
                        own < 1.3 * other + 2e-4,
                        "{keys} {quality} {geometry} {step}: off by {own}, rays by {other}"
                    );
                    own
                });
                assert!(fine < 0.6 * coarse + 1e-4, "{keys} {quality} {geometry} {camera}: {coarse} becomes {fine}");
            }
            assert!(exact.color.iter().filter(|pixel| pixel[3] > 0.1).count() > 100, "{keys} {quality}");
        }
    }
}

/// Values are projected volume by volume, along the axes of each if slices lie so, and merged as the ray caster does it.
#[test]
fn projections_by_slices_are_those_of_rays() {
    let mut renderer = gpu(&Ceiling::default());
    let slab = "{ slice = { normal = [0.3, 0.2, 1], thickness = 4, combine = \"average\" } }";
    let mut seen = 0;
    for mode in ["\"maximum\"", "\"average\"", "\"additive\"", "\"x_ray\"", slab] {
        for keys in ["", "overlap = \"priority\"", "overlap.fused = { color = 1, opacity = 0 }"] {
            for geometry in ["view_aligned", "object_aligned", "multi_texture", "shells"] {
                let rays = format!("[technique.ray_cast]\nmode = {mode}\n");
                let exact = by_cpu(&stage(keys, &rays, "step = 0.1", PARALLEL));
                let slices = format!("[technique.slicing]\nmode = {mode}\ngeometry = \"{geometry}\"\n");
                let found = draw(&mut renderer, &stage(keys, &slices, "step = 0.1\nsupersampling = 1", PARALLEL));
                let apart = mean(&found, &exact);
                // Planes of voxels are no closer than voxels, and light is added without end.
                let most = if geometry == "object_aligned" { 0.05 } else { 0.005 };
                assert!(apart < most, "{mode} {keys} {geometry}: {apart}");
                let hit = |frame: &Frame| frame.statistics.rays_hit;
                assert_eq!(hit(&found), hit(&exact), "{mode} {keys} {geometry}");
                seen += exact.color.iter().filter(|pixel| pixel[3] > 0.05).count();
            }
        }
    }
    assert!(seen > 60 * 100, "60 cases show {seen} pixels");
}

/// Isosurfaces of the ball and the waves, of so much opacity each.
fn surfaces(opacities: [f64; 2]) -> String {
    let [first, second] = opacities;
    format!(
        "mode.isosurface.isovalues = [{{ value = 0.5, color = \"#e0c080\", opacity = {first}, volume = 0 }}, \
         {{ value = 0.7, opacity = 0.4, volume = 0 }}, {{ value = 190, opacity = {second}, volume = 1 }}, \
         {{ value = 120, opacity = 0.3, volume = 1 }}]\n"
    )
}

/// Surfaces are found where rays find them, whatever slices lie between, and hide each other as they lie.
#[test]
fn surfaces_in_slices_are_those_of_rays() {
    let mut renderer = gpu(&Ceiling::default());
    let [ball, waves] = turned();
    let lights = "[lighting]\nlights = [{ kind.directional.direction = [0.8, 0.4, -0.5] }]\n";
    let mut most = 0.0f32;
    for (opacities, own, quality) in [
        ([0.3, 0.4], "", "step = 0.7\nempty_space_skipping = false"),
        ([1.0, 1.0], "", ""),
        ([0.3, 0.4], "shading = true\n", "supersampling = 2\njitter.blue_noise.seed = 3"),
        ([0.5, 0.4], "", "filter = { bc = { b = 0.3, c = 0.3 } }"),
        ([0.5, 0.4], "", "filter = \"nearest\""),
    ] {
        let modes = surfaces(opacities);
        let (first, second) = (format!("{own}{BALL}"), format!("{own}{WAVES}"));
        let layers = [(ball.clone(), &*first), (waves.clone(), &*second)];
        let stage = |technique: &str, camera: &str| {
            let quality = format!("[quality]\nearly_termination = 1\n{quality}");
            layered(&layers, &format!("{quality}\n[technique.{technique}\n{modes}{lights}{camera}"), [36, 32])
        };
        for camera in [NEAR, PARALLEL] {
            let (rays, exact) = (draw(&mut renderer, &stage("ray_cast]", camera)), by_cpu(&stage("ray_cast]", camera)));
            for more in [
                "slicing]\ngeometry = \"shells\"",
                "slicing]\norder = \"back_to_front\"\nsamples = 5",
                "slicing]\ntarget = \"f16\"\nsamples = 3",
            ] {
                let found = draw(&mut renderer, &stage(more, camera));
                let rounding = if more.contains("f16") { 4e-3 } else { 1e-5 };
                let apart = difference(&found, &rays);
                assert!(apart < rounding, "{own} {quality} {more}: {apart} from rays");
                let off = mean(&found, &exact);
                assert!(off < 2e-3, "{own} {quality} {more}: {off} from the CPU's rays");
                most = most.max(off);
                assert_eq!(found.statistics.rays_hit, rays.statistics.rays_hit, "{more}");
            }
            assert!(rays.color.iter().filter(|pixel| pixel[3] > 0.3).count() > 100, "{quality} shows little");
        }
    }
    assert!(most > 0.0);
}

/// What fragments composite is what blending composites, whichever way.
#[test]
fn slabs_are_put_together_in_any_way() {
    let mut renderer = gpu(&Ceiling::default());
    for (geometry, camera) in [("view_aligned", NEAR), ("shells", NEAR), ("view_aligned", PARALLEL)] {
        let mut of = |more: &str, quality: &str| {
            let technique = format!("[technique.slicing]\ngeometry = \"{geometry}\"\n{more}");
            draw(&mut renderer, &stage("", &technique, quality, camera))
        };
        const ALL: &str = "early_termination = 1";
        let first = of("", ALL);
        assert!(difference(&of("order = \"back_to_front\"", ALL), &first) < 1e-5, "{geometry} back to front");
        // In half precision fragments composite as many samples as are asked for, and blending all else.
        let [one, three, many] = [1, 3, 16].map(|count| of(&format!("target = \"f16\"\nsamples = {count}"), ALL));
        for coarse in [&one, &three, &many] {
            assert!(difference(coarse, &first) < 0.01, "{geometry} in half precision");
        }
        assert!(one.color != three.color && three.color != many.color, "{geometry}: samples change nothing");
        let unskipped = of("", "early_termination = 1\nempty_space_skipping = false");
        assert_eq!(unskipped.color, first.color, "{geometry}: what is skipped can be seen");
        assert!(unskipped.statistics.samples > first.statistics.samples);
        assert_eq!(unskipped.statistics.rays_hit, first.statistics.rays_hit);
        let early = of("termination_interval = 2", "early_termination = 0.9");
        assert!(difference(&early, &first) < 0.11, "{geometry}: {}", difference(&early, &first));
    }
}

/// Rays at an angle cross more of a slab than those that the opacity is corrected for.
#[test]
fn correction_is_that_of_one_volume() {
    let camera = "[camera]\nprojection.perspective.vertical_fov = 60\nview.orbit = { azimuth = 0, elevation = 0 }\n";
    let boxes = [([0.0; 3], HAZE), ([3.0, 2.0, 1.0], HAZE)].map(|(corner, own)| (solid([9; 3], corner, [1.0; 3]), own));
    let mut renderer = gpu(&Ceiling::default());
    let mut depths = |volumes: &[(Arc<Volume>, &str)], correction: &str| {
        let rest =
            format!("[quality]\nearly_termination = 1\n[technique.slicing]\ncorrection = \"{correction}\"\n{camera}");
        let frame = draw(&mut renderer, &layered(volumes, &rest, [24, 24]));
        frame.color.iter().map(|pixel| -(-pixel[3]).ln_1p()).collect::<Vec<f32>>()
    };
    let exact = depths(&boxes, "per_sample");
    for correction in ["per_frame", "off"] {
        let ratios: Vec<f32> = depths(&boxes, correction).iter().zip(&exact).map(|(own, exact)| own / exact).collect();
        let tan = (30f32).to_radians().tan() / 12.0;
        for (k, ratio) in ratios.iter().enumerate().filter(|(_, ratio)| ratio.is_finite()) {
            let [x, y] = [k % 24, k / 24].map(|place| (place as f32 - 11.5) * tan);
            let cosine = 1.0 / (1.0 + x * x + y * y).sqrt();
            assert!((ratio - cosine).abs() < 2e-3, "{correction}: {ratio} at {k}, exact {cosine}");
        }
        assert!(ratios.iter().filter(|ratio| ratio.is_finite()).count() > 100);
    }
}

#[test]
fn the_order_of_the_list_changes_no_bit_of_slices() {
    let mut renderer = gpu(&Ceiling::default());
    let surfaces = "mode.isosurface.isovalues = [{ value = 0.6, opacity = 0.4 }, { value = 130, opacity = 0.3 }]";
    let shells = "geometry = \"shells\"\norder = \"back_to_front\"";
    for technique in ["", shells, "mode = \"additive\"", "mode = \"maximum\"", surfaces] {
        let rest = format!("[technique.slicing]\n{technique}\n{NEAR}");
        let bits = |renderer: &mut GpuRenderer, layers: &[(Arc<Volume>, &str)]| {
            let frame = draw(renderer, &layered(layers, &rest, [24, 20]));
            frame.color.as_flattened().iter().map(|number| number.to_bits()).collect::<Vec<_>>()
        };
        let [a, b, c] = three();
        let first = bits(&mut renderer, &[a.clone(), b.clone(), c.clone()]);
        assert!(bits(&mut renderer, &[c, a, b]) == first, "{technique}");
    }
}

#[test]
fn more_volumes_than_slices_take_are_counted() {
    let layers: Vec<_> = (0..9).map(|k| (solid([3; 3], [f64::from(k), 0.0, 0.0], [1.0; 3]), HAZE)).collect();
    let mut renderer = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let sliced = |layers: &[_]| layered(layers, "[technique.slicing]\n", [8, 8]);
    let refused = renderer.render(&sliced(&layers), &Control::default()).unwrap_err();
    let GpuError::Volumes { found: 9, most } = refused else { panic!("{refused}") };
    assert!((1..9).contains(&most), "{refused}");
    draw(&mut renderer, &sliced(&layers[..most]));
}
