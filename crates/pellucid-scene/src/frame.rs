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
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { reason } => write!(f, "the picture is empty: {reason}"),
        }
    }
}

impl Frame {
    /// An empty picture.
    pub fn new(width: usize, height: usize) -> Self {
        let n = width * height;
        Self {
            width,
            height,
            color: vec![[0.0; 4]; n],
            depth: vec![f32::INFINITY; n],
            normal: vec![[0.0; 3]; n],
            samples: vec![0; n],
            ..Self::default()
        }
    }
}
