//! The shaders: WGSL files, and how they are put together.
//!
//! A pass has one file of its own; what passes share they import. A mode of the ray caster is a
//! module that a walk over samples or segments imports as `pellucid::mode`.

use std::collections::HashMap;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};

use wgpu::naga;

use crate::GpuError;

/// A file of this folder: its name and its text.
struct Source {
    name: &'static str,
    text: &'static str,
}

macro_rules! source {
    ($name:literal) => {
        Source { name: $name, text: include_str!(concat!($name, ".wgsl")) }
    };
}

/// What passes import; each only from those above it.
const SHARED: [Source; 11] = [
    source!("frame"),
    source!("ray"),
    source!("kernel"),
    source!("field"),
    source!("table"),
    source!("light"),
    source!("march"),
    source!("skip"),
    source!("surface"),
    source!("projected"),
    source!("preclassify"),
];

/// What a pass makes of the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pass {
    /// Emission and absorption of classified samples.
    Composite,
    /// The same with colours interpolated between classified voxels.
    CompositePre,
    /// The same with integrals over segments.
    PreIntegrated,
    /// The largest value.
    Maximum,
    /// The smallest value.
    Minimum,
    /// The mean value.
    Average,
    /// Emission alone.
    Additive,
    /// Absorption alone.
    XRay,
    /// First surfaces of constant value.
    Isosurface,
    /// The field on a plane.
    Slice,
    /// Rays into pixels.
    Resolve,
}

impl Pass {
    /// All passes.
    pub const ALL: [Self; 11] = [
        Self::Composite,
        Self::CompositePre,
        Self::PreIntegrated,
        Self::Maximum,
        Self::Minimum,
        Self::Average,
        Self::Additive,
        Self::XRay,
        Self::Isosurface,
        Self::Slice,
        Self::Resolve,
    ];

    /// The file with the entry point, and the mode it walks for.
    fn sources(self) -> (Source, Option<Source>) {
        let samples = |mode| (source!("samples"), Some(mode));
        let segments = |mode| (source!("segments"), Some(mode));
        match self {
            Self::Composite | Self::CompositePre => samples(source!("composite")),
            Self::Maximum | Self::Minimum => samples(source!("extreme")),
            Self::Average => samples(source!("average")),
            Self::Additive => samples(source!("additive")),
            Self::XRay => samples(source!("xray")),
            Self::PreIntegrated => segments(source!("preintegrated")),
            Self::Isosurface => segments(source!("isosurface")),
            Self::Slice => (source!("slice"), None),
            Self::Resolve => (source!("resolve"), None),
        }
    }

    /// Whether blocks are compared with the extreme that was found instead of being live or not.
    pub fn compares_extremes(self) -> bool {
        matches!(self, Self::Maximum | Self::Minimum)
    }
}

/// One shader: a pass, and what of it is compiled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// The pass.
    pub pass: Pass,
    /// The sampler interpolates, not the shader.
    pub hardware: bool,
    /// Some voxels are absent.
    pub holes: bool,
    /// The texture holds a part of the volume.
    pub bricks: bool,
    /// Blocks that cannot contribute are leapt over.
    pub skip: bool,
    /// Samples are lit.
    pub shaded: bool,
    /// Light fades in with the gradient's magnitude.
    pub weighted: bool,
    /// Values have opacity 1 (slabs).
    pub opaque: bool,
    /// Rays that are not done are listed for the next pass.
    pub wavefront: bool,
    /// The filter is not linear, or the gradient not of central differences.
    pub kernels: bool,
    /// Steps adapt to the data.
    pub strides: bool,
}

impl Variant {
    /// A pass with nothing compiled in.
    pub fn of(pass: Pass) -> Self {
        let off = false;
        Self {
            pass,
            hardware: off,
            holes: off,
            bricks: off,
            skip: off,
            shaded: off,
            weighted: off,
            opaque: off,
            wavefront: off,
            kernels: off,
            strides: off,
        }
    }

