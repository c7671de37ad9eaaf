//! The instruction sets against each other: every voxel type, mode and width, equal up to rounding.

use crate::common::data::{Data, Texture};
use crate::common::random::Case;
use pellucid_cpu::{CpuRenderer, InstructionSet};
use pellucid_field::VoxelType;
use pellucid_optics::{Frame as LightFrame, Light, LightKind, Material};
use pellucid_scene::{
    Classification, Combine, Control, Frame, HalfAngle, Isosurface, Jitter, Mode, Orbit, Projection, Quality, Slice,
    Stage, Technique,
};

/// The largest difference of a channel between two sets: products are fused in some and not in all.
const ROUNDING: f32 = 2e-5;

/// A lit scene of a smooth field; rounding decides nothing in it.
fn case(voxel_type: VoxelType, dims: [usize; 3], holes: f64) -> Case {
    let headlight =
        Light { frame: LightFrame::Camera, ..Light::new(LightKind::Directional { direction: [0.0, 0.0, -1.0] }) };
    let lamp = Light::new(LightKind::Point { position: [0.3, -1.5, 1.1], falloff: Default::default() });
    Case {
        data: Data {
            dims,
            voxel_type,
            texture: Texture::Waves,
            seed: 11,
            holes,
            map: [1.5, 0.2],
            components: 1,
            affine: [[1.0, 1.2, 0.8], [0.3, 0.2, 0.1], [0.1, 0.0, -0.2]],
        },
        opacities: [0.0, 0.3, 0.6],
        hull: [0.2, 0.9],
        colors: [[0.1, 0.3, 0.9], [0.9, 0.2, 0.3], [1.0, 0.9, 0.8]],
        view: (Projection::Perspective { vertical_fov: 30.0 }, Orbit::default()),
        light: Some((Material { shininess: 8.0, ..Material::default() }, vec![headlight, lamp], None)),
        clips: Vec::new(),
        crop: None,
        quality: Quality { jitter: Jitter::BlueNoise { seed: 5 }, early_termination: 1.0, ..Quality::default() },
        levels: vec![(0.31, 0.5), (0.62, 1.0)],
    }
}

fn draw(set: InstructionSet, stage: &Stage) -> Option<Frame> {
    let mut renderer = CpuRenderer::new().with_instructions(set).ok()?;
    Some(renderer.render(stage, &Control::default()).unwrap())
}

fn modes() -> Vec<(Mode, Classification)> {
    let others = [
        Mode::Composite,
        Mode::Maximum,
        Mode::Minimum,
        Mode::Average,
        Mode::Additive,
        Mode::XRay,
        Mode::Isosurface(Isosurface::new(Vec::new())),
        Mode::Slice(Slice::default()),
        Mode::Slice(Slice { thickness: 3.0, combine: Combine::Average, ..Slice::default() }),
    ];
    let mut modes: Vec<_> = others.into_iter().map(|mode| (mode, Classification::Post)).collect();
    modes.push((Mode::Composite, Classification::Pre));
    modes.push((Mode::Composite, Classification::PreIntegrated));
    modes
}

/// How many pixels differ by more than rounding.
fn different(a: &Frame, b: &Frame) -> usize {
    let differs =
        |(a, b): (&[f32; 4], &[f32; 4])| (0..4).any(|c| (a[c] - b[c]).abs().is_nan() || (a[c] - b[c]).abs() > ROUNDING);
    a.color.iter().zip(&b.color).filter(|&pair| differs(pair)).count()
}

#[test]
fn every_set_draws_every_voxel_type_alike() {
    for voxel_type in VoxelType::ALL {
        for dims in [[11, 9, 10], [2, 5, 17], [3, 2, 2]] {
            for (mode, classification) in modes() {
                let stage = case(voxel_type, dims, 0.0).stage(&mode, classification, true);
                let baseline = draw(InstructionSet::Baseline, &stage).unwrap();
                assert!(baseline.color.iter().any(|color| color[0] > 0.05), "{voxel_type} {dims:?} {mode:?} is empty");
                for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
                    let Some(frame) = draw(set, &stage) else { continue };
                    let found = different(&frame, &baseline);
                    assert_eq!(found, 0, "{set} and baseline: {voxel_type} {dims:?} {mode:?} {classification:?}");
                }
            }
        }
    }
}

/// Beside holes the nearest voxel decides whether there is a field, which rounding may change: in
/// few pixels.
#[test]
fn every_set_draws_holes_alike() {
    for voxel_type in [VoxelType::F16, VoxelType::F32] {
        for (mode, classification) in modes() {
            let stage = case(voxel_type, [11, 9, 10], 0.1).stage(&mode, classification, true);
            let baseline = draw(InstructionSet::Baseline, &stage).unwrap();
            for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
                let Some(frame) = draw(set, &stage) else { continue };
                let found = different(&frame, &baseline);
                assert!(found <= 2, "{set} and baseline: {found} pixels, {voxel_type} {mode:?} {classification:?}");
            }
        }
    }
}

/// Light that passes slabs, with and without what it scatters.
#[test]
fn every_set_sends_half_angle_light_alike() {
    for indirect in [0.0, 0.7] {
        let mut stage = case(VoxelType::U8, [11, 9, 10], 0.0).stage(&Mode::Composite, Classification::Post, true);
        stage.technique = Technique::HalfAngle(HalfAngle { resolution: 48, indirect, ..HalfAngle::default() });
        let baseline = draw(InstructionSet::Baseline, &stage).unwrap();
        assert!(baseline.color.iter().any(|color| color[0] > 0.05), "{indirect}: nothing is seen");
        for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
            let Some(frame) = draw(set, &stage) else { continue };
            assert_eq!(different(&frame, &baseline), 0, "{set} and baseline, {indirect}");
        }
    }
}

/// One ray, one packet and many: the lanes that are empty beside the last columns and rows of a
/// picture do not count.
#[test]
fn every_size_of_picture_is_a_part_of_the_largest() {
    let stage = case(VoxelType::U8, [11, 9, 10], 0.0).stage(&Mode::Composite, Classification::Post, true);
    for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
        let Some(whole) = draw(set, &stage) else { continue };
        for tile in [1, 2, 3, 5, 7] {
            let mut renderer = CpuRenderer::new().with_instructions(set).unwrap().with_tile_size(tile);
            let frame = renderer.render(&stage, &Control::default()).unwrap();
            assert_eq!(frame.color, whole.color, "{set}, tiles of {tile}");
            assert_eq!(frame.samples, whole.samples, "{set}, tiles of {tile}");
        }
    }
}
