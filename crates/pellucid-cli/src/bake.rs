//! `pellucid bake`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use pellucid::io::{Format, WriteOptions, write};
use pellucid::scene::{Control, IlluminationMethod, Mode, Scene, Stage};
use pellucid::{CpuRenderer, RenderError, cpu};
use serde_json::json;

use super::engine::Processor;
use super::failure::Failure;
use super::flags::{SceneFlags, Staged};
use super::input::{Input, RawFlags};
use super::progress::Progress;
use super::render::drawable;
use super::report::{Report, print_json};
use super::{interrupt, output};

/// Shown at the end of `pellucid bake --help`.
pub const EXAMPLES: &str = "\
Light is found on those sides of surfaces that the scene's picture sees. It is saved with a mark of the data, the surfaces and
the settings that it depends on: a picture of others refuses it, and one from another side, of another size or with surfaces
seen through more or less is drawn with it.

Examples:
  pellucid bake ct.nrrd --iso 300 --global-illumination -o light.nrrd
  pellucid bake scene.toml -o light.nrrd --compress 1
  pellucid render scene.toml --set technique.ray_cast.mode.isosurface.illumination.global.file=light.nrrd -o a.png";

#[derive(clap::Args)]
pub struct BakeArgs {
    /// A volume file, a scene (.toml, .json), or a built-in field as sample:NAME or
    /// sample:NAME@128x128x128
    input: Input,
    /// The file to write the light to, .nrrd or .nhdr; a scene names it at
    /// technique.ray_cast.mode.isosurface.illumination.global.file. Without it nothing is saved, and
    /// figures are printed alone
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Deflate the light, 1 (fast) to 9 (small) [default: plain values]
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u8).range(1..=9), requires = "output")]
    compress: Option<u8>,
    /// Print one JSON object to standard output: places, paths, seconds, threads
    #[arg(long)]
    json: bool,
    /// Say nothing on standard error but errors
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    processor: Processor,
    #[command(flatten)]
    scene: SceneFlags,
    #[command(flatten)]
    raw: RawFlags,
}

impl BakeArgs {
    /// Threads to work on.
    pub fn threads(&self) -> u16 {
        self.processor.threads()
    }
}

pub fn run(args: &BakeArgs) -> Result<(), Failure> {
    let report = Report { quiet: args.quiet };
    let cancel = interrupt::listen();
    let mut base = args.input.open(&args.raw)?;
    // The light that the scene has may be of other settings, for which this is done.
    if let Some(global) = base.scene.technique.mode_mut().and_then(Mode::global_illumination_mut) {
        global.file = None;
    }
    let scene = args.scene.apply(&base.scene)?;
    args.output.as_deref().map_or(Ok(()), check_output)?;
    lit_globally(&scene)?;
    drawable(&scene, &base)?;
    let (volumes, warnings) = base.load(&scene)?;
    let Staged { scene, stage, choices, warnings: of_settings } = args.scene.stage(&base, scene, &volumes)?;
    let warnings: Vec<String> = warnings.iter().map(ToString::to_string).chain(of_settings).collect();
    report.opening(&scene, &volumes, &choices, &warnings);
    let samples = samples(&stage)?;

    let started = Instant::now();
    let (renderer, baked) = interrupt::gracefully(|| {
        let mut renderer: CpuRenderer = args.processor.renderer()?;
        let progress = Progress::new("lighting", args.quiet);
        let tell = |share| progress.report(share);
        let baked =
            renderer.bake(&stage, &Control { progress: Some(&tell), cancel: Some(&cancel), ..Control::default() });
        Ok((renderer, baked.map_err(failed)?))
    })?;
    let seconds = started.elapsed().as_secs_f64();
    let paths = baked.lit as u64 * u64::from(samples);
    let rate = paths as f64 / seconds / f64::from(args.threads());
    report.say(format_args!(
        "lit {} of {} places by {paths} paths in {seconds:.2} s, {rate:.0} paths a second and thread",
        baked.lit, baked.places
    ));
    if let Some(path) = &args.output {
        let light = renderer.baked_light().map_err(failed)?;
        let unseen = || Failure::input("no surface is seen from the camera, and there is no light to save");
        let light = light.ok_or_else(|| unseen().hint("--iso takes a value that the data have"))?;
        let options = WriteOptions { compression: args.compress, ..WriteOptions::default() };
        write(path, &light, &options)?.iter().for_each(|warning| report.warn(warning));
        report.say(format_args!("wrote {}", path.display()));
    }
    if args.json {
        print_json(&json!({
            "places": baked.places,
            "lit": baked.lit,
            "paths": paths,
            "seconds": seconds,
            "threads": args.threads(),
            "output": args.output.as_ref().map(|path| path.to_string_lossy()),
        }))?;
    }
    Ok(())
}

fn failed(error: cpu::RenderError) -> Failure {
    RenderError::from(error).into()
}

/// Only this format keeps what the light is of.
fn check_output(path: &Path) -> Result<(), Failure> {
    if Format::from_extension(path) != Some(Format::Nrrd) {
        return Err(Failure::input(format_args!("{}: the name must end in .nrrd or .nhdr", path.display())));
    }
    output::writable(path)
}

/// Refuses before any volume is loaded a scene without such light.
fn lit_globally(scene: &Scene) -> Result<(), Failure> {
    match scene.technique.mode().global_illumination() {
        Some(_) => Ok(()),
        None => Err(Failure::input("light is found for isosurfaces in global illumination, and the scene has none")
            .hint("add --iso VALUE and --global-illumination or --ambient-occlusion")),
    }
}

/// Paths of every place.
fn samples(stage: &Stage) -> Result<u32, Failure> {
    match stage.global_illumination() {
        Some(global) if global.method == IlluminationMethod::Lattice => Ok(global.samples),
        Some(_) => {
            Err(Failure::input("light at every pixel is found anew in every picture, and there is none to keep")
                .hint("--set technique.ray_cast.mode.isosurface.illumination.global.method=lattice"))
        }
        None => Err(Failure::input(
            "nothing is lit by global illumination: it lights the surfaces of one volume with shading, \
            as rays meet them",
        )),
    }
}
