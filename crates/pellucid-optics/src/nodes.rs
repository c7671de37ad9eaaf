//! Where the entries of a table are: evenly spaced nodes over an interval of data values.

use pellucid_field::Volume;

use crate::error::checked;
use crate::{OpticsError, TransferFunction};

/// What a table has to know of the data it is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataRange {
    /// Smallest data value.
    pub low: f64,
    /// Largest data value.
    pub high: f64,
    /// Distance of neighbouring levels in data units where the data are integers; `low` is one.
    pub level_spacing: Option<f64>,
}

impl DataRange {
    /// The range of a volume's values, and the spacing of its levels if it stores integers.
    pub fn of(volume: &Volume) -> Self {
        let statistics = volume.statistics();
        let is_integer = volume.voxels().voxel_type().is_integer();
        let level_spacing = is_integer.then(|| volume.value_map().scale.abs());
        Self { low: statistics.min, high: statistics.max, level_spacing }
    }
}

/// Evenly spaced nodes over an interval of data values. Node i of n is at
/// `low + i / (n - 1) * (high - low)`: the first and the last node are *at* the ends, so a table
/// indexed by the plain fraction times n would be off by up to half a node (4.1-4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nodes {
    domain: [f64; 2],
    count: usize,
    origin: f32,
    scale: f32,
}

impl Nodes {
    /// The largest table: one node per level of 16-bit data.
    pub const MOST: usize = 65_536;
    /// The smallest table that is chosen for data: what 8-bit data need.
    pub const FEWEST: usize = 256;

    /// `count` nodes over `domain`. An interval of no width has all its nodes at one value.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] unless the ends are finite as 32-bit floats and do not descend;
    /// [`OpticsError::Parameter`] unless there are 2 to 65,536 nodes.
    pub fn new(domain: [f64; 2], count: usize) -> Result<Self, OpticsError> {
        checked("number of table entries", count as f64, 2.0..=Self::MOST as f64, "2 to 65,536")?;
        let width = (domain[1] - domain[0]) as f32;
        let fits = domain.iter().all(|end| (*end as f32).is_finite()) && width.is_finite() && domain[0] <= domain[1];
        if !fits {
            return Err(OpticsError::Interval { name: "domain of a table", found: domain, expected: "not below" });
        }
        let scale = (count - 1) as f64 / (domain[1] - domain[0]);
        // A width of zero, or one that f32 cannot resolve: everything is at the first node.
        let scale = if (scale as f32).is_finite() { scale as f32 } else { 0.0 };
        Ok(Self { domain, count, origin: domain[0] as f32, scale })
    }

    /// Nodes that represent `tf` on this data.
    ///
    /// The domain is where the function varies on the data: its hull within the data's range,
    /// with one node beyond either end, so that a jump at the end of the hull is kept.
    ///
    /// - Integer data of up to 65,536 levels there have a node at every level, so a table is
    ///   exact at every voxel; where that makes fewer than 256 nodes, each level is subdivided
    ///   evenly.
    /// - For other data nodes are doubled from 256 until the largest deviation between table and
    ///   curve is below 1/8192, or 16,384 (256 KiB: in second-level cache) are reached; then a peak
    ///   as narrow as 0.5 % of the domain is off by 0.005. Four times as many would bring that to
    ///   0.001 and make random look-ups half as slow again (`examples/measure_tables.rs`). A jump has such an error at any size and
    ///   asks for the most: it becomes a ramp of 1/16,383 of the domain.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] if the data's range is not finite.
    pub fn for_data(tf: &TransferFunction, data: &DataRange) -> Result<Self, OpticsError> {
        let range = [data.low, data.high];
        if !(data.low <= data.high && data.low.is_finite() && data.high.is_finite()) {
            return Err(OpticsError::Interval { name: "range of the data", found: range, expected: "not below" });
        }
        let hull = tf.hull().map(|end| end.clamp(data.low, data.high));
        match data.level_spacing {
            Some(spacing) if spacing > 0.0 => Self::at_levels(hull, range, spacing),
            _ => None,
        }
        .map_or_else(|| Self::by_error(tf, hull, range), Ok)
    }

