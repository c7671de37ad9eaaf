//! Nodes where they are needed: a piecewise linear map from data values to positions among the nodes of a table.
//!
//! Transfer functions are curves through control points. Evenly spaced nodes round their corners, miss what is narrower
//! than two of them and turn jumps into ramps; nodes *at* the control points do not, however close those are.

use std::sync::Arc;

use crate::curves::Curves;

/// A value at which there is a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Break {
    /// Where the curves are evaluated.
    pub value: f64,
    /// The same as look-ups see it.
    pub address: f32,
    /// Whether the curves jump here, from the break before, which is the number just below.
    pub is_jump: bool,
}

/// Evenly spaced cells between any two neighbouring breaks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Knots {
    breaks: Vec<Break>,
    /// The number of the node at every break.
    nodes: Vec<usize>,
    /// For every break its address, its node and the nodes per data unit behind it; a power of two of them.
    rows: Vec<[f32; 4]>,
}

impl Knots {
    /// The largest table: one node per level of 16-bit data.
    pub const MOST_NODES: usize = 65_536;

    /// So many cells behind each break but the last; `None` unless there are two breaks, and all of it fits in `f32`.
    pub fn new(breaks: Vec<Break>, cells: &[usize]) -> Option<Arc<Self>> {
        let (first, last) = (breaks.first()?, breaks.last()?);
        if breaks.len() < 2 || !(last.address - first.address).is_finite() {
            return None;
        }
        let mut nodes = vec![0];
        let mut rows = Vec::new();
        for (pair, &cells) in breaks.windows(2).zip(cells) {
            let width = f64::from(pair[1].address - pair[0].address);
            // So few that their number per data unit is finite.
            let cells = cells.min((width * 1e38) as usize).max(1);
            // A little less, so that no value below the next break rounds to beyond its node.
            const ROUNDING: f64 = 1.0 - 1.0 / (1 << 22) as f64;
            let node = nodes[nodes.len() - 1];
            rows.push([pair[0].address, node as f32, (cells as f64 / width * ROUNDING) as f32, 0.0]);
            nodes.push(node + cells);
        }
        let end = nodes[nodes.len() - 1];
        if end >= Self::MOST_NODES {
            return None;
        }
        // Behind the last break nothing changes; the slope keeps differences that overflow from being no numbers.
        rows.push([last.address, end as f32, f32::MIN_POSITIVE, 0.0]);
        rows.resize(rows.len().next_power_of_two(), [f32::MAX, end as f32, f32::MIN_POSITIVE, 0.0]);
        Some(Arc::new(Self { breaks, nodes, rows }))
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.nodes[self.nodes.len() - 1] + 1
    }

    /// Data values of the first and the last node.
    pub fn domain(&self) -> [f64; 2] {
        [self.breaks[0].value, self.breaks[self.breaks.len() - 1].value]
    }

    /// What look-ups search.
    pub fn rows(&self) -> &[[f32; 4]] {
        &self.rows
    }

    /// The data value of a node.
    pub fn value(&self, node: usize) -> f64 {
        let i = self.nodes.partition_point(|&first| first <= node).saturating_sub(1).min(self.nodes.len() - 2);
        let t = (node - self.nodes[i]) as f64 / (self.nodes[i + 1] - self.nodes[i]) as f64;
        self.breaks[i].value * (1.0 - t) + self.breaks[i + 1].value * t
    }

    /// The position of a value among the nodes; below 0 before the first.
    #[inline]
    pub fn position(&self, value: f32) -> f32 {
        let (mut at, mut step) = (0, self.rows.len() / 2);
        while step > 0 {
            if value >= self.rows[at + step][0] {
                at += step;
            }
            step /= 2;
        }
        let [address, node, slope, _] = self.rows[at];
        (value - address) * slope + node
    }
}

/// The number below another, far enough for one over their distance to be finite.
fn below(address: f32) -> f32 {
    address.next_down().min(address - f32::MIN_POSITIVE)
}

