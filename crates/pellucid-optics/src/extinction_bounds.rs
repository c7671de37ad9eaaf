//! Bounds of the extinction over an interval of data values: what paths of light ask of a block.

use crate::maxima::Maxima;
use crate::{Nodes, Table, path_extinction};

/// Least and largest extinction over any interval of data values, in constant time.
#[derive(Clone, Debug)]
pub struct ExtinctionBounds {
    nodes: Nodes,
    most: Maxima,
    /// Of the negative extinctions.
    least: Maxima,
}

impl ExtinctionBounds {
    /// For what look-ups in `table` can return, where opacities hold for `unit_distance` world units.
    pub fn new(table: &Table, unit_distance: f64) -> Self {
        let extinctions: Vec<f32> =
            table.entries().iter().map(|entry| path_extinction(entry[3], unit_distance)).collect();
        let negative = extinctions.iter().map(|extinction| -extinction).collect();
        Self { nodes: table.nodes().clone(), most: Maxima::new(extinctions), least: Maxima::new(negative) }
    }

    /// The least and the largest extinction per world unit of values from `low` to `high`, over the nodes on either
    /// side as well; zeros if the interval is empty or NaN.
    pub fn over(&self, low: f32, high: f32) -> [f32; 2] {
        if low.is_nan() || high.is_nan() || low > high {
            return [0.0; 2];
        }
        let first = self.nodes.clamped_position(low).floor() as usize;
        let last = self.nodes.clamped_position(high).ceil() as usize;
        // No extinction is negative: 0 has no sign.
        [-self.least.over(first, last) + 0.0, self.most.over(first, last)]
    }
}
