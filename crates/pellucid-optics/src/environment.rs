//! Light from far away, all around.

use std::f32::consts::PI;

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::checked;
use crate::{Color, ColorSpace, OpticsError, luminance, turned};

/// Light from far away, all around. Up is the world's +z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Environment {
    /// None (default).
    #[default]
    Dark,
    /// The same from everywhere.
    Constant {
        /// sRGB-encoded.
        color: Color,
        /// Factor of the colour; default 1, not negative.
        #[serde(default = "one")]
        #[schemars(range(min = 0.0))]
        intensity: f32,
    },
    /// A sky: from the colour below to the colour above, linear in the height of a direction.
    Gradient {
        /// From straight above, sRGB-encoded.
        top: Color,
        /// From straight below, sRGB-encoded.
        bottom: Color,
        /// Factor of both colours; default 1, not negative.
        #[serde(default = "one")]
        #[schemars(range(min = 0.0))]
        intensity: f32,
    },
}

fn one() -> f32 {
    1.0
}

impl Environment {
    /// Checks its intensity.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] if it is negative or not finite.
    pub fn validate(&self) -> Result<(), OpticsError> {
        match *self {
            Self::Dark => Ok(()),
            Self::Constant { intensity, .. } | Self::Gradient { intensity, .. } => {
                checked("environment intensity", f64::from(intensity), 0.0..=f64::from(f32::MAX), "0 or more")
            }
        }
    }

    /// The environment in linear light; `None` if it is dark.
    pub fn resolve(&self) -> Option<Sky> {
        let linear = |color: Color, intensity: f32| color.to_linear(ColorSpace::Srgb).map(|v| v * intensity);
        let (top, bottom) = match *self {
            Self::Dark => return None,
            Self::Constant { color, intensity } => (linear(color, intensity), linear(color, intensity)),
            Self::Gradient { top, bottom, intensity } => (linear(top, intensity), linear(bottom, intensity)),
        };
        let brightness = luminance(top) + luminance(bottom);
        (brightness > 0.0).then(|| Sky { top, bottom, slope: (luminance(top) - luminance(bottom)) / brightness })
    }
}

/// An environment in linear light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    top: [f32; 3],
    bottom: [f32; 3],
    /// How much brighter than the mean it is straight above, as a share of the mean.
    slope: f32,
}

impl Sky {
    /// Linear RGB radiance from a direction, a unit vector that points away from the scene.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> [f32; 3] {
        let t = 0.5 + 0.5 * direction.z;
        std::array::from_fn(|channel| self.bottom[channel] + (self.top[channel] - self.bottom[channel]) * t)
    }

    /// How much brighter than the mean it is straight above, as a share of the mean.
    pub fn slope(&self) -> f32 {
        self.slope
    }

    /// Density per steradian of [`sample`](Self::sample): proportional to the luminance.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        (1.0 + self.slope * direction.z) / (4.0 * PI)
    }

    /// A direction that light comes from, from two numbers in 0..1.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        // The root of z + slope z^2 / 2 = 2u - 1 + slope / 2, in a form that is exact without slope.
        let (s, t) = (self.slope, 2.0 * u[0] - 1.0);
        let z = (2.0 * t + s) / (1.0 + (1.0 + s * (2.0 * t + s)).max(0.0).sqrt());
        turned(Vec3::Z, z.clamp(-1.0, 1.0), u[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_as_frequent_as_they_are_bright() {
        for [top, bottom] in [[0xffffff, 0xffffff], [0x80a0ff, 0x202020], [0x000000, 0xffffff]] {
            let environment =
                Environment::Gradient { top: Color::hex(top), bottom: Color::hex(bottom), intensity: 2.0 };
            let sky = environment.resolve().unwrap();
            const COUNT: usize = 100_000;
            let (mut flux, mut below) = (0.0, 0);
            for k in 0..COUNT {
                let direction = sky.sample([(k as f32 + 0.5) / COUNT as f32, 0.25]);
                // Luminance over density is the same everywhere: the flux.
                flux += f64::from(luminance(sky.radiance(direction)) / sky.pdf(direction)) / COUNT as f64;
                below += usize::from(direction.z < 0.5);
            }
            let [top, bottom] =
                [top, bottom].map(|code| f64::from(luminance(Color::hex(code).to_linear(ColorSpace::Srgb))));
            let mean = top + bottom;
            assert!((flux / (4.0 * std::f64::consts::PI * mean) - 1.0).abs() < 1e-4, "{flux}");
            let slope = (top - bottom) / (top + bottom);
            let expected = 0.75 - slope * (1.0 - 0.25) / 4.0;
            assert!((below as f64 / COUNT as f64 - expected).abs() < 1e-4, "{below}, not {expected}");
        }
        assert_eq!(Environment::Dark.resolve(), None);
        assert_eq!(Environment::Constant { color: Color::BLACK, intensity: 1.0 }.resolve(), None);
        assert!(Environment::Constant { color: Color::BLACK, intensity: -1.0 }.validate().is_err());
    }
}
