//! The tests of the crate that need no process of their own, in one program: one link instead of many.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/planes.rs"]
mod planes;

mod aligned;
mod bricks;
mod errors;
mod filters;
mod half_angle;
mod layered_slices;
mod layers;
mod path_layers;
mod path_trace;
mod perturbation;
mod polygons;
mod samples;
mod shaders;
mod shadows;
mod slicing;
