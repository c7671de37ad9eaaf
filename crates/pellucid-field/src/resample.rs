//! Resampling onto another grid.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use crate::{
    FieldError, Filter, Grid, Reconstruct, Sampler, ValueMap, Volume, Voxel, Voxels, for_voxels, parallel,
    with_reconstruction,
};

/// How far outside the box a sample may be, and a position from the integer it is rounded to: the
/// error of two affines, in voxels.
const TOLERANCE: f64 = 1e-6;

/// Resamples a volume to other dims over the same box (the box between its outermost samples,
/// [`Grid::index_bounds`]).
///
/// Otherwise as [`resample`].
///
/// # Errors
/// [`FieldError::Dims`], and [`FieldError::Parameter`] for a filter out of its range.
pub fn resample_dims(volume: &Volume, dims: [usize; 3], filter: Filter) -> Result<Volume, FieldError> {
    let (low, high) = volume.grid().index_bounds();
    let (new_low, new_high) = Grid::new(dims)?.index_bounds();
    let scale = (high - low) / (new_high - new_low);
    let old_from_new = DAffine3 { matrix3: DMat3::from_diagonal(scale), translation: low - scale * new_low };
    let grid = Grid::with_affine(dims, volume.grid().world_from_index() * old_from_new)?;
    resample(volume, grid, filter, f64::NAN)
}

/// Samples a volume at the voxels of another grid, in its own type (rounded and saturated). Name,
/// units and value map are kept; absent samples are NaN.
///
/// Where the new samples are farther apart than the old ones along an axis, the kernel is widened
/// by that factor, so that what the new grid cannot represent is averaged away instead of aliasing
/// (1.5-5). How sharply is the filter's choice: [`Filter::Linear`] averages gently and cannot
/// overshoot; a [`Filter::Sinc`] of half width 8 under the Kaiser window keeps 95 % of a wave at
/// 0.8 of the new Nyquist frequency and less than a tenth at 1.2. [`Filter::Nearest`] is never
/// widened, so labels stay labels. Widened by a factor that is not whole, a kernel displaces the
/// field slightly: by less than a tenth of an old voxel for [`Filter::Linear`], less for others.
///
/// Where the axes of the two grids are parallel the work is one pass per axis in double precision;
/// otherwise the widened kernels are applied on the old grid (in `f32`) and the result is sampled.
///
/// # Arguments
/// `outside` is the data value of samples outside the old box; NaN makes them absent.
///
/// # Errors
/// [`FieldError::Parameter`] for a filter out of its range, or if `outside` is not a finite number
/// although integer voxels need it.
pub fn resample(volume: &Volume, grid: Grid, filter: Filter, outside: f64) -> Result<Volume, FieldError> {
    filter.validate()?;
    let old_from_new = volume.grid().index_from_world() * grid.world_from_index();
    let is_outside = |index: DVec3| !contains(volume.grid(), old_from_new.transform_point3(index));
    let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
    let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * last;
    let reaches_out = (0..8).any(|i| is_outside(corner(i)));
    if reaches_out && volume.voxels().voxel_type().is_integer() && !outside.is_finite() {
        let expected = "must be a number: integer voxels cannot be absent and the new grid reaches outside the old one";
        return Err(FieldError::Parameter { name: "value outside", found: outside, expected });
    }
    // Weights sum to 1, so stored numbers can be filtered in place of data values.
    let stored = volume.clone().with_value_map(ValueMap::IDENTITY)?;
    let outside = volume.value_map().stored(outside);
    let components = (0..volume.components()).map(|component| {
        let mut values = resample_component(&stored, component, &grid, old_from_new, filter)?;
        if reaches_out {
            let place = |(i, value): (usize, &mut f64)| {
                if value.is_nan() && is_outside(index_of(grid.dims(), i)) {
                    *value = outside;
                }
            };
            parallel(|| values.par_iter_mut().enumerate().for_each(place));
        }
        Ok(values)
    });
    let values = components.collect::<Result<Vec<Vec<f64>>, FieldError>>()?;
    let voxels = for_voxels!(volume.voxels(), data => interleave(data, &values));
    let mut result = Volume::with_components(grid, voxels, volume.components())?.with_value_map(volume.value_map())?;
    result.name.clone_from(&volume.name);
    result.value_unit.clone_from(&volume.value_unit);
    result.length_unit.clone_from(&volume.length_unit);
    result.is_anatomical = volume.is_anatomical;
    Ok(result)
}

