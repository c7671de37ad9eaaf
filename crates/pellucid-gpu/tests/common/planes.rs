//! What slices show, restated in double precision from the definition: for every pixel the samples of its ray on all
//! planes or shells, whatever boxes, bricks and polygons a renderer cuts the volume into.

#![allow(dead_code)] // Every test file uses its own part.

use glam::DVec3;
use pellucid_field::{Filter, Sampler};
use pellucid_optics::TransferFunction;
use pellucid_scene::{Correction, Mode, SliceGeometry, Slicing, Stage};

/// How often the way around a sample is looked at for an extreme. Between two looks a parabola that bends by the whole
/// range over the way misses 1/65536 of it, and pictures are compared to 1/255.
const LOOKS: u32 = 128;

/// What one pixel shows: associated linear colour and opacity, and how many samples it has.
pub struct Seen {
    pub color: [f64; 4],
    pub samples: u32,
}

/// The picture of a stage that slices, without light and jitter, one ray a pixel.
pub struct Planes<'a> {
    stage: &'a Stage,
    slicing: &'a Slicing,
    sampler: Sampler<'a>,
    tf: &'a TransferFunction,
}

impl<'a> Planes<'a> {
    pub fn new(stage: &'a Stage) -> Self {
        let volume = &stage.volumes[0];
        let sampler = Sampler::new(&volume.volume, volume.component, Filter::Linear).unwrap();
        Self { stage, slicing: stage.slicing().unwrap(), sampler, tf: &volume.transfer_function }
    }

    /// Numbers of samples, along a ray: that of the eye, and how they grow with distance; and the spacing of slices.
    fn lattice(&self, from: DVec3, way: DVec3) -> (f64, f64, f64) {
        let grid = *self.stage.volumes[0].volume.grid();
        let (view, step) = (&self.stage.viewpoint, self.stage.step);
        let index = grid.index_from_world();
        // Distances of planes from the eye, or numbers of voxels: linear along the ray.
        let linear = |of: &dyn Fn(DVec3) -> f64| (of(from), of(from + way) - of(from));
        match self.slicing.geometry {
            SliceGeometry::Shells if view.perspective => {
                let corners = grid.world_corners();
                let middle = grid.center();
                let radius = corners.iter().map(|c| (*c - middle).length()).fold(0.0, f64::max);
                let first = (((middle - view.eye).length() - radius).max(0.0) / step).floor();
                (-first - 0.5, 1.0 / step, step)
            }
            SliceGeometry::ViewAligned | SliceGeometry::Shells => {
                let depth = |p: DVec3| (p - view.eye).dot(view.forward);
                let nearest = grid.world_corners().map(depth).into_iter().fold(f64::INFINITY, f64::min).max(0.0);
                let (at, rise) = linear(&|p| (depth(p) - nearest) / step - 0.5);
                (at, rise, step)
            }
            geometry => {
                let voxels = |axis: usize| linear(&|p: DVec3| index.transform_point3(p)[axis]);
                let across = |axis: usize| {
                    let row = index.matrix3.row(axis);
                    row.dot(view.forward) / row.length()
                };
                let axis = (0..3).max_by(|&a, &b| across(a).abs().total_cmp(&across(b).abs())).unwrap();
                let last = (grid.dims()[axis] - 1) as f64;
                let spacing = 1.0 / index.matrix3.row(axis).length();
                let (at, rise) = voxels(axis);
                let (at, rise) = if across(axis) < 0.0 { (last - at, -rise) } else { (at, rise) };
                if geometry == SliceGeometry::ObjectAligned {
                    return (at, rise, spacing);
                }
                let voxels_apart = step * across(axis).abs() / spacing;
                (at / voxels_apart - 0.5, rise / voxels_apart, voxels_apart * spacing)
            }
        }
    }

