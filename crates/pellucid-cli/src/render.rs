//! `pellucid render`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use pellucid::field::memory;
use pellucid::io::IoError;
use pellucid::scene::{Cancel, Control, Format, Frame, ImageSettings, Scene, Stage};
use pellucid::{Passes, PngDepth, Progressive, RenderError, Renderer, save_exr, save_png};
use serde_json::{Value, json};

use super::engine::Engine;
use super::failure::Failure;
use super::flags::{SceneFlags, Staged};
use super::info::choices_json;
use super::input::{Base, Input, RawFlags};
use super::progress::Progress;
use super::report::{Report, in_flags, print_json};
use super::{interrupt, output, values};

/// Shown at the end of `pellucid render --help`.
pub const EXAMPLES: &str = "\
Settings are taken in this order, later ones win: defaults, scene file, named flags, --set.

Examples:
  pellucid render sample:head -o head.png
  pellucid render ct.nrrd --preset ct-bone --azimuth 45 -o bone.png
  pellucid render ct.nrrd --iso 300,e8dcc0 --iso -200,d0a080,0.3 -o surfaces.png
  pellucid render mr.nii.gz --slice axial --at 40% --window 0,900 --colormap gray -o slice.png
  pellucid render ct.nrrd --mode maximum --background transparent -o mip.png
  pellucid render engine.raw --dims 256x256x256 --type u8 -o engine.png
  pellucid render scene.toml --size 1920x1080 --supersampling 2 -o hd.exr
  pellucid render sample:head --accumulate 64 -o smooth.png
  pellucid render ct.nrrd --clip 0,1,0,0,-20,0 --save-scene clipped.toml -o clipped.png";

#[derive(clap::Args)]
pub struct RenderArgs {
    /// A volume file, a scene (.toml, .json), or a built-in field as sample:NAME or
    /// sample:NAME@128x128x128
    input: Input,
    #[command(flatten)]
    output: OutputFlags,
    #[command(flatten)]
    engine: Engine,
    /// Average this many frames, 1 to 65535, whose rays lie elsewhere in the pixels and sample elsewhere
    /// along the way: smooth edges and no banding
    #[arg(
        long,
        value_name = "FRAMES",
        value_parser = clap::value_parser!(u16).range(1..),
        default_value = "1",
        help_heading = "Renderer"
    )]
    accumulate: u16,
    #[command(flatten)]
    scene: SceneFlags,
    #[command(flatten)]
    raw: RawFlags,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Output")]
struct OutputFlags {
    /// The picture: .png, or .exr for linear 32-bit floats with depth (Z), normal (N.X, N.Y, N.Z)
    /// and samples per pixel as further layers
    #[arg(short, long, value_name = "FILE", required_unless_present = "save_scene")]
    output: Option<PathBuf>,
    /// Bits per channel of a .png [default: 8]
    #[arg(long, value_name = "BITS", value_parser = values::word(&DEPTHS))]
    bits: Option<PngDepth>,
    /// Also write all layers, as an .exr output has them, to this .exr
    #[arg(long, value_name = "FILE.exr", requires = "output")]
    aux: Option<PathBuf>,
    /// Write the whole scene, flags and --set included, to this .toml or .json. Without --output
    /// nothing is drawn
    #[arg(long, value_name = "FILE")]
    save_scene: Option<PathBuf>,
    /// Print one JSON object to standard output: input, choices, warnings, timings, statistics
    #[arg(long, requires = "output")]
    json: bool,
    /// Say nothing on standard error but errors
    #[arg(short, long)]
    quiet: bool,
}

const DEPTHS: [(&str, PngDepth); 2] = [("8", PngDepth::Eight), ("16", PngDepth::Sixteen)];

impl RenderArgs {
    /// Threads to work on.
    pub fn threads(&self) -> u16 {
        self.engine.threads()
    }
}

pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let report = Report { quiet: args.output.quiet };
    let cancel = interrupt::listen();
    let base = args.input.open(&args.raw)?;
    let scene = args.scene.apply(&base.scene)?;
    args.output.check()?;
    // Frames that are averaged are two.
    let held = scene.technique.needs().frames.max(if args.accumulate > 1 { 2 } else { 1 });
    affordable(&scene.image, held)?;
    let mut idle = args.engine.check()?;
    idle.extend(args.output.idle());
    drawable(&scene, &base)?;

    let started = Instant::now();
    let (volumes, warnings) = base.load(&scene)?;
    let load_seconds = started.elapsed().as_secs_f64();
    let Staged { scene, stage, mut choices, warnings: of_settings } = args.scene.stage(&base, scene, &volumes)?;
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    warnings.extend(idle);
    warnings.extend(of_settings);
    report.opening(&scene, &volumes, &choices, &warnings);
    if let Some(path) = &args.output.save_scene {
        let leaves = save_scene(path, &scene.settled(&volumes)?, &base)?;
        let how = if leaves { ", which names files outside of its folder: draw it with --allow-outside" } else { "" };
        report.say(format_args!("wrote {}{how}", path.display()));
    }
    let Some(output) = &args.output.output else { return Ok(()) };

    let (drawn, stopped) = interrupt::stoppable(|| {
        let mut renderer = args.engine.suited_to(&scene.technique).renderer()?;
        let backend = renderer.describe();
        let engine = renderer.choices(&stage)?;
        engine.iter().for_each(|choice| report.say(choice));
        choices.extend(engine);
        let drawn = draw(renderer, stage, args.accumulate.into(), &cancel, report)?;
        Ok((drawn, backend))
    });
    let (Drawn { frame, samples }, backend) = match (drawn, stopped) {
        (Ok(kept @ (Drawn { samples: Some(_), .. }, _)), Some(_)) => kept,
        (_, Some(code)) => return Err(Failure::cancelled().code(code)),
        (drawn, None) => drawn?,
    };
    let saving = Instant::now();
    args.output.save(output, &frame, &scene.image)?;
    let save_seconds = saving.elapsed().as_secs_f64();
    for warning in &frame.warnings {
        report.warn(in_flags(warning));
        warnings.push(warning.to_string());
    }
    let seconds = frame.statistics.setup_seconds + frame.statistics.render_seconds;
    let times = if args.accumulate > 1 { format!(" {} times", args.accumulate) } else { String::new() };
    report.say(format_args!(
        "drew {}x{}{times} in {seconds:.2} s on the {backend}, wrote {}",
        frame.width,
        frame.height,
        output.display()
    ));
    if args.output.json {
        print_json(&json!({
            "input": volumes.iter().map(|volume| volume.name.as_str()).collect::<Vec<_>>(),
            "dims": volumes.iter().map(|volume| volume.grid().dims()).collect::<Vec<_>>(),
            "choices": choices_json(&choices),
            "warnings": warnings,
            "backend": backend.to_string(),
            "output": output.to_string_lossy(),
            "width": frame.width,
            "height": frame.height,
            "frames": args.accumulate,
            "samples_per_pixel": samples.map(|[taken, asked]| json!({ "taken": taken, "asked": asked })),
            "timings": {
                "load_seconds": load_seconds,
                "setup_seconds": frame.statistics.setup_seconds,
                "render_seconds": frame.statistics.render_seconds,
                "save_seconds": save_seconds,
            },
            "statistics": statistics(&frame),
        }))?;
    }
    match (stopped, samples) {
        (Some(code), Some(samples)) => Err(Failure::interrupted(samples, output).code(code)),
        _ => Ok(()),
    }
}

/// A picture.
struct Drawn {
    frame: Frame,
    /// Samples of each pixel that it has, and those that were asked for, if it may have fewer.
    samples: Option<[u32; 2]>,
}

/// Draws frames and averages them.
fn draw(renderer: Renderer, stage: Stage, frames: u32, cancel: &Cancel, report: Report) -> Result<Drawn, Failure> {
    let progress = Progress::new("drawing", report.quiet);
    if let Some(settings) = stage.path_trace().cloned() {
        return trace(Passes::new(renderer, stage, settings).with_frames(frames), cancel, report, &progress);
    }
    let mut progressive = Progressive::new(renderer, stage).with_preview(None).with_frames(frames);
    for done in 0..frames {
        let tell = |share| progress.report((f64::from(done) + share) / f64::from(frames));
        progressive.step(&Control { progress: Some(&tell), cancel: Some(cancel), ..Control::default() })?;
    }
    Ok(Drawn { frame: progressive.into_frame(), samples: None })
}

/// Traces paths until there are enough of them, or until they are stopped: what there is by then is a picture, too.
fn trace(mut passes: Passes, cancel: &Cancel, report: Report, progress: &Progress) -> Result<Drawn, Failure> {
    let tell = |share| progress.report(share);
    let control = Control { progress: Some(&tell), cancel: Some(cancel), ..Control::default() };
    loop {
        match passes.step(&control) {
            Ok(true) => {}
            Ok(false) => break,
            Err(RenderError::Cancelled) if passes.taken() > 0 => {
                report.say("interrupted: writing the picture so far; once more quits at once");
                break;
            }
            Err(error) => return Err(error.into()),
        }
    }
    let samples = Some([passes.taken(), passes.asked()]);
    // Whoever does not want to wait for this interrupts once more.
    Ok(Drawn { frame: passes.into_frame(&Control::default())?, samples })
}

