//! Progress, cancellation, early termination and supersampling.

mod common;

use std::sync::Mutex;
use std::time::{Duration, Instant};

use common::{center, homogeneous, render, stage, unit_volume};
use pellucid_cpu::{CpuRenderer, RenderError};
use pellucid_scene::{Cancel, Control};

#[test]
fn progress_rises_to_one() {
    let seen = Mutex::new(Vec::new());
    let progress = |share: f64| seen.lock().unwrap().push(share);
    let stage = stage(unit_volume([16; 3], |_| 1.0), homogeneous(0.1), |scene| {
        scene.image.width = 200;
        scene.image.height = 120;
    });
    CpuRenderer::new().render(&stage, &Control { progress: Some(&progress), ..Control::default() }).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.len() > 10 && seen.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(seen.last(), Some(&1.0));
}

#[test]
fn a_cancelled_render_stops_within_50_ms() {
    let stage = stage(unit_volume([96; 3], |p| p.x), homogeneous(1e-6), |scene| {
        scene.image.width = 2048;
        scene.image.height = 2048;
        scene.quality.step = 0.05;
        scene.quality.supersampling = 4;
        scene.quality.empty_space_skipping = false;
    });
    // How long the render goes on, less the longest time that the machine kept a thread from running
    // which wanted nothing else: on a busy machine that is not the renderer's.
    let wait = || {
        let cancel = Cancel::default();
        let (outcome, waited, kept) = std::thread::scope(|scope| {
            let drawing = scope
                .spawn(|| CpuRenderer::new().render(&stage, &Control { cancel: Some(&cancel), ..Control::default() }));
            std::thread::sleep(Duration::from_millis(200));
            assert!(!drawing.is_finished(), "the scene is too easy for this test");
            let asked = Instant::now();
            cancel.cancel();
            let mut kept = Duration::ZERO;
            let mut last = asked;
            while !drawing.is_finished() {
                kept = kept.max(last.elapsed());
                last = Instant::now();
            }
            (drawing.join().unwrap(), asked.elapsed(), kept.max(last.elapsed()))
        });
        assert_eq!(outcome.unwrap_err(), RenderError::Cancelled);
        (waited.saturating_sub(kept), waited, kept)
    };
    // Rays take well under a millisecond. That several threads are kept waiting one after the other
    // hardly happens three times in a row.
    let (late, waited, kept) = (0..3).map(|_| wait()).min().unwrap();
    assert!(late < Duration::from_millis(50), "{waited:?}, threads kept from running for {kept:?}");
}

/// What early termination leaves out is at most what could still have come (7.3-2).
#[test]
fn early_termination_is_bounded_by_its_threshold() {
    let draw = |threshold: f32| {
        let frame = render(&stage(unit_volume([16, 64, 16], |_| 1.0), homogeneous(0.2), |scene| {
            scene.quality.early_termination = threshold;
        }));
        (center(&frame), frame.statistics)
    };
    let (full, all) = draw(1.0);
    let mut fewer = all.samples;
    for threshold in [0.999, 0.95, 0.5] {
        let (color, statistics) = draw(threshold);
        assert!(color[3] >= threshold && full[3] - color[3] <= 1.0 - color[3]);
        assert!(statistics.samples < fewer && statistics.rays_terminated == statistics.rays_hit);
        fewer = statistics.samples;
    }
}

/// Supersampling an edge gives coverage: the mean over the pixel's rays.
#[test]
fn supersampling_averages_rays() {
    let edge = |n: u32| {
        let stage = stage(unit_volume([16; 3], |_| 1.0), homogeneous(1.0), |scene| {
            scene.quality.supersampling = n;
            scene.image.width = 10;
            scene.image.height = 10;
            // 10 pixels show 20 units around the box of 15: pixel 1 shows -0.5 to 1.5.
            scene.camera.projection = pellucid_scene::Projection::Orthographic { height: Some(20.0) };
        });
        let frame = render(&stage);
        (frame.color[5 * 10 + 1][3], frame.statistics.rays)
    };
    assert_eq!(edge(1), (1.0, 100));
    let (covered, rays) = edge(8);
    assert!((covered - 0.75).abs() < 1e-6, "{covered}");
    assert_eq!(rays, 6400);
}

#[test]
fn impossible_numbers_of_threads_are_refused() {
    for threads in [0, CpuRenderer::MOST_THREADS + 1] {
        let error = CpuRenderer::with_threads(threads).err().map(|error| error.to_string());
        assert_eq!(error, Some(format!("cannot start {threads} threads: 1 to 1024 are possible")));
    }
}