    /// What the pixel in column x and row y shows; `None` where rounding decides whether a plane is met inside.
    pub fn pixel(&self, x: usize, y: usize) -> Option<Seen> {
        let nothing = Some(Seen { color: [0.0; 4], samples: 0 });
        let staged = &self.stage.volumes[0];
        let grid = *staged.volume.grid();
        let ray = self.stage.viewpoint.ray(x as f64 + 0.5, y as f64 + 0.5);
        let index = grid.index_from_world();
        let (from, way) = (index.transform_point3(ray.origin), index.transform_vector3(ray.direction));
        let (low, high) = grid.index_bounds();
        let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let [a, b] = [low[axis], high[axis]].map(|face| (face - from[axis]) / way[axis]);
            if way[axis] != 0.0 {
                (t0, t1) = (t0.max(a.min(b)), t1.min(a.max(b)));
            } else if from[axis] < low[axis] || from[axis] > high[axis] {
                return nothing;
            }
        }
        let Some((t0, t1)) = staged.region.interval(&ray, t0, t1).filter(|(t0, t1)| t0 < t1) else { return nothing };
        let (at_eye, rise, apart) = self.lattice(ray.origin, ray.direction);
        if rise <= 1e-9 {
            return None;
        }
        // Planes of voxels lie on the faces of the volume: those are inside.
        let room = 1e-6 * (t1 - t0);
        let place = |k: f64| (k - at_eye) / rise;
        for border in [t0, t1] {
            let beside = (place((at_eye + border * rise).round()) - border).abs() / self.stage.step;
            if (1e-5..4e-3).contains(&beside) {
                return None;
            }
        }
        let mut k = (at_eye + (t0 - room) * rise).ceil();
        let mut seen = Accumulator::new(self.stage.mode());
        let mut samples = 0;
        while place(k) <= t1 + room {
            let t = place(k);
            let half = 0.5 / rise;
            let start = if place(k - 1.0) < t0 - room { t0 } else { t - half };
            let end = if place(k + 1.0) > t1 + room { t1 } else { t + half };
            let (_, middle, _) = self.lattice(self.stage.viewpoint.eye, self.stage.viewpoint.forward);
            let length = match self.slicing.correction {
                Correction::PerSample => end.min(t1) - start.max(t0),
                Correction::PerFrame => (end.min(t1) - start.max(t0)) * rise / middle,
                Correction::Off => (end.min(t1) - start.max(t0)) * rise * apart,
            };
            let value_at = |t: f64| {
                let p = from + way * t.clamp(t0, t1);
                self.sampler.value(p.clamp(DVec3::ZERO, (high - low).floor().max(DVec3::ZERO)))
            };
            let value = match self.stage.mode() {
                // The extreme of what the sample stands for.
                mode @ (Mode::Maximum | Mode::Minimum) => {
                    let around =
                        (0..=LOOKS).map(|look| value_at(start + (end - start) * f64::from(look) / f64::from(LOOKS)));
                    around.reduce(if *mode == Mode::Minimum { f64::min } else { f64::max }).expect("more than none")
                }
                _ => value_at(t),
            };
            seen.add(self.tf, value, length, staged.unit_distance(), self.stage.step);
            samples += 1;
            k += 1.0;
        }
        Some(Seen { color: seen.color(self.tf), samples })
    }
}

/// Samples from the nearest to the farthest.
struct Accumulator<'a> {
    mode: &'a Mode,
    color: [f64; 4],
    value: Option<f64>,
    length: f64,
}

impl<'a> Accumulator<'a> {
    fn new(mode: &'a Mode) -> Self {
        Self { mode, color: [0.0; 4], value: None, length: 0.0 }
    }

    fn add(&mut self, tf: &TransferFunction, value: f64, length: f64, unit: f64, _step: f64) {
        if !value.is_finite() {
            return;
        }
        let rgb = tf.color(value).map(f64::from);
        let extinction = -(-f64::from(tf.opacity(value))).ln_1p() / unit;
        let alpha = -(-extinction * length).exp_m1();
        let best = |a: f64, b: f64| if matches!(self.mode, Mode::Minimum) { a.min(b) } else { a.max(b) };
        match self.mode {
            Mode::Composite => {
                let left = 1.0 - self.color[3];
                for (channel, c) in rgb.into_iter().chain([1.0]).enumerate() {
                    self.color[channel] += left * alpha * c;
                }
            }
            Mode::XRay => self.color = self.color.map(|c| c + (1.0 - c) * alpha),
            Mode::Additive => {
                for (channel, c) in rgb.into_iter().enumerate() {
                    self.color[channel] += extinction * length * c;
                }
            }
            Mode::Average => {
                self.value = Some(self.value.unwrap_or(0.0) + value * length);
                self.length += length;
            }
            Mode::Maximum | Mode::Minimum => self.value = Some(self.value.map_or(value, |other| best(other, value))),
            mode => panic!("no reference for {mode:?}"),
        }
    }

    fn color(&self, tf: &TransferFunction) -> [f64; 4] {
        let Some(mut value) = self.value else { return self.color };
        if self.length > 0.0 {
            value /= self.length;
        }
        let (rgb, alpha) = (tf.color(value), f64::from(tf.opacity(value)));
        let [r, g, b] = rgb.map(|c| f64::from(c) * alpha);
        [r, g, b, alpha]
    }
}
