//! Pipelines and the layouts of what is bound to them, made when they are first needed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::num::NonZeroU64;

use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType, ComputePipeline,
    ComputePipelineDescriptor, PipelineLayoutDescriptor, SamplerBindingType, ShaderModuleDescriptor, ShaderSource,
    ShaderStages, TextureSampleType, TextureViewDimension,
};

use crate::shaders::{Pass, Variant};
use crate::{Device, GpuError, uniforms};

/// A pipeline and the layouts of its groups: the frame, the volume, the tables.
#[derive(Clone)]
pub struct Pipeline {
    /// What it was made of.
    pub variant: Variant,
    /// The pipeline.
    pub pipeline: ComputePipeline,
    /// The layouts of its groups.
    pub groups: Vec<BindGroupLayout>,
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
    let source = ShaderSource::Naga(Cow::Owned(variant.link()?));
    let module = device.device.create_shader_module(ShaderModuleDescriptor { label: Some(&label), source });
    let mut groups = vec![frame_layout(device, variant)];
    if variant.pass != Pass::Resolve {
        groups.extend([volume_layout(device, variant), table_layout(device)]);
    }
    let bound: Vec<_> = groups.iter().map(Some).collect();
    let layout = device.device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(&label),
        bind_group_layouts: &bound,
        immediate_size: 0,
    });
    let pipeline = device.device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(&label),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    Ok(Pipeline { variant: *variant, pipeline, groups })
}

fn layout(device: &Device, label: &str, types: &[(u32, BindingType)]) -> BindGroupLayout {
    let entry = |&(binding, ty)| BindGroupLayoutEntry { binding, visibility: ShaderStages::COMPUTE, ty, count: None };
    let entries: Vec<_> = types.iter().map(entry).collect();
    device.device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn buffer(ty: BufferBindingType, dynamic: Option<u64>) -> BindingType {
    let min_binding_size = dynamic.and_then(NonZeroU64::new);
    BindingType::Buffer { ty, has_dynamic_offset: dynamic.is_some(), min_binding_size }
}

fn frame_layout(device: &Device, variant: &Variant) -> BindGroupLayout {
    let read = buffer(BufferBindingType::Storage { read_only: true }, None);
    let write = buffer(BufferBindingType::Storage { read_only: false }, None);
    let pass = size_of::<uniforms::Pass>() as u64;
    let mut types = vec![
        (0, buffer(BufferBindingType::Uniform, None)),
        (1, buffer(BufferBindingType::Uniform, Some(pass))),
        (2, read),
        (3, read),
        (4, read),
        (5, write),
        (6, read),
    ];
    if variant.pass == Pass::Resolve {
        types.push((7, write));
    }
    if variant.wavefront {
        types.push((8, write));
    }
    layout(device, "frame", &types)
}

fn volume_layout(device: &Device, variant: &Variant) -> BindGroupLayout {
    let texture = |sample_type| BindingType::Texture {
        sample_type,
        view_dimension: TextureViewDimension::D3,
        multisampled: false,
    };
    let blocks = if variant.pass.compares_extremes() {
        TextureSampleType::Float { filterable: false }
    } else {
        TextureSampleType::Uint
    };
    let mut types = vec![(0, texture(TextureSampleType::Float { filterable: variant.hardware })), (2, texture(blocks))];
    if variant.hardware {
        types.push((1, BindingType::Sampler(SamplerBindingType::Filtering)));
    }
    if variant.kernels {
        types.push((3, buffer(BufferBindingType::Uniform, None)));
    }
    if variant.has_voxels() {
        types.push((4, texture(TextureSampleType::Float { filterable: false })));
    }
    layout(device, "volume", &types)
}

fn table_layout(device: &Device) -> BindGroupLayout {
    layout(device, "tables", &[(0, buffer(BufferBindingType::Storage { read_only: true }, None))])
}
