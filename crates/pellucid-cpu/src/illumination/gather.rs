//! What is made of the light that paths find: its sum, or how it follows from light from far away (G-10).

use glam::Vec3;
use pellucid_optics::{Bands, MOST_COEFFICIENTS, ResolvedLight, Sky, spherical_harmonics};

/// Something that gathers light.
pub trait Gather {
    /// The lights that paths look for.
    fn lights(&self) -> &[ResolvedLight];

    /// Whether anything is to be found by paths that leave the volume.
    fn has_sky(&self) -> bool;

    /// A sky that is bright in some directions, which paths choose for it.
    fn picture(&self) -> Option<&Sky>;

    /// A path leaves in a direction, with such a share of the light from there, of each colour.
    fn leave(&mut self, direction: Vec3, weight: [f32; 3]);

    /// Light arrives from one of the lights.
    fn arrive(&mut self, light: [f32; 3]);
}

/// Irradiance, over pi.
pub struct Irradiance<'a> {
    /// The lights around.
    pub lights: &'a [ResolvedLight],
    /// The sky, if it is not dark.
    pub sky: Option<&'a Sky>,
    /// Of all paths so far, linear RGB.
    pub sum: [f32; 3],
}

impl Gather for Irradiance<'_> {
    fn lights(&self) -> &[ResolvedLight] {
        self.lights
    }

    fn has_sky(&self) -> bool {
        self.sky.is_some()
    }

    fn picture(&self) -> Option<&Sky> {
        self.sky.filter(|sky| matches!(sky, Sky::Image { .. }))
    }

    fn leave(&mut self, direction: Vec3, weight: [f32; 3]) {
        if let Some(sky) = self.sky {
            let light = sky.radiance(direction);
            self.arrive([0, 1, 2].map(|c| weight[c] * light[c]));
        }
    }

    fn arrive(&mut self, light: [f32; 3]) {
        (0..3).for_each(|c| self.sum[c] += light[c]);
    }
}

/// The transfer of light from far away: what of each of its coefficients becomes irradiance over pi (Wyman et al. 2006,
/// eq. 8).
pub struct Transfer {
    /// How many bands light has.
    pub bands: Bands,
    /// Of all paths so far, of each colour.
    pub sum: [[f32; 3]; MOST_COEFFICIENTS],
}

impl Gather for Transfer {
    fn lights(&self) -> &[ResolvedLight] {
        &[]
    }

    fn has_sky(&self) -> bool {
        true
    }

    fn picture(&self) -> Option<&Sky> {
        None
    }

    fn leave(&mut self, direction: Vec3, weight: [f32; 3]) {
        let basis = spherical_harmonics(self.bands, direction);
        for (sum, value) in self.sum.iter_mut().zip(&basis[..self.bands.coefficients()]) {
            (0..3).for_each(|c| sum[c] += weight[c] * value);
        }
    }

    fn arrive(&mut self, _: [f32; 3]) {}
}
