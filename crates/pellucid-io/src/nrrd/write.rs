//! NRRD files from volumes.

use std::path::Path;

use glam::DVec3;
use pellucid_field::{ValueMap, Volume, VoxelType, Warning};

use crate::body::{DataFile, Files, Packing, Wide, align, written_type};
use crate::options::plain_extension;
use crate::{Endian, IoError, WriteOptions};

/// Writes a volume; as a detached header with data beside it if the extension is `.nhdr`.
pub(crate) fn write(path: &Path, volume: &Volume, options: &WriteOptions) -> Result<Vec<Warning>, IoError> {
    let mut warnings = Vec::new();
    let (packing, encoding, data_extension) = match options.compression {
        None => (Packing::Plain, "raw", "raw"),
        Some(level) => (Packing::Gzip(level), "gzip", "raw.gz"),
    };
    let data_file = (plain_extension(path) == "nhdr").then(|| DataFile::of(path, data_extension)).transpose()?;
    let grid = volume.grid();
    let [x, y, z] = grid.dims();
    let affine = grid.world_from_index();
    let (a, b, c) = (affine.matrix3.x_axis, affine.matrix3.y_axis, affine.matrix3.z_axis);
    let directions = format!("{} {} {}", vector(a), vector(b), vector(c));
    let voxel_type = written_type(volume, &mut warnings);

    let mut header = "NRRD0005\n".to_owned();
    let mut field = |name: &str, value: &str| header.extend([name, ": ", value, "\n"]);
    let wide = Wide::of(volume);
    let type_name = match wide {
        Some(wide) if wide.is_integer() => "int64",
        Some(_) => "double",
        None => type_name(voxel_type),
    };
    if let Some(description) = &volume.description {
        field("content", &one_line(description));
    }
    field("type", type_name);
    if volume.is_anatomical {
        field("space", "left-posterior-superior");
    } else {
        field("space dimension", "3");
    }
    if let Some(unit) = &volume.length_unit {
        let unit = one_line(unit);
        field("space units", &format!("\"{unit}\" \"{unit}\" \"{unit}\""));
    }
    match volume.components() {
        1 => {
            field("dimension", "3");
            field("sizes", &format!("{x} {y} {z}"));
            field("kinds", "domain domain domain");
            field("space directions", &directions);
        }
        n => {
            let kind = match (n, voxel_type) {
                (3, VoxelType::U8) => "RGB-color",
                (4, VoxelType::U8) => "RGBA-color",
                _ => "vector",
            };
            field("dimension", "4");
            field("sizes", &format!("{n} {x} {y} {z}"));
            field("kinds", &format!("{kind} domain domain domain"));
            field("space directions", &format!("none {directions}"));
        }
    }
    field("space origin", &vector(affine.translation));
    field("endian", if Endian::NATIVE == Endian::Little { "little" } else { "big" });
    field("encoding", encoding);
    if let Some(unit) = &volume.value_unit {
        field("sample units", &format!("\"{}\"", one_line(unit)));
    }
    if let Some(DataFile { name, .. }) = &data_file {
        field("data file", name);
    }
    let map = volume.value_map();
    if map != ValueMap::IDENTITY && wide.is_none() {
        header.push_str(&format!("value scale:={}\nvalue offset:={}\n", map.scale, map.offset));
        warnings.push(Warning::File(format!(
            "NRRD has no field for 'value = {} x stored + {}': it is kept as key/value pairs that other programs ignore",
            map.scale, map.offset
        )));
    }
    align(&mut header, "#", 1);
    header.push('\n');
    let (header, data_file) = (header.as_bytes(), data_file.as_ref());
    Files { path, header, size_at: None, data_file, packing }.write(volume)?;
    Ok(warnings)
}

fn type_name(voxel_type: VoxelType) -> &'static str {
    match voxel_type {
        VoxelType::U8 => "uint8",
        VoxelType::I8 => "int8",
        VoxelType::U16 => "uint16",
        VoxelType::I16 => "int16",
        VoxelType::U32 => "uint32",
        VoxelType::I32 => "int32",
        VoxelType::F16 | VoxelType::F32 => "float",
    }
}

/// Shortest digits that read back as the same numbers.
fn vector(v: DVec3) -> String {
    format!("({},{},{})", v.x, v.y, v.z)
}

/// A free text that cannot break out of its quotes or its line.
fn one_line(text: &str) -> String {
    text.replace('"', "'").replace(|c: char| c.is_control(), " ")
}
