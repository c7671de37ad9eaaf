//! The tests of the crate that need no process of their own, in one program: one link instead of many.

#[path = "../common/mod.rs"]
mod common;

mod abuse;
mod atomic;
mod metaimage;
mod names;
mod nifti;
mod nrrd;
mod orientation;
mod pictures;
mod raw;
mod real_files;
mod roundtrip;
mod untrusted;
