//! MetaImage: `key = value` headers, with the data after them or in files of their own.
//!
//! Source: "MetaIO", <https://docs.itk.org/en/latest/learn/metaio.html>, and what the MetaIO
//! library does where that is silent.

mod read;
mod write;

pub(crate) use read::{describe, is_metaimage};
pub(crate) use write::write;
