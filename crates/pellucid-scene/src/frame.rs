//! What a backend gives back.

use crate::{FrameStatistics, RenderWarning};

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
