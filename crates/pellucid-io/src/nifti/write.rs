//! NIfTI-1 files from volumes.

use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DAffine3, DVec3};
use pellucid_field::{ValueMap, Volume, VoxelType, Warning};

use super::geometry::qform;
use super::header::SIZE_1;
use crate::body::{Wide, write_interleaved, write_planar, written_type};
use crate::options::is_gzip_name;
use crate::world::{Frame, millimetres, to_world};
use crate::{AtomicFile, IoError, WriteOptions};

/// Header and the four bytes that say that there are no extensions.
const DATA_OFFSET: usize = SIZE_1 + 4;

/// Writes a volume as a single file, compressed if the name ends in `.gz`.
pub(crate) fn write(path: &Path, volume: &Volume, options: &WriteOptions) -> Result<Vec<Warning>, IoError> {
    let mut warnings = Vec::new();
    let header = header(path, volume, &mut warnings)?;
    let mut file = AtomicFile::create(path)?;
    if is_gzip_name(path) {
        let level = options.compression.unwrap_or(6).clamp(1, 9);
        let mut encoder = GzEncoder::new(&mut file, Compression::new(level.into()));
        write_all(&mut encoder, &header, volume).and_then(|()| encoder.finish().map(drop))
    } else {
        write_all(&mut file, &header, volume)
    }
    .map_err(IoError::io(path))?;
    file.commit()?;
    Ok(warnings)
}

fn write_all(out: &mut impl Write, header: &[u8], volume: &Volume) -> io::Result<()> {
    out.write_all(header)?;
    if is_colour(volume) { write_interleaved(out, volume) } else { write_planar(out, volume) }
}

/// Whether the volume is what the format calls RGB24 or RGBA32.
fn is_colour(volume: &Volume) -> bool {
    volume.voxels().voxel_type() == VoxelType::U8 && volume.components() >= 3
}

fn header(path: &Path, volume: &Volume, warnings: &mut Vec<Warning>) -> Result<[u8; DATA_OFFSET], IoError> {
    let mut bytes = [0; DATA_OFFSET];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    let wide = Wide::of(volume);
    let (datatype, size) = match (written_type(volume, warnings), volume.components()) {
        _ if wide.is_some_and(|wide| wide.is_integer()) => (1024i16, 8),
        _ if wide.is_some() => (64, 8),
        (VoxelType::U8, 3) => (128, 3),
        (VoxelType::U8, 4) => (2304, 4),
        (VoxelType::U8, _) => (2, 1),
        (VoxelType::I8, _) => (256, 1),
        (VoxelType::U16, _) => (512, 2),
        (VoxelType::I16, _) => (4, 2),
        (VoxelType::U32, _) => (768, 4),
        (VoxelType::I32, _) => (8, 4),
        (VoxelType::F16 | VoxelType::F32, _) => (16, 4),
    };
    put(0, &(SIZE_1 as i32).to_ne_bytes());
    let is_vector = volume.components() > 1 && !is_colour(volume);
    let grid = volume.grid();
    let mut dim = [if is_vector { 5 } else { 3 }, 1, 1, 1, 1, 1, 1, 1i16];
    for (n, &size) in dim[1..].iter_mut().zip(&grid.dims()) {
        *n = i16::try_from(size).map_err(|_| {
            let advice = "NIfTI-1 has at most 32767 voxels along an axis; write NRRD or MetaImage";
            IoError::unsupported(path, "axis of", size, advice)
        })?;
    }
    if is_vector {
        dim[5] = volume.components() as i16;
        put(68, &1007i16.to_ne_bytes());
    }
    put(40, bytemuck::cast_slice(&dim.map(i16::to_ne_bytes)));
    put(70, &datatype.to_ne_bytes());
    put(72, &(size as i16 * 8).to_ne_bytes());

    let (unit, scale) = match volume.length_unit.as_deref() {
        None => (0, 1.0),
        Some("mm") => (2, 1.0),
        Some("m") => (1, 1.0),
        Some("um") => (3, 1.0),
        Some(unit) => match millimetres(unit) {
            Some(scale) => (2, scale),
            None => {
                warnings.push(Warning::File(format!("NIfTI has no code for the unit of length '{unit}'")));
                (0, 1.0)
            }
        },
    };
    // The way from LPS to RAS is the way back.
    let affine = to_world(grid.world_from_index(), Frame::Ras, scale);
    warn_of_rounding(volume, affine, warnings);
    let q = qform(affine);
    let spacing = grid.spacing().map(|spacing| (spacing * scale) as f32);
    let pixdim = [q.map_or(1.0, |(_, side)| side as f32), spacing[0], spacing[1], spacing[2], 1.0, 1.0, 1.0, 1.0];
    put(76, bytemuck::cast_slice(&pixdim));
    put(108, &(DATA_OFFSET as f32).to_ne_bytes());
    let map = if wide.is_some() { ValueMap::IDENTITY } else { volume.value_map() };
    put(112, bytemuck::cast_slice(&[map.scale as f32, map.offset as f32]));
    put(123, &[unit]);
    put(148, b"pellucid");
    put(252, &i16::from(q.is_some()).to_ne_bytes());
    put(254, &1i16.to_ne_bytes());
    let offset = affine.translation.as_vec3().to_array();
    let quatern = q.map_or([0.0; 3], |(quatern, _)| quatern).map(|part| part as f32);
    put(256, bytemuck::cast_slice(&[quatern, offset]));
    for row in 0..3 {
        let m = affine.matrix3.row(row).as_vec3();
        put(280 + 16 * row, bytemuck::cast_slice(&[m.x, m.y, m.z, offset[row]]));
    }
    put(344, b"n+1\0");

    if f64::from(map.scale as f32) != map.scale || f64::from(map.offset as f32) != map.offset {
        let (found, kept) = (format!("{} and {}", map.scale, map.offset), (map.scale as f32, map.offset as f32));
        let line = format!("slope and intercept {found} are rounded to single precision, {} and {}", kept.0, kept.1);
        warnings.push(Warning::File(line));
    }
    if let Some(unit) = &volume.value_unit {
        warnings.push(Warning::File(format!("NIfTI has no field for the unit of the values, '{unit}'")));
    }
    if let Some(description) = &volume.description {
        warnings.push(Warning::File(format!("NIfTI has no room for a description, '{description}'")));
    }
    Ok(bytes)
}

/// NIfTI-1 holds positions in single precision.
fn warn_of_rounding(volume: &Volume, affine: DAffine3, warnings: &mut Vec<Warning>) {
    let single = |v: DVec3| v.as_vec3().as_dvec3();
    let mut rounded = affine;
    rounded.translation = single(affine.translation);
    for axis in 0..3 {
        *rounded.matrix3.col_mut(axis) = single(affine.matrix3.col(axis));
    }
    let corners = (0..8).map(|corner| {
        let dims = volume.grid().dims();
        DVec3::from_array(std::array::from_fn(|axis| ((corner >> axis & 1) * (dims[axis] - 1)) as f64))
    });
    let shift = corners.map(|p| affine.transform_point3(p).distance(rounded.transform_point3(p))).fold(0.0, f64::max);
    if shift > 0.0 {
        let line = format!("positions are rounded to single precision: a voxel moves by up to {shift:.2e}");
        warnings.push(Warning::File(line));
    }
}
