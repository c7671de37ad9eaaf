//! Random scenes of every voxel type, over the whole range of values, for the agreement of engines.
//!
//! Transfer functions are bounded in slope: f32 rounds positions to about 1e-5 voxel and values to
//! 1e-7 of their range, and a picture may not depend on that.

use glam::{DAffine3, DMat3, DVec3, EulerRot};
use half::f16;
use pellucid_field::{Filter, Gradient, Grid, ValueMap, Volume, Voxel, VoxelType, Voxels};
use pellucid_optics::{
    Color, ColorPoint, ColorSpace, Falloff, Frame, GradientWeight, Light, LightKind, Material, OpacityPoint,
    TransferFunction,
};
use pellucid_scene::{
    Classification, Clip, Crop, Isosurface, Isovalue, Jitter, Mode, Orbit, Projection, Quality, Scene, Stage, View,
};
use proptest::collection::vec;
use proptest::prelude::*;

use super::set_mode;

/// What the values look like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texture {
    /// Every voxel by itself.
    Noise,
    /// Smooth.
    Waves,
    /// Waves in emptiness.
    Islands,
}

/// The voxels of a random volume.
#[derive(Clone, Debug)]
pub struct Data {
    /// Voxels per axis.
    pub dims: [usize; 3],
    /// Their type; values fill its range.
    pub voxel_type: VoxelType,
    /// What the values look like.
    pub texture: Texture,
    /// For different values.
    pub seed: u64,
    /// Share of absent voxels, where the type can have them.
    pub holes: f64,
    /// Scale of the data values, and the data value of 0 in ranges of the type.
    pub map: [f64; 2],
    /// Values per voxel; the last is drawn.
    pub components: usize,
    /// Spacing, Euler angles and shear.
    pub affine: [[f64; 3]; 3],
}

impl Data {
    /// The volume.
    pub fn volume(&self) -> Volume {
        let rotation = DMat3::from_euler(EulerRot::XYZ, self.affine[1][0], self.affine[1][1], self.affine[1][2]);
        let [xy, xz, yz] = self.affine[2];
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(xy, 1.0, 0.0), DVec3::new(xz, yz, 1.0));
        let matrix3 = rotation * shear * DMat3::from_diagonal(self.affine[0].into());
        let grid = Grid::with_affine(self.dims, DAffine3 { matrix3, translation: DVec3::new(3.0, -2.0, 5.0) }).unwrap();
        let [low, high] = range(self.voxel_type);
        let numbers: Vec<f64> = (0..grid.len())
            .flat_map(|voxel| (0..self.components).map(move |component| [voxel, component]))
            .map(|[voxel, component]| low + (high - low) * self.level(voxel, component))
            .collect();
        let map = ValueMap { scale: self.map[0], offset: self.map[0] * self.map[1] * (high - low) };
        let volume = Volume::with_components(grid, self.stored(&numbers), self.components).unwrap();
        volume.with_value_map(map).unwrap()
    }

    /// Value of a voxel from 0 to 1; both ends occur.
    fn level(&self, voxel: usize, component: usize) -> f64 {
        let p = [voxel % self.dims[0], voxel / self.dims[0] % self.dims[1], voxel / (self.dims[0] * self.dims[1])];
        let p = DVec3::from_array(p.map(|i| i as f64));
        let phase = (self.seed % 100) as f64 + component as f64;
        let waves = 0.5 + 0.5 * (0.43 * p.x + 0.29 * p.y + phase).sin() * (0.37 * p.z - 0.23 * p.x + phase).cos();
        match self.texture {
            Texture::Noise => (1.2 * random(self.seed, voxel * 4 + component) - 0.1).clamp(0.0, 1.0),
            Texture::Waves => waves,
            Texture::Islands => (3.0 * waves - 2.0).max(0.0),
        }
    }

    fn stored(&self, numbers: &[f64]) -> Voxels {
        fn as_type<T: Voxel>(numbers: &[f64]) -> Voxels {
            numbers.iter().map(|&v| T::from_f64(v)).collect::<Vec<T>>().into()
        }
        let absent = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        let with_holes = || -> Vec<f64> {
            let hole = |i| random(!self.seed, i) < self.holes;
            numbers.iter().enumerate().map(|(i, &v)| if hole(i) { absent[i % 3] } else { v }).collect()
        };
        match self.voxel_type {
            VoxelType::U8 => as_type::<u8>(numbers),
            VoxelType::I8 => as_type::<i8>(numbers),
            VoxelType::U16 => as_type::<u16>(numbers),
            VoxelType::I16 => as_type::<i16>(numbers),
            VoxelType::U32 => as_type::<u32>(numbers),
            VoxelType::I32 => as_type::<i32>(numbers),
            VoxelType::F16 => as_type::<f16>(&with_holes()),
            VoxelType::F32 => as_type::<f32>(&with_holes()),
        }
    }
}