    /// Every shader there is.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for pass in Pass::ALL {
            for bits in 0..1 << 10 {
                let on = |bit: u32| bits >> bit & 1 == 1;
                let variant = Self {
                    pass,
                    hardware: on(0),
                    holes: on(1),
                    bricks: on(2),
                    skip: on(3),
                    shaded: on(4),
                    weighted: on(5),
                    opaque: on(6),
                    wavefront: on(7),
                    kernels: on(8),
                    strides: on(9),
                };
                if variant == variant.canonical() {
                    all.push(variant);
                }
            }
        }
        all
    }

    /// The same shader without flags that mean nothing to it.
    pub fn canonical(mut self) -> Self {
        use Pass::*;
        let lights = matches!(self.pass, Composite | CompositePre | PreIntegrated | Isosurface);
        let projects = matches!(self.pass, Maximum | Minimum | Average | Slice);
        // Voxels without value cannot be left to a sampler, and classified voxels are not sampled
        // (but their gradients would be).
        self.hardware &= !self.holes && self.pass != Resolve;
        self.holes &= self.pass != Resolve;
        self.bricks &= self.pass != Resolve;
        self.skip &= !matches!(self.pass, Average | Slice | Resolve);
        self.shaded &= lights;
        self.weighted &= self.shaded;
        self.opaque &= projects;
        // Bricks are passes already.
        self.wavefront &= !self.bricks && self.pass != Resolve;
        self.kernels &= self.pass != Resolve;
        self.strides &= self.skip && self.pass == Composite;
        self
    }

    /// Whether classified voxels have a texture beside that of the field.
    pub fn has_voxels(&self) -> bool {
        self.kernels && self.pass == Pass::CompositePre
    }

    /// The names that are defined for the preprocessor.
    fn defines(&self) -> HashMap<String, ShaderDefValue> {
        let names = [
            ("HARDWARE", self.hardware),
            ("HOLES", self.holes),
            ("BRICKS", self.bricks),
            ("SKIP", self.skip),
            ("SHADED", self.shaded),
            ("WEIGHTED", self.weighted),
            ("OPAQUE", self.opaque),
            ("WAVEFRONT", self.wavefront),
            ("KERNELS", self.kernels),
            ("STRIDES", self.strides),
            ("NORMALS", matches!(self.pass, Pass::Composite | Pass::CompositePre | Pass::PreIntegrated)),
            ("EXTREMES", self.pass.compares_extremes()),
            ("MINIMUM", self.pass == Pass::Minimum),
            ("PRECLASSIFIED", self.pass == Pass::CompositePre),
        ];
        let defined = |(name, on): (&str, bool)| on.then(|| (name.to_owned(), ShaderDefValue::Bool(true)));
        names.into_iter().filter_map(defined).collect()
    }

    /// Links the shader and checks it.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the compiler's message; a test links every variant.
    pub fn link(&self) -> Result<naga::Module, GpuError> {
        let defines = self.defines();
        let (entry, mode) = self.pass.sources();
        let mut composer = Composer::default();
        for source in SHARED.iter().chain(&mode) {
            let module = ComposableModuleDescriptor {
                source: source.text,
                file_path: source.name,
                shader_defs: defines.clone(),
                ..Default::default()
            };
            let added = composer.add_composable_module(module).map(drop);
            added.map_err(|error| self.failed(error.emit_to_string(&composer)))?;
        }
        let module = NagaModuleDescriptor {
            source: entry.text,
            file_path: entry.name,
            shader_defs: defines,
            ..Default::default()
        };
        let made = composer.make_naga_module(module);
        made.map_err(|error| self.failed(error.emit_to_string(&composer)))
    }

    fn failed(&self, message: String) -> GpuError {
        GpuError::Shader { variant: format!("{self:?}"), message }
    }
}
