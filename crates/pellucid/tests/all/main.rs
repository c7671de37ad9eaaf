//! The tests of the crate that need no process of their own, in one program: one link instead of many.

#[path = "../common/mod.rs"]
mod common;
#[path = "../../../pellucid-gpu/tests/common/mod.rs"]
mod gpu_common;
#[path = "../common/gallery.rs"]
mod scenes;

mod bench;
mod commands;
mod effect;
mod flags;
mod gpu;
mod gpu_fields;
mod gpu_values;
mod gpu_views;
mod load_optics;
mod models;
mod passes;
mod progressive;
mod readme;
mod real_data;
mod render;
mod untrusted;
mod words;
