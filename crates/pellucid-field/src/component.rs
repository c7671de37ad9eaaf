//! One of the values of every voxel, by itself.

use rayon::prelude::*;

use crate::{FieldError, Volume, Voxels, for_voxels, parallel};

/// A component of a volume as a volume of its own: values that are read alone lie side by side.
///
/// # Errors
/// [`FieldError::Parameter`] if there is no such component.
pub fn component(volume: &Volume, component: usize) -> Result<Volume, FieldError> {
    volume.check_component(component)?;
    let own = volume.components();
    let voxels: Voxels = for_voxels!(volume.voxels(), data => {
        parallel(|| data.par_chunks_exact(own).map(|voxel| voxel[component]).collect::<Vec<_>>()).into()
    });
    volume.with_samples(*volume.grid(), voxels, 1)
}
