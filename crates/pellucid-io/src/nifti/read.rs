//! From the header to the description of a volume.

use std::path::{Path, PathBuf};

use pellucid_field::{ValueMap, Warning};

use super::geometry::world_from_index;
use super::header::{NiftiHeader, is_gzip};
use crate::description::{Description, choose_time};
use crate::encoding::Encoding;
use crate::file_names::FileNames;
use crate::options::is_gzip_name;
use crate::payload::{Parts, Payload, Skip};
use crate::source::Source;
use crate::{IoError, ReadOptions};

/// How to read a NIfTI file.
pub(crate) fn describe(source: &Source, head: &[u8], options: &ReadOptions) -> Result<Description, IoError> {
    let path = &source.path;
    let header = NiftiHeader::parse(source, head)?;
    let mut warnings = Vec::new();
    let (stored, packed) = header.stored(source)?;
    if i64::from(header.bitpix) != (stored.size() * packed * 8) as i64 {
        warnings.push(Warning::File(format!("bitpix {} does not match the datatype and is ignored", header.bitpix)));
    }
    let axes = header.dim[0];
    if !(1..=7).contains(&axes) {
        return Err(IoError::malformed(path, "dim[0]", axes, "1 to 7"));
    }
    let mut dim = [1; 7];
    for (axis, n) in dim.iter_mut().enumerate().take(axes as usize) {
        let found = header.dim[axis + 1];
        let size = usize::try_from(found).ok().filter(|&size| size > 0);
        *n = size.ok_or_else(|| IoError::malformed(path, &format!("dim[{}]", axis + 1), found, "1 or more"))?;
    }
    let [x, y, z, frames, planes, sixth, seventh] = dim;
    if sixth * seventh.min(2) > 1 || (frames > 1 && planes > 1) || (packed > 1 && planes > 1) {
        let found = format!("{:?}", &header.dim[1..]);
        let advice = "three axes of space, and one of time (the fourth) or of components (the fifth)";
        return Err(IoError::unsupported(path, "dim", found, advice));
    }
    let components = packed * planes;
    let voxels = [x, y, z].into_iter().try_fold(components as u64, |product, n| product.checked_mul(n as u64));
    let count = voxels.ok_or_else(|| IoError::too_large(path))?;
    let frame = choose_time(path, frames as u64, options, &mut warnings)?;
    let (world_from_index, in_millimetres, is_anatomical) = world_from_index(&header, &mut warnings);
    let (parts, encoding) = parts(source, head, &header);
    Ok(Description {
        dims: [x, y, z],
        world_from_index,
        components,
        value_map: value_map(&header, packed, &mut warnings),
        text: None,
        value_unit: None,
        length_unit: in_millimetres.then(|| "mm".to_owned()),
        is_anatomical,
        payload: Payload {
            header: path.clone(),
            parts,
            skip: Skip::Forward { lines: 0, bytes: offset(source, &header, &mut warnings)? },
            encoding,
            stored,
            endian: header.endian,
            count,
            frames: frames as u64,
            frame,
            planes,
        },
        warnings,
    })
}

/// The header that belongs to the image of a pair.
pub(crate) fn header_of_image(path: &Path) -> PathBuf {
    let plain = if is_gzip_name(path) { path.with_extension("") } else { path.to_owned() };
    let header = plain.with_extension("hdr");
    let packed = plain.with_extension("hdr.gz");
    if is_gzip_name(path) && packed.exists() && !header.exists() { packed } else { header }
}

fn parts(source: &Source, head: &[u8], header: &NiftiHeader) -> (Parts, Encoding) {
    if header.is_single {
        let encoding = if is_gzip(head) { Encoding::Gzip } else { Encoding::Raw };
        return (Parts::Attached(source.clone(), 0), encoding);
    }
    let path = &source.path;
    let plain = if is_gzip_name(path) { path.with_extension("") } else { path.clone() };
    let (image, packed) = (plain.with_extension("img"), plain.with_extension("img.gz"));
    let (image, encoding) =
        if packed.exists() && !image.exists() { (packed, Encoding::Gzip) } else { (image, Encoding::Raw) };
    let name = image.file_name().unwrap_or_default();
    (Parts::Files(FileNames::Listed(vec![name.into()])), encoding)
}

/// Where the values begin.
fn offset(source: &Source, header: &NiftiHeader, warnings: &mut Vec<Warning>) -> Result<u64, IoError> {
    let found = header.vox_offset;
    if !(0.0..9e15).contains(&found) || found.fract() != 0.0 {
        return Err(IoError::malformed(&source.path, "vox_offset", found, "a number of bytes, 0 or more"));
    }
    if header.is_single && (found as u64) < header.earliest {
        let line = format!("vox_offset {found} lies in the header: taken as {}", header.earliest);
        warnings.push(Warning::File(line));
        return Ok(header.earliest);
    }
    Ok(found as u64)
}

/// Slope and intercept. A slope of 0 says that there are none; colours have none.
fn value_map(header: &NiftiHeader, packed: usize, warnings: &mut Vec<Warning>) -> ValueMap {
    let (scale, offset) = (header.scl_slope, header.scl_inter);
    if packed > 1 || scale == 0.0 || !scale.is_finite() {
        return ValueMap::IDENTITY;
    }
    if !offset.is_finite() {
        warnings.push(Warning::File(format!("scl_inter is {offset}: taken as 0")));
        return ValueMap { scale, offset: 0.0 };
    }
    ValueMap { scale, offset }
}
