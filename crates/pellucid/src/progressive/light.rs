//! How much of the light of surfaces pictures wait for.

use std::time::{Duration, Instant};

use pellucid_scene::{FrameStatistics, Haste, Stage};

/// What is known of the light of a stage's surfaces.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light {
    /// The number of the round: all that is seen has the paths of those before it.
    round: usize,
}

/// Paths from each place, round by round.
const PATHS: [u32; 3] = [16, 64, u32::MAX];

impl Light {
    /// How long light is followed for a picture.
    pub const WITHIN: Duration = Duration::from_millis(250);

    /// Whether all of it is, or there is nothing to know.
    pub fn is_known(&self, stage: &Stage) -> bool {
        self.round >= PATHS.len() || stage.global_illumination().is_none()
    }

    /// What of it a picture that is drawn now waits for, so long.
    pub fn haste(&self, stage: &Stage, within: Duration) -> Option<Haste> {
        stage.global_illumination()?;
        let paths = *PATHS.get(self.round).unwrap_or(&u32::MAX);
        Some(Haste { due: Instant::now() + within, paths })
    }

    /// A picture was drawn that way.
    pub fn advance(&mut self, statistics: &FrameStatistics) {
        if statistics.waiting == 0 {
            self.round += 1;
        }
    }
}
