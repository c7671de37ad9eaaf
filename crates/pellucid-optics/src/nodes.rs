//! Where the entries of a table are: nodes over an interval of data values.

use std::sync::Arc;

use pellucid_field::Volume;

use crate::OpticsError;
use crate::error::checked;
use crate::knots::Knots;

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

    /// This range, as far as it takes to reach from `low` to `high`: by whole levels, if there are levels. Filters that
    /// overshoot make values that no voxel has.
    pub fn reaching(self, low: f64, high: f64) -> Self {
        let [below, above] = [(self.low - low).max(0.0), (high - self.high).max(0.0)];
        let whole = |distance: f64| match self.level_spacing {
            Some(spacing) if spacing > 0.0 => (distance / spacing).ceil() * spacing,
            _ => distance,
        };
        Self { low: self.low - whole(below), high: self.high + whole(above), ..self }
    }
}

/// Nodes over an interval of data values, evenly spaced or where a transfer function needs them. Even node i of n is
/// at `low + i / (n - 1) * (high - low)`: the first and the last node are *at* the ends, so a table
/// indexed by the plain fraction times n would be off by up to half a node (4.1-4).
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    domain: [f64; 2],
    count: usize,
    origin: f32,
    scale: f32,
    /// Where they are, if not even.
    knots: Option<Arc<Knots>>,
}

impl Nodes {
    /// The largest table: one node per level of 16-bit data.
    pub const MOST: usize = Knots::MOST_NODES;
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
        Ok(Self { domain, count, origin: domain[0] as f32, scale, knots: None })
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
        if let Some(knots) = &self.knots {
            return knots.value(node);
        }
        let t = node as f64 / (self.count - 1) as f64;
        // This form is exact at both ends.
        self.domain[0] * (1.0 - t) + self.domain[1] * t
    }

    /// The data value that is at position 0, in the precision of look-ups.
    pub fn origin(&self) -> f32 {
        self.origin
    }

    /// Nodes per data unit, where they are even: the position of a value is then `(value - origin) * scale`. Where they
    /// are not, as many over the same domain would have this scale.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Nothing where nodes are even. Otherwise rows of a data value, the position there, and nodes per data unit from
    /// there on, ascending; their number is a power of two. The position of a value is
    /// `(value - row[0]) * row[2] + row[1]` by the last row whose value is not larger, or the first.
    pub fn knots(&self) -> &[[f32; 4]] {
        self.knots.as_ref().map_or(&[], |knots| knots.rows())
    }

    /// The first and the last node's data value, in the precision of look-ups.
    #[inline(always)]
    pub fn ends(&self) -> [f32; 2] {
        self.domain.map(|end| end as f32)
    }

    /// The position of a value among the nodes; below 0 before the domain, and `count - 1` or more behind it.
    #[inline(always)]
    pub fn position(&self, value: f32) -> f32 {
        if let Some(knots) = &self.knots {
            return knots.position(value);
        }
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

impl From<Arc<Knots>> for Nodes {
    fn from(knots: Arc<Knots>) -> Self {
        let (domain, count) = (knots.domain(), knots.count());
        let scale = ((count - 1) as f64 / (domain[1] - domain[0])) as f32;
        let scale = if scale.is_finite() { scale } else { 0.0 };
        Self { domain, count, origin: domain[0] as f32, scale, knots: Some(knots) }
    }
}
