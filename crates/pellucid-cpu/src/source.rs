//! Where the rays of a picture come from: an eye, or a light.

use glam::{DVec2, DVec3};
use pellucid_plan::half_angle::LightFrame;
use pellucid_scene::{Ray, Viewpoint};

use crate::lines::Lines;

/// A vector that changes linearly over the picture: at its middle, and per unit to the right and up.
struct Linear {
    middle: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Linear {
    #[inline(always)]
    fn at(&self, axis: usize, a: f64, b: f64) -> f64 {
        self.middle[axis] + self.right[axis] * a + self.up[axis] * b
    }
}

/// Makes the rays of a picture.
pub struct Source {
    /// Whether they leave one point.
    perspective: bool,
    /// How far to the right and up the picture's corner (0, 0) is, at distance 1 or in world units.
    corner: DVec2,
    /// How far it is from there to the next pixel on the right, and below.
    pixel: DVec2,
    origin: Linear,
    /// Directions of any length.
    direction: Linear,
}

impl Source {
    /// The eye of a view.
    pub fn of_eye(view: &Viewpoint) -> Self {
        let pixel = 2.0 * view.half_height / view.height as f64;
        let middle = DVec2::new(view.width as f64, view.height as f64) / 2.0 - view.shift;
        let (corner, pixel) = (DVec2::new(-middle.x * pixel, middle.y * pixel), DVec2::new(pixel, -pixel));
        Self::new([view.eye, view.forward, view.right, view.up], view.perspective, [corner, pixel])
    }

    /// A light, whose picture has texels.
    pub fn of_light(frame: &LightFrame) -> Self {
        let from = [frame.origin, frame.forward, frame.right, frame.up];
        Self::new(from, !frame.is_directional, [frame.low, frame.texel])
    }

    fn new([position, forward, right, up]: [DVec3; 4], perspective: bool, [corner, pixel]: [DVec2; 2]) -> Self {
        // Rays of a perspective leave one point, others one direction.
        let same = |middle| Linear { middle, right: DVec3::ZERO, up: DVec3::ZERO };
        let differing = |middle| Linear { middle, right, up };
        let (origin, direction) =
            if perspective { (same(position), differing(forward)) } else { (differing(position), same(forward)) };
        Self { perspective, corner, pixel, origin, direction }
    }

    /// The rays through `n` picture positions, in pixels from the top left.
    #[inline(always)]
    pub fn lines<const N: usize>(&self, n: usize, x: &[f64; N], y: &[f64; N]) -> Lines<N> {
        let (mut a, mut b, mut unit) = ([0.0; N], [0.0; N], [1.0; N]);
        for lane in 0..n {
            a[lane] = x[lane] * self.pixel.x + self.corner.x;
            b[lane] = y[lane] * self.pixel.y + self.corner.y;
        }
        if self.perspective {
            for lane in 0..n {
                unit[lane] = 1.0 / (1.0 + a[lane] * a[lane] + b[lane] * b[lane]).sqrt();
            }
        }
        let mut lines = Lines::UNDIRECTED;
        for axis in 0..3 {
            for lane in 0..n {
                lines.origin[axis][lane] = self.origin.at(axis, a[lane], b[lane]);
                lines.direction[axis][lane] = self.direction.at(axis, a[lane], b[lane]) * unit[lane];
            }
        }
        lines
    }

    /// The ray through a picture position.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let Lines { origin, direction, .. } = self.lines(1, &[x], &[y]);
        let [origin, direction] = [origin, direction].map(|v| DVec3::from_array(v.map(|[v]| v)));
        Ray { origin, direction }
    }
}
