//! Where slices lie, and how far apart rays meet them.

use glam::{DAffine3, DVec3};
use pellucid_field::Grid;
use pellucid_scene::{Jitter, SliceGeometry, Slicing, Stage};

/// Numbers of samples over positions: sample k of every ray lies where the number is k, and numbers grow
/// away from the eye.
pub struct Lattice {
    kind: Kind,
    /// The axis across which slices lie, if they follow the volume.
    pub axis: Option<usize>,
    /// Steps between two samples in the middle of the picture.
    pub middle: f64,
    /// The same of a ray that crosses slices at a right angle.
    pub perpendicular: f64,
    /// The longest of all rays; infinite if some run along the slices, or meet them from behind.
    pub longest: f64,
    /// What a slice is drawn at, in samples after its first: none of its samples is farther, so that it is in front
    /// of the eye where one of them is.
    pub drawn_at: f64,
    /// Voxels along each axis that samples may lie before that.
    pub reach: DVec3,
    /// Samples that a slice stands for.
    pub samples: u32,
    jittered: bool,
}

enum Kind {
    /// `normal . voxels + offset`.
    Planes { normal: DVec3, offset: f64 },
    /// Distance from the eye in steps, and this.
    Shells { offset: f64 },
}

impl Lattice {
    /// The slices of a stage.
    pub fn new(stage: &Stage, grid: &Grid, slicing: &Slicing) -> Self {
        let (view, step) = (&stage.viewpoint, stage.step);
        let index = grid.index_from_world();
        // Gradients of the voxel coordinates in the world.
        let rows = index.matrix3.transpose();
        let across = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.dot(view.forward));
        let cosine = |axis: usize| across[axis].abs() / rows.col(axis).length();
        // The stack that faces the view (3.2-3).
        let facing = (0..3).fold(0, |best, axis| if cosine(axis) > cosine(best) { axis } else { best });
        let [low, high] = <[DVec3; 2]>::from(grid.index_bounds());
        let mut axis = Some(facing);
        let kind = match slicing.geometry {
            SliceGeometry::Shells if view.perspective => {
                axis = None;
                Kind::Shells { offset: -(nearest(grid.world_corners(), view.eye) / step).floor() - 0.5 }
            }
            // Parallel rays come from a point so far away that shells are planes.
            SliceGeometry::ViewAligned | SliceGeometry::Shells => {
                axis = None;
                let depths = grid.world_corners().map(|corner| (corner - view.eye).dot(view.forward));
                let base = depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
                let world = grid.world_from_index();
                let normal = world.matrix3.transpose() * view.forward / step;
                let offset = ((world.translation - view.eye).dot(view.forward) - base) / step - 0.5;
                Kind::Planes { normal, offset }
            }
            // The planes of voxels, or planes at any distance from the face that is nearer.
            geometry => {
                let sign = if across[facing] < 0.0 { -1.0 } else { 1.0 };
                let (spacing, face, half) = if geometry == SliceGeometry::ObjectAligned {
                    let last = (grid.dims()[facing] - 1) as f64;
                    (1.0, if sign > 0.0 { 0.0 } else { last }, 0.0)
                } else {
                    // So far apart that samples are a step apart on rays of this angle (3.4-3).
                    (across[facing].abs() * step, if sign > 0.0 { low[facing] } else { high[facing] }, 0.5)
                };
                let mut normal = DVec3::ZERO;
                normal[facing] = sign / spacing;
                Kind::Planes { normal, offset: -face * sign / spacing - half }
            }
        };
        let mut lattice = Self {
            kind,
            axis,
            middle: 1.0,
            perpendicular: 1.0,
            longest: 1.0,
            drawn_at: 0.0,
            reach: DVec3::ZERO,
            samples: slicing.samples,
            jittered: stage.quality.jitter != Jitter::Centered && slicing.geometry != SliceGeometry::ObjectAligned,
        };
        if let Kind::Planes { normal, .. } = lattice.kind {
            lattice.perpendicular = 1.0 / ((rows * normal).length() * step);
        }
        let [right, bottom] = [view.width as f64, view.height as f64];
        let noise = if lattice.jittered { 0.5 } else { 0.0 };
        lattice.drawn_at = f64::from(slicing.samples - 1) + noise;
        for [x, y] in [[0.0, 0.0], [right, 0.0], [0.0, bottom], [right, bottom]] {
            let (stride, direction) = lattice.stride(view.ray(x, y).direction * step, &index);
            lattice.longest = lattice.longest.max(stride);
            lattice.reach = lattice.reach.max(direction.abs() * stride.min(1e6) * (lattice.drawn_at + noise));
        }
        (lattice.middle, _) = lattice.stride(view.forward * step, &index);
        lattice
    }

    /// Steps from sample to sample on rays of a direction in the world, a step long; and that in voxels.
    fn stride(&self, direction: DVec3, index_from_world: &DAffine3) -> (f64, DVec3) {
        let direction = index_from_world.transform_vector3(direction);
        let stride = match self.kind {
            Kind::Planes { normal, .. } => 1.0 / normal.dot(direction).max(0.0),
            Kind::Shells { .. } => 1.0,
        };
        (stride, direction)
    }

    /// Whether samples leave their slices by noise.
    pub fn jitters(&self) -> bool {
        self.jittered
    }

    /// What a shader is told: `voxels . xyz + w`; of shells, what is added to the distance in steps.
    pub fn plane(&self) -> (DVec3, f64) {
        match self.kind {
            Kind::Planes { normal, offset } => (normal, offset),
            Kind::Shells { offset } => (DVec3::ZERO, offset),
        }
    }

    /// Whether slices are shells around the eye.
    pub fn has_shells(&self) -> bool {
        matches!(self.kind, Kind::Shells { .. })
    }

    /// The slices with samples between two corners, from the nearest on: the first, and one beyond the last.
    pub fn slices(&self, stage: &Stage, grid: &Grid, low: DVec3, high: DVec3) -> [u32; 2] {
        const ROUNDING: f64 = 1e-3;
        let beside = ROUNDING + if self.jittered { 0.5 } else { 0.0 };
        let [first, last] = match self.kind {
            Kind::Planes { normal, offset } => {
                let ends = [normal.min(DVec3::ZERO), normal.max(DVec3::ZERO)];
                [ends[1].dot(low) + ends[0].dot(high) + offset, ends[0].dot(low) + ends[1].dot(high) + offset]
            }
            Kind::Shells { offset } => {
                let corners = grid.world_corners_of((low, high));
                let eye = stage.viewpoint.eye;
                let far = corners.map(|corner| (corner - eye).length()).into_iter().fold(0.0, f64::max);
                let near = nearest(corners, eye);
                [near / stage.step + offset, far / stage.step + offset]
            }
        };
        let samples = f64::from(self.samples);
        // Samples are numbered from 0 on: what is before the eye has no number.
        let first = ((first - beside).ceil().max(0.0) / samples).floor();
        let last = ((last + beside).floor() / samples).floor() + 1.0;
        [first as u32, last.max(first) as u32]
    }
}

/// How near a box comes to a point at least: no nearer than the ball around it.
pub fn nearest(corners: [DVec3; 8], point: DVec3) -> f64 {
    let middle = corners.iter().sum::<DVec3>() / 8.0;
    let radius = corners.map(|corner| (corner - middle).length()).into_iter().fold(0.0, f64::max);
    ((middle - point).length() - radius).max(0.0)
}
