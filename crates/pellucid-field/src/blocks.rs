//! Smallest and largest values of blocks of cells, for skipping what cannot be seen.

use glam::DVec3;
use rayon::prelude::*;

use crate::{FieldError, Volume, Voxel, for_voxels, parallel};

/// The range of data values in every block of a volume (7.3-6, 8.4-1).
///
/// Block b covers the cells `b * size .. (b + 1) * size` along an axis, so the voxels
/// `b * size ..= (b + 1) * size`, widened by `reach` voxels on either side: whatever is
/// reconstructed inside the block from a filter of that reach is made of these voxels alone. At
/// the borders of the grid the blocks end with it. Ranges are of one component and of finite
/// values only.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    dims: [usize; 3],
    size: usize,
    reach: usize,
    ranges: Vec<[f32; 2]>,
}

impl Blocks {
    /// The usual number of cells per axis: blocks are one eighth of the data (7.3-6).
    pub const CELLS: usize = 8;

    /// The range of a block without a single finite value: lowest above highest.
    pub const ABSENT: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

    /// The blocks of one component of a volume, `size` cells per axis. `reach` is the number of
    /// voxels that the filter needs beyond the eight around a position: 0 for trilinear, 1 for
    /// cubic, n - 1 for half width n; 1 more with central differences.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if the size is 0 or there is no such component.
    pub fn new(volume: &Volume, component: usize, size: usize, reach: usize) -> Result<Self, FieldError> {
        if size == 0 {
            return Err(FieldError::Parameter { name: "block size", found: 0.0, expected: "at least 1 cell" });
        }
        volume.check_component(component)?;
        let dims = volume.grid().dims().map(|n| (n - 1).max(1).div_ceil(size));
        let mut blocks = Self { dims, size, reach, ranges: vec![Self::ABSENT; dims.iter().product()] };
        for_voxels!(volume.voxels(), data => blocks.fill(data, volume, component));
        Ok(blocks)
    }

    /// The same blocks for a filter whose samples leave the range of their voxels by up to a share of
    /// it on either side ([`Filter::overshoot`](crate::Filter::overshoot)).
    pub fn overshot(&self, share: f64) -> Self {
        let overshot = |&[low, high]: &[f32; 2]| {
            let [a, b] = [f64::from(low), f64::from(high)];
            let beyond = share * (b - a);
            if low > high { Self::ABSENT } else { [round_down(a - beyond), -round_down(-b - beyond)] }
        };
        Self { ranges: self.ranges.iter().map(overshot).collect(), ..*self }
    }

    /// Blocks per axis.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Cells per block and axis.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Lowest and highest data value of every block, x fastest, or [`Blocks::ABSENT`]. Values that
    /// are no `f32` are rounded outwards.
    pub fn ranges(&self) -> &[[f32; 2]] {
        &self.ranges
    }

    /// Lowest and highest data value of a block; `None` if all of its values are absent.
    ///
    /// # Panics
    /// If the block is out of range.
    pub fn range(&self, [x, y, z]: [usize; 3]) -> Option<[f32; 2]> {
        let [nx, ny, nz] = self.dims;
        assert!(x < nx && y < ny && z < nz);
        let range = self.ranges[x + nx * (y + ny * z)];
        (range != Self::ABSENT).then_some(range)
    }

    /// The range of values interpolated in a block whose voxels have this one, with room for rounding;
    /// exact where all voxels are equal.
    pub fn interpolated([low, high]: [f32; 2]) -> [f32; 2] {
        let room = if low < high { 1e-6 * low.abs().max(high.abs()) } else { 0.0 };
        [low - room, high + room]
    }

    /// The block a position in index space lies in; outside the grid, the nearest one.
    pub fn block_at(&self, index: DVec3) -> [usize; 3] {
        [0, 1, 2].map(|axis| ((index[axis] / self.size as f64).max(0.0) as usize).min(self.dims[axis] - 1))
    }

    /// First and last voxel of block `b` along an axis of n voxels.
    fn voxels(&self, b: usize, n: usize) -> (usize, usize) {
        ((b * self.size).saturating_sub(self.reach), ((b + 1) * self.size).saturating_add(self.reach).min(n - 1))
    }

    /// Run by run of blocks in a row: first the range of all rows of voxels that belong to it, sample by
    /// sample, which is a straight run through memory; then along the run.
    fn fill<T: Voxel>(&mut self, data: &[T], volume: &Volume, component: usize) {
        let grid = volume.grid();
        let ([nx, ny, nz], components) = (grid.dims(), volume.components());
        let ([bx, by, _], map) = (self.dims, volume.value_map());
        let (lowest, highest) = (T::from_f64(f64::NEG_INFINITY), T::from_f64(f64::INFINITY));
        let mut ranges = std::mem::take(&mut self.ranges);
        let fill = |(row, first, ranges): (usize, usize, &mut [[f32; 2]])| {
            let (from, to) = (self.voxels(first, nx).0, self.voxels(first + ranges.len() - 1, nx).1 + 1);
            let length = (to - from) * components;
            let (mut low, mut high) = (vec![highest; length], vec![lowest; length]);
            let ((y0, y1), (z0, z1)) = (self.voxels(row % by, ny), self.voxels(row / by, nz));
            for (z, y) in (z0..=z1).flat_map(|z| (y0..=y1).map(move |y| (z, y))) {
                let start = grid.linear_index([from, y, z]) * components;
                widen(&mut low, &mut high, &data[start..start + length]);
            }
            for (b, range) in ranges.iter_mut().enumerate() {
                let (x0, x1) = self.voxels(first + b, nx);
                let (mut least, mut most) = (highest, lowest);
                for x in x0..=x1 {
                    let i = (x - from) * components + component;
                    least = if low[i] < least { low[i] } else { least };
                    most = if high[i] > most { high[i] } else { most };
                }
                if least <= most {
                    let (a, b) = (map.value(least.to_f64()), map.value(most.to_f64()));
                    *range = [round_down(a.min(b)), -round_down(-a.max(b))];
                }
            }
        };
        let runs = ranges.par_chunks_mut(bx).enumerate().flat_map(|(row, ranges)| {
            ranges.par_chunks_mut(RUN).enumerate().map(move |(run, ranges)| (row, run * RUN, ranges))
        });
        parallel(|| runs.for_each(fill));
        self.ranges = ranges;
    }
}

/// Blocks whose voxels are looked at together; a longer row is cut, so that it costs no more memory than others.
const RUN: usize = 512;

/// Widens ranges by the finite ones of some values.
fn widen<T: Voxel>(low: &mut [T], high: &mut [T], values: &[T]) {
    for ((low, high), &value) in low.iter_mut().zip(high).zip(values) {
        let finite = T::TYPE.is_integer() || value.to_f32().is_finite();
        *low = if finite && value < *low { value } else { *low };
        *high = if finite && value > *high { value } else { *high };
    }
}

/// The largest `f32` that is not above a value.
fn round_down(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) > value { near.next_down() } else { near }
}