/// The samples of one component of a volume (with the identity value map) at the voxels of a grid.
fn resample_component(
    volume: &Volume,
    component: usize,
    grid: &Grid,
    old_from_new: DAffine3,
    filter: Filter,
) -> Result<Vec<f64>, FieldError> {
    let sampler = Sampler::new(volume, component, filter)?;
    let (source, dims) = (sampler.source(), volume.grid().dims());
    let linear = old_from_new.matrix3;
    // The length of a row is how far one step of every new axis goes along an old one.
    let shrink: [f64; 3] = std::array::from_fn(|axis| match linear.row(axis).length() {
        step if filter != Filter::Nearest && step > 1.0 + TOLERANCE => step,
        _ => 1.0,
    });
    let run = |plans: [Plan; 3]| {
        for_voxels!(source.voxels(), data => {
            run_plans(|i| data[i * source.components() + sampler.component()].to_f64(), dims, &plans)
        })
    };
    if is_diagonal(linear, grid.dims()) {
        return Ok(run(std::array::from_fn(|axis| {
            let position = |i: usize| linear.col(axis)[axis] * i as f64 + old_from_new.translation[axis];
            (0..grid.dims()[axis]).map(|i| Line::new(filter, volume.grid(), axis, position(i), shrink[axis])).collect()
        })));
    }
    if shrink == [1.0; 3] {
        return Ok(with_reconstruction!(&sampler, field => sample(&field, grid.dims(), old_from_new)));
    }
    let smooth = run(std::array::from_fn(|axis| {
        (0..dims[axis]).map(|i| Line::new(filter, volume.grid(), axis, i as f64, shrink[axis])).collect()
    }));
    let smooth = Volume::new(*volume.grid(), smooth.into_iter().map(|v| v as f32).collect::<Vec<_>>())?;
    // These are the values of the filtered field: a filter that smooths must not do so twice.
    let filter = if filter.is_interpolating() { filter } else { Filter::BSpline { prefilter: true } };
    Ok(with_reconstruction!(&Sampler::new(&smooth, 0, filter)?, field => sample(&field, grid.dims(), old_from_new)))
}

fn sample(field: &impl Reconstruct, dims: [usize; 3], old_from_new: DAffine3) -> Vec<f64> {
    let value = |i| field.value(old_from_new.transform_point3(index_of(dims, i)).map(snap));
    parallel(|| (0..dims.iter().product()).into_par_iter().map(value).collect())
}

/// How the samples of one line are made of those of the line it replaces; `None` is outside.
type Plan = Vec<Option<Line>>;

struct Line {
    taps: Vec<(usize, f64)>,
    nearest: usize,
}

impl Line {
    /// The taps at a position along an axis of a grid, of a kernel widened by `shrink`.
    fn new(filter: Filter, grid: &Grid, axis: usize, position: f64, shrink: f64) -> Option<Self> {
        let (low, high) = grid.index_bounds();
        if !(low[axis] - TOLERANCE..=high[axis] + TOLERANCE).contains(&position) {
            return None;
        }
        let last = grid.dims()[axis] - 1;
        let x = snap(position).clamp(0.0, last as f64);
        let clamp = |i: i64| i.clamp(0, last as i64) as usize;
        let taps = if shrink > 1.0 {
            let reach = filter.half_width() as f64 * shrink;
            let support = (x - reach).ceil() as i64..=(x + reach).floor() as i64;
            let taps: Vec<(usize, f64)> = support
                .map(|i| (clamp(i), filter.kernel((x - i as f64) / shrink)))
                .filter(|tap| tap.1 != 0.0)
                .collect();
            let sum: f64 = taps.iter().map(|tap| tap.1).sum();
            taps.into_iter().map(|(i, weight)| (i, weight / sum)).collect()
        } else {
            let first = x as i64 + 1 - filter.half_width() as i64;
            let weights = filter.weights(x.fract());
            weights.iter().enumerate().map(|(i, &weight)| (clamp(first + i as i64), weight)).collect()
        };
        Some(Self { taps, nearest: (x + 0.5) as usize })
    }

