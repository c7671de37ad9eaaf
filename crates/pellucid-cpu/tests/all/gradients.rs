//! Gradients of every kind through the whole renderer, where taps are there and where they are not:
//! the normals of pictures against `index_gradient` over a plain trilinear field.

use crate::common::data::{Data, Texture};
use crate::common::{render, stage, transfer_function, volume_of};
use glam::{DAffine3, DVec3};
use pellucid_cpu::{CpuRenderer, InstructionSet};
use pellucid_field::{Filter, Gradient, Grid, ValueMap, Volume, VoxelType, Voxels, index_gradient};
use pellucid_optics::{Color, ColorPoint, GradientWeight, Interpolation, OpacityPoint, TransferFunction};
use pellucid_scene::{Clip, Control, Orbit, Region, Stage, View};

/// The trilinear value, NaN outside the box and the region. Where a voxel is absent the nearest one
/// stands for it.
fn plain(volume: &Volume, region: &Region, p: DVec3) -> f64 {
    let last = DVec3::from_array(volume.grid().dims().map(|n| (n - 1) as f64));
    let inside = p.cmpge(DVec3::splat(-1e-6)).all() && p.cmple(last + 1e-6).all();
    if !inside || !region.contains(volume.grid().world_from_index().transform_point3(p)) {
        return f64::NAN;
    }
    let p = p.max(DVec3::ZERO).min(last);
    let at = |p: DVec3| volume.value(p.to_array().map(|x| x as usize), 0);
    let nearest = at((p + 0.5).floor());
    let mut sum = 0.0;
    for corner in 0..8 {
        let upper = DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1)));
        let u = p - p.floor();
        let weight = upper * u + (1.0 - upper) * (1.0 - u);
        let value = at((p.floor() + upper).min(last));
        sum += weight.x * weight.y * weight.z * if value.is_finite() { value - nearest } else { 0.0 };
    }
    nearest + sum
}

/// The gradient per index step at an index position; `None` where it is too short to have a
/// direction, or another one a little further on, as where a tap is about to leave the volume.
fn certain_gradient(volume: &Volume, region: &Region, kind: Gradient, p: DVec3) -> Option<DVec3> {
    let statistics = volume.statistics();
    let field = |p| plain(volume, region, p);
    let gradient = index_gradient(kind, p, field(p), field);
    let signs = |bits: i32| DVec3::from_array([0, 1, 2].map(|axis| f64::from(bits >> axis & 1) * 2.0 - 1.0));
    let steady = (0..8).map(|bits| p + 3e-4 * signs(bits)).all(|p| {
        let other = index_gradient(kind, p, field(p), field);
        other.abs_diff_eq(gradient, 5e-3 * (statistics.max - statistics.min))
    });
    (steady && gradient.length() > 0.02 * (statistics.max - statistics.min)).then_some(gradient)
}

/// Opaque from the middle of the values on: rays end at once, wherever that may be.
fn opaque_half(volume: &Volume) -> TransferFunction {
    let middle = (volume.statistics().min + volume.statistics().max) / 2.0;
    let interpolation = Interpolation::Step;
    let opacity = |value, opacity| OpacityPoint { value, opacity, interpolation };
    let opacities = vec![opacity(volume.statistics().min - 1.0, 0.0), opacity(middle, 1.0)];
    let tf = TransferFunction::new(vec![ColorPoint::new(middle, Color::WHITE)], opacities).unwrap();
    tf.with_unit_distance(Some(1.0)).unwrap()
}

