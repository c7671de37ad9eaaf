//! What is counted while a frame is drawn.

/// Totals of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStatistics {
    /// Rays cast.
    pub rays: u64,
    /// Rays that met the volume.
    pub rays_hit: u64,
    /// Rays that stopped early because they were opaque.
    pub rays_terminated: u64,
    /// Samples taken.
    pub samples: u64,
    /// Samples that added opacity (7.0-1).
    pub samples_visible: u64,
    /// Samples leapt over in empty blocks.
    pub samples_skipped: u64,
    /// Luminance that paths brought, and what of it a firefly clamp held back, where that is counted.
    pub light: [f64; 2],
    /// How often light of surfaces was asked for that was not known in time, of pictures in haste.
    pub waiting: u64,
    /// Seconds to build tables and block maps.
    pub setup_seconds: f64,
    /// Seconds to draw.
    pub render_seconds: f64,
    /// Seconds of them that a graphics processor worked, by its own clock, if it has one.
    pub device_seconds: Option<f64>,
}

impl FrameStatistics {
    /// Adds the totals of another frame.
    pub fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.rays_hit += other.rays_hit;
        self.rays_terminated += other.rays_terminated;
        self.samples += other.samples;
        self.samples_visible += other.samples_visible;
        self.samples_skipped += other.samples_skipped;
        self.light = [self.light[0] + other.light[0], self.light[1] + other.light[1]];
        self.waiting += other.waiting;
        self.setup_seconds += other.setup_seconds;
        self.render_seconds += other.render_seconds;
        self.device_seconds = match (self.device_seconds, other.device_seconds) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
    }
}
