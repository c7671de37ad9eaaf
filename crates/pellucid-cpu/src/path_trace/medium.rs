//! The medium that paths cross: where they collide and how much light gets through.

use glam::{Affine3A, DVec3, Vec3};
use pellucid_field::Grid;
use pellucid_scene::{MajorantGrid, Ray, Region};

use super::extinction::Extinctions;
use super::majorants::Walk;
use super::random::Random;
use super::values::Values;

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
    /// The position after so many world units.
    #[inline(always)]
    pub fn at(&self, distance: f32) -> Vec3 {
        self.origin + self.direction * distance
    }
}

/// Where a flight met the medium.
pub struct Collision {
    /// In world units from the flight's origin.
    pub distance: f32,
    /// The data value there.
    pub value: f32,
}

/// The box and the clips that bound the medium.
pub struct Space<'a> {
    grid: &'a Grid,
    region: &'a Region,
    low: Vec3,
    high: Vec3,
    index_from_world: Affine3A,
    world_from_index: Affine3A,
    /// Half-spaces `normal . p >= offset` in index space.
    planes: Vec<(Vec3, f32)>,
}

impl<'a> Space<'a> {
    /// What clips leave of a grid.
    pub fn new(grid: &'a Grid, region: &'a Region) -> Self {
        let (low, high) = grid.index_bounds();
        let world = grid.world_from_index();
        let plane = |&(normal, offset): &(DVec3, f64)| {
            ((world.matrix3.transpose() * normal).as_vec3(), (offset - normal.dot(world.translation)) as f32)
        };
        Self {
            grid,
            region,
            low: low.as_vec3(),
            high: high.as_vec3(),
            index_from_world: grid.index_from_world().as_affine3a(),
            world_from_index: world.as_affine3a(),
            planes: region.half_spaces().iter().map(plane).collect(),
        }
    }

    /// The part of a ray inside, and how far from its origin it begins.
    pub fn enter(&self, ray: &Ray) -> Option<(f64, Flight)> {
        let (low, high) = self.grid.index_bounds();
        let from_world = self.grid.index_from_world();
        let origin = from_world.transform_point3(ray.origin);
        let direction = from_world.transform_vector3(ray.direction);
        let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let inverse = direction[axis].recip();
            if !inverse.is_finite() {
                if !(low[axis]..=high[axis]).contains(&origin[axis]) {
                    return None;
                }
                continue;
            }
            let (near, far) = ((low[axis] - origin[axis]) * inverse, (high[axis] - origin[axis]) * inverse);
            (t0, t1) = (t0.max(near.min(far)), t1.min(near.max(far)));
        }
        let (t0, t1) = self.region.interval(ray, t0, t1)?;
        let entry = (origin + direction * t0).as_vec3();
        (t0 < t1).then_some((t0, Flight { origin: entry, direction: direction.as_vec3(), length: (t1 - t0) as f32 }))
    }

    /// The way from a position inside, along a unit vector of the world, to where the medium ends or to
    /// `most` world units.
    #[inline]
    pub fn leave(&self, origin: Vec3, direction: Vec3, most: f32) -> Flight {
        let direction = self.index_from_world.transform_vector3(direction);
        let sides = Vec3::select(direction.cmpgt(Vec3::ZERO), self.high, self.low);
        // A position on a side, by rounding beyond it, has no way left there; along a side there is no end.
        let exits = (sides - origin) / direction;
        let mut length = most;
        for axis in 0..3 {
            if direction[axis] != 0.0 {
                length = length.min(exits[axis].max(0.0));
            }
        }
        for (normal, offset) in &self.planes {
            let slope = normal.dot(direction);
            if slope < 0.0 {
                length = length.min(((normal.dot(origin) - offset) / -slope).max(0.0));
            }
        }
        Flight { origin, direction, length }
    }

    /// The mean distance of voxels in world units.
    pub fn voxel(&self) -> f32 {
        self.grid.mean_spacing() as f32
    }

    /// A position of the world in index space.
    pub fn index(&self, world: DVec3) -> DVec3 {
        self.grid.index_from_world().transform_point3(world)
    }

    /// A position in the world.
    #[inline]
    pub fn world(&self, index: Vec3) -> Vec3 {
        self.world_from_index.transform_point3(index)
    }
}

/// A field with an extinction.
pub struct Medium<'a, F> {
    /// The field.
    pub field: F,
    /// Its bounds.
    pub space: Space<'a>,
    /// Extinction by data value.
    pub extinctions: Extinctions,
    /// Bounds of the extinction.
    pub majorants: &'a MajorantGrid,
    /// Factors of the extinction for each colour, 0 to 1, if it has one of its own (K-13).
    pub chroma: Option<[f32; 3]>,
}

