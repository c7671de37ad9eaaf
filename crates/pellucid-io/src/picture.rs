//! Pictures: PNG with 8 or 16 bits, and EXR with named floating point channels.

mod exr;
mod png;

pub use self::exr::{read_exr, write_exr};
pub use self::png::{Picture, PngPixels, Transfer, read_png, write_png};
