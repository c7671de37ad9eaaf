//! Rays between places of a surface of any isovalue (G-02, G-03).

use pellucid_field::{Filter, Gradient, Sampler};
use pellucid_scene::SurfaceNormals;

use super::level_grids::LevelGrids;
use crate::RenderError;
use crate::field::{Any, Bounds, Field};
use crate::integrator::Counter;
use crate::lanes::*;
use crate::light::normals;
use crate::medium::{Crossed, crosses, each_piece, root};
use crate::packet::{Rays, inverse};
use crate::prepare::Prepared;
use crate::walk::{Segment, Verdict, Visit};

/// A field whose isosurfaces rays meet.
pub struct SurfaceRays<'a, S: Lanes> {
    s: S,
    field: Any<'a, S>,
    /// Its gradients are what normals are made of.
    slopes: Any<'a, S>,
    bounds: Bounds,
    grids: Option<&'a LevelGrids>,
    is_exact: bool,
    /// World units that are counted as one along rays.
    step: f32,
    /// Columns of the matrix that makes index vectors of such.
    index_from_steps: [[f32; 3]; 3],
}

/// Where rays meet a surface.
pub struct MetSurface<S: Lanes> {
    /// Index positions.
    pub index: Vec3<S>,
    /// Unit normals of the world, towards lower values.
    pub normal: Vec3<S>,
    /// Rays that meet one.
    pub lanes: Mask<S>,
}

/// What the field is at places.
pub struct Spot<S: Lanes> {
    /// Its values; no number where it is absent or clipped.
    pub value: F32<S>,
    /// Unit normals of the world, towards lower values; zero where there is no slope.
    pub normal: Vec3<S>,
}

impl<'a, S: Lanes> SurfaceRays<'a, S> {
    /// Of a volume, with such normals.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn new(
        s: S,
        prepared: &'a Prepared,
        normals: SurfaceNormals,
        grids: Option<&'a LevelGrids>,
    ) -> Result<Self, RenderError> {
        let (stage, grid, sampler) = (prepared.stage, prepared.grid(), prepared.sampler()?);
        let (values, component) = &prepared.values;
        let slopes = match normals {
            SurfaceNormals::Derivative => prepared.any_sloping(sampler.clone(), Gradient::BSpline),
            // Differences of smoothed values are smoothed differences.
            SurfaceNormals::Differences => {
                let smooth = Sampler::new(values, *component, Filter::BSpline { prefilter: false })?;
                prepared.any_sloping(smooth, Gradient::Central)
            }
            SurfaceNormals::Data => prepared.any(sampler.clone()),
        };
        let steps = grid.index_from_world().matrix3 * stage.step;
        Ok(Self {
            s,
            field: prepared.any(sampler),
            slopes,
            bounds: Bounds::new(grid, &prepared.region),
            grids,
            is_exact: stage.finds_every_surface(prepared.volume),
            step: stage.step as f32,
            index_from_steps: steps.as_mat3().to_cols_array_2d(),
        })
    }

    /// Index vectors of such of the world.
    #[inline(always)]
    pub fn index_vector(&self, world: &Vec3<S>) -> Vec3<S> {
        let way = self.along(world);
        xyz!(I => way[I] * (1.0 / self.step))
    }

    /// A step in directions of the world, as index vectors.
    #[inline(always)]
    fn along(&self, direction: &Vec3<S>) -> Vec3<S> {
        let (s, [x, y, z]) = (self.s, &self.index_from_steps);
        xyz!(I => {
            direction[0].mul_add(splat(s, x[I]), direction[1].mul_add(splat(s, y[I]), direction[2] * z[I]))
        })
    }

    /// What the field is at index positions.
    #[inline(always)]
    pub fn look(&self, index: &Vec3<S>, lanes: Mask<S>) -> Spot<S> {
        let s = self.s;
        let inside = lanes & self.bounds.contain(s, index);
        let value = inside.select(self.field.values(s, *index, inside), splat(s, f32::NAN));
        Spot { value, normal: normals(s, self.slopes.gradients(s, *index, inside)).0 }
    }

    /// Where rays from index positions in unit directions of the world first meet the surface, within so many world units.
    #[inline(always)]
    pub fn meet(
        &self,
        level: f32,
        from: &Vec3<S>,
        direction: &Vec3<S>,
        reach: F32<S>,
        lanes: Mask<S>,
    ) -> MetSurface<S> {
        let s = self.s;
        let rays = self.rays(from, direction, reach, lanes);
        let crossed = self.first(level, &rays);
        let distance = root(s, &self.field, &rays, &crossed, splat(s, level), crossed.lanes);
        let index = rays.at(distance);
        let normal = normals(s, self.slopes.gradients(s, index, crossed.lanes)).0;
        MetSurface { index, normal, lanes: crossed.lanes }
    }

    /// Whether such rays meet the surface at all.
    #[inline(always)]
    pub fn are_held_back(
        &self,
        level: f32,
        from: &Vec3<S>,
        direction: &Vec3<S>,
        reach: F32<S>,
        lanes: Mask<S>,
    ) -> Mask<S> {
        self.first(level, &self.rays(from, direction, reach, lanes)).lanes
    }

    /// Rays through what there is of the field.
    #[inline(always)]
    fn rays(&self, from: &Vec3<S>, direction: &Vec3<S>, reach: F32<S>, lanes: Mask<S>) -> Rays<S> {
        let (s, way) = (self.s, self.along(direction));
        let [enter, exit] = self.bounds.span(s, from, &way, &inverse(s, &way));
        let exit = exit.min(reach * (1.0 / self.step));
        let there = lanes & enter.simd_lt(exit);
        let enter = there.select(enter, splat(s, 0.0));
        let origin = xyz!(I => way[I].mul_add(enter, from[I]));
        Rays::from(s, origin, way, there.select(exit - enter, splat(s, 0.0)))
    }

    /// The first pieces on which rays cross the surface.
    #[inline(always)]
    fn first(&self, level: f32, rays: &Rays<S>) -> Crossed<S> {
        let (s, zero) = (self.s, splat(self.s, 0.0));
        let crossed = Crossed { distance: [zero; 2], value: [zero; 2], lanes: all(s, false) };
        let mut first = First { s, level: splat(s, level), crossed };
        let skip = self.grids.and_then(
            #[inline(always)]
            |grids| grids.at(level),
        );
        let range = if self.is_exact { Some([level; 2]) } else { None };
        each_piece(s, &self.field, rays, (skip, range), &mut Counter::new(s), &mut first);
        first.crossed
    }
}

/// The search for the first surface on every ray.
struct First<S: Lanes> {
    s: S,
    level: F32<S>,
    crossed: Crossed<S>,
}

impl<S: Lanes> Visit<S> for First<S> {
    #[inline(always)]
    fn visit(&mut self, segment: &Segment<S>, _: &mut Counter<S>) -> Verdict<S> {
        let done = segment.lanes & crosses::<S>(segment.value, self.level);
        let crossed = &mut self.crossed;
        for end in 0..2 {
            crossed.distance[end] = done.select(segment.distance[end], crossed.distance[end]);
            crossed.value[end] = done.select(segment.value[end], crossed.value[end]);
        }
        crossed.lanes |= done;
        Verdict { done, wait: all(self.s, false) }
    }
}
