//! The tests of the crate that need no process of their own, in one program: one link instead of many.

#[path = "../../../pellucid-gpu/tests/common/mod.rs"]
mod gpu_common;
#[path = "../common/mod.rs"]
mod scenes;

mod effect;
mod gpu;
mod gpu_fields;
mod gpu_values;
mod gpu_views;
mod house;
mod load_optics;
mod models;
mod passes;
mod progressive;
mod real_data;