/// A collision with a medium as dense as a majorant.
struct Met {
    /// In world units from the flight's origin.
    distance: f32,
    /// The data value there.
    value: f32,
    /// The medium's extinction there, and the majorant, per world unit.
    extinction: f32,
    majorant: f32,
}

/// Below this, a transmittance is left to chance: what gets through is rare and worth as much more.
const FAINT: f32 = 0.05;

impl<F: Values> Medium<'_, F> {
    /// The next collision along a flight, by delta tracking (Woodcock et al. 1965) against the majorant
    /// of each block: distances are those of a medium as dense as the majorant, and a collision there is
    /// one with the medium as often as the medium is as dense.
    ///
    /// Where each colour has its own extinction, the colours decide together, by what they carry (Kutz et al. 2017),
    /// and `carried` becomes what each has after that; their sum stays the same.
    #[inline]
    pub fn collide(
        &self,
        flight: &Flight,
        carried: &mut [f32; 3],
        random: &mut Random,
        looks: &mut u32,
    ) -> Option<Collision> {
        let mut collision = None;
        self.visit(flight, random, looks, |Met { distance, value, extinction, majorant }, random| {
            let number = random.number();
            let is_real = match self.chroma {
                None => number * majorant < extinction,
                Some(chroma) => decide(carried, chroma.map(|factor| (factor * extinction / majorant).min(1.0)), number),
            };
            if is_real {
                collision = Some(Collision { distance, value });
            }
            is_real
        });
        collision
    }

    /// An estimate of the share of each colour that gets through, by ratio tracking (Novak et al. 2014): the
    /// product of the chances that none of the collisions is one with the medium.
    #[inline]
    pub fn transmittance(&self, flight: &Flight, random: &mut Random, looks: &mut u32) -> [f32; 3] {
        let Some(chroma) = self.chroma else {
            let mut through = 1.0f32;
            self.visit(flight, random, looks, |Met { extinction, majorant, .. }, random| {
                through *= 1.0 - (extinction / majorant).min(1.0);
                if through < FAINT {
                    through = if random.number() * FAINT >= through { 0.0 } else { FAINT };
                }
                through == 0.0
            });
            return [through; 3];
        };
        let mut through = [1.0f32; 3];
        self.visit(flight, random, looks, |Met { extinction, majorant, .. }, random| {
            let share = extinction / majorant;
            for (through, factor) in through.iter_mut().zip(chroma) {
                *through *= 1.0 - (factor * share).min(1.0);
            }
            let most = through[0].max(through[1]).max(through[2]);
            if most < FAINT {
                let kept = if random.number() * FAINT >= most { 0.0 } else { FAINT / most };
                through = through.map(|v| v * kept);
            }
            most == 0.0 || through == [0.0; 3]
        });
        through
    }

    /// Goes through the collisions with a medium as dense as the majorants, until one is the last.
    #[inline(always)]
    fn visit(
        &self,
        flight: &Flight,
        random: &mut Random,
        looks: &mut u32,
        mut is_last: impl FnMut(Met, &mut Random) -> bool,
    ) {
        let mut walk = Walk::new(self.majorants, flight.origin, flight.direction, flight.length);
        let (mut distance, mut depth) = (0.0, random.depth());
        loop {
            let (majorant, exit) = walk.block();
            if majorant > 0.0 {
                loop {
                    let next = distance + depth / majorant;
                    if next >= exit {
                        depth -= majorant * (exit - distance).max(0.0);
                        break;
                    }
                    distance = next;
                    *looks += 1;
                    let at = flight.at(distance);
                    let value = self.field.value(at);
                    let extinction = self.extinctions.at(value) * self.field.extinction(at);
                    if is_last(Met { distance, value, extinction, majorant }, random) {
                        return;
                    }
                    depth = random.depth();
                }
            }
            let Some(entry) = walk.advance() else { return };
            distance = entry;
        }
    }
}

/// Whether colours collide that do so with these chances, and what they carry after that.
fn decide(carried: &mut [f32; 3], chances: [f32; 3], number: f32) -> bool {
    let whole: f32 = carried.iter().sum();
    let colliding: f32 = carried.iter().zip(chances).map(|(carried, chance)| carried * chance).sum();
    let chance = colliding / whole;
    let is_real = number < chance;
    for (carried, own) in carried.iter_mut().zip(chances) {
        *carried *= if is_real { own / chance } else { (1.0 - own) / (1.0 - chance) };
    }
    is_real
}
