//! Lights that have a size, as paths of light meet them.
//!
//! A light with a size brings what its middle would bring, spread evenly over the directions in which
//! it is seen: one of intensity 1 brings pi to a surface that faces it, however large it is. For a ball
//! that is exact at any distance (a ball of even radiance lights a surface like its centre does).

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use crate::{Extent, Incident, LightShape, ResolvedLight};

/// Light from one place of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// The light, as bright as a light of no extent would be that stands for all of this one.
    pub incident: Incident,
    /// World units to the place; infinite for directional lights.
    pub distance: f32,
    /// Density per steradian with which the direction was chosen; infinite if there is but one.
    pub density: f32,
}

/// A light as it is seen in some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSeen {
    /// Linear RGB radiance.
    pub radiance: [f32; 3],
    /// World units; infinite for directional lights.
    pub distance: f32,
    /// Density per steradian with which [`ResolvedLight::sample`] chooses the direction.
    pub density: f32,
}

/// Lights whose sine is smaller than this, squared, are points: single precision has no directions between.
const SMALLEST: f32 = 1e-12;

impl ResolvedLight {
    /// Light from a random place of the light at a point of the world, from two numbers in 0..1, if nothing is
    /// in between. The mean over all numbers is the light that comes from it.
    #[inline]
    pub fn sample(&self, at: Vec3, u: [f32; 2]) -> LightSample {
        let (axis, strength) = self.towards(at);
        if let (Extent::Face(face), LightShape::Local { position, .. }) = (self.extent, self.shape) {
            let way = position - at + face.edges()[0] * (u[0] - 0.5) + face.edges()[1] * (u[1] - 0.5);
            // On the face itself there is no direction.
            let squared = way.length_squared().max(f32::MIN_POSITIVE);
            let to_light = way.normalize_or_zero();
            let seen = face.cosine(to_light) * face.area() / squared;
            return LightSample {
                incident: self.arriving(to_light, strength * face.brightness(position - at) * seen / PI),
                distance: squared.sqrt(),
                density: seen.recip(),
            };
        }
        let Some(cap) = self.cap(at, axis) else {
            let distance = self.distance(at);
            return LightSample { incident: self.incident(at), distance, density: f32::INFINITY };
        };
        let to_light = cap.sample(u);
        LightSample {
            // Its radiance over the density is 2 / (1 + cosine of the edge).
            incident: self.arriving(to_light, strength * 2.0 / (2.0 - cap.height)),
            distance: self.surface(at, to_light),
            density: cap.density(),
        }
    }

    /// The light where a ray from a point of the world in some direction, a unit vector, meets it; `None` for
    /// lights of no extent and rays beside it.
    #[inline]
    pub fn seen(&self, at: Vec3, direction: Vec3) -> Option<LightSeen> {
        let (axis, strength) = self.towards(at);
        if let (Extent::Face(face), LightShape::Local { position, .. }) = (self.extent, self.shape) {
            let cosine = face.cosine(direction);
            let distance = (position - at).dot(face.normal()) / direction.dot(face.normal());
            if !(cosine > 0.0 && distance > 0.0 && face.contains(at + direction * distance - position)) {
                return None;
            }
            let radiance = self.arriving(direction, strength * face.brightness(position - at)).radiance;
            let density = distance * distance / (face.area() * cosine);
            return Some(LightSeen { radiance, distance, density });
        }
        let cap = self.cap(at, axis).filter(|cap| cap.contains(direction))?;
        let radiance = self.arriving(direction, strength / cap.sine_squared).radiance;
        Some(LightSeen { radiance, distance: self.surface(at, direction), density: cap.density() })
    }

    /// The directions in which a disc or a ball is seen; `None` if they are but one. Within a ball they are
    /// those of its nearer half, as on it.
    fn cap(&self, at: Vec3, axis: Vec3) -> Option<Cap> {
        let sine_squared = match (self.extent, self.shape) {
            (Extent::Disc { sine_squared }, _) => sine_squared,
            (Extent::Ball { radius }, LightShape::Local { position, .. }) => {
                (radius * radius / position.distance_squared(at)).min(1.0)
            }
            _ => return None,
        };
        (sine_squared >= SMALLEST).then(|| Cap {
            axis,
            sine_squared,
            height: sine_squared / (1.0 + (1.0 - sine_squared).sqrt()),
        })
    }

    /// World units to the middle.
    fn distance(&self, at: Vec3) -> f32 {
        match self.shape {
            LightShape::Directional { .. } => f32::INFINITY,
            LightShape::Local { position, .. } => position.distance(at),
        }
    }

    /// World units to the near side of a ball, in a direction in which it is seen.
    fn surface(&self, at: Vec3, direction: Vec3) -> f32 {
        match (self.extent, self.shape) {
            (Extent::Ball { radius }, LightShape::Local { position, .. }) => {
                let way = position - at;
                let beside = way.cross(direction).length_squared();
                (way.dot(direction) - (radius * radius - beside).max(0.0).sqrt()).max(0.0)
            }
            _ => f32::INFINITY,
        }
    }
}

/// Directions around a middle one.
struct Cap {
    axis: Vec3,
    /// Of the angle from the middle to the edge.
    sine_squared: f32,
    /// One less its cosine, kept as it is since small angles have cosines that round to 1.
    height: f32,
}

impl Cap {
    fn density(&self) -> f32 {
        1.0 / (TAU * self.height)
    }

    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let height = u[0] * self.height;
        let (side, up) = self.axis.any_orthonormal_pair();
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let across = (height * (2.0 - height)).sqrt();
        (self.axis * (1.0 - height) + (side * cos + up * sin) * across).normalize()
    }

    fn contains(&self, direction: Vec3) -> bool {
        self.axis.dot(direction) > 0.0 && self.axis.cross(direction).length_squared() <= self.sine_squared
    }
}
