//! The way in and out: which format a file has, and from its description to a volume.

use std::path::Path;

use pellucid_field::{FieldError, Grid, Volume, Warning};

use crate::description::Description;
use crate::header::LONGEST_HEADER;
use crate::options::{is_gzip_name, plain_extension};
use crate::source::Source;
use crate::{Format, IoError, Loaded, ReadOptions, WriteOptions, metaimage, nifti, nrrd, raw, values};

/// Reads a volume, in the format its content shows (or the extension, where the content is not
/// distinctive).
///
/// # Errors
/// [`IoError`] of every kind but those of pictures.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded, IoError> {
    let path = path.as_ref();
    // Of a NIfTI pair, the header names the image, not the other way round.
    let header = match plain_extension(path).as_str() {
        "img" if options.raw.is_none() => nifti::header_of_image(path),
        _ => path.to_owned(),
    };
    load(&Source::open(&header, options.map)?, options)
}

/// Reads a volume from bytes in memory as if they were the content of the file `name`, whose
/// extension and folder (for detached data) count as they do for [`read`].
///
/// # Errors
/// As [`read`].
pub fn read_bytes(name: impl AsRef<Path>, bytes: Vec<u8>, options: &ReadOptions) -> Result<Loaded, IoError> {
    load(&Source::memory(name.as_ref(), bytes), options)
}

/// Writes a volume, whole or not at all. Returns what the format could not hold exactly.
///
/// # Errors
/// [`IoError::Io`], and [`IoError::Unsupported`] if the extension names no format or the format
/// cannot hold the volume.
pub fn write(path: impl AsRef<Path>, volume: &Volume, options: &WriteOptions) -> Result<Vec<Warning>, IoError> {
    let path = path.as_ref();
    match options.format.or_else(|| Format::from_extension(path)) {
        Some(Format::Nrrd) => nrrd::write(path, volume, options),
        Some(Format::MetaImage) => metaimage::write(path, volume, options),
        Some(Format::Nifti) => nifti::write(path, volume, options),
        Some(Format::Raw) => raw::write(path, volume),
        None => Err(unknown(path, "write one of .nrrd .nhdr .mha .mhd .nii .nii.gz .raw, or state the format")),
    }
}

fn load(source: &Source, options: &ReadOptions) -> Result<Loaded, IoError> {
    let description = match &options.raw {
        Some(layout) => raw::describe(source, layout)?,
        None => {
            let head = source.head(LONGEST_HEADER)?;
            match recognise(source, &head)? {
                Format::Nrrd => nrrd::describe(source, &head, options)?,
                Format::MetaImage => metaimage::describe(source, &head, options)?,
                Format::Nifti => nifti::describe(source, &head, options)?,
                Format::Raw => return Err(unknown(&source.path, "state dims and type to read it as raw values")),
            }
        }
    };
    let path = &source.path;
    let Description { mut warnings, payload, mut value_map, .. } = description;
    let grid = Grid::with_affine(description.dims, description.world_from_index).map_err(IoError::field(path))?;
    let components = description.components;
    if !(1..=4).contains(&components) {
        return Err(IoError::field(path)(FieldError::Components { found: components }));
    }
    let (voxels, base) = values::voxels(&payload, options, &mut warnings)?;
    value_map.offset += value_map.scale * base;
    for warning in &mut warnings {
        // Readers of values know stored numbers; users see data values.
        if let Warning::Converted { largest_error, .. } = warning {
            *largest_error *= value_map.scale.abs();
        }
    }
    let is_integer = voxels.voxel_type().is_integer();
    let volume = Volume::with_components(grid, voxels, components).map_err(IoError::field(path))?;
    let mut volume = volume.with_value_map(value_map).map_err(IoError::field(path))?.with_name(short_name(path));
    volume.description = description.text;
    volume.value_unit = description.value_unit;
    volume.length_unit = description.length_unit;
    volume.is_anatomical = description.is_anatomical;
    if !is_integer {
        let statistics = volume.statistics();
        if statistics.nan + statistics.infinite > 0 {
            warnings.push(Warning::NotFinite { nan: statistics.nan, infinite: statistics.infinite });
        }
    }
    Ok(Loaded { volume, warnings })
}

/// The format a file shows by its content or its extension.
fn recognise(source: &Source, head: &[u8]) -> Result<Format, IoError> {
    if head.starts_with(b"NRRD") {
        return Ok(Format::Nrrd);
    }
    if nifti::is_nifti(head) {
        return Ok(Format::Nifti);
    }
    if metaimage::is_metaimage(head) {
        return Ok(Format::MetaImage);
    }
    Format::from_extension(&source.path)
        .ok_or_else(|| unknown(&source.path, "expected NRRD, MetaImage or NIfTI; state dims and type for raw values"))
}

fn unknown(path: &Path, advice: &str) -> IoError {
    let extension = path.extension().map(|extension| format!(".{}", extension.to_string_lossy()));
    IoError::unsupported(path, "format", extension.as_deref().unwrap_or("without an extension"), advice)
}

/// A file's name without its folder and extensions.
fn short_name(path: &Path) -> String {
    let plain = if is_gzip_name(path) { path.with_extension("") } else { path.to_owned() };
    plain.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}
