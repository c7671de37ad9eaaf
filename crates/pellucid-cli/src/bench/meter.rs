//! Times frames.

use std::hint::black_box;
use std::time::Instant;

use pellucid::scene::{Cancel, Control, Frame, Stage};
use pellucid::{RenderError, Renderer};

use super::timing::{Lap, Timing};
use crate::engine::Engine;
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Progress;

/// How often to draw, and who may stop it.
#[derive(Clone)]
pub struct Plan<'a> {
    /// What the renderer is made of.
    pub engine: Engine,
    /// Frames timed, at least one.
    pub frames: usize,
    /// Frames drawn before them.
    pub warmup: usize,
    /// Ctrl-C.
    pub cancel: &'a Cancel,
    /// Whether there is no bar.
    pub quiet: bool,
}

/// A renderer kept from frame to frame, and a clock.
pub struct Meter<'a> {
    plan: Plan<'a>,
    threads: u16,
    renderer: Renderer,
}

impl<'a> Meter<'a> {
    /// Starts the renderer. Its number of threads is settled here, so that what is said of a thread
    /// is true.
    pub fn new(plan: Plan<'a>) -> Result<Self, RenderError> {
        let threads = plan.engine.threads();
        let renderer = plan.engine.with_threads(threads).renderer()?;
        Ok(Self { plan, threads, renderer })
    }

    /// The same renderer kind on another number of threads.
    pub fn with_threads(&self, threads: u16) -> Result<Self, RenderError> {
        Self::new(Plan { engine: self.plan.engine.with_threads(threads), ..self.plan })
    }

    /// What draws, in words.
    pub fn describe(&self) -> String {
        self.renderer.describe()
    }

    /// What the graphics adapter can do, if one draws.
    pub fn capabilities(&self) -> Option<String> {
        self.renderer.gpu().map(|gpu| gpu.device().capabilities.to_string())
    }

    /// Threads that draw.
    pub fn threads(&self) -> u16 {
        self.threads
    }

    /// Frames timed by [`Meter::measure`].
    pub fn frames(&self) -> usize {
        self.plan.frames
    }

    /// Times one frame drawn into `frame`: the `change` of the stage, drawing it, and its picture as 8-bit numbers in
    /// memory.
    pub fn frame(
        &mut self,
        stage: &mut Stage,
        frame: &mut Frame,
        change: impl FnOnce(&mut Stage) -> Result<(), Failure>,
    ) -> Result<Lap, Failure> {
        let control = Control { cancel: Some(self.plan.cancel), ..Control::default() };
        interrupt::gracefully(|| {
            let started = Instant::now();
            change(stage)?;
            self.renderer.render_into(stage, &control, frame)?;
            let encoding = Instant::now();
            black_box(frame.to_rgba8(&stage.image));
            let encode = encoding.elapsed().as_secs_f64();
            let total = started.elapsed().as_secs_f64();
            Ok(Lap { total, encode, statistics: frame.statistics })
        })
    }

    /// Warms up with the first frame, then times all; `change` makes the stage that of frame k. Also
    /// gives the first frame timed.
    pub fn measure(
        &mut self,
        stage: &mut Stage,
        mut change: impl FnMut(usize, &mut Stage) -> Result<(), Failure>,
    ) -> Result<(Timing, Frame), Failure> {
        let progress = Progress::new("timing", self.plan.quiet);
        let mut frame = Frame::default();
        for _ in 0..self.plan.warmup {
            self.frame(stage, &mut frame, |stage| change(0, stage))?;
        }
        let mut laps = vec![self.frame(stage, &mut frame, |stage| change(0, stage))?];
        let first = frame.clone();
        for k in 1..self.plan.frames {
            progress.report(k as f64 / self.plan.frames as f64);
            laps.push(self.frame(stage, &mut frame, |stage| change(k, stage))?);
        }
        Ok((Timing { laps, threads: self.threads }, first))
    }
}
