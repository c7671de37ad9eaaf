//! The volume on the device: whole, or as many of its bricks as fit.

use std::sync::Arc;

use pellucid_field::Volume;
use pellucid_scene::{Stage, StageVolume};
use wgpu::{Texture, TextureView, TextureViewDescriptor};

use crate::bricks::{self, Brick};
use crate::texture::{self, Encoding};
use crate::{Device, GpuError};

/// A volume's voxels, cut so that they fit.
pub struct Resident {
    volume: Arc<Volume>,
    component: usize,
    border: usize,
    /// How voxels are held.
    pub encoding: Encoding,
    /// What the volume is cut into.
    pub bricks: Vec<Brick>,
    /// The bricks that are there, the one used last at the end.
    loaded: Vec<(Brick, Texture)>,
    /// Most bricks at the same time.
    room: usize,
}

impl Resident {
    /// The share of the memory that voxels may take; the rest is for tables and targets.
    const SHARE: f64 = 0.75;

    /// Cuts a volume so that it fits. Nothing is uploaded yet.
    ///
    /// # Errors
    /// [`GpuError::Budget`].
    pub fn plan(device: &Device, volume: &StageVolume, stage: &Stage) -> Result<Self, GpuError> {
        let data = &volume.volume;
        let (grid, limits) = (data.grid(), &device.capabilities);
        let encoding = Encoding::of(data, limits);
        let budget = (limits.memory as f64 * Self::SHARE) as u64;
        let whole = grid.dims().iter().map(|&n| n as u64).product::<u64>() * encoding.bytes as u64;
        // If not all fits, one brick is drawn while the next one comes.
        let each = if whole <= budget { u64::MAX } else { budget / 2 };
        let side = limits.limits.max_texture_dimension_3d as usize;
        let border = bricks::border(stage, grid);
        let bricks = bricks::cut(grid.dims(), border, side, encoding.bytes, each.min(1 << 62))?;
        let room = if whole <= budget { bricks.len() } else { 2 };
        Ok(Self {
            volume: data.clone(),
            component: volume.component,
            border,
            encoding,
            bricks,
            loaded: Vec::new(),
            room,
        })
    }

    /// Whether this is a volume, cut as a stage needs it.
    pub fn holds(&self, volume: &StageVolume, stage: &Stage) -> bool {
        Arc::ptr_eq(&self.volume, &volume.volume)
            && self.component == volume.component
            && (self.is_whole() || self.border == bricks::border(stage, volume.volume.grid()))
    }

    /// Whether there is one brick only.
    pub fn is_whole(&self) -> bool {
        self.bricks.len() == 1
    }

    /// Whether all bricks can be there at the same time.
    pub fn is_complete(&self) -> bool {
        self.room >= self.bricks.len()
    }

    /// The texture of a brick, uploaded if it is not there.
    ///
    /// # Errors
    /// What the device reports.
    pub fn texture(&mut self, device: &Device, brick: &Brick) -> Result<TextureView, GpuError> {
        let found = self.loaded.iter().position(|(loaded, _)| loaded == brick);
        let entry = match found {
            Some(place) => self.loaded.remove(place),
            None => {
                if self.loaded.len() >= self.room {
                    // Commands that still use it keep it until they are done.
                    self.loaded.remove(0);
                }
                let texture = texture::create(device, &self.encoding, brick.voxels.dims());
                texture::upload(device, &texture, &self.encoding, &self.volume, self.component, brick.voxels, [0; 3]);
                device.check()?;
                (*brick, texture)
            }
        };
        let view = entry.1.create_view(&TextureViewDescriptor::default());
        self.loaded.push(entry);
        Ok(view)
    }
}
