//! What passes are told of their part of a frame, each kind by a structure of its own: those that `frame.wgsl` calls
//! bounds.

use std::num::NonZeroU64;

use bytemuck::{Pod, Zeroable, bytes_of};
use wgpu::{BindingResource, Buffer, BufferBinding};

use crate::Device;
use crate::four::Four;

/// Rows of the picture, and one of the rays of each of their pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Rows {
    pub first: u32,
    pub count: u32,
    pub ray: u32,
    /// 1 if rays start here.
    pub begin: u32,
}

/// A pass that follows rays through a brick, or adds them to their pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct RayBounds {
    pub rows: Rows,
    pub texture_low: [u32; 3],
    pub most_looks: u32,
    pub core_low: [u32; 3],
    pub list: u32,
    pub core_high: [u32; 3],
    pub list_length: u32,
}

/// A pass that follows paths, or adds them to their pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct PathBounds {
    pub rows: Rows,
}

/// A pass of light through a slab.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct LightBounds {
    pub low: [u32; 2],
    pub high: [u32; 2],
    pub tap: [f32; 2],
    pub slab: [f32; 2],
}

/// Slabs, and the layers that light in front of them is in.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Run {
    pub first: u32,
    pub end: u32,
    pub layers: u32,
    pub layer: u32,
}

/// A pass that looks at a run of slabs.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct EyeBounds {
    pub rows: Rows,
    pub run: Run,
    pub begin_sweep: u32,
}

/// A pass over the points of a light volume that are in a run of slabs.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct PointBounds {
    pub low: Four,
    pub high: Four,
    pub run: Run,
    pub size: [u32; 3],
    pub first: u32,
}

impl Rows {
    /// So many rows from one on, and a ray that has begun.
    pub fn of([first, count, ray]: [u32; 3]) -> Self {
        Self { first, count, ray, begin: 0 }
    }
}

impl LightBounds {
    /// Of a slab.
    pub fn of(slab: u32) -> Self {
        Self { slab: [slab as f32, slab as f32 + 0.5], ..Self::default() }
    }
}

impl Run {
    /// Slabs from the first to the end, in so many layers by turns.
    pub fn of([first, end]: [u32; 2], layers: u32) -> Self {
        Self { first, end, layers, layer: first % layers }
    }
}

/// The bounds of passes of a kind, which are chosen one at a time by an offset.
pub struct BoundsBuffer {
    buffer: Buffer,
    size: usize,
    stride: usize,
}

impl BoundsBuffer {
    /// A buffer of bounds, with room for one at least.
    pub fn new<B: Pod>(device: &Device, bounds: impl IntoIterator<Item = B>) -> Self {
        let limits = &device.capabilities.limits;
        let align = limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment) as usize;
        let stride = size_of::<B>().next_multiple_of(align);
        let mut contents = Vec::new();
        for bounds in bounds {
            contents.extend_from_slice(bytes_of(&bounds));
            contents.resize(contents.len().next_multiple_of(stride), 0);
        }
        contents.resize(contents.len().max(stride), 0);
        Self { buffer: device.constant_buffer("bounds", &contents), size: size_of::<B>(), stride }
    }

    /// Where those of pass `number` are.
    pub fn offset(&self, number: usize) -> u32 {
        (number * self.stride) as u32
    }

    /// Those of one pass, bound; of which one is told by its offset.
    pub fn binding(&self) -> BindingResource<'_> {
        let size = NonZeroU64::new(self.size as u64);
        BindingResource::Buffer(BufferBinding { buffer: &self.buffer, offset: 0, size })
    }
}
