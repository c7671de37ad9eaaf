//! The CPU backend.
//!
//! A frame is drawn by rays in tiles over all cores. Every mode stands on the same parts: the part
//! of a ray that meets the field (`span`), the sample lattice along it (`lattice`), the question
//! "what is the field here?" (`probe`), blocks that cannot contribute (`skip`) and local light
//! (`surface`). A mode is what it does with the samples.

mod composite;
mod error;
mod integrator;
mod isosurface;
mod lattice;
mod medium;
mod prepare;
mod probe;
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
pub use renderer::CpuRenderer;
