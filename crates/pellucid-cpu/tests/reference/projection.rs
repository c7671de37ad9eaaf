//! What a ray makes of its values without an order (1.4-10, 1.4-11), and the plane of a slice.

use glam::DVec3;
use pellucid_scene::Slice;

use super::path::Path;
use super::{Reference, Seen};

impl Reference<'_> {
    /// The value that is largest after its sign is changed, classified.
    pub fn extreme(&self, path: &Path, sign: f64, opaque: bool) -> Seen {
        let samples = self.present(path);
        let Some(&(value, distance, _)) = samples.iter().reduce(|a, b| if sign * b.0 > sign * a.0 { b } else { a })
        else {
            return Seen::NOTHING;
        };
        let rival =
            |other: &&(f64, f64, f64)| other.1 != distance && (other.0 - value).abs() <= 1e-5 * self.field.range();
        let depth = samples.iter().find(rival).is_none().then_some(distance);
        Seen { depth, ..Seen::colored(self.classified(value, opaque)) }
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
