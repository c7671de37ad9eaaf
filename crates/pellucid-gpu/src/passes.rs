//! What the passes of a submission draw, in one buffer.

use std::num::NonZeroU64;

use bytemuck::bytes_of;
use wgpu::{BindingResource, Buffer, BufferBinding};

use crate::Device;
use crate::uniforms::Bounds;

/// Passes that are chosen one at a time, by an offset.
pub struct PassBuffer {
    buffer: Buffer,
    stride: usize,
}

impl PassBuffer {
    /// A buffer of passes, at least one.
    pub fn new(device: &Device, passes: impl IntoIterator<Item = Bounds>) -> Self {
        let limits = &device.capabilities.limits;
        let align = limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment) as usize;
        let stride = size_of::<Bounds>().next_multiple_of(align);
        let mut contents = Vec::new();
        for pass in passes {
            contents.extend_from_slice(bytes_of(&pass));
            contents.resize(contents.len().next_multiple_of(stride), 0);
        }
        Self { buffer: device.constant_buffer("passes", &contents), stride }
    }

    /// Where pass `number` is.
    pub fn offset(&self, number: usize) -> u32 {
        (number * self.stride) as u32
    }

    /// One pass, bound; which one is told by its offset.
    pub fn binding(&self) -> BindingResource<'_> {
        let size = NonZeroU64::new(size_of::<Bounds>() as u64);
        BindingResource::Buffer(BufferBinding { buffer: &self.buffer, offset: 0, size })
    }
}
