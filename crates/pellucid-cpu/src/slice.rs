//! A plane through the volume, at any orientation.

use glam::DVec3;
use pellucid_field::Grid;

use crate::field::Field;
use crate::integrator::{Integrator, Tally, Traced, one_by_one};
use crate::lanes::*;
use crate::medium::{OneGrid, ValueOptics};
use crate::packet::Packet;
use crate::projection::show;

/// The field on a plane, coloured at full opacity. (A slab of some thickness is a projection over
/// a span between two planes.)
pub struct SlicePlane<'a, S, F> {
    medium: OneGrid<'a, S, F, ValueOptics<'a>>,
    /// The plane in index space: `index_normal . p = offset`.
    index_normal: [f32; 3],
    offset: f32,
    normal: [f32; 3],
}

impl<'a, S: Lanes, F: Field<S>> SlicePlane<'a, S, F> {
    /// The plane through a world position across a unit normal.
    pub fn new(medium: OneGrid<'a, S, F, ValueOptics<'a>>, grid: &Grid, point: DVec3, normal: DVec3) -> Self {
        let index_normal = (grid.world_from_index().matrix3.transpose() * normal).normalize();
        let offset = index_normal.dot(grid.index_from_world().transform_point3(point));
        Self {
            medium,
            index_normal: index_normal.as_vec3().to_array(),
            offset: offset as f32,
            normal: normal.as_vec3().to_array(),
        }
    }
}

impl<S: Lanes, F: Field<S>> Integrator for SlicePlane<'_, S, F> {
    fn width(&self) -> usize {
        width::<S>()
    }

    fn trace(&self, wave: &[Packet], traced: &mut [Traced], tally: &mut Tally) {
        /// Rounding must not cut a plane out of the border of the volume, in steps.
        const TOLERANCE: f32 = 1e-4;
        let s = self.medium.s;
        one_by_one(
            s,
            wave,
            traced,
            tally,
            #[inline(always)]
            |_, rays, traced, counter| {
                let normal = xyz!(I => splat(s, self.index_normal[I]));
                let along = dot::<S>(rays.direction, normal);
                let distance = (splat(s, self.offset) - dot::<S>(rays.origin, normal)) / along;
                // Also false for the NaN and infinity of a ray along the plane.
                let after = distance.simd_ge(splat(s, -TOLERANCE));
                let met = rays.has(splat(s, 0.0)) & after & distance.simd_le(rays.length() + TOLERANCE);
                counter.sample(met);
                let distance = met.select(distance, splat(s, 0.0));
                let value = self.medium.values(rays.at(distance), met);
                let value = met.select(value, splat(s, f32::NAN));
                show(&self.medium, value, distance, traced, counter);
                traced.set_surface(s, value.is_finite(), distance, xyz!(I => splat(s, self.normal[I])));
            },
        );
    }
}
