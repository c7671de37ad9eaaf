//! What a linked shader reads and writes.

use std::num::NonZeroU64;

use wgpu::naga::{
    AddressSpace, Expression, GlobalVariable, Handle, ImageClass, ImageDimension, Module, ScalarKind, ShaderStage,
    StorageAccess, StorageFormat, TypeInner,
};
use wgpu::{
    BindingType, BufferBindingType, SamplerBindingType, ShaderStages, StorageTextureAccess, TextureFormat,
    TextureSampleType, TextureViewDimension,
};

use super::instances::BINDINGS;

/// The constants of which a pass has its own, at an offset that is told with it.
const CHOSEN: &str = "bounds";

/// A buffer, a texture or a sampler that a shader uses.
#[derive(Clone)]
pub struct Resource {
    /// Its group, and its number there.
    pub place: [u32; 2],
    /// The number of the volume that it belongs to.
    pub layer: usize,
    /// What shaders call it.
    pub name: String,
    /// What can be bound to it.
    pub ty: BindingType,
    /// Where it is used.
    pub visibility: ShaderStages,
}

/// The resources of a module that holds nothing but what its entry points use.
///
/// # Errors
/// The name of a resource of a kind that no shader had before.
pub fn resources(module: &Module) -> Result<Vec<Resource>, String> {
    let stage = |stage| match stage {
        ShaderStage::Vertex => ShaderStages::VERTEX,
        ShaderStage::Fragment => ShaderStages::FRAGMENT,
        _ => ShaderStages::COMPUTE,
    };
    let visibility = module.entry_points.iter().map(|entry| stage(entry.stage)).collect();
    let filtered = filtered(module);
    let mut found = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else { continue };
        let name = name_of(variable);
        let ty = binding_type(module, variable, name == CHOSEN, filtered.contains(&handle));
        let ty = ty.ok_or_else(|| format!("nothing can be bound to {name}"))?;
        let (place, layer) = ([binding.group, binding.binding], (binding.binding / BINDINGS) as usize);
        found.push(Resource { place, layer, name: name.to_owned(), ty, visibility });
    }
    Ok(found)
}

/// The name of a variable in its file: the linker puts that of the file's module behind it, and what is copied before
/// anything branches is "stored" until then.
fn name_of(variable: &GlobalVariable) -> &str {
    let linked = variable.name.as_deref().unwrap_or_default();
    let name = linked.split_once("X_naga_oil_mod_X").map_or(linked, |(name, _)| name);
    name.strip_prefix("stored_").unwrap_or(name)
}

/// The textures that a sampler reads: others need not be of a format that can be filtered.
fn filtered(module: &Module) -> Vec<Handle<GlobalVariable>> {
    let functions = module.functions.iter().map(|(_, function)| function);
    let functions = functions.chain(module.entry_points.iter().map(|entry| &entry.function));
    let sampled = functions.flat_map(|function| {
        function.expressions.iter().filter_map(|(_, expression)| match expression {
            Expression::ImageSample { image, .. } => match function.expressions[*image] {
                Expression::GlobalVariable(texture) => Some(texture),
                _ => None,
            },
            _ => None,
        })
    });
    sampled.collect()
}

fn binding_type(
    module: &Module,
    variable: &GlobalVariable,
    has_dynamic_offset: bool,
    filterable: bool,
) -> Option<BindingType> {
    let inner = &module.types[variable.ty].inner;
    let buffer = |ty| BindingType::Buffer {
        ty,
        has_dynamic_offset,
        min_binding_size: NonZeroU64::new(inner.size(module.to_ctx()).into()),
    };
    Some(match (variable.space, inner) {
        (AddressSpace::Uniform, _) => buffer(BufferBindingType::Uniform),
        (AddressSpace::Storage { access }, _) => {
            buffer(BufferBindingType::Storage { read_only: !access.contains(StorageAccess::STORE) })
        }
        (_, TypeInner::Sampler { comparison: false }) => BindingType::Sampler(SamplerBindingType::Filtering),
        (_, &TypeInner::Image { dim, arrayed, class }) => {
            let view_dimension = match (dim, arrayed) {
                (ImageDimension::D2, false) => TextureViewDimension::D2,
                (ImageDimension::D2, true) => TextureViewDimension::D2Array,
                (ImageDimension::D3, _) => TextureViewDimension::D3,
                _ => return None,
            };
            let texture = |sample_type| BindingType::Texture { sample_type, view_dimension, multisampled: false };
            match class {
                ImageClass::Sampled { kind: ScalarKind::Float, multi: false } => {
                    texture(TextureSampleType::Float { filterable })
                }
                ImageClass::Sampled { kind: ScalarKind::Uint, multi: false } => texture(TextureSampleType::Uint),
                ImageClass::Storage { format, access: StorageAccess::STORE } => BindingType::StorageTexture {
                    access: StorageTextureAccess::WriteOnly,
                    format: match format {
                        StorageFormat::R32Float => TextureFormat::R32Float,
                        StorageFormat::Rgba32Float => TextureFormat::Rgba32Float,
                        _ => return None,
                    },
                    view_dimension,
                },
                _ => return None,
            }
        }
        _ => return None,
    })
}
