//! Coefficients that make a cubic B-spline interpolate.

use rayon::prelude::*;

use crate::{FieldError, Volume, Voxel, for_voxels, parallel};

/// The stable pole of the inverse of the sampled cubic B-spline (1, 4, 1) / 6: sqrt(3) - 2.
const POLE: f64 = -0.267_949_192_431_122_7;

/// The cubic B-spline coefficients of one component of a volume, as an `f32` volume on the same
/// grid with the same value map: under [`Filter::BSpline`](crate::Filter::BSpline) with
/// `prefilter: false` it takes the values of `volume` at the voxels, up to `f32` rounding.
///
/// The borders mirror the volume about the outer faces of its border voxels, which is what taps
/// clamped to the border meet there. Absent voxels take part with the nearest present value along
/// their line (x first, then y, then z) and are NaN in the result; at the present voxels that touch
/// one, interpolation is approximate, because there a sample sees its nearest coefficient instead.
///
/// # Errors
/// [`FieldError::Parameter`] if there is no such component.
pub fn spline_coefficients(volume: &Volume, component: usize) -> Result<Volume, FieldError> {
    volume.check_component(component)?;
    let coefficients = for_voxels!(volume.voxels(), data => {
        parallel(|| coefficients(data, volume.grid().dims(), volume.components(), component))
    });
    let mut result = Volume::new(*volume.grid(), coefficients)?.with_value_map(volume.value_map())?;
    result.name.clone_from(&volume.name);
    result.value_unit.clone_from(&volume.value_unit);
    result.length_unit.clone_from(&volume.length_unit);
    result.is_anatomical = volume.is_anatomical;
    Ok(result)
}

fn coefficients<T: Voxel>(data: &[T], [nx, ny, _]: [usize; 3], components: usize, component: usize) -> Vec<f32> {
    let voxels = || data.par_chunks(components).map(|voxel| voxel[component].to_f32());
    let mut values: Vec<f32> = voxels().collect();
    values.par_chunks_mut(nx).for_each(|line| filter_rows(line.chunks_mut(1).collect()));
    values.par_chunks_mut(nx * ny).for_each(|slab| filter_rows(slab.chunks_mut(nx).collect()));
    let mut by_y: Vec<Vec<&mut [f32]>> = std::iter::repeat_with(Vec::new).take(ny).collect();
    for (row, values) in values.chunks_mut(nx).enumerate() {
        by_y[row % ny].push(values);
    }
    by_y.into_par_iter().for_each(filter_rows);
    values.par_iter_mut().zip(voxels()).for_each(|(value, voxel)| {
        if !voxel.is_finite() {
            *value = f32::NAN;
        }
    });
    values
}

/// Filters every column of a stack of rows of equal width, in double precision.
fn filter_rows(mut rows: Vec<&mut [f32]>) {
    let (count, width) = (rows.len(), rows[0].len());
    let mut panel: Vec<f64> = rows.iter().flat_map(|row| row.iter().map(|&v| f64::from(v))).collect();
    if panel.iter().any(|v| !v.is_finite()) {
        (0..width).for_each(|column| fill_absent(&mut panel, width, column));
    }
    if count > 1 {
        filter_columns(&mut panel, width);
    }
    for (row, values) in rows.iter_mut().zip(panel.chunks(width)) {
        row.iter_mut().zip(values).for_each(|(out, &value)| *out = value as f32);
    }
}

/// Gives the absent entries of a column the nearest present one's value (NaN if there is none).
fn fill_absent(panel: &mut [f64], width: usize, column: usize) {
    let at = |row: usize| row * width + column;
    let rows = panel.len() / width;
    let present: Vec<usize> = (0..rows).filter(|&row| panel[at(row)].is_finite()).collect();
    for row in (0..rows).filter(|row| present.binary_search(row).is_err()) {
        let after = present.partition_point(|&p| p < row);
        let neighbours = [after.checked_sub(1), Some(after)];
        let nearest = neighbours.into_iter().flatten().filter_map(|i| present.get(i)).min_by_key(|p| p.abs_diff(row));
        panel[at(row)] = nearest.map_or(f64::NAN, |&p| panel[at(p)]);
    }
}

/// Solves `(c[i-1] + 4 c[i] + c[i+1]) / 6 = f[i]` along the columns of a panel of at least two
/// rows, where `c[-1] = c[0]` and `c[n] = c[n-1]`: a causal and an anticausal recursion with the
/// same pole, each begun with what the mirrored signal would have left it.
fn filter_columns(panel: &mut [f64], width: usize) {
    let rows = panel.len() / width;
    panel.iter_mut().for_each(|v| *v *= 6.0);
    let turn = POLE.powi(rows as i32);
    for column in 0..width {
        let (mut power, mut sum) = (1.0, 0.0);
        for row in 0..rows {
            sum += power * (panel[row * width + column] + turn * panel[(rows - 1 - row) * width + column]);
            power *= POLE;
        }
        panel[column] += sum * POLE / (1.0 - turn * turn);
    }
    for at in width..panel.len() {
        panel[at] += POLE * panel[at - width];
    }
    let last = panel.len() - width;
    panel[last..].iter_mut().for_each(|v| *v *= POLE / (POLE - 1.0));
    for at in (0..last).rev() {
        panel[at] = POLE * (panel[at + width] - panel[at]);
    }
}
