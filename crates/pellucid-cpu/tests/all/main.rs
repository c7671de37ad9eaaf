//! The tests of the crate that need no process of their own, in one program: one link instead of many.

#[path = "../common/mod.rs"]
mod common;
#[path = "../reference/mod.rs"]
mod reference;
mod saved_light;

mod absent;
mod adaptive;
mod agreement;
mod aligned;
mod chroma;
mod classification;
mod clipping;
mod components;
mod cut;
mod data_colors;
mod extremes;
mod gradients;
mod half_angle;
mod homogeneous;
mod illumination;
mod instruction_sets;
mod invariance;
mod isosurface;
mod layers;
mod leaps;
mod path_lights;
mod path_sights;
mod path_trace;
mod perturbation;
mod projection;
mod shadows;
mod values;
