//! What a backend gives back.

use std::fmt;

/// A drawn picture and what was measured on the way; rows from the top, `width * height` each.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB radiance times coverage, and coverage (associated alpha); no background.
    pub color: Vec<[f32; 4]>,
    /// Distance from the eye (along the ray, world units) to where the ray's opacity first reaches
    /// one half, to the surface, or to the projected extreme; infinite where there is none.
    pub depth: Vec<f32>,
    /// Unit world normal at that depth, out of the surface towards lower values; zero where there
    /// is none.
    pub normal: Vec<[f32; 3]>,
    /// Field samples taken for the pixel, gradient taps not counted.
    pub samples: Vec<u32>,
    /// Standard error of the pixel's luminance where it is a mean of random samples, else zero.
    pub noise: Vec<f32>,
    /// Totals.
    pub statistics: FrameStatistics,
    /// What the user should know.
    pub warnings: Vec<RenderWarning>,
}

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
    /// Seconds to build tables and block maps.
    pub setup_seconds: f64,
    /// Seconds to draw.
    pub render_seconds: f64,
    /// Seconds of them that a graphics processor worked, by its own clock, if it has one.
    pub device_seconds: Option<f64>,
}

/// Something a user should hear of although the picture was drawn.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RenderWarning {
    /// Nothing of the volume is in the picture.
    Empty {
        /// Why, as far as known.
        reason: String,
    },
    /// Memory was short, and the picture was drawn with less of it.
    Memory {
        /// What was short, and what was done.
        reason: String,
    },
    /// Light was left out of the picture on purpose.
    Bias {
        /// What was left out, and how much of it.
        reason: String,
    },
    /// Something was asked for that could not be had, and something else stands for it.
    Fallback {
        /// What was missing, and what was done.
        reason: String,
    },
}

impl RenderWarning {
    /// The picture is empty although this many rays met the volume.
    pub fn empty(rays_hit: u64) -> Self {
        let reason = if rays_hit == 0 {
            "no ray meets the volume; look at the camera and the clips"
        } else {
            "the rays meet the volume but no sample has opacity; look at the transfer function and the window"
        };
        Self::Empty { reason: reason.to_owned() }
    }
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { reason } => write!(f, "the picture is empty: {reason}"),
            Self::Memory { reason } | Self::Bias { reason } | Self::Fallback { reason } => f.write_str(reason),
        }
    }
}

impl Frame {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        let mut frame = Self::default();
        frame.clear(width, height);
        frame
    }

    /// Makes this an empty picture of some size, in the memory it has as far as that reaches.
    pub fn clear(&mut self, width: usize, height: usize) {
        fn fill<T: Copy>(plane: &mut Vec<T>, n: usize, value: T) {
            plane.clear();
            plane.resize(n, value);
        }
        let n = width * height;
        (self.width, self.height) = (width, height);
        fill(&mut self.color, n, [0.0; 4]);
        fill(&mut self.depth, n, f32::INFINITY);
        fill(&mut self.normal, n, [0.0; 3]);
        fill(&mut self.samples, n, 0);
        fill(&mut self.noise, n, 0.0);
        self.statistics = FrameStatistics::default();
        self.warnings.clear();
    }
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
        self.setup_seconds += other.setup_seconds;
        self.render_seconds += other.render_seconds;
        self.device_seconds = match (self.device_seconds, other.device_seconds) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
    }
}
