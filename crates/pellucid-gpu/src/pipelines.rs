//! Pipelines that compute, made when they are first needed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

use wgpu::{
    BindingType, BufferBindingType, ComputePipeline, ComputePipelineDescriptor, Limits, ShaderModule,
    ShaderModuleDescriptor, ShaderSource,
};

use crate::groups::Groups;
use crate::shaders::{Resource, Variant, resources};
use crate::{Device, GpuError};

/// A pipeline and what is bound to it.
#[derive(Clone)]
pub struct Pipeline {
    /// What it was made of; of several volumes, for the first.
    pub variant: Variant,
    /// The pipeline.
    pub pipeline: ComputePipeline,
    /// What is bound to it.
    pub groups: Groups,
}

/// The pipelines of a device.
#[derive(Default)]
pub struct Pipelines(HashMap<Vec<Variant>, Pipeline>);

impl Pipelines {
    /// The pipeline of a variant.
    ///
    /// # Errors
    /// [`GpuError::Shader`], or what the device reports.
    pub fn get(&mut self, device: &Device, variant: Variant) -> Result<&Pipeline, GpuError> {
        self.of_layers(device, vec![variant])
    }

    /// The pipeline of a pass over several volumes, of which each has its variant.
    ///
    /// # Errors
    /// As [`Pipelines::get`].
    pub fn of_layers(&mut self, device: &Device, mut layers: Vec<Variant>) -> Result<&Pipeline, GpuError> {
        layers.iter_mut().for_each(|variant| *variant = variant.canonical());
        Ok(match self.0.entry(layers) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(place) => {
                let pipeline = make(device, place.key())?;
                device.check()?;
                place.insert(pipeline)
            }
        })
    }
}

fn make(device: &Device, layers: &[Variant]) -> Result<Pipeline, GpuError> {
    let label = format!("{:?}", layers[0].pass);
    let Shader { module, resources } = shader(device, layers)?;
    check_limits(&device.capabilities.limits, layers.len(), &resources)?;
    let groups = Groups::new(device, &label, &resources);
    let pipeline = device.device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(&label),
        layout: Some(&groups.pipeline_layout(device)),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    Ok(Pipeline { variant: layers[0], pipeline, groups })
}

/// Whether a pass can be given all that shaders of so many volumes use.
///
/// # Errors
/// [`GpuError::Volumes`] with as many as it can be given.
pub fn check_limits(limits: &Limits, volumes: usize, resources: &[Resource]) -> Result<(), GpuError> {
    let fit = |limit: u32, is_of_kind: &dyn Fn(&BindingType) -> bool| {
        let found: Vec<&Resource> = resources.iter().filter(|resource| is_of_kind(&resource.ty)).collect();
        if found.len() <= limit as usize {
            return Ok(());
        }
        // The last volume has nothing that is there for all.
        let each = found.iter().filter(|resource| resource.layer + 1 == volumes).count().max(1);
        let common = found.len().saturating_sub(each * volumes);
        Err(GpuError::Volumes { found: volumes, most: (limit as usize).saturating_sub(common) / each })
    };
    let is_uniform = |ty: &_| matches!(ty, BindingType::Buffer { ty: BufferBindingType::Uniform, .. });
    let is_stored = |ty: &_| matches!(ty, BindingType::Buffer { ty: BufferBindingType::Storage { .. }, .. });
    fit(limits.max_uniform_buffers_per_shader_stage, &is_uniform)?;
    fit(limits.max_storage_buffers_per_shader_stage, &is_stored)?;
    fit(limits.max_sampled_textures_per_shader_stage, &|ty| matches!(ty, BindingType::Texture { .. }))
}

/// The shader of a variant, and what it uses.
pub struct Shader {
    /// The shader.
    pub module: ShaderModule,
    /// What it reads and writes.
    pub resources: Vec<Resource>,
}

/// Makes the shader of a variant, or of those of several volumes.
///
/// # Errors
/// [`GpuError::Shader`].
pub fn shader(device: &Device, layers: &[Variant]) -> Result<Shader, GpuError> {
    let label = format!("{:?}", layers[0].pass);
    let linked = device.link(layers)?;
    let resources =
        resources(&linked).map_err(|message| GpuError::Shader { variant: format!("{layers:?}"), message })?;
    let source = ShaderSource::Naga(Cow::Owned(linked));
    let module = device.device.create_shader_module(ShaderModuleDescriptor { label: Some(&label), source });
    Ok(Shader { module, resources })
}
