//! How slices are projected, and how much larger than they are boxes are drawn.

use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::{Correction, Slicing, Stage};

use super::blending::unassociated;
use super::lattice::Lattice;
use crate::shaders::Pass;
use crate::uniforms::{Slices, four};
use crate::window::Window;

/// Voxels by which boxes are drawn larger, so that every pixel of a sample in them has a fragment: by what samples lie
/// beside their slice, and by the rounding of corners to parts of a pixel.
pub fn margin(stage: &Stage, grid: &Grid, lattice: &Lattice) -> DVec3 {
    const PART_OF_PIXEL: f64 = 0.05;
    const ROUNDING: f64 = 2e-3;
    let view = &stage.viewpoint;
    let depths = grid.world_corners().map(|corner| (corner - view.eye).dot(view.forward));
    let farthest = if view.perspective { depths.into_iter().fold(0.0, f64::max) } else { 1.0 };
    let pixel = 2.0 * view.half_height / view.height as f64 * farthest;
    let index = grid.index_from_world().matrix3.transpose();
    let lengths = DVec3::new(index.x_axis.length(), index.y_axis.length(), index.z_axis.length());
    lattice.reach + lengths * (PART_OF_PIXEL * pixel) + ROUNDING
}

/// What shaders are told to draw rows of a window with, for one ray of their pixels: `[row, rows, sub]`. There are so
/// many slices in all.
pub fn numbers(
    stage: &Stage,
    grid: &Grid,
    lattice: &Lattice,
    (slicing, pass, slices): (&Slicing, Pass, u32),
    (window, [row, rows, sub]): (&Window, [u32; 3]),
) -> Slices {
    let view = &stage.viewpoint;
    let world = grid.world_from_index();
    // A direction's share of the way from the eye to voxels, as a row.
    let along =
        |direction: DVec3| (world.matrix3.transpose() * direction).extend(direction.dot(world.translation - view.eye));
    let pixel = 2.0 * view.half_height / view.height as f64;
    let w = if view.perspective { along(view.forward) } else { glam::DVec4::W };
    let n = stage.quality.supersampling;
    let inside = |cell: u32| (f64::from(cell) + 0.5) / f64::from(n) - 0.5;
    // Fragments are in the middle of pixels, wherever the ray goes through them.
    let left = view.width as f64 / 2.0 - view.shift.x - inside(sub % n) - f64::from(window.low[0]);
    let top = view.height as f64 / 2.0 - view.shift.y - inside(sub / n) - f64::from(row);
    let x = (along(view.right) / pixel + w * left) * (2.0 / f64::from(window.size[0])) - w;
    let y = w - (w * top - along(view.up) / pixel) * (2.0 / f64::from(rows));
    let (normal, offset) = lattice.plane();
    Slices {
        plane: four(normal, offset),
        strides: [
            lattice.middle as f32,
            lattice.perpendicular as f32,
            1.0 / (slices * lattice.samples).max(1) as f32,
            stage.quality.early_termination,
        ],
        clip_x: x.as_vec4().to_array(),
        clip_y: y.as_vec4().to_array(),
        clip_w: w.as_vec4().to_array(),
        margin: four(margin(stage, grid, lattice), lattice.drawn_at),
        eye: four(grid.index_from_world().transform_point3(view.eye), 1.0),
        counts: [
            slicing.samples,
            match slicing.correction {
                Correction::PerSample => 0,
                Correction::PerFrame => 1,
                Correction::Off => 2,
            },
            u32::from(lattice.has_shells()),
            u32::from(unassociated(pass, slicing)),
        ],
    }
}
