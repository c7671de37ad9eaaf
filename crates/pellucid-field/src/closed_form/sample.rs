//! From a field to a volume.

use glam::DVec3;
use half::f16;
use rayon::prelude::*;

use super::ScalarField;
use crate::{FieldError, Grid, ValueMap, Volume, Voxel, VoxelType, Voxels, parallel};

/// Samples a field on a grid whose outermost samples lie on the box of the field (1.5-1: N
/// samples span N - 1 spacings). An axis with one sample gets the middle of the box, one voxel
/// as thick as the box.
///
/// Of a field with edges that are sharper than the grid can hold, voxels have what they [see](ScalarField::seen).
///
/// Data values are the field's own in every voxel type. Float types store them as they are.
/// Integer types store them as they are, rounded, if the field is measured in whole units
/// (Hounsfield) and its range fits into the type; otherwise the range of the field is spread over
/// all levels of the type, and the volume's [`ValueMap`] leads back.
///
/// # Errors
/// [`FieldError::Dims`] and [`FieldError::Affine`] for a grid that cannot be,
/// [`FieldError::Parameter`] if the range of the field is not finite.
pub fn sample_field(field: &dyn ScalarField, dims: [usize; 3], voxel_type: VoxelType) -> Result<Volume, FieldError> {
    let grid = grid_over(field.bounds(), dims)?;
    let map = value_map(field, voxel_type)?;
    let voxels: Voxels = match voxel_type {
        VoxelType::U8 => fill::<u8>(field, &grid, map).into(),
        VoxelType::I8 => fill::<i8>(field, &grid, map).into(),
        VoxelType::U16 => fill::<u16>(field, &grid, map).into(),
        VoxelType::I16 => fill::<i16>(field, &grid, map).into(),
        VoxelType::U32 => fill::<u32>(field, &grid, map).into(),
        VoxelType::I32 => fill::<i32>(field, &grid, map).into(),
        VoxelType::F16 => fill::<f16>(field, &grid, map).into(),
        VoxelType::F32 => fill::<f32>(field, &grid, map).into(),
    };
    let about = field.about();
    let mut volume = Volume::new(grid, voxels)?.with_value_map(map)?.with_name(about.name);
    volume.value_unit = about.value_unit.map(str::to_owned);
    volume.length_unit = about.length_unit.map(str::to_owned);
    // Only fields of patients are in their millimetres.
    volume.is_anatomical = about.length_unit == Some("mm");
    Ok(volume)
}

fn grid_over((low, high): (DVec3, DVec3), dims: [usize; 3]) -> Result<Grid, FieldError> {
    let (mut spacing, mut origin) = (high - low, low);
    for axis in 0..3 {
        match dims[axis] {
            0 | 1 => origin[axis] = (low[axis] + high[axis]) / 2.0,
            n => spacing[axis] /= (n - 1) as f64,
        }
    }
    Grid::with_spacing(dims, spacing.to_array(), origin.to_array())
}

fn value_map(field: &dyn ScalarField, voxel_type: VoxelType) -> Result<ValueMap, FieldError> {
    let (low, high) = field.range();
    for (name, found) in [("lowest value of the field", low), ("highest value of the field", high)] {
        if !found.is_finite() {
            return Err(FieldError::Parameter { name, found, expected: "finite" });
        }
    }
    let Some((first, last)) = levels(voxel_type) else { return Ok(ValueMap::IDENTITY) };
    if field.about().whole_units && first <= low && high <= last {
        return Ok(ValueMap::IDENTITY);
    }
    let scale = if high > low { (high - low) / (last - first) } else { 1.0 };
    Ok(ValueMap { scale, offset: low - first * scale })
}

/// Lowest and highest number of an integer type.
fn levels(voxel_type: VoxelType) -> Option<(f64, f64)> {
    Some(match voxel_type {
        VoxelType::U8 => (0.0, u8::MAX.into()),
        VoxelType::I8 => (i8::MIN.into(), i8::MAX.into()),
        VoxelType::U16 => (0.0, u16::MAX.into()),
        VoxelType::I16 => (i16::MIN.into(), i16::MAX.into()),
        VoxelType::U32 => (0.0, u32::MAX.into()),
        VoxelType::I32 => (i32::MIN.into(), i32::MAX.into()),
        VoxelType::F16 | VoxelType::F32 => return None,
    })
}

fn fill<T: Voxel>(field: &dyn ScalarField, grid: &Grid, map: ValueMap) -> Vec<T> {
    let [nx, ny, _] = grid.dims();
    let width = voxel_width(grid);
    let mut voxels = vec![T::zeroed(); grid.len()];
    let fill = |(row, voxels): (usize, &mut [T])| {
        let (y, z) = ((row % ny) as f64, (row / ny) as f64);
        let at = |x: f64| grid.world_from_index().transform_point3(DVec3::new(x, y, z));
        for (run, voxels) in voxels.chunks_mut(RUN).enumerate() {
            let (first, last) = ((run * RUN) as f64, (run * RUN + voxels.len() - 1) as f64);
            let (middle, radius) = (at((first + last) / 2.0), at(first).distance(at(last)) / 2.0);
            if let Some(value) = field.even(middle, radius, width) {
                voxels.fill(T::from_f64(map.stored(value)));
                continue;
            }
            for (x, voxel) in voxels.iter_mut().enumerate() {
                *voxel = T::from_f64(map.stored(field.seen(at(first + x as f64), width)));
            }
        }
    };
    parallel(|| voxels.par_chunks_mut(nx).enumerate().for_each(fill));
    voxels
}

/// Voxels of a row that are filled at once where a field is even.
const RUN: usize = 8;

/// What a voxel sees is as wide as its neighbours are away: the geometric mean over the axes that have any.
fn voxel_width(grid: &Grid) -> f64 {
    let (spacing, dims) = (grid.spacing(), grid.dims());
    let apart: Vec<f64> = (0..3).filter(|axis| dims[*axis] > 1).map(|axis| spacing[axis]).collect();
    if apart.is_empty() { 0.0 } else { apart.iter().product::<f64>().powf(1.0 / apart.len() as f64) }
}
