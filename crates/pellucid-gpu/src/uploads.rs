//! Tables and blocks on the device, kept while only camera and light change.

use std::sync::Arc;

use bytemuck::{Pod, cast_slice};
use pellucid_plan::{BLUE_NOISE_TILE, BlockContent, BlockMap, ColorGrid, Tables, blue_noise};
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

use crate::noise::UploadedNoise;
use crate::optics::Optics;
use crate::scattering::HEADER;
use crate::shaders::Pass;
use crate::{Device, texture};

/// The tables of a stage, uploaded.
pub struct Uploads {
    of: Arc<Tables>,
    pass: Pass,
    bleeds: bool,
    /// Colours and opacities, tables of scattering, and where the former are if their nodes are not even.
    pub entries: Buffer,
    /// What rays ask of blocks.
    pub blocks: TextureView,
    /// Noise on the volume, if there is some.
    pub perturbation: Option<UploadedNoise>,
    /// The colours of voxels, if samples have them, and what they were.
    pub colors: Option<(Arc<ColorGrid>, TextureView)>,
    /// How samples scatter.
    pub scattering: [[f32; 4]; HEADER],
    /// Isosurfaces.
    pub levels: Buffer,
    /// The tile of blue noise.
    pub blue_noise: TextureView,
}

impl Uploads {
    /// Uploads tables.
    pub fn new(device: &Device, tables: &Arc<Tables>, optics: &Optics, colors: Option<Arc<ColorGrid>>) -> Self {
        let noise: Vec<f32> = (0..BLUE_NOISE_TILE * BLUE_NOISE_TILE)
            .map(|cell| blue_noise(cell % BLUE_NOISE_TILE, cell / BLUE_NOISE_TILE, 0) as f32)
            .collect();
        let (scattering, scattered) = optics.scattering();
        Self {
            of: tables.clone(),
            pass: optics.pass,
            bleeds: optics.bleeds,
            entries: storage(device, "table", &[&*optics.entries, &scattered, optics.nodes.knots()].concat()),
            blocks: block_texture(device, optics.blocks, optics.pass.compares_extremes()),
            perturbation: UploadedNoise::new(device, tables),
            colors: colors.map(|colors| {
                let bytes = cast_slice(colors.texels());
                let view = texture::solid(device, "colors", TextureFormat::Rgba16Uint, colors.dims(), bytes);
                (colors, view)
            }),
            scattering,
            levels: storage(device, "levels", &optics.levels),
            blue_noise: texture::flat(
                device,
                "blue noise",
                TextureFormat::R32Float,
                [BLUE_NOISE_TILE; 2],
                cast_slice(&noise),
            ),
        }
    }

    /// Whether they are of these tables and colours.
    pub fn are_of(&self, tables: &Arc<Tables>, optics: &Optics, colors: Option<&Arc<ColorGrid>>) -> bool {
        let colored = match (&self.colors, colors) {
            (Some((own, _)), Some(other)) => Arc::ptr_eq(own, other),
            (own, other) => own.is_none() && other.is_none(),
        };
        colored && Arc::ptr_eq(&self.of, tables) && (self.pass, self.bleeds) == (optics.pass, optics.bleeds)
    }
}

/// A buffer that shaders read, and that can be joined to others; never smaller than an element, as bindings cannot be.
pub fn storage<T: Pod>(device: &Device, label: &str, content: &[T]) -> Buffer {
    let nothing = [0u8; 128];
    let contents = if content.is_empty() { &nothing } else { cast_slice(content) };
    device.buffer(label, contents, BufferUsages::STORAGE | BufferUsages::COPY_SRC)
}

/// The blocks as a texture; a single one where none is asked.
fn block_texture(device: &Device, blocks: Option<&BlockMap>, extremes: bool) -> TextureView {
    let none = if extremes { TextureFormat::R32Float } else { TextureFormat::R8Uint };
    let (format, dims, bytes) = match blocks {
        None => (none, [1; 3], vec![0; 4]),
        Some(BlockMap { dims, content, levels, .. }) => match (content, levels) {
            (BlockContent::Distances(distances), None) => (TextureFormat::R8Uint, *dims, distances.clone()),
            (BlockContent::Distances(distances), Some(levels)) => {
                let pairs = distances.iter().zip(levels).flat_map(|(&distance, &level)| [distance, level]);
                (TextureFormat::Rg8Uint, *dims, pairs.collect())
            }
            (BlockContent::Extremes(extremes), _) => {
                // Shaders need not know infinity, which blocks without any value have.
                let bytes = extremes.iter().flat_map(|v| v.max(f32::MIN).to_ne_bytes());
                (TextureFormat::R32Float, *dims, bytes.collect())
            }
        },
    };
    texture::solid(device, "blocks", format, dims, &bytes)
}
