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
use crate::pass_volumes::PassVolumes;
use crate::pipelines::{Pipeline, Pipelines};
use crate::shaders::Variant;
use crate::uniforms;
use crate::{Device, GpuError};

/// Volumes that rays are followed through together.
pub struct Followed<'a> {
    /// The volumes.
    pub volumes: PassVolumes<'a>,
    /// What one volume is cut into, as rays meet them; of several the first.
    pub bricks: Vec<Brick>,
    /// What follows rays.
    pub march: Pipeline,
    /// What it reads of tables.
    pub table: BindGroup,
}

/// What is bound to shaders that follow rays through a volume whose lists lie where `lists` says.
pub fn bindings<'a>(
    device: &'a Device,
    stage: &Stage,
    Drawn { volume, resident, optics, uploads }: &Drawn<'a, '_>,
    (drawing, light): (Drawing, Option<&LightVolumes>),
    lists: [u32; 4],
) -> Bindings<'a> {
    let alter = |frame: &mut uniforms::Frame| {
        if let Some(light) = light {
            frame.set_light_points(light.depth, light.part_from_world * volume.volume.grid().world_from_index());
        }
        frame.lists = lists;
    };
    let bindings = Bindings::new(device, resident, (stage, volume), (optics, uploads), drawing.interpolation, alter);
    let mut bindings = bindings.with_light(light.map(|light| light.points.clone()));
    bindings.variant = Variant {
        skip: optics.blocks.is_some(),
        // The many rounds of wide kernels are for several passes.
        wavefront: drawing.passes == Passes::Wavefront || bindings.variant.kernels,
        strides: optics.blocks.is_some_and(|blocks| blocks.levels.is_some()),
        ..bindings.variant
    };
    bindings
}

impl<'a> Followed<'a> {
    /// What follows rays through these volumes; by turns if `wavefront` says so.
    ///
    /// # Errors
    /// What the device reports; [`GpuError::Volumes`] if a pass cannot be given as many volumes.
    pub fn new(
        device: &'a Device,
        pipelines: &mut Pipelines,
        stage: &Stage,
        volumes: PassVolumes<'a>,
        wavefront: bool,
    ) -> Result<Self, GpuError> {
        let variants = volumes.variants().map(|variant| Variant { wavefront, ..variant });
        let march = pipelines.of_layers(device, variants.collect())?.clone();
        let mut bricks = volumes.first().resident.bricks.clone();
        bricks::sort(&mut bricks, stage, volumes.first().volume.volume.grid());
        Ok(Self { table: volumes.table_group(&march.groups), volumes, bricks, march })
    }

    /// The textures of a brick or, of several volumes, of all of them: bound.
    ///
    /// # Errors
    /// As [`PassVolumes::volume_group`].
    pub fn volume_group(&mut self, brick: &Brick, control: &Control) -> Result<BindGroup, GpuError> {
        self.volumes.volume_group(&self.march.groups, brick, control)
    }

    /// What its shader is told of the frame and its passes, with what is the pass's own.
    pub fn frame_group(&self, passes: &BoundsBuffer, own: &[Named]) -> BindGroup {
        self.volumes.frame_group(&self.march.groups, passes, own)
    }
}
