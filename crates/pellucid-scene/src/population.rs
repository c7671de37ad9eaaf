//! How the values of a component are distributed: what automatic looks and windows are made from.
//!
//! Everything is a share of the values, never of their range: one hot voxel moves a range as far as it likes, and a
//! share by nothing.

use pellucid_field::{Volume, parallel};
use rayon::prelude::*;

/// The finite data values of a component in order, or enough of them to tell shares of a thousandth.
pub struct Population {
    values: Vec<f64>,
    /// Distance of neighbouring levels where the data are integers.
    level: Option<f64>,
}

/// What rays meet where there is nothing, as far as the values tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backdrop {
    /// The commonest value is a low one: what is above it is something.
    Below(f64),
    /// The commonest value is a high one: what is below it is something.
    Above(f64),
    /// Values deviate from this one to both sides.
    Between(f64),
    /// No value stands out.
    None,
}

/// Most values that are looked at one by one.
const MOST: usize = 1 << 18;

impl Population {
    /// That of a component; of very many voxels, of some spread evenly over them.
    pub fn of(volume: &Volume, component: usize) -> Self {
        Self::of_some(volume, component, MOST)
    }

    /// That of so many voxels, where there are more.
    pub fn of_some(volume: &Volume, component: usize, most: usize) -> Self {
        let (voxels, components, map) = (volume.voxels(), volume.components(), volume.value_map());
        let total = volume.grid().len();
        let (stride, count) = if total <= most { (1, total) } else { (stride(total), most) };
        let value = |k: usize| {
            let voxel = (k as u128 * stride as u128 % total as u128) as usize;
            map.value(voxels.get(voxel * components + component))
        };
        let values = parallel(|| {
            let there = (0..count).into_par_iter().map(value).filter(|value| value.is_finite());
            let mut values: Vec<f64> = there.collect();
            values.par_sort_unstable_by(f64::total_cmp);
            values
        });
        let level = voxels.voxel_type().is_integer().then_some(map.scale.abs());
        Self { values, level }
    }

    /// The values, ascending.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The share of values from `low` to `high`, ends included.
    pub fn share(&self, low: f64, high: f64) -> f64 {
        let (from, to) = (self.values.partition_point(|v| *v < low), self.values.partition_point(|v| *v <= high));
        to.saturating_sub(from) as f64 / self.values.len().max(1) as f64
    }

