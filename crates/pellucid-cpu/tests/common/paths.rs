//! Pictures by paths of light, and whether they agree within their noise.

use pellucid_field::Volume;
use pellucid_optics::{Albedo, Color, Environment, Light, LightKind, Lighting, Phase, Scattering, luminance};
use pellucid_scene::{Frame, PathTrace, Scene, Stage, Technique};

use super::{homogeneous, render, stage, unit_volume};

pub const DARK: Lighting = Lighting::dark();
pub const WHITE: Environment = Environment::Constant { color: Color::WHITE, intensity: 1.0 };

/// The picture of a volume by paths, orthographic along +y, of 16 x 16 pixels.
pub fn traced(volume: Volume, opacity: f32, settings: PathTrace, edit: impl FnOnce(&mut Scene)) -> (Stage, Frame) {
    let stage = stage(volume, homogeneous(opacity), |scene| {
        scene.lighting = DARK;
        scene.technique = Technique::PathTrace(settings);
        edit(scene);
    });
    let frame = render(&stage);
    (stage, frame)
}

/// A homogeneous cube of this side.
pub fn cube(side: usize) -> Volume {
    unit_volume([side + 1; 3], |_| 0.0)
}

/// A cloud with holes: two blobs of different density far apart.
pub fn blobs(side: usize) -> Volume {
    let n = (side - 1) as f64;
    unit_volume([side; 3], move |p| {
        let blob = |x: f64, y: f64, z: f64, size: f64| {
            let squared = (p.x / n - x).powi(2) + (p.y / n - y).powi(2) + (p.z / n - z).powi(2);
            (1.0 - squared / (size * size)).max(0.0)
        };
        blob(0.3, 0.5, 0.4, 0.2) + 0.3 * blob(0.7, 0.4, 0.65, 0.25)
    })
}

/// Mean over the picture of a number of each pixel, and the standard error of that mean.
pub fn mean(frame: &Frame, number: impl Fn([f32; 4]) -> f64) -> (f64, f64) {
    let n = frame.color.len() as f64;
    let numbers: Vec<f64> = frame.color.iter().map(|color| number(*color)).collect();
    let mean = numbers.iter().sum::<f64>() / n;
    let variance = numbers.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Four standard errors: one honest test in 16,000 exceeds them.
pub fn agrees((mean, error): (f64, f64), expected: f64, what: &str) {
    assert!((mean - expected).abs() < 4.0 * error + 1e-6, "{what}: {mean} with error {error}, not {expected}");
}

/// The part of the picture that looks through the volume from front to back: the middle.
pub fn middle(frame: &Frame) -> Frame {
    let keep = |k: &usize| (4..12).contains(&(k % 16)) && (4..12).contains(&(k / 16));
    let color = (0..frame.color.len()).filter(keep).map(|k| frame.color[k]).collect();
    Frame { color, ..Frame::default() }
}

pub fn scattering(phase: Phase, albedo: f32) -> Scattering {
    Scattering { phase, albedo: Albedo::Constant(albedo), ..Scattering::default() }
}

pub fn directional(direction: [f64; 3]) -> Light {
    Light::new(LightKind::Directional { direction })
}

/// Whether two pictures of the same light agree in their sums.
pub fn agree(a: &Frame, b: &Frame, what: &str) {
    let sum = |frame: &Frame| frame.color.iter().map(|c| f64::from(luminance([c[0], c[1], c[2]]))).sum::<f64>();
    let squares = a.noise.iter().chain(&b.noise).map(|v| f64::from(*v).powi(2)).sum::<f64>();
    let z = (sum(a) - sum(b)) / squares.sqrt();
    assert!(z.abs() < 4.0 && sum(a) > 0.0, "{what}: {} and {}, {z} deviations", sum(a), sum(b));
}
