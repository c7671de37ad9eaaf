//! A volume that paths collide with.

use glam::{DVec3, Vec3};
use pellucid_optics::{Material, Reflection, Scattering, Table};

use super::medium::Medium;
use super::random::Random;
use super::values::Values;
use super::vertex::Vertex;
use crate::field::{Moved, Probe};

/// A volume, and what is made of collisions with it.
pub struct PathLayer<'a, F> {
    /// The medium.
    pub medium: Medium<'a, F>,
    /// For normals.
    pub probe: Probe<'a, Moved<'a>>,
    /// Colours by data value.
    pub table: &'a Table,
    /// How the medium scatters.
    pub scattering: &'a Scattering,
    /// How surfaces in it reflect, if there are any.
    pub material: Option<&'a Material>,
}

impl<F: Values> PathLayer<'_, F> {
    /// The normal at a position of the world, towards lower values; zero where there is no surface.
    pub fn normal(&self, world: DVec3) -> [f32; 3] {
        if !self.scattering.has_surfaces() {
            return [0.0; 3];
        }
        let at = self.medium.space.index(world);
        (-self.probe.gradient(at).normalize_or_zero()).as_vec3().to_array()
    }

    /// The surface at a collision, as often as the collision is one with a surface.
    pub fn surface(
        &self,
        at: Vec3,
        value: f32,
        color: [f32; 3],
        to_eye: Vec3,
        random: &mut Random,
    ) -> Option<Vertex<'_>> {
        let material = self.material.filter(|_| self.scattering.has_surfaces())?;
        let gradient = self.probe.gradient(at.as_dvec3());
        let share = self.scattering.surface_at(f64::from(value), gradient.length() as f32);
        if random.number() >= share {
            return None;
        }
        let normal = gradient.try_normalize().map(|normal| -normal.as_vec3())?;
        Reflection::new(material, color, normal, to_eye).map(Vertex::Surface)
    }

    /// Where a surface is lit: in front of the matter that belongs to it, which is `depth` mean free paths deep.
    pub fn in_front(&self, at: Vec3, value: f32, normal: Vec3, depth: f32) -> Vec3 {
        if depth == 0.0 {
            return at;
        }
        // No surface is told more finely than in voxels.
        let distance = (depth / (self.medium.extinctions.at(value) * self.medium.field.extinction(at)))
            .min(self.medium.space.voxel());
        let way = self.medium.space.leave(at, normal, distance);
        way.at(way.length)
    }
}
