//! What shaders are told of a frame: the structures of `frame.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3};
use pellucid_field::Grid;
use pellucid_optics::{Material, Nodes};
use pellucid_plan::{Merging, blue_noise_shift};
use pellucid_scene::{Jitter, Mode, Overlap, Region, Slice, Stage, StageVolume};

use crate::four::Four;
use crate::noise::Noise;
use crate::scattering::HEADER;
use crate::window::Window;

/// What a frame is drawn with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Frame {
    pub origin_middle: Four,
    pub origin_right: Four,
    pub origin_up: Four,
    pub direction_middle: Four,
    pub direction_right: Four,
    pub direction_up: Four,
    pub world_middle: Four,
    pub world_right: Four,
    pub world_up: Four,
    pub low: Four,
    pub high: Four,
    pub gradient_x: Four,
    pub gradient_y: Four,
    pub gradient_z: Four,
    pub world_x: Four,
    pub world_y: Four,
    pub world_z: Four,
    pub picture: Four,
    pub values: Four,
    pub material: Four,
    pub limits: Four,
    pub plane: Four,
    pub plane_normal: Four,
    pub shadows: Four,
    pub points_x: Four,
    pub points_y: Four,
    pub points_z: Four,
    pub chroma: Four,
    pub table: Four,
    pub size: [u32; 4],
    pub dims: [u32; 4],
    pub blocks: [u32; 4],
    pub light_count: u32,
    pub plane_count: u32,
    pub level_count: u32,
    pub two_sided: u32,
    pub jitter: [u32; 4],
    pub stack: [u32; 4],
    pub lists: [u32; 4],
    pub overlap: [u32; 4],
    pub scattering: [Four; HEADER],
    pub noise: Noise,
}

/// An isosurface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Level {
    pub color: Four,
    pub value: Four,
}

/// What a ray has found so far.
pub const STATE_BYTES: u64 = 64;

/// Where slices lie, and how they are drawn.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Slices {
    pub plane: Four,
    pub strides: Four,
    pub clip_x: Four,
    pub clip_y: Four,
    pub clip_w: Four,
    pub margin: Four,
    pub eye: Four,
    pub counts: [u32; 4],
}

/// A pixel as it comes back.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Pixel {
    pub color: Four,
    pub surface: Four,
    pub counts: [u32; 4],
}

/// The same where colours from behind are held back each in its own way.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ChromaticPixel {
    pub pixel: Pixel,
    pub held_back: Four,
}

impl Frame {
    /// The parts that camera, grid, clips and optics give; the rest is the volume's and the tables'.
    pub fn new(stage: &Stage, volume: &StageVolume, region: &Region) -> Self {
        let grid = volume.volume.grid();
        let mut frame = Self::default();
        frame.set_rays(stage, grid);
        frame.set_grid(grid);
        let view = &stage.viewpoint;
        let [left, top] = [view.width as f64 / 2.0 - view.shift.x, view.height as f64 / 2.0 - view.shift.y];
        let pixel = 2.0 * view.half_height / view.height as f64;
        frame.picture = [left, top, pixel, stage.step].map(|v| v as f32);
        // What scatters as a cloud reflects as any surface, as far as it is one.
        if let Some(material) = volume.material.or_else(|| stage.scatters().then(Material::default)) {
            frame.set_material(&material, stage.ambient);
        }
        if let Some(weight) = &volume.gradient_weight {
            frame.limits[0] = weight.low;
            frame.limits[1] = 1.0 / (weight.high - weight.low);
        }
        frame.limits[2] = stage.quality.early_termination;
        frame.limits[3] = (stage.step / volume.unit_distance()) as f32;
        frame.size = [view.width as u32, 0, stage.quality.supersampling, u32::from(view.perspective)];
        if let Some(length) = stage.shadow_step(volume) {
            let away = stage.shadow_offset(volume, length);
            frame.shadows = [length, length / stage.step, away, 0.0].map(|v| v as f32);
        }
        let [r, g, b] = stage.chroma(volume).map_or([1.0; 3], |chroma| chroma.ratios);
        frame.chroma = [r, g, b, 0.0];
        frame.overlap = match Merging::of(stage) {
            Merging::Overlap(Overlap::Add) => [0; 4],
            Merging::Overlap(Overlap::Maximum) => [1, 0, 0, 0],
            Merging::Overlap(Overlap::Priority) => [2, 0, 0, 0],
            Merging::Overlap(Overlap::Fused { color, opacity }) => [3, color as u32, opacity as u32, 0],
            Merging::Sum => [4, 0, 0, 0],
        };
        frame.light_count = stage.lights.len() as u32;
        frame.plane_count = region.half_spaces().len() as u32;
        if let Mode::Slice(slice) = stage.mode() {
            frame.set_plane(stage, volume, slice);
        }
        if let Jitter::BlueNoise { seed } = stage.quality.jitter {
            let [x, y] = blue_noise_shift(seed);
            frame.jitter = [x, y, 1, 0];
        }
        frame
    }

