//! From the header's fields to the description of a volume.

use pellucid_field::{ValueMap, VoxelType, Warning};

use super::axes::Shape;
use super::fields::NrrdHeader;
use crate::description::{Description, choose_time};
use crate::encoding::Encoding;
use crate::header::Field;
use crate::payload::{Payload, Skip};
use crate::source::Source;
use crate::{Endian, IoError, ReadOptions, StoredType};

/// How to read a NRRD file.
pub(crate) fn describe(source: &Source, head: &[u8], options: &ReadOptions) -> Result<Description, IoError> {
    let mut warnings = Vec::new();
    let mut header = NrrdHeader::parse(source, head, &mut warnings)?;
    let stored = stored_type(header.require("type", "a type of values")?)?;
    let encoding = encoding(header.require("encoding", "an encoding")?)?;
    let endian = match header.get("endian") {
        Some(field) => endian(field)?,
        None if stored.size() == 1 || encoding == Encoding::Text => Endian::NATIVE,
        None => {
            let expected = "'little' or 'big' for values of several bytes";
            return Err(IoError::Missing { path: source.path.clone(), field: "endian", expected });
        }
    };
    let shape = Shape::parse(&header, &mut warnings)?;
    for name in ["old min", "old max", "measurement frame"] {
        if header.get(name).is_some() {
            warnings.push(Warning::File(format!("the field '{name}' is ignored")));
        }
    }
    let frame = choose_time(&source.path, shape.frames, options, &mut warnings)?;
    let voxels = shape.dims.iter().try_fold(shape.components as u64, |product, &n| product.checked_mul(n as u64));
    let count = voxels.ok_or_else(|| IoError::too_large(&source.path))?;
    let skip = skip(&header, encoding)?;
    let value_map = value_map(&header)?;
    let content = header.get("content").map(|field| field.text.to_owned());
    let value_unit = header.get("sample units").map(|field| field.text.trim_matches('"').to_owned());
    let parts = header.take_parts()?;
    Ok(Description {
        dims: shape.dims,
        world_from_index: shape.world_from_index,
        components: shape.components,
        text: content.filter(|text| !text.is_empty()),
        value_map,
        value_unit: value_unit.filter(|unit| !unit.is_empty()),
        length_unit: shape.length_unit,
        is_anatomical: shape.is_anatomical,
        payload: Payload {
            header: source.path.clone(),
            parts,
            skip,
            encoding,
            stored,
            endian,
            count,
            frames: shape.frames,
            frame,
            planes: if shape.planar { shape.components } else { 1 },
        },
        warnings,
    })
}

fn stored_type(field: Field) -> Result<StoredType, IoError> {
    Ok(match field.text.to_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => VoxelType::I8.into(),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => VoxelType::U8.into(),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => VoxelType::I16.into(),
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => VoxelType::U16.into(),
        "int" | "signed int" | "int32" | "int32_t" => VoxelType::I32.into(),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => VoxelType::U32.into(),
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => StoredType::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => StoredType::U64,
        "float" => VoxelType::F32.into(),
        "double" => StoredType::F64,
        _ => return Err(field.error("an integer type of 8 to 64 bit, float or double")),
    })
}

fn encoding(field: Field) -> Result<Encoding, IoError> {
    Ok(match field.text.to_lowercase().as_str() {
        "raw" => Encoding::Raw,
        "gz" | "gzip" => Encoding::Gzip,
        "bz2" | "bzip2" => Encoding::Bzip2,
        "hex" => Encoding::Hex,
        "txt" | "text" | "ascii" => Encoding::Text,
        _ => return Err(field.error("raw, gzip, bzip2, hex or text")),
    })
}

fn endian(field: Field) -> Result<Endian, IoError> {
    match field.text.to_lowercase().as_str() {
        "little" => Ok(Endian::Little),
        "big" => Ok(Endian::Big),
        _ => Err(field.error("little or big")),
    }
}

fn skip(header: &NrrdHeader, encoding: Encoding) -> Result<Skip, IoError> {
    let lines = header.get("line skip").map_or(Ok(0), |field| field.number("a number of lines, 0 or more"))?;
    let Some(field) = header.get("byte skip") else { return Ok(Skip::Forward { lines, bytes: 0 }) };
    match field.number::<i64>("a number of bytes, or -1")? {
        -1 if encoding == Encoding::Raw => Ok(Skip::FromEnd),
        bytes if bytes >= 0 => Ok(Skip::Forward { lines, bytes: bytes as u64 }),
        _ => Err(field.error("0 or more, or -1 with 'encoding: raw'")),
    }
}

/// The format has no such field; these are the keys that this crate writes.
fn value_map(header: &NrrdHeader) -> Result<ValueMap, IoError> {
    let number = |key, otherwise| header.key(key).map_or(Ok(otherwise), |field| field.number("a number"));
    Ok(ValueMap { scale: number("value scale", 1.0)?, offset: number("value offset", 0.0)? })
}
