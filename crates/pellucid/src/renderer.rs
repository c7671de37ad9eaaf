//! Which backend draws.

use std::fmt;

use pellucid_cpu::{CpuRenderer, InstructionSet};
use pellucid_field::Threads;
#[cfg(feature = "gpu")]
use pellucid_field::parallel;
#[cfg(feature = "gpu")]
use pellucid_gpu::{AdapterChoice, Ceiling, GpuRenderer};
#[cfg(feature = "gpu")]
use pellucid_scene::RenderWarning;
use pellucid_scene::{Choice, Control, Frame, Stage};

/// What draws a stage. Every backend draws the same picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// The fastest one there is: graphics hardware, or the processor if there is none. A graphics
    /// driver that runs on the processor is never taken.
    #[default]
    Auto,
    /// Rays on all processor cores.
    Cpu,
    /// A graphics processor, through Vulkan, Metal or DX12.
    #[cfg(feature = "gpu")]
    Gpu,
}

impl Backend {
    /// Whether it has all that a stage asks for; automatically chosen, one of them has.
    pub fn draws(self, stage: &Stage) -> bool {
        match self {
            Self::Auto => true,
            Self::Cpu => CpuRenderer::draws(stage),
            #[cfg(feature = "gpu")]
            Self::Gpu => GpuRenderer::draws(stage),
        }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            #[cfg(feature = "gpu")]
            Self::Gpu => "gpu",
        })
    }
}

/// Why a frame was not drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
    /// What the CPU backend says.
    #[error(transparent)]
    Cpu(pellucid_cpu::RenderError),
    /// What the GPU backend says.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(pellucid_gpu::GpuError),
}

impl From<pellucid_cpu::RenderError> for RenderError {
    fn from(error: pellucid_cpu::RenderError) -> Self {
        match error {
            pellucid_cpu::RenderError::Cancelled => Self::Cancelled,
            error => Self::Cpu(error),
        }
    }
}

#[cfg(feature = "gpu")]
impl From<pellucid_gpu::GpuError> for RenderError {
    fn from(error: pellucid_gpu::GpuError) -> Self {
        match error {
            pellucid_gpu::GpuError::Cancelled => Self::Cancelled,
            error => Self::Gpu(error),
        }
    }
}

/// Draws stages. Keep one for several frames: what depends on the data alone is made once.
pub struct Renderer {
    engine: Engine,
    /// What the processor does beside a graphics adapter runs on these, if they are said.
    #[cfg(feature = "gpu")]
    threads: Option<Threads>,
    /// Why graphics hardware is not used, if it was looked for.
    #[cfg(feature = "gpu")]
    without_gpu: Option<pellucid_gpu::GpuError>,
    /// What draws stages that the graphics adapter lacks something for.
    #[cfg(feature = "gpu")]
    stand_in: Option<Box<CpuRenderer>>,
}

enum Engine {
    Cpu(Box<CpuRenderer>),
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuRenderer>),
}

impl From<Engine> for Renderer {
    fn from(engine: Engine) -> Self {
        Self {
            engine,
            #[cfg(feature = "gpu")]
            threads: None,
            #[cfg(feature = "gpu")]
            without_gpu: None,
            #[cfg(feature = "gpu")]
            stand_in: None,
        }
    }
}

impl Default for Renderer {
    fn default() -> Self {
        CpuRenderer::new().into()
    }
}

impl From<CpuRenderer> for Renderer {
    fn from(renderer: CpuRenderer) -> Self {
        Engine::Cpu(Box::new(renderer)).into()
    }
}

#[cfg(feature = "gpu")]
impl From<GpuRenderer> for Renderer {
    fn from(renderer: GpuRenderer) -> Self {
        Engine::Gpu(Box::new(renderer)).into()
    }
}

impl Renderer {
    /// A renderer on all cores, or on the best graphics hardware. Chosen by [`Backend::Auto`], the processor
    /// draws what the adapter does not, and what it has no memory for or was lost over; frames say so.
    ///
    /// # Errors
    /// [`RenderError`] if the backend is not to be had; the CPU always is.
    pub fn new(backend: Backend) -> Result<Self, RenderError> {
        match backend {
            Backend::Cpu => Ok(Self::default()),
            #[cfg(not(feature = "gpu"))]
            Backend::Auto => Ok(Self::default()),
            #[cfg(feature = "gpu")]
            Backend::Auto => Ok(hardware().map_or_else(
                |error| Self::default().without_gpu(error),
                |gpu| Self::from(gpu).with_stand_in(CpuRenderer::new()),
            )),
            #[cfg(feature = "gpu")]
            Backend::Gpu => Ok(hardware()?.into()),
        }
    }

