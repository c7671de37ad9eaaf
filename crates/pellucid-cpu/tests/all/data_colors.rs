//! Voxels that are colours are drawn in them, by closed forms.

use std::sync::Arc;

use crate::common::{center, render, unit_volume};
use glam::DVec3;
use pellucid_field::{Grid, Volume};
use pellucid_optics::srgb_decode;
use pellucid_scene::{
    Classification, Colors, Frame, HalfAngle, Jitter, LookAt, Orbit, Projection, Scene, Source, Technique, View,
    VolumeEntry,
};

/// Voxels of a block.
const DIMS: [usize; 3] = [9, 6, 5];

fn colored(components: usize, voxel: impl Fn([usize; 3]) -> [u8; 4]) -> Arc<Volume> {
    let [nx, ny, nz] = DIMS;
    let places = (0..nx * ny * nz).map(|k| [k % nx, k / nx % ny, k / nx / ny]);
    let data: Vec<u8> = places.flat_map(|place| voxel(place)[..components].to_vec()).collect();
    Arc::new(Volume::with_components(Grid::new(DIMS).unwrap(), data, components).unwrap())
}

/// A narrow look along +y through the voxels with this x.
fn along_y(volumes: &[Arc<Volume>], x: f64, edit: impl FnOnce(&mut Scene)) -> [f32; 4] {
    let mut scene =
        Scene { volumes: volumes.iter().map(|_| VolumeEntry::new(Source::memory())).collect(), ..Scene::default() };
    scene.camera.projection = Projection::Orthographic { height: Some(1e-4) };
    let (position, target) = ([x, -30.0, 2.1], [x, 2.5, 2.1]);
    scene.camera.view = View::LookAt(LookAt { position, target, up: [0.0, 0.0, 1.0] });
    (scene.image.width, scene.image.height) = (3, 3);
    scene.quality.early_termination = 1.0;
    edit(&mut scene);
    center(&render(&scene.resolve(volumes).unwrap().0))
}

fn assert_close(found: [f32; 4], exact: [f64; 4], what: &str) {
    let far = found.iter().zip(exact).any(|(found, exact)| (f64::from(*found) - exact).abs() > 3e-5);
    assert!(!far, "{what}: {found:?}, exact {exact:?}");
}

fn linear(encoded: u8) -> f64 {
    f64::from(srgb_decode(f32::from(encoded) / 255.0))
}

/// The opacity of 5 voxels of matter, the height of the block.
fn held_back(per_voxel: f64) -> f64 {
    1.0 - (1.0 - per_voxel).powf((DIMS[1] - 1) as f64)
}

#[test]
fn alpha_is_the_opacity_of_a_voxel() {
    let color = [200, 90, 30];
    // All but a corner, which makes alpha one that varies.
    let volume = colored(4, |place| [color[0], color[1], color[2], if place == [0; 3] { 0 } else { 51 }]);
    let alpha = held_back(51.0 / 255.0);
    let exact = [linear(color[0]) * alpha, linear(color[1]) * alpha, linear(color[2]) * alpha, alpha];
    for classification in [Classification::Post, Classification::Pre, Classification::PreIntegrated] {
        for (step, jitter) in [(0.3, Jitter::Centered), (1.7, Jitter::BlueNoise { seed: 2 })] {
            let found = along_y(std::slice::from_ref(&volume), 5.3, |scene| {
                (scene.quality.classification, scene.quality.step, scene.quality.jitter) =
                    (classification, step, jitter);
            });
            assert_close(found, exact, &format!("{classification:?}, {step}"));
        }
    }
}

#[test]
fn colors_between_voxels_are_their_mean_in_linear_light() {
    // Red at even x, blue at odd ones, as bright as each other.
    let volume = colored(3, |[x, ..]| if x % 2 == 0 { [180, 0, 0, 0] } else { [0, 0, 180, 0] });
    let opacity = 0.2f32;
    for x in [2.0, 2.25, 2.5, 2.9, 0.0, 8.0] {
        let found = along_y(std::slice::from_ref(&volume), x, |scene| {
            scene.volumes[0].colors = Some(Colors::Data);
            scene.volumes[0].transfer_function =
                Some(crate::common::transfer_function(&[(0.0, 0xff_ffff)], &[(0.0, opacity)]));
        });
        let alpha = held_back(opacity.into());
        let blue = if x > 7.0 { 0.0 } else { x % 2.0 } * linear(180) * alpha;
        let red = (linear(180) * alpha - blue).max(0.0);
        assert_close(found, [red, 0.0, blue, alpha], &format!("at {x}"));
    }
}

