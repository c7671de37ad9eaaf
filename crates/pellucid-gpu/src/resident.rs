//! The volume on the device: whole, or as many of its bricks as fit.

use std::sync::Arc;

use pellucid_field::Volume;
use pellucid_scene::Control;
use wgpu::{SubmissionIndex, Texture, TextureView, TextureViewDescriptor, TextureViewDimension};

use crate::bricks::Brick;
use crate::plan::MemoryPlan;
use crate::staging::Staging;
use crate::texture::{self, Encoding, Layout, Part, Source};
use crate::{Device, GpuError};

/// A volume's voxels, cut so that they fit.
pub struct Resident {
    /// What the field is made of and, if that is coefficients, the voxels that are classified.
    sources: Vec<Source>,
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
    layout: Layout,
    /// One for each source.
    textures: Vec<Texture>,
    /// The last commands that read it.
    used: Option<SubmissionIndex>,
}

impl Resident {
    /// A volume of which nothing is uploaded yet.
    pub fn new(device: &Device, sources: Vec<Source>, plan: MemoryPlan, bricks: Vec<Brick>) -> Self {
        Self { sources, bricks, staging: Staging::new(device, plan.staging), plan, loaded: Vec::new() }
    }

    /// Whether this is what is read, cut in this way and with as much memory.
    pub fn holds(&self, sources: &[Source], plan: &MemoryPlan, bricks: &[Brick]) -> bool {
        self.sources.len() == sources.len()
            && self.sources.iter().zip(sources).all(|(source, other)| source.is(other))
            && self.bricks == bricks
            && (self.plan.loaded, self.plan.staging) == (plan.loaded, plan.staging)
    }

    /// What the field is made of.
    pub fn field(&self) -> &Source {
        &self.sources[0]
    }

    /// The voxels themselves.
    pub fn voxels(&self) -> &Source {
        &self.sources[self.sources.len() - 1]
    }

    /// Whether there is one brick only.
    pub fn is_whole(&self) -> bool {
        self.bricks.len() == 1
    }

    /// Whether all bricks can be there at the same time.
    pub fn is_complete(&self) -> bool {
        self.plan.loaded >= self.bricks.len()
    }

    /// The textures of a brick, of the field and of the voxels, uploaded if they are not there in the plan's
    /// layout.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`], or what the device reports.
    pub fn textures(
        &mut self,
        device: &Device,
        brick: &Brick,
        control: &Control,
    ) -> Result<[TextureView; 2], GpuError> {
        let layout = self.plan.layout;
        let is_it = |loaded: &Loaded| loaded.brick == *brick && loaded.layout == layout;
        let found = self.loaded.iter().position(is_it);
        let entry = match found {
            Some(place) => self.loaded.remove(place),
            None => {
                if self.loaded.len() >= self.plan.loaded {
                    // Its memory is free once nothing reads it any more.
                    let passed = self.loaded.remove(0);
                    passed.used.map_or(Ok(()), |used| device.wait_for(used))?;
                }
                let create = |source: &Source| texture::create(device, &source.encoding, layout, brick.voxels.dims());
                let textures: Vec<Texture> = self.sources.iter().map(create).collect();
                device.check()?;
                let entry = Loaded { brick: *brick, layout, textures, used: None };
                for source in 0..entry.textures.len() {
                    self.upload(device, source, &entry, brick.voxels, control)?;
                }
                entry
            }
        };
        let last = entry.textures.len() - 1;
        // A stack of one layer is one all the same.
        let dimension = if layout == Layout::Solid { TextureViewDimension::D3 } else { TextureViewDimension::D2Array };
        let view = TextureViewDescriptor { dimension: Some(dimension), ..Default::default() };
        let views = [0, last].map(|source| entry.textures[source].create_view(&view));
        self.loaded.push(entry);
        Ok(views)
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
        // Coefficients of a filter change everywhere.
        let [source] = &mut self.sources[..] else { return Ok(false) };
        if shape(volume) != shape(&source.volume) || *encoding != source.encoding {
            return Ok(false);
        }
        source.volume = volume.clone();
        let loaded = std::mem::take(&mut self.loaded);
        let (mut sent, control) = (Ok(()), Control::default());
        for entry in &loaded {
            if let Some(part) = part.common(&entry.brick.voxels) {
                sent = sent.and_then(|()| self.upload(device, 0, entry, part, &control));
            }
        }
        // What is only partly new is of no use.
        self.loaded = if sent.is_ok() { loaded } else { Vec::new() };
        sent.map(|()| true)
    }

    /// Sends a part of a brick's voxels, of one source, on their way.
    fn upload(
        &mut self,
        device: &Device,
        source: usize,
        entry: &Loaded,
        part: Part,
        control: &Control,
    ) -> Result<(), GpuError> {
        let Source { volume, component, encoding } = &self.sources[source];
        let grid = volume.grid();
        let axes = entry.layout.axes();
        let [at, dims] = [
            axes.map(|axis| part.low[axis] - entry.brick.voxels.low[axis]),
            axes.map(|axis| part.high[axis] - part.low[axis]),
        ];
        let [nx, ny, _] = grid.dims();
        let stride = [1, nx, nx * ny][axes[0]];
        let fill = |bytes: &mut Vec<u8>, row, layer| {
            let mut voxel = part.low;
            voxel[axes[1]] += row;
            voxel[axes[2]] += layer;
            encoding.append(bytes, (volume, *component), grid.linear_index(voxel), stride, dims[0]);
        };
        let go_on = || if control.is_cancelled() { Err(GpuError::Cancelled) } else { Ok(()) };
        self.staging.write(device, &entry.textures[source], at, dims, fill, go_on)
    }
}