impl OutputFlags {
    /// Refuses before a long render what could not be written after it.
    fn check(&self) -> Result<(), Failure> {
        for path in self.output.iter().chain(&self.aux) {
            let known: &[&str] = if Some(path) == self.aux.as_ref() { &["exr"] } else { &["png", "exr"] };
            if !known.iter().any(|known| has_extension(path, known)) {
                let path = path.display();
                return Err(Failure::input(format_args!("{path}: the name must end in .{}", known.join(" or ."))));
            }
        }
        if let Some(path) = self.save_scene.as_ref().filter(|path| Format::of(path).is_none()) {
            return Err(Failure::input(format_args!("{}: a scene's name must end in .toml or .json", path.display())));
        }
        self.output.iter().chain(&self.aux).chain(&self.save_scene).try_for_each(|path| output::writable(path))
    }

    /// What is asked of a .png that is not written.
    fn idle(&self) -> Option<String> {
        let is_png = self.output.as_ref().is_some_and(|path| has_extension(path, "png"));
        let idle = self.bits.is_some() && !is_png;
        idle.then(|| "--bits has no effect: only a .png has bits to choose, an .exr holds floats".to_owned())
    }

    fn save(&self, output: &Path, frame: &Frame, image: &ImageSettings) -> Result<(), IoError> {
        if has_extension(output, "png") {
            save_png(output, frame, image, self.bits.unwrap_or_default())?;
        } else {
            save_exr(output, frame, image)?;
        }
        self.aux.as_ref().map_or(Ok(()), |aux| save_exr(aux, frame, image))
    }
}

/// Refuses before any volume is loaded what could not be drawn after it: other numbers of volumes than backends draw,
/// and optics that cannot be read.
pub fn drawable(scene: &Scene, base: &Base) -> Result<(), Failure> {
    let listed = scene.volumes.len();
    if listed == 0 {
        return Err(Failure::input("the scene lists no volume, and pictures are of one or more"));
    }
    if listed > 1 && !scene.technique.needs().several_volumes {
        let name = scene.technique.name();
        let message = format_args!("the scene lists {listed} volumes, and {name} draws one as it is set: keep one");
        let hint = "--technique ray-cast, half-angle and path-trace draw several; so do slices that project values, and \
            composited ones that are view-aligned or shells";
        return Err(Failure::input(message).hint(hint));
    }
    Ok(base.load_optics(&mut scene.clone())?)
}

/// Refuses a picture that does not fit into memory, where the drawing would be killed; `frames` are
/// held at a time.
pub fn affordable(image: &ImageSettings, frames: usize) -> Result<(), Failure> {
    /// A frame with all layers. There is one more of them, in tiles or in what is written.
    const BYTES_PER_PIXEL: usize = 50;
    let bytes = (image.width as usize * image.height as usize).saturating_mul(BYTES_PER_PIXEL * (frames + 1));
    memory::afford(bytes).map_err(|_| {
        let size = format_args!("{} x {} pixels", image.width, image.height);
        Failure::work(format_args!("a picture of {size} needs about {} MB of memory", bytes / 1_000_000))
    })
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Writes the scene so that it draws the same from where it lies now: what is in its folder or below is named from
/// there, and all else by its whole path. Whether there is any such.
fn save_scene(path: &Path, scene: &Scene, base: &Base) -> Result<bool, Failure> {
    let mut scene = scene.clone();
    let home = std::path::absolute(path).map_err(Failure::reading(path))?;
    let home = home.parent().and_then(|home| home.canonicalize().ok());
    let mut leaves = false;
    for file in scene.files_mut() {
        let from = base.folder.join(&*file);
        let inside =
            home.as_ref().and_then(|home| from.canonicalize().ok()?.strip_prefix(home).ok().map(Path::to_owned));
        leaves |= inside.is_none();
        *file = inside.map_or_else(|| std::path::absolute(&from), Ok).map_err(Failure::reading(&from))?;
    }
    let format = Format::of(path).unwrap_or(Format::Toml);
    let text = scene.to_text(format).map_err(Failure::input)?;
    output::write(path, &text)?;
    Ok(leaves)
}

fn statistics(frame: &Frame) -> Value {
    let counts = &frame.statistics;
    json!({
        "rays": counts.rays,
        "rays_hit": counts.rays_hit,
        "rays_terminated": counts.rays_terminated,
        "samples": counts.samples,
        "samples_visible": counts.samples_visible,
        "samples_skipped": counts.samples_skipped,
    })
}
