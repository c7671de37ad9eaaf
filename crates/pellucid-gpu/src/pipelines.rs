//! Pipelines that compute, made when they are first needed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

use wgpu::{ComputePipeline, ComputePipelineDescriptor, ShaderModule, ShaderModuleDescriptor, ShaderSource};

use crate::groups::Groups;
use crate::shaders::{Resource, Variant, resources};
use crate::{Device, GpuError};

/// A pipeline and what is bound to it.
#[derive(Clone)]
pub struct Pipeline {
    /// What it was made of.
    pub variant: Variant,
    /// The pipeline.
    pub pipeline: ComputePipeline,
    /// What is bound to it.
    pub groups: Groups,
}

/// The pipelines of a device.
#[derive(Default)]
pub struct Pipelines(HashMap<Variant, Pipeline>);

impl Pipelines {
    /// The pipeline of a variant.
    ///
    /// # Errors
    /// [`GpuError::Shader`], or what the device reports.
    pub fn get(&mut self, device: &Device, variant: Variant) -> Result<&Pipeline, GpuError> {
        let variant = variant.canonical();
        Ok(match self.0.entry(variant) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(place) => {
                let pipeline = make(device, &variant)?;
                device.check()?;
                place.insert(pipeline)
            }
        })
    }
}

fn make(device: &Device, variant: &Variant) -> Result<Pipeline, GpuError> {
    let label = format!("{:?}", variant.pass);
    let Shader { module, resources } = shader(device, variant)?;
    let groups = Groups::new(device, &label, &resources);
    let pipeline = device.device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(&label),
        layout: Some(&groups.pipeline_layout(device)),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    Ok(Pipeline { variant: *variant, pipeline, groups })
}

/// The shader of a variant, and what it uses.
pub struct Shader {
    /// The shader.
    pub module: ShaderModule,
    /// What it reads and writes.
    pub resources: Vec<Resource>,
}

/// Makes the shader of a variant.
///
/// # Errors
/// [`GpuError::Shader`].
pub fn shader(device: &Device, variant: &Variant) -> Result<Shader, GpuError> {
    let label = format!("{:?}", variant.pass);
    let linked = device.link(variant)?;
    let resources =
        resources(&linked).map_err(|message| GpuError::Shader { variant: format!("{variant:?}"), message })?;
    let source = ShaderSource::Naga(Cow::Owned(linked));
    let module = device.device.create_shader_module(ShaderModuleDescriptor { label: Some(&label), source });
    Ok(Shader { module, resources })
}
