//! What techniques ask of a scene: every rule of the stage, the plan and the backends that depends on it reads it here.

/// What a technique, with its settings, asks of a scene and heeds of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// How light comes to samples.
    pub light: LightPath,
    /// Whether samples reflect `lighting.ambient`.
    pub ambient: bool,
    /// Whether `quality.classification` decides how samples become colours: others classify each by itself.
    pub classification: bool,
    /// Whether each colour of light can be held back in its own way.
    pub extinction_color: bool,
    /// Whether samples and surfaces look for lights through what lies between.
    pub shadows: bool,
    /// Whether several volumes are drawn in one picture.
    pub several_volumes: bool,
    /// Whether a rule of overlap decides anything: rays that meet surfaces, and paths, meet all volumes.
    pub overlap: bool,
    /// Whether samples may have colours of their own, those of the data.
    pub data_colors: bool,
    /// Whether steps may adapt to the data.
    pub adaptive: bool,
    /// Whether samples may be moved off their places by noise.
    pub jitter: bool,
    /// Whether what is nearest comes first, so that what is behind need not be drawn.
    pub front_to_back: bool,
    /// Whether fragments are blended, which graphics devices alone do.
    pub blending: bool,
    /// Pictures that are held while it draws, the one that is drawn among them.
    pub frames: usize,
}

/// How light comes to samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPath {
    /// It is there, or held back on its way from lights. Samples answer it as surfaces or, if `lighting.model` says so
    /// of composited ones, as a cloud.
    Arrives,
    /// It goes through the volume from slab to slab, and what is scattered goes with it.
    Spreads,
    /// It is followed from one scattering to the next, as it happens.
    Scatters,
}

impl LightPath {
    /// Whether light is followed through the volume, all of which scatters it.
    pub fn is_followed(self) -> bool {
        self != Self::Arrives
    }
}
