//! The curves of a transfer function as tables see them, and how far straight lines are from them.

use crate::TransferFunction;

/// Colour and opacity by data value, opacities in shares of the largest: what a thin medium hides is of its own size.
#[derive(Clone, Copy)]
pub(crate) struct Curves<'a> {
    tf: &'a TransferFunction,
    most: f32,
}

/// The largest differences of colours and of opacity.
pub(crate) type Off = [f32; 2];

impl<'a> Curves<'a> {
    /// Those of a function.
    pub fn of(tf: &'a TransferFunction) -> Self {
        let most = tf.opacities().iter().map(|point| point.opacity).fold(0.0, f32::max);
        Self { tf, most: if most > 0.0 { most } else { 1.0 } }
    }

    /// How far the curves are from the straight lines between two values.
    pub fn off_chord(&self, [low, high]: [f64; 2], value: f64) -> Off {
        let [from, to, exact] = [low, high, value].map(|value| self.at(value));
        let t = ((value - low) / (high - low)) as f32;
        off([0, 1, 2, 3].map(|c| from[c] + (to[c] - from[c]) * t - exact[c]))
    }

    /// Whether there is anything between the properties of two values.
    pub fn differ(&self, a: f64, b: f64) -> bool {
        const NOTHING: f32 = 1e-4;
        let (a, b) = (self.at(a), self.at(b));
        let [color, opacity] = off([0, 1, 2, 3].map(|c| a[c] - b[c]));
        color.max(opacity) > NOTHING
    }

    /// Whether a curve jumps in an interval.
    pub fn jump_within(&self, [low, high]: [f64; 2]) -> bool {
        let inside = self.tf.values().into_iter().filter(|value| (low..=high).contains(value));
        inside.into_iter().any(|value| self.differ(value.next_down(), value))
    }

    fn at(&self, value: f64) -> [f32; 4] {
        let [r, g, b] = self.tf.color(value);
        [r, g, b, self.tf.opacity(value) / self.most]
    }
}

fn off(difference: [f32; 4]) -> Off {
    let [r, g, b, opacity] = difference.map(f32::abs);
    [r.max(g).max(b), opacity]
}

/// The larger of each.
pub(crate) fn largest(a: Off, b: Off) -> Off {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// Values between two control points; in the dark the sRGB curve bends most near a point.
pub(crate) fn inner(from: f64, to: f64) -> [f64; 5] {
    [0.02, 0.25, 0.5, 0.75, 0.98].map(|t| from + (to - from) * t)
}
