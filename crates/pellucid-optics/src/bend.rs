//! How far a transfer function is from a straight line: what a longer step may miss (7.3-3).

use crate::maxima::Maxima;
use crate::{Nodes, StepTable};

/// The bends of a step table, over any interval of values and at any width.
///
/// A step in the middle of a segment sees the value there; the steps it stands for see values to
/// both sides of it. Were the table straight, the differences would cancel. What does not cancel is
/// the *bend* `|f(v - w) + f(v + w) - 2 f(v)| / 2`, for values that change by w over half of the
/// segment. Unlike the book's measure, which knows the data only, this one is small wherever the
/// data vary without a visible consequence.
#[derive(Clone, Debug)]
pub struct Bend {
    nodes: Nodes,
    /// Nodes per bin.
    group: usize,
    /// `widths[j]` has the largest bend of every bin for widths of `group * 2^j` nodes, if those are even.
    widths: Vec<Maxima>,
    /// Of every number of the entries and of its negative, if nodes are not even.
    extremes: Vec<[Maxima; 2]>,
}

impl Bend {
    const BINS: usize = 512;

    /// The bends of a table's associated colours and opacities.
    pub fn of_steps(table: &StepTable) -> Self {
        let (nodes, entries) = (table.nodes().clone(), table.entries());
        if !nodes.knots().is_empty() {
            let of = |c: usize, sign: f32| Maxima::new(entries.iter().map(|entry| sign * entry[c]).collect());
            let extremes = (0..4).map(|c| [of(c, 1.0), of(c, -1.0)]).collect();
            return Self { nodes, group: 1, widths: Vec::new(), extremes };
        }
        let last = entries.len() - 1;
        let group = entries.len().div_ceil(Self::BINS);
        let bend = |node: usize, width: usize| {
            let [before, at, after] = [node.saturating_sub(width), node, (node + width).min(last)].map(|n| entries[n]);
            (0..4).map(|c| (before[c] + after[c] - 2.0 * at[c]).abs() / 2.0).fold(0.0, f32::max)
        };
        let of_width = |j: u32| {
            let bins = (0..=last).step_by(group);
            let largest =
                |bin: usize| (bin..(bin + group).min(last + 1)).map(|node| bend(node, group << j)).fold(0.0, f32::max);
            Maxima::new(bins.map(largest).collect())
        };
        let widths = (0..=entries.len().div_ceil(group).ilog2()).map(of_width).collect();
        Self { nodes, group, widths, extremes: Vec::new() }
    }

    /// The largest bend over values from `low` to `high` that change by up to `width`, in data
    /// units, to either side; between the widths that were tabulated, of the next larger one.
    pub fn over(&self, low: f32, high: f32, width: f32) -> f32 {
        // Also where the interval is empty or not a number.
        let varies = low < high;
        if !varies {
            return 0.0;
        }
        if !self.extremes.is_empty() {
            // No bend is larger than what the entries differ by over all of these values.
            let first = self.nodes.clamped_position(low - width).floor() as usize;
            let last = self.nodes.clamped_position(high + width).ceil() as usize;
            return self.extremes.iter().map(|e| e[0].over(first, last) + e[1].over(first, last)).fold(0.0, f32::max);
        }
        let bin = |value: f32| self.nodes.clamped_position(value) as usize / self.group;
        let bins = (width * self.nodes.scale() / self.group as f32).max(1.0);
        let j = (bins.log2().ceil() as usize).min(self.widths.len() - 1);
        self.widths[j].over(bin(low), bin(high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Color, ColorPoint, Interpolation, OpacityPoint, Table, TransferFunction};

    fn bend(opacities: &[(f64, f32)]) -> Bend {
        let interpolation = Interpolation::Linear;
        let color = ColorPoint { value: 0.0, color: Color::WHITE, interpolation };
        let opacities = opacities.iter().map(|&(value, opacity)| OpacityPoint { value, opacity, interpolation });
        let tf = TransferFunction::new(vec![color], opacities.collect()).unwrap();
        Bend::of_steps(&StepTable::new(&Table::build(&tf, [0.0, 100.0], 1001).unwrap(), 1.0).unwrap())
    }

    #[test]
    fn straight_lines_have_no_bend_and_corners_have_half_their_turn() {
        // Slope 0 up to 50, then 0.01 a unit.
        let bend = bend(&[(0.0, 0.0), (50.0, 0.0), (100.0, 0.5)]);
        assert!(bend.over(0.0, 30.0, 8.0) < 1e-6);
        assert!(bend.over(70.0, 80.0, 8.0) < 1e-6);
        // At the corner the bend at width w is 0.01 w / 2; widths are rounded up, at most doubled.
        let found = bend.over(40.0, 60.0, 8.0);
        assert!((0.04 - 1e-5..=0.08 + 1e-5).contains(&found), "{found}");
    }

    #[test]
    fn what_does_not_vary_has_no_bend() {
        let bend = bend(&[(0.0, 0.0), (50.0, 1.0), (100.0, 0.0)]);
        assert_eq!(bend.over(50.0, 50.0, 0.0), 0.0);
        assert!(bend.over(45.0, 55.0, 10.0) > 0.15);
    }
}
