//! The tests of the crate that need no process of their own, in one program: one link instead of many. Reconstruction,
//! gradients and resampling are held against closed forms and brute force.

mod blocks;
mod cavities;
mod closed_form;
mod derived;
mod filter;
mod gradient;
mod grid_types;
mod joint_histogram;
mod marschner_lobb;
mod noise;
mod prefilter;
mod resample;
mod sampler;

use glam::DVec3;
use pellucid_field::{Filter, Grid, SincWindow, Volume};

/// A filter of every kind.
const FILTERS: [Filter; 11] = [
    Filter::Nearest,
    Filter::Linear,
    Filter::BSpline { prefilter: false },
    Filter::CATMULL_ROM,
    Filter::MITCHELL,
    Filter::Bc { b: 0.0, c: 0.3 },
    Filter::Sinc { window: SincWindow::Lanczos, half_width: 2 },
    Filter::Sinc { window: SincWindow::Lanczos, half_width: 3 },
    Filter::Sinc { window: SincWindow::Hann, half_width: 4 },
    Filter::Sinc { window: SincWindow::Blackman, half_width: 5 },
    Filter::Sinc { window: SincWindow::Kaiser, half_width: 8 },
];

/// Voxel (i, j, k) is f(i, j, k).
fn voxels(dims: [usize; 3], f: impl Fn(DVec3) -> f64) -> Vec<f32> {
    let [nx, ny, nz] = dims;
    let index = |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / (nx * ny)) as f64);
    (0..nx * ny * nz).map(|i| f(index(i)) as f32).collect()
}

/// An `f32` volume with unit spacing.
fn volume(dims: [usize; 3], f: impl Fn(DVec3) -> f64) -> Volume {
    Volume::new(Grid::new(dims).unwrap(), voxels(dims, f)).unwrap()
}

/// A small generator of reproducible numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn point(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.within(low, high), self.within(low, high), self.within(low, high))
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.point(-1.0, 1.0);
            if (0.01..1.0).contains(&p.length()) {
                return p.normalize();
            }
        }
    }
}

#[track_caller]
fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} within {tolerance}");
}

#[track_caller]
fn assert_near(found: DVec3, expected: DVec3, tolerance: f64) {
    assert!((found - expected).length() <= tolerance, "{found} is not {expected} within {tolerance}");
}
