//! How alike the pixels of a few rows are to others, for one offset to those after the other: patches that are compared
//! overlap, and their sums are made once (Darbon et al. 2008).

use super::guides::{Guides, REACH};

/// Rows of a band: few enough to stay in cache, many enough for those of patches beyond its ends not to matter.
const ROWS: usize = 16;

/// Pixels around two that are compared, on each side.
const PATCH: isize = 1;

/// Weights below this one are none: they would move less than a display shows.
const LEAST: f32 = 0.003;

/// Rows of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Band {
    /// The first of them.
    pub first: usize,
    /// How many.
    pub rows: usize,
}

impl Band {
    /// Those of a picture.
    pub fn all(height: usize) -> Vec<Self> {
        (0..height).step_by(ROWS).map(|first| Self { first, rows: ROWS.min(height - first) }).collect()
    }
}

/// The offsets to neighbours.
pub fn offsets() -> impl Iterator<Item = [isize; 2]> {
    let all = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| [dx, dy]));
    all.filter(|offset| *offset != [0, 0])
}

/// What compares the pixels of a band.
pub struct Comparison<'a> {
    guides: &'a Guides<'a>,
    band: Band,
    size: [isize; 2],
    /// Differences of pixels, of the band and `PATCH` pixels around it.
    differences: Vec<f32>,
    /// Their sums along rows.
    sums: Vec<f32>,
}

impl<'a> Comparison<'a> {
    /// Of a band of a picture of some width and height.
    pub fn new(guides: &'a Guides<'a>, band: Band, [width, height]: [usize; 2]) -> Self {
        let margin = 2 * PATCH as usize;
        Self {
            guides,
            band,
            size: [width as isize, height as isize],
            differences: vec![0.0; (width + margin) * (band.rows + margin)],
            sums: vec![0.0; width * (band.rows + margin)],
        }
    }

    /// Gives each pair of a pixel of the band and the neighbour at an offset, and how alike they are. Of two, either is as much like the other, to the bit.
    pub fn pairs(&mut self, [dx, dy]: [isize; 2], mut each: impl FnMut(usize, usize, f32)) {
        let Self { guides, band, size: [width, height], differences, sums } = self;
        let (width, height, first) = (*width, *height, band.first as isize);
        let side = (2 * PATCH + 1) as usize;
        // Beyond its border the picture goes on as it is there.
        let pixel = |x: isize, y: isize| (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize;
        let mut place = differences.iter_mut();
        for y in first - PATCH..first + band.rows as isize + PATCH {
            for (x, place) in (-PATCH..width + PATCH).zip(&mut place) {
                *place = guides.difference(pixel(x, y), pixel(x + dx, y + dy));
            }
        }
        let columns = width as usize;
        for (sums, row) in sums.chunks_exact_mut(columns).zip(differences.chunks_exact(columns + side - 1)) {
            sums.iter_mut().zip(row.windows(side)).for_each(|(sum, window)| *sum = window.iter().sum());
        }
        let distance = ((dx * dx + dy * dy) as f32).sqrt();
        for row in 0..band.rows {
            let y = first + row as isize;
            if !(0..height).contains(&(y + dy)) {
                continue;
            }
            for x in (-dx).max(0)..width.min(width - dx) {
                let column = x as usize;
                let sum: f32 = (row..row + side).map(|line| sums[line * columns + column]).sum();
                let color = (-(sum / (side * side) as f32).max(0.0)).exp();
                if color < LEAST {
                    continue;
                }
                let (own, other) = (pixel(x, y), pixel(x + dx, y + dy));
                let weight = color * guides.edges(own, other, distance);
                if weight >= LEAST {
                    each(own, other, weight);
                }
            }
        }
    }
}
