//! Slices show what is on their planes: against a restatement in double precision, against the ray caster where it
//! takes the same samples, and against each other (chapter 3).

use std::sync::Arc;

use crate::common::{LEVEL, device, difference, draw, gpu, sample, side, stage};
use crate::planes::Planes;
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, VoxelType};
use pellucid_gpu::{Ceiling, GpuRenderer, Interpolation, Part};
use pellucid_scene::{Control, Frame, Stage};

const SIZE: [u32; 2] = [56, 48];
const DIMS: [usize; 3] = [30, 26, 34];
const GEOMETRIES: [&str; 4] = ["view_aligned", "object_aligned", "multi_texture", "shells"];
const MODES: [&str; 6] = ["composite", "maximum", "minimum", "average", "additive", "x_ray"];

const PARALLEL: &str =
    "[camera]\nprojection.orthographic = { height = 2.9 }\nview.orbit = { azimuth = 35, elevation = -25 }";
const PERSPECTIVE: &str =
    "[camera]\nprojection.perspective.vertical_fov = 40\nview.orbit = { azimuth = -130, elevation = 30 }";
const INSIDE: &str = "[camera]\nprojection.perspective.vertical_fov = 50\n\
    view.look_at = { position = [0.11, -0.43, 0.35], target = [0.4, 0.9, 0.2] }";
const CLIPPED: &str = "[[clips]]\nplane = { point = [0.1, 0, 0], normal = [0.3, 1, -0.4] }\n\
    [camera]\nview.orbit = { azimuth = 70, elevation = 10 }";

/// A smooth ramp, so that tables follow the transfer function exactly.
const LOOK: &str = "shading = false\n\
    transfer_function = { colors = [{ value = 0.0, color = [1, 0, 0] }, { value = 1.0, color = [0, 0.5, 1] }], \
    opacities = [{ value = 0.2, opacity = 0.0 }, { value = 1.0, opacity = 0.3 }] }";

fn sliced(technique: &str, more: &str) -> Stage {
    let volume = sample("marschner-lobb", DIMS, VoxelType::F32);
    stage(&volume, &format!("{LOOK}\n[technique.slicing]\n{technique}\n{more}"), SIZE)
}

/// How far a picture is from its definition, in levels of 8 bits, and how many pixels have other samples.
fn apart(frame: &Frame, stage: &Stage) -> (f64, usize) {
    let planes = Planes::new(stage);
    let (mut most, mut counts, mut compared) = (0.0f64, 0, 0);
    for (place, color) in frame.color.iter().enumerate() {
        let Some(seen) = planes.pixel(place % frame.width, place / frame.width) else { continue };
        compared += 1;
        for (found, expected) in color.iter().zip(seen.color) {
            most = most.max((f64::from(*found) - expected).abs());
        }
        counts += usize::from(frame.samples[place] != seen.samples);
    }
    assert!(compared * 100 > frame.color.len() * 95, "{compared} of {} pixels", frame.color.len());
    (most * 255.0, counts)
}

