//! Terrain as a volume: a slab over a map of heights (K-28, K-29).

use glam::{DVec2, DVec3};
use pellucid_field::closed_form::{About, ScalarField};
use pellucid_field::{FieldError, VoxelType};

/// Heights at the points of a rectangle, x fastest; samples lie **at** the points, and the borders hold beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    pub(crate) dims: [usize; 2],
    pub(crate) heights: Vec<f32>,
}

impl HeightMap {
    /// Heights of `dims` points.
    ///
    /// # Errors
    /// [`FieldError::Length`] if they are not as many as that, [`FieldError::Parameter`] if there are none or one is
    /// not finite.
    pub fn new(dims: [usize; 2], heights: Vec<f32>) -> Result<Self, FieldError> {
        let expected = dims[0].saturating_mul(dims[1]);
        if heights.len() != expected {
            return Err(FieldError::Length { found: heights.len(), expected });
        }
        if expected == 0 {
            return Err(FieldError::Parameter { name: "points of a height map", found: 0.0, expected: "at least 1" });
        }
        match heights.iter().find(|height| !height.is_finite()) {
            Some(height) => {
                Err(FieldError::Parameter { name: "height", found: f64::from(*height), expected: "finite" })
            }
            None => Ok(Self { dims, heights }),
        }
    }

    /// Points per axis.
    pub fn dims(&self) -> [usize; 2] {
        self.dims
    }

    /// The next level: half the points, each the mean of four (of two or one at an odd border).
    pub fn halved(&self) -> Self {
        let dims = self.dims.map(|n| n.div_ceil(2));
        let mean = |i: usize| {
            let (x, y) = (2 * (i % dims[0]), 2 * (i / dims[0]));
            let at = |dx: usize, dy: usize| {
                let (x, y) = ((x + dx).min(self.dims[0] - 1), (y + dy).min(self.dims[1] - 1));
                self.heights[x + y * self.dims[0]]
            };
            (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0
        };
        Self { dims, heights: (0..dims[0] * dims[1]).map(mean).collect() }
    }

    /// The level whose texels are at least as large as a footprint of so many texels, by the binary logarithm
    /// of that (K-29); this one for footprints up to 1.
    pub fn for_footprint(&self, texels: f64) -> Self {
        let levels = texels.max(1.0).log2().round().min(32.0) as u32;
        (0..levels).fold(self.clone(), |map, _| if map.dims == [1, 1] { map } else { map.halved() })
    }

    /// The height at a place, 0 to 1 across each side of the map, bilinear between points.
    pub fn at(&self, place: DVec2) -> f64 {
        // Texels cover the map evenly, whatever their number: levels lie over each other.
        let at = |axis: usize| {
            let n = self.dims[axis];
            let x = (place[axis] * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
            let cell = (x as usize).min(n.saturating_sub(2));
            (cell, (cell + 1).min(n - 1), x - cell as f64)
        };
        let ((x0, x1, u), (y0, y1, v)) = (at(0), at(1));
        let height = |x: usize, y: usize| f64::from(self.heights[x + y * self.dims[0]]);
        let row = |y: usize| height(x0, y) + u * (height(x1, y) - height(x0, y));
        row(y0) + v * (row(y1) - row(y0))
    }
}

/// On which side of the faces of a slab it fades out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ramp {
    /// Inside: between the faces alone there is anything.
    #[default]
    Inside,
    /// Outside: between the faces all of it is there.
    Outside,
}

/// A slab from `bottom` to `top` above the heights of a map, on [0, 1]^2 x [low, high]: with q the height above
/// the map, 1 where `bottom + ramp <= q <= top - ramp` and falling linearly to 0 at both faces (or from 1 at
/// the faces to 0 a ramp beyond). As an extinction it has the optical depth `(top - bottom) - ramp` along z, or
/// `+ ramp` (K-28).
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    map: HeightMap,
    bottom: f64,
    top: f64,
    ramp: f64,
    side: Ramp,
}

impl HeightField {
    /// A slab over a map.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] unless `bottom < top`, both finite, and the ramp is above 0 and, inside, at most half
    /// of the slab.
    pub fn new(map: HeightMap, [bottom, top]: [f64; 2], ramp: f64, side: Ramp) -> Result<Self, FieldError> {
        if !(bottom.is_finite() && top.is_finite() && bottom < top) {
            return Err(FieldError::Parameter { name: "top", found: top, expected: "finite and above bottom" });
        }
        let most = if side == Ramp::Inside { (top - bottom) / 2.0 } else { f64::MAX };
        if !(ramp > 0.0 && ramp <= most) {
            let expected = "above 0 and, inside, at most half of the slab";
            return Err(FieldError::Parameter { name: "ramp", found: ramp, expected });
        }
        Ok(Self { map, bottom, top, ramp, side })
    }

    /// How far the ramp reaches beyond the faces.
    fn beyond(&self) -> f64 {
        if self.side == Ramp::Inside { 0.0 } else { self.ramp }
    }
}

impl ScalarField for HeightField {
    fn value(&self, p: DVec3) -> f64 {
        let q = p.z - self.map.at(p.truncate());
        let depth = (q - self.bottom).min(self.top - q) + self.beyond();
        (depth / self.ramp).clamp(0.0, 1.0)
    }

    /// By central differences over 1/4096 of the map.
    fn gradient(&self, p: DVec3) -> DVec3 {
        const STEP: f64 = 1.0 / 4096.0;
        let slope = |axis: DVec3| (self.value(p + axis * STEP) - self.value(p - axis * STEP)) / (2.0 * STEP);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let heights = || self.map.heights.iter().map(|height| f64::from(*height));
        let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let beyond = self.beyond();
        (DVec3::new(0.0, 0.0, low + self.bottom - beyond), DVec3::new(1.0, 1.0, high + self.top + beyond))
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: "height-field",
            description: "a slab over a map of heights",
            dims: [128, 128, 64],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}