/// Compares the normals of a picture; returns how many pixels had one.
fn check_normals(stage: &Stage, set: InstructionSet, kind: Gradient) -> usize {
    let Ok(mut renderer) = CpuRenderer::new().with_instructions(set) else { return usize::MAX };
    let frame = renderer.render(stage, &Control::default()).unwrap();
    let staged = &stage.volumes[0];
    let grid = staged.volume.grid();
    let mut compared = 0;
    for (pixel, depth) in frame.depth.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
        let ray = stage.viewpoint.ray((pixel % frame.width) as f64 + 0.5, (pixel / frame.width) as f64 + 0.5);
        let p = grid.index_from_world().transform_point3(ray.at(f64::from(*depth)));
        let Some(gradient) = certain_gradient(&staged.volume, &staged.region, kind, p) else { continue };
        let exact = -(grid.index_from_world().matrix3.transpose() * gradient).normalize();
        let normal = glam::Vec3::from_array(frame.normal[pixel]).as_dvec3();
        let what = format!("{} {:?}", staged.volume.voxels().voxel_type(), grid.dims());
        assert!(normal.abs_diff_eq(exact, 2e-3), "{set}, {kind:?}, {what}, at {p}: {normal}, exact {exact}");
        compared += 1;
    }
    compared
}

const KINDS: [Gradient; 8] = [
    Gradient::Central,
    Gradient::Forward,
    Gradient::Backward,
    Gradient::Sobel,
    Gradient::SobelIsotropic,
    Gradient::Prewitt,
    Gradient::Gaussian { sigma: 0.7 },
    Gradient::BSpline,
];

const SETS: [InstructionSet; 3] = [InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Baseline];

fn data(voxel_type: VoxelType, dims: [usize; 3], holes: f64) -> Data {
    Data {
        dims,
        voxel_type,
        texture: Texture::Noise,
        seed: 3,
        holes,
        map: [0.8, 0.3],
        components: 1,
        affine: [[1.0, 1.3, -0.9], [0.4, 0.9, 0.2], [0.2, -0.1, 0.1]],
    }
}

fn looked_at(volume: &Volume, azimuth: f64, elevation: f64, kind: Gradient, clip: Option<Clip>) -> Stage {
    stage(volume.clone(), opaque_half(volume), |scene| {
        scene.camera.view = View::Orbit(Orbit { azimuth, elevation, ..Orbit::default() });
        scene.quality.gradient = kind;
        scene.quality.step = 0.21;
        scene.clips = clip.into_iter().collect();
    })
}

/// Central differences, which have a kernel of their own: every type of voxel, sizes down to a
/// single cell, from all sides, so that every border is met.
#[test]
fn central_differences_are_right_at_every_border() {
    let sizes = [[2, 2, 2], [3, 2, 2], [2, 3, 2], [2, 2, 3], [3, 3, 3], [4, 2, 5], [9, 8, 7], [17, 3, 9]];
    for voxel_type in VoxelType::ALL {
        let mut compared = 0;
        for dims in sizes {
            let volume = data(voxel_type, dims, 0.0).volume();
            for (azimuth, elevation) in [(20.0, 30.0), (140.0, -50.0), (250.0, 10.0)] {
                let stage = looked_at(&volume, azimuth, elevation, Gradient::Central, None);
                compared += SETS.map(|set| check_normals(&stage, set, Gradient::Central))[2];
            }
        }
        assert!(compared > 1200, "{voxel_type}: {compared} normals");
    }
}

#[test]
fn every_kind_is_right_at_borders_clips_and_holes() {
    for kind in KINDS {
        let mut compared = [0; 3];
        for dims in [[2, 2, 2], [5, 6, 4], [9, 8, 7]] {
            for (i, (voxel_type, holes, clipped)) in
                [(VoxelType::U8, 0.0, false), (VoxelType::I16, 0.0, true), (VoxelType::F32, 0.1, false)]
                    .into_iter()
                    .enumerate()
            {
                let volume = data(voxel_type, dims, holes).volume();
                let point = volume.grid().center().to_array();
                let clip = clipped.then_some(Clip::Plane { point, normal: [0.5, -0.8, 0.3] });
                let stage = looked_at(&volume, 200.0, 40.0, kind, clip);
                compared[i] += SETS.map(|set| check_normals(&stage, set, kind))[2];
            }
        }
        assert!(compared.iter().all(|&n| n > 40), "{kind:?}: {compared:?} normals");
    }
}

