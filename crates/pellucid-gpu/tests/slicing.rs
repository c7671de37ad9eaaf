//! Slices show what is on their planes: against a restatement in double precision, against the ray caster where it
//! takes the same samples, and against each other (chapter 3).

mod common;
#[path = "common/planes.rs"]
mod planes;

use common::{LEVEL, device, difference, draw, gpu, sample, side, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::VoxelType;
use pellucid_gpu::{Ceiling, GpuRenderer, Interpolation};
use pellucid_scene::{Control, Frame, Stage};
use planes::Planes;

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
const SURFACES: &str = "{ isosurface = { isovalues = [{ value = 0.4, opacity = 0.5 }, { value = 0.7 }] } }";

#[test]
fn slices_show_what_rays_show_where_their_samples_are_the_same() {
    let mut gpu = gpu(&Ceiling::default());
    for (look, mode) in [
        (LIT, "\"composite\""),
        (PRE, "\"composite\""),
        (PRE_INTEGRATED, "\"composite\""),
        (LIT, SURFACES),
        (LIT, "{ slice = { normal = [0.3, 1, -0.4], thickness = 0.6, combine = \"minimum\" } }"),
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
    for view in [PARALLEL, PERSPECTIVE, INSIDE] {
        for geometry in GEOMETRIES {
            for classification in ["post", "pre_integrated"] {
                let base = format!("geometry = \"{geometry}\"");
                let more = format!("[quality]\nearly_termination = 1.0\nclassification = \"{classification}\"\n{view}");
                unchanged(&base, &[("samples = 2", 0.01), ("samples = 5", 0.01)], &more);
            }
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
            assert!(some.samples < all.samples * 9 / 10, "{some:?} of {all:?}");
            assert_eq!(some.samples + some.samples_skipped, all.samples + all.samples_skipped);
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
