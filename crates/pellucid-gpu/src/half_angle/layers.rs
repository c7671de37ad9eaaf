//! Light in front of slabs: layers of texels, each as large as the light's picture and a rim around it.

use wgpu::{
    Color, CommandEncoder, Extent3d, LoadOp, Operations, RenderPassColorAttachment, RenderPassDescriptor, StoreOp,
    Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
    TextureViewDimension,
};

use crate::Device;

/// What light has lost, in layers that are filled by turns.
pub struct Layers {
    texture: Texture,
    /// Where a slab holds something.
    pub held: TextureView,
    /// All of them.
    pub all: TextureView,
    /// One at a time, to be read and to be written.
    pub each: Vec<[TextureView; 2]>,
}

impl Layers {
    /// Bytes of a texel.
    const TEXEL_BYTES: u64 = 16;

    /// Texels on both sides of a picture that stay as they are.
    const RIM: u32 = 2;

    /// Sides of layers for pictures of so many texels.
    pub fn sides(size: [u32; 2]) -> [u32; 2] {
        size.map(|texels| texels + Self::RIM)
    }

    /// Bytes of so many layers for pictures of so many texels, and of the mark of what a slab holds.
    pub fn bytes(size: [u32; 2], count: u32) -> u64 {
        let texels: u64 = Self::sides(size).into_iter().map(u64::from).product();
        texels * (u64::from(count) * Self::TEXEL_BYTES + 4)
    }

    fn new(device: &Device, size: [u32; 2], count: u32) -> Self {
        let [width, height] = Self::sides(size);
        let texture = |label, format, layers, usage| {
            device.device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d { width, height, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING,
                view_formats: &[],
            })
        };
        let held = texture("held", TextureFormat::R32Float, 1, TextureUsages::empty());
        let texture = texture("light", TextureFormat::Rgba32Float, count, TextureUsages::RENDER_ATTACHMENT);
        let view = |first, count, dimension| {
            texture.create_view(&TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer: first,
                array_layer_count: Some(count),
                ..Default::default()
            })
        };
        use TextureViewDimension::{D2, D2Array};
        Self {
            held: held.create_view(&Default::default()),
            all: view(0, count, D2Array),
            each: (0..count).map(|layer| [view(layer, 1, D2Array), view(layer, 1, D2)]).collect(),
            texture,
        }
    }

    /// Those that are there, if they are as large and enough, or new ones: the old ones go first.
    pub fn kept<'l>(slot: &'l mut Option<Self>, device: &Device, size: [u32; 2], count: u32) -> &'l Self {
        slot.take_if(|layers| {
            let Extent3d { width, height, depth_or_array_layers } = layers.texture.size();
            [width, height] != Self::sides(size) || depth_or_array_layers < count
        });
        slot.get_or_insert_with(|| Self::new(device, size, count))
    }

    /// Light as it enters, everywhere.
    pub fn clear(&self, encoder: &mut CommandEncoder) {
        for [_, view] in &self.each {
            let ops = Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store };
            let attachment = RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
            encoder.begin_render_pass(&RenderPassDescriptor {
                label: Some("light"),
                color_attachments: &[Some(attachment)],
                ..Default::default()
            });
        }
    }
}