    /// Rays count from the plane across the view in which the first of the volumes begins: from a far eye, single
    /// precision would blur where they enter. Their lengths are in steps, as those of the world may be
    /// too long or too short for single precision.
    fn set_rays(&mut self, stage: &Stage, grid: &Grid) {
        let view = &stage.viewpoint;
        let depths = corners(stage).map(|corner| (corner - view.eye).dot(view.forward));
        let base = depths.fold(f64::INFINITY, f64::min).max(0.0);
        let index = |v: DVec3| grid.index_from_world().transform_vector3(v);
        let step = stage.step;
        let middle = grid.index_from_world().transform_point3(view.eye + view.forward * base);
        let nothing = DVec3::ZERO;
        // Rays of a perspective leave one point, others one direction.
        let (across, turning) = if view.perspective { (base, 1.0) } else { (1.0, 0.0) };
        self.origin_middle = four(middle, base / step);
        self.origin_right = four(index(view.right * across), 0.0);
        self.origin_up = four(index(view.up * across), 0.0);
        let [right, up] = if turning == 1.0 { [view.right, view.up] } else { [nothing; 2] };
        self.direction_middle = four(index(view.forward * step), 0.0);
        self.direction_right = four(index(right * step), 0.0);
        self.direction_up = four(index(up * step), 0.0);
        self.world_middle = four(view.forward, 0.0);
        self.world_right = four(right, 0.0);
        self.world_up = four(up, 0.0);
    }

    fn set_grid(&mut self, grid: &Grid) {
        let (low, high) = grid.index_bounds();
        (self.low, self.high) = (four(low, 0.0), four(high, 0.0));
        [self.gradient_x, self.gradient_y, self.gradient_z] =
            rows(DAffine3 { matrix3: grid.world_from_index_gradient(), translation: DVec3::ZERO });
        [self.world_x, self.world_y, self.world_z] = rows(grid.world_from_index());
        let [x, y, z] = grid.dims().map(|n| n as u32);
        self.dims = [x, y, z, 0];
    }

    fn set_plane(&mut self, stage: &Stage, volume: &StageVolume, slice: &Slice) {
        let (point, normal) = stage.slice_plane(volume, slice);
        let grid = volume.volume.grid();
        let across = (grid.world_from_index().matrix3.transpose() * normal).normalize();
        self.plane = four(across, across.dot(grid.index_from_world().transform_point3(point)));
        self.plane_normal = four(normal, 0.0);
    }

    /// How samples reflect, and the ambient light on them.
    pub fn set_material(&mut self, material: &Material, ambient: f32) {
        let unlit = material.emission + material.ambient * ambient;
        self.material = [unlit, material.diffuse, material.specular, material.shininess];
        self.two_sided = u32::from(material.two_sided);
    }

    /// How many points light volumes have across their last axis, and where a grid's voxels are in their box.
    pub fn set_light_points(&mut self, depth: usize, part_from_index: DAffine3) {
        self.shadows[3] = depth as f32;
        [self.points_x, self.points_y, self.points_z] = rows(part_from_index);
    }

