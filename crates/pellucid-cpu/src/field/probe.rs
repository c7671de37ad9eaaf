//! The field at one position, in f64.

use glam::{DMat3, DVec3};
use pellucid_field::{Gradient, Grid, Reconstruct, index_gradient};
use pellucid_scene::Region;

/// A reconstructed field inside its clip region; what is clipped is absent.
pub struct Probe<'a, R> {
    field: R,
    region: &'a Region,
    grid: &'a Grid,
    gradient: Gradient,
    /// Index steps to the taps of gradients.
    spacing: DVec3,
    world_from_index_gradient: DMat3,
}

impl<'a, R: Reconstruct> Probe<'a, R> {
    /// A probe of a field on a grid.
    pub fn new(field: R, grid: &'a Grid, region: &'a Region, gradient: Gradient) -> Self {
        let world_from_index_gradient = grid.world_from_index_gradient();
        Self { field, region, grid, gradient, spacing: DVec3::ONE, world_from_index_gradient }
    }

    /// The same with central differences over so many index steps.
    pub fn with_spacing(self, spacing: DVec3) -> Self {
        Self { gradient: Gradient::Central, spacing, ..self }
    }

    /// The data value at an index position, moved into the grid's box; NaN where absent.
    pub fn value(&self, index: DVec3) -> f64 {
        self.field.value(self.inside(index))
    }

    /// The gradient in data units per world unit, one-sided beside whatever is absent or clipped. The
    /// value in the middle is taken as exactly as those around it: against one rounded to f32 a flat
    /// field would have a slope, and a direction.
    pub fn gradient(&self, index: DVec3) -> DVec3 {
        let index = self.inside(index);
        let center = self.field.value(index);
        let gradient = if self.is_whole_around(index) {
            self.field.gradient(self.gradient, index, center)
        } else {
            let world_from_index = self.grid.world_from_index();
            let step = self.spacing;
            index_gradient(self.gradient, index / step, center, |p| {
                let p = p * step;
                if self.region.contains(world_from_index.transform_point3(p)) { self.field.value(p) } else { f64::NAN }
            }) / step
        };
        self.world_from_index_gradient * gradient
    }

    /// Whether no clip comes near what the field's own gradient reads. A B-spline's is of the 4x4x4
    /// voxels, where they are all there: a cut elsewhere does not turn it into one of samples.
    fn is_whole_around(&self, index: DVec3) -> bool {
        if self.region.is_everything() || self.gradient != Gradient::BSpline {
            return self.region.is_everything();
        }
        // The region is convex: with the corners it has all voxels between them.
        let (world_from_index, cell) = (self.grid.world_from_index(), index.floor());
        (0..8).all(|corner| {
            let offset = DVec3::from_array([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 2.0 }));
            self.region.contains(world_from_index.transform_point3(cell + offset))
        })
    }

    /// The field without its region.
    pub fn field(&self) -> &R {
        &self.field
    }

    /// Turns a gradient per index step into one per world unit.
    pub fn world_from_index_gradient(&self) -> DMat3 {
        self.world_from_index_gradient
    }

    /// Positions come from rays in f32, which may leave the box by a rounding.
    fn inside(&self, index: DVec3) -> DVec3 {
        let (low, high) = self.grid.index_bounds();
        index.max(low).min(high)
    }
}
