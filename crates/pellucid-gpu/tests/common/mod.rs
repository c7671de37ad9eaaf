//! Stages to draw, renderers to draw them with, and how far two pictures are apart.

#![allow(dead_code)] // Every test file uses its own part.

use std::sync::Arc;

use pellucid_field::{Volume, VoxelType, closed_form};
use pellucid_gpu::{AdapterChoice, Ceiling, Device, GpuRenderer, Interpolation};
use pellucid_scene::{Control, Format, Frame, Scene, Stage};

/// A renderer with exact interpolation on whatever Vulkan driver there is.
pub fn gpu(ceiling: &Ceiling) -> GpuRenderer {
    GpuRenderer::on(device(ceiling)).with_interpolation(Interpolation::Exact)
}

/// A device of whatever Vulkan driver there is.
pub fn device(ceiling: &Ceiling) -> Device {
    let open = |choice| Device::open(&choice, ceiling);
    let device = open(AdapterChoice::Hardware).or_else(|_| open(AdapterChoice::Software));
    device.expect("a Vulkan driver is needed; on Debian: apt-get install mesa-vulkan-drivers")
}

/// Textures of at most so many voxels per axis.
pub fn side(side: u32) -> Ceiling {
    Ceiling { texture_side: Some(side), ..Ceiling::default() }
}

/// What a renderer draws.
pub fn draw(gpu: &mut GpuRenderer, stage: &Stage) -> Frame {
    gpu.render(stage, &Control::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A built-in field.
pub fn sample(name: &str, dims: [usize; 3], voxel_type: VoxelType) -> Arc<Volume> {
    Arc::new(closed_form::sample_field(closed_form::by_name(name).unwrap().as_ref(), dims, voxel_type).unwrap())
}

/// A stage of a volume; the document goes on after the volume's source.
pub fn stage(volume: &Arc<Volume>, document: &str, size: [u32; 2]) -> Stage {
    let mut scene = Scene::parse(&format!("[[volumes]]\nsource = \"memory\"\n{document}"), Format::Toml)
        .unwrap_or_else(|error| panic!("{error} in {document}"));
    [scene.image.width, scene.image.height] = size;
    scene.resolve(std::slice::from_ref(volume)).unwrap().0
}

/// Largest difference of colour or opacity, of 1.
pub fn difference(a: &Frame, b: &Frame) -> f32 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pairs = a.color.as_flattened().iter().zip(b.color.as_flattened());
    pairs
        .map(|(a, b)| if a == b { 0.0 } else { (a - b).abs() })
        .fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m })
}

/// A step of an 8-bit channel.
pub const LEVEL: f32 = 1.0 / 255.0;

/// Every way to look along rays: a name, and what goes on after the volume's source.
pub const MODES: [(&str, &str); 14] = [
    ("composite", "shading = false"),
    ("shaded", "shading = true"),
    ("weighted", "shading = true\ngradient_weight = { low = 0.1, high = 4.0 }"),
    ("pre-classified", "shading = true\n[quality]\nclassification = \"pre\""),
    ("pre-integrated", "shading = true\n[quality]\nclassification = \"pre_integrated\"\nstep = 1.5"),
    ("maximum", "[technique.ray_cast]\nmode = \"maximum\""),
    ("minimum", "[technique.ray_cast]\nmode = \"minimum\""),
    ("average", "[technique.ray_cast]\nmode = \"average\""),
    ("additive", "[technique.ray_cast]\nmode = \"additive\""),
    ("x-ray", "[technique.ray_cast]\nmode = \"x_ray\""),
    (
        "isosurface",
        "[[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = 0.4\nopacity = 0.5\n[[technique.ray_cast.mode.isosurface.isovalues]]\nvalue = 0.7",
    ),
    ("slice", "[technique.ray_cast.mode.slice]\nnormal = [0.3, 1.0, -0.4]"),
    ("slab", "[technique.ray_cast.mode.slice]\nnormal = [0.3, 1.0, -0.4]\nthickness = 0.6\ncombine = \"maximum\""),
    ("mean slab", "[technique.ray_cast.mode.slice]\nthickness = 0.4\ncombine = \"average\""),
];

/// A built-in field with holes: single voxels, a slab of infinities, and a ball of NaN.
pub fn with_holes(name: &str, dims: [usize; 3]) -> Arc<Volume> {
    let whole = sample(name, dims, VoxelType::F32);
    let grid = *whole.grid();
    let mut values = Vec::with_capacity(grid.len());
    for (z, y, x) in (0..dims[2]).flat_map(|z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| (z, y, x)))) {
        let middle = [x, y, z].iter().zip(dims).map(|(&v, n)| (v as f64 - n as f64 * 0.6).powi(2)).sum::<f64>().sqrt();
        values.push(match () {
            () if middle < dims[0] as f64 / 5.0 => f32::NAN,
            () if x == 5 => f32::INFINITY,
            () if (x * 31 + y * 17 + z * 7) % 97 == 0 => f32::NEG_INFINITY,
            () => whole.value([x, y, z], 0) as f32,
        });
    }
    Arc::new(Volume::new(grid, values).unwrap())
}
