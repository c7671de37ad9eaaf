//! The volume on the device: whole, or as many of its bricks as fit.

use std::sync::Arc;

use pellucid_field::Volume;
use pellucid_scene::{Stage, StageVolume, Tables};
use wgpu::{Texture, TextureView, TextureViewDescriptor};

use crate::bricks::{self, Brick};
use crate::texture::{self, Encoding};
use crate::{Device, GpuError};

/// A component of a volume.
pub struct Source {
    volume: Arc<Volume>,
    component: usize,
    encoding: Encoding,
}

impl Source {
    fn new(device: &Device, volume: &Arc<Volume>, component: usize) -> Self {
        Self { volume: volume.clone(), component, encoding: Encoding::of(volume, &device.capabilities) }
    }

    fn is(&self, volume: &Arc<Volume>, component: usize) -> bool {
        Arc::ptr_eq(&self.volume, volume) && self.component == component
    }

    /// What a shader reads, times the first and plus the second, is the data value.
    pub fn data(&self) -> [f64; 2] {
        self.encoding.data(&self.volume)
    }
}

/// A volume's voxels, cut so that they fit.
pub struct Resident {
    /// What the field is made of and, if that is coefficients, the voxels that are classified.
    sources: Vec<Source>,
    border: usize,
    /// What the volume is cut into.
    pub bricks: Vec<Brick>,
    /// The bricks that are there, the one used last at the end.
    loaded: Vec<(Brick, Vec<Texture>)>,
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
    pub fn plan(device: &Device, volume: &StageVolume, tables: &Tables, stage: &Stage) -> Result<Self, GpuError> {
        let (grid, limits) = (volume.volume.grid(), &device.capabilities);
        let sources: Vec<Source> =
            wanted(volume, tables, stage).map(|(volume, component)| Source::new(device, volume, component)).collect();
        let bytes: usize = sources.iter().map(|source| source.encoding.bytes).sum();
        let budget = (limits.memory as f64 * Self::SHARE) as u64;
        let whole = grid.dims().iter().map(|&n| n as u64).product::<u64>() * bytes as u64;
        // If not all fits, one brick is drawn while the next one comes.
        let each = if whole <= budget { u64::MAX } else { budget / 2 };
        let side = limits.limits.max_texture_dimension_3d as usize;
        let border = bricks::border(stage, grid);
        let bricks = bricks::cut(grid.dims(), border, side, bytes, each.min(1 << 62))?;
        let room = if whole <= budget { bricks.len() } else { 2 };
        Ok(Self { sources, border, bricks, loaded: Vec::new(), room })
    }

    /// Whether this is a volume, cut as a stage needs it.
    pub fn holds(&self, volume: &StageVolume, tables: &Tables, stage: &Stage) -> bool {
        let wanted: Vec<_> = wanted(volume, tables, stage).collect();
        let same = |(source, &(volume, component)): (&Source, &(_, _))| source.is(volume, component);
        self.sources.len() == wanted.len()
            && self.sources.iter().zip(&wanted).all(same)
            && (self.is_whole() || self.border == bricks::border(stage, volume.volume.grid()))
    }

    /// What the field is made of.
    pub fn field(&self) -> &Source {
        &self.sources[0]
    }

    /// The voxels themselves.
    pub fn voxels(&self) -> &Source {
        &self.sources[self.sources.len() - 1]
    }

    /// How the field is held.
    pub fn encoding(&self) -> &Encoding {
        &self.field().encoding
    }

    /// Whether there is one brick only.
    pub fn is_whole(&self) -> bool {
        self.bricks.len() == 1
    }

    /// Whether all bricks can be there at the same time.
    pub fn is_complete(&self) -> bool {
        self.room >= self.bricks.len()
    }

    /// The textures of a brick, of the field and of the voxels, uploaded if they are not there.
    ///
    /// # Errors
    /// What the device reports.
    pub fn textures(&mut self, device: &Device, brick: &Brick) -> Result<[TextureView; 2], GpuError> {
        let found = self.loaded.iter().position(|(loaded, _)| loaded == brick);
        let entry = match found {
            Some(place) => self.loaded.remove(place),
            None => {
                if self.loaded.len() >= self.room {
                    // Commands that still use it keep it until they are done.
                    self.loaded.remove(0);
                }
                let upload = |Source { volume, component, encoding }: &Source| {
                    let texture = texture::create(device, encoding, brick.voxels.dims());
                    texture::upload(device, &texture, encoding, volume, *component, brick.voxels, [0; 3]);
                    texture
                };
                let textures = self.sources.iter().map(upload).collect();
                device.check()?;
                (*brick, textures)
            }
        };
        let last = entry.1.len() - 1;
        let views = [0, last].map(|source| entry.1[source].create_view(&TextureViewDescriptor::default()));
        self.loaded.push(entry);
        Ok(views)
    }
}

/// What a stage reads: the field and, where that is coefficients, the voxels that are classified.
fn wanted<'a>(
    volume: &'a StageVolume,
    tables: &'a Tables,
    stage: &Stage,
) -> impl Iterator<Item = (&'a Arc<Volume>, usize)> + use<'a> {
    let both = stage.classifies_voxels() && !Arc::ptr_eq(&tables.field, &volume.volume);
    let voxels = both.then_some((&volume.volume, volume.component));
    std::iter::once((&tables.field, tables.component)).chain(voxels)
}
