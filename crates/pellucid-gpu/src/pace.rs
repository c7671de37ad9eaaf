//! How much of a frame is handed to the device at once.

use std::time::Duration;

/// An amount of work, learnt from what it takes.
pub struct Pace(u32);

impl Default for Pace {
    fn default() -> Self {
        Self(4)
    }
}

impl Pace {
    /// A submission shall take between half of this and this.
    const GOAL: Duration = Duration::from_millis(30);

    /// The next amount; at most so much.
    pub fn amount(&self, most: u32) -> u32 {
        self.0.min(most)
    }

    /// What a submission of that amount took.
    pub fn learn(&mut self, took: Duration) {
        if took > Self::GOAL {
            self.0 = (self.0 / 2).max(1);
        } else if took < Self::GOAL / 2 {
            self.0 = (self.0 * 2).min(1 << 16);
        }
    }
}
