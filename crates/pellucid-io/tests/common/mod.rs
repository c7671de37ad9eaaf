//! What the tests of several formats share.
#![allow(dead_code, reason = "every test file uses its own part")]

pub mod ledger;
pub mod mutate;
pub mod nifti;
pub mod seeds;

use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use half::f16;
use pellucid_field::{Grid, Volume, VoxelType, Voxels, Warning};
use pellucid_io::{IoError, Loaded, ReadOptions, read_bytes};

pub fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<Loaded, IoError> {
    read_bytes(name, bytes.as_ref().to_vec(), &ReadOptions::default())
}

/// All stored numbers.
pub fn stored(volume: &Volume) -> Vec<f64> {
    (0..volume.voxels().len()).map(|index| volume.voxels().get(index)).collect()
}

/// The one message of an error.
pub fn message(result: Result<Loaded, IoError>) -> String {
    result.map(|loaded| loaded.volume.grid().dims()).expect_err("must fail").to_string()
}

pub fn texts(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(Warning::to_string).collect()
}

/// A rotated, mirrored grid with three different spacings.
pub fn oblique(dims: [usize; 3]) -> Grid {
    let rotation = DMat3::from_quat(DQuat::from_euler(EulerRot::XYZ, 0.3, -0.7, 1.9));
    let matrix3 = rotation * DMat3::from_diagonal(DVec3::new(0.7, -1.3, 2.1));
    Grid::with_affine(dims, DAffine3 { matrix3, translation: DVec3::new(-120.3, 45.7, 1e3 / 3.0) }).unwrap()
}

/// A sheared, mirrored grid whose numbers are exact in single precision.
pub fn dyadic(dims: [usize; 3]) -> Grid {
    let matrix3 =
        DMat3::from_cols(DVec3::new(0.5, 0.25, 0.0), DVec3::new(0.0, -1.75, 0.125), DVec3::new(-0.0625, 0.0, 3.0));
    Grid::with_affine(dims, DAffine3 { matrix3, translation: DVec3::new(-100.5, 7.25, 0.375) }).unwrap()
}

/// `count` values that reach both ends of their type, and all that floats can be.
pub fn extremes(voxel_type: VoxelType, count: usize) -> Voxels {
    fn cycle<T: Copy>(values: &[T], count: usize) -> Vec<T> {
        values.iter().copied().cycle().take(count).collect()
    }
    let singles = [0.0, -0.0, 1.5, f32::MIN, f32::MAX, f32::MIN_POSITIVE / 8.0, f32::NAN, f32::INFINITY, -7.25e-3];
    match voxel_type {
        VoxelType::U8 => cycle(&[0, 1, 127, 128, 255, 42u8], count).into(),
        VoxelType::I8 => cycle(&[0, -1, 127, -128, 5i8], count).into(),
        VoxelType::U16 => cycle(&[0, 1, 255, 256, 0x1234, 65535u16], count).into(),
        VoxelType::I16 => cycle(&[0, -1, -1024, 3071, i16::MIN, i16::MAX, 0x1234], count).into(),
        VoxelType::U32 => cycle(&[0, 1, 0x1234_5678, u32::MAX], count).into(),
        VoxelType::I32 => cycle(&[0, -1, 0x1234_5678, i32::MIN, i32::MAX], count).into(),
        VoxelType::F16 => cycle(&[f16::ZERO, f16::MIN, f16::MAX, f16::from_f32(-0.1), f16::INFINITY], count).into(),
        VoxelType::F32 => cycle(&singles, count).into(),
    }
}

/// Largest difference of two affines, relative to the largest number in them.
pub fn affine_error(a: DAffine3, b: DAffine3) -> f64 {
    let (a, b) = (a.to_cols_array(), b.to_cols_array());
    let scale = a.iter().fold(0f64, |scale, number| scale.max(number.abs()));
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}