    /// Which part of the picture is drawn.
    pub fn set_window(&mut self, window: &Window) {
        (self.size[0], self.size[1]) = (window.size[0], window.low[0]);
    }

    /// How stored numbers become data values: `stored * scale + offset`.
    pub fn set_values(&mut self, [scale, offset]: [f64; 2]) {
        (self.values[0], self.values[1]) = (scale as f32, offset as f32);
    }

    /// Where the entries of the table are, and behind them, from a place on, the rows that tell so if they are not even.
    pub fn set_nodes(&mut self, nodes: &Nodes, knots: u64) {
        (self.values[2], self.values[3]) = (nodes.origin(), nodes.scale());
        self.dims[3] = nodes.count() as u32;
        let [low, high] = nodes.ends();
        self.table = [low, high, nodes.knots().len() as f32, knots as f32];
    }

    /// How much data values would rise over the first voxel behind a cut: by the width of the transfer function. Not
    /// set where cuts are not lit by their faces.
    pub fn set_rise(&mut self, nodes: &Nodes) {
        let [low, high] = nodes.domain();
        self.gradient_x[3] = if high > low { (high - low) as f32 } else { 1.0 };
    }

    /// How many blocks there are, of how many cells.
    pub fn set_blocks(&mut self, [x, y, z]: [usize; 3], size: usize) {
        self.blocks = [x, y, z, size].map(|n| n as u32);
    }
}

/// The corners of all volumes in the world.
pub fn corners(stage: &Stage) -> impl Iterator<Item = DVec3> {
    stage.volumes.iter().flat_map(|volume| volume.volume.grid().world_corners())
}

/// The half-spaces of a region in voxels: `normal . p >= offset`, the normals of length 1.
pub fn planes(region: &Region, grid: &Grid) -> Vec<Four> {
    let world = grid.world_from_index();
    let plane = |&(normal, offset): &(DVec3, f64)| {
        let across = world.matrix3.transpose() * normal;
        let length = across.length();
        four(across / length, (offset - normal.dot(world.translation)) / length)
    };
    region.half_spaces().iter().map(plane).collect()
}

pub fn four(v: DVec3, w: f64) -> Four {
    v.extend(w).as_vec4().to_array()
}

