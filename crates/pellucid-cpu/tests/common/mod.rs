//! Small scenes for tests.
#![allow(dead_code, reason = "every test binary uses another part")]

pub mod data;
pub mod paths;
pub mod random;

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Grid, Volume, Voxels};
use pellucid_optics::{Color, ColorPoint, Interpolation, OpacityPoint, TransferFunction};
use pellucid_scene::{Camera, Control, Frame, Mode, Orbit, Projection, RayCast, Scene, Source, Stage, Technique, View};

/// A transfer function through (value, opacity) and (value, colour code) points, unit distance 1.
pub fn transfer_function(colors: &[(f64, u32)], opacities: &[(f64, f32)]) -> TransferFunction {
    let interpolation = Interpolation::Linear;
    let colors = colors.iter().map(|&(value, hex)| ColorPoint { value, color: Color::hex(hex), interpolation });
    let opacities = opacities.iter().map(|&(value, opacity)| OpacityPoint { value, opacity, interpolation });
    let tf = TransferFunction::new(colors.collect(), opacities.collect()).unwrap();
    tf.with_unit_distance(Some(1.0)).unwrap()
}

/// A homogeneous white medium with this opacity per world unit.
pub fn homogeneous(opacity: f32) -> TransferFunction {
    transfer_function(&[(0.0, 0xffffff)], &[(0.0, opacity)])
}

/// A volume from a function of the index position, on a grid with an affine.
pub fn volume_of(dims: [usize; 3], affine: DAffine3, value: impl Fn(DVec3) -> f64) -> Volume {
    let grid = Grid::with_affine(dims, affine).unwrap();
    let mut values = Vec::with_capacity(grid.len());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            values.extend((0..dims[0]).map(|x| value(DVec3::new(x as f64, y as f64, z as f64)) as f32));
        }
    }
    Volume::new(grid, Voxels::from(values)).unwrap()
}

/// A volume with unit spacing at the origin.
pub fn unit_volume(dims: [usize; 3], value: impl Fn(DVec3) -> f64) -> Volume {
    volume_of(dims, DAffine3::IDENTITY, value)
}

/// A 16 x 16 orthographic picture along +y, unlit; edited before it is resolved.
pub fn stage(volume: Volume, tf: TransferFunction, edit: impl FnOnce(&mut Scene)) -> Stage {
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].transfer_function = Some(tf);
    scene.volumes[0].shading = Some(false);
    scene.camera = Camera {
        projection: Projection::Orthographic { height: None },
        view: View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() }),
        ..Camera::default()
    };
    scene.image.width = 16;
    scene.image.height = 16;
    scene.quality.early_termination = 1.0;
    edit(&mut scene);
    scene.resolve(&[Arc::new(volume)]).unwrap().0
}

/// Chooses the mode of a scene.
pub fn set_mode(scene: &mut Scene, mode: Mode) {
    scene.technique = Technique::RayCast(RayCast { mode });
}

/// Draws a stage.
pub fn render(stage: &Stage) -> Frame {
    CpuRenderer::new().render(stage, &Control::default()).unwrap()
}

/// The pixel in the middle.
pub fn center(frame: &Frame) -> [f32; 4] {
    frame.color[frame.height / 2 * frame.width + frame.width / 2]
}
