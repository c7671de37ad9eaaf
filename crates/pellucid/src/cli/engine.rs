//! What draws: the flags that make the renderer and leave the picture alone.

use std::num::NonZero;

use pellucid::{Backend, InstructionSet, RenderError, Renderer};

use super::values;

const BACKENDS: [(&str, Backend); 2] = [("auto", Backend::Auto), ("cpu", Backend::Cpu)];
const SETS: [(&str, InstructionSet); 4] = [
    ("auto", InstructionSet::Auto),
    ("avx512", InstructionSet::Avx512),
    ("avx2", InstructionSet::Avx2),
    ("baseline", InstructionSet::Baseline),
];
const MOST_THREADS: u16 = 1024;

#[derive(clap::Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Renderer")]
pub struct Engine {
    /// What draws
    #[arg(long, value_name = "BACKEND", value_parser = values::word(&BACKENDS), default_value = "auto")]
    backend: Backend,
    /// Threads to draw with, 1 to 1024; the picture is the same for any number [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)))]
    threads: Option<u16>,
    /// Processor instructions to draw with; the picture depends on them by roundings only
    #[arg(long, value_name = "SET", value_parser = values::word(&SETS), default_value = "auto")]
    simd: InstructionSet,
}

impl Engine {
    /// The renderer asked for.
    pub fn renderer(&self) -> Result<Renderer, RenderError> {
        let renderer = match self.threads {
            Some(threads) => Renderer::with_threads(self.backend, threads.into()),
            None => Renderer::new(self.backend),
        };
        renderer?.with_instructions(self.simd)
    }

    /// Threads asked for, or as many as there are cores.
    pub fn threads(&self) -> u16 {
        let cores = || std::thread::available_parallelism().map_or(1, NonZero::get);
        self.threads.unwrap_or_else(|| cores().min(MOST_THREADS.into()) as u16)
    }

    /// The same with this number of threads.
    pub fn with_threads(self, threads: u16) -> Self {
        Self { threads: Some(threads), ..self }
    }
}
