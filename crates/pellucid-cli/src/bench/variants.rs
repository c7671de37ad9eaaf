//! Sweeps that change one setting of the scene.

use pellucid::field::Grid;
use pellucid::scene::{Camera, LookAt, Projection, Scene, View};

use super::subject::Subject;
use crate::flags::quality::{FILTERS, GRADIENTS};

/// A scene and what is special about it.
pub type Variant = (String, Scene);

/// In units of the smallest voxel spacing.
const STEPS: [(&str, f64); 6] = [("4", 4.0), ("2", 2.0), ("1", 1.0), ("1/2", 0.5), ("1/4", 0.25), ("1/8", 0.125)];

/// Distances between samples.
pub fn steps(subject: &Subject) -> Vec<Variant> {
    STEPS.map(|(label, step)| variant(subject, label, |scene| scene.quality.step = step)).into()
}

/// Sizes of the picture.
pub fn sizes(subject: &Subject) -> Vec<Variant> {
    let size = |n: u32| variant(subject, &format!("{n}x{n}"), |scene| (scene.image.width, scene.image.height) = (n, n));
    [256, 512, 1024, 2048, 4096].map(size).into()
}

/// Reconstruction filters.
pub fn filters(subject: &Subject) -> Vec<Variant> {
    FILTERS.map(|(label, filter)| variant(subject, label, |scene| scene.quality.filter = filter)).into()
}

/// Gradient estimators, with the shading that needs them.
pub fn gradients(subject: &Subject) -> Vec<Variant> {
    let shaded = |label: &str, gradient| {
        variant(subject, label, |scene| {
            scene.quality.gradient = gradient;
            scene.volumes.iter_mut().for_each(|entry| entry.shading = Some(true));
        })
    };
    GRADIENTS.map(|(label, gradient)| shaded(label, gradient)).into()
}

/// Parallel rays along the axes of memory and across them, all of the same picture height: the work
/// is alike, the order of the voxels is not.
pub fn views(subject: &Subject) -> Vec<Variant> {
    const DIRECTIONS: [(&str, [f64; 3]); 4] =
        [("+x", [1.0, 0.0, 0.0]), ("+y", [0.0, 1.0, 0.0]), ("+z", [0.0, 0.0, 1.0]), ("diagonal", [1.0; 3])];
    let grids: Vec<&Grid> = subject.stage.volumes.iter().map(|volume| volume.volume.grid()).collect();
    DIRECTIONS.map(|(label, direction)| variant(subject, label, |scene| scene.camera = along(direction, &grids))).into()
}

/// A camera that looks along a direction at the middle of the first grid and shows all of it from
/// any side.
fn along(direction: [f64; 3], grids: &[&Grid]) -> Camera {
    let Some(grid) = grids.first() else { return Camera::default() };
    let center = grid.center();
    let radius = grid.world_corners().map(|corner| (corner - center).length()).into_iter().fold(0.0, f64::max);
    let target = center.to_array();
    let position = std::array::from_fn(|axis| target[axis] - 2.0 * radius * direction[axis]);
    Camera {
        projection: Projection::Orthographic { height: Some(2.0 * radius) },
        view: View::LookAt(LookAt { position, target, up: [0.0, 0.0, 1.0] }),
        ..Camera::default()
    }
}

fn variant(subject: &Subject, label: &str, change: impl FnOnce(&mut Scene)) -> Variant {
    let mut scene = subject.scene.clone();
    change(&mut scene);
    (label.to_owned(), scene)
}
