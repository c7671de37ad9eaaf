//! How the command fails: one line, a hint where there is a next step, and an exit code.

use std::fmt;
use std::io::ErrorKind;
use std::path::Path;

use pellucid::field::printable;
use pellucid::gpu::GpuError;
use pellucid::io::IoError;
use pellucid::scene::ResolveError;
use pellucid::{LoadError, RenderError, cpu};

/// Why the command stops.
#[derive(Debug)]
pub struct Failure {
    /// Exit code, as `pellucid --help` documents them.
    pub code: u8,
    message: String,
    hint: Option<String>,
}

/// Work that could not be done although input and command line are right.
const WORK: u8 = 1;
/// The input or the command line is wrong.
const INPUT: u8 = 2;
/// Stopped by Ctrl-C: 128 + SIGINT.
const CANCELLED: u8 = 130;

impl Failure {
    /// The input or the command line is wrong.
    pub fn input(message: impl fmt::Display) -> Self {
        Self { code: INPUT, message: one_line(&message.to_string()), hint: None }
    }

    /// Something failed while working.
    pub fn work(message: impl fmt::Display) -> Self {
        Self { code: WORK, ..Self::input(message) }
    }

    /// The user stopped it.
    pub fn cancelled() -> Self {
        Self { code: CANCELLED, ..Self::input("cancelled, no picture was written") }
    }

    /// The user stopped it, and what there was is in a file.
    pub fn interrupted([taken, asked]: [u32; 2], kept: &Path) -> Self {
        let kept = kept.display();
        let message = format!("interrupted: the picture of {taken} of {asked} samples a pixel is in {kept}");
        Self { code: CANCELLED, ..Self::input(message) }
    }

    /// The same with another exit code.
    pub fn code(self, code: u8) -> Self {
        Self { code, ..self }
    }

    /// Adds what to do next.
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(one_line(&hint.into())), ..self }
    }

    /// A file that cannot be read: the input is wrong.
    pub fn reading(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |error| Self::input(format_args!("{}: {error}", path.display()))
    }

    /// What clap found wrong with the command line of `command`.
    pub fn usage(error: &clap::Error, command: &str) -> Self {
        let text = error.render().to_string();
        let (mut message, mut hint) = (Vec::new(), None);
        for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
            if let Some(tip) = line.strip_prefix("tip: ") {
                hint.get_or_insert_with(|| tip.to_owned());
            } else if line.starts_with("Usage:") || line.starts_with("For more information") {
                break;
            } else if let Some(values) = line.strip_prefix("[possible values: ") {
                message.push(format!("(one of {})", values.trim_end_matches(']')));
            } else {
                message.push(line.trim_start_matches("error: ").to_owned());
            }
        }
        Self::input(message.join(" ")).hint(hint.unwrap_or_else(|| format!("see '{command} --help'")))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pellucid: error: {}", self.message)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, "\npellucid: hint: {hint}"))
    }
}

/// Messages of other crates may break lines, and what they quote of files may steer terminals.
fn one_line(message: &str) -> String {
    printable(&message.split_whitespace().collect::<Vec<_>>().join(" ")).into_owned()
}

/// Reading: what is in the file, or that there is none, is the caller's input; the rest is not.
impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        match &error {
            LoadError::Io(IoError::Memory { .. }) | LoadError::Memory { .. } => Self::work(&error),
            LoadError::Io(IoError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
                let hint = "the header or scene names it; names in them start at their own folder";
                Self::input(&error).hint(hint)
            }
            LoadError::Io(IoError::Limit { setting: "bytes", found, .. }) => {
                let enough = format!("{}M", found.div_ceil(1 << 20));
                Self::input(&error)
                    .hint(format!("--max-bytes {enough} reads it, if you trust the file and have the memory"))
            }
            LoadError::Io(IoError::Outside { .. }) => {
                Self::input(&error).hint("--allow-outside reads it, if you trust the scene or header that names it")
            }
            LoadError::Io(IoError::Unsupported { what, .. }) if what.contains("format") => {
                Self::input(&error).hint("a headerless file needs --dims and --type")
            }
            _ => Self::input(&error),
        }
    }
}

impl From<ResolveError> for Failure {
    fn from(error: ResolveError) -> Self {
        Self::input(error)
    }
}

/// Writing.
impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        match error {
            IoError::Unsupported { .. } => Self::input(error),
            _ => Self::work(error),
        }
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled => Self::cancelled(),
            RenderError::Gpu(GpuError::Unsupported { .. } | GpuError::Volumes { .. }) => Self::input(error),
            RenderError::Cpu(
                cpu::RenderError::Threads(_)
                | cpu::RenderError::Memory(_)
                | cpu::RenderError::SavedLight(cpu::SavedLightError::Memory(_)),
            )
            | RenderError::Gpu(_) => Self::work(error),
            _ => Self::input(error),
        }
    }
}