    /// Its value from those of the old line; absent ones are replaced as a [`Sampler`] does.
    #[inline(always)]
    fn value(&self, at: impl Fn(usize) -> f64) -> f64 {
        let sum: f64 = self.taps.iter().map(|&(i, weight)| weight * at(i)).sum();
        if sum.is_finite() {
            return sum;
        }
        let nearest = at(self.nearest);
        if !nearest.is_finite() {
            return f64::NAN;
        }
        let present = |i| Some(at(i)).filter(|v: &f64| v.is_finite()).unwrap_or(nearest);
        self.taps.iter().map(|&(i, weight)| weight * present(i)).sum()
    }
}

/// One pass per axis, the one that shrinks most first.
fn run_plans(read: impl Fn(usize) -> f64 + Sync, mut dims: [usize; 3], plans: &[Plan; 3]) -> Vec<f64> {
    let growth = |axis: usize| plans[axis].len() as f64 / dims[axis] as f64;
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| growth(a).total_cmp(&growth(b)));
    let mut values = run_plan(read, dims, axes[0], &plans[axes[0]]);
    for pass in 1..3 {
        dims[axes[pass - 1]] = plans[axes[pass - 1]].len();
        values = run_plan(|i| values[i], dims, axes[pass], &plans[axes[pass]]);
    }
    values
}

/// Replaces every line along one axis; `read` gives a value by its position in memory.
fn run_plan(read: impl Fn(usize) -> f64 + Sync, dims: [usize; 3], axis: usize, plan: &Plan) -> Vec<f64> {
    let inner: usize = dims[..axis].iter().product();
    let outer: usize = dims[axis + 1..].iter().product();
    let mut out = vec![f64::NAN; inner * plan.len() * outer];
    let least = (1 << 12) / inner.min(1 << 12);
    let fill = |(row, values): (usize, &mut [f64])| {
        let Some(line) = &plan[row % plan.len()] else { return };
        let start = row / plan.len() * dims[axis] * inner;
        for (i, value) in values.iter_mut().enumerate() {
            *value = line.value(|tap| read(start + tap * inner + i));
        }
    };
    parallel(|| out.par_chunks_mut(inner).with_min_len(least).enumerate().for_each(fill));
    out
}

/// Whether the new axes run along the old ones, in the same order, as far as the grid reaches.
fn is_diagonal(linear: DMat3, dims: [usize; 3]) -> bool {
    let drift = |axis: usize, other: usize| (linear.col(axis)[other] * dims[axis] as f64).abs();
    (0..3).all(|axis| (0..3).all(|other| axis == other || drift(axis, other) < TOLERANCE))
}

fn contains(grid: &Grid, index: DVec3) -> bool {
    let (low, high) = grid.index_bounds();
    index.cmpge(low - TOLERANCE).all() && index.cmple(high + TOLERANCE).all()
}

/// Voxels that coincide must not be missed by the rounding of the affines.
fn snap(x: f64) -> f64 {
    if (x - x.round()).abs() < TOLERANCE { x.round() } else { x }
}

fn index_of([nx, ny, _]: [usize; 3], i: usize) -> DVec3 {
    DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / (nx * ny)) as f64)
}

/// The values of all components, interleaved and in the type of `like`.
fn interleave<T: Voxel>(_like: &[T], values: &[Vec<f64>]) -> Voxels {
    let components = values.len();
    let value = |i: usize| T::from_f64(values[i % components][i / components]);
    parallel(|| (0..components * values[0].len()).into_par_iter().map(value).collect::<Vec<T>>()).into()
}
