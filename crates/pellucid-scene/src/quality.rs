//! How carefully to draw: one setting per stage of the pipeline (9.0-1).

use pellucid_field::{Filter, Gradient};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, join, require};
use crate::check_optics;

/// Quality settings. Changing one does not alter another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Quality {
    /// Distance between samples, in units of the smallest voxel spacing: 0.01 to 100. Default 0.5,
    /// two samples per voxel (9.1-1).
    pub step: f64,
    /// Reconstruction between voxels. Default linear.
    pub filter: Filter,
    /// Gradient estimator for shading. Default central.
    pub gradient: Gradient,
    /// Where the transfer function is applied. Default post.
    pub classification: Classification,
    /// Where in its step a ray takes its first sample. Default centered.
    pub jitter: Jitter,
    /// A ray stops when its opacity reaches this, 0 to 1; 1 never stops early. Default 0.999.
    pub early_termination: f32,
    /// How far a longer step may be from the steps it stands for, in associated colour or opacity, 0
    /// to 1 (7.3-3): where the transfer function is nearly straight over the values of a block of the
    /// volume, samples are taken at two or four times the step. 0 takes every sample. Composited,
    /// post-classified pictures only. Default 0.
    pub adaptive_tolerance: f32,
    /// Whether blocks without opacity are leapt over; the picture is the same. Default true.
    pub empty_space_skipping: bool,
    /// Rays per pixel and axis, 1 to 16: 2 draws four rays a pixel. Default 1.
    pub supersampling: u32,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            step: 0.5,
            filter: Filter::default(),
            gradient: Gradient::default(),
            classification: Classification::default(),
            jitter: Jitter::default(),
            early_termination: 0.999,
            adaptive_tolerance: 0.0,
            empty_space_skipping: true,
            supersampling: 1,
        }
    }
}

/// Where the transfer function is applied (chapter 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Classification {
    /// To the interpolated value (4.3).
    #[default]
    Post,
    /// To voxels, interpolating associated colours (4.2).
    Pre,
    /// To segments, with a table of ray integrals (4.5, 4.6).
    PreIntegrated,
}

/// Where in its step a ray takes its first sample (9.1-4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Jitter {
    /// In the middle, for every pixel: `t_k = t_entry + (k + 1/2) step`.
    #[default]
    Centered,
    /// At a blue-noise offset per pixel, the same for the same seed: wood grain becomes fine noise.
    BlueNoise {
        /// Chooses the pattern. Default 0.
        #[serde(default)]
        seed: u32,
    },
}

impl Quality {
    pub(crate) fn check(&self, path: &str) -> Checked {
        require((0.01..=100.0).contains(&self.step), path, "step", self.step, "0.01 to 100 voxel spacings")?;
        let early = self.early_termination;
        require(early > 0.0 && early <= 1.0, path, "early_termination", early, "an opacity above 0, up to 1")?;
        let tolerance = self.adaptive_tolerance;
        require((0.0..=1.0).contains(&tolerance), path, "adaptive_tolerance", tolerance, "0 to 1")?;
        require((1..=16).contains(&self.supersampling), path, "supersampling", self.supersampling, "1 to 16")?;
        check_optics::filter(&join(path, "filter"), &self.filter)?;
        check_optics::gradient(&join(path, "gradient"), &self.gradient)
    }
}
