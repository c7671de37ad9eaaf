//! How many rays are handed to the device at once.

use std::time::Duration;

/// How long the commands of a submission may take: short enough to be cancelled in time, and far from
/// what drivers take for a hang.
const SUBMISSION: Duration = Duration::from_millis(25);

/// How much is drawn at once, learnt from frame to frame.
pub struct Bands {
    /// Seconds that a ray took in the slowest band of the last frame.
    last: f64,
    /// The same of this frame so far.
    slowest: f64,
}

impl Default for Bands {
    /// A guess that lets the first frame begin with little: too little costs less than too much.
    fn default() -> Self {
        Self { last: 5e-6, slowest: 0.0 }
    }
}

impl Bands {
    /// Rays for the next submission.
    pub fn rays(&self) -> u64 {
        (SUBMISSION.as_secs_f64() / self.last.max(self.slowest)) as u64
    }

    /// What a submission took.
    pub fn learn(&mut self, rays: u64, took: Duration) {
        self.slowest = self.slowest.max(took.as_secs_f64() / rays as f64);
    }

    /// The next frame begins with what this one told.
    pub fn end_frame(&mut self) {
        *self = Self { last: self.slowest, slowest: 0.0 };
    }
}
