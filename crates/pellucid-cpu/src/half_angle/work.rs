//! Which tiles of the light's picture have something to do in a slab: found in a time that grows with their number, and
//! with that of the blocks, whatever the blur reaches over.

use std::iter::StepBy;
use std::ops::Range;

use glam::{DVec2, DVec3};
use pellucid_plan::BlockContent;
use pellucid_plan::half_angle::Geometry;

use super::band::{BAND, TILE};
use crate::prepare::Prepared;

/// Where light is looked at.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// Where something is: it alone is lit.
    InMatter,
    /// Also beside it and behind it.
    Everywhere,
}

/// The last slab in front of which the light of tiles matters, as one more than its number: one that holds something
/// there, or so much later in a tile from which a blur reaches it. `reach` in texels a slab.
pub fn needed(prepared: &Prepared, geometry: &Geometry, [tiles, bands]: [usize; 2], reach: f64) -> Vec<usize> {
    let Geometry { frame, slabs, .. } = geometry;
    let Some((blocks, distances)) = prepared.tables.blocks.as_ref().and_then(|blocks| match &blocks.content {
        BlockContent::Distances(distances) => Some((blocks, distances)),
        BlockContent::Extremes(_) => None,
    }) else {
        return vec![slabs.count; tiles * bands];
    };
    let (grid, [nx, ny, _]) = (prepared.grid(), blocks.dims);
    // 0 where never anything is.
    let mut last = vec![0usize; tiles * bands];
    for block in (0..distances.len()).filter(|&block| distances[block] == 0) {
        let first = [block % nx, block / nx % ny, block / (nx * ny)].map(|b| (b * blocks.size) as f64);
        let (mut low, mut high, mut end) = (DVec2::INFINITY, DVec2::NEG_INFINITY, 0.0f64);
        for corner in 0..8 {
            let index = DVec3::from_array(
                [0, 1, 2].map(|axis| first[axis] + if corner >> axis & 1 == 1 { blocks.size as f64 } else { 0.0 }),
            );
            let world = grid.world_from_index().transform_point3(index);
            let place = frame.project(world);
            (low, high, end) = (low.min(place), high.max(place), end.max(slabs.coordinate(world)));
        }
        let span = |low: f64, high: f64, side: usize, count: usize| {
            let [low, high] = [low - 2.0, high + 2.0].map(|texel| (texel / side as f64).clamp(0.0, count as f64 - 1.0));
            low as usize..high as usize + 1
        };
        for band in span(low.y, high.y, BAND, bands) {
            for tile in span(low.x, high.x, TILE, tiles) {
                let last = &mut last[band * tiles + tile];
                *last = (*last).max(end.ceil() as usize + 1);
            }
        }
    }
    if reach == 0.0 { last } else { reached(&last, tiles, reach) }
}

/// The same, less a slab for every `reach + 1` texels that a tile is away, at most over all tiles. Distances are the
/// larger of those along rows and columns, between the nearest texels: a chessboard's, of squares as wide as a band is
/// high, which two passes over them find exactly (Rosenfeld and Pfaltz 1966).
fn reached(last: &[usize], tiles: usize, reach: f64) -> Vec<usize> {
    const SQUARES: usize = TILE / BAND;
    const { assert!(TILE == SQUARES * BAND) };
    /// Parts of a slab in which the way is counted: whole numbers, rounded towards more slabs.
    const PARTS: f64 = (1u64 << 20) as f64;
    let square = (BAND as f64 / (reach + 1.0) * PARTS) as i64;
    let width = tiles * SQUARES;
    let mut parts: Vec<i64> = last.iter().flat_map(|&last| [(last as f64 * PARTS) as i64; SQUARES]).collect();
    let height = parts.len() / width;
    // Squares side by side are no distance apart.
    for line in lines(width, height) {
        let old: Vec<i64> = line.clone().map(|at| parts[at]).collect();
        for (k, at) in line.enumerate() {
            parts[at] = old[k.saturating_sub(1)..old.len().min(k + 2)].iter().copied().fold(0, i64::max);
        }
    }
    let mut pass = |order: &mut dyn Iterator<Item = usize>, back: bool| {
        for at in order {
            let (x, y) = (at % width, at / width);
            let row = if back { (y + 1 < height).then_some(at + width) } else { at.checked_sub(width) };
            let beside = if back { (x + 1 < width).then_some(at + 1) } else { (x > 0).then(|| at - 1) };
            let before = row.filter(|_| x > 0).map(|row| row - 1);
            let after = row.filter(|_| x + 1 < width).map(|row| row + 1);
            let most = [row, beside, before, after].into_iter().flatten().map(|other| parts[other] - square);
            parts[at] = most.fold(parts[at], i64::max);
        }
    };
    let count = width * height;
    pass(&mut (0..count), false);
    pass(&mut (0..count).rev(), true);
    let slabs = |squares: &[i64]| squares.iter().map(|parts| (*parts as f64 / PARTS).ceil() as usize).max();
    parts.chunks_exact(SQUARES).map(|squares| slabs(squares).unwrap_or(0)).collect()
}

