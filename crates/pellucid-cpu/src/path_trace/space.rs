//! Where the medium is: the box of its grid, and what clips leave of it.

use glam::{Affine3A, DVec3, Vec3};
use pellucid_field::Grid;
use pellucid_scene::{Ray, Region};

use crate::lines::Lines;
use crate::solid::{Solid, half_spaces};

/// A straight way through the medium, in index space.
#[derive(Clone, Copy)]
pub struct Flight {
    /// Where it starts.
    pub origin: Vec3,
    /// Index steps per world unit.
    pub direction: Vec3,
    /// Its length in world units.
    pub length: f32,
}

impl Flight {
    /// What is left of a line, and how far from its origin that begins; `None` if nothing is.
    pub fn new(line: &Lines<1>) -> Option<(f64, Self)> {
        let [[t0], [t1]] = line.ends;
        let [origin, direction] = [line.origin, line.direction].map(|v| DVec3::from_array(v.map(|[v]| v)));
        let entry = (origin + direction * t0).as_vec3();
        (t0 < t1).then_some((t0, Self { origin: entry, direction: direction.as_vec3(), length: (t1 - t0) as f32 }))
    }

    /// The position after so many world units.
    #[inline(always)]
    pub fn at(&self, distance: f32) -> Vec3 {
        self.origin + self.direction * distance
    }
}

/// Less of the box's extent, or of a way, is lost in the rounding of positions.
const ROUNDING: f32 = 1e-6;

/// The box and the clips that bound the medium.
pub struct Space<'a> {
    grid: &'a Grid,
    solid: Solid,
    low: Vec3,
    high: Vec3,
    index_from_world: Affine3A,
    world_from_index: Affine3A,
    /// Half-spaces `normal . p >= offset` in index space.
    planes: Vec<(Vec3, f32)>,
}

impl<'a> Space<'a> {
    /// What clips leave of a grid.
    pub fn new(grid: &'a Grid, region: &Region) -> Self {
        let (low, high) = grid.index_bounds();
        let world = grid.world_from_index();
        Self {
            grid,
            solid: Solid::new(grid, region),
            low: low.as_vec3(),
            high: high.as_vec3(),
            index_from_world: grid.index_from_world().as_affine3a(),
            world_from_index: world.as_affine3a(),
            planes: half_spaces(grid, region).map(|(normal, offset)| (normal.as_vec3(), offset as f32)).collect(),
        }
    }

    /// The part of a ray inside, of what is between two distances, and how far from its origin it begins.
    pub fn enter(&self, ray: &Ray, between: [f64; 2]) -> Option<(f64, Flight)> {
        let mut line = self.solid.carry(1, &Lines::from((ray, between)));
        let steady = self.steady(Vec3::from_array(line.direction.map(|[way]| way as f32)));
        for axis in (0..3).filter(|&axis| steady[axis] == 0.0) {
            line.direction[axis] = [0.0];
        }
        self.solid.cut(1, &mut line);
        Flight::new(&line)
    }

    /// The way from a position inside, along a unit vector of the world, to where the medium ends or to
    /// `most` world units.
    #[inline]
    pub fn leave(&self, origin: Vec3, direction: Vec3, most: f32) -> Flight {
        let direction = self.steady(self.index_from_world.transform_vector3(direction));
        let sides = Vec3::select(direction.cmpgt(Vec3::ZERO), self.high, self.low);
        // A position on a side, by rounding beyond it, has no way left there; along a side there is no end.
        let exits = ((sides - origin) / direction).max(Vec3::ZERO);
        let mut length = Vec3::select(direction.cmpeq(Vec3::ZERO), Vec3::INFINITY, exits).min_element().min(most);
        for (normal, offset) in &self.planes {
            let slope = normal.dot(direction);
            if slope < -ROUNDING {
                length = length.min(((normal.dot(origin) - offset) / -slope).max(0.0));
            }
        }
        Flight { origin, direction, length }
    }

    /// A direction without the parts by which, on its longest way in the box, it would lead off a side by rounding
    /// alone: along a side there is no end, least of all for a position on it.
    #[inline]
    fn steady(&self, direction: Vec3) -> Vec3 {
        let ways = (self.high - self.low) / direction.abs();
        let along_sides = (ways * ROUNDING).cmpgt(Vec3::splat(ways.min_element()));
        Vec3::select(along_sides, Vec3::ZERO, direction)
    }

    /// The mean distance of voxels in world units.
    pub fn voxel(&self) -> f32 {
        self.grid.mean_spacing() as f32
    }

    /// A position of the world in index space.
    pub fn index(&self, world: DVec3) -> DVec3 {
        self.grid.index_from_world().transform_point3(world)
    }

    /// Whether an index position lies inside.
    pub fn contains(&self, index: Vec3) -> bool {
        let inside = index.cmpge(self.low).all() && index.cmple(self.high).all();
        inside && self.planes.iter().all(|(normal, offset)| normal.dot(index) >= *offset)
    }

    /// A position in the world, in double precision.
    pub fn world_of(&self, index: Vec3) -> DVec3 {
        self.grid.world_from_index().transform_point3(index.as_dvec3())
    }

    /// A position in the world.
    #[inline]
    pub fn world(&self, index: Vec3) -> Vec3 {
        self.world_from_index.transform_point3(index)
    }
}
