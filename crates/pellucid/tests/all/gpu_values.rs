//! What values become where tables are tempted to be coarse, on the graphics processor: closed forms, and the CPU's
//! pictures.

use std::sync::Arc;

use crate::gpu_common::{LEVEL, difference, draw, gpu, stage};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume};
use pellucid_gpu::Ceiling;
use pellucid_scene::{Control, Stage};

/// Along +y, unlit, over a narrow part of the picture's middle.
fn along_y(volume: &Volume, document: &str) -> Stage {
    let text = format!(
        "shading = false\n{document}\n[camera]\nframe = \"grid\"\nprojection.orthographic.height = 0.001\n\
         view.orbit = {{ azimuth = 0, elevation = 0 }}"
    );
    stage(&Arc::new(volume.clone()), &text, [8, 8])
}

/// Values along y, with one other voxel in a corner.
fn along(dims: [usize; 3], corner: f32, value: impl Fn(usize) -> f32) -> Volume {
    let grid = Grid::new(dims).unwrap();
    let at = |k: usize| if k == 0 { corner } else { value(k / dims[0] % dims[1]) };
    Volume::new(grid, (0..grid.len()).map(at).collect::<Vec<f32>>()).unwrap()
}

fn quality(classification: &str, step: f64) -> String {
    format!("[quality]\nclassification = \"{classification}\"\nstep = {step}\nearly_termination = 1.0")
}

