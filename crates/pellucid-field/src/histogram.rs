//! How often data values occur.

use rayon::prelude::*;

use crate::{FieldError, Volume, Voxel, for_voxels, parallel};

/// Counts of the finite data values of one component in bins of equal width: what automatic
/// windows are made from.
///
/// Bin i holds the values from `low + i * width` up to, but without, `low + (i + 1) * width`; the
/// last bin includes its upper end.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    low: f64,
    width: f64,
    counts: Vec<u64>,
    absent: u64,
    /// Whether all values of a bin are the one in its middle.
    levels: bool,
}

impl Histogram {
    /// Bins that serve most purposes.
    pub const BINS: usize = 256;

    /// Counts the values of a component in `bins` bins between its lowest and highest finite
    /// value; around a single value if they are the same.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if there are no bins or there is no such component.
    pub fn new(volume: &Volume, component: usize, bins: usize) -> Result<Self, FieldError> {
        volume.check_component(component)?;
        if bins == 0 {
            return Err(FieldError::Parameter { name: "bins", found: 0.0, expected: "at least 1" });
        }
        let (low, high) = for_voxels!(volume.voxels(), data => range(data, volume, component));
        let (low, high) = match (low, high) {
            _ if low > high => (0.0, 1.0),
            // Wide enough that the ends differ from the value whatever its magnitude.
            _ if low == high => (low - low.abs().max(1.0) * 0.5, high + high.abs().max(1.0) * 0.5),
            range => range,
        };
        let width = (high - low) / bins as f64;
        let mut histogram = Self { low, width, counts: vec![], absent: 0, levels: false };
        let map = volume.value_map();
        for_voxels!(volume.voxels(), data => {
            histogram.count(data, volume, component, bins, |stored| ((map.value(stored) - low) / width) as usize)
        });
        Ok(histogram)
    }

    /// Counts every level of an 8 or 16 bit integer volume by itself, from the lowest one that
    /// occurs to the highest: the data value of a level is the middle of its bin. `None` for other
    /// types and if there is no such component.
    pub fn of_levels(volume: &Volume, component: usize) -> Option<Self> {
        let kind = volume.voxels().voxel_type();
        if !kind.is_integer() || kind.size() > 2 || component >= volume.components() {
            return None;
        }
        let map = volume.value_map();
        let (low, high) = for_voxels!(volume.voxels(), data => range(data, volume, component));
        let width = map.scale.abs();
        let bins = ((high - low) / width).round() as usize + 1;
        let (ends, up) = ((map.stored(low).round(), map.stored(high).round()), map.scale > 0.0);
        let mut histogram = Self { low: low - width / 2.0, width, counts: vec![], absent: 0, levels: true };
        for_voxels!(volume.voxels(), data => {
            histogram.count(data, volume, component, bins, |stored| {
                (if up { stored - ends.0 } else { ends.0 - stored }) as usize
            })
        });
        Some(histogram)
    }

    /// Values per bin.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Lower end of the first bin and upper end of the last, in data values.
    pub fn range(&self) -> (f64, f64) {
        (self.low, self.edge(self.counts.len()))
    }

    /// Width of a bin, in data values.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Number of finite values.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Number of values that are not finite; they are in no bin.
    pub fn absent(&self) -> u64 {
        self.absent
    }

    /// The value of rank `q * (total - 1)`, rounded down, among the sorted finite values, q from 0 to 1
    /// (clamped): exact for [`Histogram::of_levels`], otherwise to within a bin, taking the values
    /// in it as evenly spread. `None` if there is no finite value.
    pub fn percentile(&self, q: f64) -> Option<f64> {
        let total = self.total();
        let mut rank = (q.clamp(0.0, 1.0) * total.checked_sub(1)? as f64) as u64;
        let bin = self.counts.iter().position(|&count| {
            let found = rank < count;
            rank -= if found { 0 } else { count };
            found
        })?;
        let share = if self.levels { 0.5 } else { (rank as f64 + 0.5) / self.counts[bin] as f64 };
        Some(self.edge(bin) + share * self.width)
    }

