//! Longer steps where the transfer function is straight (7.3-3, 7.3-4).

use crate::common::{center, homogeneous, render, stage, transfer_function, unit_volume};
use pellucid_field::Volume;
use pellucid_optics::TransferFunction;
use pellucid_scene::{Frame, Jitter};

fn draw(volume: Volume, tf: TransferFunction, tolerance: f32) -> Frame {
    render(&stage(volume, tf, |scene| scene.quality.adaptive_tolerance = tolerance))
}

fn largest_difference(a: &Frame, b: &Frame) -> f32 {
    let channels = a.color.iter().flatten().zip(b.color.iter().flatten());
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A soft ball in a large empty volume, and a medium that is everywhere.
fn ball(n: usize) -> Volume {
    let middle = (n - 1) as f64 / 2.0;
    unit_volume([n; 3], |p| (1.0 - (p - middle).length() / 12.0).max(0.0))
}

/// A constant medium is exact at any stride, wherever the samples lie (Beer and Lambert).
#[test]
fn a_homogeneous_slab_is_exact_with_strides() {
    for (length, step, blue) in [(40usize, 0.5, false), (41, 0.37, false), (55, 0.9, true)] {
        let exact = 1.0 - (1.0 - 0.02f64).powi(length as i32 - 1);
        let volume = unit_volume([33, length, 33], |_| 0.5);
        let frame = render(&stage(volume, homogeneous(0.02), |scene| {
            scene.quality.adaptive_tolerance = 0.01;
            scene.quality.step = step;
            if blue {
                scene.quality.jitter = Jitter::BlueNoise { seed: 3 };
            }
        }));
        let drawn = f64::from(center(&frame)[3]);
        assert!((drawn - exact).abs() < 1e-5, "length {length}, step {step}: {drawn}, exact {exact}");
        let full = ((length - 1) as f64 / step).ceil() * frame.statistics.rays_hit as f64;
        assert!((frame.statistics.samples as f64) < 0.3 * full, "{} of {full} samples", frame.statistics.samples);
    }
}

/// The oracle of 7.3-3: a ball in a thin medium that varies nowhere else.
#[test]
fn steps_are_longer_outside_and_short_inside() {
    let tf =
        || transfer_function(&[(0.0, 0x8090a0), (1.0, 0xffc080)], &[(0.0, 0.01), (0.3, 0.01), (0.5, 0.3), (0.7, 0.02)]);
    let (exact, adaptive) = (draw(ball(96), tf(), 0.0), draw(ball(96), tf(), 0.02));
    let corner = |frame: &Frame| frame.samples[2 * frame.width + 2];
    assert!(4 * corner(&adaptive) <= corner(&exact) + 8, "{} and {}", corner(&adaptive), corner(&exact));
    let difference = largest_difference(&exact, &adaptive);
    assert!(difference < 0.005, "{difference}");
    let middle = |frame: &Frame| frame.samples[frame.height / 2 * frame.width + frame.width / 2];
    assert!(middle(&adaptive) > corner(&adaptive));
}

/// The smaller the tolerance, the smaller the error; at 0 every sample is taken.
#[test]
fn the_tolerance_bounds_the_error() {
    let tf =
        || transfer_function(&[(0.0, 0x2040a0), (1.0, 0xffc080)], &[(0.0, 0.0), (0.4, 0.05), (0.6, 0.01), (1.0, 0.2)]);
    let waves = || unit_volume([64; 3], |p| 0.5 + 0.5 * (p.x * 0.11).sin() * (p.y * 0.09).cos() * (p.z * 0.13).sin());
    let exact = draw(waves(), tf(), 0.0);
    let mut samples = exact.statistics.samples;
    for tolerance in [1e-6, 0.01, 0.1, 1.0] {
        let adaptive = draw(waves(), tf(), tolerance);
        let difference = largest_difference(&exact, &adaptive);
        assert!(difference <= tolerance.min(0.03) + 1e-6, "{tolerance}: {difference}");
        assert!(adaptive.statistics.samples <= samples, "{tolerance}");
        samples = adaptive.statistics.samples;
    }
    assert!(2 * samples < exact.statistics.samples, "{samples} of {}", exact.statistics.samples);
}

/// A stride that begins in a smooth block must not run over the sheet behind it (7.3-3, pitfall).
#[test]
fn long_steps_never_jump_over_a_thin_sheet() {
    let tf = || transfer_function(&[(0.0, 0xffffff)], &[(0.0, 0.001), (0.5, 0.001), (0.6, 0.9), (0.7, 0.001)]);
    for sheet in [34.0, 37.0, 41.0, 45.0] {
        let volume = || unit_volume([24, 96, 24], |p| if p.y == sheet { 0.6 } else { 0.2 });
        let difference = largest_difference(&draw(volume(), tf(), 0.0), &draw(volume(), tf(), 0.02));
        assert!(difference < 1e-4, "sheet at {sheet}: {difference}");
    }
}
