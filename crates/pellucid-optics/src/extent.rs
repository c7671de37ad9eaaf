//! What shines around the middle of a light.

use std::f32::consts::PI;

use glam::Vec3;

/// What shines around the middle of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// Nothing: the middle alone.
    Point,
    /// Directions around that of a directional light.
    Disc {
        /// Squared sine of the angle from the middle to the edge.
        sine_squared: f32,
    },
    /// A ball around a position.
    Ball {
        /// In world units.
        radius: f32,
    },
    /// A flat face around a position.
    Face(Face),
}

/// A parallelogram that shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    edges: [Vec3; 2],
    /// Unit vector out of the side that shines.
    normal: Vec3,
    area: f32,
    two_sided: bool,
}

impl Face {
    /// A face with these edges; `None` if they span none.
    pub(crate) fn new(edges: [Vec3; 2], two_sided: bool) -> Option<Self> {
        let across = edges[0].cross(edges[1]);
        let area = across.length();
        let normal = across.try_normalize().filter(|_| area.is_finite())?;
        Some(Self { edges, normal, area, two_sided })
    }

    /// Its edges, in world units.
    pub fn edges(&self) -> [Vec3; 2] {
        self.edges
    }

    /// The unit vector out of the side that shines.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// In square world units.
    pub fn area(&self) -> f32 {
        self.area
    }

    /// Whether it shines to both sides.
    pub fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    /// How much of the face is seen by light that goes along `to_light` to it: the cosine at the face.
    pub(crate) fn cosine(&self, to_light: Vec3) -> f32 {
        let cosine = -self.normal.dot(to_light);
        if self.two_sided { cosine.abs() } else { cosine.max(0.0) }
    }

    /// Radiance per radiance of a light at the face's middle, which is `way` off: both bring as much there,
    /// straight ahead.
    pub(crate) fn brightness(&self, way: Vec3) -> f32 {
        PI * way.length_squared() / self.area
    }

    /// Whether a place in its plane, from its middle, is on it.
    pub(crate) fn contains(&self, place: Vec3) -> bool {
        let [a, b] = self.edges;
        let within = |share: f32| share.abs() <= 0.5 * self.area;
        within(place.cross(b).dot(self.normal)) && within(a.cross(place).dot(self.normal))
    }
}
