//! The part of a ray that meets the field.

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::{Ray, Region};

/// A ray over the interval on which there is a field, in world units, with its index-space twin.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The ray in the world.
    pub ray: Ray,
    /// Distance at which the ray enters the field; not before the eye.
    pub entry: f64,
    /// Distance at which it leaves.
    pub exit: f64,
    index_origin: DVec3,
    index_direction: DVec3,
}

impl Span {
    /// Intersects a ray with the grid's box and the clip region; `None` if it misses.
    ///
    /// The box test happens in index space, where the box is axis-aligned whatever the affine, and
    /// distances stay in world units because the direction is transformed without normalising.
    pub fn new(ray: &Ray, grid: &Grid, region: &Region) -> Option<Self> {
        let index_from_world = grid.index_from_world();
        let index_origin = index_from_world.transform_point3(ray.origin);
        let index_direction = index_from_world.transform_vector3(ray.direction);
        let (low, high) = grid.index_bounds();
        let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (index_origin[axis], index_direction[axis]);
            if d == 0.0 {
                if o < low[axis] || o > high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
            t0 = t0.max(a.min(b));
            t1 = t1.min(a.max(b));
        }
        let (entry, exit) = region.interval(ray, t0, t1)?;
        Some(Self { ray: *ray, entry, exit, index_origin, index_direction })
    }

    /// The continuous voxel index at distance t.
    #[inline(always)]
    pub fn index_at(&self, t: f64) -> DVec3 {
        self.index_origin + self.index_direction * t
    }

    /// The index-space direction per world unit.
    pub fn index_direction(&self) -> DVec3 {
        self.index_direction
    }

    /// Length of the interval in world units.
    pub fn length(&self) -> f64 {
        self.exit - self.entry
    }
}
