//! A picture of the sky on the device: the texels of `sky.wgsl`.

use std::sync::Arc;

use bytemuck::cast_slice;
use pellucid_optics::{Sky, SkyMap};
use wgpu::{TextureFormat, TextureView};

use crate::four::Four;
use crate::{Device, GpuError, texture};

/// A picture that was uploaded, kept while it is the same.
pub struct UploadedSky {
    of: Arc<SkyMap>,
    /// Texels and, below them, what is told of rows.
    pub texels: TextureView,
}

impl UploadedSky {
    /// Uploads a picture.
    pub fn new(device: &Device, map: &Arc<SkyMap>) -> Self {
        let [_, height] = map.size();
        let texels = map.texels().iter().zip(map.column_shares()).map(|(&[r, g, b], share)| [r, g, b, *share]);
        let rows =
            (0..height).zip(map.row_shares()).map(|(row, share)| [map.side(row), map.side(row + 1), 0.0, *share]);
        let mut content: Vec<Four> = texels.chain(rows).collect();
        let size = size(map);
        content.resize(size[0] * size[1], [0.0; 4]);
        let texels = texture::flat(device, "sky", TextureFormat::Rgba32Float, size, cast_slice(&content));
        Self { of: map.clone(), texels }
    }

    /// Whether it is what a sky shows.
    pub fn is_of(&self, sky: Option<&Sky>) -> bool {
        matches!(sky, Some(Sky::Image { map, .. }) if Arc::ptr_eq(map, &self.of))
    }
}

/// Texels of the texture: those of the picture, and one for each of its rows.
fn size(map: &SkyMap) -> [usize; 2] {
    let [width, height] = map.size();
    [width, height + height.div_ceil(width)]
}

/// Bytes of a sky on the device.
///
/// # Errors
/// [`GpuError::Budget`] for a picture larger than a texture can be.
pub fn bytes(device: &Device, sky: Option<&Sky>) -> Result<u64, GpuError> {
    let Some(Sky::Image { map, .. }) = sky else { return Ok(0) };
    let size = size(map).map(|texels| texels as u64);
    let bytes = |[width, height]: [u64; 2]| width * height * size_of::<Four>() as u64;
    let most = u64::from(device.capabilities.limits.max_texture_dimension_2d);
    if size.into_iter().any(|texels| texels > most) {
        let [width, height] = map.size();
        return Err(GpuError::Budget {
            what: format!("a picture of the sky of {width} x {height} texels"),
            needed: bytes(size),
            budget: bytes(size.map(|texels| texels.min(most))),
            advice: "draw it with --backend cpu, or take a smaller one",
        });
    }
    Ok(bytes(size))
}
