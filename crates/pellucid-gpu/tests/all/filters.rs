//! Every filter and every gradient, on every type of voxel, and steps that adapt to the data: the CPU
//! backend's pictures within 2/255 and 50 dB.

use std::sync::Arc;

use half::f16;
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Filter, Gradient, Grid, SincWindow, ValueMap, Volume, Voxel, VoxelType, Voxels};
use pellucid_gpu::{AdapterChoice, Ceiling, Device, GpuRenderer, Interpolation};
use pellucid_optics::{Color, ColorPoint, Interpolation as Curve, OpacityPoint, TransferFunction};
use pellucid_scene::{
    Classification, Clip, Control, Frame, Isosurface, Isovalue, Jitter, Mode, Orbit, RayCast, Scene, Source, Stage,
    Technique, View,
};

const GRADIENTS: [Gradient; 8] = [
    Gradient::Forward,
    Gradient::Backward,
    Gradient::Central,
    Gradient::Sobel,
    Gradient::SobelIsotropic,
    Gradient::Prewitt,
    Gradient::Gaussian { sigma: 0.6 },
    Gradient::BSpline,
];

/// With how many of the gradients each is tried: drivers that run on the processor (llvmpipe) end all loops
/// of a shader after 65,535 rounds, and a Gaussian of a wide sinc takes more beside a hole.
const FILTERS: [(Filter, usize); 9] = [
    (Filter::Nearest, 8),
    (Filter::Linear, 8),
    (Filter::BSpline { prefilter: false }, 8),
    (Filter::BSpline { prefilter: true }, 8),
    (Filter::CATMULL_ROM, 8),
    (Filter::MITCHELL, 4),
    (Filter::Sinc { window: SincWindow::Lanczos, half_width: 2 }, 3),
    (Filter::Sinc { window: SincWindow::Kaiser, half_width: 3 }, 1),
    (Filter::Sinc { window: SincWindow::Blackman, half_width: 4 }, 1),
];

fn gpu(ceiling: &Ceiling) -> GpuRenderer {
    let open = |choice| Device::open(&choice, ceiling);
    let device = open(AdapterChoice::Hardware).or_else(|_| open(AdapterChoice::Software));
    let device = device.expect("a Vulkan driver is needed; on Debian: apt-get install mesa-vulkan-drivers");
    GpuRenderer::on(device).with_interpolation(Interpolation::Exact)
}

/// Noise upon a smooth field, over most of the type's range; some voxels are absent where the type can
/// say so.
fn volume(voxel_type: VoxelType, dims: [usize; 3]) -> Volume {
    let grid = Grid::with_spacing(dims, [1.0, 0.7, 1.6], [3.0, -2.0, 5.0]).unwrap();
    let [nx, ny, _] = dims;
    let level = |voxel: usize| {
        let [x, y, z] = [voxel % nx, voxel / nx % ny, voxel / (nx * ny)].map(|i| i as f64);
        let noise = (voxel.wrapping_mul(2_654_435_761) >> 7) % 1000;
        0.5 + 0.35 * (0.6 * x + 0.3 * y).sin() * (0.5 * z - 0.2 * x).cos() + 0.1 * noise as f64 / 1000.0
    };
    let [low, high] = match voxel_type {
        VoxelType::U8 => [0.0, 255.0],
        VoxelType::I8 => [-128.0, 127.0],
        VoxelType::U16 => [0.0, 65_535.0],
        VoxelType::I16 => [-32_768.0, 32_767.0],
        VoxelType::U32 => [0.0, 4e9],
        VoxelType::I32 => [-2e9, 2e9],
        VoxelType::F16 => [-50.0, 900.0],
        VoxelType::F32 => [-3e5, 8e5],
    };
    let hole = |voxel: usize| voxel % 211 == 100;
    let numbers = (0..grid.len()).map(|voxel| low + (high - low) * level(voxel));
    let holed = || numbers.clone().enumerate().map(|(voxel, v)| if hole(voxel) { f64::NAN } else { v });
    fn of<T: Voxel>(numbers: impl Iterator<Item = f64>) -> Voxels
    where
        Voxels: From<Vec<T>>,
    {
        numbers.map(T::from_f64).collect::<Vec<T>>().into()
    }
    let voxels = match voxel_type {
        VoxelType::U8 => of::<u8>(numbers),
        VoxelType::I8 => of::<i8>(numbers),
        VoxelType::U16 => of::<u16>(numbers),
        VoxelType::I16 => of::<i16>(numbers),
        VoxelType::U32 => of::<u32>(numbers),
        VoxelType::I32 => of::<i32>(numbers),
        VoxelType::F16 => of::<f16>(holed()),
        VoxelType::F32 => of::<f32>(holed()),
    };
    // Data values from 0 to 1 in every type.
    let map = ValueMap { scale: 1.0 / (high - low), offset: -low / (high - low) };
    Volume::new(grid, voxels).unwrap().with_value_map(map).unwrap()
}

