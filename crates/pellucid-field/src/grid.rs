//! Grid geometry: dims and one affine.

use glam::{DAffine3, DMat3, DVec3};

use crate::FieldError;

/// A regular grid of samples: how many per axis, and where they are.
///
/// Voxel (i, j, k) is a sample at `world_from_index * (i, j, k)`. The grid spans the box between
/// its outermost samples, `[0, n - 1]` in index space; an axis with a single sample has the
/// thickness of that one voxel, `[-1/2, 1/2]`, so that an image or a line of voxels can be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    world_from_index: DAffine3,
    index_from_world: DAffine3,
}

impl Grid {
    /// A grid with unit spacing, unrotated, its first voxel at the origin.
    ///
    /// # Errors
    /// [`FieldError::Dims`] if an axis is empty or the voxel count overflows.
    pub fn new(dims: [usize; 3]) -> Result<Self, FieldError> {
        Self::with_affine(dims, DAffine3::IDENTITY)
    }

    /// A grid from a spacing per axis in world units and the position of its first voxel.
    ///
    /// # Errors
    /// As [`Grid::with_affine`].
    pub fn with_spacing(dims: [usize; 3], spacing: [f64; 3], origin: [f64; 3]) -> Result<Self, FieldError> {
        let linear = DMat3::from_diagonal(DVec3::from_array(spacing));
        Self::with_affine(dims, DAffine3 { matrix3: linear, translation: DVec3::from_array(origin) })
    }

    /// A grid from its full index-to-world affine; rotated, sheared and mirrored grids are
    /// ordinary.
    ///
    /// # Errors
    /// [`FieldError::Dims`], [`FieldError::Affine`], and [`FieldError::Extent`] where neighbouring samples are
    /// closer than 1e-30, or than 1e-13 of how far along their axis they are from the origin, or further apart than 1e30
    /// world units, or any sample is further than 1e35 from the origin.
    pub fn with_affine(dims: [usize; 3], world_from_index: DAffine3) -> Result<Self, FieldError> {
        let count = dims.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        if count.is_none_or(|count| count == 0 || count > isize::MAX as usize / 64) {
            return Err(FieldError::Dims { dims });
        }
        let determinant = world_from_index.matrix3.determinant();
        let inverse = world_from_index.inverse();
        if determinant == 0.0 || !determinant.is_finite() || !world_from_index.is_finite() || !inverse.is_finite() {
            return Err(FieldError::Affine { determinant });
        }
        let grid = Self { dims, world_from_index, index_from_world: inverse };
        grid.check_extent()?;
        Ok(grid)
    }

    /// Single precision ends at 1e38, gradients are values over spacings, and double precision has 16 digits.
    fn check_extent(&self) -> Result<(), FieldError> {
        const SPACINGS: [f64; 2] = [1e-30, 1e30];
        const FURTHEST: f64 = 1e35;
        /// How far apart voxels have to be for their distance from the origin, or eyes and rays are rounded to visible
        /// parts of voxels.
        const PRECISION: f64 = 1e-13;
        let refuse = |what, found, [least, most]: [f64; 2]| match (least..=most).contains(&found) {
            true => Ok(()),
            false => Err(FieldError::Extent { what, found, least, most }),
        };
        let spacings = self.spacing();
        for spacing in spacings {
            refuse("the distance between two voxels", spacing, SPACINGS)?;
        }
        let (low, high) = self.world_bounds();
        let furthest = low.abs().max(high.abs()).max_element();
        refuse("the distance of the furthest voxel from the origin", furthest, [0.0, FURTHEST])?;
        for (axis, spacing) in spacings.into_iter().enumerate() {
            // Only places along the axis tell its voxels apart.
            let along = self.world_from_index.matrix3.col(axis) / spacing;
            let far = self.world_corners().map(|corner| corner.dot(along).abs()).into_iter().fold(0.0, f64::max);
            let what = "the distance between two voxels that far from the origin";
            refuse(what, spacing, [PRECISION * far, SPACINGS[1]])?;
        }
        Ok(())
    }

    /// Samples per axis, x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// Never true: a grid has at least one voxel.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// World position of a continuous index.
    pub fn world_from_index(&self) -> DAffine3 {
        self.world_from_index
    }

    /// Continuous index of a world position.
    pub fn index_from_world(&self) -> DAffine3 {
        self.index_from_world
    }

    /// Texture coordinates of a continuous index: `(i + 1/2) / n`.
    pub fn texture_from_index(&self) -> DAffine3 {
        let n = DVec3::from_array(self.dims.map(|n| n as f64));
        DAffine3 { matrix3: DMat3::from_diagonal(n.recip()), translation: 0.5 / n }
    }

    /// Texture coordinates of a world position.
    pub fn texture_from_world(&self) -> DAffine3 {
        self.texture_from_index() * self.index_from_world
    }

    /// World gradient from a gradient per index step: the inverse transpose of the affine, so
    /// that normals stay perpendicular to surfaces whatever the spacing and shear (5.3, 2.2-1).
    pub fn world_from_index_gradient(&self) -> DMat3 {
        self.index_from_world.matrix3.transpose()
    }

    /// Distance between neighbouring samples along x, y and z, in world units.
    pub fn spacing(&self) -> [f64; 3] {
        let m = self.world_from_index.matrix3;
        [m.x_axis.length(), m.y_axis.length(), m.z_axis.length()]
    }

    /// Mean of the three spacings: the default unit distance of opacity.
    pub fn mean_spacing(&self) -> f64 {
        self.spacing().iter().sum::<f64>() / 3.0
    }

    /// Smallest of the three spacings: the reference length of a sampling step (9.1-1).
    pub fn smallest_spacing(&self) -> f64 {
        self.spacing().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The box the grid spans, in index space, as (lowest, highest) corner.
    pub fn index_bounds(&self) -> (DVec3, DVec3) {
        let low = self.dims.map(|n| if n == 1 { -0.5 } else { 0.0 });
        let high = self.dims.map(|n| if n == 1 { 0.5 } else { (n - 1) as f64 });
        (DVec3::from_array(low), DVec3::from_array(high))
    }

    /// The eight corners of the grid's box in the world, x fastest.
    pub fn world_corners(&self) -> [DVec3; 8] {
        self.world_corners_of(self.index_bounds())
    }

    /// The eight corners in the world of a box in index space, given as (lowest, highest) corner;
    /// x fastest.
    pub fn world_corners_of(&self, (low, high): (DVec3, DVec3)) -> [DVec3; 8] {
        std::array::from_fn(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            self.world_from_index.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
        })
    }

    /// The axis-aligned box around [`Grid::world_corners`], as (lowest, highest) corner.
    pub fn world_bounds(&self) -> (DVec3, DVec3) {
        let corners = self.world_corners();
        corners.iter().fold((corners[0], corners[0]), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// World position of the middle of the grid.
    pub fn center(&self) -> DVec3 {
        let (low, high) = self.index_bounds();
        self.world_from_index.transform_point3((low + high) / 2.0)
    }

    /// Position of voxel (x, y, z) in memory, in voxels: `x + nx * (y + ny * z)`.
    pub fn linear_index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.dims[0] * (y + self.dims[1] * z)
    }
}
