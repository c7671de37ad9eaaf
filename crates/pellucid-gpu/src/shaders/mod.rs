//! The shaders: WGSL files, and how they are put together.
//!
//! A pass has one file of its own; what passes share they import. A mode of the ray caster is a
//! module that a walk over samples or segments imports as `pellucid::mode`.

use std::collections::HashMap;

use naga_oil::compose::ShaderDefValue;

mod instances;
mod linker;
mod pass;
mod resource;
mod written;

use instances::flag_of;
pub use linker::Linker;
pub use pass::{Pass, Traversal};
pub use resource::{Resource, resources};

/// Where shaders find what is the same for all of their invocations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constants {
    /// In uniform buffers, which graphics hardware has caches for.
    Uniform,
    /// In storage buffers: Mesa's software driver compiles a shader anew for every submission, and keeps them
    /// all, if uniforms decide which way it goes.
    Stored,
}

/// One shader: a pass, and what of it is compiled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// The pass.
    pub pass: Pass,
    /// Where its samples come from.
    pub traversal: Traversal,
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
    /// The volume is a stack of 2D textures.
    pub stack: bool,
    /// Colours are interpolated without their opacity.
    pub bleeding: bool,
    /// Samples scatter light.
    pub scattered: bool,
    /// There is indirect light.
    pub indirect: bool,
    /// It is attenuated in its own way.
    pub transport: bool,
    /// Direct light becomes indirect light.
    pub scatters_direct: bool,
    /// It does so, or all light comes, from matter alone.
    pub gated: bool,
    /// What lies between lights and samples holds light back.
    pub shadowed: bool,
    /// Noise moves the field, or varies its optics.
    pub perturbed: bool,
    /// Each colour is held back in its own way.
    pub chromatic: bool,
    /// The nodes of tables are not even.
    pub knots: bool,
    /// Samples have the colours of their voxels.
    pub painted: bool,
    /// Surfaces are looked for by the cubics of cells.
    pub exact: bool,
    /// Its volume is one of several.
    pub layered: bool,
}

impl Variant {
    /// A pass with nothing compiled in.
    pub fn of(pass: Pass) -> Self {
        let off = false;
        Self {
            pass,
            traversal: Traversal::Rays,
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
            stack: off,
            bleeding: off,
            scattered: off,
            indirect: off,
            transport: off,
            scatters_direct: off,
            gated: off,
            shadowed: off,
            perturbed: off,
            chromatic: off,
            knots: off,
            painted: off,
            exact: off,
            layered: off,
        }
    }

