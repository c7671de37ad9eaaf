//! What pixels are compared by.

use glam::Vec3;
use pellucid_optics::luminance;

use crate::Frame;

/// How far neighbours are looked for, in pixels.
pub const REACH: isize = 5;

/// How sharply pixels are told apart by the angle between their normals: a power of its cosine.
const FACING: i32 = 16;

/// How alike the surroundings of two pixels must be: differences count in variances of theirs.
const TOLERANCE: f32 = 2.0;

/// The same for the coverage of the two themselves, which is as noisy in a cloud as it tells of its rim.
const SILHOUETTE: f32 = 6.0;

/// What neighbours are compared by.
pub struct Guides<'a> {
    frame: &'a Frame,
    color: &'a [[f32; 4]],
    /// Of the mean of each channel.
    variance: Vec<[f32; 4]>,
    /// How much the depth changes from pixel to pixel, the median of eight.
    slope: Vec<f32>,
    /// Whether there is no noise in a pixel, and none around where chance may have kept it dark.
    exact: Vec<bool>,
}

impl<'a> Guides<'a> {
    /// Of the colours of a frame, and the standard errors of their luminance, of so many samples.
    pub fn new(frame: &'a Frame, color: &'a [[f32; 4]], noise: &[f32], samples: u32) -> Self {
        let variance = places(frame).map(|at| variance(frame, color, noise, samples as f32, at)).collect();
        let is_exact = |(pixel, at): (usize, [isize; 2])| {
            let reach = if color[pixel][3] > 0.0 { REACH } else { 1 };
            around(frame, at, reach).all(|pixel| noise[pixel] == 0.0)
        };
        let exact = (0..).zip(places(frame)).map(is_exact).collect();
        Self { frame, color, variance, slope: slopes(frame), exact }
    }

    /// How unlike two pixels are by their colours and coverage, beyond their noise.
    pub fn difference(&self, a: usize, b: usize) -> f32 {
        let (one, two, of_one, of_two) = (self.color[a], self.color[b], self.variance[a], self.variance[b]);
        let channel = |c: usize| {
            let expected = of_one[c] + of_two[c];
            ((one[c] - two[c]).powi(2) - expected) / (TOLERANCE * expected + 1e-8)
        };
        (channel(0) + channel(1) + channel(2)) / 3.0 + channel(3)
    }

    /// Whether two pixels are covered alike, as far as so many samples tell: surroundings that are do not make up for
    /// a silhouette between the two.
    fn covered_alike(&self, a: usize, b: usize) -> f32 {
        let expected = self.variance[a][3] + self.variance[b][3];
        let unlike = (self.color[a][3] - self.color[b][3]).powi(2) - expected;
        (-unlike.max(0.0) / (SILHOUETTE * expected)).exp()
    }

    /// Whether two pixels so far apart show the same thing, as coverage, depth and normal tell: 0 to 1.
    pub fn edges(&self, a: usize, b: usize, distance: f32) -> f32 {
        if self.exact[a] || self.exact[b] {
            return 0.0;
        }
        self.covered_alike(a, b) * same_surface(self.frame, &self.slope, [a, b], distance)
    }
}

/// Whether two pixels so far apart lie on the same surface: as deep as slopes lead one to expect, and facing the same
/// way.
pub fn same_surface(frame: &Frame, slope: &[f32], [a, b]: [usize; 2], distance: f32) -> f32 {
    let deeper = frame.depth[a] - frame.depth[b];
    let unlike = if deeper.is_finite() {
        (deeper / (3.0 * distance * slope[a].min(slope[b]).max(f32::MIN_POSITIVE))).powi(2)
    } else {
        0.0
    };
    let [one, two] = [a, b].map(|pixel| Vec3::from_array(frame.normal[pixel]));
    let facing = if one == Vec3::ZERO || two == Vec3::ZERO { 1.0 } else { one.dot(two).max(0.0).powi(FACING) };
    facing * (-unlike).exp()
}

/// The variance of each channel's mean. That of colours is the luminance's, shared as the colours around are: one
/// pixel's own estimate is low where its value is, and such pixels would keep what they have. Coverage is a share of
/// the samples, and its variance that of its posterior, which is not 0 where all samples agree: surroundings, which a
/// silhouette parts, need not tell.
fn variance(frame: &Frame, color: &[[f32; 4]], noise: &[f32], samples: f32, at: [isize; 2]) -> [f32; 4] {
    let (mut sum, mut squares, mut count) = ([0.0; 4], 0.0, 0.0);
    for pixel in around(frame, at, 1) {
        (0..4).for_each(|c| sum[c] += color[pixel][c]);
        squares += noise[pixel] * noise[pixel];
        count += 1.0;
    }
    let [r, g, b, _] = sum.map(|sum| sum / count);
    let brightness = luminance([r, g, b]).max(1e-9);
    let own = place(frame, at).map_or(0.0, |pixel| color[pixel][3]);
    let hits = own.clamp(0.0, 1.0) * samples;
    let of_coverage = (hits + 1.0) * (samples - hits + 1.0) / ((samples + 2.0).powi(2) * (samples + 3.0));
    let of = |channel: f32| squares / count * (channel / brightness).powi(2);
    [of(r), of(g), of(b), of_coverage]
}

/// How much the depth changes from each pixel to those around, the median of eight.
pub fn slopes(frame: &Frame) -> Vec<f32> {
    let slope = |at: [isize; 2]| {
        let own = place(frame, at).map_or(0.0, |pixel| frame.depth[pixel]);
        let changes = around(frame, at, 1).map(|pixel| (frame.depth[pixel] - own).abs());
        let mut changes: Vec<f32> = changes.filter(|change| change.is_finite()).collect();
        changes.sort_by(f32::total_cmp);
        // A depth is a single number of 24 bits: flat faces have some slope, too.
        changes.get(changes.len() / 2).copied().unwrap_or(0.0).max(own.min(f32::MAX) * 1e-5)
    };
    places(frame).map(slope).collect()
}

/// Columns and rows of a frame's pixels.
pub fn places(frame: &Frame) -> impl Iterator<Item = [isize; 2]> + use<> {
    let (width, height) = (frame.width as isize, frame.height as isize);
    (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
}

/// The pixel at a column and row, if there is one.
fn place(frame: &Frame, [x, y]: [isize; 2]) -> Option<usize> {
    let [column, row] = [usize::try_from(x).ok()?, usize::try_from(y).ok()?];
    (column < frame.width && row < frame.height).then_some(row * frame.width + column)
}

/// The pixels up to so many columns and rows away.
pub fn around(frame: &Frame, [x, y]: [isize; 2], reach: isize) -> impl Iterator<Item = usize> + '_ {
    let offsets = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [x + dx, y + dy]));
    offsets.filter_map(|at| place(frame, at))
}
