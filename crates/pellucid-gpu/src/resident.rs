//! The volume on the device: whole, or as many of its bricks as fit.

use std::sync::Arc;

use pellucid_field::Volume;
use pellucid_scene::{Control, StageVolume};
use wgpu::{SubmissionIndex, Texture, TextureView, TextureViewDescriptor};

use crate::bricks::Brick;
use crate::plan::MemoryPlan;
use crate::staging::Staging;
use crate::texture::{self, Encoding, Part};
use crate::{Device, GpuError};

/// A volume's voxels, cut so that they fit.
pub struct Resident {
    volume: Arc<Volume>,
    component: usize,
    /// How voxels are held.
    pub encoding: Encoding,
    /// What the volume is cut into.
    pub bricks: Vec<Brick>,
    /// How it fits into memory.
    pub plan: MemoryPlan,
    /// The bricks that are there, the one used last at the end.
    loaded: Vec<Loaded>,
    staging: Staging,
}

struct Loaded {
    brick: Brick,
    texture: Texture,
    /// The last commands that read it.
    used: Option<SubmissionIndex>,
}

impl Resident {
    /// A volume of which nothing is uploaded yet.
    pub fn new(
        device: &Device,
        volume: &StageVolume,
        encoding: Encoding,
        plan: MemoryPlan,
        bricks: Vec<Brick>,
    ) -> Self {
        Self {
            volume: volume.volume.clone(),
            component: volume.component,
            encoding,
            bricks,
            staging: Staging::new(device, plan.staging),
            plan,
            loaded: Vec::new(),
        }
    }

    /// Whether this is a volume, cut in this way and with as much memory.
    pub fn holds(&self, volume: &StageVolume, plan: &MemoryPlan, bricks: &[Brick]) -> bool {
        Arc::ptr_eq(&self.volume, &volume.volume)
            && self.component == volume.component
            && self.bricks == bricks
            && (self.plan.loaded, self.plan.staging) == (plan.loaded, plan.staging)
    }

    /// Whether there is one brick only.
    pub fn is_whole(&self) -> bool {
        self.bricks.len() == 1
    }

    /// Whether all bricks can be there at the same time.
    pub fn is_complete(&self) -> bool {
        self.plan.loaded >= self.bricks.len()
    }

    /// The texture of a brick, uploaded if it is not there.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn texture(&mut self, device: &Device, brick: &Brick, control: &Control) -> Result<TextureView, GpuError> {
        let found = self.loaded.iter().position(|loaded| loaded.brick == *brick);
        let entry = match found {
            Some(place) => self.loaded.remove(place),
            None => {
                if self.loaded.len() >= self.plan.loaded {
                    // Its memory is free once nothing reads it any more.
                    let passed = self.loaded.remove(0);
                    passed.used.map_or(Ok(()), |used| device.wait_for(used))?;
                }
                let texture = texture::create(device, &self.encoding, brick.voxels.dims());
                device.check()?;
                self.upload(device, &texture, brick, brick.voxels, control)?;
                Loaded { brick: *brick, texture, used: None }
            }
        };
        let view = entry.texture.create_view(&TextureViewDescriptor::default());
        self.loaded.push(entry);
        Ok(view)
    }

    /// Tells that submitted commands read the brick asked for last.
    pub fn used(&mut self, by: SubmissionIndex) {
        if let Some(last) = self.loaded.last_mut() {
            last.used = Some(by);
        }
    }

    /// Takes another volume that differs in one part only, and uploads that. Returns whether it could:
    /// another shape, type or coding needs new textures.
    ///
    /// # Errors
    /// What the device reports.
    pub fn update(
        &mut self,
        device: &Device,
        volume: &Arc<Volume>,
        encoding: &Encoding,
        part: Part,
    ) -> Result<bool, GpuError> {
        let shape = |volume: &Volume| (*volume.grid(), volume.components(), volume.value_map());
        if shape(volume) != shape(&self.volume) || *encoding != self.encoding {
            return Ok(false);
        }
        self.volume = volume.clone();
        let loaded = std::mem::take(&mut self.loaded);
        let mut sent = Ok(());
        for entry in &loaded {
            if let Some(part) = part.common(&entry.brick.voxels) {
                sent = sent.and_then(|()| self.upload(device, &entry.texture, &entry.brick, part, &Control::default()));
            }
        }
        // What is only partly new is of no use.
        self.loaded = if sent.is_ok() { loaded } else { Vec::new() };
        sent.map(|()| true)
    }

    /// Sends a part of a brick's voxels on their way.
    fn upload(
        &mut self,
        device: &Device,
        texture: &Texture,
        brick: &Brick,
        part: Part,
        control: &Control,
    ) -> Result<(), GpuError> {
        let at = [0, 1, 2].map(|axis| part.low[axis] - brick.voxels.low[axis]);
        let (volume, encoding, width) = (&self.volume, &self.encoding, part.dims()[0]);
        let fill = |bytes: &mut Vec<u8>, y, z| {
            let first = volume.grid().linear_index([part.low[0], part.low[1] + y, part.low[2] + z]);
            encoding.append(bytes, volume, self.component, first, width);
        };
        let go_on = || if control.is_cancelled() { Err(GpuError::Cancelled) } else { Ok(()) };
        self.staging.write(device, texture, at, part.dims(), fill, go_on)
    }
}
