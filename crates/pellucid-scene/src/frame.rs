//! What a backend gives back.

use std::fmt;

use crate::Stage;

/// A drawn picture and what was measured on the way; rows from the top, `width * height` each.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB radiance times coverage, and coverage (associated alpha); no background.
    pub color: Vec<[f32; 4]>,
    /// The share of red, green and blue light from behind that is held back, where that is not the same for all
    /// (K-13): coverage is then their mean, which is what is left of them on a transparent background. Else empty.
    pub opacities: Vec<[f32; 3]>,
    /// Distance from the eye (along the ray, world units) to where the ray's opacity first reaches
    /// one half, to the surface, or to the projected extreme; infinite where there is none.
    pub depth: Vec<f32>,
    /// Unit world normal at that depth, out of the surface towards lower values, whichever side of it the eye is
    /// on, also where a clip or the box cuts through matter; of a slice, its own. Zero where there is none.
    pub normal: Vec<[f32; 3]>,
    /// Field samples taken for the pixel, gradient taps not counted.
    pub samples: Vec<u32>,
    /// Linear RGB radiance behind every pixel where the background is the environment, else nothing.
    pub backdrop: Vec<[f32; 3]>,
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
    /// Luminance that paths brought, and what of it a firefly clamp held back, where that is counted.
    pub light: [f64; 2],
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
    /// Matter is so dense that paths are scattered very often and get nowhere, which takes very long.
    Dense {
        /// The volume, by its number.
        volume: usize,
        /// World distance that its opacities hold for.
        unit_distance: f64,
        /// Largest optical depth in a voxel.
        in_voxel: f64,
        /// The same over the diagonal of its box.
        across: f64,
        /// Mean spacing of its voxels in world units.
        voxel: f64,
    },
}

impl RenderWarning {
    /// A firefly clamp held light back, if these totals say so.
    pub fn clamped(statistics: &FrameStatistics) -> Option<Self> {
        let [brought, held_back] = statistics.light;
        (held_back > 0.0).then(|| {
            let share = 100.0 * held_back / brought;
            let reason = format!("the firefly clamp held back {share:.2} % of the light that paths brought");
            Self::Bias { reason }
        })
    }

    /// The picture of a stage is empty although this many rays met the volume.
    pub fn empty(stage: &Stage, rays_hit: u64) -> Self {
        Self::Empty { reason: stage.why_empty(rays_hit) }
    }
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { reason } => write!(f, "the picture is empty: {reason}"),
            Self::Memory { reason } | Self::Bias { reason } | Self::Fallback { reason } => f.write_str(reason),
            Self::Dense { volume, unit_distance, in_voxel, across, voxel } => write!(
                f,
                "volumes[{volume}] has an optical depth of up to {in_voxel:.0} in a voxel and of {across:.3e} across: \
                 paths are scattered very often, and take long; its transfer function's unit_distance is \
                 {unit_distance:e}, a voxel {voxel:e}: opacities mostly hold for a voxel or more"
            ),
        }
    }
}

impl Frame {
    /// Memory of a pixel with all that a frame holds of it.
    pub const PIXEL_BYTES: usize = size_of::<[f32; 4]>() + size_of::<[f32; 3]>() + 3 * size_of::<f32>();

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
        self.opacities.clear();
        fill(&mut self.depth, n, f32::INFINITY);
        fill(&mut self.normal, n, [0.0; 3]);
        fill(&mut self.samples, n, 0);
        fill(&mut self.noise, n, 0.0);
        self.backdrop.clear();
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
        self.light = [self.light[0] + other.light[0], self.light[1] + other.light[1]];
        self.setup_seconds += other.setup_seconds;
        self.render_seconds += other.render_seconds;
        self.device_seconds = match (self.device_seconds, other.device_seconds) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
    }
}
