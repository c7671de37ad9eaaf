//! Values far from 0: backends compute in single precision, which tells whole numbers apart up to 2^24. Labels and
//! identifiers are often larger, but close to each other, and so are times and absolute positions: what is drawn then
//! counts from the smallest of them.

use std::sync::Arc;

use pellucid_field::{FieldError, ValueMap, Volume, Voxels};

/// Up to here single precision has every whole number.
const WHOLE: f64 = (1u32 << 24) as f64;

/// The data value that values have to be counted from to be told apart, if they would not be as they are.
pub fn origin_of(volume: &Volume) -> Option<f64> {
    let (range, map) = (volume.statistics(), volume.value_map());
    if !volume.voxels().voxel_type().is_integer() {
        // Stored numbers are as fine as they are: only what is added to them may leave fewer than 16 bits of them.
        return (map.offset.abs() > 256.0 * (range.max - range.min)).then_some(range.min);
    }
    let levels = |value: f64| (value / map.scale).abs();
    let told_apart = levels(range.min).max(levels(range.max)) <= WHOLE;
    // Where most of the range is beyond, counting from elsewhere does not help.
    let helps = levels(range.max - range.min) <= WHOLE;
    (!told_apart && helps).then_some(range.min)
}

/// How far apart integers of a volume have to be to be told apart, if that is more than one level.
pub fn smallest_difference(volume: &Volume) -> Option<f64> {
    let (range, map) = (volume.statistics(), volume.value_map());
    let largest = (range.min / map.scale).abs().max((range.max / map.scale).abs());
    let is_integer = volume.voxels().voxel_type().is_integer();
    let gap = (largest / WHOLE).log2().ceil().exp2();
    (is_integer && largest > WHOLE).then(|| gap * map.scale.abs())
}

/// A volume whose data values are less by `origin`, the smallest of them or the one of its smallest number.
///
/// # Errors
/// None that a volume could have; of [`Volume`].
pub fn counted_from(volume: &Volume, origin: f64) -> Result<Arc<Volume>, FieldError> {
    let map = volume.value_map();
    let first = map.stored(origin).round();
    let (voxels, first): (Voxels, f64) = match volume.voxels() {
        // Only the map is far from 0.
        voxels if voxels.voxel_type().size() < 4 => (voxels.clone(), 0.0),
        // Counted up from the smallest number, or down from the largest where values fall.
        Voxels::U32(data) if map.scale > 0.0 => {
            let first = first as u32;
            (data.iter().map(|v| v.wrapping_sub(first)).collect::<Vec<u32>>().into(), f64::from(first))
        }
        Voxels::U32(data) => {
            let first = first as u32;
            (data.iter().map(|v| v.wrapping_sub(first) as i32).collect::<Vec<i32>>().into(), f64::from(first))
        }
        Voxels::I32(data) => {
            let first = first as i32;
            (data.iter().map(|v| v.wrapping_sub(first)).collect::<Vec<i32>>().into(), f64::from(first))
        }
        voxels => (voxels.clone(), 0.0),
    };
    let offset = (map.offset - origin) + first * map.scale;
    let mut counted = Volume::with_components(*volume.grid(), voxels, volume.components())?
        .with_value_map(ValueMap { offset, ..map })?
        .with_name(volume.name.clone());
    counted.value_unit.clone_from(&volume.value_unit);
    counted.length_unit.clone_from(&volume.length_unit);
    Ok(Arc::new(counted))
}
