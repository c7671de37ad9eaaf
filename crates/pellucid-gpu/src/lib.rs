//! The wgpu backend: the scenes of the CPU backend on Vulkan, Metal and DX12, within what WebGPU
//! guarantees.
//!
//! Work happens on an open [`Device`]; every optional feature is used where it is there and replaced
//! where it is not. Shaders are WGSL files in `shaders/`, a file per pass, put together when they are
//! needed. What they compute is stated by the CPU backend; tests hold the pictures together.

mod bindings;
mod bounds;
mod bricks;
mod device;
mod dispatch;
mod drawing;
mod error;
mod four;
mod groups;
mod half_angle;
mod kernels;
mod light_volume;
mod lights;
mod lists;
mod noise;
mod on_device;
mod optics;
mod pace;
mod pass_volumes;
mod path_trace;
mod pipelines;
mod plan;
mod ray_cast;
mod renderer;
mod resident;
mod scattering;
pub mod shaders;
mod slicing;
mod staging;
mod targets;
mod texture;
mod timer;
mod uniforms;
mod uploads;
mod window;

pub use device::{AdapterChoice, AdapterSummary, Capabilities, Ceiling, Device, adapters};
pub use drawing::{Interpolation, Passes};
pub use error::GpuError;
pub use plan::MemoryPlan;
pub use renderer::GpuRenderer;
pub use texture::Part;
pub use wgpu;
