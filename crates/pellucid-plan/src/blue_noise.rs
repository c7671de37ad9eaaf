//! Blue noise for the start of rays (9.1-4), the same for every backend.
//!
//! A 64 x 64 tile of ranks made by void-and-cluster (R. Ulichney, "The void-and-cluster method for
//! dither array generation", 1993): every rank appears once and every prefix of ranks is spread
//! evenly, so what jitter leaves is fine-grained and has no pattern of its own.

use std::sync::OnceLock;

/// Side of the tile; the pattern repeats after this many pixels.
pub const TILE: usize = 64;
const CELLS: usize = TILE * TILE;

/// A number in `[0, 1)` for a pixel; another seed shifts the tile.
pub fn blue_noise(x: usize, y: usize, seed: u32) -> f64 {
    static RANKS: OnceLock<Vec<u16>> = OnceLock::new();
    let ranks = RANKS.get_or_init(void_and_cluster);
    let [right, down] = blue_noise_shift(seed).map(|shift| shift as usize);
    let (x, y) = ((x + right) % TILE, (y + down) % TILE);
    (f64::from(ranks[y * TILE + x]) + 0.5) / CELLS as f64
}

/// How many pixels a seed shifts the tile.
pub fn blue_noise_shift(seed: u32) -> [u32; 2] {
    // Weyl steps: seeds that follow each other land far apart.
    [0x9E37_79B9u32, 0x85EB_CA6B].map(|factor| seed.wrapping_mul(factor) >> 20)
}

/// Which cells are set, and how crowded every cell is.
struct Pattern {
    set: Vec<bool>,
    crowding: Vec<f64>,
    kernel: Vec<f64>,
}

impl Pattern {
    fn new() -> Self {
        // Ulichney found a standard deviation of 1.5 cells to work best.
        let fall = |d: usize| (d.min(TILE - d) as f64).powi(2) / (2.0 * 1.5 * 1.5);
        let kernel = (0..CELLS).map(|c| (-fall(c % TILE) - fall(c / TILE)).exp()).collect();
        Self { set: vec![false; CELLS], crowding: vec![0.0; CELLS], kernel }
    }

    fn toggle(&mut self, cell: usize) {
        let sign = if self.set[cell] { -1.0 } else { 1.0 };
        self.set[cell] = !self.set[cell];
        let (x, y) = (cell % TILE, cell / TILE);
        for row in 0..TILE {
            let from = ((row + TILE - y) % TILE) * TILE;
            for column in 0..TILE {
                self.crowding[row * TILE + column] += sign * self.kernel[from + (column + TILE - x) % TILE];
            }
        }
    }

    /// The set cell with the most company.
    fn tightest_cluster(&self) -> usize {
        self.extreme(|p, best| p.0 && (!best.0 || p.1 > best.1))
    }

    /// The free cell with the least company.
    fn largest_void(&self) -> usize {
        self.extreme(|p, best| !p.0 && (best.0 || p.1 < best.1))
    }

    fn extreme(&self, better: impl Fn((bool, f64), (bool, f64)) -> bool) -> usize {
        let at = |cell: usize| (self.set[cell], self.crowding[cell]);
        (1..CELLS).fold(0, |best, cell| if better(at(cell), at(best)) { cell } else { best })
    }
}

fn void_and_cluster() -> Vec<u16> {
    let mut pattern = Pattern::new();
    let mut random = 0x2545_F491u32;
    let mut ones = 0;
    while ones < CELLS / 10 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let cell = (random >> 20) as usize % CELLS;
        if !pattern.set[cell] {
            pattern.toggle(cell);
            ones += 1;
        }
    }
    // Move points from clusters into voids until a point would go back to where it came from.
    loop {
        let cluster = pattern.tightest_cluster();
        pattern.toggle(cluster);
        let void = pattern.largest_void();
        pattern.toggle(void);
        if void == cluster {
            break;
        }
    }
    let mut ranks = vec![0u16; CELLS];
    let start = pattern.set.clone();
    for rank in (0..ones).rev() {
        let cluster = pattern.tightest_cluster();
        pattern.toggle(cluster);
        ranks[cluster] = rank as u16;
    }
    for (cell, &set) in start.iter().enumerate() {
        if set {
            pattern.toggle(cell);
        }
    }
    for rank in ones..CELLS {
        let void = pattern.largest_void();
        pattern.toggle(void);
        ranks[void] = rank as u16;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_appears_once() {
        let mut ranks = void_and_cluster();
        ranks.sort_unstable();
        assert!(ranks.iter().enumerate().all(|(k, &rank)| usize::from(rank) == k));
    }

    /// Power at low spatial frequencies, by direct Fourier sums, against white noise's flat level:
    /// the variance of a uniform number, 1/12.
    #[test]
    fn low_frequencies_are_missing() {
        let mut power = 0.0;
        let mut count = 0.0;
        for (u, v) in (0..8).flat_map(|u| (0..8).map(move |v| (u, v))).filter(|f| *f != (0, 0)) {
            let (mut re, mut im) = (0.0, 0.0);
            for (x, y) in (0..TILE).flat_map(|y| (0..TILE).map(move |x| (x, y))) {
                let angle = std::f64::consts::TAU * (u * x + v * y) as f64 / TILE as f64;
                let value = blue_noise(x, y, 0) - 0.5;
                re += value * angle.cos();
                im += value * angle.sin();
            }
            power += (re * re + im * im) / CELLS as f64;
            count += 1.0;
        }
        let mean = power / count;
        assert!(mean < 0.1 / 12.0, "power at low frequencies {mean}, white noise has {}", 1.0 / 12.0);
    }

    #[test]
    fn a_seed_moves_the_tile_and_the_pattern_repeats() {
        assert_ne!(blue_noise(3, 5, 0), blue_noise(3, 5, 1));
        assert_eq!(blue_noise(3, 5, 7), blue_noise(3 + TILE, 5 + 2 * TILE, 7));
    }
}
