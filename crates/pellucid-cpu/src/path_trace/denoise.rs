//! Noise taken out of a picture of paths: light exchanged between non-local neighbours (Buades et al. 2005), with
//! the noise that is known of every pixel (Rousselle et al. 2012) and edges of depth, normal and coverage.

use glam::Vec3;
use pellucid_optics::luminance;
use pellucid_scene::{Control, Frame};
use rayon::prelude::*;

use crate::RenderError;

/// How far neighbours are looked for, in pixels.
const REACH: isize = 5;

/// Pixels around two that are compared, on each side.
const PATCH: isize = 1;

/// How alike neighbours must be: differences count in this many standard deviations of theirs.
const STRICTNESS: f32 = 1.5;

/// The colours of a picture of so many paths a pixel, without noise as far as neighbours tell. What has no
/// noise stays as it is, to the bit, and no other plane of the frame is changed.
///
/// # Errors
/// [`RenderError::Cancelled`].
pub fn denoised(frame: &Frame, samples: u32, control: &Control) -> Result<Vec<[f32; 4]>, RenderError> {
    let picture = Picture::new(frame, samples);
    let pixels = frame.width * frame.height;
    let each = |pixel: usize| {
        // Now and then: a pixel takes microseconds.
        if pixel.is_multiple_of(256) && control.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(pixel) }
    };
    let alike = |pixel| each(pixel).map(|pixel| 1.0 + picture.neighbours(pixel).map(|(_, weight)| weight).sum::<f32>());
    let whole = (0..pixels).into_par_iter().map(alike).collect::<Result<Vec<_>, _>>()?;
    (0..pixels).into_par_iter().map(|pixel| each(pixel).map(|pixel| picture.color(pixel, &whole))).collect()
}

/// What neighbours are compared by.
struct Picture<'a> {
    frame: &'a Frame,
    luminance: Vec<f32>,
    /// Of the luminance, the mean of 3 x 3 pixels: one pixel's own estimate is low where its value is, and such
    /// pixels would keep what they have.
    variance: Vec<f32>,
    /// How much the depth changes from pixel to pixel, the median of eight.
    slope: Vec<f32>,
    samples: f32,
}

impl<'a> Picture<'a> {
    fn new(frame: &'a Frame, samples: u32) -> Self {
        let mut picture = Self {
            frame,
            luminance: frame.color.iter().map(|[r, g, b, _]| luminance([*r, *g, *b])).collect(),
            variance: Vec::new(),
            slope: Vec::new(),
            samples: samples as f32,
        };
        let pixels = || (0..frame.height as isize).flat_map(|y| (0..frame.width as isize).map(move |x| [x, y]));
        let variance = |at| {
            let around = picture.around(at, 1).map(|pixel| frame.noise[pixel].powi(2));
            let (sum, count) = around.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
            sum / count
        };
        let slope = |at| {
            let own = frame.depth[picture.pixel(at).unwrap_or(0)];
            let around = picture.around(at, 1).map(|pixel| (frame.depth[pixel] - own).abs());
            let mut changes: Vec<f32> = around.filter(|change| change.is_finite()).collect();
            changes.sort_by(f32::total_cmp);
            // A depth is a single number of 24 bits: flat faces have some slope, too.
            changes.get(changes.len() / 2).copied().unwrap_or(0.0).max(own.min(f32::MAX) * 1e-5)
        };
        (picture.variance, picture.slope) = (pixels().map(variance).collect(), pixels().map(slope).collect());
        picture
    }

    fn pixel(&self, [x, y]: [isize; 2]) -> Option<usize> {
        let (width, height) = (self.frame.width, self.frame.height);
        let [column, row] = [usize::try_from(x).ok()?, usize::try_from(y).ok()?];
        (column < width && row < height).then_some(row * width + column)
    }

