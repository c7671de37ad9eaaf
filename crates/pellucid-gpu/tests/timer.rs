//! What the device's own clock says of a frame.

mod common;

use common::{device, draw, gpu, sample, side, stage};
use pellucid_field::VoxelType;
use pellucid_gpu::{Ceiling, GpuRenderer, Passes};

const SIZE: [u32; 2] = [64, 48];
const DIMS: [usize; 3] = [40, 38, 42];

/// However the work is handed out, the passes' own time is told, and is most of what drawing takes where
/// there is much to do: on the software driver, which has next to nothing to wait for.
#[test]
fn the_time_of_every_pass_is_told() {
    let volume = sample("marschner-lobb", DIMS, VoxelType::F32);
    let document = "shading = true\n[quality]\nstep = 0.1\nsupersampling = 2\nearly_termination = 1.0";
    let kernels = "shading = true\n[quality]\ngradient = \"sobel\"";
    let few = Ceiling { memory: Some(500 << 10), ..side(16) };
    let wavefront = GpuRenderer::on(device(&Ceiling::default())).with_passes(Passes::Wavefront);
    for (name, mut gpu, document) in [
        ("single", gpu(&Ceiling::default()), document),
        ("wavefront", wavefront, document),
        ("kernels", gpu(&Ceiling::default()), kernels),
        ("bricks", gpu(&side(32)), document),
        ("few bricks", gpu(&few), document),
    ] {
        let stage = stage(&volume, document, SIZE);
        let plan = gpu.plan(&stage).unwrap();
        assert_eq!(plan.loaded < plan.bricks, name == "few bricks", "{name}: {plan}");
        let has_clock = gpu.device().capabilities.optional().any(|(name, there)| name.contains("TIMESTAMP") && there);
        // The first frame makes the pipelines.
        draw(&mut gpu, &stage);
        let statistics = draw(&mut gpu, &stage).statistics;
        let Some(seconds) = statistics.device_seconds else {
            assert!(!has_clock, "{name}: the device has a clock");
            continue;
        };
        let share = seconds / statistics.render_seconds;
        println!("{name}: {plan}: {:.1} ms, {share:.2} of the drawing", seconds * 1e3);
        assert!(share <= 1.0, "{name}: {share} of the time that drawing took");
        assert!(share > 0.2 || !gpu.device().adapter.is_software(), "{name}: {share} of the time that drawing took");
    }
}
