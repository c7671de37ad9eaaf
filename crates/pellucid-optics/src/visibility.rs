//! Whether, and how much, an interval of data values is visible: what skipping empty space asks
//! of a block's minimum and maximum (7.3-6).

use crate::maxima::Maxima;
use crate::{Nodes, Table, TransferFunction};

/// Largest opacity over any interval of data values, in constant time.
#[derive(Clone, Debug)]
pub struct Visibility {
    nodes: Nodes,
    /// Of the opacities of all nodes.
    maxima: Maxima,
}

impl Visibility {
    /// For what look-ups in `table`, or in a step table made from it, can return. An interval
    /// has no opacity here exactly if no look-up in it returns any.
    pub fn of_table(table: &Table) -> Self {
        let opacities = table.entries().iter().map(|entry| entry[3]).collect();
        Self::new(table.nodes().clone(), opacities)
    }

    /// For segments whose ends lie in the interval: peaks between nodes count too. An interval
    /// without opacity here has none in pre-integrated look-ups; the reverse holds up to the
    /// distance of two nodes.
    pub fn of_segments(tf: &TransferFunction, nodes: &Nodes) -> Self {
        let mut peaks: Vec<f32> = (0..nodes.count()).map(|node| tf.opacity(nodes.value(node))).collect();
        // Between control points the curve is monotone, so cells need only their points.
        let domain = nodes.domain();
        for point in tf.opacities().iter().filter(|point| (domain[0]..=domain[1]).contains(&point.value)) {
            let (node, _) = nodes.cell(nodes.clamped_position(point.value as f32));
            // The neighbours too: rounding may put a value on either side of a node.
            let cells = node.saturating_sub(1)..=(node + 2).min(nodes.count() - 1);
            peaks[cells].iter_mut().for_each(|peak| *peak = peak.max(point.opacity));
        }
        Self::new(nodes.clone(), peaks)
    }

    fn new(nodes: Nodes, opacities: Vec<f32>) -> Self {
        Self { nodes, maxima: Maxima::new(opacities) }
    }

    /// An upper bound of the opacity per unit distance over the values from `low` to `high`; it
    /// includes the nodes on either side. Zero if the interval is empty or NaN.
    pub fn max_opacity(&self, low: f32, high: f32) -> f32 {
        if low.is_nan() || high.is_nan() || low > high {
            return 0.0;
        }
        let first = self.nodes.clamped_position(low).floor() as usize;
        let last = self.nodes.clamped_position(high).ceil() as usize;
        self.maxima.over(first, last)
    }

    /// Whether values from `low` to `high` can have any opacity. False is a proof: no look-up of
    /// a value in the interval returns opacity.
    pub fn any_opacity(&self, low: f32, high: f32) -> bool {
        self.max_opacity(low, high) > 0.0
    }
}
