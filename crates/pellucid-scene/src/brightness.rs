//! Colours as one value per voxel.

use pellucid_field::{FieldError, Volume, Voxel, Voxels, parallel};
use rayon::prelude::*;

use crate::holds_colors;

/// The brightness of a volume whose voxels are colours, 3 or 4 components of 8 or 16 bits: the luma of Rec. ITU-R
/// BT.709, 3.2, of encoded red, green and blue, times their alpha if they have one. `None` for other volumes.
///
/// # Errors
/// None that a volume which exists can have.
pub fn brightness(volume: &Volume) -> Result<Option<Volume>, FieldError> {
    if !holds_colors(volume) {
        return Ok(None);
    }
    let colors = volume.components();
    let voxels = match volume.voxels() {
        Voxels::U8(data) => Voxels::from(lumas(data, colors, f64::from(u8::MAX))),
        Voxels::U16(data) => Voxels::from(lumas(data, colors, f64::from(u16::MAX))),
        _ => return Ok(None),
    };
    let mut luma =
        Volume::new(*volume.grid(), voxels)?.with_value_map(volume.value_map())?.with_name(volume.name.clone());
    (luma.value_unit, luma.length_unit) = (volume.value_unit.clone(), volume.length_unit.clone());
    Ok(Some(luma))
}

fn lumas<T: Voxel>(data: &[T], components: usize, most: f64) -> Vec<T> {
    let luma = |voxel: &[T]| {
        let [r, g, b] = [0, 1, 2].map(|channel| voxel[channel].to_f64());
        let alpha = voxel.get(3).map_or(1.0, |alpha| alpha.to_f64() / most);
        T::from_f64(((0.2126 * r + 0.7152 * g + 0.0722 * b) * alpha).round())
    };
    parallel(|| data.par_chunks_exact(components).map(luma).collect())
}
