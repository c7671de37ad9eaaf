//! The CPU backend.
//!
//! A frame is drawn by packets of rays in tiles over all cores. Every mode stands on the same parts:
//! rays (`source`), where they meet the field (`lines`, `solid`) and where on them samples are taken (`rays`), side by
//! side in vectors (`packet`), what lies along them (`medium`), the question "what is the field here?" (`field`), what it looks like
//! (`classify`, `light`), and blocks that cannot contribute (`skip`). A mode is what it does with
//! the samples. What runs per sample is written once and compiled for every instruction set
//! (`lanes`).

mod apart;
mod cells;
mod chroma;
mod classify;
mod composite;
mod cut;
mod element;
mod error;
mod field;
mod half_angle;
mod illumination;
mod integrator;
mod isosurface;
mod lanes;
mod layers;
mod light;
mod lines;
mod medium;
mod modes;
mod monotone;
mod packet;
mod paint;
mod path_trace;
mod prepare;
mod projection;
mod rays;
mod reconstruct;
mod renderer;
mod samples;
mod segments;
mod shadow;
mod skip;
mod slice;
mod solid;
mod source;
#[cfg(test)]
mod test_random;
mod tiles;
mod vary;
mod walk;

pub use error::RenderError;
pub use illumination::{Baked, SavedLightError};
pub use lanes::InstructionSet;
pub use renderer::CpuRenderer;
