//! A picture of low resolution: how low, and how it fills the window.

use std::time::Duration;

use pellucid_scene::{Frame, FrameStatistics, Viewpoint};
use rayon::prelude::*;

/// Divisors of the resolution per axis. They are few, so that it seldom changes from view to view.
const REDUCTIONS: [usize; 7] = [2, 3, 4, 6, 8, 12, 16];
/// The one of a first picture, when nothing has been measured.
const UNMEASURED: usize = 4;

/// What the last picture cost, in seconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    /// To set up, and to fill the window: whatever the resolution.
    pub fixed: f64,
    /// Per ray.
    pub per_ray: f64,
}

impl Pace {
    /// The pace of a picture that took `enlarging` more seconds to fill the window.
    pub fn new(statistics: &FrameStatistics, enlarging: f64) -> Self {
        Self {
            fixed: statistics.setup_seconds + enlarging,
            per_ray: statistics.render_seconds / statistics.rays.max(1) as f64,
        }
    }
}

/// By what to divide the resolution of a view with this many rays per pixel, for a picture within
/// the budget: by 1 if the whole picture is, by 16 if none is.
pub fn reduction(view: &Viewpoint, rays_per_pixel: f64, pace: Option<Pace>, budget: Duration) -> usize {
    let Some(pace) = pace else { return UNMEASURED };
    let within = |rays: f64| pace.fixed + pace.per_ray * rays <= budget.as_secs_f64();
    if within((view.width * view.height) as f64 * rays_per_pixel) {
        return 1;
    }
    let rays = |divisor: usize| {
        let small = view.with_rows(rows(view, divisor));
        (small.width * small.height) as f64
    };
    let [.., coarsest] = REDUCTIONS;
    REDUCTIONS.into_iter().find(|&divisor| within(rays(divisor))).unwrap_or(coarsest)
}

/// Rows of a view divided.
pub fn rows(view: &Viewpoint, divisor: usize) -> usize {
    view.height.div_ceil(divisor)
}

/// Enlarges the picture of [`Viewpoint::with_rows`] to that of its view: colours, which are
/// associated, bilinearly; depth, normal and samples, which do not mix, from the nearest pixel.
pub fn enlarge(small: &Frame, large: &mut Frame, width: usize, height: usize) {
    if (large.width, large.height) != (width, height) {
        large.clear(width, height);
    }
    large.statistics = small.statistics;
    large.warnings.clone_from(&small.warnings);
    let scale = small.height as f64 / height as f64;
    let across = Axis { scale, from: width, to: small.width };
    let down = Axis { scale, from: height, to: small.height };
    let row = width.max(1);
    let color = large.color.par_chunks_mut(row);
    let depth = large.depth.par_chunks_mut(row);
    let normal = large.normal.par_chunks_mut(row);
    let samples = large.samples.par_chunks_mut(row);
    color.zip(depth).zip(normal).zip(samples).enumerate().for_each(|(y, (((color, depth), normal), samples))| {
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
        }
    });
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
    std::array::from_fn(|c| (b[c] - a[c]).mul_add(weight, a[c]))
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
        let full = 1600.0 * 800.0;
        let budget = Duration::from_millis(30);
        // A whole picture in `seconds`, 2 ms of it fixed.
        let by = |seconds: f64| {
            reduction(&view, 1.0, Some(Pace { fixed: 0.002, per_ray: (seconds - 0.002) / full }), budget)
        };
        assert_eq!([0.01, 0.029, 0.031, 0.113, 0.115, 0.44, 0.46, 60.0].map(by), [1, 1, 2, 2, 3, 4, 6, 16]);
        // Four rays a pixel are for the whole picture only.
        let pace = Some(Pace { fixed: 0.0, per_ray: 0.02 / full });
        assert_eq!([1.0, 4.0].map(|rays| reduction(&view, rays, pace, budget)), [1, 2]);
        assert_eq!(reduction(&view, 1.0, None, budget), 4);
        assert_eq!(reduction(&view, 1.0, Some(Pace { fixed: 1.0, per_ray: 0.0 }), budget), 16);
    }
}
