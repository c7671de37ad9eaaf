//! The field at one position, in single precision.

use glam::Vec3;
use pellucid_field::{ComponentView, Linear, Reconstruct, Sampler, Voxel};
use pellucid_optics::{Displacer, Variation};

/// A reconstructed field.
pub trait Values: Sync {
    /// The data value at a position in index space inside the grid; NaN where it is absent.
    fn value(&self, index: Vec3) -> f32;

    /// The factor of the extinction there.
    #[inline(always)]
    fn extinction(&self, _: Vec3) -> f32 {
        1.0
    }

    /// A colour there.
    #[inline(always)]
    fn color(&self, _: Vec3, color: [f32; 3]) -> [f32; 3] {
        color
    }
}

impl Values for Box<dyn Values + '_> {
    fn value(&self, index: Vec3) -> f32 {
        (**self).value(index)
    }

    fn extinction(&self, index: Vec3) -> f32 {
        (**self).extinction(index)
    }

    fn color(&self, index: Vec3, color: [f32; 3]) -> [f32; 3] {
        (**self).color(index, color)
    }
}

/// Trilinear values of voxels of a type.
pub struct ScalarTrilinear<'a, T> {
    data: &'a [T],
    last: Vec3,
    /// The last cell along each axis.
    cells: [usize; 3],
    /// Voxels from one row, and from one slice, to the next.
    stride: [usize; 2],
    scale: f32,
    offset: f32,
    exact: Linear<'a, T>,
}

impl<'a, T: Voxel> ScalarTrilinear<'a, T> {
    /// The field of a view; `None` if it has several components, or an axis of one voxel.
    pub fn new(view: ComponentView<'a, T>) -> Option<Self> {
        let (dims, stride, map) = (view.dims(), view.stride(), view.value_map());
        (stride[0] == 1 && dims.into_iter().all(|n| n > 1)).then(|| Self {
            data: view.data(),
            last: Vec3::from_array(dims.map(|n| (n - 1) as f32)),
            cells: dims.map(|n| n - 2),
            stride: [stride[1], stride[2]],
            scale: map.scale as f32,
            offset: map.offset as f32,
            exact: Linear(view),
        })
    }
}

impl<T: Voxel> Values for ScalarTrilinear<'_, T> {
    #[inline(always)]
    fn value(&self, index: Vec3) -> f32 {
        let p = index.max(Vec3::ZERO).min(self.last);
        // By way of i32: processors convert to signed numbers in one instruction.
        let cell: [usize; 3] = std::array::from_fn(|axis| (p[axis] as i32 as usize).min(self.cells[axis]));
        let [ux, uy, uz] = std::array::from_fn(|axis| p[axis] - cell[axis] as i32 as f32);
        let row = |dy: usize, dz: usize| {
            let start = cell[0] + (cell[1] + dy) * self.stride[0] + (cell[2] + dz) * self.stride[1];
            let pair = &self.data[start..start + 2];
            lerp(ux, pair[0].to_f32(), pair[1].to_f32())
        };
        let value = lerp(uz, lerp(uy, row(0, 0), row(1, 0)), lerp(uy, row(0, 1), row(1, 1)));
        if !T::TYPE.is_integer() && !value.is_finite() {
            // Beside holes the rules are more than arithmetic.
            return self.exact.value(p.as_dvec3()) as f32;
        }
        value * self.scale + self.offset
    }
}

#[inline(always)]
fn lerp(u: f32, a: f32, b: f32) -> f32 {
    a + u * (b - a)
}

/// Any field.
pub struct ScalarAny<'a> {
    /// The field.
    pub sampler: Sampler<'a>,
    /// The lowest and the highest position of its grid.
    pub bounds: [Vec3; 2],
}

impl Values for ScalarAny<'_> {
    fn value(&self, index: Vec3) -> f32 {
        let [low, high] = self.bounds;
        self.sampler.value(index.max(low).min(high).as_dvec3()) as f32
    }
}

/// Any field under noise.
pub struct Perturbed<'a> {
    /// The field.
    pub field: ScalarAny<'a>,
    /// What moves it.
    pub displacer: Option<&'a Displacer>,
    /// What varies its optics.
    pub variation: Option<&'a Variation>,
}

impl Values for Perturbed<'_> {
    fn value(&self, index: Vec3) -> f32 {
        let Some(displacer) = self.displacer else { return self.field.value(index) };
        self.field.value(Vec3::from_array(displacer.source(index.to_array(), || self.field.value(index))))
    }

    fn extinction(&self, index: Vec3) -> f32 {
        self.variation.map_or(1.0, |variation| variation.extinction(variation.at(index.to_array())))
    }

    fn color(&self, index: Vec3, color: [f32; 3]) -> [f32; 3] {
        self.variation.map_or(color, |variation| variation.color(variation.at(index.to_array()), color))
    }
}