fn transfer_function(opacities: &[(f64, f32)]) -> TransferFunction {
    let interpolation = Curve::Linear;
    let colors = [(0.2, 0x2060c0), (0.5, 0xf0e0c0), (0.8, 0xc03020)];
    let colors = colors.map(|(value, hex)| ColorPoint { value, color: Color::hex(hex), interpolation });
    let opacities = opacities.iter().map(|&(value, opacity)| OpacityPoint { value, opacity, interpolation });
    let tf = TransferFunction::new(colors.to_vec(), opacities.collect()).unwrap();
    tf.with_unit_distance(Some(1.0)).unwrap()
}

/// A lit picture of a volume from the side, cut by a plane.
fn stage(volume: &Arc<Volume>, edit: impl FnOnce(&mut Scene)) -> Stage {
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].transfer_function = Some(transfer_function(&[(0.45, 0.0), (0.6, 0.3), (0.9, 0.5)]));
    scene.volumes[0].shading = Some(true);
    scene.camera.view = View::Orbit(Orbit { azimuth: 35.0, elevation: 25.0, ..Orbit::default() });
    scene.clips = vec![Clip::Plane { point: [8.0, 1.0, 11.0], normal: [-0.6, -0.3, -0.2] }];
    (scene.image.width, scene.image.height) = (28, 24);
    edit(&mut scene);
    scene.resolve(std::slice::from_ref(volume)).unwrap().0
}

fn mode(scene: &mut Scene, mode: Mode) {
    scene.technique = Technique::RayCast(RayCast { mode });
}

fn isosurface() -> Mode {
    Mode::Isosurface(Isosurface::new(vec![Isovalue { value: 0.6, color: None, opacity: 0.8, volume: None }]))
}

/// What is wrong with a picture, if it is further than `most` and 50 dB from another.
fn fault(found: &Frame, expected: &Frame, stage: &Stage, most: u8) -> Option<String> {
    let (a, b) = (found.to_rgba8(&stage.image), expected.to_rgba8(&stage.image));
    let differences = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b));
    let largest = differences.clone().max().unwrap();
    let squares: f64 = differences.map(|d| f64::from(d).powi(2)).sum();
    let psnr = 10.0 * (255.0 * 255.0 * a.len() as f64 / squares).log10();
    (psnr < 50.0 || largest > most).then(|| format!("{psnr:.1} dB, largest difference {largest}"))
}

/// Draws stages on both backends.
struct Both {
    gpu: GpuRenderer,
    cpu: CpuRenderer,
    faults: Vec<String>,
}

impl Both {
    fn new() -> Self {
        Self { gpu: gpu(&Ceiling::default()), cpu: CpuRenderer::new(), faults: Vec::new() }
    }

