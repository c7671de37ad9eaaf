//! Volumes made by procedures, as they stand in a document.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, dims, finite, require};

/// A procedure, and how it is baked into voxels: once, when the scene is loaded, one evaluation a voxel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum ModelSource {
    /// The large shape of a cloud: ellipsoids that blend into each other, in a box of 2 x 2 x 1.2, values 0 to 1
    /// (K-25). `perturbation` gives it detail.
    Clouds(CloudsSource),
    /// Smoke: the magnitude of five octaves of sines in a box of 1 x 1 x 1 (MOD-06).
    Spectral(SpectralSource),
    /// Terrain: a slab over a map of heights on 1 x 1, values 0 to 1 (K-28).
    HeightField(HeightFieldSource),
}

/// A cloud of ellipsoids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CloudsSource {
    /// Number of the cloud: the same seed is the same cloud everywhere. Default 0.
    pub seed: u32,
    /// How many ellipsoids, 1 to 256. Default 32.
    #[schemars(range(min = 1, max = 256))]
    pub ellipsoids: usize,
    /// Voxels per axis, 1 to 65536; left out, 64 along each.
    pub dims: [usize; 3],
}

impl Default for CloudsSource {
    fn default() -> Self {
        Self { seed: 0, ellipsoids: 32, dims: [64; 3] }
    }
}

/// Smoke of sines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpectralSource {
    /// Phases of every octave along x, y and z, in radians; left out, all 0.
    pub phases: [[f64; 3]; 5],
    /// Voxels per axis, 1 to 65536; left out, 128 along each.
    pub dims: [usize; 3],
}

impl Default for SpectralSource {
    fn default() -> Self {
        Self { phases: [[0.0; 3]; 5], dims: [128; 3] }
    }
}

/// A slab that follows a map of heights, `bottom` to `top` above it, and fades out towards both faces. Voxels take the
/// level of the map whose texels are about as large as they are (K-29).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeightFieldSource {
    /// Where the heights come from; left out, mountains of seed 0.
    pub map: HeightSource,
    /// Height of the map's largest value over its smallest possible one, in widths of the map, 0 to 10. Default 0.25.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub relief: f64,
    /// The slab's faces over the map, in widths of the map, the lower first; left out, -0.06 and 0.
    pub slab: [f64; 2],
    /// Distance over which it fades out inside of both faces, above 0 and at most half of the slab. Default 0.02.
    pub ramp: f64,
    /// Voxels per axis, 1 to 65536; left out, 256, 256 and 96.
    pub dims: [usize; 3],
}

/// A map of heights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum HeightSource {
    /// Mountains out of noise, of 1024 x 1024 heights: the same seed is the same land everywhere.
    Terrain(u32),
    /// A PNG file whose mean of red, green and blue is the height, black to white; its top row lies farthest along y.
    /// A relative path starts at the scene's folder.
    File(PathBuf),
}

impl Default for HeightFieldSource {
    fn default() -> Self {
        Self { map: HeightSource::Terrain(0), relief: 0.25, slab: [-0.06, 0.0], ramp: 0.02, dims: [256, 256, 96] }
    }
}

impl ModelSource {
    pub(crate) fn check(&self, path: &str) -> Checked {
        match self {
            Self::Clouds(CloudsSource { ellipsoids, dims: found, .. }) => {
                require((1..=256).contains(ellipsoids), path, "clouds.ellipsoids", ellipsoids, "1 to 256")?;
                dims(path, "clouds.dims", found)
            }
            Self::Spectral(SpectralSource { phases, dims: found }) => {
                for (octave, phases) in phases.iter().enumerate() {
                    finite(path, &format!("spectral.phases[{octave}]"), *phases)?;
                }
                dims(path, "spectral.dims", found)
            }
            Self::HeightField(HeightFieldSource { relief, slab: [bottom, top], ramp, dims: found, .. }) => {
                require((0.0..=10.0).contains(relief), path, "height_field.relief", relief, "0 to 10 widths")?;
                let is_slab = bottom < top && bottom.abs().max(top.abs()) <= 10.0;
                let slab = format!("[{bottom}, {top}]");
                require(is_slab, path, "height_field.slab", slab, "two numbers from -10 to 10, the lower first")?;
                let most = (top - bottom) / 2.0;
                let expected = format!("above 0 and at most half of the slab, {most}");
                require(*ramp > 0.0 && *ramp <= most, path, "height_field.ramp", ramp, &expected)?;
                dims(path, "height_field.dims", found)
            }
        }
    }
}
