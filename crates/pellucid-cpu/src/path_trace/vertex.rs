//! What happens to light where a path collides with the medium.

use glam::Vec3;
use pellucid_optics::{Incident, Phase, PhaseNormalization, Reflection, Scatterer};

use super::random::Random;

/// How light leaves a collision.
pub enum Vertex<'a> {
    /// Scattered by the medium.
    Medium {
        /// By which angles.
        phase: &'a Phase,
        /// What weights of direct light are relative to.
        normalization: PhaseNormalization,
        /// Albedo and anisotropy.
        scatterer: Scatterer,
        /// The way the path goes, away from the eye.
        forward: Vec3,
    },
    /// Reflected by a surface in it (K-11).
    Surface(Reflection),
}

impl Vertex<'_> {
    /// The share of the light from a direction that goes to the eye, per steradian; paths go against the
    /// light, and a phase function is the same both ways.
    #[inline]
    pub fn eval(&self, direction: Vec3) -> [f32; 3] {
        match self {
            Self::Medium { phase, scatterer, forward, .. } => {
                scale(phase.eval(scatterer.g, forward.dot(direction)), scatterer.albedo)
            }
            Self::Surface(surface) => surface.eval(direction),
        }
    }

    /// The density per steradian of [`sample`](Self::sample).
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            Self::Medium { phase, scatterer, forward, .. } => phase.pdf(scatterer.g, forward.dot(direction)),
            Self::Surface(surface) => surface.pdf(direction),
        }
    }

    /// Where the path goes on.
    #[inline]
    pub fn sample(&self, random: &mut Random) -> Vec3 {
        match self {
            Self::Medium { phase, scatterer, forward, .. } => {
                phase.sample_direction(scatterer.g, *forward, random.pair())
            }
            Self::Surface(surface) => surface.sample(random.number(), random.pair()),
        }
    }

    /// What goes to the eye of a light of no extent.
    #[inline]
    pub fn light(&self, light: Incident) -> [f32; 3] {
        match self {
            Self::Medium { phase, normalization, scatterer, forward } => {
                let weight = phase.weight(*normalization, scatterer.g, forward.dot(light.to_light));
                scale(scale(weight, scatterer.albedo), light.radiance)
            }
            Self::Surface(surface) => surface.light(light),
        }
    }
}

/// The product, colour by colour.
#[inline(always)]
pub fn scale(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}
