//! Shaders put together from their files.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use wgpu::naga::Module;
use wgpu::naga::compact::{KeepUnused, compact};

use super::instances::{is_shared, text_of};
use super::pass::{
    APART, ISOSURFACES, LAYERS, MERGE, OF_ALL, OF_EACH, OF_ONE, SHARED, SLICE_ISOSURFACES, SLICE_LAYERS,
    SLICE_LAYERS_PIXELS, Wgsl,
};
use super::written::{
    across, constants, count, each, each_hit, each_path, every, every_line, every_slab, every_slab_light,
};
use super::{Constants, Pass, Traversal, Variant, defines};
use crate::GpuError;

/// Links shaders. What several are made of is compiled once for all that define the same names there: most of the time
/// that linking a variant takes is spent on files that it shares with others.
#[derive(Default)]
pub struct Linker {
    /// The shared files with each file that a pass imports under a name that several files go by, or with none.
    composers: HashMap<Option<&'static str>, Composer>,
    /// The files of so many layers that are followed together.
    together: HashMap<usize, Composer>,
    /// What merges so many that are followed apart.
    apart: HashMap<usize, Composer>,
}

impl Linker {
    /// Links a shader and checks it: of a pass over one volume, or of one over several of which each has its variant.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the compiler's message; a test links every variant.
    pub fn link(&mut self, layers: &[Variant], constants: Constants) -> Result<Module, GpuError> {
        let failed = |message: String| GpuError::Shader { variant: format!("{layers:?}"), message };
        let variant = &layers[0];
        let (composer, name, text) = if variant.is_of_several() {
            let (composers, files): (_, fn(usize) -> _) = match variant.pass {
                Pass::Apart => (&mut self.apart, merging),
                _ => (&mut self.together, of_layers),
            };
            let (name, text) = entry_of_several(variant);
            let composer = match composers.entry(layers.len()) {
                Entry::Occupied(found) => found.into_mut(),
                Entry::Vacant(place) => place.insert(composer(files(layers.len())).map_err(failed)?),
            };
            (composer, name, text)
        } else {
            let (entry, mode) = variant.pass.files(variant.traversal);
            let composer = match self.composers.entry(mode.as_ref().map(|mode| mode.name)) {
                Entry::Occupied(found) => found.into_mut(),
                Entry::Vacant(place) => place.insert(composer(of_one(mode.as_ref())).map_err(failed)?),
            };
            (composer, entry.name, Cow::Borrowed(entry.text))
        };
        let mut defines = defines(layers);
        if constants == Constants::Stored {
            defines.insert("STORED_CONSTANTS".to_owned(), ShaderDefValue::Bool(true));
            if variant.pass.sweeps() {
                defines.insert("LOADED_CONSTANTS".to_owned(), ShaderDefValue::Bool(true));
            }
        }
        let module =
            NagaModuleDescriptor { source: &text, file_path: name, shader_defs: defines, ..Default::default() };
        let made = composer.make_naga_module(module);
        let mut made = made.map_err(|error| failed(error.emit_to_string(composer)))?;
        // What is left is what the pass uses.
        compact(&mut made, KeepUnused::No);
        Ok(made)
    }
}

type Files = Vec<(&'static str, String)>;

/// The file with the entry point of a pass over several volumes: its name and its text.
fn entry_of_several(variant: &Variant) -> (&'static str, Cow<'static, str>) {
    let own = match (variant.pass, variant.traversal) {
        (Pass::Apart, _) => APART,
        (Pass::Isosurface, Traversal::Slices) => SLICE_ISOSURFACES,
        (_, Traversal::Slices) => SLICE_LAYERS,
        (_, Traversal::SlicePixels) => SLICE_LAYERS_PIXELS,
        (Pass::Isosurface, Traversal::Rays) => ISOSURFACES,
        (pass, Traversal::Rays) if pass.sweeps() || pass.traces() => {
            // One file goes through any number of volumes: what is no volume's own is asked of the first.
            let (entry, _) = pass.files(Traversal::Rays);
            return (entry.name, text_of(entry.text, 0).into());
        }
        (_, Traversal::Rays) => LAYERS,
    };
    (own.name, own.text.into())
}

/// The files of one volume, with one that the pass imports under a name that several files go by.
fn of_one(mode: Option<&Wgsl>) -> Files {
    let own = |file: &Wgsl| (file.name, file.text.to_owned());
    let asked = [("each_path", each_path(0)), ("constants", constants(&["pellucid".to_owned()]))];
    // What only layers import has to be there all the same.
    let none = std::iter::once(("across", across(0)));
    none.chain(SHARED.iter().chain(mode).map(own)).chain(asked).chain(OF_ONE.iter().map(own)).collect()
}

/// The files of so many layers that are followed together.
fn of_layers(layers: usize) -> Files {
    let own = |file: &Wgsl| {
        let across = (file.name == "shadow").then(|| ("across", across(layers)));
        of_each(file, layers).into_iter().chain(across).collect::<Vec<_>>()
    };
    let files = SHARED.iter().chain(&OF_EACH).flat_map(own);
    let roots: Vec<_> = (0..layers).map(|k| format!("pellucid::of{k}")).collect();
    let asked = [
        ("each", each(layers)),
        ("each_hit", each_hit(layers)),
        ("each_path", each_path(layers)),
        ("every", every(layers)),
        ("every_line", every_line(layers)),
        ("every_slab", every_slab(layers)),
        ("every_slab_light", every_slab_light(layers)),
        ("constants", constants(&roots)),
    ];
    let last = OF_ALL.map(|file| (file.name, file.text.to_owned()));
    std::iter::once(("count", count(layers))).chain(files).chain(asked).chain(last).collect()
}

/// What merges so many layers: files of the first, which are those of all.
fn merging(layers: usize) -> Files {
    let files = SHARED.iter().chain([&MERGE]).flat_map(|file| of_each(file, 1));
    [("count", count(layers)), ("across", across(0))].into_iter().chain(files).collect()
}

/// A file of so many layers: of most, each has its own.
fn of_each(file: &Wgsl, layers: usize) -> Files {
    match is_shared(file.name) {
        true => vec![(file.name, file.text.to_owned())],
        false => (0..layers).map(|layer| (file.name, text_of(file.text, layer))).collect(),
    }
}

/// Files that others import.
fn composer(files: impl IntoIterator<Item = (&'static str, String)>) -> Result<Composer, String> {
    let mut composer = Composer::default();
    for (name, text) in files {
        let module = ComposableModuleDescriptor { source: &text, file_path: name, ..Default::default() };
        let added = composer.add_composable_module(module).map(drop);
        added.map_err(|error| error.emit_to_string(&composer))?;
    }
    Ok(composer)
}