    /// Middle of the fullest bin, the lowest of several; `None` if there is no finite value.
    pub fn mode(&self) -> Option<f64> {
        let fullest = *self.counts.iter().max()?;
        let bin = self.counts.iter().position(|&count| count == fullest)?;
        (fullest > 0).then(|| self.middle(bin))
    }

    /// The threshold that divides the values into two classes with the largest variance between
    /// them (N. Otsu, "A Threshold Selection Method from Gray-Level Histograms", 1979): an edge
    /// between bins, or the middle of the empty bins between two classes. `None` if fewer than
    /// two bins are filled.
    pub fn otsu(&self) -> Option<f64> {
        let total = self.total() as f64;
        let moment = |(bin, &count): (usize, &u64)| bin as f64 * count as f64;
        let whole: f64 = self.counts.iter().enumerate().map(moment).sum();
        let (mut below, mut sum) = (0.0, 0.0);
        let (mut best, mut first, mut last) = (0.0, 0, 0);
        for (bin, count) in self.counts.iter().enumerate() {
            below += *count as f64;
            sum += moment((bin, count));
            let above = total - below;
            if below == 0.0 || above == 0.0 {
                continue;
            }
            let between = below * above * ((whole - sum) / above - sum / below).powi(2);
            if between > best {
                (best, first, last) = (between, bin + 1, bin + 1);
            } else if between == best {
                last = bin + 1;
            }
        }
        (best > 0.0).then(|| (self.edge(first) + self.edge(last)) / 2.0)
    }

    /// Data value in the middle of a bin.
    pub fn middle(&self, bin: usize) -> f64 {
        self.low + (bin as f64 + 0.5) * self.width
    }

    fn edge(&self, bin: usize) -> f64 {
        self.low + bin as f64 * self.width
    }

    /// Counts in parallel; `bin_of` is given stored numbers. Rounding may put the highest value one
    /// bin too far.
    fn count<T: Voxel>(
        &mut self,
        data: &[T],
        volume: &Volume,
        component: usize,
        bins: usize,
        bin_of: impl Fn(f64) -> usize + Sync,
    ) {
        let components = volume.components();
        let none = || (vec![0u64; bins], 0u64);
        let count = |(mut counts, mut absent): (Vec<u64>, u64), chunk: &[T]| {
            for value in chunk.iter().skip(component).step_by(components) {
                let value = value.to_f64();
                if value.is_finite() {
                    counts[bin_of(value).min(bins - 1)] += 1;
                } else {
                    absent += 1;
                }
            }
            (counts, absent)
        };
        let join = |(mut a, absent): (Vec<u64>, u64), (b, more): (Vec<u64>, u64)| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            (a, absent + more)
        };
        let chunks = || data.par_chunks(CHUNK * components);
        (self.counts, self.absent) = parallel(|| chunks().fold(none, count).reduce(none, join));
    }
}

/// Voxels per unit of parallel work: enough to make a private histogram worth its while.
const CHUNK: usize = 1 << 16;

/// Lowest and highest finite data value of a component; lowest above highest if there is none.
fn range<T: Voxel>(data: &[T], volume: &Volume, component: usize) -> (f64, f64) {
    let components = volume.components();
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    let of_chunk = |chunk: &[T]| {
        let values = chunk.iter().skip(component).step_by(components).map(|value| value.to_f64());
        values.filter(|value| value.is_finite()).fold(none, |range, value| wider(range, (value, value)))
    };
    let (low, high) = parallel(|| data.par_chunks(CHUNK * components).map(of_chunk).reduce(|| none, wider));
    if low > high {
        return none;
    }
    let (a, b) = (volume.value_map().value(low), volume.value_map().value(high));
    (a.min(b), a.max(b))
}
