//! NRRD: "nearly raw raster data", versions 1 to 5, with attached or detached data.
//!
//! Source: "Definition of NRRD File Format", <https://teem.sourceforge.net/nrrd/format.html>.

mod axes;
mod fields;
mod read;
mod write;

pub(crate) use read::describe;
pub(crate) use write::write;
