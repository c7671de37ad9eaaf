//! A picture of low resolution: how low, and how it fills the window.

use std::time::Duration;

use pellucid_scene::{Frame, FrameStatistics, Viewpoint};
use rayon::prelude::*;

/// Divisors of the resolution per axis. They are few, so that it seldom changes from view to view.
const REDUCTIONS: [usize; 7] = [2, 3, 4, 6, 8, 12, 16];
/// The one of a first picture, when nothing has been measured.
const UNMEASURED: usize = 4;

/// What the last pictures cost, in seconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    setup: f64,
    enlarging: f64,
    /// Per ray. Those of a preview are dearer: what they read is farther apart.
    whole: Option<f64>,
    preview: Option<f64>,
}

fn per_ray(statistics: &FrameStatistics) -> Option<f64> {
    Some(statistics.render_seconds / statistics.rays.max(1) as f64)
}

impl Pace {
    /// Learns from a preview that took `enlarging` seconds more.
    pub fn preview(&mut self, statistics: &FrameStatistics, enlarging: f64) {
        (self.setup, self.enlarging, self.preview) = (statistics.setup_seconds, enlarging, per_ray(statistics));
    }

    /// Learns from a full picture.
    pub fn whole(&mut self, statistics: &FrameStatistics) {
        (self.setup, self.whole) = (statistics.setup_seconds, per_ray(statistics));
    }

    /// By what to divide the resolution of a view with this many rays per pixel, for a picture within
    /// the budget: by 1 if the whole picture is, by 16 if none is. A quarter of the budget is for rays
    /// even where all of it is used up before the first: fewer of them would save nothing.
    pub fn reduction(&self, view: &Viewpoint, rays_per_pixel: f64, budget: Duration) -> usize {
        let budget = budget.as_secs_f64();
        let pixels = (view.width * view.height) as f64;
        if self.whole.is_some_and(|each| self.setup + each * pixels * rays_per_pixel <= budget) {
            return 1;
        }
        let Some(each) = self.preview.or(self.whole) else { return UNMEASURED };
        let for_rays = (budget - self.setup - self.enlarging).max(budget / 4.0);
        let [.., coarsest] = REDUCTIONS;
        let within = |&divisor: &usize| {
            let small = view.with_rows(rows(view, divisor));
            each * (small.width * small.height) as f64 <= for_rays
        };
        REDUCTIONS.into_iter().find(within).unwrap_or(coarsest)
    }
}

/// Rows of a view divided.
pub fn rows(view: &Viewpoint, divisor: usize) -> usize {
    view.height.div_ceil(divisor)
}

/// Enlarges the picture of [`Viewpoint::with_rows`] to that of its view: colours, which are
/// associated, bilinearly; depth, normal, samples and noise, which do not mix, from the nearest pixel.
pub fn enlarge(small: &Frame, large: &mut Frame, width: usize, height: usize) {
    if (large.width, large.height) != (width, height) {
        large.clear(width, height);
    }
    large.statistics = small.statistics;
    large.warnings.clone_from(&small.warnings);
    large.opacities.clear();
    let scale = small.height as f64 / height as f64;
    let across = Axis { scale, from: width, to: small.width };
    let down = Axis { scale, from: height, to: small.height };
    if !small.opacities.is_empty() {
        let nearest =
            |place: usize| down.taps(place / width).nearest * small.width + across.taps(place % width).nearest;
        large.opacities.extend((0..width * height).map(|place| small.opacities[nearest(place)]));
    }
    let row = width.max(1);
    let color = large.color.par_chunks_mut(row);
    let depth = large.depth.par_chunks_mut(row);
    let normal = large.normal.par_chunks_mut(row);
    let samples = large.samples.par_chunks_mut(row);
    let noise = large.noise.par_chunks_mut(row);
    let rows = color.zip(depth).zip(normal).zip(samples).zip(noise).enumerate();
    rows.for_each(|(y, ((((color, depth), normal), samples), noise))| {
        let vertical = down.taps(y);
        let [upper, lower] = vertical.ends.map(|row| &small.color[row * small.width..][..small.width]);
        let nearest = vertical.nearest * small.width;
        for x in 0..width {
            let taps = across.taps(x);
            let [left, right] = taps.ends;
            color[x] = mix(
                mix(upper[left], upper[right], taps.weight),
                mix(lower[left], lower[right], taps.weight),
                vertical.weight,
            );
            let pixel = nearest + taps.nearest;
            (depth[x], normal[x], samples[x]) = (small.depth[pixel], small.normal[pixel], small.samples[pixel]);
            noise[x] = small.noise[pixel];
        }
    });
    large.backdrop.clear();
    if !small.backdrop.is_empty() {
        let pixels = (0..width * height).into_par_iter().map(|pixel| {
            let (x, y) = (across.taps(pixel % row), down.taps(pixel / row));
            let at = |row: usize, column: usize| {
                let [r, g, b] = small.backdrop[row * small.width + column];
                [r, g, b, 0.0]
            };
            let rows = y.ends.map(|row| mix(at(row, x.ends[0]), at(row, x.ends[1]), x.weight));
            let [r, g, b, _] = mix(rows[0], rows[1], y.weight);
            [r, g, b]
        });
        large.backdrop = pixels.collect();
    }
}

/// Pixels of one axis of the large picture, seen from the small one; their middles coincide.
struct Axis {
    scale: f64,
    from: usize,
    to: usize,
}

