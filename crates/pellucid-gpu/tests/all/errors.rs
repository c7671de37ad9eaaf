//! Whatever goes wrong is a typed error, and a new renderer works after it.

use crate::common::{LEVEL, MODES, device, difference, draw, gpu, sample, stage, with_holes};
use pellucid_field::VoxelType;
use pellucid_gpu::{AdapterChoice, Ceiling, Device, GpuError, GpuRenderer, Interpolation, adapters};
use pellucid_scene::Control;
use proptest::prelude::*;

const SIZE: [u32; 2] = [40, 32];

#[test]
fn a_lost_device_says_so_and_another_one_draws() {
    let volume = sample("ball", [16; 3], VoxelType::U8);
    let stage = stage(&volume, "", SIZE);
    let mut gpu = gpu(&Ceiling::default());
    let expected = draw(&mut gpu, &stage);
    gpu.device().device.destroy();
    for _ in 0..2 {
        let error = gpu.render(&stage, &Control::default()).unwrap_err();
        assert!(matches!(error, GpuError::Lost { .. }), "{error:?}");
    }
    // Lost before anything was uploaded, too.
    let mut fresh = crate::common::gpu(&Ceiling::default());
    fresh.device().device.destroy();
    assert!(matches!(fresh.render(&stage, &Control::default()), Err(GpuError::Lost { .. })));
    assert_eq!(draw(&mut crate::common::gpu(&Ceiling::default()), &stage).color, expected.color);
}

#[test]
fn a_rejected_command_is_an_error_and_the_device_goes_on() {
    let device = device(&Ceiling::default());
    let limit = device.capabilities.limits.max_buffer_size;
    let descriptor = |size| wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    };
    let _refused = device.device.create_buffer(&descriptor(limit + 4));
    let error = device.check().unwrap_err();
    assert!(matches!(error, GpuError::Rejected { .. }), "{error:?}");
    let mut gpu = GpuRenderer::on(device);
    let volume = sample("ball", [16; 3], VoxelType::U8);
    draw(&mut gpu, &stage(&volume, "", SIZE));
}

#[test]
fn an_adapter_that_is_not_there_names_those_that_are() {
    let error = Device::open(&AdapterChoice::Named("none such".into()), &Ceiling::default()).err().unwrap();
    let text = error.to_string();
    assert!(text.contains("'none such'"), "{text}");
    let all = adapters();
    assert!(!all.is_empty());
    for (adapter, capabilities) in all {
        assert!(text.contains(&adapter.to_string()), "{adapter} is not in {text}");
        assert!(capabilities.to_string().contains("3D textures to"), "{capabilities}");
        let part = adapter.name[..adapter.name.len().min(4)].to_uppercase();
        assert!(Device::open(&AdapterChoice::Named(part), &Ceiling::default()).is_ok());
    }
}

#[test]
fn what_does_not_fit_is_told_in_numbers() {
    let volume = sample("ball", [64; 3], VoxelType::U16);
    let stage = stage(&volume, "", SIZE);
    let memory = |bytes| Ceiling { memory: Some(bytes), ..Ceiling::default() };
    let error = gpu(&memory(20_000)).render(&stage, &Control::default()).unwrap_err();
    let GpuError::Budget { needed, budget: 20_000, .. } = error else { panic!("{error:?}") };
    assert!(needed > 20_000);
    let side = Ceiling { texture_side: Some(3), ..Ceiling::default() };
    let error = gpu(&side).render(&stage, &Control::default()).unwrap_err();
    assert!(matches!(error, GpuError::Budget { .. }), "{error:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any ceiling gives the right picture or says what it needs.
    #[test]
    fn any_ceiling_draws_or_says_why_not(
        side in 4u32..64,
        memory in 16u64 << 10..4 << 20,
        mode in 0..MODES.len(),
        kind in 0..3,
    ) {
        let volume = match kind {
            0 => sample("marschner-lobb", [14, 17, 9], VoxelType::U8),
            1 => sample("marschner-lobb", [50, 10, 9], VoxelType::F32),
            _ => with_holes("marschner-lobb", [15, 13, 11]),
        };
        let stage = stage(&volume, MODES[mode].1, SIZE);
        let ceiling = Ceiling { texture_side: Some(side), memory: Some(memory), ..Ceiling::default() };
        let mut small = gpu(&ceiling);
        match small.render(&stage, &Control::default()) {
            Ok(found) => {
                let plan = small.plan(&stage).unwrap();
                prop_assert!(plan.total() <= memory, "{}", plan);
                let mut large = GpuRenderer::on(device(&Ceiling::default())).with_interpolation(Interpolation::Exact);
                let apart = difference(&found, &draw(&mut large, &stage));
                prop_assert!(apart <= LEVEL, "{:.2} levels apart: {}", apart / LEVEL, plan);
            }
            Err(GpuError::Budget { .. }) => {}
            Err(error) => prop_assert!(false, "{:?}", error),
        }
    }
}