    /// Every shader there is.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for (pass, traversal) in Pass::ALL.into_iter().flat_map(|pass| Traversal::ALL.map(|how| (pass, how))) {
            for bits in 0..1 << 20 {
                let on = |bit: u32| bits >> bit & 1 == 1;
                let variant = Self {
                    pass,
                    traversal,
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
                    stack: on(10),
                    bleeding: on(11),
                    scattered: on(12),
                    indirect: on(13),
                    transport: on(14),
                    scatters_direct: on(15),
                    gated: on(16),
                    shadowed: on(17),
                    perturbed: on(18),
                    chromatic: on(19),
                    // Changes one function: a part of the shaders says enough.
                    knots: on(0) && on(4),
                    painted: on(1) && on(18),
                    exact: false,
                    layered: false,
                };
                let exact = Self { exact: true, ..variant };
                all.extend([variant, exact].into_iter().filter(|variant| *variant == variant.canonical()));
            }
        }
        all
    }

    /// The same shader without flags that mean nothing to it.
    pub fn canonical(mut self) -> Self {
        use Pass::*;
        if !self.pass.samples() {
            self.traversal = Traversal::Rays;
        }
        let slices = self.traversal == Traversal::Slices;
        let pixels = self.traversal == Traversal::SlicePixels;
        self.layered &= self.pass.is_of_layers(self.traversal);
        let merged = self.layered && self.pass.is_apart();
        if pixels && !merged && matches!(self.pass, CompositePre | PreIntegrated | Additive | Isosurface) {
            // Their slices are blended as colours.
            self.pass = Composite;
        }
        self.layered |= self.pass == Apart;
        let clouds = matches!(self.pass, Composite | CompositePre | PreIntegrated | HalfAngleEye | PathTrace);
        let lights = clouds || self.pass == Isosurface;
        let projects = matches!(self.pass, Maximum | Minimum | Average | Slice);
        let reads = self.pass.reads() && !pixels;
        // Voxels without value cannot be left to a sampler, and classified voxels are not sampled
        // (but their gradients would be).
        self.hardware &= !self.holes && reads;
        self.holes &= reads;
        let is_whole = self.pass.sweeps() || self.pass.traces();
        self.bricks &= reads && !is_whole;
        // Slices leap by what is not drawn; those through several volumes are drawn everywhere.
        self.skip &=
            reads && (!slices || self.layered) && !matches!(self.pass, Average | Slice | PathTrace | PathTracePixels);
        self.shaded &= lights && reads;
        self.weighted &= self.shaded;
        // Values of slices are classified once they are blended.
        self.opaque &= projects && !slices;
        // Bricks are passes already.
        self.wavefront &= !self.bricks && reads && !slices && !is_whole;
        self.kernels &= reads;
        self.strides &= self.skip && self.pass == Composite;
        self.stack &= slices && !self.bricks && !self.kernels && !self.layered;
        // Slices through one volume look between themselves; those through several find what rays find.
        self.exact &= self.pass == Isosurface && (self.traversal == Traversal::Rays || self.layered) && reads;
        self.bleeding &= slices && self.pass == CompositePre;
        // What the eye sees of slabs is always a cloud, and so is what paths meet.
        self.scattered = (self.scattered && clouds && reads) || matches!(self.pass, HalfAngleEye | PathTrace);
        self.indirect &= matches!(self.pass, HalfAngleLight | HalfAngleEye);
        self.transport &= self.indirect;
        // On the way to the eye's samples only what has a transport of its own becomes more, in any of the volumes.
        let becomes_more = self.transport || self.layered;
        let becomes_indirect = self.pass == HalfAngleLight || (self.pass == HalfAngleEye && becomes_more);
        self.scatters_direct &= self.indirect && becomes_indirect;
        self.gated &= self.scatters_direct && self.pass == HalfAngleLight;
        // Light meets the whole volume, along rays that the eye's rays ask for.
        self.perturbed &= reads && !slices && !self.bricks;
        // Light on its way is held back whatever the colours.
        let composites = matches!(self.pass, Composite | CompositePre | PreIntegrated | HalfAngleEye);
        self.painted &= reads && !slices && !self.bricks && composites;
        // Blending units hold all colours back alike, and so do integrals over segments.
        self.chromatic &= match self.pass {
            Composite => self.traversal == Traversal::Rays,
            HalfAngleLight => self.indirect,
            pass => matches!(pass, HalfAngleEye | HalfAngleSurface | Resolve | PathTracePixels),
        };
        // Slices of values are classified where they have become pixels.
        self.knots &= self.pass.reads() && if projects { !slices } else { !pixels };
        if self.layered {
            // One walk goes through all of them, whole and in steps of one length.
            (self.bricks, self.strides, self.chromatic) = (false, false, false);
            // Surfaces of several volumes are met in one pass: their order is known as long as all of them are at hand.
            self.wavefront &= self.pass != Isosurface;
        }
        self.shadowed &= self.lights() && self.pass.samples() && !slices && !self.bricks;
        self
    }

    /// Whether samples are lit in any way.
    fn lights(&self) -> bool {
        self.shaded || self.scattered
    }

    /// Whether it is put together of the files of several layers.
    fn is_of_several(&self) -> bool {
        self.layered && (self.pass.follows_together() || self.pass == Pass::Apart)
    }

    /// The names that are defined for the preprocessor.
    fn names(&self) -> Vec<&'static str> {
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
            ("LIT", self.lights()),
            ("SCATTERED", self.scattered),
            ("INDIRECT", self.indirect),
            ("TRANSPORT", self.transport),
            ("SCATTERS_DIRECT", self.scatters_direct),
            ("GATED", self.gated),
            ("SHADOWED", self.shadowed),
            ("PERTURBED", self.perturbed),
            ("CHROMATIC", self.chromatic),
            ("KNOTS", self.knots),
            ("PAINTED", self.painted),
            ("LAYERED", self.layered),
            ("APART", self.layered && self.pass.is_apart()),
            ("OF_LIGHT", matches!(self.pass, Pass::HalfAngleLight | Pass::HalfAnglePresence)),
            ("OF_POINTS", self.pass == Pass::LightPoints),
            ("OF_SLABS", matches!(self.pass, Pass::HalfAngleEye | Pass::HalfAngleSurface)),
            ("OF_PATHS", self.pass.traces()),
            ("SURFACES", self.pass == Pass::Isosurface),
            ("EXACT", self.exact),
            ("SEGMENTS", self.pass == Pass::PreIntegrated),
            ("EXTREMES", self.pass.compares_extremes()),
            ("MINIMUM", self.pass == Pass::Minimum),
            ("PRECLASSIFIED", self.pass == Pass::CompositePre),
            ("STACK", self.stack),
            ("BLEEDING", self.bleeding),
            ("GIVEN", self.pass == Pass::SliceGivenPolygons),
            ("SHELLS", self.pass == Pass::SliceShells),
            ("MEAN", self.pass == Pass::Average),
            ("TRANSMITTANCE", self.pass == Pass::XRay),
            ("CLASSIFIED_LAST", matches!(self.pass, Pass::Maximum | Pass::Minimum | Pass::Average)),
        ];
        names.into_iter().filter(|(_, on)| *on).map(|(name, _)| name).collect()
    }
}

/// The names that are defined for the preprocessor: each layer has its own.
fn defines(layers: &[Variant]) -> HashMap<String, ShaderDefValue> {
    let each = layers.iter().enumerate().flat_map(|(layer, variant)| {
        let own = move |name: &str| if variant.is_of_several() { flag_of(name, layer) } else { name.to_owned() };
        variant.names().into_iter().map(own)
    });
    each.map(|name| (name, ShaderDefValue::Bool(true))).collect()
}
