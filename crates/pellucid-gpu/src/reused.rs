//! What is used again from frame to frame.

use std::time::Duration;

use crate::Device;
use crate::half_angle::Layers;
use crate::pace::Pace;
use crate::path_trace::UploadedSky;
use crate::slicing::Canvas;
use crate::targets::Targets;
use crate::timer::Timer;

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

/// Targets, and what was learnt of the device's speed.
pub struct Reused {
    /// Rays in a submission.
    pub bands: Bands,
    /// Looks at the blocks in a pass of a wavefront.
    pub looks: Pace,
    /// Slices in a submission.
    pub slices: Pace,
    /// Pixels.
    pub targets: Option<Targets>,
    /// What slices are blended in.
    pub canvas: Option<Canvas>,
    /// Layers of light on its way through slabs.
    pub light: Option<Layers>,
    /// A picture of the sky.
    pub sky: Option<UploadedSky>,
    /// The device's clock, if it has one.
    pub timer: Option<Timer>,
}

impl Reused {
    /// Nothing yet, on a device.
    pub fn new(device: &Device) -> Self {
        Self {
            bands: Bands::default(),
            looks: Pace::default(),
            slices: Pace::default(),
            targets: None,
            canvas: None,
            light: None,
            sky: None,
            timer: Timer::new(device),
        }
    }
}
