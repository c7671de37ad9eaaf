//! Random volumes of every voxel type, over the whole range of values, with the sizes, holes, value
//! maps and shapes that kernels have to get right.

use glam::{DAffine3, DMat3, DVec3, EulerRot};
use half::f16;
use pellucid_field::{Grid, ValueMap, Volume, Voxel, VoxelType, Voxels};
use proptest::prelude::*;

/// What the values look like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texture {
    /// Every voxel by itself.
    Noise,
    /// Smooth.
    Waves,
    /// Waves in emptiness.
    Islands,
    /// Cubes of noise in emptiness, a few voxels apart from the borders of the blocks that engines
    /// leap over, or at them.
    Crumbs,
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
        let noise = (1.2 * random(self.seed, voxel * 4 + component) - 0.1).clamp(0.0, 1.0);
        let phase = (self.seed % 100) as f64 + component as f64;
        let waves = 0.5 + 0.5 * (0.43 * p.x + 0.29 * p.y + phase).sin() * (0.37 * p.z - 0.23 * p.x + phase).cos();
        match self.texture {
            Texture::Noise => noise,
            Texture::Waves => waves,
            Texture::Islands => (3.0 * waves - 2.0).max(0.0),
            Texture::Crumbs => {
                let cube = ((p + (self.seed % 4) as f64) / 4.0).floor();
                let full = random(self.seed, (cube.x + 16.0 * cube.y + 256.0 * cube.z) as usize) < 0.06;
                if full { noise } else { 0.0 }
            }
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