/// The pixels on both sides of a place, the share of the second, and the one the place lies in.
struct Taps {
    ends: [usize; 2],
    weight: f32,
    nearest: usize,
}

impl Axis {
    fn taps(&self, pixel: usize) -> Taps {
        let from_middle = pixel as f64 + 0.5 - self.from as f64 / 2.0;
        let last = self.to - 1;
        let place = (from_middle * self.scale + self.to as f64 / 2.0 - 0.5).clamp(0.0, last as f64);
        let first = place as usize;
        Taps {
            ends: [first, (first + 1).min(last)],
            weight: (place - first as f64) as f32,
            nearest: (place + 0.5) as usize,
        }
    }
}

fn mix(a: [f32; 4], b: [f32; 4], weight: f32) -> [f32; 4] {
    // Without fused instructions in the target, `mul_add` is a call per channel.
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * weight)
}

#[cfg(test)]
mod tests {
    use pellucid_scene::{Camera, Projection};

    use super::*;

    fn view(width: usize, height: usize) -> Viewpoint {
        let projection = Projection::Orthographic { height: Some(10.0) };
        Camera { projection, ..Camera::default() }.viewpoint(width, height, &[])
    }

    /// Pixels hold where their ray starts: linear in the picture, so the enlarged picture holds where
    /// the rays of the large one start, but for the border, outside the middles of small pixels.
    #[test]
    fn an_enlarged_picture_shows_everything_in_its_place() {
        for (width, height, divisor) in [(64, 48, 4), (50, 39, 4), (33, 70, 3), (31, 5, 16), (7, 1, 4), (1, 9, 2)] {
            let view = view(width, height).shifted(0.3, -0.2);
            let low = view.with_rows(rows(&view, divisor));
            let start = |view: &Viewpoint, x: usize, y: usize| {
                let origin = view.ray(x as f64 + 0.5, y as f64 + 0.5).origin.as_vec3();
                [origin.x, origin.y, origin.z, 1.0]
            };
            let mut small = Frame::new(low.width, low.height);
            for (y, x) in (0..low.height).flat_map(|y| (0..low.width).map(move |x| (y, x))) {
                let pixel = y * low.width + x;
                small.color[pixel] = start(&low, x, y);
                (small.depth[pixel], small.samples[pixel]) = (pixel as f32, pixel as u32);
                small.normal[pixel] = [pixel as f32; 3];
            }
            let mut large = Frame::default();
            enlarge(&small, &mut large, width, height);
            let scale = low.height as f64 / height as f64;
            let at = |v: usize, from: usize, to: usize| (v as f64 + 0.5 - from as f64 / 2.0) * scale + to as f64 / 2.0;
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let pixel = y * width + x;
                let (u, v) = (at(x, width, low.width), at(y, height, low.height));
                let inside = |place: f64, n: usize| (0.5..=n as f64 - 0.5).contains(&place);
                if inside(u, low.width) && inside(v, low.height) {
                    let (found, exact) = (large.color[pixel], start(&view, x, y));
                    let off = (0..4).map(|c| (found[c] - exact[c]).abs()).fold(0.0, f32::max);
                    assert!(off < 1e-4, "{width}x{height} by {divisor}, ({x}, {y}): {found:?}, not {exact:?}");
                }
                // The nearest pixel is the one the place lies in.
                let nearest = v.floor() as usize * low.width + u.floor() as usize;
                assert_eq!((large.depth[pixel], large.samples[pixel]), (nearest as f32, nearest as u32));
                assert_eq!(large.normal[pixel], [nearest as f32; 3]);
            }
        }
    }

    #[test]
    fn resolution_follows_the_budget() {
        let view = view(1600, 800);
        let full = 1600 * 800;
        let budget = Duration::from_millis(30);
        let took = |render_seconds: f64, rays: u64, setup_seconds: f64| FrameStatistics {
            rays,
            setup_seconds,
            render_seconds,
            ..FrameStatistics::default()
        };
        assert_eq!(Pace::default().reduction(&view, 1.0, budget), 4);
        // After a whole picture, 2 ms of it to set up.
        let after = |seconds: f64| {
            let mut pace = Pace::default();
            pace.whole(&took(seconds - 0.002, full, 0.002));
            pace
        };
        let by = |seconds: f64| after(seconds).reduction(&view, 1.0, budget);
        assert_eq!([0.01, 0.029, 0.031, 0.113, 0.115, 0.44, 0.46, 60.0].map(by), [1, 1, 2, 2, 3, 4, 6, 16]);
        // Four rays a pixel are for the whole picture only.
        assert_eq!([1.0, 4.0].map(|rays| after(0.02).reduction(&view, rays, budget)), [1, 2]);
        // A preview in a quarter of the rows that took 27 ms, with 1 ms to enlarge it, is as good as can
        // be, however fast the rays of the whole picture are; another millisecond is too much.
        let again = |seconds: f64| {
            let mut pace = after(0.05);
            pace.preview(&took(seconds, full / 16, 0.002), 0.001);
            pace.reduction(&view, 1.0, budget)
        };
        assert_eq!([0.0269, 0.0271].map(again), [4, 6]);
        // With the time used up, a quarter of it is for rays.
        let late = |seconds: f64| {
            let mut pace = Pace::default();
            pace.preview(&took(seconds / 16.0, full / 16, 1.0), 0.0);
            pace.reduction(&view, 1.0, budget)
        };
        assert_eq!([0.001, 0.029, 0.031, 16.0 * 0.0076].map(late), [2, 2, 3, 6]);
    }
}
