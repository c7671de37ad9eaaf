//! Light from far away.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::bands::{Bands, MOST_COEFFICIENTS};
use super::basis::spherical_harmonics_f64;
use super::rotation::Rotation;
use super::sky::project;
use super::zonal::{Window, Zonal};
use crate::{Extent, LightShape, ResolvedLight, Sky};

/// Light from far away, all around: the linear RGB coefficients of its radiance, those of the sky and of directional
/// lights (Wyman et al. 2006, eq. 7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonics {
    bands: Bands,
    /// 0 beyond the bands.
    coefficients: [[f64; 3]; MOST_COEFFICIENTS],
}

impl Harmonics {
    /// No light.
    pub const fn dark(bands: Bands) -> Self {
        Self { bands, coefficients: [[0.0; 3]; MOST_COEFFICIENTS] }
    }

    /// The light of a sky: exact, a picture's for even texels.
    pub fn of_sky(bands: Bands, sky: &Sky) -> Self {
        let mut coefficients = project(sky);
        coefficients[bands.coefficients()..].fill([0.0; 3]);
        Self { bands, coefficients }
    }

    /// More light, from one direction, a unit vector that points away from the scene: so much that it brings this
    /// irradiance to a surface that faces it.
    pub fn add(&mut self, to_light: Vec3, irradiance: [f32; 3]) {
        self.add_cap(to_light, 0.0, irradiance.map(f64::from));
    }

    /// More light, that of a directional light: one of intensity 1 brings pi. Returns whether it was added, which a
    /// light with a place in the scene is not.
    #[must_use = "lights with a place in the scene are not added"]
    pub fn add_light(&mut self, light: &ResolvedLight) -> bool {
        let LightShape::Directional { to_light } = light.shape() else { return false };
        let sine_squared = if let Extent::Disc { sine_squared } = light.extent() { sine_squared } else { 0.0 };
        self.add_cap(to_light, sine_squared, light.radiance().map(|v| PI * f64::from(v)));
        true
    }

    fn add_cap(&mut self, to_light: Vec3, sine_squared: f32, irradiance: [f64; 3]) {
        let axis = to_light.as_dvec3().normalize_or_zero();
        let shares = Zonal::cap(sine_squared.into()).around(axis, self.bands);
        for (coefficient, share) in self.coefficients.iter_mut().zip(shares) {
            *coefficient = std::array::from_fn(|channel| coefficient[channel] + share * irradiance[channel]);
        }
    }

    /// How many bands it has.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Linear RGB, as many as the bands have.
    pub fn coefficients(&self) -> &[[f64; 3]] {
        &self.coefficients[..self.bands.coefficients()]
    }

    /// The same light, turned with everything in it.
    pub fn rotated(&self, rotation: &Rotation) -> Self {
        Self { coefficients: rotation.rotate(&self.coefficients), ..*self }
    }

    /// The same light without waves around what is sharp in it.
    pub fn windowed(&self, window: Window) -> Self {
        self.convolved(Zonal::window(window, self.bands))
    }

    /// Linear RGB radiance from a direction, a unit vector that points away from the scene; of a few bands it may be
    /// negative.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let basis = spherical_harmonics_f64(self.bands, direction);
        let sum = |channel: usize| self.coefficients.iter().zip(basis).map(|(rgb, value)| rgb[channel] * value).sum();
        std::array::from_fn(sum)
    }

    /// Linear RGB irradiance on an unoccluded surface with that normal, a unit vector; not negative.
    pub fn irradiance(&self, normal: DVec3) -> [f64; 3] {
        self.convolved(Zonal::CLAMPED_COSINE).radiance(normal).map(|v| v.max(0.0))
    }

    fn convolved(&self, zonal: Zonal) -> Self {
        let factors = zonal.factors();
        let coefficients = std::array::from_fn(|i| self.coefficients[i].map(|v| v * factors[i.isqrt()]));
        Self { coefficients, ..*self }
    }
}
