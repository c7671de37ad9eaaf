//! NIfTI-1 and NIfTI-2: binary headers of 348 and 540 bytes, alone or in front of the data.
//!
//! Sources: `nifti1.h` (<https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h>) and
//! `nifti2.h`.

mod geometry;
mod header;
mod read;
mod write;

pub(crate) use header::is_nifti;
pub(crate) use read::{describe, header_of_image};
pub(crate) use write::write;
