//! The scene document.

use std::path::PathBuf;
use std::sync::Arc;

use pellucid_field::{Short, Volume, VoxelType};
use pellucid_optics::{GradientWeight, Lighting, Material, Perturbation, Scattering, TransferFunction};
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::check::{self, Checked, finite, join, positive, require};
use crate::check_optics;
use crate::{Camera, Clip, Colors, ImageSettings, Invalid, ModelSource, Overlap, Quality, Technique};

/// Everything that decides a picture. Whatever is left out is chosen automatically or takes its
/// documented default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// Version of the document; this program reads version 1. Default 1.
    pub version: u32,
    /// One line about the picture.
    pub title: String,
    /// The volumes with their optics.
    pub volumes: Vec<VolumeEntry>,
    /// What lies where several of them overlap. Default add.
    pub overlap: Overlap,
    /// The camera; left out, it frames the volumes.
    pub camera: Camera,
    /// The lights; left out, one headlight, or none where an environment is the light.
    pub lighting: Lighting,
    /// Clip objects; what all of them keep is drawn.
    pub clips: Vec<Clip>,
    /// Which technique draws, and its settings.
    pub technique: Technique,
    /// How carefully to draw.
    pub quality: Quality,
    /// Size, background and encoding of the picture.
    pub image: ImageSettings,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            version: 1,
            title: String::new(),
            volumes: Vec::new(),
            overlap: Overlap::default(),
            camera: Camera::default(),
            lighting: Lighting::default(),
            clips: Vec::new(),
            technique: Technique::default(),
            quality: Quality::default(),
            image: ImageSettings::default(),
        }
    }
}

/// One volume and how it looks.
///
/// The transfer function comes from, in this order: `transfer_function`; else `colormap` and
/// `opacity` over the window, each completed from the preset if only one is given; else `preset`;
/// else an automatic choice by the data's unit and range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeEntry {
    /// Where the voxels come from.
    pub source: Source,
    /// Which component of the voxels is drawn, numbered from 0; left out, the first, or of 3 or 4 components of 8
    /// or 16 bits, which are colours, the brightness; where those are drawn in their own colours, the fourth if it
    /// varies.
    #[serde(default)]
    pub component: Option<usize>,
    /// Where colours come from; left out, from the data if voxels are colours, composited, and nothing else tells of
    /// colours: no component, preset, colour map or transfer function.
    #[serde(default)]
    pub colors: Option<Colors>,
    /// Distance between samples per axis, replacing the file's.
    #[serde(default)]
    pub spacing: Option<[f64; 3]>,
    /// Part of the grid that is kept; the rest is absent.
    #[serde(default)]
    pub crop: Option<Crop>,
    /// Name of a preset (`pellucid presets` lists them).
    #[serde(default)]
    pub preset: Option<String>,
    /// Data values that colour maps, opacity shapes and presets are spread over; left out, chosen from the
    /// distribution of the values, but for presets in Hounsfield units, which keep their own.
    #[serde(default)]
    pub window: Option<[f64; 2]>,
    /// Name of a colour map, `_r` reverses it; or a colour, by its name or `#rrggbb`.
    #[serde(default)]
    pub colormap: Option<String>,
    /// Name of an opacity shape (linear, sigmoid_5, geom, foreground, ...), `_r` reverses it.
    #[serde(default)]
    pub opacity: Option<String>,
    /// World distance the opacities hold for, replacing that of the transfer function or preset.
    #[serde(default)]
    pub unit_distance: Option<f64>,
    /// The transfer function in full.
    #[serde(default)]
    pub transfer_function: Option<TransferFunction>,
    /// Whether surfaces are lit; left out, the preset decides.
    #[serde(default)]
    pub shading: Option<bool>,
    /// How surfaces reflect; left out, the preset's.
    #[serde(default)]
    pub material: Option<Material>,
    /// Gradient magnitudes between which unlit turns into lit; left out, the preset's or none.
    #[serde(default)]
    pub gradient_weight: Option<GradientWeight>,
    /// How light is scattered, by techniques that follow it through the volume.
    #[serde(default)]
    pub scattering: Scattering,
    /// Noise that displaces what is drawn and varies how it looks; none by default.
    #[serde(default)]
    pub perturbation: Perturbation,
}

