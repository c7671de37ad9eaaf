//! Values without a header.

use std::io::Write;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use pellucid_field::{ValueMap, Volume, Warning};

use crate::description::Description;
use crate::encoding::Encoding;
use crate::payload::{Parts, Payload, Skip};
use crate::source::Source;
use crate::{AtomicFile, IoError, RawLayout, StoredType};

/// How to read a file of this layout.
pub(crate) fn describe(source: &Source, layout: &RawLayout) -> Result<Description, IoError> {
    let voxels = layout.dims.iter().try_fold(1u64, |product, &n| product.checked_mul(n as u64));
    let count = voxels.and_then(|voxels| voxels.checked_mul(layout.components as u64));
    let size = layout.stored.size() as u64;
    let expected = count.and_then(|count| count.checked_mul(size)).filter(|&bytes| bytes > 0);
    let found = source.length;
    let fits = match (expected, layout.skip) {
        (Some(expected), None) => found == expected,
        (Some(expected), Some(skip)) => skip.checked_add(expected).is_some_and(|end| end <= found),
        (None, _) => false,
    };
    let Some(count) = count.filter(|_| fits) else {
        let [x, y, z] = layout.dims;
        let needed = expected.map_or("an impossible number of".to_owned(), |bytes| bytes.to_string());
        let skip = layout.skip.map_or(String::new(), |skip| format!(" after {skip}"));
        let what = format!("{needed} bytes{skip} ({x} x {y} x {z}, {} x {})", layout.components, layout.stored);
        let expected = format!("{what}{}", suggestions(layout, found));
        return Err(IoError::malformed(&source.path, "file size", found, expected));
    };
    Ok(Description {
        dims: layout.dims,
        world_from_index: DAffine3::from_mat3(DMat3::from_diagonal(DVec3::from_array(layout.spacing))),
        components: layout.components,
        value_map: ValueMap::IDENTITY,
        text: None,
        value_unit: None,
        length_unit: None,
        is_anatomical: false,
        payload: Payload {
            header: source.path.clone(),
            parts: Parts::Attached(source.clone(), layout.skip.unwrap_or(0)),
            skip: Skip::NONE,
            encoding: Encoding::Raw,
            stored: layout.stored,
            endian: layout.endian,
            count,
            frames: 1,
            frame: 0,
            planes: 1,
        },
        warnings: Vec::new(),
    })
}

/// Nearby layouts that the file's size would fit.
fn suggestions(layout: &RawLayout, found: u64) -> String {
    let [x, y, z] = layout.dims.map(|n| n as u64);
    let available = found.saturating_sub(layout.skip.unwrap_or(0));
    let slice = x.checked_mul(y).and_then(|area| area.checked_mul(layout.components as u64));
    let Some(slice) = slice.filter(|&slice| slice > 0) else { return String::new() };
    let mut fits = Vec::new();
    if let Some(values) = slice.checked_mul(z).filter(|&values| values > 0) {
        for size in [1, 2, 4, 8] {
            if values.checked_mul(size) == Some(available) {
                let names = StoredType::ALL.iter().filter(|stored| stored.size() as u64 == size);
                let names: Vec<_> = names.map(|stored| stored.name()).collect();
                fits.push(format!("type {}", names.join(" or ")));
            }
        }
    }
    if let Some(slice_bytes) = slice.checked_mul(layout.stored.size() as u64)
        && available > 0
        && available.is_multiple_of(slice_bytes)
    {
        fits.push(format!("dims {x} x {y} x {}", available / slice_bytes));
    }
    let needed = slice.checked_mul(z).and_then(|values| values.checked_mul(layout.stored.size() as u64));
    if layout.skip.is_none()
        && let Some(header) = needed.and_then(|needed| found.checked_sub(needed)).filter(|&header| header > 0)
    {
        fits.push(format!("skip {header}, if the file begins with a header"));
    }
    if fits.is_empty() { String::new() } else { format!("; it would fit {}", fits.join(", or ")) }
}

/// Writes the values alone, in native order.
pub(crate) fn write(path: &Path, volume: &Volume) -> Result<Vec<Warning>, IoError> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(volume.voxels().as_bytes()).map_err(IoError::io(path))?;
    file.commit()?;
    let [x, y, z] = volume.grid().dims();
    let (stored, components) = (volume.voxels().voxel_type(), volume.components());
    let layout = format!("{x} x {y} x {z}, {components} x {stored}");
    let map = volume.value_map();
    let values = match map == ValueMap::IDENTITY {
        true => String::new(),
        false => format!(", what numbers mean (value = {} x stored + {})", map.scale, map.offset),
    };
    let described = if volume.description.is_some() { ", the description" } else { "" };
    Ok(vec![Warning::File(format!(
        "raw files hold values alone: keep the layout ({layout}){values}{described}, the grid and units apart"
    ))])
}