    /// The pixels up to so many away.
    fn around(&self, [x, y]: [isize; 2], reach: isize) -> impl Iterator<Item = usize> {
        let offsets = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [x + dx, y + dy]));
        offsets.filter_map(|at| self.pixel(at))
    }

    /// The pixels that are like one, and how much. Of two, either is as much like the other.
    fn neighbours(&self, own: usize) -> impl Iterator<Item = (usize, f32)> {
        let at = [own % self.frame.width, own / self.frame.width].map(|v| v as isize);
        let offsets = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| [dx, dy]));
        offsets.filter(|offset| *offset != [0, 0]).filter_map(move |[dx, dy]| {
            let other = self.pixel([at[0] + dx, at[1] + dy])?;
            let exact = |pixel: usize| self.frame.noise[pixel] == 0.0 && self.variance[pixel] == 0.0;
            if exact(own) || exact(other) {
                return None;
            }
            let edges = self.edges(own, other, ((dx * dx + dy * dy) as f32).sqrt());
            // What cannot be seen of 8 bits is not worth a comparison.
            (edges > 0.01).then(|| (other, edges * (-self.difference(at, [dx, dy])).exp()))
        })
    }

    /// The colour of a pixel, given how much of each there is like it. What one pixel gets of another, the other
    /// loses to it: no light comes or goes, where a mean would lose that of rare bright paths.
    fn color(&self, own: usize, whole: &[f32]) -> [f32; 4] {
        let before = self.frame.color[own];
        let mut after = before;
        for (other, weight) in self.neighbours(own) {
            let share = weight / whole[own].max(whole[other]);
            for (channel, sum) in after.iter_mut().enumerate() {
                *sum += share * (self.frame.color[other][channel] - before[channel]);
            }
        }
        after
    }

    /// How unlike the surroundings of two pixels are, beyond their noise: 0 or more.
    fn difference(&self, [x, y]: [isize; 2], [dx, dy]: [isize; 2]) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for py in -PATCH..=PATCH {
            for px in -PATCH..=PATCH {
                let pair = (self.pixel([x + px, y + py]), self.pixel([x + px + dx, y + py + dy]));
                let (Some(a), Some(b)) = pair else { continue };
                let (va, vb) = (self.variance[a], self.variance[b]);
                let squared = (self.luminance[a] - self.luminance[b]).powi(2) - (va + vb);
                sum += squared / (1e-10 + STRICTNESS * STRICTNESS * (va + vb));
                count += 1.0;
            }
        }
        (sum / count).max(0.0)
    }

    /// Whether two pixels show the same thing, 0 to 1: as deep as slopes lead one to expect, facing the same way,
    /// and covered alike, as far as so many paths tell.
    fn edges(&self, a: usize, b: usize, distance: f32) -> f32 {
        let frame = self.frame;
        let mut squares = 0.0;
        let deeper = frame.depth[a] - frame.depth[b];
        if deeper.is_finite() && distance > 0.0 {
            squares += (deeper / (3.0 * distance * self.slope[a].min(self.slope[b]).max(f32::MIN_POSITIVE))).powi(2);
        }
        let [one, two] = [a, b].map(|pixel| frame.color[pixel][3]);
        let variance = |alpha: f32| (alpha * (1.0 - alpha)).max(0.0) / self.samples + self.samples.powi(-2);
        squares += (one - two).powi(2) / (6.0 * (variance(one) + variance(two)));
        let [one, two] = [a, b].map(|pixel| Vec3::from_array(frame.normal[pixel]));
        let facing = if one == Vec3::ZERO || two == Vec3::ZERO { 1.0 } else { one.dot(two).max(0.0).powi(8) };
        facing * (-squares).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of one depth and coverage, of these luminances and noise.
    fn frame(side: usize, value: impl Fn(usize) -> f32, noise: f32) -> Frame {
        let mut frame = Frame::new(side, side);
        for pixel in 0..side * side {
            let v = value(pixel);
            frame.color[pixel] = [v, v, v, 1.0];
            frame.depth[pixel] = 10.0;
            frame.noise[pixel] = noise;
        }
        frame
    }

    /// Numbers of mean 0 and variance 1 that look random.
    fn normal(pixel: usize) -> f32 {
        let hash = |seed: usize| {
            let v = (pixel * 2 + seed + 1) as u64;
            let v = (v ^ v << 31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let v = (v ^ v >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((v ^ v >> 31) >> 40) as f32 / (1 << 24) as f32
        };
        (0..12).map(|k| hash(k * 7919)).sum::<f32>() - 6.0
    }

    fn run(frame: &Frame) -> Vec<[f32; 4]> {
        denoised(frame, 16, &Control::default()).unwrap()
    }

    fn rmse(colors: &[[f32; 4]], truth: impl Fn(usize) -> f32) -> f32 {
        let squares = colors.iter().enumerate().map(|(pixel, color)| (color[0] - truth(pixel)).powi(2));
        (squares.sum::<f32>() / colors.len() as f32).sqrt()
    }

    #[test]
    fn without_noise_nothing_changes() {
        let frame = frame(24, |pixel| (pixel * 37 % 101) as f32 / 101.0, 0.0);
        assert_eq!(run(&frame), frame.color);
    }

    #[test]
    fn an_even_picture_stays_so_and_its_noise_goes() {
        let even = run(&frame(24, |_| 0.7, 0.1));
        assert!(even.iter().all(|color| (color[0] - 0.7).abs() < 1e-5 && color[3] == 1.0));
        const SIDE: usize = 64;
        let noisy = frame(SIDE, |pixel| 0.7 + 0.1 * normal(pixel), 0.1);
        let smooth = run(&noisy);
        let mean = |colors: &[[f32; 4]]| colors.iter().map(|c| f64::from(c[0])).sum::<f64>() / (SIDE * SIDE) as f64;
        // Roundings of single precision alone.
        assert!((mean(&smooth) - mean(&noisy.color)).abs() < 1e-6, "{} and {}", mean(&smooth), mean(&noisy.color));
        let [before, after] = [&noisy.color, &smooth].map(|colors| rmse(colors, |_| 0.7));
        assert!(before > 0.09 && after < before / 4.0, "{before}, then {after}");
    }

    #[test]
    fn edges_of_colour_and_of_guides_are_kept() {
        const SIDE: usize = 64;
        let right = |pixel: usize| pixel % SIDE >= SIDE / 2;
        // A step of five deviations, told by the colours alone.
        let step = |pixel| if right(pixel) { 0.8 } else { 0.3 };
        let mut noisy = frame(SIDE, |pixel| step(pixel) + 0.1 * normal(pixel), 0.1);
        let by_color = run(&noisy);
        let column =
            |colors: &[[f32; 4]], x: usize| (0..SIDE).map(|y| colors[y * SIDE + x][0]).sum::<f32>() / SIDE as f32;
        assert!(column(&by_color, 31) < 0.37 && column(&by_color, 32) > 0.73, "{}", column(&by_color, 31));
        // A step of one deviation, which only guides tell: each of them does, and without them it is blurred.
        let faint = |pixel| if right(pixel) { 0.6 } else { 0.5 };
        noisy = frame(SIDE, |pixel| faint(pixel) + 0.1 * normal(pixel), 0.1);
        let contrast = |frame: &Frame| {
            let smooth = run(frame);
            let side = |columns: std::ops::Range<usize>| columns.map(|x| column(&smooth, x)).sum::<f32>() / 3.0;
            side(32..35) - side(29..32)
        };
        let raw = (32..35).map(|x| column(&noisy.color, x) - column(&noisy.color, x - 3)).sum::<f32>() / 3.0;
        let blurred = contrast(&noisy);
        let guided = |guide: &dyn Fn(&mut Frame, usize)| {
            let mut frame = noisy.clone();
            (0..SIDE * SIDE).filter(|pixel| right(*pixel)).for_each(|pixel| guide(&mut frame, pixel));
            contrast(&frame)
        };
        let mut faced = noisy.clone();
        faced.normal.fill([0.0, 0.0, 1.0]);
        (0..SIDE * SIDE).filter(|pixel| right(*pixel)).for_each(|pixel| faced.normal[pixel] = [1.0, 0.0, 0.0]);
        let kept = [
            guided(&|frame, pixel| frame.depth[pixel] = 12.0),
            guided(&|frame, pixel| frame.color[pixel][3] = 0.2),
            contrast(&faced),
        ];
        assert!(blurred < 0.6 * raw, "{blurred} of {raw}");
        assert!(kept.iter().all(|kept| *kept > 0.7 * raw), "{kept:?} of {raw}");
    }
}