/// The rows of a matrix.
pub fn rows(DAffine3 { matrix3, translation }: DAffine3) -> [Four; 3] {
    let matrix = matrix3.transpose();
    [four(matrix.x_axis, translation.x), four(matrix.y_axis, translation.y), four(matrix.z_axis, translation.z)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::{EyeBounds, LightBounds, PathBounds, PointBounds, RayBounds, Rows, Run};
    use crate::half_angle::Sweep;
    use crate::lights::{Extent, Light};
    use crate::noise::Term;
    use crate::path_trace::Paths;
    use crate::shaders::{self, Constants, Linker, Traversal, Variant};
    use crate::slicing::SliceBox;
    use std::mem::offset_of;
    use wgpu::naga::{Module, TypeInner};

    /// Members of a structure of a shader with their offsets, and its size.
    fn layout(module: &Module, name: &str) -> (Vec<(String, usize)>, usize) {
        let found = module.types.iter().map(|(_, ty)| ty).find(|ty| {
            // Imported names come with that of their module behind them.
            ty.name.as_deref().is_some_and(|full| full == name || full.starts_with(&format!("{name}X_naga")))
        });
        let Some(TypeInner::Struct { members, span }) = found.map(|ty| &ty.inner) else {
            panic!("no structure {name} among {:?}", module.types.iter().map(|(_, ty)| &ty.name).collect::<Vec<_>>());
        };
        let member = |m: &wgpu::naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset as usize);
        (members.iter().map(member).collect(), *span as usize)
    }

    fn linked(variant: Variant) -> Module {
        Linker::default().link(&[variant], Constants::Uniform).unwrap()
    }

    macro_rules! fields {
        ($ty:ident: $($field:ident)*) => {
            (vec![$((stringify!($field).to_owned(), offset_of!($ty, $field))),*], size_of::<$ty>())
        };
    }

    #[test]
    fn structures_are_those_of_the_shaders() {
        let shaded = linked(Variant { shaded: true, ..Variant::of(shaders::Pass::Isosurface) });
        let resolve = linked(Variant::of(shaders::Pass::Resolve));
        let frame = fields!(Frame: origin_middle origin_right origin_up direction_middle direction_right direction_up
            world_middle world_right world_up low high gradient_x gradient_y gradient_z world_x world_y world_z
            picture values material limits plane plane_normal shadows
            points_x points_y points_z chroma table size dims blocks light_count
            plane_count level_count two_sided jitter stack lists overlap scattering noise);
        assert_eq!(layout(&shaded, "Frame"), frame);
        let rays = fields!(RayBounds: rows texture_low most_looks core_low list core_high list_length);
        assert_eq!(layout(&shaded, "Bounds"), rays);
        assert_eq!(layout(&shaded, "Rows"), fields!(Rows: first count ray begin));
        assert_eq!(layout(&shaded, "Light"), fields!(Light: place radiance axis cone extent));
        assert_eq!(layout(&shaded, "Level"), fields!(Level: color value));
        let sliced = linked(Variant { traversal: Traversal::Slices, ..Variant::of(shaders::Pass::Composite) });
        let pixels = Variant { traversal: Traversal::SlicePixels, ..Variant::of(shaders::Pass::Average) };
        let slices = fields!(Slices: plane strides clip_x clip_y clip_w margin eye counts);
        assert_eq!(layout(&sliced, "Slices"), slices);
        assert_eq!(layout(&sliced, "Box"), fields!(SliceBox: low high));
        assert_eq!(layout(&linked(pixels), "Pixel"), fields!(Pixel: color surface counts));
        let sweep = fields!(Sweep: slabs texel_x texel_y depth origin_middle origin_right origin_up direction_middle
            direction_right direction_up plane ways blur scales cone taps size counts light);
        let eye = linked(Variant::of(shaders::Pass::HalfAngleEye).canonical());
        assert_eq!(layout(&eye, "Sweep"), sweep);
        assert_eq!(layout(&eye, "Bounds"), fields!(EyeBounds: rows run begin_sweep));
        assert_eq!(layout(&eye, "Run"), fields!(Run: first end layers layer));
        let light = linked(Variant { indirect: true, ..Variant::of(shaders::Pass::HalfAngleLight) }.canonical());
        assert_eq!(layout(&light, "Bounds"), fields!(LightBounds: low high tap slab));
        let points = linked(Variant::of(shaders::Pass::LightPoints).canonical());
        assert_eq!(layout(&points, "Bounds"), fields!(PointBounds: low high run size first));
        let paths = fields!(Paths: counts more numbers top bottom picture picture_size surface chroma index_x index_y index_z lens_right lens_up first_x first_y first_z own_x own_y own_z);
        let trace = linked(Variant::of(shaders::Pass::PathTrace).canonical());
        assert_eq!(layout(&trace, "Paths"), paths);
        assert_eq!(layout(&trace, "Bounds"), fields!(PathBounds: rows));
        assert_eq!(layout(&trace, "Extent"), fields!(Extent: kind first second normal));
        let noisy = Variant { perturbed: true, ..Variant::of(shaders::Pass::Composite) };
        let noisy = linked(noisy);
        assert_eq!(layout(&noisy, "Noise"), fields!(Noise: amplitude reach spacing between weights counts terms));
        assert_eq!(layout(&noisy, "Term"), fields!(Term: scale start));
        assert_eq!(layout(&resolve, "Pixel"), fields!(Pixel: color surface counts));
        assert_eq!(layout(&resolve, "State").1 as u64, STATE_BYTES);
    }
}
