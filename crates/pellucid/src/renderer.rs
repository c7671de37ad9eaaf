//! Which backend draws.

use std::fmt;

use pellucid_cpu::{CpuRenderer, InstructionSet, RenderError};
use pellucid_scene::{Control, Frame, Stage};

/// What draws a stage. Every backend draws the same picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// The fastest one there is.
    #[default]
    Auto,
    /// Rays on all processor cores.
    Cpu,
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
        })
    }
}

/// Draws stages. Keep one for several frames: what depends on the data alone is made once.
#[derive(Default)]
pub struct Renderer {
    cpu: CpuRenderer,
}

impl Renderer {
    /// A renderer on all cores.
    ///
    /// # Errors
    /// [`RenderError`] if the backend is not to be had; the CPU always is.
    pub fn new(backend: Backend) -> Result<Self, RenderError> {
        match backend {
            Backend::Auto | Backend::Cpu => Ok(Self::default()),
        }
    }

    /// A renderer whose CPU work runs on `threads` threads of its own. The picture does not depend
    /// on their number.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if there are none, too many, or the system refuses them.
    pub fn with_threads(backend: Backend, threads: usize) -> Result<Self, RenderError> {
        match backend {
            Backend::Auto | Backend::Cpu => Ok(Self { cpu: CpuRenderer::with_threads(threads)? }),
        }
    }

    /// The same renderer with other processor instructions. The picture depends on them by
    /// roundings only.
    ///
    /// # Errors
    /// [`RenderError::Instructions`] if the machine lacks them.
    pub fn with_instructions(self, set: InstructionSet) -> Result<Self, RenderError> {
        Ok(Self { cpu: self.cpu.with_instructions(set)? })
    }

    /// The processor instructions that are used; never [`InstructionSet::Auto`].
    pub fn instructions(&self) -> InstructionSet {
        self.cpu.instructions()
    }

    /// The backend that draws; never [`Backend::Auto`].
    pub fn backend(&self) -> Backend {
        Backend::Cpu
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// [`RenderError`]; nothing of an unfinished frame is returned.
    pub fn render(&mut self, stage: &Stage, control: &Control) -> Result<Frame, RenderError> {
        self.cpu.render(stage, control)
    }

    /// Draws a frame into one that is there; the memory of its pictures is used again if they have
    /// the right size.
    ///
    /// # Errors
    /// [`RenderError`]; the frame is then what it was before.
    pub fn render_into(&mut self, stage: &Stage, control: &Control, frame: &mut Frame) -> Result<(), RenderError> {
        self.cpu.render_into(stage, control, frame)
    }
}
