//! What is left of lights on their way to samples (6.1).

mod across;
mod cache;
mod media;
mod surfaces;
mod to_lights;
mod volume;

use crate::lanes::*;

pub use across::{Across, Turn};
pub use cache::LightCache;
pub use media::Media;
pub use surfaces::{Product, Surfaces};
pub use to_lights::ToLights;
pub use volume::{LightVolume, LightVolumes};

/// Light of which so little is left is not followed to its end: a tenth of an 8-bit step.
const DARK: f32 = 1.0 / 2560.0;

/// Something that holds light back.
pub trait Shadow<S: Lanes>: Sync {
    /// The share of a light, by its number, that reaches index positions, 0 to 1.
    fn transmittance(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>) -> F32<S>;
}
