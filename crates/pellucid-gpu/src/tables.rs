//! Tables and blocks on the device, kept while only camera and light change.

use std::sync::Arc;

use bytemuck::{Pod, cast_slice};
use pellucid_field::Volume;
use pellucid_optics::TransferFunction;
use pellucid_scene::{BLUE_NOISE_TILE, Quality, Stage, StageVolume, Technique, blue_noise};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

use crate::optics::{BlockCache, BlockContent, BlockMap, Optics};
use crate::{Device, GpuError, texture};

/// Everything that tables depend on.
#[derive(PartialEq)]
struct Settings {
    transfer_function: TransferFunction,
    component: usize,
    step: f64,
    unit_distance: f64,
    quality: Quality,
    technique: Technique,
}

/// The tables of a stage, uploaded.
pub struct Tables {
    volume: Arc<Volume>,
    settings: Settings,
    /// What they were made of.
    pub optics: Optics,
    /// Colours and opacities.
    pub entries: Buffer,
    /// What rays ask of blocks.
    pub blocks: TextureView,
    /// Isosurfaces.
    pub levels: Buffer,
    /// The tile of blue noise.
    pub noise: Buffer,
}

impl Tables {
    /// Makes the tables of a stage, or takes those that are there if they are the same.
    ///
    /// # Errors
    /// As [`Optics::new`].
    pub fn of(
        old: Option<Self>,
        device: &Device,
        stage: &Stage,
        volume: &StageVolume,
        cache: &mut BlockCache,
    ) -> Result<Self, GpuError> {
        let settings = Settings {
            transfer_function: volume.transfer_function.clone(),
            component: volume.component,
            step: stage.step,
            unit_distance: volume.unit_distance(),
            quality: stage.quality.clone(),
            technique: stage.technique.clone(),
        };
        if let Some(old) = old
            && Arc::ptr_eq(&old.volume, &volume.volume)
            && old.settings == settings
        {
            return Ok(old);
        }
        let optics = Optics::new(stage, volume, cache)?;
        let noise: Vec<f32> = (0..BLUE_NOISE_TILE * BLUE_NOISE_TILE)
            .map(|cell| blue_noise(cell % BLUE_NOISE_TILE, cell / BLUE_NOISE_TILE, 0) as f32)
            .collect();
        Ok(Self {
            volume: volume.volume.clone(),
            settings,
            entries: storage(device, "table", &optics.entries),
            blocks: block_texture(device, optics.blocks.as_ref(), optics.pass.compares_extremes()),
            levels: storage(device, "levels", &optics.levels),
            noise: storage(device, "noise", &noise),
            optics,
        })
    }
}

/// A buffer that shaders read; never empty, as bindings cannot be.
pub fn storage<T: Pod>(device: &Device, label: &str, content: &[T]) -> Buffer {
    let nothing = [0u8; 64];
    let contents = if content.is_empty() { &nothing } else { cast_slice(content) };
    let usage = BufferUsages::STORAGE;
    device.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
}

/// The blocks as a texture; a single one where none is asked.
fn block_texture(device: &Device, blocks: Option<&BlockMap>, extremes: bool) -> TextureView {
    let format = if extremes { TextureFormat::R32Float } else { TextureFormat::R8Uint };
    let (dims, bytes): ([usize; 3], &[u8]) = match blocks {
        None => ([1; 3], &[0; 4]),
        Some(BlockMap { dims, content: BlockContent::Distances(distances), .. }) => (*dims, distances),
        Some(BlockMap { dims, content: BlockContent::Extremes(extremes), .. }) => (*dims, cast_slice(extremes)),
    };
    let texture = texture::of_bytes(device, "blocks", format, dims, bytes);
    texture.create_view(&Default::default())
}
