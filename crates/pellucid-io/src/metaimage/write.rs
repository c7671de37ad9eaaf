//! MetaImage files from volumes.

use std::path::Path;

use glam::DVec3;
use pellucid_field::{ValueMap, Volume, VoxelType, Warning};

use crate::body::{DataFile, Files, Packing, SIZE_DIGITS, Wide, align, written_type};
use crate::options::plain_extension;
use crate::{Endian, IoError, WriteOptions};

/// Writes a volume; with its data in a file of their own if the extension is `.mhd`.
pub(crate) fn write(path: &Path, volume: &Volume, options: &WriteOptions) -> Result<Vec<Warning>, IoError> {
    let mut warnings = Vec::new();
    let (packing, data_extension) = match options.compression {
        None => (Packing::Plain, "raw"),
        Some(level) => (Packing::Zlib(level), "zraw"),
    };
    let data_file = (plain_extension(path) == "mhd").then(|| DataFile::of(path, data_extension)).transpose()?;
    let grid = volume.grid();
    let affine = grid.world_from_index();
    let spacing = grid.spacing();
    let axes = [affine.matrix3.x_axis, affine.matrix3.y_axis, affine.matrix3.z_axis];
    let directions: [DVec3; 3] = std::array::from_fn(|axis| axes[axis] / spacing[axis]);
    let directions = directions.map(|v| words(v.to_array())).join(" ");
    let wide = Wide::of(volume);
    let tag_type = match written_type(volume, &mut warnings) {
        _ if wide.is_some_and(|wide| wide.is_integer()) => "MET_LONG_LONG",
        _ if wide.is_some() => "MET_DOUBLE",
        VoxelType::U8 => "MET_UCHAR",
        VoxelType::I8 => "MET_CHAR",
        VoxelType::U16 => "MET_USHORT",
        VoxelType::I16 => "MET_SHORT",
        VoxelType::U32 => "MET_UINT",
        VoxelType::I32 => "MET_INT",
        VoxelType::F16 | VoxelType::F32 => "MET_FLOAT",
    };
    let flag = |is_true: bool| if is_true { "True" } else { "False" };

    let mut header = String::new();
    let mut tag = |name: &str, value: &str| header.extend([name, " = ", value, "\n"]);
    tag("ObjectType", "Image");
    tag("NDims", "3");
    tag("BinaryData", "True");
    tag("BinaryDataByteOrderMSB", flag(Endian::NATIVE == Endian::Big));
    tag("CompressedData", flag(options.compression.is_some()));
    tag("TransformMatrix", &directions);
    tag("Offset", &words(affine.translation.to_array()));
    tag("CenterOfRotation", "0 0 0");
    match volume.length_unit.as_deref() {
        Some(unit @ ("mm" | "cm" | "um")) => tag("DistanceUnits", unit),
        Some(unit) => warnings.push(Warning::File(format!("MetaImage has no name for the unit of length '{unit}'"))),
        None => {}
    }
    tag("ElementSpacing", &words(spacing));
    tag("DimSize", &words(grid.dims()));
    if volume.components() > 1 {
        tag("ElementNumberOfChannels", &volume.components().to_string());
    }
    let map = volume.value_map();
    if map != ValueMap::IDENTITY && wide.is_none() {
        tag("ElementToIntensityFunctionSlope", &map.scale.to_string());
        tag("ElementToIntensityFunctionOffset", &map.offset.to_string());
    }
    if let Some(unit) = &volume.value_unit {
        warnings.push(Warning::File(format!("MetaImage has no field for the unit of the values, '{unit}'")));
    }
    if let Some(description) = &volume.description {
        warnings.push(Warning::File(format!("MetaImage keeps no description, '{description}'")));
    }
    tag("ElementType", tag_type);
    let last = format!("ElementDataFile = {}\n", data_file.as_ref().map_or("LOCAL", |file| &file.name));
    // The MetaIO library cannot unpack local data without their size, which is known only at the end.
    let size_at = options.compression.map(|_| {
        header.push_str("CompressedDataSize = ");
        let at = header.len() as u64;
        header.push_str(&" ".repeat(SIZE_DIGITS));
        header.push('\n');
        at
    });
    align(&mut header, "Comment = aligned", last.len());
    header.push_str(&last);
    let (header, data_file) = (header.as_bytes(), data_file.as_ref());
    Files { path, header, size_at, data_file, packing }.write(volume)?;
    Ok(warnings)
}

/// Numbers between spaces, with the shortest digits that read back as the same.
fn words<T: ToString>(numbers: [T; 3]) -> String {
    numbers.map(|number| number.to_string()).join(" ")
}
