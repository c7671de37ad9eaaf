//! A part of a volume.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use crate::{FieldError, Grid, Volume, Voxel, Voxels, for_voxels, parallel};

/// The `size` voxels per axis from voxel `from` on, with all components, at the same place in the
/// world: only the origin of the affine moves.
///
/// # Errors
/// [`FieldError::Region`] if the region is empty or reaches out of the grid.
pub fn crop(volume: &Volume, from: [usize; 3], size: [usize; 3]) -> Result<Volume, FieldError> {
    let dims = volume.grid().dims();
    let fits = |axis: usize| size[axis] > 0 && from[axis].checked_add(size[axis]).is_some_and(|end| end <= dims[axis]);
    if !(0..3).all(fits) {
        return Err(FieldError::Region { from, size, dims });
    }
    let origin = DAffine3::from_translation(DVec3::from_array(from.map(|i| i as f64)));
    let grid = Grid::with_affine(size, volume.grid().world_from_index() * origin)?;
    let voxels: Voxels = for_voxels!(volume.voxels(), data => copy(data, volume, from, size).into());
    volume.with_samples(grid, voxels, volume.components())
}

fn copy<T: Voxel>(data: &[T], volume: &Volume, from: [usize; 3], size: [usize; 3]) -> Vec<T> {
    let components = volume.components();
    let row = size[0] * components;
    let mut voxels = vec![T::zeroed(); row * size[1] * size[2]];
    let fill = |(index, voxels): (usize, &mut [T])| {
        let (y, z) = (index % size[1], index / size[1]);
        let start = volume.grid().linear_index([from[0], from[1] + y, from[2] + z]) * components;
        voxels.copy_from_slice(&data[start..start + row]);
    };
    parallel(|| voxels.par_chunks_mut(row).enumerate().for_each(fill));
    voxels
}