    /// The value below which a share of the values is.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let last = self.values.len().checked_sub(1)?;
        Some(self.values[(share * last as f64).round() as usize])
    }

    /// The ends of all values but outliers.
    pub fn ends(&self) -> Option<[f64; 2]> {
        let (first, last) = (*self.values.first()?, *self.values.last()?);
        let middle = self.quantile(0.5)?;
        let split = self.values.partition_point(|v| *v <= middle);
        let below: Vec<f64> = self.values[..split].iter().rev().map(|v| middle - v).collect();
        let above: Vec<f64> = self.values[split..].iter().map(|v| v - middle).collect();
        // A side of one value has no outliers but itself.
        let low = top(&below).map_or(first, |reach| middle - reach);
        Some([low, top(&above).map_or(last.min(middle), |reach| middle + reach)])
    }

    /// The commonest value and its share, where values that no eye tells apart count as one.
    pub fn commonest(&self) -> Option<(f64, f64)> {
        const BINS: usize = 256;
        let (low, high) = (self.quantile(0.001)?, self.quantile(0.999)?);
        let width = ((high - low) / BINS as f64).max(self.level.unwrap_or(0.0));
        if width <= 0.0 {
            return Some((low, self.share(low, low)));
        }
        let edge = |bin: usize| self.values.partition_point(|v| *v < low + (bin as f64 - 0.5) * width);
        let (mut from, mut to) = (0, 0);
        for bin in 0..=BINS {
            let (first, end) = (edge(bin), edge(bin + 1));
            if end.saturating_sub(first) > to - from {
                (from, to) = (first, end);
            }
        }
        // The middle one of a bin full of one value is that value.
        let value = self.values.get((from + to) / 2)?;
        Some((*value, (to - from) as f64 / self.values.len() as f64))
    }

    /// What rays meet where there is nothing.
    pub fn backdrop(&self) -> Backdrop {
        let (Some((common, share)), Some([low, high])) = (self.commonest(), self.ends()) else { return Backdrop::None };
        if low >= high {
            return Backdrop::None;
        }
        let near = (high - low) / 256.0;
        // Noise of a background lies on both sides of it, and so do the ripples that resampling leaves along edges. An
        // exact background has no noise.
        let least = if self.share(common, common) > 0.1 { 0.1 } else { 0.3 };
        let sides = |neutral: f64| {
            let (above, below) = (self.typical(neutral, near, 1.0), self.typical(neutral, near, -1.0));
            let (reach, count) = ([above.0, below.0], [above.1, below.1]);
            reach[0].min(reach[1]) > least * reach[0].max(reach[1])
                && count[0].min(count[1]) > 0.02 * count[0].max(count[1])
        };
        let signed = low < 0.0 && high > 0.0;
        let is_zero = common.abs() <= 2.0 * near;
        if signed && is_zero && sides(0.0) {
            return Backdrop::Between(0.0);
        }
        // Deviations from a state that fills most of space, as far from it on both sides.
        if self.level.is_none() && share > 0.3 && sides(common) {
            return Backdrop::Between(common);
        }
        if signed && self.level.is_none() && share < 0.1 && sides(0.0) {
            return Backdrop::Between(0.0);
        }
        match common - low < high - common {
            true => Backdrop::Below(common),
            false if share > 0.3 => Backdrop::Above(common),
            false => Backdrop::None,
        }
    }

    /// Whether values are CT numbers by what they are (-1000 in air, 0 in water): air outside, tissue within, and less
    /// in between, with nothing that a scanner does not give.
    pub fn is_like_hounsfield(&self) -> bool {
        let (Some(least), Some(most)) = (self.values.first(), self.values.last()) else { return false };
        if *least > -900.0 || *most < 200.0 || self.share(f64::NEG_INFINITY, -3100.0) > 0.001 {
            return false;
        }
        // Deviations from nothing may reach as far.
        if matches!(self.backdrop(), Backdrop::Between(_)) {
            return false;
        }
        let per_unit = |low: f64, high: f64| self.share(low, high) / (high - low);
        let [air, lung, tissue] = [[-1100.0, -850.0], [-750.0, -300.0], [-200.0, 300.0]].map(|[a, b]| per_unit(a, b));
        // Integers from air to bone are hardly anything else, whatever part of a patient they show.
        self.level.is_some() || (air * 250.0 > 0.01 && tissue * 500.0 > 0.01 && lung < 0.5 * air.min(tissue))
    }

    /// How far values lie from another one on a side, all but the farthest hundredth, and the number of them.
    fn typical(&self, from: f64, near: f64, side: f64) -> (f64, f64) {
        let beyond = self.beyond(from, near, side);
        let Some(last) = beyond.len().checked_sub(1) else { return (0.0, 0.0) };
        (beyond[(0.99 * last as f64) as usize], beyond.len() as f64)
    }

    /// Distances, ascending, of the values more than `near` from another one on the side of a sign.
    fn beyond(&self, from: f64, near: f64, side: f64) -> Vec<f64> {
        if side > 0.0 {
            let first = self.values.partition_point(|v| *v <= from + near);
            self.values[first..].iter().map(|v| v - from).collect()
        } else {
            let end = self.values.partition_point(|v| *v < from - near);
            self.values[..end].iter().rev().map(|v| from - v).collect()
        }
    }

    /// How far values reach from another one on the side of a sign, but for outliers; `None` if there are none there.
    pub fn reach(&self, from: f64, side: f64) -> Option<f64> {
        top(&self.beyond(from, 0.0, side))
    }
}

/// The largest of ascending distances from a background but for outliers: the farthest thousandth, and few that lie
/// twice as far as all others, with nothing between. What is above it is drawn as it is.
fn top(distances: &[f64]) -> Option<f64> {
    let n = distances.len();
    let last = n.checked_sub(1)?;
    let lonely = match n {
        0..16 => 0,
        16..64 => 1,
        _ => (n / 100).max(4),
    };
    let gap = (0..lonely)
        .rev()
        .find(|k| distances[last - k] > 2.0 * distances[last - k - 1] && distances[last - k - 1] > 0.0);
    let rest = gap.map_or(last, |k| last - k - 1);
    Some(distances[rest.min(last - n / 1000)])
}

/// The step from voxel to voxel of a sample: the golden section of their number, whose multiples spread evenly
/// (Knuth, The Art of Computer Programming, 6.4), and which is no divisor of rows and slices.
fn stride(total: usize) -> usize {
    let gcd = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let golden = (total as f64 * 0.618_033_988_749_895) as usize;
    (golden..total).find(|step| gcd(*step, total) == 1).unwrap_or(1)
}
