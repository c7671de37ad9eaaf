//! The part of a ray that meets the field, and where it is looked at.

use glam::DVec3;
use pellucid_scene::{Ray, Stage};

/// A ray over the interval on which there is a field.
pub struct Path {
    /// The ray.
    pub ray: Ray,
    /// Distance at which it begins.
    pub entry: f64,
    /// Distance at which it ends.
    pub exit: f64,
    /// The faces of the box, clips and half-spaces on which it begins: inward normals in the world.
    pub faces: Vec<DVec3>,
    step: f64,
    jitter: f64,
}

impl Path {
    /// Where a ray is inside the box, the clips and further half-spaces, face by face.
    pub fn new(ray: Ray, stage: &Stage, slab: Vec<(DVec3, f64)>, jitter: f64) -> Option<Self> {
        let staged = &stage.volumes[0];
        let grid = staged.volume.grid();
        let (low, high) = grid.index_bounds();
        let origin = grid.index_from_world().transform_point3(ray.origin);
        let direction = grid.index_from_world().transform_vector3(ray.direction);
        let world_from_index_gradient = grid.index_from_world().matrix3.transpose();
        let faces = (0..3).flat_map(|axis| {
            let (o, d) = (origin[axis], direction[axis]);
            let normal = world_from_index_gradient.col(axis).normalize();
            [(o - low[axis], d, normal), (high[axis] - o, -d, -normal)]
        });
        let half_spaces = staged.region.half_spaces().iter().copied().chain(slab);
        // In voxels, as the box.
        let planes = half_spaces.map(|(normal, offset)| {
            let voxel = (grid.world_from_index().matrix3.transpose() * normal).length();
            ((normal.dot(ray.origin) - offset) / voxel, normal.dot(ray.direction) / voxel, normal)
        });
        let all: Vec<(f64, f64, DVec3)> = faces.chain(planes).collect();
        let (mut entry, mut exit) = (0.0f64, f64::INFINITY);
        for &(above, slope, _) in &all {
            if slope == 0.0 && above < 0.0 {
                return None;
            }
            if slope > 0.0 {
                entry = entry.max(-above / slope);
            }
            if slope < 0.0 {
                exit = exit.min(-above / slope);
            }
        }
        // Of two that meet within so many voxels there, rounding decides which it is.
        let near = |&&(above, slope, _): &&(f64, f64, DVec3)| slope > 0.0 && (above + slope * entry).abs() < 4e-3;
        let faces = all.iter().filter(near).map(|face| face.2).collect();
        (entry < exit).then_some(Self { ray, entry, exit, faces, step: stage.step, jitter })
    }

    /// Distance and length of every sample: segments of one step from the entry on, the last one
    /// shorter, each with its sample at the same relative place.
    pub fn samples(&self) -> Vec<(f64, f64)> {
        // A remainder below the precision of the interval is no segment.
        let count = ((self.exit - self.entry) / self.step - 1e-9).ceil().max(1.0) as usize;
        let sample = |k| {
            let from = self.entry + k as f64 * self.step;
            let length = self.step.min(self.exit - from);
            (from + self.jitter * length, length)
        };
        (0..count).map(sample).collect()
    }

    /// Entry, samples and exit.
    pub fn nodes(&self) -> Vec<f64> {
        let samples = self.samples();
        let inner = samples.iter().map(|&(distance, _)| distance);
        [self.entry].into_iter().chain(inner).chain([self.exit]).collect()
    }

    /// Whether a distance lies on the path, or outside by no more than `slack` steps.
    pub fn holds(&self, distance: f64, slack: f64) -> bool {
        let room = (slack + 1e-9) * self.step;
        (self.entry - room..=self.exit + room).contains(&distance)
    }
}
