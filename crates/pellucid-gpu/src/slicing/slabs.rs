//! Slices through several volumes: across the view or around the eye, a step apart, from before the first volume on. What
//! lies between one and the next is drawn with the former.

use pellucid_field::Grid;
use pellucid_scene::{Correction, SliceGeometry, SliceTarget, Slicing, Stage};

use super::blending::unassociated;
use super::lattice::nearest;
use crate::shaders::Pass;
use crate::uniforms::{self, Slices, four};

/// Samples that a fragment composites at least, where blending would not round between them: the ways of its ray through
/// all volumes are found once for all of them.
const TOGETHER: u32 = 16;

/// The slices of a stage with several volumes.
pub struct Slabs {
    shells: bool,
    /// Steps from the eye to the first shell; planes begin where rays count from.
    first: f64,
    /// Samples that one stands for.
    samples: u32,
    /// How many there are, and would be of as few samples as asked for.
    pub counts: [u32; 2],
}

impl Slabs {
    /// The slices of a stage.
    pub fn new(stage: &Stage, slicing: &Slicing) -> Self {
        let (view, step) = (&stage.viewpoint, stage.step);
        // Parallel rays come from a point so far away that shells are planes.
        let shells = slicing.geometry == SliceGeometry::Shells && view.perspective;
        let (first, last) = if shells {
            let near = |grid: &Grid| nearest(grid.world_corners(), view.eye);
            let near = stage.volumes.iter().map(|volume| near(volume.volume.grid())).fold(f64::INFINITY, f64::min);
            let far = uniforms::corners(stage).map(|corner| (corner - view.eye).length()).fold(0.0, f64::max);
            ((near / step).floor(), far / step)
        } else {
            let depths = uniforms::corners(stage).map(|corner| (corner - view.eye).dot(view.forward));
            let [near, far] = depths.fold([f64::INFINITY, 0.0], |[near, far], depth| [near.min(depth), far.max(depth)]);
            (near.max(0.0) / step, far / step)
        };
        let samples = match slicing.target {
            SliceTarget::F32 => slicing.samples.max(TOGETHER),
            SliceTarget::U8 | SliceTarget::F16 => slicing.samples,
        };
        // One more than there are: rounding must not cut off the last.
        let counts = [samples, slicing.samples].map(|each| (((last - first) / f64::from(each)).ceil() + 1.0) as u32);
        Self { shells, first: if shells { first } else { 0.0 }, samples, counts }
    }

    /// What shaders are told of them.
    pub fn numbers(&self, stage: &Stage, slicing: &Slicing, pass: Pass) -> Slices {
        Slices {
            plane: four(glam::DVec3::ZERO, -self.first),
            strides: [0.0, 0.0, 0.0, stage.quality.early_termination],
            counts: [
                self.samples,
                u32::from(slicing.correction != Correction::PerSample),
                u32::from(self.shells),
                u32::from(unassociated(pass, slicing)),
            ],
            ..Slices::default()
        }
    }
}
