//! Light from far away, all around.

mod day;
mod map;

use std::f32::consts::PI;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{Quat, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::checked;
use crate::{Color, ColorSpace, OpticsError, luminance, turned};

pub use map::SkyMap;

/// Light from far away, all around. Up is the world's +z.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// A picture of everything around.
    Image(SkyImage),
}

/// A picture of everything around, equirectangular: straight above in its first row, the world's +y in its
/// middle column and +x right of that. Its texels are light, as bright as they say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkyImage {
    /// Where it comes from.
    pub source: SkySource,
    /// By how many degrees it is turned around the world's +z, from +x towards +y. Default 0.
    #[serde(default)]
    pub rotation: f64,
    /// Factor of its light; default 1, not negative.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0))]
    pub intensity: f32,
    /// What is in its file, once that is read.
    #[serde(skip)]
    pub map: Option<Arc<SkyMap>>,
}

/// Where a picture of everything around comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum SkySource {
    /// An EXR or PNG file; a relative path starts at the scene's folder.
    File(PathBuf),
    /// A built-in blue sky with a sun.
    Day,
}

fn one() -> f32 {
    1.0
}

impl Environment {
    /// Checks its numbers.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] if it, or a rotation, is out of range.
    pub fn validate(&self) -> Result<(), OpticsError> {
        let intensity = match self {
            Self::Dark => return Ok(()),
            Self::Constant { intensity, .. } | Self::Gradient { intensity, .. } => *intensity,
            Self::Image(image) => {
                checked("environment rotation", image.rotation, -1e6..=1e6, "degrees")?;
                image.intensity
            }
        };
        checked("environment intensity", f64::from(intensity), 0.0..=f64::from(f32::MAX), "0 or more")
    }

    /// The environment in linear light; `None` if it is dark.
    ///
    /// # Errors
    /// [`OpticsError::SkyMap`] for a picture whose file has not been read.
    pub fn resolve(&self) -> Result<Option<Sky>, OpticsError> {
        let linear = |color: Color, intensity: f32| color.to_linear(ColorSpace::Srgb).map(|v| v * intensity);
        let (top, bottom) = match self {
            Self::Dark => return Ok(None),
            Self::Constant { color, intensity } => (linear(*color, *intensity), linear(*color, *intensity)),
            Self::Gradient { top, bottom, intensity } => (linear(*top, *intensity), linear(*bottom, *intensity)),
            Self::Image(image) => return image.resolve(),
        };
        let brightness = luminance(top) + luminance(bottom);
        let slope = (luminance(top) - luminance(bottom)) / brightness;
        Ok((brightness > 0.0).then_some(Sky::Gradient { top, bottom, slope }))
    }
}

impl SkyImage {
    fn resolve(&self) -> Result<Option<Sky>, OpticsError> {
        let map = match (&self.map, &self.source) {
            (Some(map), _) => map.clone(),
            (None, SkySource::Day) => Arc::new(day::day()?),
            (None, SkySource::File(path)) => {
                return Err(OpticsError::SkyMap { problem: format!("{} has not been read", path.display()) });
            }
        };
        let lit = !map.is_dark() && self.intensity > 0.0;
        let turn = Quat::from_rotation_z(self.rotation.to_radians() as f32);
        Ok(lit.then_some(Sky::Image { map, turn, intensity: self.intensity }))
    }
}

/// An environment in linear light.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// Linear in the height of a direction.
    Gradient {
        /// Linear RGB radiance from straight above.
        top: [f32; 3],
        /// From straight below.
        bottom: [f32; 3],
        /// How much brighter than the mean it is straight above, as a share of the mean.
        slope: f32,
    },
    /// A picture, turned.
    Image {
        /// The picture.
        map: Arc<SkyMap>,
        /// From its directions to the world's.
        turn: Quat,
        /// Factor of its light.
        intensity: f32,
    },
}

impl Sky {
    /// Linear RGB radiance from a direction, a unit vector that points away from the scene.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> [f32; 3] {
        match self {
            Self::Gradient { top, bottom, .. } => {
                let t = 0.5 + 0.5 * direction.z;
                std::array::from_fn(|channel| bottom[channel] + (top[channel] - bottom[channel]) * t)
            }
            Self::Image { map, turn, intensity } => map.radiance(turn.inverse() * direction).map(|v| v * intensity),
        }
    }

    /// Density per steradian of [`sample`](Self::sample): proportional to the luminance.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            Self::Gradient { slope, .. } => (1.0 + slope * direction.z) / (4.0 * PI),
            Self::Image { map, turn, .. } => map.pdf(map.radiance(turn.inverse() * direction)),
        }
    }

    /// A direction that light comes from, from two numbers in 0..1.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        match self {
            Self::Gradient { slope: s, .. } => {
                // The root of z + slope z^2 / 2 = 2u - 1 + slope / 2, in a form that is exact without slope.
                let t = 2.0 * u[0] - 1.0;
                let z = (2.0 * t + s) / (1.0 + (1.0 + s * (2.0 * t + s)).max(0.0).sqrt());
                turned(Vec3::Z, z.clamp(-1.0, 1.0), u[1])
            }
            Self::Image { map, turn, .. } => *turn * map.sample(u),
        }
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
            let sky = environment.resolve().unwrap().unwrap();
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
        assert_eq!(Environment::Dark.resolve(), Ok(None));
        assert_eq!(Environment::Constant { color: Color::BLACK, intensity: 1.0 }.resolve(), Ok(None));
        assert!(Environment::Constant { color: Color::BLACK, intensity: -1.0 }.validate().is_err());
    }
}
