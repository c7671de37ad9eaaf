//! Volume files in and out (NRRD, MetaImage, NIfTI, raw) and pictures (PNG, EXR).
//!
//! [`read`] recognises a volume file by its content and returns a [`Loaded`]: the volume in its
//! stored type, and a warning for everything that was converted, guessed or ignored.
//! [`write`](write()) stores a volume in the format its extension names.
//!
//! ```no_run
//! use pellucid_io::{ReadOptions, WriteOptions, read, write};
//!
//! # fn main() -> Result<(), pellucid_io::IoError> {
//! let loaded = read("head.nii.gz", &ReadOptions::default())?;
//! for warning in &loaded.warnings {
//!     eprintln!("warning: {warning}");
//! }
//! write("head.nrrd", &loaded.volume, &WriteOptions::default())?;
//! # Ok(())
//! # }
//! ```
//!
//! What every reader keeps to:
//!
//! - A file that states an anatomical frame (NIfTI q-form and s-form, NRRD `space`, MetaImage)
//!   lands in LPS millimetres. A file that states none keeps its own numbers.
//! - Values are read or decoded straight into their destination; plain ones in native order are
//!   mapped into memory instead by those who vouch for their files ([`Mapping`]).
//! - Nothing is allocated that the size of the file does not justify, so a header may lie about
//!   its dims without harm, and what a packed file may become has [`Limits`].
//! - Only regular files are opened ([`open_regular`]), and headers name what lies in their own
//!   folder or below ([`locate`]).
//! - Files are written beside their destination and renamed into place ([`AtomicFile`]).

mod atomic;
mod body;
mod description;
mod encoding;
mod error;
mod file_names;
mod header;
mod limits;
mod locate;
mod lookahead;
mod metaimage;
mod nifti;
mod nrrd;
mod open;
mod options;
mod payload;
mod picture;
mod raw;
mod raw_layout;
mod source;
mod stored;
mod stream;
mod values;
mod volumes;
mod world;

pub use atomic::{AtomicFile, discard_unfinished};
pub use error::IoError;
pub use limits::Limits;
pub use locate::locate;
pub use open::{open_regular, read_text};
pub use options::{Format, Loaded, ReadOptions, WriteOptions};
pub use picture::{
    Picture, PngPixels, Transfer, is_guarded, read_exr, read_picture, read_picture_bytes, read_png, write_exr,
    write_png,
};
pub use raw_layout::RawLayout;
pub use source::Mapping;
pub use stored::{Endian, StoredType};
pub use volumes::{read, read_bytes, write};
