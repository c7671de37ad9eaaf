//! `pellucid compare`.

use std::path::PathBuf;
use std::str::FromStr;

use pellucid::field::Volume;
use pellucid::io::{PngPixels, Transfer, write_png};
use pellucid::scene::{Frame, ImageSettings, Likeness, Scene, TECHNIQUES, Technique, meant};
use serde_json::{Value, json};

use super::bench::{Meter, Plan, still};
use super::difference::Difference;
use super::engine::{BACKENDS, Engine};
use super::failure::Failure;
use super::flags::{SceneFlags, Staged};
use super::input::{Input, RawFlags};
use super::report::{Report, print, print_json};
use super::set::{self, Setting};
use super::{interrupt, output, render};
use pellucid::Backend;

/// Shown at the end of `pellucid compare --help`.
pub const EXAMPLES: &str = "\
The first picture is the one that the others are compared with. Upper row: the pictures; lower row: how
far each is from the first, times --gain.

Examples:
  pellucid compare sample:head --techniques ray-cast@cpu,ray-cast@gpu -o backends.png
  pellucid compare ct.nrrd --also quality.step=0.25 --also 'quality.step=2; quality.classification=pre_integrated' -o steps.png
  pellucid compare scene.toml --techniques ray-cast,view-aligned,object-aligned -o slices.png";

#[derive(clap::Args)]
pub struct CompareArgs {
    /// A volume file, a scene (.toml, .json), or a built-in field as sample:NAME
    input: Input,
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help = techniques_help())]
    techniques: Vec<Rendition>,
    /// One more picture, of the first technique with these settings (as --set takes them, separated by
    /// semicolons). Repeatable
    #[arg(long, value_name = "PATH=VALUE;...")]
    also: Vec<Settings>,
    /// The pictures and their differences, side by side
    #[arg(short, long, value_name = "FILE.png")]
    output: Option<PathBuf>,
    /// How much brighter differences are drawn than they are
    #[arg(long, value_name = "FACTOR", default_value = "16")]
    gain: f32,
    /// Frames timed for each picture, after one that is not
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), default_value = "3")]
    frames: u16,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
    /// Say nothing on standard error but errors
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    engine: Engine,
    #[command(flatten)]
    scene: SceneFlags,
    #[command(flatten)]
    raw: RawFlags,
}

/// Settings of the scene document.
#[derive(Clone, Debug, Default)]
struct Settings(Vec<Setting>);

impl FromStr for Settings {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split(';').map(|part| part.trim().parse()).collect::<Result<_, _>>().map(Self)
    }
}

/// One way to draw the scene.
#[derive(Clone, Debug, Default)]
struct Rendition {
    label: String,
    /// The scene's own if it is not said.
    technique: Option<Likeness>,
    settings: Settings,
    backend: Option<Backend>,
}

/// Ways to draw shadows along rays, by name, and what makes a scene one of them.
const SHADOWS: [(&str, &str); 2] = [
    ("shadow-rays", "lighting.model=scattering; lighting.shadows.rays.step=1"),
    ("shadow-volume", "lighting.model=scattering; lighting.shadows.volume.resolution=0.5"),
];

/// What can be drawn, by name, and with which settings.
fn known() -> impl Iterator<Item = (&'static str, Likeness, &'static str)> + Clone {
    let shadows = SHADOWS.map(|(name, settings)| (name, Technique::along_rays as Likeness, settings));
    TECHNIQUES.iter().map(|(name, likeness)| (*name, *likeness, "")).chain(shadows)
}

fn techniques_help() -> String {
    let names: Vec<&str> = known().map(|(name, ..)| name).collect();
    let shadows: Vec<&str> = SHADOWS.iter().map(|(name, _)| *name).collect();
    format!(
        "Techniques to draw with, the reference first: {} ({} cast rays); each may say where, as ray-cast@cpu or \
         ray-cast@gpu [default: the scene's own]",
        names.join(", "),
        shadows.join(" and ")
    )
}

impl FromStr for Rendition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, place) = text.split_once('@').map_or((text, None), |(name, place)| (name, Some(place)));
        let known = known();
        let found = known.clone().find(|(known, ..)| *known == name);
        let unknown = || {
            let names: Vec<&str> = known.map(|(name, ..)| name).collect();
            let pointer = meant(name, names.iter().copied());
            let pointer = pointer.map_or_else(String::new, |name| format!(" (did you mean {name}?)"));
            format!("'{name}' is none of {}{pointer}", names.join(", "))
        };
        let (_, technique, settings) = found.ok_or_else(unknown)?;
        let backend = |place: &str| {
            let found = BACKENDS.iter().find(|(known, _)| *known == place);
            found.map(|(_, backend)| *backend).ok_or_else(|| format!("'{place}' is none of auto, cpu, gpu"))
        };
        Ok(Self {
            label: text.to_owned(),
            technique: Some(technique),
            settings: if settings.is_empty() { Settings::default() } else { settings.parse()? },
            backend: place.map(backend).transpose()?,
        })
    }
}

/// A picture and its figures.
struct Compared {
    label: String,
    renderer: String,
    rgba: Vec<u8>,
    median_ms: f64,
    samples: f64,
    error: Difference,
}

pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    let report = Report { quiet: args.quiet };
    let cancel = interrupt::listen();
    let base = args.input.open(&args.raw)?;
    let scene = args.scene.apply(&base.scene)?;
    render::affordable(&scene.image, 1)?;
    let idle = args.engine.check()?;
    render::drawable(&scene, &base)?;
    if let Some(path) = &args.output {
        output::writable(path)?;
    }
    let (volumes, warnings) = base.load(&scene)?;
    let Staged { scene, choices, warnings: of_settings, .. } = args.scene.stage(&base, scene, &volumes)?;
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    warnings.extend(idle);
    warnings.extend(of_settings);
    report.opening(&scene, &volumes, &choices, &warnings);
    let mut drawn: Vec<Compared> = Vec::new();
    for rendition in args.renditions() {
        let plan = Plan {
            engine: rendition.backend.map_or_else(|| args.engine.clone(), |backend| args.engine.on(backend)),
            frames: args.frames.into(),
            warmup: 1,
            cancel: &cancel,
            quiet: args.quiet,
        };
        drawn.push(draw(&rendition, &scene, &volumes, plan, drawn.first())?);
    }
    if let Some(path) = &args.output {
        sheet(path, &drawn, &scene.image, args.gain)?;
        report.say(format_args!("wrote {}", path.display()));
    }
    if args.json { print_json(&json(&drawn)) } else { print(&table(&drawn)) }
}

impl CompareArgs {
    /// Threads to work on.
    pub fn threads(&self) -> u16 {
        self.engine.threads()
    }

    /// The pictures to draw: those of the techniques, then those with other settings.
    fn renditions(&self) -> Vec<Rendition> {
        let own = Rendition { label: "scene".into(), ..Rendition::default() };
        let mut all = if self.techniques.is_empty() { vec![own] } else { self.techniques.clone() };
        let first = all[0].clone();
        all.extend(self.also.iter().map(|also| {
            let settings = first.settings.0.iter().chain(&also.0).cloned().collect();
            let label = also.0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
            Rendition { label, settings: Settings(settings), ..first.clone() }
        }));
        all
    }
}

fn draw(
    rendition: &Rendition,
    scene: &Scene,
    volumes: &[std::sync::Arc<Volume>],
    plan: Plan,
    reference: Option<&Compared>,
) -> Result<Compared, Failure> {
    let mut scene = scene.clone();
    if let Some(technique) = rendition.technique {
        scene.technique = technique(&scene.technique);
    }
    let scene = set::apply(&scene, &rendition.settings.0)?;
    let mut meter = Meter::new(Plan { engine: plan.engine.suited_to(&scene.technique), ..plan })?;
    let (timing, frame): (_, Frame) = still(&scene, volumes, &mut meter)?;
    let rgba = frame.to_rgba8(&scene.image);
    let error = reference.map_or_else(|| Difference::between(&rgba, &rgba), |of| Difference::between(&of.rgba, &rgba));
    Ok(Compared {
        label: rendition.label.clone(),
        renderer: meter.describe(),
        median_ms: timing.median_ms(),
        samples: timing.samples(),
        rgba,
        error,
    })
}

/// The pictures above their differences from the first.
fn sheet(path: &std::path::Path, drawn: &[Compared], image: &ImageSettings, gain: f32) -> Result<(), Failure> {
    let (width, height) = (image.width as usize, image.height as usize);
    let columns = drawn.len();
    let mut sheet = vec![0u8; columns * width * 2 * height * 4];
    let row_bytes = width * 4;
    for (column, picture) in drawn.iter().enumerate() {
        let pixels = picture.rgba.chunks_exact(4).zip(drawn[0].rgba.chunks_exact(4));
        let difference = |(a, b): (&[u8], &[u8])| {
            let part = |channel: usize| (f32::from(a[channel].abs_diff(b[channel])) * gain).min(255.0) as u8;
            [part(0), part(1), part(2), 255]
        };
        let differences: Vec<u8> = pixels.flat_map(difference).collect();
        for (half, content) in [&picture.rgba, &differences].into_iter().enumerate() {
            for (row, line) in content.chunks_exact(row_bytes).enumerate() {
                let start = ((half * height + row) * columns + column) * row_bytes;
                sheet[start..start + row_bytes].copy_from_slice(line);
            }
        }
    }
    let size = [(columns * width) as u32, 2 * height as u32];
    Ok(write_png(path, size[0], size[1], PngPixels::U8(&sheet), Transfer::Srgb)?)
}

fn table(drawn: &[Compared]) -> String {
    let widest = drawn.iter().map(|drawn| drawn.label.len()).fold(9, usize::max);
    let mut text = format!(
        "{:<widest$}  {:>9}  {:>10}  {:>8}  {:>7}  {:>7}  renderer\n",
        "technique", "median ms", "samples", "PSNR dB", "largest", "mean"
    );
    for Compared { label, renderer, median_ms, samples, error, .. } in drawn {
        let Difference { psnr, largest, mean } = error;
        text += &format!(
            "{label:<widest$}  {median_ms:>9.2}  {samples:>10.0}  {psnr:>8.1}  {largest:>7}  {mean:>7.3}  {renderer}\n"
        );
    }
    text
}

fn json(drawn: &[Compared]) -> Value {
    let one = |drawn: &Compared| {
        json!({
            "technique": drawn.label,
            "renderer": drawn.renderer,
            "median_ms": drawn.median_ms,
            "samples": drawn.samples,
            "psnr_db": drawn.error.psnr_json(),
            "largest_difference": drawn.error.largest,
            "mean_difference": drawn.error.mean,
        })
    };
    Value::Array(drawn.iter().map(one).collect())
}
