//! Surfaces of constant value between the nodes of a ray (5.5-8).

use pellucid_optics::ColorSpace;
use pellucid_scene::Isovalue;

use super::path::Path;
use super::{Reference, Seen};

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
                let color = self.lit(base.map(f64::from), world, self.field.gradient(p, level.value), to_eye);
                if seen.depth == Some(f64::INFINITY) {
                    seen.depth = Some(distance);
                    seen.normal = self.field.normal(p, level.value);
                }
                let share = (1.0 - seen.color[3]) * f64::from(level.opacity);
                for (channel, light) in seen.color.iter_mut().zip([color[0], color[1], color[2], 1.0]) {
                    *channel += share * light;
                }
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
