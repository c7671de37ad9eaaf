//! The pipelines that draw slices.

use std::collections::HashMap;

use wgpu::{
    ColorTargetState, ColorWrites, CompareFunction, DepthStencilState, FragmentState, PrimitiveState, RenderPipeline,
    RenderPipelineDescriptor, VertexState,
};

use super::blending::{Blending, SUM};
use super::targets::DEPTH;
use crate::groups::Groups;
use crate::pipelines::{Shader, check_limits, shader};
use crate::shaders::{Pass, Variant};
use crate::{Device, GpuError};

/// A pipeline that draws, and what is bound to it.
#[derive(Clone)]
pub struct DrawPipeline {
    /// The pipeline.
    pub pipeline: RenderPipeline,
    /// What is bound to it.
    pub groups: Groups,
}

/// The pipelines of a device, made when they are first needed.
#[derive(Default)]
pub struct DrawPipelines {
    slices: HashMap<(Vec<Variant>, Pass, Blending), DrawPipeline>,
    done: Option<DrawPipeline>,
}

impl DrawPipelines {
    /// Draws what a variant, or those of several volumes, make of fragments on the proxies that a pass makes.
    ///
    /// # Errors
    /// [`GpuError::Shader`], or what the device reports; [`GpuError::Volumes`] if it cannot be given as many volumes.
    pub fn slices(
        &mut self,
        device: &Device,
        layers: Vec<Variant>,
        proxies: Pass,
        blending: Blending,
    ) -> Result<DrawPipeline, GpuError> {
        let layers = layers.into_iter().map(Variant::canonical).collect();
        let key = (layers, proxies, blending);
        if let Some(found) = self.slices.get(&key) {
            return Ok(found.clone());
        }
        let target =
            |format, blend| Some(ColorTargetState { format, blend: Some(blend), write_mask: ColorWrites::ALL });
        let fragments = shader(device, &key.0)?;
        check_limits(&device.capabilities.limits, key.0.len(), &fragments.resources)?;
        let made = make(
            device,
            [&shader(device, &[Variant::of(proxies)])?, &fragments],
            &[target(blending.format, blending.state), target(blending.counts, SUM)],
            CompareFunction::Less,
        );
        device.check()?;
        Ok(self.slices.entry(key).or_insert(made).clone())
    }

    /// Marks the pixels that are done.
    ///
    /// # Errors
    /// As [`DrawPipelines::slices`].
    pub fn done(&mut self, device: &Device) -> Result<DrawPipeline, GpuError> {
        if let Some(found) = &self.done {
            return Ok(found.clone());
        }
        let both = shader(device, &[Variant::of(Pass::SliceDone)])?;
        let made = make(device, [&both; 2], &[], CompareFunction::Always);
        device.check()?;
        Ok(self.done.insert(made).clone())
    }
}

/// What has targets only compares depths, the other writes them: tests before fragments stay possible (2.4-5).
fn make(
    device: &Device,
    [vertex, fragment]: [&Shader; 2],
    targets: &[Option<ColorTargetState>],
    depth_compare: CompareFunction,
) -> DrawPipeline {
    let resources = [&vertex.resources[..], &fragment.resources].concat();
    let groups = Groups::new(device, "slices", &resources);
    let pipeline = device.device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("slices"),
        layout: Some(&groups.pipeline_layout(device)),
        vertex: VertexState {
            module: &vertex.module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(targets.is_empty()),
            depth_compare: Some(depth_compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(FragmentState {
            module: &fragment.module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets,
        }),
        multiview_mask: None,
        cache: None,
    });
    DrawPipeline { pipeline, groups }
}
