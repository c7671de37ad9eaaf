//! What techniques ask of a scene: every rule of the stage, the plan and the backends that depends on it reads it here.

/// What a technique, with its settings, asks of a scene and heeds of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// How light comes to samples.
    pub light: LightPath,
    /// Whether `quality.classification` decides how samples become colours: others classify each by itself.
    pub classification: bool,
    /// Whether each colour of light can be held back in its own way.
    pub extinction_color: bool,
    /// Whether samples and surfaces look for lights through what lies between.
    pub shadows: bool,
    /// Whether several volumes are drawn in one picture.
    pub several_volumes: bool,
    /// Whether a rule of overlap decides anything: rays that meet surfaces, paths, and light on its way meet all volumes.
    pub overlap: bool,
    /// Whether samples may have colours of their own, those of the data.
    pub data_colors: bool,
}

/// How light comes to samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPath {
    /// It is there, or held back on its way from lights. Samples answer it as surfaces or, if `lighting.model` says so
    /// of composited ones, as a cloud.
    Arrives,
    /// It is followed through the volume, all of which scatters it.
    Travels,
}
