//! What slices are blended in.

use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, Extent3d, TextureDescriptor, TextureDimension, TextureFormat,
    TextureUsages, TextureView,
};

use super::blending::Blending;
use crate::Device;

/// The depth of what is done: before all slices.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Side of a square of pixels whose least opacity is kept; `slice_tiles.wgsl` has the same.
pub const TILE: u32 = 16;

/// The textures of a band of the picture.
pub struct Canvas {
    size: [u32; 2],
    formats: [TextureFormat; 2],
    /// Colours.
    pub colors: TextureView,
    /// Samples taken and seen.
    pub counts: TextureView,
    /// Which pixels are done.
    pub done: TextureView,
    /// Least opacities of squares of pixels.
    pub tiles: Buffer,
}

impl Canvas {
    /// Bytes per pixel of a band, at most.
    pub const PIXEL_BYTES: u64 = 16 + 8 + 4;

    /// Textures for a band of this size.
    pub fn new(device: &Device, size: [u32; 2], blending: &Blending) -> Self {
        let [width, height] = size;
        let texture = |label, format, usage| {
            let texture = device.device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: usage | TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let tiles = u64::from(width.div_ceil(TILE)) * u64::from(height.div_ceil(TILE));
        Self {
            size,
            formats: [blending.format, blending.counts],
            colors: texture("slices", blending.format, TextureUsages::TEXTURE_BINDING),
            counts: texture("counts", blending.counts, TextureUsages::TEXTURE_BINDING),
            done: texture("done", DEPTH, TextureUsages::empty()),
            tiles: device.device.create_buffer(&BufferDescriptor {
                label: Some("tiles"),
                size: tiles * 4,
                usage: BufferUsages::STORAGE,
                mapped_at_creation: false,
            }),
        }
    }

    /// Whether this is a band of that size for that blending.
    pub fn fits(&self, size: [u32; 2], blending: &Blending) -> bool {
        self.size == size && self.formats == [blending.format, blending.counts]
    }
}