#[test]
fn a_transfer_function_tints_the_colors() {
    let volume = colored(3, |_| [180, 255, 90, 0]);
    let found = along_y(&[volume], 4.0, |scene| {
        scene.volumes[0].colors = Some(Colors::Data);
        scene.volumes[0].transfer_function = Some(crate::common::transfer_function(&[(0.0, 0x80_ff00)], &[(0.0, 0.1)]));
    });
    let alpha = held_back(0.1);
    assert_close(found, [linear(180) * linear(0x80) * alpha, alpha, 0.0, alpha], "tinted");
}

/// White voxels are what a white transfer function is, whatever draws them.
#[test]
fn white_voxels_are_those_of_a_white_transfer_function() {
    let volume = colored(3, |_| [255; 4]);
    let draw = |colors, half_angle: bool, layers: usize| -> Frame {
        let entry = VolumeEntry {
            colors: Some(colors),
            transfer_function: Some(crate::common::transfer_function(&[(0.0, 0xff_ffff)], &[(0.0, 0.1)])),
            shading: Some(true),
            ..VolumeEntry::new(Source::memory())
        };
        let mut scene = Scene { volumes: vec![entry; layers], ..Scene::default() };
        scene.camera.view = View::Orbit(Orbit { azimuth: 30.0, elevation: 20.0, ..Orbit::default() });
        (scene.image.width, scene.image.height) = (20, 20);
        if half_angle {
            scene.technique = Technique::HalfAngle(HalfAngle { resolution: 32, ..HalfAngle::default() });
        }
        render(&scene.resolve(&vec![volume.clone(); layers]).unwrap().0)
    };
    for (half_angle, layers) in [(false, 1), (false, 2), (true, 1), (true, 2)] {
        let [own, plain] = [Colors::Data, Colors::TransferFunction].map(|colors| draw(colors, half_angle, layers));
        assert!(own.color.iter().any(|pixel| pixel[0] > 0.1), "nothing is seen");
        for (own, plain) in own.color.as_flattened().iter().zip(plain.color.as_flattened()) {
            assert!((own - plain).abs() < 1e-5, "{half_angle}, {layers}: {own} and {plain}");
        }
    }
}

/// Extinctions add, and colours by their shares of them.
#[test]
fn colored_voxels_meet_other_volumes() {
    let red = colored(3, |_| [255, 0, 0, 0]);
    let gray = Arc::new(unit_volume(DIMS, |_: DVec3| 1.0));
    let found = along_y(&[red, gray], 4.0, |scene| {
        scene.volumes[0].colors = Some(Colors::Data);
        for (entry, opacity) in scene.volumes.iter_mut().zip([0.1, 0.3]) {
            entry.transfer_function = Some(crate::common::transfer_function(&[(0.0, 0xff_ffff)], &[(0.0, opacity)]));
            entry.shading = Some(false);
        }
    });
    let [first, second] = [0.1f32, 0.3].map(|opacity| -(1.0 - f64::from(opacity)).ln());
    let alpha = 1.0 - (-(first + second) * 5.0).exp();
    let gray = alpha * second / (first + second);
    assert_close(found, [alpha, gray, gray, alpha], "both");
}

/// Of two volumes that are fused, the one that gives opacity has no colours, not even its own.
#[test]
fn fused_volumes_have_the_colors_of_one() {
    let volumes = [colored(3, |_| [255, 0, 0, 0]), colored(3, |_| [0, 255, 0, 0])];
    let found = along_y(&volumes, 4.0, |scene| {
        scene.overlap = pellucid_scene::Overlap::Fused { color: 0, opacity: 1 };
        for entry in &mut scene.volumes {
            entry.colors = Some(Colors::Data);
            entry.transfer_function = Some(crate::common::transfer_function(&[(0.0, 0xff_ffff)], &[(0.0, 0.1)]));
        }
    });
    let alpha = held_back(0.1);
    assert_close(found, [alpha, 0.0, 0.0, alpha], "fused");
}
