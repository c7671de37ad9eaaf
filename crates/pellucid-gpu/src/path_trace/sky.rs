//! A picture of the sky on the device: the texels of `sky.wgsl`.

use std::sync::Arc;

use pellucid_optics::{Sky, SkyMap};
use wgpu::Buffer;

use crate::uploads::storage;
use crate::{Device, GpuError};

type Four = [f32; 4];

/// A picture that was uploaded, kept while it is the same.
pub struct UploadedSky {
    of: Arc<SkyMap>,
    /// Texels and rows.
    pub texels: Buffer,
}

impl UploadedSky {
    /// Uploads a picture.
    pub fn new(device: &Device, map: &Arc<SkyMap>) -> Self {
        let [_, height] = map.size();
        let texels = map.texels().iter().zip(map.column_shares()).map(|(&[r, g, b], share)| [r, g, b, *share]);
        let rows =
            (0..height).zip(map.row_shares()).map(|(row, share)| [map.side(row), map.side(row + 1), 0.0, *share]);
        let content: Vec<Four> = texels.chain(rows).collect();
        Self { of: map.clone(), texels: storage(device, "sky", &content) }
    }

    /// Whether it is what a sky shows.
    pub fn is_of(&self, sky: Option<&Sky>) -> bool {
        matches!(sky, Some(Sky::Image { map, .. }) if Arc::ptr_eq(map, &self.of))
    }
}

/// Bytes of a sky on the device.
///
/// # Errors
/// [`GpuError::Budget`] for a picture larger than a shader can be given.
pub fn bytes(device: &Device, sky: Option<&Sky>) -> Result<u64, GpuError> {
    let Some(Sky::Image { map, .. }) = sky else { return Ok(0) };
    let [width, height] = map.size().map(|n| n as u64);
    let needed = (width + 1) * height * size_of::<Four>() as u64;
    let limits = &device.capabilities.limits;
    let budget = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if needed > budget {
        let what = format!("a picture of the sky of {width} x {height} texels");
        return Err(GpuError::Budget {
            what,
            needed,
            budget,
            advice: "draw it with --backend cpu, or take a smaller one",
        });
    }
    Ok(needed)
}
