//! What a ray makes of its values without an order (1.4-10, 1.4-11), and the plane of a slice.

use glam::DVec3;
use pellucid_field::Filter;
use pellucid_scene::Slice;

use super::path::Path;
use super::{Reference, Seen};

impl Reference<'_> {
    /// The value that is largest after its sign is changed, classified: of every piece between two planes of voxels
    /// the largest of four looks and where the cubic through these is largest, which is the field where that is
    /// trilinear; of nearest voxels, of all that the ray passes.
    pub fn extreme(&self, path: &Path, sign: f64, opaque: bool) -> Seen {
        let mut found: Vec<(f64, f64)> = Vec::new();
        for pair in self.knots(path).windows(2) {
            // A voxel that is absent ends the field at a knot: rounding must not decide on which side a look is.
            let room = match (self.field.has_holes(), self.stage.quality.filter) {
                (false, _) => 0.0,
                (true, Filter::Linear) => 5e-5,
                (true, _) => 1e-3,
            };
            let at = |part: f64| pair[0] + (pair[1] - pair[0]) * part;
            let value = |part: f64| sign * self.field.value(self.field.index(path.ray.at(at(part))));
            let mut parts = vec![0.5];
            if !self.field.is_of_nearest_voxels() {
                parts = [0.0, 1.0, 2.0, 3.0].map(|u| room + (1.0 - 2.0 * room) * u / 3.0).to_vec();
                let looks: Vec<f64> = parts.iter().map(|&part| value(part)).collect();
                // Newton's differences, and from them the powers of u.
                let first = looks[1] - looks[0];
                let second = looks[2] - 2.0 * looks[1] + looks[0];
                let third = looks[3] - 3.0 * looks[2] + 3.0 * looks[1] - looks[0];
                let (c, b, a) = (first - second / 2.0 + third / 3.0, (second - third) / 2.0, third / 6.0);
                let root = (b * b - 3.0 * a * c).sqrt();
                let sum = if b < 0.0 { root - b } else { -root - b };
                let roots = [sum / (3.0 * a), c / sum].into_iter().filter(|u| *u > 0.0 && *u < 3.0);
                parts.extend(roots.map(|u| room + (1.0 - 2.0 * room) * u / 3.0));
            }
            found.extend(parts.into_iter().map(|part| (value(part), at(part))).filter(|(value, _)| value.is_finite()));
        }
        let Some(&(value, distance)) = found.iter().reduce(|a, b| if b.0 > a.0 { b } else { a }) else {
            return Seen::NOTHING;
        };
        let far = |other: &&(f64, f64)| (other.1 - distance).abs() > 1e-3 * self.stage.step;
        let rival = |other: &&(f64, f64)| far(other) && (other.0 - value).abs() <= 1e-4 * self.field.range();
        let depth = found.iter().find(rival).is_none().then_some(distance);
        Seen { depth, ..Seen::colored(self.classified(sign * value, opaque)) }
    }

    /// Where a path begins and ends, and passes planes through voxels or half way between them.
    fn knots(&self, path: &Path) -> Vec<f64> {
        let [start, end] = [path.entry, path.exit].map(|distance| self.field.index(path.ray.at(distance)));
        let mut knots = vec![path.entry, path.exit];
        let halves = self.field.is_of_nearest_voxels() || self.field.has_holes();
        for axis in 0..3 {
            let (a, b) = (start[axis], end[axis]);
            let (low, high) = (a.min(b), a.max(b));
            let planes = ((2.0 * low).ceil() as i64..=(2.0 * high).floor() as i64).filter(|k| halves || k % 2 == 0);
            let part = |k: i64| (k as f64 / 2.0 - a) / (b - a);
            let parts = planes.map(part).filter(|part| (0.0..=1.0).contains(part));
            knots.extend(parts.map(|part| path.entry + (path.exit - path.entry) * part));
        }
        knots.sort_by(f64::total_cmp);
        knots
    }

    /// The mean value over the length on which there is any, classified.
    pub fn average(&self, path: &Path, opaque: bool) -> Seen {
        let samples = self.present(path);
        let length: f64 = samples.iter().map(|sample| sample.2).sum();
        let sum: f64 = samples.iter().map(|sample| sample.0 * sample.2).sum();
        if length > 0.0 { Seen::colored(self.classified(sum / length, opaque)) } else { Seen::NOTHING }
    }

    /// The light of the medium, none of it absorbed (1.2-7, model 2); opacity up to 0.9999.
    pub fn additive(&self, path: &Path) -> Seen {
        let mut color = [0.0; 4];
        for (value, _, length) in self.present(path) {
            let depth = self.extinction(value).min(-(1e-4f64).ln() / self.unit()) * length;
            for (channel, light) in color.iter_mut().zip(self.color(value)) {
                *channel += depth * light;
            }
        }
        Seen::colored(color)
    }

    /// The share of light that is held back (1.2-7, model 1).
    pub fn x_ray(&self, path: &Path) -> Seen {
        let through: f64 =
            self.present(path).iter().map(|&(value, _, length)| 1.0 - self.opacity(value, length)).product();
        Seen::colored([1.0 - through; 4])
    }

    /// The field on a plane. `None` where the ray runs along it and rounding moves the point far.
    pub fn cut(&self, path: &Path, slice: &Slice) -> Option<Seen> {
        let [point, normal] = self.plane(slice);
        let facing = path.ray.direction.dot(normal);
        if facing.abs() < 0.05 {
            return None;
        }
        let distance = (point - path.ray.origin).dot(normal) / facing;
        let value = self.field.value(self.field.index(path.ray.at(distance)));
        if !(value.is_finite() && path.holds(distance, self.field.reading.slack)) {
            return Some(Seen::NOTHING);
        }
        Some(Seen { depth: Some(distance), normal: Some(normal), ..Seen::colored(self.classified(value, true)) })
    }

    /// Value, distance and length of the samples that are there.
    fn present(&self, path: &Path) -> Vec<(f64, f64, f64)> {
        let value = |distance| self.field.value(self.field.index(path.ray.at(distance)));
        let samples = path.samples().into_iter().map(|(distance, length)| (value(distance), distance, length));
        samples.filter(|sample| sample.0.is_finite()).collect()
    }

    /// Associated colour and opacity per unit distance of one value.
    fn classified(&self, value: f64, opaque: bool) -> [f64; 4] {
        let alpha = if opaque { 1.0 } else { f64::from(self.tf.opacity(value)) };
        let color = DVec3::from_array(self.color(value)) * alpha;
        [color.x, color.y, color.z, alpha]
    }
}
