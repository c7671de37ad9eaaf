//! What shaders are told of paths: the structure of `paths.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use pellucid_field::Grid;
use pellucid_optics::{OpticsError, Sky};
use pellucid_scene::{Jitter, MajorantGrid, PathTrace, Stage};

use crate::uniforms::four;

type Four = [f32; 4];

/// The settings of paths, in steps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Paths {
    pub counts: [u32; 4],
    pub more: [u32; 4],
    pub numbers: Four,
    pub top: Four,
    pub bottom: Four,
    pub index_x: Four,
    pub index_y: Four,
    pub index_z: Four,
    pub lens_right: Four,
    pub lens_up: Four,
}

impl Paths {
    /// Of a stage that looks at a grid.
    ///
    /// # Errors
    /// As [`pellucid_optics::Environment::resolve`].
    pub fn new(
        stage: &Stage,
        grid: &Grid,
        settings: &PathTrace,
        majorants: &MajorantGrid,
    ) -> Result<Self, OpticsError> {
        let view = &stage.viewpoint;
        let frames = match stage.quality.jitter {
            Jitter::Centered => 0,
            // Frames to be averaged differ by it.
            Jitter::BlueNoise { seed } => seed.wrapping_add(1),
        };
        let focus = settings.focus.unwrap_or_else(|| (view.target - view.eye).dot(view.forward));
        let [x, y, z] = majorants.leaps.dims().map(|n| n as u32);
        let in_steps = |length: f64| (length / stage.step) as f32;
        // A single block is as large as anything.
        let size = majorants.size.min(1e9);
        let rows = grid.index_from_world().matrix3.transpose() * stage.step;
        let [index_x, index_y, index_z] = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row: DVec3| four(row, 0.0));
        let (top, bottom) = sky(settings.environment.resolve()?);
        Ok(Self {
            counts: [settings.seed, frames, settings.samples, settings.bounces],
            more: [settings.roulette, x, y, z],
            numbers: [settings.noise, in_steps(settings.aperture), in_steps(focus), size],
            top,
            bottom,
            index_x,
            index_y,
            index_z,
            lens_right: four(view.right, 0.0),
            lens_up: four(view.up, 0.0),
        })
    }
}

/// Its ends, with the slope of its brightness, and that it is there.
fn sky(sky: Option<Sky>) -> (Four, Four) {
    match sky {
        Some(Sky::Gradient { top: [r, g, b], bottom: [red, green, blue], slope }) => {
            ([r, g, b, slope], [red, green, blue, 1.0])
        }
        _ => ([0.0; 4], [0.0; 4]),
    }
}
