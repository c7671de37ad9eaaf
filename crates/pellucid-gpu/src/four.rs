//! What WGSL has as `vec4<f32>`.

/// Four numbers side by side.
pub type Four = [f32; 4];
