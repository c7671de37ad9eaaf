//! The ways that shadow rays go.

use glam::DVec3;
use pellucid_optics::{LightShape, ResolvedLight};

use crate::field::Bounds;
use crate::lanes::*;
use crate::medium::Span;
use crate::packet::{Rays, inverse};
use crate::prepare::Prepared;

/// The ways from samples to lights.
pub struct ToLights {
    lights: Vec<Bearing>,
    bounds: Bounds,
    /// World length of an index vector, as columns of a matrix.
    world_from_index: [[f32; 3]; 3],
    /// In world units.
    step: f32,
}

/// Where a light is, in index space.
enum Bearing {
    /// A step towards it.
    Everywhere([f32; 3]),
    /// Its position.
    Somewhere([f32; 3]),
}

impl ToLights {
    /// For steps of so many world units.
    pub fn new(prepared: &Prepared, step: f64) -> Self {
        let grid = prepared.grid();
        let index_from_world = grid.index_from_world();
        let aim = |light: &ResolvedLight| match light.shape() {
            LightShape::Directional { to_light } => {
                let step = index_from_world.transform_vector3(to_light.as_dvec3() * step);
                Bearing::Everywhere(step.as_vec3().to_array())
            }
            LightShape::Local { position, .. } => {
                let position: DVec3 = index_from_world.transform_point3(position.as_dvec3());
                Bearing::Somewhere(position.as_vec3().to_array())
            }
        };
        Self {
            lights: prepared.stage.lights.iter().map(aim).collect(),
            bounds: Bounds::new(grid, &prepared.region),
            world_from_index: grid.world_from_index().matrix3.as_mat3().to_cols_array_2d(),
            step: step as f32,
        }
    }

    /// Rays from index positions to a light, or to where the volume ends; `skip` steps of them are left out.
    #[inline(always)]
    pub fn rays<S: Lanes>(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>, skip: f32) -> Rays<S> {
        let (direction, most) = self.aim(s, light, index);
        let length = self.bounds.exit(s, index, &direction, &inverse(s, &direction)).min(most) - skip;
        let origin = xyz!(I => direction[I].mul_add(splat(s, skip), index[I]));
        Rays::from(s, origin, direction, lanes.select(length, splat(s, 0.0)))
    }

    /// Where the volume lies on the ways from index positions, inside it or not, to a light; `skip` steps of them are
    /// left out.
    #[inline(always)]
    pub fn span<S: Lanes>(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>, skip: f32) -> Span<S> {
        let (direction, most) = self.aim(s, light, index);
        let [enter, exit] = self.bounds.span(s, index, &direction, &inverse(s, &direction));
        let (enter, exit) = (enter.max(splat(s, skip)), exit.min(most));
        let (met, zero, far) = (lanes & enter.simd_lt(exit), splat(s, 0.0), splat(s, f32::INFINITY));
        let start = met.select(enter, zero);
        let origin = xyz!(I => direction[I].mul_add(start, index[I]));
        let rays = Rays::from(s, origin, direction, met.select(exit - enter, zero));
        Span { rays, ends: [met.select(enter, far), met.select(exit, -far)], beam: None }
    }

    /// A step from index positions towards a light, and how many there are to it.
    #[inline(always)]
    fn aim<S: Lanes>(&self, s: S, light: usize, index: &Vec3<S>) -> (Vec3<S>, F32<S>) {
        match &self.lights[light] {
            Bearing::Everywhere(step) => (xyz!(I => splat(s, step[I])), splat(s, f32::INFINITY)),
            Bearing::Somewhere(position) => {
                let way = xyz!(I => splat(s, position[I]) - index[I]);
                let [x, y, z] = self.world_from_index;
                let world = xyz!(I => way[0].mul_add(splat(s, x[I]), way[1].mul_add(splat(s, y[I]), way[2] * z[I])));
                let steps = (dot::<S>(world, world).sqrt() * (1.0 / self.step)).max(splat(s, 1e-6));
                (xyz!(I => way[I] / steps), steps)
            }
        }
    }
}
