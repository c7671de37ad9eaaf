//! Surfaces of constant value between the nodes of a ray (5.5-8).

use pellucid_optics::ColorSpace;
use pellucid_scene::Isovalue;

use super::path::Path;
use super::{DEPTH, NORMAL, Reference, Seen};

impl Reference<'_> {
    /// The surfaces along a path, nearest first. `None` if the field passes a level several times
    /// between two nodes, jumps over it beside a hole, or is absent on the way: the place is then
    /// one of several.
    pub fn surfaces(&self, path: &Path, levels: &[Isovalue]) -> Option<Seen> {
        let to_eye = -path.ray.direction;
        let value = |distance: f64| self.field.value(self.field.index(path.ray.at(distance)));
        let mut seen = Seen::NOTHING;
        for pair in path.nodes().windows(2) {
            let [front, back] = [value(pair[0]), value(pair[1])];
            if !(front.is_finite() && back.is_finite()) {
                continue;
            }
            // The value leaves `front` and meets the levels on its way to `back` in their order.
            let mut crossed: Vec<&Isovalue> = levels.iter().filter(|l| (front < l.value) != (back < l.value)).collect();
            if back < front {
                crossed.reverse();
            }
            for level in crossed {
                let distance = root(pair[0], pair[1], |distance| value(distance) - level.value)?;
                let world = path.ray.at(distance);
                let p = self.field.index(world);
                let base = level.color.map_or_else(|| self.tf.color(level.value), |c| c.to_linear(ColorSpace::Srgb));
                let gradient = self.field.gradient(p, level.value);
                let [lit, mut doubt] = self.lit_and_doubt(base.map(f64::from), world, level.value, gradient, to_eye);
                // A surface at a glancing angle is found somewhere along the ray, and beside a hole or the end of a
                // clip the gradient jumps.
                let aside = [-DEPTH, DEPTH].map(|steps| path.ray.at(distance + steps * self.stage.step));
                let mut certain = true;
                for world in aside {
                    let beside = self.field.gradient(self.field.index(world), level.value);
                    certain &= beside.normalize_or_zero().abs_diff_eq(gradient.normalize_or_zero(), NORMAL);
                    let other = self.lit(base.map(f64::from), world, beside, to_eye);
                    (0..3)
                        .for_each(|channel| doubt[channel] = doubt[channel].max((other[channel] - lit[channel]).abs()));
                }
                if seen.depth == Some(f64::INFINITY) {
                    seen.depth = Some(distance);
                    seen.normal = self.field.normal_of(gradient).filter(|_| certain);
                }
                let share = (1.0 - seen.color[3]) * f64::from(level.opacity);
                for channel in 0..3 {
                    seen.color[channel] += share * lit[channel];
                    seen.doubt[channel] += share * doubt[channel];
                }
                seen.color[3] += share;
                if seen.color[3] >= f64::from(self.stage.quality.early_termination) {
                    return Some(seen);
                }
            }
        }
        Some(seen)
    }
}

/// Where a function passes 0, by bisection; `None` unless it does so once, and without a jump.
fn root(from: f64, to: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    const PARTS: usize = 200;
    let at = |i: usize| from + (to - from) * i as f64 / PARTS as f64;
    let below = |i| Some(f(at(i))).filter(|v| v.is_finite()).map(|v| v < 0.0);
    let below: Vec<bool> = (0..=PARTS).map(below).collect::<Option<_>>()?;
    let mut changes = (0..PARTS).filter(|&i| below[i] != below[i + 1]);
    let (Some(i), None) = (changes.next(), changes.next()) else { return None };
    let (mut low, mut high) = (at(i), at(i + 1));
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if (f(middle) < 0.0) == below[i] { low = middle } else { high = middle }
    }
    let jump = (f(high) - f(low)).abs() > 1e-6 * (f(to) - f(from)).abs();
    (!jump).then_some((low + high) / 2.0)
}