const NARROW: &str = "[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"], [1e6, \"#ffffff\"]]\n\
    opacities = [[0.5, 0], [1.0, 0.5], [1.5, 0]]\nunit_distance = 1.0\n";

#[test]
fn a_peak_of_a_millionth_of_the_range_is_seen() {
    let mut gpu = gpu(&Ceiling::default());
    let volume = along([9, 3, 9], 1e6, |_| 1.0);
    for classification in ["post", "pre", "pre_integrated"] {
        let stage = along_y(&volume, &format!("{NARROW}{}", quality(classification, 0.3)));
        let found = draw(&mut gpu, &stage);
        assert!((found.color[27][3] - 0.75).abs() < 1e-4, "{classification}: {:?}", found.color[27]);
    }
}

#[test]
fn beside_a_peak_there_is_no_matter() {
    let mut gpu = gpu(&Ceiling::default());
    let tf = "[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nunit_distance = 1.0\n\
        opacities = [[0, 0], [30000, 0], [30020, 0.9], [30040, 0], [65535, 0]]\n";
    for constant in [29_990.0, 30_060.0, 30_100.0] {
        for classification in ["post", "pre", "pre_integrated"] {
            let volume = along([9, 40, 9], 65_535.0, |_| constant);
            let found = draw(&mut gpu, &along_y(&volume, &format!("{tf}{}", quality(classification, 0.5))));
            assert_eq!(found.color[27], [0.0; 4], "{classification} of {constant}");
        }
    }
}

#[test]
fn jumps_are_where_they_are_and_ends_of_rays_have_their_own_length() {
    let mut gpu = gpu(&Ceiling::default());
    for (at, classification, step) in
        [(20.3, "post", 0.02), (20.3, "pre_integrated", 0.7), (22.0, "pre_integrated", 1.5)]
    {
        let tf = format!(
            "[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nunit_distance = 1.0\n\
             opacities = [[0, 0], [{at}, 0], [{at}, 0.05], [250, 0.05]]\n"
        );
        let volume = along([9, 41, 9], 250.0, |y| 10.0 + y as f32);
        let found = draw(&mut gpu, &along_y(&volume, &format!("{tf}{}", quality(classification, step))));
        let exact = 1.0 - 0.95f64.powf(50.0 - at);
        let alpha = f64::from(found.color[27][3]);
        assert!((alpha - exact).abs() < 1e-3, "jump at {at}, {classification}: {alpha}, exact {exact}");
    }
    // Extinction 1 a unit over 2 of them, colours from black to white (4.5-1).
    let tf = "[volumes.transfer_function]\ncolors = [[0, \"#000000\"], [2, \"#ffffff\"]]\ncolor_space = \"linear\"\n\
        opacities = [[0, 0.6321205588]]\nunit_distance = 1.0\n";
    for step in [0.37, 1.0, 2.0] {
        let volume = along([9, 3, 9], 0.0, |y| y as f32);
        let found = draw(&mut gpu, &along_y(&volume, &format!("{tf}{}", quality("pre_integrated", step))));
        let exact = (1.0 - 3.0 * (-2.0f64).exp()) / 2.0;
        let red = f64::from(found.color[27][0]);
        assert!((red / exact - 1.0).abs() < 3e-3, "step {step}: {red}, exact {exact}");
    }
}

/// Catmull and Rom's spline beside a step from 0 to 1 is `1 + t/2 - t^2 + t^3/2`, at most 29/27 (a third of a voxel past
/// it); transfer functions show what is beyond 0 and 1, where no voxel is.
#[test]
fn values_beyond_those_of_voxels_are_classified_as_what_they_are() {
    let mut gpu = gpu(&Ceiling::default());
    let volume = along([9, 40, 9], 0.0, |y| if y < 20 { 0.0 } else { 1.0 });
    let above = "opacities = [[1.0, 0], [1.1, 1]]\n";
    let below = "opacities = [[-0.1, 1], [0.0, 0]]\n";
    let optics = |opacities: &str| {
        format!("[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nunit_distance = 1.0\n{opacities}")
    };
    let filter = |text: &str| format!("filter = {{ {text} }}\n");
    let catmull_rom = filter("bc = { b = 0, c = 0.5 }");
    for (opacities, mode) in [(above, "maximum"), (below, "minimum")] {
        let document =
            format!("{}[technique.ray_cast]\nmode = \"{mode}\"\n[quality]\n{catmull_rom}", optics(opacities));
        let alpha = draw(&mut gpu, &along_y(&volume, &document)).color[27][3];
        assert!((alpha - 20.0 / 27.0).abs() < 1e-3, "{mode}: {alpha}");
    }
    let (spline, lanczos) =
        (filter("b_spline = { prefilter = true }"), filter("sinc = { window = \"lanczos\", half_width = 3 }"));
    for (filter, classification) in
        [(&catmull_rom, "post"), (&catmull_rom, "pre_integrated"), (&spline, "post"), (&lanczos, "post")]
    {
        for opacities in [above, below] {
            let document = format!("{}{}\n{filter}", optics(opacities), quality(classification, 0.2));
            let stage = along_y(&volume, &document);
            let found = draw(&mut gpu, &stage);
            let expected = CpuRenderer::new().render(&stage, &Control::default()).unwrap();
            assert!(
                found.color[27][3] > 0.02,
                "{filter}{opacities}{classification}: nothing beyond the voxels is seen"
            );
            let apart = difference(&found, &expected);
            assert!(apart <= LEVEL, "{filter}{opacities}{classification}: {:.2} levels apart", apart / LEVEL);
        }
    }
}

/// Everything that looks values up, with nodes at control points: the CPU's pictures.
#[test]
fn uneven_nodes_look_as_on_the_processor() {
    let mut gpu = gpu(&Ceiling::default());
    let grid = Grid::new([20, 21, 19]).unwrap();
    let value = |k: usize| {
        let [x, y, z] = [k % 20, k / 20 % 21, k / 420].map(|i| i as f32);
        50.0 + 45.0 * (0.5 * x + 0.2 * y).sin() * (0.4 * z - 0.3 * y).cos() + if k == 0 { 1e5 } else { 0.0 }
    };
    let volume = Arc::new(Volume::new(grid, (0..grid.len()).map(value).collect::<Vec<f32>>()).unwrap());
    let tf = "[volumes.transfer_function]\ncolors = [[0, \"#203060\"], [50, \"#ff8040\"], [80, \"#ffffff\"]]\nunit_distance = 1.0\n\
        opacities = [[30, 0], [40, 0.3], [50, 0], [70, 0.0], [90, 0.6], [1e5, 0.7]]\n";
    let ways = [
        ("post", quality("post", 0.5)),
        ("adaptive", format!("{}\nadaptive_tolerance = 0.01", quality("post", 0.5))),
        ("pre", quality("pre", 0.5)),
        ("pre-integrated", quality("pre_integrated", 1.0)),
        ("maximum", "[technique.ray_cast]\nmode = \"maximum\"".to_owned()),
        ("average", "[technique.ray_cast]\nmode = \"average\"".to_owned()),
        ("x-ray", "[technique.ray_cast]\nmode = \"x_ray\"".to_owned()),
        ("half-angle", "[technique.half_angle]".to_owned()),
    ];
    for (name, after) in ways {
        let stage = stage(&volume, &format!("shading = false\n{tf}{after}"), [40, 36]);
        let (found, expected) =
            (draw(&mut gpu, &stage), CpuRenderer::new().render(&stage, &Control::default()).unwrap());
        let apart = difference(&found, &expected);
        assert!(apart <= 2.0 * LEVEL, "{name}: {:.2} levels apart", apart / LEVEL);
        assert!(found.statistics.samples_visible > 0, "{name}: nothing is seen");
    }
}
