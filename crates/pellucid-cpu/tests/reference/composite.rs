//! Emission and absorption, front to back (1.4-8), under the three classifications.

use glam::DVec3;
use pellucid_optics::{DataRange, Table};
use pellucid_scene::Classification;

use super::path::Path;
use super::{Reference, Seen, over_length};

/// A sample on its way into a ray.
struct Sample {
    distance: f64,
    /// Data value where it is lit; NaN if absent.
    value: f64,
    /// Associated RGBA.
    color: [f64; 4],
}

impl Reference<'_> {
    /// The medium along a path; `None` if rounding decides by which face it comes in.
    pub fn composite(&self, path: &Path) -> Option<Seen> {
        let cut = match path.faces[..] {
            [] => None,
            [face] => Some(face),
            _ => return None,
        };
        let gradient_of = |p: DVec3, value: f64, world: DVec3| {
            let own = self.field.gradient(p, value);
            cut.map_or(own, |face| self.impregnated(own, face, world - path.ray.at(path.entry)))
        };
        let samples = match self.stage.quality.classification {
            Classification::Post => self.post(path),
            Classification::Pre => self.pre(path),
            Classification::PreIntegrated => self.preintegrated(path),
        };
        let mut seen = Seen::NOTHING;
        // Where opacity passes one half, a little earlier and a little later.
        let mut halves = [None; 2];
        for sample in samples {
            let [r, g, b, alpha] = sample.color;
            if alpha == 0.0 {
                continue;
            }
            let world = path.ray.at(sample.distance);
            let p = self.field.index(world);
            let gradient = gradient_of(p, sample.value, world);
            let weighs = self.staged.gradient_weight.is_some();
            let gradient_lit = if weighs { self.field.gradient(p, sample.value) } else { gradient };
            let base = [r / alpha, g / alpha, b / alpha];
            let [lit, doubt] = self.lit_and_doubt(base, world, sample.value, gradient_lit, -path.ray.direction);
            let share = (1.0 - seen.color[3]) * alpha;
            for channel in 0..3 {
                seen.color[channel] += share * lit[channel];
                seen.doubt[channel] += share * doubt[channel];
            }
            seen.color[3] += share;
            for (half, room) in halves.iter_mut().zip([-1e-5, 1e-5]) {
                if half.is_none() && seen.color[3] >= 0.5 + room {
                    *half = Some(sample.distance);
                }
            }
            if seen.color[3] >= f64::from(self.stage.quality.early_termination) {
                break;
            }
        }
        match halves {
            [None, None] => (),
            [Some(early), Some(late)] if early == late => {
                let world = path.ray.at(early);
                let p = self.field.index(world);
                let gradient = self.field.gradient(p, self.field.value(p));
                (seen.depth, seen.normal) = (Some(early), self.field.normal_of(gradient));
            }
            _ => (seen.depth, seen.normal) = (None, None),
        }
        Some(seen)
    }

    /// The gradient so far inside a face by which a ray came in: of the matter, as if the values rose there by the
    /// width of the transfer function in one voxel, and beyond the first voxel of the data, more and more (C-28).
    fn impregnated(&self, own: DVec3, face: DVec3, inside: DVec3) -> DVec3 {
        let grid = self.staged.volume.grid();
        let index_normal = grid.world_from_index().matrix3.transpose() * face;
        let depth = inside.dot(face) / index_normal.length();
        if depth >= 8.0 {
            return own;
        }
        let [low, high] = Table::for_data(self.tf, &DataRange::of(&self.staged.volume)).unwrap().nodes().domain();
        let rise = if high > low { high - low } else { 1.0 };
        let steep = face * (rise / index_normal.length());
        own * (depth - 1.0).clamp(0.0, 1.0) + steep / depth.max(1.0).powi(2)
    }

    /// The transfer function of the interpolated value (4.3-1).
    fn post(&self, path: &Path) -> Vec<Sample> {
        let sample = |(distance, length)| {
            let value = self.field.value(self.field.index(path.ray.at(distance)));
            let (alpha, [r, g, b]) = (self.opacity(value, length), self.color(value));
            Sample { distance, value, color: [r * alpha, g * alpha, b * alpha, alpha] }
        };
        path.samples().into_iter().map(sample).collect()
    }

    /// The interpolated associated colours of the voxels (4.2-1), of one step; then over the
    /// sample's own length (1.4-14).
    fn pre(&self, path: &Path) -> Vec<Sample> {
        let sample = |(distance, length): (f64, f64)| {
            let p = self.field.index(path.ray.at(distance));
            let [x, y, z] = [0, 1, 2].map(|axis| self.field.taps(axis, p[axis]));
            let mut sum = [0.0; 4];
            for (k, wz) in &z {
                for (j, wy) in &y {
                    for (i, wx) in &x {
                        let value = self.field.voxel([*i, *j, *k]);
                        let (alpha, [r, g, b]) = (self.opacity(value, self.stage.step), self.color(value));
                        let color = [r * alpha, g * alpha, b * alpha, alpha];
                        (0..4).for_each(|channel| sum[channel] += wx * wy * wz * color[channel]);
                    }
                }
            }
            // Filters with negative weights overshoot.
            let color = sum.map(|channel| channel.clamp(0.0, 1.0));
            Sample { distance, value: self.field.value(p), color: shortened(color, length / self.stage.step) }
        };
        path.samples().into_iter().map(sample).collect()
    }

    /// The medium between the nodes, where the value runs straight from one end to the other
    /// (4.5-5). Where one end is absent the field reaches half way with the value of the other.
    fn preintegrated(&self, path: &Path) -> Vec<Sample> {
        let node = |&distance: &f64| (distance, self.field.value(self.field.index(path.ray.at(distance))));
        let nodes: Vec<(f64, f64)> = path.nodes().iter().map(node).collect();
        let segment = |pair: &[(f64, f64)]| {
            let [(start, front), (end, back)] = [pair[0], pair[1]];
            let (front, back, length) = match (front.is_finite(), back.is_finite()) {
                (true, true) => (front, back, end - start),
                (true, false) => (front, front, (end - start) / 2.0),
                _ => (back, back, (end - start) / 2.0),
            };
            let distance = (start + end) / 2.0;
            let value = self.field.value(self.field.index(path.ray.at(distance)));
            let color = self.integral(front, back, length);
            Sample { distance, value, color }
        };
        nodes.windows(2).map(segment).collect()
    }

    /// A length along which the value runs straight: from the table, if this reference has one,
    /// or in thin slices.
    fn integral(&self, front: f64, back: f64, length: f64) -> [f64; 4] {
        const SLICES: usize = 128;
        if let Some(table) = &self.table {
            return table.over_length(front as f32, back as f32, (length / self.stage.step) as f32).map(f64::from);
        }
        let mut sum = [0.0; 4];
        for slice in 0..SLICES {
            let value = front + (back - front) * (slice as f64 + 0.5) / SLICES as f64;
            let alpha = self.opacity(value, length / SLICES as f64);
            let [r, g, b] = self.color(value);
            let share = (1.0 - sum[3]) * alpha;
            sum = [sum[0] + share * r, sum[1] + share * g, sum[2] + share * b, sum[3] + share];
        }
        sum
    }
}

/// An associated colour over a part of its length (1.4-14).
fn shortened(color: [f64; 4], ratio: f64) -> [f64; 4] {
    let alpha = over_length(color[3], ratio);
    if color[3] > 0.0 { color.map(|channel| channel * alpha / color[3]) } else { color }
}
