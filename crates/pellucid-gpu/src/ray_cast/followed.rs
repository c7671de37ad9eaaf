//! What a pipeline follows rays through: a volume, whole or in bricks, or several whole ones together.

use pellucid_scene::{Control, Stage};
use wgpu::BindGroup;

use crate::bindings::Bindings;
use crate::bounds::BoundsBuffer;
use crate::bricks::{self, Brick};
use crate::drawing::{Drawing, Passes};
use crate::groups::Named;
use crate::light_volume::LightVolumes;
use crate::on_device::Drawn;
use crate::pipelines::{Pipeline, Pipelines};
use crate::resident::Resident;
use crate::shaders::Variant;
use crate::uniforms;
use crate::{Device, GpuError};

use super::lists::Lists;

/// A volume on the device, and what shaders are given of it.
pub struct OnRays<'a> {
    /// Its voxels.
    pub resident: &'a mut Resident,
    /// What shaders are given besides.
    pub bindings: Bindings<'a>,
    /// What it is cut into, as rays meet them.
    bricks: Vec<Brick>,
}

/// Volumes that rays are followed through together.
pub struct Followed<'a> {
    device: &'a Device,
    /// In the order in which they are merged.
    volumes: Vec<OnRays<'a>>,
    /// Their lists, if they are several.
    lists: Option<Lists>,
    /// What follows rays.
    pub march: Pipeline,
    /// What it reads of tables.
    pub table: BindGroup,
}

impl<'a> OnRays<'a> {
    /// A volume whose lists lie where `places` says.
    pub fn new(
        device: &'a Device,
        stage: &Stage,
        Drawn { volume, resident, optics, uploads }: Drawn<'a, '_>,
        (drawing, light): (Drawing, Option<&LightVolumes>),
        [entries, planes, lights]: [u32; 3],
    ) -> Self {
        let alter = |frame: &mut uniforms::Frame| {
            frame.set_light_points(light.map_or(0, |light| light.depth));
            frame.lists = [entries, planes, lights, 0];
        };
        let mut bindings =
            Bindings::new(device, resident, (stage, volume), (optics, uploads), drawing.interpolation, alter)
                .with_light(light.map(|light| light.points.clone()));
        bindings.variant = Variant {
            skip: optics.blocks.is_some(),
            // The many rounds of wide kernels are for several passes.
            wavefront: drawing.passes == Passes::Wavefront || bindings.variant.kernels,
            strides: optics.blocks.is_some_and(|blocks| blocks.levels.is_some()),
            ..bindings.variant
        };
        let mut bricks = resident.bricks.clone();
        bricks::sort(&mut bricks, stage, volume.volume.grid());
        Self { resident, bindings, bricks }
    }
}

impl<'a> Followed<'a> {
    /// What follows rays through these volumes; by turns if `wavefront` says so.
    ///
    /// # Errors
    /// What the device reports; [`GpuError::Volumes`] if a pass cannot be given as many volumes.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        volumes: Vec<OnRays<'a>>,
        wavefront: bool,
    ) -> Result<Self, GpuError> {
        let variant = |volume: &OnRays| Variant { wavefront, ..volume.bindings.variant };
        let march = pipelines.of_layers(device, volumes.iter().map(variant).collect())?.clone();
        let each: Vec<_> = volumes.iter().map(|volume| volume.bindings.lists()).collect();
        let lists = (volumes.len() > 1).then(|| Lists::joined(device, &each));
        let table = match &lists {
            Some(lists) => march.groups.tables().bind(device, &lists.named().collect::<Vec<_>>()),
            None => volumes[0].bindings.table_group(&march.groups),
        };
        Ok(Self { device, volumes, lists, march, table })
    }

    /// The first of the volumes: what all have in common is told of it.
    pub fn first(&self) -> &OnRays<'a> {
        &self.volumes[0]
    }

    /// What one volume is cut into, as rays meet them; of several the first.
    pub fn bricks(&self) -> &[Brick] {
        &self.volumes[0].bricks
    }

    /// All volumes.
    pub fn residents(&mut self) -> impl Iterator<Item = &mut Resident> {
        self.volumes.iter_mut().map(|volume| &mut *volume.resident)
    }

    /// The textures of a brick or, of several volumes, of all of them: bound.
    ///
    /// # Errors
    /// As [`Resident::textures`].
    pub fn volume_group(&mut self, brick: &Brick, control: &Control) -> Result<BindGroup, GpuError> {
        let mut views = Vec::with_capacity(self.volumes.len());
        for (number, OnRays { resident, .. }) in self.volumes.iter_mut().enumerate() {
            // Of several volumes each is whole.
            let brick = if number == 0 { *brick } else { resident.bricks[0] };
            views.push(resident.textures(self.device, &brick, control)?);
        }
        let of = self.volumes.iter().zip(&views).map(|(volume, views)| volume.bindings.of_volume(views));
        Ok(self.march.groups.volume().bind_layers(self.device, &of.collect::<Vec<_>>()))
    }

    /// What a pipeline is told of the frame and its passes, with what is the pass's own.
    pub fn frame_group(&self, pipeline: &Pipeline, passes: &BoundsBuffer, own: Vec<Named>) -> BindGroup {
        let mut layers: Vec<_> = self.volumes.iter().map(|volume| volume.bindings.of_frame(passes)).collect();
        // What is found first is bound.
        layers[0].splice(0..0, self.lists.iter().flat_map(Lists::named).chain(own));
        pipeline.groups.frame().bind_layers(self.device, &layers)
    }

    /// Most looks at the blocks in a pass.
    pub fn most_looks(&self) -> u32 {
        self.volumes.iter().map(|volume| volume.bindings.most_looks).min().unwrap_or(u32::MAX)
    }

    /// Most rows of the picture at once.
    pub fn most_rows(&self) -> u32 {
        self.volumes.iter().map(|volume| volume.resident.plan.rows).min().unwrap_or(1)
    }
}
