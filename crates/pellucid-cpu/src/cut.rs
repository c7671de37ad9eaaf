//! Cut faces: where clips, and the box of the data, cut through matter.
//!
//! The field is one-sided there, and within solid matter its gradient is noise. What lies behind a face that a
//! ray enters by is part of the cut: it has the face's normal, and deeper on that of the data, by weights that
//! fall off ("impregnation", Eq. 15.6, C-28; Weiskopf, Engel, Ertl 2003).

use glam::DMat3;

use crate::field::Bounds;
use crate::lanes::*;

/// The faces by which rays can enter.
pub struct Cuts {
    bounds: Bounds,
    /// Turns a gradient per index step into one per world unit.
    world_from_index_gradient: [[f32; 3]; 3],
    /// How much data values would rise over the first voxel, were there nothing outside.
    rise: f32,
}

/// The faces that the rays of a packet came in by.
pub struct Cut<S: Lanes> {
    /// Unit normals in index space, inwards, and their offsets there; infinitely deep where there is none.
    normal: Vec3<S>,
    offset: F32<S>,
    /// Gradients of the rise, in the world.
    gradient: Vec3<S>,
}

impl Cuts {
    /// The faces around a field; a rise of its values by this much a voxel is as steep as they are.
    pub fn new(bounds: Bounds, world_from_index_gradient: DMat3, rise: f32) -> Self {
        let world_from_index_gradient = world_from_index_gradient.as_mat3().to_cols_array_2d();
        Self { bounds, world_from_index_gradient, rise }
    }

    /// Those by which rays in index directions came to their entries.
    #[inline(always)]
    pub fn met<S: Lanes>(&self, s: S, entry: &Vec3<S>, direction: &Vec3<S>) -> Cut<S> {
        let (normal, offset) = self.bounds.entered(s, entry, direction);
        let steepest = self.world_gradients::<S>(&normal);
        Cut { normal, offset, gradient: xyz!(I => steepest[I] * self.rise) }
    }

    /// Gradients per world unit, of those per index step.
    #[inline(always)]
    pub fn world_gradients<S: Lanes>(&self, gradient: &Vec3<S>) -> Vec3<S> {
        let [x, y, z] = &self.world_from_index_gradient;
        xyz!(I => gradient[0] * x[I] + gradient[1] * y[I] + gradient[2] * z[I])
    }
}

impl<S: Lanes> Cut<S> {
    /// Gradients at index positions, of what is cut.
    #[inline(always)]
    pub fn gradients(&self, s: S, index: &Vec3<S>, gradient: Vec3<S>) -> Vec3<S> {
        /// Voxels beyond which a face is not felt.
        const DEEPEST: f32 = 8.0;
        let depth = dot::<S>(self.normal, *index) - self.offset;
        let near = depth.simd_lt(splat(s, DEEPEST));
        if !near.any_true() {
            return gradient;
        }
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let deep = depth.max(one);
        let weight = one / (deep * deep);
        let own = (depth - 1.0).max(zero).min(one);
        xyz!(I => near.select(gradient[I].mul_add(own, self.gradient[I] * weight), gradient[I]))
    }
}
