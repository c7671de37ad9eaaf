//! Settings of half-angle slicing (Kniss et al. 2003, section 6.3).

use pellucid_optics::Lighting;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Technique;
use super::needs::{LightPath, Needs};
use super::settings::Settings;
use crate::Look;
use crate::check::{Checked, require};

/// Light that travels through the volume while it is drawn: slices halfway between the light and the eye
/// serve both. Their distance along a ray in the middle of the picture is `quality.step`.
///
/// Direct light loses what the transfer function takes out of it. Indirect light is what was scattered
/// forward, into a cone around the light's direction: it is blurred from slice to slice and loses what
/// `scattering.transport` says, which lets it reach deeper. It never turns back and never leaves the cone, so
/// light does not bleed around an obstacle (6.3-12). The model is made for the eye and does not conserve
/// energy: without attenuation both terms together are brighter than the light.
///
/// Every sample is classified by itself (post-classification), and what it gives back of the light is its
/// `scattering.albedo`. A shaded volume's material counts where `scattering.surface` makes one of its samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HalfAngle {
    /// The light that shines, numbered from 0; left out, all of them, in a sweep each. They must stand outside
    /// the volume.
    pub light: Option<usize>,
    /// Texels along the longer side of the light's picture of the volume, 16 to 4096. Default 512.
    pub resolution: u32,
    /// What light loses on its way into the slice that it lights (K-06b). Default half_slab.
    pub correction: LightCorrection,
    /// Factor of the direct light, 0 to 100; default 1.
    pub direct: f32,
    /// Factor of the indirect light, 0 to 100; 0 draws shadows alone, in less time. Default 1.
    pub indirect: f32,
    /// Indirect light that enters the volume, as a share of the light, 0 to 10: 1 as if it shone through mist,
    /// 0 leaves what direct light turns into by `in_scatter` (6.3-4). Default 1.
    pub initial_indirect: f32,
    /// Full angle at the apex of the cone that light is scattered into, in degrees, 0 to 90. Default 20.
    pub blur_angle: f64,
    /// How many places a slice's indirect light is gathered from, 1 to 16; a single one does not blur.
    /// Default 4.
    pub taps: u32,
    /// Where in the cone they lie. Default per_slice.
    pub jitter: BlurJitter,
    /// Chooses the pattern of the jitter. Default 0.
    pub seed: u32,
    /// How the blur follows the distance of slices. Default per_slice.
    pub blur_scaling: BlurScaling,
    /// What becomes indirect light in a slice (6.3-7). Default indirect.
    pub in_scatter: InScatter,
    /// Whether the scene's ambient light shines, too (K-16). Default false.
    pub ambient: bool,
}

impl Default for HalfAngle {
    fn default() -> Self {
        Self {
            light: None,
            resolution: 512,
            correction: LightCorrection::default(),
            direct: 1.0,
            indirect: 1.0,
            initial_indirect: 1.0,
            blur_angle: 20.0,
            taps: 4,
            jitter: BlurJitter::default(),
            seed: 0,
            blur_scaling: BlurScaling::default(),
            in_scatter: InScatter::default(),
            ambient: false,
        }
    }
}

/// What light loses on its way into the slice that it lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LightCorrection {
    /// What the half of the slice takes that it has crossed: errors fall with the square of the step (K-06b).
    #[default]
    HalfSlab,
    /// Nothing, as in the classical method: slices are lit by what reaches their front, always too brightly; errors fall
    /// with the step (6.1-4).
    None,
}

/// Where the taps of the blur lie. They are the corners of a regular polygon, the same for all texels, so
/// that light is neither moved nor lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BlurJitter {
    /// On the rim of the cone, everywhere and always at the same angles.
    Fixed,
    /// Turned by another angle and on another circle for every slice, so that they fill the cone's disc.
    #[default]
    PerSlice,
}

/// How the radius of the blur follows the distance `d` of slices along the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BlurScaling {
    /// `d tan(angle / 2)`, as it was published. Offsets of slices add like a random walk, so finer slices blur
    /// less, with the root of their distance (K-09).
    #[default]
    PerSlice,
    /// That of slices one voxel apart, whatever their number: the radius grows with the root of `d`.
    PerDistance,
}

/// What becomes indirect light in a slice (Eq. 6.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InScatter {
    /// Indirect light alone, spread evenly (6.3-7 a, K-09).
    #[default]
    Indirect,
    /// Direct light, too: what the slice takes of it and does not absorb, weighted by the phase function over
    /// its forward value (6.3-7 b, Eq. 6.8). Means something only where `transport` is absorption.
    Direct,
    /// Direct light, from places that hold something (6.3-7 c).
    DirectFromMatter,
    /// Both from places that hold something (6.3-7 d): nothing passes gaps but direct light.
    BothFromMatter,
}

impl Settings for HalfAngle {
    fn name(&self) -> &'static str {
        "half_angle"
    }

    fn needs(&self) -> Needs {
        Needs {
            light: LightPath::Spreads,
            ambient: self.ambient,
            classification: false,
            extinction_color: true,
            shadows: false,
            several_volumes: true,
            overlap: true,
            data_colors: true,
            adaptive: false,
            jitter: true,
            front_to_back: true,
            blending: false,
            frames: 1,
        }
    }

    fn plain(&self) -> Technique {
        Technique::HalfAngle(Self::default())
    }

    fn idle(&self) -> Vec<(&'static str, &'static str)> {
        let all = |names: &[&'static str], reason| names.iter().map(|name| (*name, reason)).collect();
        match self {
            Self { indirect, .. } if *indirect <= 0.0 => all(
                &["initial_indirect", "in_scatter", "blur_angle", "taps", "blur_scaling", "jitter", "seed"],
                "there is no indirect light",
            ),
            Self { taps: ..=1, .. } => all(&["jitter", "seed"], "a single tap does not blur"),
            Self { jitter: BlurJitter::Fixed, .. } => all(&["seed"], "the taps are at the same places in every slice"),
            _ => Vec::new(),
        }
    }

    fn light_by(&mut self, look: Look, lighting: &mut Lighting) {
        self.ambient = true;
        // What is spread forward reaches shadows as well.
        lighting.ambient = lighting.ambient.min(0.35);
        self.blur_angle = if look == Look::Skin { 45.0 } else { 35.0 };
        (self.in_scatter, self.initial_indirect, self.indirect) = match look {
            Look::Cloud => (InScatter::DirectFromMatter, 0.3, 1.0),
            _ => (InScatter::default(), 1.0, 0.55),
        };
    }

    fn check(&self, path: &str) -> Checked {
        require((16..=4096).contains(&self.resolution), path, "resolution", self.resolution, "16 to 4096 texels")?;
        for (key, factor) in [("direct", self.direct), ("indirect", self.indirect)] {
            require((0.0..=100.0).contains(&factor), path, key, factor, "0 to 100")?;
        }
        let initial = self.initial_indirect;
        require((0.0..=10.0).contains(&initial), path, "initial_indirect", initial, "0 to 10")?;
        let angle = self.blur_angle;
        require((0.0..=90.0).contains(&angle), path, "blur_angle", angle, "0 to 90 degrees")?;
        require((1..=16).contains(&self.taps), path, "taps", self.taps, "1 to 16")
    }
}
