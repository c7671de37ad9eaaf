//! Speckles (fireflies): pixels that one rare bright path made far brighter than all around. Their light is right in
//! the mean of many pictures, so that it is not dropped but spread, over surroundings wide enough to hide it.

use pellucid_optics::luminance;
use rayon::prelude::*;

use super::guides::{around, places, same_surface, slopes};
use crate::Frame;

/// How far away those are that a pixel is judged by, in pixels, and how many of them there must be.
const NEAR: isize = 2;
const FEWEST: usize = 6;

/// How far its light is spread, in pixels, and over how many of them at least.
const FAR: isize = 10;
const LEAST: f32 = 8.0;

/// How far above its surroundings' median a speckle is, in distances from there to the brightest seventh of them.
const OUTLYING: f32 = 8.0;

/// In how many standard errors of its own a pixel is surely brighter than its surroundings. One path that outshines all
/// others of a pixel makes its standard error as large as its mean, and two such paths already 1.4 times less.
const SURE: f32 = 1.25;

/// The colours of a frame with the light of speckles spread, and the standard errors of what is left.
pub fn spread(frame: &Frame) -> (Vec<[f32; 4]>, Vec<f32>) {
    let slope = slopes(frame);
    let at: Vec<[isize; 2]> = places(frame).collect();
    let found: Vec<(usize, Calm)> = (0..at.len())
        .into_par_iter()
        .filter_map(|pixel| surroundings(frame, &slope, pixel, at[pixel]).map(|calm| (pixel, calm)))
        .collect();
    let (mut color, mut noise) = (frame.color.clone(), frame.noise.clone());
    let mut is_speckle = vec![false; at.len()];
    found.iter().for_each(|(pixel, _)| is_speckle[*pixel] = true);
    for (pixel, calm) in found {
        let others = around(frame, at[pixel], FAR).filter(|other| !is_speckle[*other] && color[*other][3] > 0.0);
        let covered: Vec<usize> = others.filter(|other| covered_alike(frame, pixel, *other, 0.25)).collect();
        let weighted = |weight: &dyn Fn(usize) -> f32| -> Vec<(usize, f32)> {
            covered.iter().map(|other| (*other, weight(*other))).collect()
        };
        let sum = |takers: &[(usize, f32)]| takers.iter().map(|(_, weight)| weight).sum::<f32>();
        let mut takers = weighted(&|other| same_surface(frame, &slope, [pixel, other], distance(frame, pixel, other)));
        if sum(&takers) < LEAST {
            takers = weighted(&|_| 1.0);
        }
        let whole = sum(&takers);
        if whole < LEAST {
            continue;
        }
        let before = frame.color[pixel];
        let kept = calm.level / brightness(before);
        for channel in 0..3 {
            color[pixel][channel] = before[channel] * kept;
            let given = before[channel] * (1.0 - kept) / whole;
            takers.iter().for_each(|(other, weight)| color[*other][channel] += given * weight);
        }
        noise[pixel] = calm.noise;
    }
    (color, noise)
}

/// What a pixel would be like without its brightest path.
struct Calm {
    level: f32,
    noise: f32,
}

/// What a speckle's surroundings are like; `None` if it is none.
fn surroundings(frame: &Frame, slope: &[f32], pixel: usize, at: [isize; 2]) -> Option<Calm> {
    let (own, error) = (brightness(frame.color[pixel]), frame.noise[pixel]);
    if error == 0.0 {
        return None;
    }
    let others = around(frame, at, NEAR).filter(|other| *other != pixel);
    let covered: Vec<usize> = others.filter(|other| covered_alike(frame, pixel, *other, 0.5)).collect();
    let same = |other: &usize| same_surface(frame, slope, [pixel, *other], distance(frame, pixel, *other)) > 0.3;
    let of_surface: Vec<usize> = covered.iter().copied().filter(same).collect();
    // In corners there is little that faces the same way.
    let others = if of_surface.len() < FEWEST { covered } else { of_surface };
    if others.len() < FEWEST {
        return None;
    }
    let sorted = |number: &dyn Fn(usize) -> f32| {
        let mut numbers: Vec<f32> = others.iter().map(|other| number(*other)).collect();
        numbers.sort_by(f32::total_cmp);
        numbers
    };
    let (levels, noises) = (sorted(&|other| brightness(frame.color[other])), sorted(&|other| frame.noise[other]));
    let middle = others.len() / 2;
    let (level, noise) = (levels[middle], noises[middle]);
    let usual = (levels[others.len() * 6 / 7] - level).max(noise);
    let excess = own - level;
    (excess > OUTLYING * usual && excess < SURE * error).then_some(Calm { level, noise })
}

/// Whether the coverage of two pixels differs by so much at most.
fn covered_alike(frame: &Frame, a: usize, b: usize, most: f32) -> bool {
    (frame.color[a][3] - frame.color[b][3]).abs() <= most
}

fn distance(frame: &Frame, a: usize, b: usize) -> f32 {
    let [x, y] = [a % frame.width, a / frame.width];
    let across = x.abs_diff(b % frame.width);
    (across as f32).hypot(y.abs_diff(b / frame.width) as f32)
}

fn brightness([r, g, b, _]: [f32; 4]) -> f32 {
    luminance([r, g, b])
}