    /// A node at every level of integer data, if they are few enough.
    fn at_levels(hull: [f64; 2], range: [f64; 2], spacing: f64) -> Option<Self> {
        // Levels counted from the lowest data value, which is one of them.
        let last = ((range[1] - range[0]) / spacing).round();
        // The tolerance counts an end that is on a level, but for rounding, as being on it.
        let first_needed = (((hull[0] - range[0]) / spacing - 1e-6).ceil() - 1.0).max(0.0);
        let last_needed = (((hull[1] - range[0]) / spacing + 1e-6).floor() + 1.0).min(last);
        let steps = last_needed - first_needed;
        if steps + 1.0 > Self::MOST as f64 {
            return None;
        }
        let steps = (steps as usize).max(1);
        let subdivision = (Self::FEWEST - 1).div_ceil(steps);
        let low = range[0] + first_needed * spacing;
        Self::new([low, low + steps as f64 * spacing], steps * subdivision + 1).ok()
    }

    fn by_error(tf: &TransferFunction, hull: [f64; 2], range: [f64; 2]) -> Result<Self, OpticsError> {
        const TOLERANCE: f32 = 1.0 / 8192.0;
        const MOST: usize = 16_384;
        let mut count = if tf.jumps() { MOST } else { Self::FEWEST };
        loop {
            let pad = (hull[1] - hull[0]) / (count - 3) as f64;
            let domain = if pad > 0.0 { [hull[0] - pad, hull[1] + pad] } else { range };
            let nodes = Self::new(domain, count)?;
            if count == MOST || nodes.error(tf) <= TOLERANCE {
                return Ok(nodes);
            }
            count *= 2;
        }
    }

    /// The largest deviation between the curves of `tf` and their straight lines between these
    /// nodes, looked for where it can be: at every control point and between them.
    fn error(&self, tf: &TransferFunction) -> f32 {
        let at = |value: f64| {
            let [r, g, b] = tf.color(value);
            [r, g, b, tf.opacity(value)]
        };
        let deviation = |value: f64| {
            let position = (value - self.domain[0]) / (self.domain[1] - self.domain[0]) * (self.count - 1) as f64;
            let cell = position.floor().clamp(0.0, (self.count - 2) as f64);
            let (from, to) = (at(self.value(cell as usize)), at(self.value(cell as usize + 1)));
            let t = (position - cell) as f32;
            let exact = at(value);
            (0..4).map(|c| (from[c] + (to[c] - from[c]) * t - exact[c]).abs()).fold(0.0, f32::max)
        };
        let values: Vec<f64> =
            tf.values().into_iter().filter(|value| (self.domain[0]..=self.domain[1]).contains(value)).collect();
        let between = values.windows(2).flat_map(|pair| {
            // In the dark the sRGB curve bends most near a point, hence also close to the ends.
            [0.02, 0.25, 0.5, 0.75, 0.98].map(|t| pair[0] + (pair[1] - pair[0]) * t)
        });
        let cell_centers = between.map(|value| {
            let width = (self.domain[1] - self.domain[0]) / (self.count - 1) as f64;
            self.domain[0] + (((value - self.domain[0]) / width).floor() + 0.5) * width
        });
        values.iter().copied().chain(cell_centers).map(deviation).fold(0.0, f32::max)
    }

    /// Data values of the first and the last node.
    pub fn domain(&self) -> [f64; 2] {
        self.domain
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The data value of a node.
    pub fn value(&self, node: usize) -> f64 {
        let t = node as f64 / (self.count - 1) as f64;
        // This form is exact at both ends.
        self.domain[0] * (1.0 - t) + self.domain[1] * t
    }

    /// The data value that is at position 0, in the precision of look-ups.
    pub fn origin(&self) -> f32 {
        self.origin
    }

    /// Nodes per data unit: the position of a value is `(value - origin) * scale`.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// The position of a value among the nodes; below 0 or above `count - 1` outside the domain.
    #[inline(always)]
    pub fn position(&self, value: f32) -> f32 {
        // Not fused into value * scale + bias: the difference is exact near the origin, whatever
        // the distance of the domain from 0.
        (value - self.origin) * self.scale
    }

    /// [`position`](Self::position), limited to the nodes there are; 0 for NaN.
    #[inline(always)]
    pub fn clamped_position(&self, value: f32) -> f32 {
        self.position(value).max(0.0).min((self.count - 1) as f32)
    }

    /// The node below a position in `0..=count - 1` and the fraction towards the next one.
    #[inline(always)]
    pub(crate) fn cell(&self, position: f32) -> (usize, f32) {
        // By way of i32: processors convert to signed numbers in one instruction.
        let node = (position as i32 as usize).min(self.count - 2);
        (node, position - node as i32 as f32)
    }
}
