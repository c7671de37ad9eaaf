//! From the header's tags to the description of a volume.

use std::collections::HashMap;

use glam::DVec3;
use pellucid_field::{ValueMap, VoxelType, Warning};

use crate::description::{Description, choose_time};
use crate::encoding::Encoding;
use crate::file_names::FileNames;
use crate::header::{Field, Lines};
use crate::payload::{Parts, Payload, Skip};
use crate::source::Source;
use crate::world::{Frame, affine_from_steps, millimetres, to_world};
use crate::{Endian, IoError, ReadOptions, StoredType};

/// Whether a file begins like a MetaImage header, which may open with any of a few tags.
pub(crate) fn is_metaimage(bytes: &[u8]) -> bool {
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
    let tag = |line: &str| line.split_once('=').map(|(tag, _)| tag.trim().to_lowercase());
    let tags: Vec<_> = start.lines().map_while(tag).collect();
    tags.iter().any(|tag| tag == "ndims" || tag == "dimsize")
}

/// A parsed header.
struct MetaImageHeader<'a> {
    source: &'a Source,
    tags: HashMap<String, String>,
    /// The lines after `ElementDataFile = LIST`.
    list: Vec<String>,
    /// Where the header ends.
    end: u64,
}

impl<'a> MetaImageHeader<'a> {
    fn parse(source: &'a Source, head: &[u8]) -> Result<Self, IoError> {
        let mut lines = Lines::new(source, head);
        let mut header = Self { source, tags: HashMap::new(), list: Vec::new(), end: 0 };
        while let Some(line) = lines.next_line()? {
            if line.trim().is_empty() {
                continue;
            }
            let Some((tag, value)) = line.split_once('=') else {
                return Err(IoError::malformed(&source.path, "header line", &line, "'tag = value'"));
            };
            let (tag, value) = (tag.trim().to_lowercase(), value.trim().to_owned());
            let is_list = value.split_whitespace().next() == Some("LIST");
            let is_last = tag == "elementdatafile";
            header.tags.insert(tag, value);
            if is_last {
                header.end = lines.position() as u64;
                while is_list && let Some(name) = lines.next_line()? {
                    header.list.push(name.trim().to_owned());
                }
                break;
            }
        }
        header.list.retain(|name| !name.is_empty());
        Ok(header)
    }