    fn draw(&mut self, name: &str, stage: &Stage) -> [Frame; 2] {
        let found = self.gpu.render(stage, &Control::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected = self.cpu.render(stage, &Control::default()).unwrap();
        assert!(expected.statistics.samples_visible > 0, "{name}: nothing is seen");
        self.faults.extend(fault(&found, &expected, stage, 2).map(|fault| format!("{name}: {fault}")));
        [found, expected]
    }

    fn finish(self) {
        assert!(self.faults.is_empty(), "{} pictures:\n{}", self.faults.len(), self.faults.join("\n"));
    }
}

#[test]
fn filters_and_gradients_are_those_of_the_processor() {
    let mut both = Both::new();
    let volume = Arc::new(volume(VoxelType::F32, [12, 14, 9]));
    for (filter, count) in FILTERS {
        for gradient in GRADIENTS.into_iter().rev().take(count) {
            let stage = stage(&volume, |scene| {
                (scene.quality.filter, scene.quality.gradient) = (filter, gradient);
                // Few samples, for the same reason.
                scene.quality.step = 4.0;
            });
            both.draw(&format!("{filter:?} {gradient:?}"), &stage);
        }
    }
    both.finish();
}

#[test]
fn every_mode_takes_every_filter() {
    let mut both = Both::new();
    let volume = Arc::new(volume(VoxelType::F16, [12, 14, 9]));
    for (filter, _) in &FILTERS[..6] {
        for classification in [Classification::Pre, Classification::PreIntegrated] {
            let stage = stage(&volume, |scene| {
                (scene.quality.filter, scene.quality.classification) = (*filter, classification);
            });
            both.draw(&format!("{filter:?} {classification:?}"), &stage);
        }
        // A field of nearest voxels passes a level where it jumps: rounding decides whose gradient is seen.
        let surfaces = (*filter != Filter::Nearest).then(isosurface);
        for technique in [Mode::Maximum, Mode::XRay].into_iter().chain(surfaces) {
            let name = format!("{filter:?} {technique:?}");
            let stage = stage(&volume, |scene| {
                scene.quality.filter = *filter;
                mode(scene, technique);
            });
            both.draw(&name, &stage);
        }
    }
    both.finish();
}

#[test]
fn every_type_of_voxel_takes_every_filter() {
    let mut both = Both::new();
    let filters = [
        (Filter::Linear, Gradient::Sobel),
        (Filter::Nearest, Gradient::Central),
        (Filter::BSpline { prefilter: true }, Gradient::BSpline),
        (Filter::CATMULL_ROM, Gradient::Prewitt),
    ];
    for voxel_type in VoxelType::ALL {
        // One axis is shorter than the kernels.
        for dims in [[9, 7, 3]] {
            let volume = Arc::new(volume(voxel_type, dims));
            for (filter, gradient) in filters {
                let stage = stage(&volume, |scene| {
                    (scene.quality.filter, scene.quality.gradient) = (filter, gradient);
                    scene.clips.clear();
                });
                both.draw(&format!("{voxel_type:?} {dims:?} {filter:?} {gradient:?}"), &stage);
            }
        }
    }
    both.finish();
}

/// Waves that are steep in places, in a medium that is thin elsewhere.
fn waves() -> (Arc<Volume>, TransferFunction) {
    let grid = Grid::new([48; 3]).unwrap();
    let value = |voxel: usize| {
        let [x, y, z] = [voxel % 48, voxel / 48 % 48, voxel / 2304].map(|i| i as f32);
        0.5 + 0.5 * (x * 0.11).sin() * (y * 0.09).cos() * (z * 0.13).sin()
    };
    let volume = Volume::new(grid, (0..grid.len()).map(value).collect::<Vec<f32>>()).unwrap();
    (Arc::new(volume), transfer_function(&[(0.0, 0.0), (0.45, 0.0), (0.5, 0.02), (0.8, 0.01), (1.0, 0.2)]))
}

fn adaptive(volume: &Arc<Volume>, tf: &TransferFunction, tolerance: f32, jitter: Jitter) -> Stage {
    stage(volume, |scene| {
        scene.volumes[0].transfer_function = Some(tf.clone());
        scene.clips.clear();
        scene.quality.adaptive_tolerance = tolerance;
        scene.quality.jitter = jitter;
    })
}

/// The same strides at the same places: as many samples, and the same picture (7.3-3).
#[test]
fn steps_adapt_as_on_the_processor() {
    let mut both = Both::new();
    let (volume, tf) = waves();
    let every = both.draw("without", &adaptive(&volume, &tf, 0.0, Jitter::Centered));
    for (tolerance, jitter) in [(0.1, Jitter::Centered), (1.0, Jitter::BlueNoise { seed: 3 })] {
        let [found, expected] = both.draw("adaptive", &adaptive(&volume, &tf, tolerance, jitter));
        let [a, b] = [&found, &expected].map(|frame| frame.statistics.samples as f64);
        assert!((a - b).abs() < 0.01 * b, "tolerance {tolerance}: {a} and {b} samples");
        let all = every[1].statistics.samples as f64;
        assert!(b < 0.97 * all, "tolerance {tolerance}: {b} of {all} samples");
    }
    both.finish();
}

/// Bricks have what wide kernels reach for, and strides go on from one to the next.
#[test]
fn bricks_change_no_filter_and_no_stride() {
    let small = Ceiling { texture_side: Some(24), ..Ceiling::default() };
    let (mut whole, mut bricked) = (gpu(&Ceiling::default()), gpu(&small));
    let (volume, tf) = waves();
    let filters = [
        (Filter::CATMULL_ROM, Gradient::Sobel, Classification::Post),
        (Filter::Nearest, Gradient::Sobel, Classification::PreIntegrated),
    ];
    let mut stages = vec![adaptive(&volume, &tf, 0.05, Jitter::Centered)];
    stages.extend(filters.map(|(filter, gradient, classification)| {
        stage(&volume, |scene| {
            scene.volumes[0].transfer_function = Some(tf.clone());
            scene.quality.filter = filter;
            scene.quality.gradient = gradient;
            scene.quality.classification = classification;
            scene.quality.step = 2.0;
            (scene.image.width, scene.image.height) = (16, 12);
        })
    }));
    for (number, stage) in stages.iter().enumerate() {
        let [found, expected] = [&mut bricked, &mut whole].map(|gpu| gpu.render(stage, &Control::default()).unwrap());
        let fault = fault(&found, &expected, stage, 1);
        assert!(fault.is_none(), "stage {number}: {}", fault.unwrap_or_default());
    }
}