/// A field without slope has no normals, and where slopes make surfaces it has none, whatever its value: also
/// at borders and holes, where differences are against the value in the middle, and for types and
/// value maps whose values are no `f32`.
#[test]
fn a_flat_field_has_no_normals_at_its_borders() {
    let grid = Grid::new([6, 5, 7]).unwrap();
    let flat = |voxels: Voxels, components| {
        let volume = Volume::with_components(grid, voxels, components).unwrap();
        volume.with_value_map(ValueMap { scale: 0.37, offset: 0.1 }).unwrap()
    };
    // Holes inside, and in the first cell, where no tap of the gradient meets the hole.
    let mut holed = vec![132.0f32; 210];
    (holed[0], holed[81]) = (f32::NAN, f32::NAN);
    let volumes = [
        flat(vec![7u8; 210].into(), 1),
        flat(vec![7u8; 420].into(), 2),
        flat(vec![16_777_217i32; 210].into(), 1),
        flat(vec![u32::MAX; 210].into(), 1),
        flat(holed.into(), 1),
    ];
    for volume in volumes {
        for kind in KINDS {
            let what = format!("{kind:?} of {}", volume.voxels().voxel_type());
            let tf = transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.3)]);
            let frame = render(&stage(volume.clone(), tf, |scene| {
                scene.quality.gradient = kind;
                scene.volumes[0].shading = Some(true);
                scene.volumes[0].gradient_weight = Some(GradientWeight { low: 0.0, high: 1e-3 });
                scene.image.width = 40;
                scene.image.height = 40;
            }));
            assert!(frame.normal.iter().flatten().all(|n| *n == 0.0), "{what} has normals");
            // White as it is: the least slope would darken it.
            let unlit = |color: &&[f32; 4]| (color[0] - color[3]).abs() < 1e-6;
            assert_eq!(frame.color.iter().find(|color| !unlit(color)), None, "{what} is lit");
        }
    }
}

/// A cut that takes nothing of the picture leaves the gradients what they are, under every filter: a
/// B-spline's derivative is of its voxels and not of its samples, which it has smoothed.
#[test]
fn a_cut_elsewhere_changes_no_gradient() {
    let volume = data(VoxelType::U8, [9, 8, 7], 0.0).volume();
    for filter in [Filter::Linear, Filter::BSpline { prefilter: false }, Filter::BSpline { prefilter: true }] {
        for kind in KINDS {
            let draw = |clip: Option<Clip>| {
                let mut stage = looked_at(&volume, 200.0, 40.0, kind, clip);
                stage.quality.filter = filter;
                render(&stage)
            };
            let far = Clip::Box { min: [-99.0; 3], max: [99.0; 3] };
            assert!(draw(None).normal == draw(Some(far)).normal, "{filter:?} {kind:?}");
        }
    }
}

/// The gradient of a ramp is the ramp's, to rounding, in every direction and at every border. (The
/// smoothing kinds lose taps at edges, where a tap and its opposite are both outside.)
#[test]
fn a_ramp_has_one_normal() {
    let slope = DVec3::new(0.3, -1.1, 0.7);
    let volume = volume_of([6, 5, 7], DAffine3::IDENTITY, |p| 40.0 + slope.dot(p));
    for kind in [Gradient::Central, Gradient::Forward, Gradient::Backward, Gradient::BSpline] {
        for (azimuth, elevation) in [(0.0, 0.0), (100.0, 35.0), (290.0, -70.0)] {
            let frame = render(&looked_at(&volume, azimuth, elevation, kind, None));
            let hits = frame.normal.iter().zip(&frame.depth).filter(|(_, depth)| depth.is_finite());
            let normals: Vec<DVec3> = hits.map(|(n, _)| glam::Vec3::from_array(*n).as_dvec3()).collect();
            assert!(normals.len() > 20, "{} normals", normals.len());
            for normal in normals {
                assert!(normal.abs_diff_eq(-slope.normalize(), 1e-5), "{kind:?}: {normal}");
            }
        }
    }
}
