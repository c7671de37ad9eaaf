//! Settings of the path tracer.

use pellucid_optics::{Environment, Lighting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Technique;
use super::needs::{LightPath, Needs};
use super::settings::Settings;
use crate::Look;
use crate::check::{Checked, join, positive, require};
use crate::check_optics;

/// Settings of the path tracer: light by the equation of transfer, with every scattering, free of bias
/// and with noise that falls with the square root of the samples.
///
/// Every sample is classified by itself (post-classification). A volume scatters as its `scattering`
/// says; its material's emission shines at every point that has opacity, and `ambient` is not used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PathTrace {
    /// Paths per pixel, at most, 1 to 1048576. Default 64.
    pub samples: u32,
    /// How often a path is scattered, at most, 0 to 100000; with 0 there is emission alone, with 1 single
    /// scattering. Default 1000. That is as often as it takes, but for the densest of white media.
    pub bounces: u32,
    /// The standard error, as a share of a pixel's brightness, with which the pixel is done before it has
    /// all samples, 0 to 1; 0 takes all. Default 0.
    pub noise: f32,
    /// Light from far away, all around. It is not seen behind the volume: the background is the image's.
    /// Default dark.
    pub environment: Environment,
    /// Radius of the lens in world units, 0 or more: what is not in focus is blurred. Default 0.
    pub aperture: f64,
    /// Distance in world units, along the view, of what is in focus; left out, the target's.
    pub focus: Option<f64>,
    /// The start of the random numbers: another seed, other noise. Default 0.
    pub seed: u32,
    /// Scatterings after which dim paths are ended at random, 0 to 100000. Default 4.
    pub roulette: u32,
    /// How far in front of its collision a surface is lit, in mean free paths (one over the extinction there), at
    /// most a voxel, 0 to 100. A path collides within the matter of a surface, whose outer part then shadows it: of
    /// a flat one, half of the light. 3 leaves a twentieth of that shadow. Walls that are thicker keep theirs, and
    /// clouds are lit where they are. Default 0, which is free of bias.
    pub surface_depth: f32,
    /// Whether noise is taken out of the picture's colours: pixels around that are alike up to their noise, as deep,
    /// facing alike and covered alike, exchange their light, and speckles (fireflies) are spread over wide surroundings.
    /// None of it is lost, but its place is no longer free of bias. 16 samples a pixel then look like 64 to 100 without
    /// it. The frame's noise is that of the paths. Default false.
    pub denoise: bool,
    /// How bright a path may be, 0 or more: one with a higher luminance, of which 1 is white, is held to it in its own
    /// colour. Rare bright paths are the speckles (fireflies) that fall slowest with more samples; what is held back is
    /// missing from the picture, which is darker by a share that the renderer of the processor reports, most of all
    /// where light is focused: highlights, and rims of clouds in front of the sun. Keep it well above the brightest that
    /// is seen. On a cloud under a sun of 1.7, 4 takes 0.05 % of the light and gains 0.03 dB at 64 samples a pixel, and
    /// 10 does nothing; `denoise` gains 6 dB and keeps all light: try that first. Default 0, which holds nothing back
    /// and is free of bias.
    pub firefly_clamp: f32,
    /// What bounds the extinction where paths look for their next collision. Default local.
    pub majorants: Majorants,
}

impl Default for PathTrace {
    fn default() -> Self {
        Self {
            samples: 64,
            bounces: 1000,
            noise: 0.0,
            environment: Environment::default(),
            aperture: 0.0,
            focus: None,
            seed: 0,
            roulette: 4,
            surface_depth: 0.0,
            denoise: false,
            firefly_clamp: 0.0,
            majorants: Majorants::default(),
        }
    }
}

/// Bounds of the extinction. The picture is the same but for its noise, and the time it takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Majorants {
    /// One for every block of the data: thin parts take few looks and empty ones none.
    #[default]
    Local,
    /// One for all of it.
    Global,
}

impl PathTrace {
    /// Fewest paths by which [`noise`](Self::noise) is judged: of fewer, dark pixels are often not without noise but
    /// unlucky.
    pub const LEAST_TO_JUDGE: u32 = 64;
}

impl Settings for PathTrace {
    fn name(&self) -> &'static str {
        "path_trace"
    }

    /// Paths look at extinctions, of each colour if they differ, and not at opacities of samples.
    fn needs(&self) -> Needs {
        Needs {
            light: LightPath::Scatters,
            ambient: false,
            classification: false,
            extinction_color: false,
            shadows: false,
            several_volumes: true,
            overlap: false,
            data_colors: false,
            adaptive: false,
            jitter: true,
            front_to_back: true,
            blending: false,
            // Passes are averaged, and the denoiser's planes are as much as two pictures.
            frames: if self.denoise { 4 } else { 2 },
        }
    }

    fn environment(&self) -> Option<&Environment> {
        Some(&self.environment)
    }

    fn environment_mut(&mut self) -> Option<&mut Environment> {
        Some(&mut self.environment)
    }

    fn plain(&self) -> Technique {
        Technique::PathTrace(Self::default())
    }

    fn idle(&self) -> Vec<(&'static str, &'static str)> {
        let focused = self.aperture <= 0.0;
        focused.then_some(("focus", "everything is in focus without an aperture")).into_iter().collect()
    }

    fn light_by(&mut self, look: Look, lighting: &mut Lighting) {
        self.environment = look.environment();
        self.surface_depth = if look == Look::Cloud { 0.0 } else { 3.0 };
        self.denoise = true;
        // The sky and the ambient light are the same light.
        if look == Look::Sky {
            lighting.lights.clear();
        }
    }

    fn check(&self, path: &str) -> Checked {
        require((1..=1 << 20).contains(&self.samples), path, "samples", self.samples, "1 to 1048576")?;
        require(self.bounces <= 100_000, path, "bounces", self.bounces, "0 to 100000")?;
        require((0.0..=1.0).contains(&self.noise), path, "noise", self.noise, "0 to 1")?;
        check_optics::environment(&join(path, "environment"), &self.environment)?;
        let aperture = self.aperture;
        require((0.0..=1e30).contains(&aperture), path, "aperture", aperture, "0 or a length")?;
        if let Some(focus) = self.focus {
            positive(path, "focus", focus, "a length greater than 0")?;
        }
        let depth = self.surface_depth;
        require((0.0..=100.0).contains(&depth), path, "surface_depth", depth, "0 to 100 mean free paths")?;
        let clamp = self.firefly_clamp;
        require((0.0..=1e9).contains(&clamp), path, "firefly_clamp", clamp, "0 or a luminance up to 1e9")?;
        require(self.roulette <= 100_000, path, "roulette", self.roulette, "0 to 100000")
    }
}
