//! Detail that the voxels do not have: noise that displaces what is drawn and varies how it looks (K-21 to
//! K-24, MOD-07 to MOD-11).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::OpticsError;
use crate::error::checked;

/// Noise on a volume. Off by default; then nothing of a picture changes, and nothing takes longer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Perturbation {
    /// Number of the noise: the same seed is the same noise everywhere. Default 0.
    pub seed: u32,
    /// Noise that moves what is drawn.
    pub displacement: Displacement,
    /// Noise that varies how it looks.
    pub optics: PropertyNoise,
}

/// Where a sample looks for its value: at its own place, moved by three channels of noise along the axes
/// of the volume (K-24, MOD-08).
///
/// What is drawn never leaves the volume's box, and none is cut off there: towards a face, the shift across it
/// fades to nothing over the largest distance it can have. Gradients are central differences of the
/// displaced field over one texel of the finest octave, 1/16 to 1 voxel, whatever `quality.gradient` is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Displacement {
    /// Shift at a noise of 1 as a share of the volume's longest side, 0 to 1. Default 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub amplitude: f32,
    /// Noises that add up, at most 8; left out, frequencies 2, 4, 8 and 16 with weights 1, 1/2, 1/4 and 1/8. No
    /// shift along an axis is larger than the amplitude times the sum of all weights.
    #[schemars(length(max = 8))]
    pub octaves: Vec<Octave>,
    /// Two data values, in either order: where the volume has the first, nothing moves; where it has the second,
    /// everything moves by the whole amplitude; between them it rises smoothly (fur, MOD-10). Left out,
    /// everything moves.
    pub between: Option<[f32; 2]>,
}

/// How noise varies optical properties after classification (K-23). At 0 a property is as it is; at 1, a noise of
/// -1 to 1 takes it to nothing or to twice as much. Composited samples, light on its way to them and paths
/// are varied; projections and isosurfaces show the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PropertyNoise {
    /// Noises that add up, at most 8; sums beyond -1 and 1 are cut off. Left out, one of frequency 2.
    #[schemars(length(max = 8))]
    pub octaves: Vec<Octave>,
    /// How much the extinction varies, 0 to 1. Default 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opacity: f32,
    /// How much red, green and blue of what samples reflect vary, each by itself, 0 to 1; none becomes more
    /// than white. Default 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub color: f32,
    /// How much the indirect attenuation of red, green and blue varies, each by itself (`scattering.transport`),
    /// 0 to 1: iridescence. Default 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub transport: f32,
}

/// One noise of a sum (K-21).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Octave {
    /// Periods over the volume's longest side, 1/16 to 1024. A period has 32 random numbers.
    #[schemars(range(min = 0.0625, max = 1024.0))]
    pub frequency: f32,
    /// Factor, -16 to 16. Default 1.
    #[serde(default = "one")]
    #[schemars(range(min = -16.0, max = 16.0))]
    pub weight: f32,
    /// Where in the noise the volume's first voxel lies, in periods: to be moved on from frame to frame
    /// (K-22, MOD-11). Whole periods change nothing. Left out, at its
    /// beginning.
    #[serde(default)]
    pub offset: [f64; 3],
}

/// The most noises in a sum.
const MOST_OCTAVES: usize = 8;

fn one() -> f32 {
    1.0
}

impl Octave {
    /// An octave that is not moved.
    pub fn new(frequency: f32, weight: f32) -> Self {
        Self { frequency, weight, offset: [0.0; 3] }
    }

    fn validate(&self) -> Result<(), (&'static str, OpticsError)> {
        let at = |key, checked: Result<(), OpticsError>| checked.map_err(|error| (key, error));
        at("frequency", checked("frequency", self.frequency.into(), 0.0625..=1024.0, "1/16 to 1024"))?;
        at("weight", checked("weight", self.weight.into(), -16.0..=16.0, "-16 to 16"))?;
        self.offset
            .iter()
            .try_for_each(|&offset| at("offset", checked("offset", offset, -1e9..=1e9, "numbers from -1e9 to 1e9")))
    }
}

impl Default for Displacement {
    fn default() -> Self {
        let octave = |k| Octave::new(f32::from(2u8 << k), 1.0 / f32::from(1u8 << k));
        Self { amplitude: 0.0, octaves: (0..4).map(octave).collect(), between: None }
    }
}

impl Default for PropertyNoise {
    fn default() -> Self {
        Self { octaves: vec![Octave::new(2.0, 1.0)], opacity: 0.0, color: 0.0, transport: 0.0 }
    }
}

impl Perturbation {
    /// The same over data values that are less by `origin`.
    pub fn counted_from(mut self, origin: f64) -> Self {
        let between = &mut self.displacement.between;
        *between = between.map(|ends| ends.map(|value| (f64::from(value) - origin) as f32));
        self
    }

    /// Whether anything is displaced.
    pub fn displaces(&self) -> bool {
        self.displacement.amplitude > 0.0 && self.displacement.octaves.iter().any(|octave| octave.weight != 0.0)
    }

    /// Whether any property varies.
    pub fn varies(&self) -> bool {
        let PropertyNoise { octaves, opacity, color, transport } = &self.optics;
        [opacity, color, transport].iter().any(|weight| **weight > 0.0) && octaves.iter().any(|o| o.weight != 0.0)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The key of the first setting that cannot be used, and why.
    pub fn validate(&self) -> Result<(), (String, OpticsError)> {
        let share = |list: &str, name: &'static str, found: f32| {
            checked(name, found.into(), 0.0..=1.0, "0 to 1").map_err(|error| (format!("{list}.{name}"), error))
        };
        let Displacement { amplitude, octaves, between } = &self.displacement;
        share("displacement", "amplitude", *amplitude)?;
        sum("displacement", octaves)?;
        if let Some([none, full]) = between
            && !(none.is_finite() && full.is_finite() && none != full)
        {
            let found = [f64::from(*none), f64::from(*full)];
            let error = OpticsError::Interval { name: "between", found, expected: "other than" };
            return Err(("displacement.between".to_owned(), error));
        }
        let PropertyNoise { octaves, opacity, color, transport } = &self.optics;
        sum("optics", octaves)?;
        share("optics", "opacity", *opacity)?;
        share("optics", "color", *color)?;
        share("optics", "transport", *transport)
    }
}

fn sum(list: &str, octaves: &[Octave]) -> Result<(), (String, OpticsError)> {
    checked("number of octaves", octaves.len() as f64, 0.0..=MOST_OCTAVES as f64, "at most 8")
        .map_err(|error| (format!("{list}.octaves"), error))?;
    octaves.iter().enumerate().try_for_each(|(k, octave)| {
        octave.validate().map_err(|(key, error)| (format!("{list}.octaves[{k}].{key}"), error))
    })
}
