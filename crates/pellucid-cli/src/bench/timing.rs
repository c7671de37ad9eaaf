//! What a few frames took.

use pellucid::scene::FrameStatistics;
use serde_json::{Value, json};

/// One frame, in seconds.
#[derive(Clone, Copy, Debug)]
pub struct Lap {
    /// From the change to the picture as 8-bit numbers in memory.
    pub total: f64,
    /// The last part of it: from light to 8-bit numbers.
    pub encode: f64,
    /// What the renderer counted and timed itself.
    pub statistics: FrameStatistics,
}

/// Frames of one kind, at least one.
#[derive(Clone, Debug)]
pub struct Timing {
    /// In the order drawn.
    pub laps: Vec<Lap>,
    /// Threads that drew.
    pub threads: u16,
}

/// Headings of [`Timing::cells`].
pub const HEADINGS: [&str; 10] = [
    "median ms",
    "min ms",
    "max ms",
    "set-up ms",
    "encode ms",
    "samples",
    "visible",
    "skipped",
    "threads",
    "Msamples/s/thread",
];

impl Timing {
    /// Median time of a frame in milliseconds.
    pub fn median_ms(&self) -> f64 {
        median(self.all_ms())
    }

    fn all_ms(&self) -> Vec<f64> {
        self.laps.iter().map(|lap| lap.total * 1e3).collect()
    }

    fn min_ms(&self) -> f64 {
        self.all_ms().into_iter().fold(f64::INFINITY, f64::min)
    }

    fn max_ms(&self) -> f64 {
        self.all_ms().into_iter().fold(0.0, f64::max)
    }

    /// Median of a part of every frame in milliseconds.
    fn part_ms(&self, seconds: impl Fn(&Lap) -> f64) -> f64 {
        median(self.laps.iter().map(|lap| seconds(lap) * 1e3).collect())
    }

    /// Median time the graphics processor worked for a frame, by its own clock, in milliseconds.
    pub fn device_ms(&self) -> Option<f64> {
        let all: Option<Vec<f64>> = self.laps.iter().map(|lap| Some(lap.statistics.device_seconds? * 1e3)).collect();
        all.map(median)
    }

    /// Median time of drawing alone in milliseconds, by the device's own clock where there is one.
    pub fn drawing_ms(&self) -> f64 {
        self.device_ms().unwrap_or_else(|| self.part_ms(|lap| lap.statistics.render_seconds))
    }

    /// Mean samples of a frame.
    pub fn samples(&self) -> f64 {
        self.mean(|counts| counts.samples)
    }

    fn total(&self, count: impl Fn(&FrameStatistics) -> u64) -> f64 {
        self.laps.iter().map(|lap| count(&lap.statistics) as f64).sum()
    }

    /// Mean of a count over the frames.
    fn mean(&self, count: impl Fn(&FrameStatistics) -> u64) -> f64 {
        self.total(count) / self.laps.len() as f64
    }

    /// Million samples a thread takes in a second of the whole frame, encoding included.
    fn rate(&self) -> f64 {
        let seconds: f64 = self.laps.iter().map(|lap| lap.total).sum();
        self.total(|counts| counts.samples) / seconds / f64::from(self.threads) / 1e6
    }

    /// A line of a table, under [`HEADINGS`].
    pub fn cells(&self) -> [String; HEADINGS.len()] {
        let ms = |v: f64| format!("{v:.2}");
        let count = |v: f64| format!("{v:.0}");
        [
            ms(self.median_ms()),
            ms(self.min_ms()),
            ms(self.max_ms()),
            ms(self.part_ms(|lap| lap.statistics.setup_seconds)),
            ms(self.part_ms(|lap| lap.encode)),
            count(self.mean(|counts| counts.samples)),
            count(self.mean(|counts| counts.samples_visible)),
            count(self.mean(|counts| counts.samples_skipped)),
            self.threads.to_string(),
            ms(self.rate()),
        ]
    }

    /// Everything there is to say. Times are milliseconds, counts means per frame.
    pub fn json(&self) -> Value {
        json!({
            "median_ms": self.median_ms(),
            "min_ms": self.min_ms(),
            "max_ms": self.max_ms(),
            "frames_ms": self.all_ms(),
            "setup_ms": self.part_ms(|lap| lap.statistics.setup_seconds),
            "render_ms": self.part_ms(|lap| lap.statistics.render_seconds),
            "device_ms": self.device_ms(),
            "encode_ms": self.part_ms(|lap| lap.encode),
            "rays": self.mean(|counts| counts.rays),
            "rays_hit": self.mean(|counts| counts.rays_hit),
            "rays_terminated": self.mean(|counts| counts.rays_terminated),
            "samples": self.mean(|counts| counts.samples),
            "samples_visible": self.mean(|counts| counts.samples_visible),
            "samples_skipped": self.mean(|counts| counts.samples_skipped),
            "threads": self.threads,
            "msamples_per_second_per_thread": self.rate(),
        })
    }
}

/// The middle of the values, or the mean of the two in the middle.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(seconds: &[f64]) -> Timing {
        let lap = |&total: &f64| Lap {
            total,
            encode: total / 10.0,
            statistics: FrameStatistics { samples: 3_000_000, setup_seconds: total / 4.0, ..Default::default() },
        };
        Timing { laps: seconds.iter().map(lap).collect(), threads: 2 }
    }

    #[test]
    fn medians_are_in_the_middle_and_rates_per_thread() {
        let odd = timing(&[0.5, 0.1, 0.3]);
        assert_eq!((odd.median_ms(), odd.min_ms(), odd.max_ms()), (300.0, 100.0, 500.0));
        let even = timing(&[0.4, 0.1, 0.2, 0.3]);
        assert!((even.median_ms() - 250.0).abs() < 1e-9);
        assert!((even.part_ms(|lap| lap.statistics.setup_seconds) - 62.5).abs() < 1e-9);
        // 12 million samples in a second of two threads.
        assert!((even.rate() - 6.0).abs() < 1e-9);
        assert_eq!(even.json()["samples"], 3e6);
        assert_eq!(even.cells()[5], "3000000");
    }
}
