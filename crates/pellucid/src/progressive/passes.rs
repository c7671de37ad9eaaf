//! Pictures of paths, pass by pass: there is a whole picture all the time, and a better one after every pass.

use std::time::Instant;

use pellucid_scene::{Control, Frame, PathTrace, Stage, Technique, denoise};

use super::mean::average;
use super::rays::another;
use crate::{RenderError, Renderer};

/// Paths a pixel of the first pass: the least that tells of its noise.
const FIRST: u32 = 2;

/// Paths a pixel from which on a pass is not as large as all before it, but a quarter of that.
const SOME: u32 = 64;

/// Traces the paths of a stage a few a pixel at a time, so that whoever stops it keeps what there is: the mean of
/// the passes that were finished. It is the picture of [`Renderer::render`] but for its noise, which belongs to other
/// random numbers, and its depth and normal, which are those of the largest pass.
///
/// ```
/// use pellucid::scene::{Control, PathTrace, SampleSource, Scene, Source};
/// use pellucid::{Backend, Passes, Renderer, load};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let ball = SampleSource { name: "ball".into(), dims: Some([16; 3]), voxel_type: None };
/// let mut scene = Scene::of(Source::Sample(ball));
/// (scene.image.width, scene.image.height) = (16, 12);
/// let (stage, _) = scene.resolve(&load(&scene, "")?.0)?;
/// let settings = PathTrace { samples: 12, ..PathTrace::default() };
/// let mut passes = Passes::new(Renderer::new(Backend::Cpu)?, stage, settings);
/// while passes.step(&Control::default())? {
///     println!("{} of {} paths", passes.taken(), passes.asked());
/// }
/// let frame = passes.into_frame(&Control::default())?;
/// assert_eq!(frame.color.len(), 16 * 12);
/// # Ok(())
/// # }
/// ```
pub struct Passes {
    renderer: Renderer,
    stage: Stage,
    settings: PathTrace,
    asked: u32,
    taken: u32,
    passes: u32,
    /// Paths of the pass that the depth is of.
    largest: u32,
    mean: Frame,
    next: Frame,
}

impl Passes {
    /// Passes over a stage by these settings, whatever its own technique.
    pub fn new(renderer: Renderer, stage: Stage, settings: PathTrace) -> Self {
        let (mean, next) = (Frame::default(), Frame::default());
        let asked = settings.samples;
        Self { renderer, stage, settings, asked, taken: 0, passes: 0, largest: 0, mean, next }
    }

    /// The same with so many times the paths a pixel that the stage asks for.
    pub fn with_frames(self, frames: u32) -> Self {
        Self { asked: self.settings.samples.saturating_mul(frames.max(1)), ..self }
    }

    /// Paths a pixel, at most, that the finished passes have followed.
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// Paths a pixel, at most, of the whole picture.
    pub fn asked(&self) -> u32 {
        self.asked
    }

    /// Draws another pass, and tells whether there was one to draw.
    ///
    /// # Errors
    /// [`RenderError`], among them [`RenderError::Cancelled`]; the passes before it stay, and another step tries the
    /// same again.
    pub fn step(&mut self, control: &Control) -> Result<bool, RenderError> {
        let paths = self.size();
        if paths == 0 {
            return Ok(false);
        }
        let (before, asked) = (f64::from(self.taken), f64::from(self.asked));
        let report = |share: f64| control.report((before + share * f64::from(paths)) / asked);
        let control = Control { progress: Some(&report), ..*control };
        let frame = if self.taken == 0 { &mut self.mean } else { &mut self.next };
        self.stage.technique = Technique::PathTrace(PathTrace {
            samples: paths,
            // Of a mean of independent passes, weighted by their paths, this is the noise that was asked for.
            noise: self.settings.noise * (f64::from(self.settings.samples) / f64::from(paths)).sqrt() as f32,
            denoise: false,
            ..self.settings.clone()
        });
        let own = self.stage.quality.jitter;
        self.stage.quality.jitter = another(own, self.passes);
        let drawn = self.renderer.render_into(&self.stage, &control, frame);
        self.stage.quality.jitter = own;
        drawn?;
        self.passes += 1;
        self.taken += paths;
        if self.passes > 1 {
            average(&mut self.mean, &self.next, paths as f32 / self.taken as f32);
            if paths > self.largest {
                std::mem::swap(&mut self.mean.depth, &mut self.next.depth);
                std::mem::swap(&mut self.mean.normal, &mut self.next.normal);
            }
        }
        self.largest = self.largest.max(paths);
        Ok(true)
    }

    /// The mean of the passes that were finished, without noise as far as the stage asks for that; empty before the
    /// first.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub fn into_frame(mut self, control: &Control) -> Result<Frame, RenderError> {
        if self.settings.denoise && self.taken > 0 {
            let started = Instant::now();
            denoise(&mut self.mean, self.taken, control).map_err(|_| RenderError::Cancelled)?;
            self.mean.statistics.render_seconds += started.elapsed().as_secs_f64();
        }
        Ok(self.mean)
    }

    /// Paths a pixel of the next pass: as many as before, or a quarter of that once there are some, so that little is
    /// lost with a pass that is not finished. Where pixels are done at some noise, each takes a least number of paths
    /// in every pass, and passes are few.
    fn size(&self) -> u32 {
        let left = self.asked - self.taken;
        let size = match self.taken {
            _ if self.settings.noise > 0.0 => self.taken.saturating_mul(3).max(PathTrace::LEAST_TO_JUDGE),
            0 => FIRST,
            taken if taken < SOME => taken.min(SOME / 4),
            taken => taken / 4,
        };
        // What would be left for a small last pass is taken along.
        if left <= size.saturating_add(size / 2) { left } else { size }
    }
}
