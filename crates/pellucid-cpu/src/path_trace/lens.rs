//! Rays from the eye, or from a lens around it.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use pellucid_scene::{PathTrace, Ray, Viewpoint};

use super::random::Random;
use crate::source::Source;

/// A camera with a thin lens.
pub struct Lens {
    source: Source,
    view: Viewpoint,
    aperture: f64,
    focus: f64,
}

impl Lens {
    /// The camera of a view. Paths are spread over each pixel anyway: where frames to be averaged have
    /// their rays is nothing to them.
    pub fn new(view: &Viewpoint, settings: &PathTrace) -> Self {
        let focus = settings.focus.unwrap_or_else(|| (view.target - view.eye).dot(view.forward));
        let view = Viewpoint { shift: DVec2::ZERO, ..*view };
        Self { source: Source::of_eye(&view), view, aperture: settings.aperture, focus }
    }

    /// The ray through the middle of a pixel, and of the lens.
    pub fn middle(&self, x: usize, y: usize) -> Ray {
        self.source.ray(x as f64 + 0.5, y as f64 + 0.5)
    }

    /// A ray through a random point of a pixel, and of the lens.
    pub fn ray(&self, x: usize, y: usize, random: &mut Random) -> Ray {
        let [right, down] = random.pair().map(f64::from);
        let ray = self.source.ray(x as f64 + right, y as f64 + down);
        if self.aperture == 0.0 {
            return ray;
        }
        let [u, turn] = random.pair().map(f64::from);
        let (sin, cos) = (TAU * turn).sin_cos();
        let across: DVec3 = (self.view.right * cos + self.view.up * sin) * (self.aperture * u.sqrt());
        let target = ray.origin + ray.direction * (self.focus / ray.direction.dot(self.view.forward));
        let origin = ray.origin + across;
        Ray { origin, direction: (target - origin).normalize() }
    }
}
