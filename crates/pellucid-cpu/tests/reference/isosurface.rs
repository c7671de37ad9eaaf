//! Surfaces of constant value between the nodes of a ray (5.5-8).

use pellucid_optics::ColorSpace;
use pellucid_scene::{Isosurface, Isovalue, SurfaceSearch};

use super::path::Path;
use super::{DEPTH, NORMAL, Reference, Seen};

impl Reference<'_> {
    /// The surfaces along a path, nearest first. `None` if the field passes a level several times
    /// between two nodes, jumps over it beside a hole, or is absent on the way: the place is then
    /// one of several. Of those that are searched for exactly, `None` if it comes close to a level and turns back.
    pub fn surfaces(&self, path: &Path, surfaces: &Isosurface) -> Option<Seen> {
        let levels = &surfaces.isovalues;
        let is_exact = surfaces.search == SurfaceSearch::Exact && self.field.is_trilinear();
        if is_exact {
            self.tell_turns(path, levels)?;
        }
        let to_eye = -path.ray.direction;
        let value = |distance: f64| self.field.value(self.field.index(path.ray.at(distance)));
        let mut seen = Seen::NOTHING;
        let nodes = if is_exact { self.fine_nodes(path).concat() } else { path.nodes() };
        for pair in nodes.windows(2) {
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

impl Reference<'_> {
    /// Many places on every piece of a path between two planes on which the field bends; its ends are a little within.
    fn fine_nodes(&self, path: &Path) -> Vec<Vec<f64>> {
        const PARTS: usize = 64;
        const WITHIN: f64 = 1e-7;
        let (from, to) = (self.field.index(path.ray.at(path.entry)), self.field.index(path.ray.at(path.exit)));
        let length = path.exit - path.entry;
        let mut ends = vec![0.0, 1.0];
        for axis in 0..3 {
            // Half way between voxels the nearest one changes, which stands for absent ones.
            let (a, way) = (2.0 * from[axis], 2.0 * (to[axis] - from[axis]));
            let (low, high) = (a.min(a + way).ceil() as i64, a.max(a + way).floor() as i64);
            ends.extend((low..=high).map(|plane| (plane as f64 - a) / way).filter(|part| (0.0..1.0).contains(part)));
        }
        ends.sort_by(f64::total_cmp);
        let piece = |ends: &[f64]| {
            let part = |i: usize| WITHIN + (1.0 - 2.0 * WITHIN) * i as f64 / PARTS as f64;
            let place = |i: usize| path.entry + length * (ends[0] + (ends[1] - ends[0]) * part(i));
            (0..=PARTS).map(place).collect()
        };
        ends.windows(2).filter(|ends| ends[1] - ends[0] > 1e-9).map(piece).collect()
    }

    /// `None` if the field turns so close to a level that rounding decides whether it passes it, or jumps over it.
    fn tell_turns(&self, path: &Path, levels: &[Isovalue]) -> Option<()> {
        /// How far from a turn the nearest of the nodes may be, in ranges of values, and more.
        const CLOSE: f64 = 4e-4;
        let close = CLOSE * self.field.range();
        let value = |distance: f64| self.field.value(self.field.index(path.ray.at(distance)));
        let mut before = f64::NAN;
        for piece in self.fine_nodes(path) {
            let values: Vec<f64> = piece.iter().map(|&distance| value(distance)).collect();
            for level in levels {
                let above = |v: f64| v - level.value;
                let turns =
                    values.windows(3).any(|v| (v[1] - v[0]) * (v[2] - v[1]) <= 0.0 && above(v[1]).abs() < close);
                let jumps = above(before) * above(values[0]) < 0.0;
                let grazes = (above(values[0]).abs() < 1e-5 * self.field.range())
                    || (above(before).abs() < 1e-5 * self.field.range());
                if turns || jumps || grazes {
                    return None;
                }
            }
            before = values[values.len() - 1];
        }
        Some(())
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
