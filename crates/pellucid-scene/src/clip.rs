//! Clipping: which part of space holds a field at all.

use glam::{DMat3, DVec3};
use pellucid_field::Grid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Ray;
use crate::check::{Checked, direction, finite, require};

/// A clip object. What it removes is absent: samples, gradients, isosurfaces and light all see
/// the same field. What several clips leave is their intersection.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum Clip {
    /// Keeps the side of a plane that the normal points to.
    Plane {
        /// A world position on the plane.
        point: [f64; 3],
        /// Direction towards the side that stays; any length.
        normal: [f64; 3],
    },
    /// Keeps the inside of a world-axis-aligned box.
    Box {
        /// Lowest corner.
        min: [f64; 3],
        /// Highest corner.
        max: [f64; 3],
    },
}

impl Clip {
    pub(crate) fn check(&self, path: &str) -> Checked {
        match *self {
            Self::Plane { point, normal } => {
                finite(path, "plane.point", point)?;
                direction(path, "plane.normal", normal)
            }
            Self::Box { min, max } => {
                finite(path, "box.min", min)?;
                finite(path, "box.max", max)?;
                let ordered = (0..3).all(|axis| min[axis] < max[axis]);
                require(ordered, path, "box.max", format!("{max:?}"), &format!("more than min {min:?} on every axis"))
            }
        }
    }
}

/// A convex part of space: the intersection of half-spaces `normal . p >= offset`. No half-space
/// means all of space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    half_spaces: Vec<(DVec3, f64)>,
}

impl Region {
    /// The region that a list of clips leaves.
    pub fn from_clips(clips: &[Clip]) -> Self {
        let mut region = Self::default();
        for clip in clips {
            match *clip {
                Clip::Plane { point, normal } => {
                    region.keep(DVec3::from_array(normal).normalize(), DVec3::from_array(point));
                }
                Clip::Box { min, max } => {
                    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                        region.keep(axis, DVec3::from_array(min));
                        region.keep(-axis, DVec3::from_array(max));
                    }
                }
            }
        }
        region
    }

    /// Also keeps only the side of the plane through `point` that the unit `normal` points to.
    pub fn keep(&mut self, normal: DVec3, point: DVec3) {
        self.half_spaces.push((normal, normal.dot(point)));
    }

    /// Whether nothing is clipped.
    pub fn is_everything(&self) -> bool {
        self.half_spaces.is_empty()
    }

    /// The half-spaces: unit normal and offset.
    pub fn half_spaces(&self) -> &[(DVec3, f64)] {
        &self.half_spaces
    }

    /// Whether a world point stays, boundary included.
    pub fn contains(&self, point: DVec3) -> bool {
        self.half_spaces.iter().all(|(normal, offset)| normal.dot(point) >= *offset)
    }

    /// The corners of what the region leaves of a grid's box, some of them more than once; none if it leaves
    /// nothing with a volume.
    pub fn corners_in(&self, grid: &Grid) -> Vec<DVec3> {
        let (low, high) = grid.index_bounds();
        let [low, high] = [low, high].map(|index| grid.world_from_index().transform_point3(index));
        let center = grid.center();
        let mut inside = self.clone();
        for axis in 0..3 {
            // A plane of constant index has the world gradient of that index as its normal.
            let normal = grid.world_from_index_gradient().col(axis).normalize();
            inside.keep(normal, low);
            inside.keep(-normal, high);
        }
        // Counted from the middle, offsets are no larger than the box, and rounding is small beside it.
        let planes: Vec<_> = inside.half_spaces.iter().map(|(n, offset)| (*n, offset - n.dot(center))).collect();
        let room = 1e-9 * (high - low).length();
        let mut corners = Vec::new();
        for (i, (a, p)) in planes.iter().enumerate() {
            for (j, (b, q)) in planes.iter().enumerate().skip(i + 1) {
                for (c, r) in &planes[j + 1..] {
                    let meeting = DMat3::from_cols(*a, *b, *c).transpose();
                    if meeting.determinant().abs() < 1e-12 {
                        continue;
                    }
                    let corner = meeting.inverse() * DVec3::new(*p, *q, *r);
                    if planes.iter().all(|(normal, offset)| normal.dot(corner) >= offset - room) {
                        corners.push(center + corner);
                    }
                }
            }
        }
        corners
    }

    /// Whether a box in index space lies wholly outside, by one of the planes alone.
    pub(crate) fn excludes(&self, grid: &Grid, bounds: (DVec3, DVec3)) -> bool {
        if self.is_everything() {
            return false;
        }
        let corners = grid.world_corners_of(bounds);
        let outside = |(normal, offset): &(DVec3, f64)| corners.iter().all(|corner| normal.dot(*corner) < *offset);
        self.half_spaces.iter().any(outside)
    }

    /// The part of `[t0, t1]` on which the ray is inside; `None` if there is none.
    pub fn interval(&self, ray: &Ray, mut t0: f64, mut t1: f64) -> Option<(f64, f64)> {
        for (normal, offset) in &self.half_spaces {
            let slope = normal.dot(ray.direction);
            let above = normal.dot(ray.origin) - offset;
            if slope.abs() < 1e-300 {
                if above < 0.0 {
                    return None;
                }
            } else if slope > 0.0 {
                t0 = t0.max(-above / slope);
            } else {
                t1 = t1.min(-above / slope);
            }
        }
        (t0 < t1).then_some((t0, t1))
    }
}