impl VolumeEntry {
    /// A volume from a source, everything else automatic.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            component: None,
            colors: None,
            spacing: None,
            crop: None,
            preset: None,
            window: None,
            colormap: None,
            opacity: None,
            unit_distance: None,
            transfer_function: None,
            shading: None,
            material: None,
            gradient_weight: None,
            scattering: Scattering::default(),
            perturbation: Perturbation::default(),
        }
    }

    fn check(&self, path: &str) -> Checked {
        self.source.check(&join(path, "source"))?;
        let component = self.component.unwrap_or(0);
        require(component < 4, path, "component", component, "0 to 3")?;
        for (axis, length) in self.spacing.iter().flatten().enumerate() {
            positive(path, &format!("spacing[{axis}]"), *length, "a length greater than 0")?;
        }
        if let Some(Crop { from, to }) = self.crop {
            finite(path, "crop.from", from)?;
            finite(path, "crop.to", to)?;
            let ordered = (0..3).all(|axis| from[axis] < to[axis]);
            require(ordered, path, "crop.to", format!("{to:?}"), &format!("more than from {from:?} on every axis"))?;
        }
        let names = [&self.preset, &self.colormap, &self.opacity].map(Option::as_deref);
        check_optics::names(path, names[0], names[1], names[2])?;
        if let Some([low, high]) = self.window {
            // Control points at its ends are 32-bit floats in tables.
            let ordered = low < high && low.abs().max(high.abs()) <= f64::from(f32::MAX);
            require(
                ordered,
                path,
                "window",
                format!("[{}, {}]", Short(low), Short(high)),
                "two finite values, the lower first",
            )?;
        }
        if let Some(unit) = self.unit_distance {
            positive(path, "unit_distance", unit, "a length greater than 0")?;
        }
        if let Some(material) = &self.material {
            check_optics::material(&join(path, "material"), material)?;
        }
        if let Some(weight) = &self.gradient_weight {
            check_optics::gradient_weight(&join(path, "gradient_weight"), weight)?;
        }
        check_optics::scattering(&join(path, "scattering"), &self.scattering)?;
        check_optics::perturbation(&join(path, "perturbation"), &self.perturbation)?;
        let transport = self.perturbation.optics.transport;
        let meant = transport == 0.0 || self.scattering.transport.is_some();
        let allowed = "0, or scattering.transport, which it varies";
        require(meant, path, "perturbation.optics.transport", transport, allowed)
    }
}

/// Part of a grid, in continuous voxel indices.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Crop {
    /// Lowest index kept, x, y, z.
    pub from: [f64; 3],
    /// Highest index kept.
    pub to: [f64; 3],
}

/// Where voxels come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(transform = memory_is_a_word)]
pub enum Source {
    /// A file that describes itself; a relative path starts at the scene's folder.
    File(PathBuf),
    /// A headerless file.
    Raw {
        /// The file; a relative path starts at the scene's folder.
        path: PathBuf,
        /// Voxels per axis, x (fastest), y, z.
        dims: [usize; 3],
        /// Type of the values.
        voxel_type: VoxelType,
        /// Interleaved values per voxel, 1 to 4. Default 1.
        #[serde(default = "one")]
        components: usize,
        /// Bytes before the first value. Default 0.
        #[serde(default)]
        skip: u64,
        /// Whether values are stored most significant byte first. Default false.
        #[serde(default)]
        big_endian: bool,
    },
    /// A built-in closed-form field (`pellucid sample --list`).
    Sample(SampleSource),
    /// A volume made by a procedure.
    Model(ModelSource),
    /// Voxels that a program hands over; a document cannot hold them.
    Memory(
        #[serde(skip)]
        #[schemars(with = "()")]
        Held,
    ),
}