    fn get(&self, name: &'static str) -> Option<Field<'_>> {
        let text = self.tags.get(&name.to_lowercase())?;
        Some(Field { path: &self.source.path, name, text })
    }

    /// The first of several names for the same thing.
    fn any(&self, names: &[&'static str]) -> Option<Field<'_>> {
        names.iter().find_map(|name| self.get(name))
    }

    fn require(&self, name: &'static str, expected: &'static str) -> Result<Field<'_>, IoError> {
        self.get(name).ok_or_else(|| IoError::Missing { path: self.source.path.clone(), field: name, expected })
    }

    fn flag(&self, names: &[&'static str], otherwise: bool) -> Result<bool, IoError> {
        let Some(field) = self.any(names) else { return Ok(otherwise) };
        match field.text.to_lowercase().as_str() {
            "true" | "t" | "1" | "yes" => Ok(true),
            "false" | "f" | "0" | "no" => Ok(false),
            _ => Err(field.error("True or False")),
        }
    }
}

/// How to read a MetaImage file.
pub(crate) fn describe(source: &Source, head: &[u8], options: &ReadOptions) -> Result<Description, IoError> {
    let path = &source.path;
    let mut header = MetaImageHeader::parse(source, head)?;
    let mut warnings = Vec::new();
    if let Some(field) = header.get("ObjectType").filter(|field| !field.text.eq_ignore_ascii_case("image")) {
        return Err(field.error("Image"));
    }
    let dimension: usize = header.require("NDims", "the number of axes")?.number("2, 3 or 4")?;
    if !(2..=4).contains(&dimension) {
        return Err(IoError::unsupported(path, "NDims", dimension, "2, 3, or 4 with the last for time"));
    }
    let why = format!("'NDims = {dimension}'");
    let sizes_field = header.require("DimSize", "the number of voxels along each axis")?;
    let sizes: Vec<usize> = sizes_field.numbers(dimension, &why)?;
    if sizes.contains(&0) {
        return Err(sizes_field.error("at least 1 voxel along every axis"));
    }
    let channels = header.get("ElementNumberOfChannels");
    let components: usize = channels.map_or(Ok(1), |field| field.number("a number of channels"))?;
    let stored = stored_type(header.require("ElementType", "a type such as MET_SHORT")?)?;
    let (file_from_index, frame, scale) = geometry(&header, dimension, &mut warnings)?;
    let mut dims = [1; 3];
    dims[..dimension.min(3)].copy_from_slice(&sizes[..dimension.min(3)]);
    let frames = sizes.get(3).map_or(1, |&n| n as u64);
    let time = choose_time(path, frames, options, &mut warnings)?;
    let count = dims.iter().try_fold(components as u64, |product, &n| product.checked_mul(n as u64));
    let count = count.ok_or_else(|| IoError::too_large(path))?;

    let is_big = header.flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"], false)?;
    let encoding = match (header.flag(&["BinaryData"], true)?, header.flag(&["CompressedData"], false)?) {
        (false, _) => Encoding::Text,
        (true, true) => Encoding::Zlib,
        (true, false) => Encoding::Raw,
    };
    let parts = parts(&mut header)?;
    let is_local = matches!(parts, Parts::Attached(..));
    let skip = match header.get("HeaderSize").map(|field| (field, field.number::<i64>("a number of bytes, or -1"))) {
        None => Skip::NONE,
        Some((_, Ok(-1))) if encoding == Encoding::Raw => Skip::FromEnd,
        // MetaIO counts from the start of the file, so it has no use when the data are local.
        Some((_, Ok(bytes))) if bytes >= 0 && encoding == Encoding::Raw => {
            Skip::Forward { lines: 0, bytes: if is_local { 0 } else { bytes as u64 } }
        }
        Some((_, Ok(0))) => Skip::NONE,
        Some((field, Ok(_))) => return Err(field.error("0 or more, or -1, and 0 for data that are not plain")),
        Some((_, Err(error))) => return Err(error),
    };
    let number = |name, otherwise| header.get(name).map_or(Ok(otherwise), |field| field.number("a number"));
    let value_map = ValueMap {
        scale: number("ElementToIntensityFunctionSlope", 1.0)?,
        offset: number("ElementToIntensityFunctionOffset", 0.0)?,
    };
    Ok(Description {
        dims,
        world_from_index: to_world(file_from_index, frame, scale),
        components,
        value_map,
        text: None,
        value_unit: None,
        length_unit: (frame == Frame::Lps).then(|| "mm".to_owned()),
        is_anatomical: frame.is_anatomical(),
        payload: Payload {
            header: path.clone(),
            parts,
            skip,
            encoding,
            stored,
            endian: if is_big { Endian::Big } else { Endian::Little },
            count,
            frames,
            frame: time,
            planes: 1,
        },
        warnings,
    })
}

/// Where the voxels are, in which frame, and millimetres per unit.
fn geometry(
    header: &MetaImageHeader,
    dimension: usize,
    warnings: &mut Vec<Warning>,
) -> Result<(glam::DAffine3, Frame, f64), IoError> {
    let why = format!("'NDims = {dimension}'");
    let numbers = |field: Field| field.numbers::<f64>(dimension, &why);
    let spacing = match header.any(&["ElementSpacing", "ElementSize"]) {
        Some(field) => numbers(field)?,
        None => vec![1.0; dimension],
    };
    let offset = match header.any(&["Offset", "Position", "Origin"]) {
        Some(field) => numbers(field)?,
        None => vec![0.0; dimension],
    };
    let transform = header.any(&["TransformMatrix", "Rotation", "Orientation"]);
    let transform = transform.map(|field| field.numbers::<f64>(dimension * dimension, &why)).transpose()?;
    if let Some(center) = header.get("CenterOfRotation")
        && numbers(center)?.iter().any(|&part| part != 0.0)
    {
        // As ITK does: the offset is that of the first voxel, whatever the centre.
        warnings.push(Warning::File("CenterOfRotation is ignored: Offset is where the first voxel is".to_owned()));
    }
    let axes = dimension.min(3);
    let steps: Vec<DVec3> = (0..axes)
        .map(|axis| {
            let mut direction = DVec3::ZERO;
            for part in 0..axes {
                // Row by row, the matrix lists the direction of each axis of the image.
                let identity = f64::from(u8::from(axis == part));
                direction[part] = transform.as_ref().map_or(identity, |matrix| matrix[axis * dimension + part]);
            }
            direction * spacing[axis]
        })
        .collect();
    let origin = DVec3::from_array(std::array::from_fn(|part| if part < axes { offset[part] } else { 0.0 }));
    let affine = affine_from_steps(&steps, origin);
    let unit = header.get("DistanceUnits").filter(|field| field.text != "?");
    match unit {
        Some(field) => {
            let scale = millimetres(field.text).ok_or_else(|| field.error("um, mm or cm"))?;
            Ok((affine, Frame::Lps, scale))
        }
        // ITK's positions are LPS; a header without any of these tags says nothing of a patient.
        None if header.get("AnatomicalOrientation").is_some() => Ok((affine, Frame::Lps, 1.0)),
        None => Ok((affine, Frame::Unstated, 1.0)),
    }
}

fn parts(header: &mut MetaImageHeader) -> Result<Parts, IoError> {
    let field = header.require("ElementDataFile", "LOCAL, LIST or the name of a file, as the last tag")?;
    if field.text.eq_ignore_ascii_case("local") {
        return Ok(Parts::Attached(header.source.clone(), header.end));
    }
    if field.text.split_whitespace().next() == Some("LIST") {
        return FileNames::listed(&header.source.path, std::mem::take(&mut header.list)).map(Parts::Files);
    }
    FileNames::parse(&field).map(Parts::Files)
}

fn stored_type(field: Field) -> Result<StoredType, IoError> {
    let name = field.text.to_uppercase();
    Ok(match name.strip_suffix("_ARRAY").unwrap_or(&name) {
        "MET_CHAR" => VoxelType::I8.into(),
        "MET_UCHAR" | "MET_ASCII_CHAR" => VoxelType::U8.into(),
        "MET_SHORT" => VoxelType::I16.into(),
        "MET_USHORT" => VoxelType::U16.into(),
        // A long has 4 bytes in MetaIO, whatever the machine.
        "MET_INT" | "MET_LONG" => VoxelType::I32.into(),
        "MET_UINT" | "MET_ULONG" => VoxelType::U32.into(),
        "MET_LONG_LONG" => StoredType::I64,
        "MET_ULONG_LONG" => StoredType::U64,
        "MET_FLOAT" => VoxelType::F32.into(),
        "MET_DOUBLE" => StoredType::F64,
        _ => return Err(field.error("MET_CHAR, SHORT, INT, LONG_LONG, their unsigned kin, MET_FLOAT or MET_DOUBLE")),
    })
}