/// Which of the cells of a picture, so many in a row, are at most `reach` cells away from one that is marked.
pub fn around(marked: &[bool], width: usize, reach: usize) -> Vec<bool> {
    let mut near = marked.to_vec();
    for line in lines(width, marked.len() / width) {
        // How many are marked in front of each.
        let mut count = vec![0u32];
        count.extend(line.clone().scan(0, |sum, at| {
            *sum += u32::from(near[at]);
            Some(*sum)
        }));
        for (k, at) in line.enumerate() {
            near[at] = count[(count.len() - 1).min(k + reach + 1)] > count[k.saturating_sub(reach)];
        }
    }
    near
}

/// The places of the cells of every row, and of every column.
fn lines(width: usize, height: usize) -> impl Iterator<Item = StepBy<Range<usize>>> {
    let rows = (0..height).map(move |y| (y * width..(y + 1) * width).step_by(1));
    rows.chain((0..width).map(move |x| (x..width * height).step_by(width)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from 0 to 1 (SplitMix64).
    fn random() -> impl FnMut() -> f64 {
        let mut state = 0u64;
        move || {
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// Every tile asks every other: what the search is a fast form of.
    #[test]
    fn tiles_are_needed_as_long_as_any_other_needs_them() {
        let mut random = random();
        let mut number = |most: f64| (random() * most) as usize;
        for round in 0..60 {
            let (tiles, bands) = (1 + number(9.0), 1 + number(20.0));
            let reach = [0.1, 0.7, 3.0, 17.0, 200.0][round % 5];
            let last: Vec<usize> =
                (0..tiles * bands).map(|_| if number(3.0) == 0 { number(90.0) } else { 0 }).collect();
            let later = |to: usize, from: usize| {
                let gap = |a: usize, b: usize, side: usize| a.abs_diff(b).saturating_sub(1) * side;
                let texels = gap(to / tiles, from / tiles, BAND).max(gap(to % tiles, from % tiles, TILE));
                last[from].saturating_sub((texels as f64 / (reach + 1.0)) as usize)
            };
            let exact: Vec<usize> =
                (0..last.len()).map(|to| (0..last.len()).map(|from| later(to, from)).max().unwrap_or(0)).collect();
            let found = reached(&last, tiles, reach);
            assert!(found.iter().zip(&exact).all(|(found, exact)| (*exact..=exact + 1).contains(found)));
            let same = found.iter().zip(&exact).filter(|(found, exact)| found == exact).count();
            assert!(same * 10 >= exact.len() * 9, "{same} of {}", exact.len());
        }
    }

    #[test]
    fn cells_around_are_those_of_a_square() {
        let mut random = random();
        for reach in [0usize, 1, 2, 7, 40] {
            let (width, height) = (23usize, 17usize);
            let marked: Vec<bool> = (0..width * height).map(|_| random() < 0.01).collect();
            let found = around(&marked, width, reach);
            for (at, found) in found.into_iter().enumerate() {
                let near = |other: usize| {
                    let apart = |a: usize, b: usize| a.abs_diff(b) <= reach;
                    marked[other] && apart(at % width, other % width) && apart(at / width, other / width)
                };
                assert_eq!(found, (0..marked.len()).any(near), "{at} within {reach}");
            }
        }
    }
}
