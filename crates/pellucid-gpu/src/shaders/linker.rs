//! Shaders put together from their files.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use wgpu::naga::Module;
use wgpu::naga::compact::{KeepUnused, compact};

use super::instances::{across, each, is_shared, text_of};
use super::pass::{LAYER, LAYERS, MERGE, SHARED};
use super::{Constants, Variant, defines};
use crate::GpuError;

/// Links shaders. What several are made of is compiled once for all that define the same names there: most of the time
/// that linking a variant takes is spent on files that it shares with others.
#[derive(Default)]
pub struct Linker {
    /// The shared files with each file that a walk imports as `pellucid::mode`, or with none.
    composers: HashMap<Option<&'static str>, Composer>,
    /// The files of so many layers.
    layers: HashMap<usize, Composer>,
}

impl Linker {
    /// Links a shader and checks it: of a pass over one volume, or of one over several of which each has its variant.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the compiler's message; a test links every variant.
    pub fn link(&mut self, layers: &[Variant], constants: Constants) -> Result<Module, GpuError> {
        let failed = |message: String| GpuError::Shader { variant: format!("{layers:?}"), message };
        let variant = &layers[0];
        let (composer, entry) = if variant.is_among_others() {
            let composer = match self.layers.entry(layers.len()) {
                Entry::Occupied(found) => found.into_mut(),
                Entry::Vacant(place) => place.insert(of_layers(layers.len()).map_err(failed)?),
            };
            (composer, LAYERS)
        } else {
            let (entry, mode) = variant.pass.files(variant.traversal);
            let composer = match self.composers.entry(mode.as_ref().map(|mode| mode.name)) {
                Entry::Occupied(found) => found.into_mut(),
                Entry::Vacant(place) => {
                    let files = SHARED.iter().chain(&mode).map(|file| (file.name, file.text.to_owned()));
                    // What only layers import has to be there all the same.
                    let none = std::iter::once(("across", across(0)));
                    place.insert(composer(none.chain(files)).map_err(failed)?)
                }
            };
            (composer, entry)
        };
        let mut defines = defines(layers);
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

/// The files of so many layers: of most, each has its own.
fn of_layers(count: usize) -> Result<Composer, String> {
    let mut files = Vec::new();
    for file in SHARED.iter().chain([&LAYER]) {
        if is_shared(file.name) {
            files.push((file.name, file.text.to_owned()));
        } else {
            files.extend((0..count).map(|layer| (file.name, text_of(file.text, layer))));
        }
        if file.name == "shadow" {
            files.push(("across", across(count)));
        }
    }
    files.extend([("each", each(count)), (MERGE.name, MERGE.text.to_owned())]);
    composer(files.into_iter())
}

/// Files that others import.
fn composer(files: impl Iterator<Item = (&'static str, String)>) -> Result<Composer, String> {
    let mut composer = Composer::default();
    for (name, text) in files {
        let module = ComposableModuleDescriptor { source: &text, file_path: name, ..Default::default() };
        let added = composer.add_composable_module(module).map(drop);
        added.map_err(|error| error.emit_to_string(&composer))?;
    }
    Ok(composer)
}
