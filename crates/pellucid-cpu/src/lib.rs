//! The CPU backend.
//!
//! A frame is drawn by packets of rays in tiles over all cores. Every mode stands on the same parts:
//! the part of a ray that meets the field (`span`), the sample positions along it (`lattice`), rays
//! side by side (`packet`), the question "what is the field here?" (`field`), what it looks like
//! (`classify`, `surface`), and blocks that cannot contribute (`skip`). A mode is what it does with
//! the samples. What runs per sample is written once and compiled for every instruction set
//! (`lanes`).

mod classify;
mod composite;
mod distance;
mod error;
mod field;
mod integrator;
mod isosurface;
mod lanes;
mod lattice;
mod modes;
mod packet;
mod prepare;
mod projection;
mod renderer;
mod samples;
mod segments;
mod skip;
mod slice;
mod span;
mod surface;
mod tiles;

pub use error::RenderError;
pub use lanes::InstructionSet;
pub use renderer::CpuRenderer;
