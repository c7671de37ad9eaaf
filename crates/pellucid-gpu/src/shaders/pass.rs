//! The passes, and the files that they are put together of.

/// A file of this folder: its name and its text.
pub(super) struct Wgsl {
    pub name: &'static str,
    pub text: &'static str,
}

macro_rules! wgsl {
    ($name:literal) => {
        Wgsl { name: $name, text: include_str!(concat!($name, ".wgsl")) }
    };
}

/// What passes import; each only from those above it.
pub(super) const SHARED: &[Wgsl] = &[
    wgsl!("frame"),
    wgsl!("lists"),
    wgsl!("way"),
    wgsl!("ray"),
    wgsl!("kernel"),
    wgsl!("noise"),
    wgsl!("field"),
    wgsl!("table"),
    wgsl!("paint"),
    wgsl!("vary"),
    wgsl!("levels"),
    wgsl!("pieces"),
    wgsl!("monotone"),
    wgsl!("skip"),
    wgsl!("shadow"),
    wgsl!("points"),
    wgsl!("light_volume"),
    wgsl!("scatter"),
    wgsl!("normal"),
    wgsl!("arriving"),
    wgsl!("blinn_phong"),
    wgsl!("scattered"),
    wgsl!("hybrid"),
    wgsl!("light"),
    wgsl!("march"),
    wgsl!("cut"),
    wgsl!("surface"),
    wgsl!("projected"),
    wgsl!("preclassify"),
    wgsl!("classified"),
    wgsl!("integrals"),
    wgsl!("cursor"),
    wgsl!("crossing"),
    wgsl!("slices"),
    wgsl!("polygon"),
    wgsl!("pixel"),
    wgsl!("sliced"),
    wgsl!("window"),
    wgsl!("passage"),
    wgsl!("sweep"),
    wgsl!("slab"),
    wgsl!("eye"),
    wgsl!("slab_light"),
    wgsl!("random"),
    wgsl!("flight"),
    wgsl!("paths"),
    wgsl!("vertex"),
    wgsl!("extent"),
    wgsl!("sky"),
];

/// What light and the eye are told of slabs by one volume; several tell it together.
pub(super) const OF_ONE: [Wgsl; 3] = [wgsl!("slabs_of_one"), wgsl!("line_of_one"), wgsl!("look_of_one")];

/// What several volumes in one pass have besides: what each of them is asked.
pub(super) const OF_EACH: [Wgsl; 3] = [wgsl!("layer"), wgsl!("hits"), wgsl!("part")];

/// What they are together; each only from those above it.
pub(super) const OF_ALL: [Wgsl; 10] = [
    MERGE,
    wgsl!("ways"),
    wgsl!("ahead"),
    wgsl!("slice_nodes"),
    wgsl!("together"),
    wgsl!("sights"),
    wgsl!("slab_pieces"),
    wgsl!("slabs_of_several"),
    wgsl!("line_of_several"),
    wgsl!("look_of_several"),
];
pub(super) const MERGE: Wgsl = wgsl!("merge");

/// Passes over several volumes that have files of their own.
pub(super) const LAYERS: Wgsl = wgsl!("layers");
pub(super) const ISOSURFACES: Wgsl = wgsl!("isosurfaces");
pub(super) const APART: Wgsl = wgsl!("apart");
pub(super) const SLICE_LAYERS: Wgsl = wgsl!("slice_layers");
pub(super) const SLICE_ISOSURFACES: Wgsl = wgsl!("slice_isosurfaces");
pub(super) const SLICE_LAYERS_PIXELS: Wgsl = wgsl!("slice_layers_pixels");

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
    /// What rays have found in several volumes, each followed by itself, in one.
    Apart,
    /// Rays into pixels.
    Resolve,
    /// Polygons in which slices cut boxes.
    SlicePolygons,
    /// The same, cut by the processor.
    SliceGivenPolygons,
    /// Shells around the eye.
    SliceShells,
    /// The whole window, for each slice through several volumes.
    SliceWindows,
    /// Marks pixels that slices have made opaque.
    SliceDone,
    /// The least opacity of squares of pixels.
    SliceTiles,
    /// Boxes that slices hide.
    SliceOcclusion,
    /// Light on its way through a slab of half-angle slicing.
    HalfAngleLight,
    /// Where a slab holds something.
    HalfAnglePresence,
    /// What the eye sees of slabs.
    HalfAngleEye,
    /// What a light brought to pixels, and their surface.
    HalfAngleSurface,
    /// Light at the points of a light volume.
    LightPoints,
    /// Paths of light.
    PathTrace,
    /// What they brought to pixels.
    PathTracePixels,
}

/// How a pass gets at the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Traversal {
    /// Along rays.
    Rays,
    /// Slice by slice: what a fragment adds.
    Slices,
    /// What slices have added up to, as pixels.
    SlicePixels,
}