/// The range of stored numbers.
fn range(voxel_type: VoxelType) -> [f64; 2] {
    match voxel_type {
        VoxelType::U8 => [0.0, 255.0],
        VoxelType::I8 => [-128.0, 127.0],
        VoxelType::U16 => [0.0, 65_535.0],
        VoxelType::I16 => [-32_768.0, 32_767.0],
        VoxelType::U32 => [0.0, 4_294_967_295.0],
        VoxelType::I32 => [-2_147_483_648.0, 2_147_483_647.0],
        VoxelType::F16 => [-65_504.0, 65_504.0],
        VoxelType::F32 => [-3.7e5, 8.1e5],
    }
}

/// A number from 0 to 1 (SplitMix64).
fn random(seed: u64, i: usize) -> f64 {
    let mut z = seed.wrapping_add((i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Random volumes. Sizes where the end of the data matters are frequent.
pub fn data() -> impl Strategy<Value = Data> {
    let size = || prop_oneof![3 => 2usize..5, 3 => 2usize..13, 1 => 1usize..40];
    let texture = prop_oneof![Just(Texture::Noise), Just(Texture::Waves), Just(Texture::Islands)];
    let affine = (
        ([0.6..2.0f64, 0.6..2.0f64, 0.6..2.0f64], any::<bool>())
            .prop_map(|([x, y, z], mirrored)| [x, y, if mirrored { -z } else { z }]),
        prop_oneof![1 => Just([0.0; 3]), 3 => [0.0..6.0f64, 0.0..6.0f64, 0.0..6.0f64]],
        [-0.4..0.4f64, -0.4..0.4f64, -0.4..0.4f64],
    );
    (
        [size(), size(), size()],
        prop::sample::select(VoxelType::ALL.to_vec()),
        texture,
        any::<u64>(),
        prop_oneof![Just(0.0), 0.0..0.15f64],
        prop_oneof![Just([1.0, 0.0]), (0.001..30.0f64, -1.0..1.0f64).prop_map(|(s, o)| [s, o]), Just([-0.37, 0.6])],
        prop_oneof![4 => Just(1usize), 1 => 2usize..4],
        affine,
    )
        .prop_map(|(dims, voxel_type, texture, seed, holes, map, components, (spacing, angles, shear))| Data {
            dims,
            voxel_type,
            texture,
            seed,
            holes,
            map,
            components,
            affine: [spacing, angles, shear],
        })
}

/// A random scene.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its volume.
    pub data: Data,
    /// Opacities at a third, two thirds and the whole of the range of values, and where they rise
    /// from 0.
    pub opacities: [f32; 3],
    /// Where the colours and opacities begin and end, as shares of the range of values.
    pub hull: [f64; 2],
    /// Colours from the smallest to the largest value, linear.
    pub colors: [[f32; 3]; 3],
    /// The camera.
    pub view: (Projection, Orbit),
    /// Light, if there is any: material, lights in volume sizes around its middle, weight.
    pub light: Option<(Material, Vec<Light>, Option<GradientWeight>)>,
    /// Clip planes by a point in shares of the box and a normal.
    pub clips: Vec<[[f64; 3]; 2]>,
    /// The part of the box that is kept, as shares.
    pub crop: Option<[f64; 3]>,
    /// Quality settings; the step is overwritten if rays would be very long.
    pub quality: Quality,
    /// Isovalues as shares of the range of values.
    pub levels: Vec<(f64, f32)>,
}

/// Random scenes in which surfaces are lit or not.
pub fn case() -> impl Strategy<Value = Case> {
    let color = || [0.0..1.0f32, 0.0..1.0f32, 0.0..1.0f32];
    let opacity = || prop_oneof![1 => Just(0.0f32), 4 => 0.0..0.8f32];
    let projection = prop_oneof![
        (5.0..80.0f64).prop_map(|vertical_fov| Projection::Perspective { vertical_fov }),
        Just(Projection::Orthographic { height: None }),
    ];
    let angles =
        prop_oneof![4 => (0.0..360.0f64, -90.0..90.0f64), 1 => (0..4u8).prop_map(|k| (90.0 * f64::from(k), 0.0))];
    let view = (projection, angles, prop_oneof![4 => 1.0..1.5f64, 1 => 1.5..30.0f64]).prop_map(
        |(projection, (azimuth, elevation), zoom)| (projection, Orbit { azimuth, elevation, zoom, ..Orbit::default() }),
    );
    let jitter = prop_oneof![Just(Jitter::Centered), any::<u32>().prop_map(|seed| Jitter::BlueNoise { seed })];
    let quality = (0.3..2.0f64, jitter, prop_oneof![3 => Just(1u32), 1 => Just(2)], any::<bool>()).prop_map(
        |(step, jitter, supersampling, early)| Quality {
            step,
            jitter,
            supersampling,
            early_termination: if early { 0.9 } else { 1.0 },
            ..Quality::default()
        },
    );
    let unit = || -1.0..1.0f64;
    (
        (data(), [opacity(), opacity(), opacity()], prop_oneof![Just([0.0, 1.0]), Just([0.2, 0.9]), Just([0.4, 1.0])]),
        ([color(), color(), color()], view, prop_oneof![Just(None), light().prop_map(Some)]),
        vec([[0.2..0.8f64, 0.2..0.8f64, 0.2..0.8f64], [unit(), unit(), 0.1..1.0f64]], 0..3),
        prop_oneof![3 => Just(None), 1 => [0.0..0.4f64, 0.0..0.4f64, 0.0..0.4f64].prop_map(Some)],
        (quality, vec((0.15..0.85f64, prop_oneof![Just(1.0f32), 0.1..0.9f32]), 1..4)),
    )
        .prop_map(|((data, opacities, hull), (colors, view, light), clips, crop, (mut quality, levels))| {
            // Half way between a voxel and a hole, rounding decides; for every ray of a pixel by itself.
            if data.holes > 0.0 {
                quality.supersampling = 1;
            }
            Case { data, opacities, hull, colors, view, light, clips, crop, quality, levels }
        })
}

fn light() -> impl Strategy<Value = (Material, Vec<Light>, Option<GradientWeight>)> {
    let material =
        (0.0..0.3f32, 0.0..0.3f32, 0.2..0.8f32, prop_oneof![Just(0.0f32), 0.0..0.4f32], 1.0..12.0f32, any::<bool>())
            .prop_map(|(emission, ambient, diffuse, specular, shininess, two_sided)| Material {
                emission,
                ambient,
                diffuse,
                specular,
                shininess,
                two_sided,
            });
    let direction = || [-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64];
    // Around the volume and outside of it.
    let position = || {
        let away = ([-1.0..1.0f64, -1.0..1.0f64, 0.8..2.0f64], any::<bool>());
        away.prop_map(|([x, y, z], below)| [x, y, if below { -z } else { z }])
    };
    let falloff =
        || prop_oneof![Just(Falloff::None), (0.5..1.5f64).prop_map(|reference| Falloff::InverseSquare { reference })];
    let kind = prop_oneof![
        direction().prop_map(|direction| LightKind::Directional { direction }),
        (position(), falloff()).prop_map(|(position, falloff)| LightKind::Point { position, falloff }),
        (position(), falloff(), 0.0..30.0f64, 25.0..60.0f64).prop_map(|(position, falloff, inner_angle, soft)| {
            let outer_angle = inner_angle + soft;
            LightKind::Spot { position, direction: position.map(|x| -x), inner_angle, outer_angle, falloff }
        }),
    ];
    let one = (kind, [0.0..1.0f32, 0.0..1.0f32, 0.0..1.0f32], 0.2..1.0f32, any::<bool>(), any::<bool>()).prop_map(
        |(kind, color, intensity, camera, specular)| Light {
            kind,
            color: Color::new(color).unwrap(),
            intensity,
            frame: if camera && matches!(kind, LightKind::Directional { .. }) { Frame::Camera } else { Frame::World },
            specular,
        },
    );
    let weight = prop_oneof![
        2 => Just(None),
        1 => (0.0..0.1f32, 0.2..0.6f32).prop_map(|(low, high)| Some(GradientWeight { low, high })),
    ];
    (material, vec(one, 1..4), weight)
}

/// Columns and rows of a picture: no multiples of what engines work on at once.
pub const PICTURE: [u32; 2] = [13, 11];

impl Case {
    /// The stage under a mode and a classification, with or without skipping.
    pub fn stage(&self, mode: &Mode, classification: Classification, skipping: bool) -> Stage {
        let volume = self.data.volume();
        let statistics = *volume.statistics();
        let low = statistics.min;
        // Wide enough for the control points to be apart, in levels and beside the rounding of values.
        let largest = low.abs().max(statistics.max.abs());
        let range = (statistics.max - low).max(30.0 * self.data.map[0].abs()).max(0.05 * largest);
        let grid = *volume.grid();
        let inside = |share: [f64; 3]| {
            let (low, high) = grid.index_bounds();
            low + (high - low) * DVec3::from_array(share)
        };
        let radius = (grid.world_corners()[0] - grid.center()).length();
        let stage = super::stage(volume, self.transfer_function(low, range), |scene| {
            [scene.image.width, scene.image.height] = PICTURE;
            set_mode(scene, self.leveled(mode, low, range));
            (scene.camera.projection, scene.camera.view) = (self.view.0, View::Orbit(self.view.1));
            scene.quality = Quality { classification, empty_space_skipping: skipping, ..self.quality.clone() };
            scene.volumes[0].component = self.data.components - 1;
            self.illuminate(scene, &grid, radius, range);
            let plane = |[share, normal]: [[f64; 3]; 2]| Clip::Plane {
                point: grid.world_from_index().transform_point3(inside(share)).to_array(),
                normal,
            };
            scene.clips = self.clips.iter().copied().map(plane).collect();
            let crop = |from: [f64; 3]| Crop {
                from: inside(from).to_array(),
                to: inside(from.map(|share| share + 0.55)).to_array(),
            };
            scene.volumes[0].crop = self.crop.map(crop);
        });
        // However long the box, some hundred samples are enough.
        Stage { step: stage.step.max(radius / 60.0), ..stage }
    }

    /// The optics over values from `low` on. Control points lie on nodes of the tables that engines
    /// look up, whose resolution is not the question here: at levels of integers, and at multiples
    /// of 1/253 of the hull.
    fn transfer_function(&self, low: f64, range: f64) -> TransferFunction {
        let at = |share: f64| {
            let value = range * (self.hull[0] + (self.hull[1] - self.hull[0]) * share / 253.0);
            let spacing = self.data.map[0].abs();
            low + if self.data.voxel_type.is_integer() { (value / spacing).round() * spacing } else { value }
        };
        let colors = [0.0, 126.0, 253.0].into_iter().zip(self.colors);
        let colors = colors.map(|(share, color)| ColorPoint::new(at(share), Color::new(color).unwrap()));
        let opacities = [0.0, 84.0, 168.0, 253.0].into_iter().zip([0.0].into_iter().chain(self.opacities));
        let opacities = opacities.map(|(share, opacity)| OpacityPoint::new(at(share), opacity));
        let tf = TransferFunction::new(colors.collect(), opacities.collect()).unwrap();
        tf.with_color_space(ColorSpace::Linear).with_unit_distance(Some(1.7)).unwrap()
    }

    fn leveled(&self, mode: &Mode, low: f64, range: f64) -> Mode {
        let level = |&(share, opacity): &(f64, f32)| Isovalue { value: low + range * share, color: None, opacity };
        match mode {
            Mode::Isosurface(_) => Mode::Isosurface(Isosurface { isovalues: self.levels.iter().map(level).collect() }),
            other => other.clone(),
        }
    }

    fn illuminate(&self, scene: &mut Scene, grid: &Grid, radius: f64, range: f64) {
        let Some((material, lights, weight)) = &self.light else { return };
        let placed = |position: [f64; 3]| (grid.center() + DVec3::from_array(position) * 2.0 * radius).to_array();
        let scaled = |falloff| match falloff {
            Falloff::InverseSquare { reference } => Falloff::InverseSquare { reference: reference * radius },
            Falloff::None => Falloff::None,
        };
        let light = |light: &Light| {
            let kind = match light.kind {
                LightKind::Point { position, falloff } => {
                    LightKind::Point { position: placed(position), falloff: scaled(falloff) }
                }
                LightKind::Spot { position, direction, inner_angle, outer_angle, falloff } => {
                    let (position, falloff) = (placed(position), scaled(falloff));
                    LightKind::Spot { position, direction, inner_angle, outer_angle, falloff }
                }
                directional => directional,
            };
            Light { kind, ..*light }
        };
        scene.lighting.lights = lights.iter().map(light).collect();
        scene.volumes[0].shading = Some(true);
        scene.volumes[0].material = Some(*material);
        let weight = weight.map(|w| GradientWeight { low: w.low * range as f32, high: w.high * range as f32 });
        scene.volumes[0].gradient_weight = weight;
    }

    /// The same scene with a transfer function of straight curves over all values. How closely tables
    /// follow bends is not the question here.
    pub fn straight(mut self) -> Self {
        let [first, middle, last] = &mut self.opacities;
        // The curve starts at 0.
        (*first, *middle) = (*last * (84.0 / 253.0), *last * (168.0 / 253.0));
        let [first, middle, last] = &mut self.colors;
        (0..3)
            .for_each(|channel| middle[channel] = first[channel] + (last[channel] - first[channel]) * (126.0 / 253.0));
        self.hull = [0.0, 1.0];
        self
    }

    /// The same scene under other reconstructions.
    pub fn reconstructed(mut self, filter: Filter, gradient: Gradient) -> Self {
        (self.quality.filter, self.quality.gradient) = (filter, gradient);
        if filter == Filter::Nearest {
            // As beside holes.
            self.quality.supersampling = 1;
        }
        self
    }
}
