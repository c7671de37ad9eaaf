//! Pipelines and the layouts of what is bound to them, made when they are first needed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::num::NonZeroU64;

use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType, ComputePipeline,
    ComputePipelineDescriptor, PipelineLayout, PipelineLayoutDescriptor, SamplerBindingType, ShaderModule,
    ShaderModuleDescriptor, ShaderSource, ShaderStages, StorageTextureAccess, TextureFormat, TextureSampleType,
    TextureViewDimension,
};

use crate::shaders::{Constants, Pass, Traversal, Variant};
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
    let module = module(device, variant)?;
    let groups = groups(device, variant);
    let layout = pipeline_layout(device, &groups);
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

/// The shader of a variant.
///
/// # Errors
/// [`GpuError::Shader`].
pub fn module(device: &Device, variant: &Variant) -> Result<ShaderModule, GpuError> {
    let source = ShaderSource::Naga(Cow::Owned(device.link(variant)?));
    let label = format!("{:?}", variant.pass);
    Ok(device.device.create_shader_module(ShaderModuleDescriptor { label: Some(&label), source }))
}

/// The layouts of a variant's groups.
pub fn groups(device: &Device, variant: &Variant) -> Vec<BindGroupLayout> {
    let mut groups = vec![frame_layout(device, variant)];
    match (variant.pass, variant.traversal) {
        (pass, _) if !pass.reads() => {}
        (_, Traversal::SlicePixels) => {
            let nothing = device
                .device
                .create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some("nothing"), entries: &[] });
            groups.extend([nothing, table_layout(device, variant)]);
        }
        _ => groups.extend([volume_layout(device, variant), table_layout(device, variant)]),
    }
    groups
}

/// The layout of a pipeline with such groups.
pub fn pipeline_layout(device: &Device, groups: &[BindGroupLayout]) -> PipelineLayout {
    let bound: Vec<_> = groups.iter().map(Some).collect();
    device.device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &bound,
        immediate_size: 0,
    })
}

fn layout(device: &Device, variant: &Variant, label: &str, types: &[(u32, BindingType)]) -> BindGroupLayout {
    let draws = variant.traversal == Traversal::Slices || variant.pass == Pass::SliceDone;
    let visibility = if draws { ShaderStages::VERTEX_FRAGMENT } else { ShaderStages::COMPUTE };
    let entry = |&(binding, ty)| BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = types.iter().map(entry).collect();
    device.device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn buffer(ty: BufferBindingType, dynamic: Option<u64>) -> BindingType {
    let min_binding_size = dynamic.and_then(NonZeroU64::new);
    BindingType::Buffer { ty, has_dynamic_offset: dynamic.is_some(), min_binding_size }
}

/// A buffer that is the same for all invocations.
fn constants(device: &Device, dynamic: Option<u64>) -> BindingType {
    let ty = match device.constants() {
        Constants::Uniform => BufferBindingType::Uniform,
        Constants::Stored => BufferBindingType::Storage { read_only: true },
    };
    buffer(ty, dynamic)
}

/// A 2D texture of floats, or layers of them.
fn flat(filterable: bool, view_dimension: TextureViewDimension) -> BindingType {
    BindingType::Texture { sample_type: TextureSampleType::Float { filterable }, view_dimension, multisampled: false }
}

fn frame_layout(device: &Device, variant: &Variant) -> BindGroupLayout {
    let read = buffer(BufferBindingType::Storage { read_only: true }, None);
    let write = buffer(BufferBindingType::Storage { read_only: false }, None);
    let pass = size_of::<uniforms::Bounds>() as u64;
    let uniform = constants(device, None);
    let picture = flat(false, TextureViewDimension::D2);
    let stored = |format| BindingType::StorageTexture {
        access: StorageTextureAccess::WriteOnly,
        format,
        view_dimension: TextureViewDimension::D2,
    };
    let layers = flat(variant.hardware, TextureViewDimension::D2Array);
    let mut types = vec![(0, uniform), (1, constants(device, Some(pass))), (2, read), (3, read), (4, read), (6, read)];
    match (variant.pass, variant.traversal) {
        (Pass::SliceDone, _) => types.extend([(9, uniform), (13, picture)]),
        (Pass::SliceTiles, _) => types.extend([(13, picture), (15, write)]),
        (Pass::SliceOcclusion, _) => types.extend([(9, uniform), (10, read), (15, write), (16, write)]),
        (_, Traversal::Slices) => types.extend([(9, uniform), (10, read), (11, read), (12, read)]),
        (_, Traversal::SlicePixels) => types.extend([(7, write), (9, uniform), (13, picture), (14, picture)]),
        (Pass::Resolve, _) => types.extend([(5, write), (7, write)]),
        (Pass::HalfAngleLight, _) => {
            types.extend([(17, uniform), (18, layers), (21, stored(TextureFormat::Rgba32Float))]);
            types.extend(variant.gated.then_some((22, picture)));
        }
        (Pass::HalfAnglePresence, _) => types.extend([(17, uniform), (22, stored(TextureFormat::R32Float))]),
        (Pass::PathTrace, _) => types.extend([(5, write), (19, uniform), (20, read), (21, read), (22, read)]),
        (Pass::PathTracePixels, _) => types.extend([(5, write), (7, write), (19, uniform)]),
        (Pass::HalfAngleEye, _) => types.extend([(5, write), (17, uniform), (18, layers)]),
        (Pass::LightPoints, _) => {
            let points = BindingType::StorageTexture {
                access: StorageTextureAccess::WriteOnly,
                format: TextureFormat::R32Float,
                view_dimension: TextureViewDimension::D3,
            };
            types.extend([(17, uniform), (18, layers), (23, points)]);
        }
        (Pass::HalfAngleSurface, _) => types.extend([(5, write), (17, uniform)]),
        _ => types.push((5, write)),
    }
    if variant.wavefront {
        types.push((8, write));
    }
    layout(device, variant, "frame", &types)
}

fn volume_layout(device: &Device, variant: &Variant) -> BindGroupLayout {
    let texture = |sample_type| BindingType::Texture {
        sample_type,
        view_dimension: TextureViewDimension::D3,
        multisampled: false,
    };
    let field = BindingType::Texture {
        sample_type: TextureSampleType::Float { filterable: variant.hardware },
        view_dimension: if variant.stack { TextureViewDimension::D2Array } else { TextureViewDimension::D3 },
        multisampled: false,
    };
    let blocks = if variant.pass.compares_extremes() {
        TextureSampleType::Float { filterable: false }
    } else {
        TextureSampleType::Uint
    };
    let mut types = vec![(0, field), (2, texture(blocks))];
    if variant.hardware {
        types.push((1, BindingType::Sampler(SamplerBindingType::Filtering)));
    }
    if variant.kernels {
        types.push((3, constants(device, None)));
    }
    if variant.perturbed {
        types.extend([(5, texture(TextureSampleType::Float { filterable: false })), (6, constants(device, None))]);
    }
    if variant.shadowed {
        types.push((7, texture(TextureSampleType::Float { filterable: false })));
    }
    if variant.has_voxels() {
        types.push((4, texture(TextureSampleType::Float { filterable: false })));
    }
    layout(device, variant, "volume", &types)
}

fn table_layout(device: &Device, variant: &Variant) -> BindGroupLayout {
    let read = buffer(BufferBindingType::Storage { read_only: true }, None);
    let mut types = vec![(0, read)];
    if variant.has_scattering() {
        types.extend([(1, constants(device, None)), (2, read)]);
    }
    layout(device, variant, "tables", &types)
}
