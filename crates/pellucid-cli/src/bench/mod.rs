//! `pellucid bench`.

mod machine;
mod meter;
mod reference;
mod results;
mod subject;
mod sweep;
mod timing;
mod variants;

use std::path::{Path, PathBuf};

use pellucid::scene::Frame;
use pellucid::{PngDepth, save_png};
use serde_json::{Value, json};

use super::engine::Engine;
use super::failure::Failure;
use super::flags::SceneFlags;
use super::input::{Input, RawFlags};
use super::report::{Report, print, print_json};
use super::{interrupt, output, values};
use machine::Machine;
pub use meter::{Meter, Plan};
use reference::Reference;
use results::Results;
use subject::Subject;
pub use subject::still;
use sweep::{SWEEPS, Sweep};

/// Shown at the end of `pellucid bench --help`.
pub const EXAMPLES: &str = "\
A timed frame is a camera change, the drawing, and the picture as 8-bit RGBA in memory. A scene is
loaded once and one renderer draws all its frames. Counts are means per frame. Sweeps keep the
camera still; each setting has its own --warmup and --frames. The voxels of a sample are the eight
around it; their rate is that of drawing alone, by the adapter's own clock if it has one.

Examples:
  pellucid bench scene.toml other.toml --size 512x512
  pellucid bench sample:head --orbit 0 --frames 30 --threads 1
  pellucid bench ct.nrrd --preset ct-bone --sweep step --sweep threads --json figures.json
  pellucid bench sample:ball --sweep volume --largest 1024
  pellucid bench scene.toml --adapter software --warmup 20 --frames 100 --reference --json figures.json";

#[derive(clap::Args)]
pub struct BenchArgs {
    /// Scenes (.toml, .json), volume files, or built-in fields as sample:NAME
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<Input>,
    #[command(flatten)]
    measure: MeasureFlags,
    #[command(flatten)]
    engine: Engine,
    #[command(flatten)]
    scene: SceneFlags,
    #[command(flatten)]
    raw: RawFlags,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Measurement")]
struct MeasureFlags {
    /// Frames timed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value = "12")]
    frames: u32,
    /// Frames drawn before them
    #[arg(long, value_name = "N", default_value = "2")]
    warmup: u32,
    /// Degrees the camera walks around its target, about its up direction; 0 keeps it still
    #[arg(long, value_name = "DEGREES", value_parser = values::number, default_value = "360",
        allow_hyphen_values = true)]
    orbit: f64,
    /// Also vary one setting. Repeatable
    ///
    /// step, size, threads, filter, gradient (shaded) and view (along the axes and the diagonal)
    /// change that alone; volume samples a built-in field at growing sizes in three voxel types;
    /// edit changes the transfer function before every frame.
    #[arg(long, value_name = "SETTING", value_parser = values::word(&SWEEPS))]
    sweep: Vec<Sweep>,
    /// Voxels per axis where --sweep volume ends
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(64..=4096), default_value = "512")]
    largest: u32,
    /// Write everything, with notes on the machine, as JSON to this file; '-' prints it instead of
    /// the tables
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Save the first picture timed to this .png, of one input
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// Also tell the error of the first picture timed, against the processor's with steps so many times
    /// finer and every ray followed to its end [default: 8]
    #[arg(long, value_name = "FINER", num_args = 0..=1, require_equals = true, default_missing_value = "8",
        value_parser = clap::value_parser!(u8).range(1..=64), conflicts_with = "against")]
    reference: Option<u8>,
    /// Also tell the error of the first picture timed, of one input, against this .png
    #[arg(long, value_name = "FILE.png")]
    against: Option<PathBuf>,
    /// Say nothing on standard error but errors
    #[arg(short, long)]
    quiet: bool,
}

impl BenchArgs {
    /// Threads to work on.
    pub fn threads(&self) -> u16 {
        self.engine.threads()
    }
}

pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let measure = &args.measure;
    let report = Report { quiet: measure.quiet };
    let cancel = interrupt::listen();
    measure.check(args.inputs.len())?;
    let plan = Plan {
        engine: args.engine.clone(),
        frames: measure.frames as usize,
        warmup: measure.warmup as usize,
        cancel: &cancel,
        quiet: measure.quiet,
    };
    let machine = Machine::new();
    let mut scenes = Vec::new();
    for input in &args.inputs {
        let results = measure_one(args, input, plan.clone(), report)?;
        if measure.prints_tables() {
            let notes = if scenes.is_empty() { machine.text() } else { String::new() };
            print(&format!("{notes}\n{}", results.text()))?;
        }
        scenes.push(results.json());
    }
    measure.write(&json!({
        "machine": machine.json(),
        "frames": measure.frames,
        "warmup": measure.warmup,
        "scenes": scenes,
    }))
}

fn measure_one(args: &BenchArgs, input: &Input, plan: Plan, report: Report) -> Result<Results, Failure> {
    let measure = &args.measure;
    let check = |scene: &_| measure.sweep.iter().try_for_each(|sweep| sweep.check(scene));
    let (subject, mut meter) = Subject::open(input, &args.raw, &args.scene, plan.clone(), report, check)?;
    let (orbit, first) = subject.orbit(&mut meter, measure.orbit)?;
    if let Some(path) = &measure.picture {
        save(path, &first, &subject)?;
    }
    let error = measure.reference().map(|reference| reference.compare(&subject, &first, plan)).transpose()?;
    let mut sweeps = Vec::new();
    for sweep in &measure.sweep {
        sweeps.push((*sweep, sweep.run(&subject, &mut meter, measure.largest as usize)?));
    }
    let (renderer, capabilities) = (meter.describe(), meter.capabilities());
    Ok(Results { subject, renderer, capabilities, degrees: measure.orbit, orbit, error, sweeps })
}

fn save(path: &Path, frame: &Frame, subject: &Subject) -> Result<(), Failure> {
    Ok(save_png(path, frame, &subject.scene.image, PngDepth::Eight)?)
}

impl MeasureFlags {
    /// Refuses before long work what could not be written after it.
    fn check(&self, inputs: usize) -> Result<(), Failure> {
        if let Some(path) = &self.picture {
            if inputs != 1 {
                return Err(Failure::input(format_args!("--picture is about one input, {inputs} are given")));
            }
            if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
                return Err(Failure::input(format_args!("{}: the name must end in .png", path.display())));
            }
            output::writable(path)?;
        }
        if self.against.is_some() && inputs != 1 {
            return Err(Failure::input(format_args!("--against is about one input, {inputs} are given")));
        }
        self.json_file().map_or(Ok(()), output::writable)
    }

    /// What the first picture is compared with.
    fn reference(&self) -> Option<Reference> {
        let given = || self.against.clone().map(Reference::Given);
        self.reference.map(Reference::Drawn).or_else(given)
    }

    fn prints_tables(&self) -> bool {
        self.json.as_deref() != Some(Path::new("-"))
    }

    fn json_file(&self) -> Option<&Path> {
        self.json.as_deref().filter(|_| self.prints_tables())
    }

    fn write(&self, told: &Value) -> Result<(), Failure> {
        match self.json_file() {
            Some(path) => output::write(path, &format!("{told:#}\n")),
            None if self.prints_tables() => Ok(()),
            None => print_json(told),
        }
    }
}