    /// A renderer whose CPU work runs on `threads` threads of its own. The picture does not depend
    /// on their number.
    ///
    /// # Errors
    /// [`RenderError::Cpu`] if there are none, too many, or the system refuses them.
    pub fn with_threads(backend: Backend, threads: usize) -> Result<Self, RenderError> {
        let threads = Threads::new(threads).map_err(pellucid_cpu::RenderError::from)?;
        Ok(Self::new(backend)?.on_threads(threads))
    }

    /// The same renderer with its CPU work on other threads: all of it if the processor draws, else what
    /// it does beside a graphics adapter (tables, blocks) and instead of it.
    pub fn on_threads(self, threads: Threads) -> Self {
        let engine = match self.engine {
            Engine::Cpu(cpu) => Engine::Cpu(Box::new(cpu.on_threads(threads.clone()))),
            #[cfg(feature = "gpu")]
            engine @ Engine::Gpu(_) => engine,
        };
        Self {
            engine,
            #[cfg(feature = "gpu")]
            stand_in: self.stand_in.map(|cpu| Box::new(cpu.on_threads(threads.clone()))),
            #[cfg(feature = "gpu")]
            threads: Some(threads),
            #[cfg(feature = "gpu")]
            without_gpu: self.without_gpu,
        }
    }

    /// The same renderer with other processor instructions, if the processor draws. The picture
    /// depends on them by roundings only.
    ///
    /// # Errors
    /// [`RenderError::Cpu`] if the machine lacks them.
    pub fn with_instructions(self, set: InstructionSet) -> Result<Self, RenderError> {
        let engine = match self.engine {
            Engine::Cpu(cpu) => Engine::Cpu(Box::new(cpu.with_instructions(set)?)),
            #[cfg(feature = "gpu")]
            engine @ Engine::Gpu(_) => engine,
        };
        Ok(Self { engine, ..self })
    }

    /// The same renderer, which tells among its choices why no graphics hardware draws.
    #[cfg(feature = "gpu")]
    pub fn without_gpu(self, why: pellucid_gpu::GpuError) -> Self {
        Self { without_gpu: Some(why), ..self }
    }

    /// The same renderer, in which the processor draws what the graphics adapter does not have, and what it
    /// fails over because it is lost or has too little memory; frames say so.
    #[cfg(feature = "gpu")]
    pub fn with_stand_in(self, cpu: CpuRenderer) -> Self {
        Self { stand_in: Some(Box::new(cpu)), ..self }
    }

    /// The processor instructions that are used, never [`InstructionSet::Auto`]; `None` if another
    /// processor draws.
    pub fn instructions(&self) -> Option<InstructionSet> {
        match &self.engine {
            Engine::Cpu(cpu) => Some(cpu.instructions()),
            #[cfg(feature = "gpu")]
            Engine::Gpu(_) => None,
        }
    }

    /// The backend that draws; never [`Backend::Auto`].
    pub fn backend(&self) -> Backend {
        match &self.engine {
            Engine::Cpu(_) => Backend::Cpu,
            #[cfg(feature = "gpu")]
            Engine::Gpu(_) => Backend::Gpu,
        }
    }

    /// What draws, in words: "cpu", or the graphics adapter.
    pub fn describe(&self) -> String {
        match &self.engine {
            Engine::Cpu(_) => "cpu".to_owned(),
            #[cfg(feature = "gpu")]
            Engine::Gpu(gpu) => gpu.device().adapter.to_string(),
        }
    }

    /// The GPU backend, if it draws.
    #[cfg(feature = "gpu")]
    pub fn gpu(&self) -> Option<&GpuRenderer> {
        match &self.engine {
            Engine::Cpu(_) => None,
            Engine::Gpu(gpu) => Some(gpu),
        }
    }

