//! Straight lines that follow a curve.

/// The largest distance of [`polyline`] from the curve.
pub(crate) const TOLERANCE: f64 = 1e-3;

/// Points of a continuous curve over 0..=1, ends included: intervals are halved until straight
/// lines are within [`TOLERANCE`] of it.
pub(crate) fn polyline(curve: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let mut points = vec![(0.0, curve(0.0))];
    // Where the next lines end, the nearest last.
    let mut ends = vec![1.0, 0.5];
    while let Some(&end) = ends.last() {
        let (from, at_from) = points[points.len() - 1];
        let at_end = curve(end);
        // Not only the middle, where a sigmoid crosses its chord.
        let off = [0.25, 0.5, 0.75].map(|t| {
            let line = at_from + (at_end - at_from) * t;
            (curve(from + (end - from) * t) - line).abs()
        });
        let middle = (from + end) / 2.0;
        if off.into_iter().fold(0.0, f64::max) > TOLERANCE && from < middle && middle < end {
            ends.push(middle);
        } else {
            points.push((end, at_end));
            ends.pop();
        }
    }
    points
}
