//! Phase functions from files.

use std::path::Path;

use pellucid_io::{Limits, Transfer, read_picture, read_text};
use pellucid_optics::{PhaseEntries, srgb_decode};

use crate::LoadError;

/// Reads the entries of a phase function: lines of numbers, or the first row of a PNG as light.
///
/// # Errors
/// [`LoadError::Io`], and [`LoadError::Line`] for lines.
pub fn read(path: &Path, limits: &Limits) -> Result<PhaseEntries, LoadError> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        let picture = read_picture(path, limits)?;
        let linear = |v: f32| if picture.transfer == Transfer::Srgb { srgb_decode(v) } else { v };
        let row = picture.pixels.iter().take(picture.width as usize);
        return Ok(PhaseEntries::Even(row.map(|[r, g, b, _]| [*r, *g, *b].map(linear)).collect()));
    }
    let entries = PhaseEntries::from_text(&read_text(path, limits)?);
    entries.map_err(|error| LoadError::Line { path: path.to_owned(), line: error.line, problem: error.problem })
}