    /// What was chosen to draw a stage with: the backend if that was left open, and on a graphics adapter
    /// its limits and the memory that the stage takes.
    ///
    /// # Errors
    /// [`RenderError`] if the stage cannot be drawn.
    pub fn choices(&mut self, stage: &Stage) -> Result<Vec<Choice>, RenderError> {
        match &mut self.engine {
            #[cfg(not(feature = "gpu"))]
            Engine::Cpu(_) => {
                // Nothing is chosen where there is one backend.
                let _ = stage;
                Ok(Vec::new())
            }
            #[cfg(feature = "gpu")]
            Engine::Cpu(_) => {
                let choice = |why| Choice::new("backend", "cpu", format!("cpu, as there is {why}"));
                Ok(self.without_gpu.iter().map(choice).collect())
            }
            #[cfg(feature = "gpu")]
            Engine::Gpu(gpu) => {
                let planned = match (&self.stand_in, GpuRenderer::lacks(stage)) {
                    (Some(_), Some(what)) => Err(format!("the GPU backend has no {what}")),
                    (stand_in, _) => match on(&self.threads, || gpu.plan(stage)) {
                        Err(error) if stand_in.is_some() && gives_out(&error, stage) => Err(error.to_string()),
                        planned => Ok(planned?),
                    },
                };
                let plan = match planned {
                    Ok(plan) => plan,
                    Err(why) => return Ok(vec![Choice::new("backend", "cpu", format!("cpu, as {why}"))]),
                };
                let (device, interpolation) = (gpu.device(), gpu.interpolation());
                let chosen = format!("{}; {}; {interpolation} interpolation", device.adapter, device.capabilities);
                let memory = Choice::new("graphics memory", plan.total(), plan.to_string());
                Ok(vec![Choice::new("backend", device.adapter.name.as_str(), chosen), memory])
            }
        }
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// [`RenderError`]; nothing of an unfinished frame is returned.
    pub fn render(&mut self, stage: &Stage, control: &Control) -> Result<Frame, RenderError> {
        let mut frame = Frame::default();
        self.render_into(stage, control, &mut frame)?;
        Ok(frame)
    }

    /// Draws a frame into one that is there; the memory of its pictures is used again if they have
    /// the right size.
    ///
    /// # Errors
    /// [`RenderError`]; the frame is then what it was before.
    pub fn render_into(&mut self, stage: &Stage, control: &Control, frame: &mut Frame) -> Result<(), RenderError> {
        match &mut self.engine {
            Engine::Cpu(cpu) => Ok(cpu.render_into(stage, control, frame)?),
            #[cfg(feature = "gpu")]
            Engine::Gpu(gpu) => {
                let threads = &self.threads;
                let mut draw = || on(threads, || gpu.render_into(stage, control, frame));
                let Some(cpu) = &mut self.stand_in else { return Ok(draw()?) };
                let why = match GpuRenderer::lacks(stage) {
                    Some(what) => format!("the GPU backend has no {what}"),
                    None => match draw() {
                        Err(error) if gives_out(&error, stage) => error.to_string(),
                        drawn => return Ok(drawn?),
                    },
                };
                cpu.render_into(stage, control, frame)?;
                let reason = format!("{why}: the processor drew this picture");
                frame.warnings.push(RenderWarning::Fallback { reason });
                Ok(())
            }
        }
    }
}

/// Does work on these threads, or on those of all parallel work.
#[cfg(feature = "gpu")]
fn on<R: Send>(threads: &Option<Threads>, work: impl FnOnce() -> R + Send) -> R {
    match threads {
        Some(threads) => threads.run(work),
        None => parallel(work),
    }
}

/// Whether an adapter failed that was there, or has too little room, over a stage that the processor can draw.
#[cfg(feature = "gpu")]
fn gives_out(error: &pellucid_gpu::GpuError, stage: &Stage) -> bool {
    use pellucid_gpu::GpuError;
    let too_much = matches!(error, GpuError::Memory { .. } | GpuError::Budget { .. } | GpuError::Volumes { .. });
    (too_much || matches!(error, GpuError::Lost { .. })) && CpuRenderer::draws(stage)
}

/// A renderer on the best graphics hardware.
#[cfg(feature = "gpu")]
fn hardware() -> Result<GpuRenderer, pellucid_gpu::GpuError> {
    GpuRenderer::new(&AdapterChoice::Hardware, &Ceiling::default())
}