#[test]
fn every_mode_and_geometry_shows_what_is_on_its_planes() {
    let mut gpu = gpu(&Ceiling::default());
    let mut failures = Vec::new();
    for view in [PARALLEL, PERSPECTIVE, INSIDE, CLIPPED] {
        for geometry in GEOMETRIES {
            for mode in MODES {
                let stage = sliced(
                    &format!("geometry = \"{geometry}\"\nmode = \"{mode}\""),
                    &format!("[quality]\nearly_termination = 1.0\nempty_space_skipping = false\n{view}"),
                );
                let (levels, counts) = apart(&draw(&mut gpu, &stage), &stage);
                if levels > 1.0 || counts > 0 {
                    failures.push(format!("{geometry} {mode} {view:.60}: {levels:.2} levels, {counts} counts"));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A stage whose ray caster and slices take the same samples: parallel rays at a right angle to a face, and a whole
/// number of steps through the volume.
fn face_on(technique: &str, look: &str) -> Stage {
    let volume = sample("marschner-lobb", DIMS, VoxelType::F32);
    let more = "[camera]\nprojection.orthographic = { height = 2.2 }\nview.orbit = { azimuth = 0, elevation = 0 }";
    stage(&volume, &format!("{look}\n{technique}\n{more}"), SIZE)
}

const LIT: &str = "preset = \"simulation\"\nshading = true\n[quality]\nearly_termination = 1.0";
const PRE_INTEGRATED: &str = "preset = \"simulation\"\nshading = true\n\
    [quality]\nclassification = \"pre_integrated\"\nstep = 1.0\nearly_termination = 1.0";
const PRE: &str = "preset = \"simulation\"\n[quality]\nclassification = \"pre\"\nearly_termination = 1.0";
const SURFACES: &str =
    "{ isosurface = { isovalues = [{ value = 0.4, opacity = 0.5 }, { value = 0.7 }], search = \"sampled\" } }";

#[test]
fn slices_show_what_rays_show_where_their_samples_are_the_same() {
    let mut gpu = gpu(&Ceiling::default());
    for (look, mode) in [
        (LIT, "\"composite\""),
        (PRE, "\"composite\""),
        (PRE_INTEGRATED, "\"composite\""),
        (LIT, SURFACES),
        (LIT, "{ slice = { normal = [0, 1, 0], thickness = 0.6060606, combine = \"minimum\" } }"),
        (LIT, "\"maximum\""),
        (LIT, "\"x_ray\""),
    ] {
        let rays = face_on(&format!("[technique.ray_cast]\nmode = {mode}"), look);
        let expected = CpuRenderer::new().render(&rays, &Control::default()).unwrap();
        for geometry in ["view_aligned", "multi_texture", "shells"] {
            for order in ["front_to_back", "back_to_front"] {
                let technique =
                    format!("[technique.slicing]\nmode = {mode}\ngeometry = \"{geometry}\"\norder = \"{order}\"");
                let found = draw(&mut gpu, &face_on(&technique, look));
                let apart = difference(&found, &expected) / LEVEL;
                assert!(apart <= 1.0, "{geometry}, {order}, {mode}, {look}: {apart} levels");
                assert!(found.statistics.samples > 1000 && found.statistics.samples_visible > 100);
            }
        }
    }
}

/// Pictures that settings must not change, by how many levels at most.
fn unchanged(base: &str, others: &[(&str, f32)], more: &str) {
    let mut gpu = gpu(&Ceiling::default());
    let expected = draw(&mut gpu, &sliced(base, more));
    for (other, most) in others {
        let found = draw(&mut gpu, &sliced(&format!("{base}\n{other}"), more));
        let apart = difference(&found, &expected) / LEVEL;
        assert!(apart <= *most, "{base} {other} {more}: {apart} levels");
    }
}

#[test]
fn who_cuts_in_which_order_does_not_matter() {
    for view in [PARALLEL, PERSPECTIVE, INSIDE, CLIPPED] {
        for geometry in GEOMETRIES {
            let exact = format!("[quality]\nearly_termination = 1.0\n{view}");
            let others = [
                ("proxy = \"processor\"", 0.0),
                ("order = \"back_to_front\"", 0.01),
                ("order = \"back_to_front\"\ncolors = \"non_associated\"", 0.01),
                ("termination_interval = 0", 0.0),
                ("occlusion_culling = false", 0.0),
            ];
            unchanged(&format!("geometry = \"{geometry}\""), &others, &exact);
        }
    }
}

#[test]
fn several_samples_to_a_slice_make_the_same_picture() {
    for (view, classification) in [(PARALLEL, "pre_integrated"), (PERSPECTIVE, "post"), (INSIDE, "post")] {
        for geometry in GEOMETRIES {
            let base = format!("geometry = \"{geometry}\"");
            let more = format!("[quality]\nearly_termination = 1.0\nclassification = \"{classification}\"\n{view}");
            unchanged(&base, &[("samples = 2", 0.01), ("samples = 5", 0.01)], &more);
        }
    }
}

#[test]
fn blocks_without_opacity_are_not_drawn_and_not_missed() {
    let mut gpu = gpu(&Ceiling::default());
    for geometry in GEOMETRIES {
        for (view, classification) in [(PARALLEL, "post"), (PERSPECTIVE, "pre_integrated"), (INSIDE, "post")] {
            // An opaque shell in an empty volume of several boxes.
            let volume = sample("ball", [70, 50, 60], VoxelType::F32);
            let draw = |gpu: &mut GpuRenderer, skipping: bool| {
                let text = format!(
                    "shading = false\ntransfer_function = {{ colors = [{{ value = 0.0, color = [1, 0.5, 0] }}], \
                    opacities = [{{ value = 0.40, opacity = 0.0 }}, {{ value = 0.45, opacity = 0.5 }}, \
                    {{ value = 0.5, opacity = 0.0 }}] }}\n\
                    [technique.slicing]\ngeometry = \"{geometry}\"\ntermination_interval = 0\n\
                    [quality]\nearly_termination = 1.0\nempty_space_skipping = {skipping}\n\
                    classification = \"{classification}\"\n{view}"
                );
                draw(gpu, &stage(&volume, &text, SIZE))
            };
            let [all, some] = [false, true].map(|skipping| draw(&mut gpu, skipping));
            // Boxes are drawn one after the other: what is added in another grouping differs by roundings.
            assert!(difference(&all, &some) < 1e-5, "{geometry} {view}: {}", difference(&all, &some));
            let [all, some] = [all.statistics, some.statistics];
            assert_eq!(all.samples_visible, some.samples_visible);
            assert!(some.samples < all.samples, "{some:?} of {all:?}");
            if classification == "post" {
                // Blocks beside live ones are live for segments.
                assert!(some.samples < all.samples * 7 / 10, "{some:?} of {all:?}");
                assert_eq!(some.samples + some.samples_skipped, all.samples + all.samples_skipped);
            }
        }
    }
}

#[test]
fn what_is_hidden_is_not_drawn() {
    let volume = sample("ball", [96; 3], VoxelType::F32);
    let mut gpu = gpu(&Ceiling::default());
    let mut draw = |slicing: &str| {
        let text = format!(
            "shading = false\ntransfer_function = {{ colors = [{{ value = 0.0, color = [1, 0.5, 0] }}], \
            opacities = [{{ value = 0.25, opacity = 0.0 }}, {{ value = 0.3, opacity = 0.6 }}] }}\n\
            [technique.slicing]\n{slicing}\n[quality]\nearly_termination = 0.95\n{PERSPECTIVE}"
        );
        draw(&mut gpu, &stage(&volume, &text, [96, 96]))
    };
    let all = draw("termination_interval = 0");
    let mut least = all.statistics.samples;
    // The more often it looks, the less it draws.
    for interval in [30, 10, 2] {
        let some = draw(&format!("termination_interval = {interval}"));
        assert!(difference(&all, &some) <= 0.051, "{interval}: {}", difference(&all, &some));
        assert!(some.statistics.samples < least, "{interval}: {:?} after {least}", some.statistics);
        least = some.statistics.samples;
    }
    assert!(least < all.statistics.samples / 2, "{least} of {}", all.statistics.samples);
}

#[test]
fn bricks_and_stacks_show_the_whole() {
    let mut whole = gpu(&Ceiling::default());
    let mut failures = Vec::new();
    for ceiling in [12, 16, 32] {
        let mut bricked = gpu(&side(ceiling));
        for (geometry, mode) in GEOMETRIES.into_iter().zip(["\"composite\"", SURFACES, "\"x_ray\"", "\"minimum\""]) {
            for classification in ["post", "pre_integrated"] {
                let more = format!("[quality]\nclassification = \"{classification}\"\n{PARALLEL}");
                let stage = sliced(&format!("geometry = \"{geometry}\"\nmode = {mode}"), &more);
                let plan = bricked.plan(&stage).unwrap();
                assert!(plan.bricks > 1, "{plan}");
                let apart = difference(&draw(&mut bricked, &stage), &draw(&mut whole, &stage)) / LEVEL;
                if apart > 0.3 {
                    failures.push(format!("{geometry} {mode} {classification}, side {ceiling}: {apart} levels"));
                }
            }
        }
    }
    let stage = sliced("geometry = \"object_aligned\"", PARALLEL);
    assert!(whole.plan(&stage).unwrap().to_string().contains("in 3 stacks of slices"));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn the_sampler_shows_stacks_of_all_axes() {
    let mut exact = gpu(&Ceiling::default());
    let mut fast = GpuRenderer::on(device(&Ceiling::default())).with_interpolation(Interpolation::Hardware);
    for [azimuth, elevation] in [[10, 5], [80, -10], [190, 20], [-95, 5], [20, 80], [40, -75]] {
        for geometry in ["object_aligned", "multi_texture"] {
            let view = format!("[camera]\nview.orbit = {{ azimuth = {azimuth}, elevation = {elevation} }}");
            let stage = sliced(&format!("geometry = \"{geometry}\""), &view);
            let (levels, _) = apart(&draw(&mut exact, &stage), &stage);
            assert!(levels <= 1.0, "{geometry} from {azimuth}, {elevation}: {levels} levels");
            // Positions of samplers have 8 bits between voxels.
            let apart = difference(&draw(&mut fast, &stage), &draw(&mut exact, &stage)) / LEVEL;
            assert!(apart <= 2.0, "{geometry} from {azimuth}, {elevation}: {apart} levels");
        }
    }
}

#[test]
fn opacity_follows_the_distance_of_slices_as_asked() {
    let mut gpu = gpu(&Ceiling::default());
    for view in [PARALLEL, PERSPECTIVE] {
        for geometry in GEOMETRIES {
            let mut pictures = Vec::new();
            for correction in ["per_sample", "per_frame", "off"] {
                let more = format!("[quality]\nearly_termination = 1.0\n{view}");
                let stage = sliced(&format!("geometry = \"{geometry}\"\ncorrection = \"{correction}\""), &more);
                let frame = draw(&mut gpu, &stage);
                let (levels, _) = apart(&frame, &stage);
                assert!(levels <= 1.0, "{geometry}, {correction}, {view}: {levels} levels");
                pictures.push(frame);
            }
            // Without correction, planes that are crossed at an angle are too thin.
            let alpha = |frame: &Frame| frame.color.iter().map(|c| c[3]).sum::<f32>();
            let is_thin = geometry == "object_aligned" || geometry == "multi_texture";
            assert_eq!(alpha(&pictures[2]) < 0.97 * alpha(&pictures[0]), is_thin, "{geometry} {view}");
        }
    }
}

#[test]
fn jittered_rays_and_many_of_them_sample_between_slices() {
    let mut gpu = gpu(&Ceiling::default());
    for view in [PARALLEL, PERSPECTIVE] {
        for geometry in GEOMETRIES {
            let base = format!("geometry = \"{geometry}\"");
            let [coarse, culled] = [false, true].map(|skips| {
                let quality = "jitter.blue_noise.seed = 5\nsupersampling = 2\nearly_termination = 1.0";
                let more = format!("[quality]\n{quality}\nempty_space_skipping = {skips}\n{view}");
                draw(&mut gpu, &sliced(&base, &more))
            });
            assert!(difference(&coarse, &culled) < 1e-5);
            let plain = draw(&mut gpu, &sliced(&base, &format!("[quality]\nearly_termination = 1.0\n{view}")));
            // Noise moves samples by half a step: a little everywhere, and nothing is lost.
            let sum = |frame: &Frame| frame.color.iter().map(|c| f64::from(c[3])).sum::<f64>();
            let (noisy, calm) = (sum(&coarse), sum(&plain));
            assert!((noisy / calm - 1.0).abs() < 0.01, "{geometry} {view}: {noisy} for {calm}");
        }
    }
}

/// A medium of one value, a hundred voxels deep; its transfer function has this opacity per voxel.
fn slab(opacity: f64, depth: usize, technique: &str, more: &str) -> Stage {
    let grid = Grid::new([6, depth + 1, 6]).unwrap();
    let volume = Arc::new(Volume::new(grid, vec![100u8; grid.len()]).unwrap());
    let text = format!(
        "shading = false\ntransfer_function = {{ unit_distance = 1.0, colors = [{{ value = 0, color = [1, 1, 1] }}], \
        opacities = [{{ value = 0, opacity = {opacity} }}] }}\n[technique.slicing]\n{technique}\n{more}"
    );
    stage(&volume, &text, [9, 9])
}

#[test]
fn a_slab_has_its_closed_form_from_every_angle() {
    let mut gpu = gpu(&Ceiling::default());
    for geometry in GEOMETRIES {
        for angle in [0.0f64, 20.0, 44.0] {
            let view = format!(
                "[quality]\nearly_termination = 1.0\nstep = 0.7\n[camera]\n\
                projection.orthographic = {{ height = 0.5 }}\nview.orbit = {{ azimuth = {angle}, elevation = 0 }}"
            );
            // As thick as wide, so that rays at an angle go in and out by the large faces.
            let grid = Grid::new([41, 11, 41]).unwrap();
            let volume = Arc::new(Volume::new(grid, vec![100u8; grid.len()]).unwrap());
            let text = format!(
                "shading = false\ntransfer_function = {{ unit_distance = 1.0, colors = [{{ value = 0, \
                color = [1, 1, 1] }}], opacities = [{{ value = 0, opacity = 0.1 }}] }}\n\
                [technique.slicing]\ngeometry = \"{geometry}\"\n{view}"
            );
            let frame = draw(&mut gpu, &stage(&volume, &text, [5, 5]));
            let expected = 1.0 - 0.9f64.powf(10.0 / angle.to_radians().cos());
            let found = f64::from(frame.color[12][3]);
            assert!((found - expected).abs() < 1e-5, "{geometry} at {angle}: {found} for {expected}");
        }
    }
}

/// What blending in few bits loses: the numbers of item 9.5-1.
#[test]
fn coarse_targets_lose_thin_samples() {
    let mut gpu = gpu(&Ceiling::default());
    let mut opacity = |alpha: f64, depth: usize, target: &str, order: &str| {
        let technique = format!("target = \"{target}\"\norder = \"{order}\"");
        let more = "[quality]\nstep = 1.0\nearly_termination = 1.0\n[camera]\n\
            projection.orthographic = { height = 4 }\nview.orbit = { azimuth = 0, elevation = 0 }";
        let frame = draw(&mut gpu, &slab(alpha, depth, &technique, more));
        assert_eq!(frame.samples[40], depth as u32);
        frame.color[40][3]
    };
    for order in ["front_to_back", "back_to_front"] {
        assert!((opacity(0.01, 500, "f32", order) - 0.99343).abs() < 1e-5);
        assert!((opacity(0.001, 2000, "f32", order) - 0.86480).abs() < 1e-5);
        // Rounded to nearest or truncated.
        let eight = opacity(0.01, 500, "u8", order);
        assert!((0.80..=0.84).contains(&eight), "{order}: {eight}");
        assert_eq!(opacity(0.001, 2000, "u8", order), 0.0);
        let half = opacity(0.01, 500, "f16", order);
        assert!((0.95..0.985).contains(&half), "{order}: {half}");
        let stalled = opacity(0.001, 2000, "f16", order);
        assert!((0.45..0.80).contains(&stalled), "{order}: {stalled}");
    }
}

#[test]
fn colours_without_their_opacity_bleed() {
    // Transparent red beside opaque blue: between them associated colours are blue, others are half red (3.2-8).
    let grid = Grid::new([2, 2, 2]).unwrap();
    let values: Vec<f32> = (0..8).map(|k| (k % 2) as f32).collect();
    let volume = Arc::new(Volume::new(grid, values).unwrap());
    let mut gpu = gpu(&Ceiling::default());
    let mut middle = |colors: &str, order: &str| {
        let text = format!(
            "shading = false\ntransfer_function = {{ unit_distance = 1.0, colors = [{{ value = 0.0, color = [1, 0, 0] }}, \
            {{ value = 1.0, color = [0, 0, 1] }}], opacities = [{{ value = 0.0, opacity = 0.0 }}, \
            {{ value = 1.0, opacity = 1.0 }}] }}\n[technique.slicing]\ncolors = \"{colors}\"\norder = \"{order}\"\n\
            [quality]\nclassification = \"pre\"\nstep = 1.0\n[camera]\n\
            projection.orthographic = {{ height = 0.2 }}\nview.orbit = {{ azimuth = 0, elevation = 0 }}"
        );
        draw(&mut gpu, &stage(&volume, &text, [1, 1])).color[0]
    };
    for order in ["front_to_back", "back_to_front"] {
        for (colors, expected) in [("associated", [0.0, 0.0, 0.5, 0.5]), ("non_associated", [0.25, 0.0, 0.25, 0.5])] {
            let found = middle(colors, order);
            let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < 1e-4, "{colors}, {order}: {found:?}");
        }
    }
}

#[test]
fn updates_reach_the_stacks() {
    let before = sample("marschner-lobb", DIMS, VoxelType::F32);
    let grid = *before.grid();
    let part = Part { low: [3, 4, 5], high: [20, 12, 30] };
    let mut values: Vec<f32> = (0..grid.len())
        .map(|k| {
            let [nx, ny, _] = DIMS;
            before.value([k % nx, k / nx % ny, k / nx / ny], 0) as f32
        })
        .collect();
    for z in part.low[2]..part.high[2] {
        for y in part.low[1]..part.high[1] {
            for x in part.low[0]..part.high[0] {
                values[grid.linear_index([x, y, z])] = ((x * 3 + y * 5 + z * 7) % 11) as f32 / 10.0;
            }
        }
    }
    let after = Arc::new(Volume::new(grid, values).unwrap());
    for [azimuth, elevation] in [[0, 0], [90, 0], [0, 90]] {
        let text = format!(
            "{LOOK}\n[technique.slicing]\ngeometry = \"multi_texture\"\n\
            [camera]\nview.orbit = {{ azimuth = {azimuth}, elevation = {elevation} }}"
        );
        let mut updated = gpu(&Ceiling::default());
        draw(&mut updated, &stage(&before, &text, SIZE));
        updated.update(&after, part).unwrap();
        let found = draw(&mut updated, &stage(&after, &text, SIZE));
        assert_eq!(found.color, draw(&mut gpu(&Ceiling::default()), &stage(&after, &text, SIZE)).color);
    }
}

#[test]
fn flat_and_thin_volumes_are_drawn() {
    let mut gpu = gpu(&Ceiling::default());
    for dims in [[40, 1, 30], [1, 1, 40], [1, 37, 2], [2, 2, 2]] {
        let volume = sample("marschner-lobb", dims, VoxelType::U16);
        for geometry in GEOMETRIES {
            for mode in ["composite", "average"] {
                let text =
                    format!("{LOOK}\n[technique.slicing]\ngeometry = \"{geometry}\"\nmode = \"{mode}\"\n{PARALLEL}");
                let frame = draw(&mut gpu, &stage(&volume, &text, SIZE));
                assert!(frame.color.as_flattened().iter().all(|v| v.is_finite()), "{geometry} {dims:?}");
                assert!(frame.statistics.samples > 0, "{geometry} {dims:?}");
            }
        }
    }
}

#[test]
fn rays_along_slices_are_told_of() {
    let mut gpu = gpu(&Ceiling::default());
    let wide = "[camera]\nprojection.perspective.vertical_fov = 120\n\
        view.look_at = { position = [0.1, -0.2, 0.3], target = [0.8, 0.9, 0.5] }";
    for (geometry, told) in [("object_aligned", true), ("view_aligned", false), ("shells", false)] {
        let frame = draw(&mut gpu, &sliced(&format!("geometry = \"{geometry}\""), wide));
        let found = frame.warnings.iter().any(|warning| warning.to_string().contains("view_aligned slices have none"));
        assert_eq!(found, told, "{geometry}: {:?}", frame.warnings);
    }
}
