//! What draws: the flags that make the renderer and leave the picture alone.

use std::num::NonZero;

use pellucid::field::{Threads, thread_count};
use pellucid::gpu::{AdapterChoice, Ceiling, GpuError, GpuRenderer, Interpolation, Passes};
use pellucid::scene::Technique;
use pellucid::{Backend, CpuRenderer, InstructionSet, RenderError, Renderer};

use super::failure::Failure;
use super::values;

/// Backends by name.
pub const BACKENDS: [(&str, Backend); 3] = [("auto", Backend::Auto), ("cpu", Backend::Cpu), ("gpu", Backend::Gpu)];
const SETS: [(&str, InstructionSet); 4] = [
    ("auto", InstructionSet::Auto),
    ("avx512", InstructionSet::Avx512),
    ("avx2", InstructionSet::Avx2),
    ("baseline", InstructionSet::Baseline),
];
const INTERPOLATIONS: [(&str, Interpolation); 2] =
    [("hardware", Interpolation::Hardware), ("exact", Interpolation::Exact)];
const PASSES: [(&str, Passes); 2] = [("single", Passes::Single), ("wavefront", Passes::Wavefront)];
const MOST_THREADS: u16 = 1024;

/// As many threads as there are cores.
pub fn cores() -> u16 {
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    cores.min(MOST_THREADS.into()) as u16
}

#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Renderer")]
pub struct Engine {
    /// What draws
    ///
    /// auto takes graphics hardware where there is some, and the processor otherwise. gpu takes the best
    /// adapter there is, one that runs on the processor if there is no hardware, as auto does for slices,
    /// which the processor does not draw.
    #[arg(long, value_name = "BACKEND", value_parser = values::word(&BACKENDS), default_value = "auto")]
    backend: Backend,
    #[command(flatten)]
    processor: Processor,
    /// Graphics adapter to draw with, by a part of its description; 'software' is one that runs on the
    /// processor. Implies --backend gpu [default: the best hardware]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Between voxels on a graphics adapter: its texture unit, fast, or exactly as the processor does
    /// [default: hardware]
    #[arg(long, value_name = "HOW", value_parser = values::word(&INTERPOLATIONS))]
    interpolation: Option<Interpolation>,
    /// Work on a graphics adapter: every ray to its end, or all rays for a while and then those that are
    /// not done, so that no piece of work is long; the picture is the same [default: single]
    #[arg(long, value_name = "HOW", value_parser = values::word(&PASSES))]
    passes: Option<Passes>,
    /// Memory to use on a graphics adapter, in MiB; larger volumes are drawn brick by brick
    /// [default: all there is]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 24))]
    gpu_memory: Option<u64>,
}

/// How the processor draws.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Renderer")]
pub struct Processor {
    /// Threads to draw with, 1 to 1024; the picture is the same for any number [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)))]
    threads: Option<u16>,
    /// Processor instructions to draw with; the picture depends on them by roundings only [default: auto]
    #[arg(long, value_name = "SET", value_parser = values::word(&SETS))]
    simd: Option<InstructionSet>,
}

impl Processor {
    /// The renderer asked for, on the threads that the command runs on.
    pub fn renderer(&self) -> Result<CpuRenderer, RenderError> {
        Ok(CpuRenderer::new().with_instructions(self.simd.unwrap_or(InstructionSet::Auto))?)
    }

    /// Threads asked for, or as many as there are cores.
    pub fn threads(&self) -> u16 {
        self.threads.unwrap_or_else(cores)
    }
}

impl Engine {
    /// Refuses flags that contradict the backend, and tells of those that do nothing on it.
    pub fn check(&self) -> Result<Vec<String>, Failure> {
        let of_adapters = [
            (self.adapter.is_some(), "--adapter"),
            (self.interpolation.is_some(), "--interpolation"),
            (self.passes.is_some(), "--passes"),
            (self.gpu_memory.is_some(), "--gpu-memory"),
        ];
        let of_processors =
            [(self.processor.threads.is_some(), "--threads"), (self.processor.simd.is_some(), "--simd")];
        let named = |flags: &[(bool, &'static str)]| {
            flags.iter().filter(|(given, _)| *given).map(|(_, flag)| *flag).collect::<Vec<_>>()
        };
        if let (Backend::Cpu, Some(flag)) = (self.backend, named(&of_adapters).first()) {
            let message = format_args!("{flag} is about graphics adapters, and --backend cpu draws on the processor");
            return Err(Failure::input(message).hint(format!("leave out {flag}, or --backend cpu")));
        }
        let processor_draws = self.backend != Backend::Gpu && self.adapter.is_none();
        let idle = if processor_draws { Vec::new() } else { named(&of_processors) };
        let tell = |flag| format!("{flag} has no effect: it is about the processor, and a graphics adapter draws");
        Ok(idle.into_iter().map(tell).collect())
    }

    /// The same, on a graphics adapter of any kind where the choice is open and the processor lacks the technique.
    pub fn suited_to(&self, technique: &Technique) -> Self {
        let open = self.backend == Backend::Auto && self.adapter.is_none();
        if open && technique.needs().blending { self.on(Backend::Gpu) } else { self.clone() }
    }

    /// The renderer asked for.
    pub fn renderer(&self) -> Result<Renderer, RenderError> {
        let renderer = self.backend()?;
        let threads = usize::from(self.threads());
        // The command runs on threads already, seldom on others than these.
        if threads == thread_count() {
            return Ok(renderer);
        }
        Ok(renderer.on_threads(Threads::new(threads).map_err(pellucid::cpu::RenderError::from)?))
    }

    fn backend(&self) -> Result<Renderer, RenderError> {
        if self.backend == Backend::Gpu || self.adapter.is_some() {
            return Ok(self.gpu()?.into());
        }
        let cpu = self.processor.renderer()?;
        let gpu = (self.backend == Backend::Auto).then(|| self.gpu()).transpose();
        Ok(match gpu {
            Ok(Some(gpu)) => Renderer::from(gpu).with_stand_in(cpu),
            Err(why) => Renderer::from(cpu).without_gpu(why),
            Ok(None) => cpu.into(),
        })
    }

    fn gpu(&self) -> Result<GpuRenderer, GpuError> {
        let choice = match self.adapter.as_deref() {
            None if self.backend == Backend::Gpu => AdapterChoice::Any,
            None => AdapterChoice::Hardware,
            Some("software") => AdapterChoice::Software,
            Some(name) => AdapterChoice::Named(name.to_owned()),
        };
        let ceiling = Ceiling { memory: self.gpu_memory.map(|mib| mib << 20), ..Ceiling::default() };
        let interpolation = self.interpolation.unwrap_or(Interpolation::Hardware);
        let passes = self.passes.unwrap_or(Passes::Single);
        Ok(GpuRenderer::new(&choice, &ceiling)?.with_interpolation(interpolation).with_passes(passes))
    }

    /// The same with this backend.
    pub fn on(&self, backend: Backend) -> Self {
        // An adapter that was named stays the one of every GPU picture.
        let adapter = self.adapter.clone().filter(|_| backend != Backend::Cpu);
        Self { backend, adapter, ..self.clone() }
    }

    /// Threads asked for, or as many as there are cores.
    pub fn threads(&self) -> u16 {
        self.processor.threads()
    }

    /// The same with this number of threads.
    pub fn with_threads(&self, threads: u16) -> Self {
        let processor = Processor { threads: Some(threads), ..self.processor.clone() };
        Self { processor, ..self.clone() }
    }
}