fn one() -> usize {
    1
}

/// Voxels that a program has in memory; none in a scene that was read from a document.
#[derive(Clone, Debug, Default)]
pub struct Held(pub Option<Arc<Volume>>);

/// In documents the variant that holds voxels is a word, as serde has it without them.
fn memory_is_a_word(schema: &mut Schema) {
    let variants = schema.get_mut("oneOf").and_then(Value::as_array_mut);
    for variant in variants.into_iter().flatten().filter(|variant| variant["properties"]["memory"].is_object()) {
        *variant = json!({ "description": variant["description"], "type": "string", "const": "memory" });
    }
}

/// The same voxels, not equal ones: comparing scenes must not compare gigabytes.
impl PartialEq for Held {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() == b.is_none(),
        }
    }
}

impl From<Arc<Volume>> for Source {
    fn from(volume: Arc<Volume>) -> Self {
        Self::Memory(Held(Some(volume)))
    }
}

impl From<Volume> for Source {
    fn from(volume: Volume) -> Self {
        Arc::new(volume).into()
    }
}

/// A built-in field, sampled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SampleSource {
    /// Its name.
    pub name: String,
    /// Voxels per axis; left out, the field's own default.
    #[serde(default)]
    pub dims: Option<[usize; 3]>,
    /// Type of the values; left out, the field's own default.
    #[serde(default)]
    pub voxel_type: Option<VoxelType>,
}

impl Source {
    /// Voxels that the program hands over later, to [`Scene::resolve`].
    pub const fn memory() -> Self {
        Self::Memory(Held(None))
    }

    fn check(&self, path: &str) -> Checked {
        let dims = match self {
            Self::Raw { dims, components, skip, .. } => {
                require((1..=4).contains(components), path, "raw.components", components, "1 to 4")?;
                // TOML has no larger integers, and no disk such files.
                require(i64::try_from(*skip).is_ok(), path, "raw.skip", skip, "less than 2^63 bytes")?;
                Some((dims, "raw.dims"))
            }
            Self::Sample(sample) => sample.dims.as_ref().map(|dims| (dims, "sample.dims")),
            Self::Model(model) => return model.check(&join(path, "model")),
            Self::File(_) | Self::Memory(_) => None,
        };
        let Some((found, key)) = dims else { return Ok(()) };
        check::dims(path, key, found)
    }
}

impl Scene {
    /// A scene of one volume, everything else automatic.
    pub fn of(source: Source) -> Self {
        Self { volumes: vec![VolumeEntry::new(source)], ..Self::default() }
    }

    /// Checks every value against its documented range.
    ///
    /// # Errors
    /// The first value out of range, with its path in the document.
    pub fn validate(&self) -> Result<(), Invalid> {
        require(self.version == 1, "", "version", self.version, "1, the version this program reads")?;
        for (k, entry) in self.volumes.iter().enumerate() {
            entry.check(&format!("volumes[{k}]"))?;
        }
        self.overlap.check(self.volumes.len())?;
        self.camera.check("camera")?;
        for (k, light) in self.lighting.lights.iter().enumerate() {
            check_optics::light(&format!("lighting.lights[{k}]"), light)?;
        }
        let ambient = self.lighting.ambient;
        require(ambient >= 0.0 && ambient.is_finite(), "lighting", "ambient", ambient, "0 or more")?;
        check_optics::shadows("lighting.shadows", &self.lighting.shadows)?;
        for (k, clip) in self.clips.iter().enumerate() {
            clip.check(&format!("clips[{k}]"))?;
        }
        self.technique.check("technique")?;
        self.quality.check("quality")?;
        self.image.check("image")
    }
}
