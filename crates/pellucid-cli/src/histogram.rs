//! A histogram in a terminal.

use pellucid::field::{Histogram, Short};

/// Eighths of a character cell, from empty to full.
const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Draws counts on a logarithmic scale, `width` characters wide and `rows` high, with the range of
/// values under it. A bin with a single value shows: it is at least an eighth of a cell high.
pub fn draw(histogram: &Histogram, width: usize, rows: usize) -> String {
    let counts = gather(histogram.counts(), width.max(1));
    let most = counts.iter().copied().max().unwrap_or(0);
    let full = (rows * 8) as f64;
    let scale = (most as f64 + 1.0).ln();
    let heights: Vec<usize> = counts
        .iter()
        .map(|count| match count {
            0 => 0,
            count => (((*count as f64 + 1.0).ln() / scale * full).round() as usize).max(1),
        })
        .collect();
    let mut text = String::new();
    for row in (0..rows).rev() {
        text.extend(heights.iter().map(|height| BLOCKS[height.saturating_sub(row * 8).min(8)]));
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    let (low, high) = histogram.range();
    let [low, high] = Short::ends(low, high);
    let note = format!("log counts, most {most}");
    let gap = counts.len().saturating_sub(low.len() + high.len() + note.len());
    text.push_str(&format!("{low}{}{note}{}{high}\n", " ".repeat(gap / 2), " ".repeat(gap - gap / 2)));
    text
}

/// Columns of equally many bins each, or, where there is room, equally many columns for each bin:
/// anything else would draw a comb that is not in the data.
fn gather(counts: &[u64], width: usize) -> Vec<u64> {
    let columns: Vec<u64> = counts.chunks(counts.len().div_ceil(width).max(1)).map(|bins| bins.iter().sum()).collect();
    let repeat = (width / columns.len().max(1)).max(1);
    columns.into_iter().flat_map(|count| std::iter::repeat_n(count, repeat)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_share_columns_evenly() {
        assert_eq!(gather(&[1, 2, 3, 4, 5], 3), [3, 7, 5]);
        assert_eq!(gather(&[1, 2], 5), [1, 1, 2, 2]);
        assert_eq!(gather(&[7], 2), [7, 7]);
        assert_eq!(gather(&[], 2), [0u64; 0]);
    }

    #[test]
    fn heights_are_logarithmic_and_nothing_is_lost_from_sight() {
        use pellucid::field::{Grid, Volume};
        // 1 zero, 6 ones, 63 twos: full height is ln 64, a single value ln 2 / ln 64 = 1/6 of it.
        let values: Vec<u8> = [vec![0; 1], vec![1; 6], vec![2; 63]].concat();
        let volume = Volume::new(Grid::new([70, 1, 1]).unwrap(), values).unwrap();
        let text = draw(&Histogram::of_levels(&volume, 0).unwrap(), 3, 3);
        let rows: Vec<&str> = text.lines().collect();
        // 24 eighths: 4, 24 ln 7 / ln 64 = 11.2, 24.
        assert_eq!(rows[..3], ["  █", " ▃█", "▄██"]);
        assert!(rows[3].starts_with("-0.5") && rows[3].ends_with("2.5"), "{}", rows[3]);
    }
}
