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
    one_each(volume, |[r, g, b, alpha], most| (0.2126 * r + 0.7152 * g + 0.0722 * b) * (alpha / most))
}

/// The alpha of a volume of colours, by itself: of those that have none the largest that there is. `None` for other
/// volumes.
///
/// # Errors
/// None that a volume which exists can have.
pub fn alpha(volume: &Volume) -> Result<Option<Volume>, FieldError> {
    one_each(volume, |[.., alpha], _| alpha)
}

/// A volume of what a function makes of every colour with its alpha, given the largest number of its type.
fn one_each(volume: &Volume, value: impl Fn([f64; 4], f64) -> f64 + Sync) -> Result<Option<Volume>, FieldError> {
    if !holds_colors(volume) {
        return Ok(None);
    }
    let voxels = match volume.voxels() {
        Voxels::U8(data) => Voxels::from(values(data, volume.components(), u8::MAX.into(), value)),
        Voxels::U16(data) => Voxels::from(values(data, volume.components(), u16::MAX.into(), value)),
        _ => return Ok(None),
    };
    let mut made =
        Volume::new(*volume.grid(), voxels)?.with_value_map(volume.value_map())?.with_name(volume.name.clone());
    (made.value_unit, made.length_unit) = (volume.value_unit.clone(), volume.length_unit.clone());
    Ok(Some(made))
}

fn values<T: Voxel>(data: &[T], components: usize, most: f64, value: impl Fn([f64; 4], f64) -> f64 + Sync) -> Vec<T> {
    let one = |voxel: &[T]| {
        let channel = |number: usize| voxel.get(number).map_or(most, |channel| channel.to_f64());
        T::from_f64(value([0, 1, 2, 3].map(channel), most).round())
    };
    parallel(|| data.par_chunks_exact(components).map(one).collect())
}