/// Breaks at these values, ascending, and at both ends of an interval, as far as they lie in it and are different
/// numbers in single precision; two where a curve jumps.
pub(crate) fn breaks(curves: Curves, values: &[f64], [low, high]: [f64; 2]) -> Vec<Break> {
    let inside = values.iter().copied().filter(|value| (low..=high).contains(value));
    let mut breaks: Vec<Break> = Vec::new();
    for value in std::iter::once(low).chain(inside).chain([high]) {
        let address = value as f32;
        if let Some(last) = breaks.last_mut()
            && address - last.address < f32::MIN_POSITIVE
        {
            // The upper side of what single precision cannot tell apart.
            last.value = last.value.max(value);
        } else {
            breaks.push(Break { value, address, is_jump: false });
        }
    }
    let mut with_jumps: Vec<Break> = Vec::with_capacity(breaks.len());
    for here in breaks {
        let address = below(here.address);
        let before = Break { value: f64::from(address), address, is_jump: false };
        // What rounds to a control point counts as being there.
        let upper = here.value.max(f64::from(here.address));
        let is_jump = curves.differ(before.value, upper);
        if is_jump && with_jumps.last().is_none_or(|last| before.address - last.address >= f32::MIN_POSITIVE) {
            with_jumps.push(before);
        }
        // Elsewhere the curve is what it is at the point itself: where it is 0, nothing is to be seen.
        let value = if is_jump { upper } else { here.value };
        with_jumps.push(Break { value, is_jump, ..here });
    }
    with_jumps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Color, ColorPoint, OpacityPoint, TransferFunction};

    fn curve(points: &[(f64, f32)]) -> TransferFunction {
        let points = points.iter().map(|&(value, opacity)| OpacityPoint::new(value, opacity)).collect();
        TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], points).unwrap()
    }

    #[test]
    fn positions_are_nodes_at_breaks_and_never_beyond_them_before() {
        for values in [[0.5, 1.0, 1.5, 1e6], [-1e-30, 0.0, 1e-30, 1.0], [29_999.0, 30_000.0, 30_000.01, 30_040.0]] {
            let tf = curve(&values.map(|value| (value, 0.5)));
            let breaks = breaks(Curves::of(&tf), &values, [values[0], values[3]]);
            let addresses: Vec<f32> = breaks.iter().map(|b| b.address).collect();
            let knots = Knots::new(breaks, &[7, 16_000, 64]).unwrap();
            for (address, node) in addresses.iter().zip([0.0, 7.0, 16_007.0, 16_071.0]) {
                assert_eq!(knots.position(*address), node, "{values:?}");
                assert!(node == 0.0 || knots.position(address.next_down()) <= node, "{values:?} at {node}");
            }
            assert!(knots.position(values[0] as f32 - 1.0) < 0.0);
            for node in 0..knots.count() {
                let found = knots.position(knots.value(node) as f32);
                // Single precision has no number for each of 16,000 nodes between close values.
                let resolution = 16_000.0 * f32::EPSILON as f64 * values[2].abs() / (values[2] - values[1]);
                assert!((f64::from(found) - node as f64).abs() < 1e-2 + resolution, "{values:?}: {node} at {found}");
            }
        }
    }

    #[test]
    fn jumps_are_between_two_numbers_that_are_neighbours() {
        for at in [0.0, 0.1, 0.7, -3.0, 1e-37, 1e30] {
            let tf = curve(&[(at, 0.0), (at, 1.0)]);
            let breaks = breaks(Curves::of(&tf), &[at], [at - 1.0, at + at.abs().max(1.0)]);
            let upper = breaks.iter().find(|b| b.is_jump).unwrap();
            assert_eq!((upper.address, tf.opacity(upper.value)), (at as f32, 1.0));
            let lower = breaks.iter().rfind(|b| b.address < upper.address).unwrap();
            assert_eq!((lower.address, tf.opacity(lower.value)), (below(at as f32), 0.0));
        }
    }
}
