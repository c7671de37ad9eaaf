//! Shaders put together from their files.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use wgpu::naga::Module;
use wgpu::naga::compact::{KeepUnused, compact};

use super::pass::{SHARED, Wgsl};
use super::{Constants, Variant};
use crate::GpuError;

/// Links shaders. What several are made of is compiled once for all that define the same names there: most of the time
/// that linking a variant takes is spent on files that it shares with others.
#[derive(Default)]
pub struct Linker {
    /// The shared files with each file that a walk imports as `pellucid::mode`, or with none.
    composers: HashMap<Option<&'static str>, Composer>,
}

impl Linker {
    /// Links a shader and checks it.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the compiler's message; a test links every variant.
    pub fn link(&mut self, variant: &Variant, constants: Constants) -> Result<Module, GpuError> {
        let failed = |message: String| GpuError::Shader { variant: format!("{variant:?}"), message };
        let (entry, mode) = variant.pass.files(variant.traversal);
        let composer = match self.composers.entry(mode.as_ref().map(|mode| mode.name)) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(place) => place.insert(composer(SHARED.iter().chain(&mode)).map_err(failed)?),
        };
        let mut defines = variant.defines();
        if constants == Constants::Stored {
            defines.insert("STORED_CONSTANTS".to_owned(), ShaderDefValue::Bool(true));
            if variant.pass.sweeps() {
                defines.insert("LOADED_CONSTANTS".to_owned(), ShaderDefValue::Bool(true));
            }
        }
        let module = NagaModuleDescriptor {
            source: entry.text,
            file_path: entry.name,
            shader_defs: defines,
            ..Default::default()
        };
        let made = composer.make_naga_module(module);
        let mut made = made.map_err(|error| failed(error.emit_to_string(composer)))?;
        // What is left is what the pass uses.
        compact(&mut made, KeepUnused::No);
        Ok(made)
    }
}

/// Files that others import.
fn composer<'f>(files: impl Iterator<Item = &'f Wgsl>) -> Result<Composer, String> {
    let mut composer = Composer::default();
    for file in files {
        let module = ComposableModuleDescriptor { source: file.text, file_path: file.name, ..Default::default() };
        let added = composer.add_composable_module(module).map(drop);
        added.map_err(|error| error.emit_to_string(&composer))?;
    }
    Ok(composer)
}
