//! The `pellucid` command: one file per subcommand, one per concern.

mod adapters;
mod bake;
mod bench;
mod compare;
mod completions;
mod convert;
mod difference;
mod engine;
mod failure;
mod flags;
mod histogram;
mod info;
mod input;
mod interrupt;
mod memory;
mod output;
mod presets;
mod progress;
mod render;
mod report;
mod sample;
mod schema;
mod set;
mod values;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

use failure::Failure;
use pellucid::field::Threads;

#[global_allocator]
static MEMORY: memory::Memory = memory::Memory;

/// Volume graphics: turns scans, simulations and built-in fields into pictures.
///
/// A scene says what to draw: volumes, how they look, camera, lights, clips, technique and
/// quality. It comes from a file, from flags, or from both, and whatever it leaves open is chosen
/// for the data and said on standard error.
#[derive(Parser)]
#[command(name = "pellucid", version, after_help = "Exit codes: 0 fine, 1 work failed, 2 wrong input, 130 cancelled")]
#[command(after_long_help = "\
Exit codes:
    0  fine
    1  something failed while working: a file could not be written, no threads, no memory
    2  the input or the command line is wrong
  130  cancelled with Ctrl-C; nothing half-written is left behind. Path tracing keeps the picture of
       the samples it has by then; Ctrl-C once more quits at once
  128 + N  ended by another signal, as 143 by SIGTERM and 129 by SIGHUP; nothing is left behind, either

Try:
  pellucid render sample:head -o head.png
  pellucid info scan.nii.gz
  pellucid render --help")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Draw a picture of a volume or a scene
    #[command(after_long_help = render::EXAMPLES)]
    Render(Box<render::RenderArgs>),
    /// Find the light of isosurfaces everywhere, and save it for pictures
    #[command(after_long_help = bake::EXAMPLES)]
    Bake(Box<bake::BakeArgs>),
    /// Measure how fast scenes and volumes are drawn
    #[command(after_long_help = bench::EXAMPLES)]
    Bench(Box<bench::BenchArgs>),
    /// Draw a scene in several ways, and tell how far the pictures are apart
    #[command(after_long_help = compare::EXAMPLES)]
    Compare(Box<compare::CompareArgs>),
    /// Tell what is in volume files, with a histogram
    Info(info::InfoArgs),
    /// Write a built-in field to a volume file
    Sample(sample::SampleArgs),
    /// Write a volume in another format
    Convert(convert::ConvertArgs),
    /// List presets, colour maps and opacity shapes
    Presets(presets::PresetsArgs),
    /// Print the JSON Schema of scene files
    Schema,
    /// Print a completion script for a shell
    Completions(completions::CompletionsArgs),
}

fn main() -> ExitCode {
    memory::rehearse();
    quieten_drivers();
    let tell = std::panic::take_hook();
    // What a decoder's panic becomes is told like all errors.
    std::panic::set_hook(Box::new(move |panic| {
        if !pellucid::io::is_guarded() {
            tell(panic)
        }
    }));
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if asks_for_help(&error) => {
            // To standard output, or to standard error if the command is missing.
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
        Err(error) => return fail(&Failure::usage(&error, &named_command())),
    };
    // All of it on threads that were to be had, so that no part of the work meets a lack of them.
    let done = Threads::new(cli.command.threads().into()).map_err(Failure::work);
    let done = done.and_then(|threads| threads.run(|| cli.command.run()));
    done.map_or_else(|failure| fail(&failure), |()| ExitCode::SUCCESS)
}

impl Command {
    /// Threads to work on.
    fn threads(&self) -> u16 {
        match self {
            Self::Render(args) => args.threads(),
            Self::Bake(args) => args.threads(),
            Self::Bench(args) => args.threads(),
            Self::Compare(args) => args.threads(),
            // They have no work for several.
            Self::Presets(_) | Self::Schema | Self::Completions(_) => 1,
            Self::Info(_) | Self::Sample(_) | Self::Convert(_) => engine::cores(),
        }
    }

    fn run(&self) -> Result<(), Failure> {
        match self {
            Self::Render(args) => render::run(args),
            Self::Bake(args) => bake::run(args),
            Self::Bench(args) => bench::run(args),
            Self::Compare(args) => compare::run(args),
            Self::Info(args) => info::run(args),
            Self::Sample(args) => sample::run(args),
            Self::Convert(args) => convert::run(args),
            Self::Presets(args) => presets::run(args),
            Self::Schema => schema::run(),
            Self::Completions(args) => completions::run(args),
        }
    }
}

/// "pellucid render", if that is what the command line begins with.
fn named_command() -> String {
    let first = std::env::args_os().nth(1).unwrap_or_default();
    let command = Cli::command();
    command.find_subcommand(first).map_or("pellucid".into(), |named| format!("pellucid {}", named.get_name()))
}

fn asks_for_help(error: &clap::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    )
}

fn fail(failure: &Failure) -> ExitCode {
    use std::io::Write;
    // If standard error is gone, the exit code still tells.
    let _ = writeln!(std::io::stderr(), "{failure}");
    ExitCode::from(failure.code)
}

/// Vulkan's layers look for a Wayland display and complain on standard error, twice a run and past every `--quiet`,
/// where the variable that says where one would be is not set. With it set to a place that is not there they find none
/// in silence.
#[cfg(target_os = "linux")]
fn quieten_drivers() {
    const PLACE: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(PLACE).is_none() {
        // SAFETY: nothing has started a thread yet, so that none can read the environment meanwhile.
        unsafe { std::env::set_var(PLACE, "/nonexistent") };
    }
}

#[cfg(not(target_os = "linux"))]
fn quieten_drivers() {}