impl Pass {
    /// All passes.
    pub const ALL: [Self; 26] = [
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
        Self::Apart,
        Self::Resolve,
        Self::SlicePolygons,
        Self::SliceGivenPolygons,
        Self::SliceShells,
        Self::SliceWindows,
        Self::SliceDone,
        Self::SliceTiles,
        Self::SliceOcclusion,
        Self::HalfAngleLight,
        Self::HalfAnglePresence,
        Self::HalfAngleEye,
        Self::HalfAngleSurface,
        Self::LightPoints,
        Self::PathTrace,
        Self::PathTracePixels,
    ];

    /// Whether it makes something of samples along rays, which slices can do as well.
    pub(crate) fn samples(self) -> bool {
        use Pass::*;
        let sampling = [Composite, CompositePre, PreIntegrated, Maximum, Minimum, Average, Additive, XRay, Isosurface];
        sampling.contains(&self)
    }

    /// Whether it follows rays, or paths, through several volumes together.
    pub fn follows_together(self) -> bool {
        use Pass::*;
        let is_of_rays = matches!(self, Composite | CompositePre | PreIntegrated | Isosurface);
        let is_of_slabs = matches!(self, HalfAngleLight | HalfAnglePresence | HalfAngleEye | HalfAngleSurface);
        is_of_rays || is_of_slabs || self.traces()
    }

    /// Whether it follows rays through each of several volumes by itself: what it makes of a ray has no place on it.
    pub(crate) fn is_apart(self) -> bool {
        use Pass::*;
        matches!(self, Maximum | Minimum | Average | Additive | XRay | Slice)
    }

    /// Whether it knows that there are several volumes.
    pub(crate) fn is_of_layers(self, traversal: Traversal) -> bool {
        match traversal {
            Traversal::Rays => {
                self.follows_together() || self.is_apart() || matches!(self, Self::Apart | Self::Resolve)
            }
            Traversal::Slices => self.follows_together(),
            // What slices through each volume have added up to is merged.
            Traversal::SlicePixels => self.follows_together() || self.is_apart(),
        }
    }

    /// Whether it follows rays through slabs.
    pub(crate) fn sweeps(self) -> bool {
        use Pass::*;
        matches!(self, HalfAngleLight | HalfAnglePresence | HalfAngleEye | HalfAngleSurface | LightPoints)
    }

    /// Whether it follows paths of light, or looks at what they brought.
    pub(crate) fn traces(self) -> bool {
        matches!(self, Self::PathTrace | Self::PathTracePixels)
    }

    /// Whether it looks at the volume.
    pub(crate) fn reads(self) -> bool {
        self.samples() || self.sweeps() || self.traces() || self == Self::Slice
    }

    /// The file with the entry point, and the mode it walks for.
    pub(super) fn files(self, traversal: Traversal) -> (Wgsl, Option<Wgsl>) {
        let slices = traversal == Traversal::Slices;
        let samples = |mode| (if slices { wgsl!("slice_samples") } else { wgsl!("samples") }, Some(mode));
        let segments = |mode| (if slices { wgsl!("slice_segments") } else { wgsl!("segments") }, Some(mode));
        match self {
            _ if traversal == Traversal::SlicePixels => (wgsl!("slice_pixels"), None),
            Self::Maximum | Self::Minimum | Self::Average if slices => samples(wgsl!("slice_value")),
            Self::Composite | Self::CompositePre => samples(wgsl!("composite")),
            Self::Maximum | Self::Minimum => (wgsl!("extreme"), None),
            Self::Average => samples(wgsl!("average")),
            Self::Additive => samples(wgsl!("additive")),
            Self::XRay => samples(wgsl!("xray")),
            Self::PreIntegrated => segments(wgsl!("preintegrated")),
            Self::Isosurface => segments(wgsl!("isosurface")),
            Self::Slice => (wgsl!("slice"), None),
            Self::Apart => (APART, None),
            Self::Resolve => (wgsl!("resolve"), None),
            Self::SlicePolygons | Self::SliceGivenPolygons | Self::SliceShells => (wgsl!("slice_proxies"), None),
            Self::SliceWindows => (wgsl!("slice_windows"), None),
            Self::SliceDone => (wgsl!("slice_done"), None),
            Self::SliceTiles => (wgsl!("slice_tiles"), None),
            Self::SliceOcclusion => (wgsl!("slice_occlusion"), None),
            Self::HalfAngleLight => (wgsl!("half_angle_light"), None),
            Self::HalfAnglePresence => (wgsl!("half_angle_presence"), None),
            Self::HalfAngleEye => (wgsl!("half_angle_eye"), None),
            Self::HalfAngleSurface => (wgsl!("half_angle_surface"), None),
            Self::LightPoints => (wgsl!("light_points"), None),
            Self::PathTrace => (wgsl!("path_trace"), Some(wgsl!("alone"))),
            Self::PathTracePixels => (wgsl!("path_trace_pixels"), Some(wgsl!("sight"))),
        }
    }

    /// Whether blocks are compared with the extreme that was found instead of being live or not.
    pub fn compares_extremes(self) -> bool {
        matches!(self, Self::Maximum | Self::Minimum)
    }
}

impl Traversal {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Rays, Self::Slices, Self::SlicePixels];
}
