//! `pellucid info`.

use std::fmt::Write;
use std::sync::Arc;

use pellucid::field::{Grid, Histogram, Short, Volume, Warning, printable};
use pellucid::optics::Scattering;
use pellucid::scene::{Choice, Scene, VolumeEntry};
use serde_json::{Value, json};

use super::failure::Failure;
use super::input::{Input, RawFlags};
use super::report::{in_flags, print, print_json};
use super::{adapters, histogram};

#[derive(clap::Args)]
pub struct InfoArgs {
    /// Volume files, scenes, or sample:NAME
    #[arg(required_unless_present = "adapters", value_name = "FILE")]
    inputs: Vec<Input>,
    /// List the graphics adapters instead, with their limits and optional features
    #[arg(long, conflicts_with = "inputs")]
    adapters: bool,
    /// Print one JSON array, an object per volume or adapter
    #[arg(long)]
    json: bool,
    /// Component of the histogram and the automatic choices, from 0 [default: the scene's; else 0 for the
    /// histogram, and for choices what a picture would be of]
    #[arg(long, value_name = "K")]
    component: Option<usize>,
    #[command(flatten)]
    raw: RawFlags,
}

pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    if args.adapters {
        return adapters::list(args.json);
    }
    let mut objects = Vec::new();
    for (k, input) in args.inputs.iter().enumerate() {
        let base = input.open(&args.raw)?;
        let (volumes, warnings) = base.load(&base.scene)?;
        for (volume, entry) in volumes.iter().zip(&base.scene.volumes) {
            let about = About::new(volume, entry, args.component, &warnings)?;
            if args.json {
                objects.push(about.json());
            } else {
                let gap = if k > 0 { "\n" } else { "" };
                print(&format!("{gap}{}", about.text(columns())))?;
            }
        }
    }
    if args.json { print_json(&Value::Array(objects)) } else { Ok(()) }
}

/// Width of the terminal, or of the usual one where there is none.
fn columns() -> usize {
    terminal_size::terminal_size().map_or(80, |(width, _)| width.0.into())
}

/// Everything there is to say of a volume.
struct About<'v> {
    /// As it is drawn: with the spacing that a scene states.
    volume: Arc<Volume>,
    histogram: Histogram,
    warnings: &'v [Warning],
    /// How a picture of the volume would make it look by itself.
    choices: Vec<Choice>,
}

impl<'v> About<'v> {
    fn new(
        volume: &Arc<Volume>,
        entry: &VolumeEntry,
        component: Option<usize>,
        warnings: &'v [Warning],
    ) -> Result<Self, Failure> {
        let asked = component.or(entry.component);
        let component = asked.unwrap_or_default();
        let entry = VolumeEntry { component: asked, scattering: Scattering::default(), ..entry.clone() };
        let scene = Scene { volumes: vec![entry], ..Scene::default() };
        let (stage, mut choices) = scene.resolve(std::slice::from_ref(volume))?;
        choices.retain(|choice| choice.setting != "camera");
        let histogram = Histogram::of_levels(volume, component)
            .map_or_else(|| Histogram::new(volume, component, Histogram::BINS), Ok)
            .map_err(Failure::input)?;
        // The values are the file's, also where they are drawn as differences.
        let volume = match stage.volumes.first().map(|staged| staged.volume.grid()) {
            Some(grid) if grid != volume.grid() => {
                Arc::new(Volume::clone(volume).with_grid(*grid).map_err(Failure::input)?)
            }
            _ => volume.clone(),
        };
        Ok(Self { volume, histogram, warnings, choices })
    }

    fn text(&self, columns: usize) -> String {
        let (volume, grid) = (&*self.volume, self.volume.grid());
        let mut text = format!("{}\n", printable(&volume.name));
        let mut line = |label: &str, value: String| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "  {label:<15}{}", printable(&value));
        };
        let length = volume.length_unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        let data = volume.value_unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
        let [x, y, z] = grid.dims();
        if let Some(description) = &volume.description {
            line("holds", description.clone());
        }
        line("dims", format!("{x} x {y} x {z}"));
        line("type", format!("{}, {}", volume.voxels().voxel_type(), components(volume.components())));
        let map = volume.value_map();
        if (map.scale, map.offset) != (1.0, 0.0) {
            line("values are", format!("stored * {} + {}", Short(map.scale), Short(map.offset)));
        }
        line("spacing", format!("{}{length}", triple(grid.spacing(), " x ")));
        line("size", format!("{}{length}", triple(extent(grid), " x ")));
        line("origin", format!("{}{length}", triple(grid.world_from_index().translation.to_array(), ", ")));
        if volume.is_anatomical {
            line("axes point", format!("{} (left, posterior, superior are +x, +y, +z)", orientation(grid)));
        } else {
            line("axes point", "where the file does not say: the sides of the data are not known".into());
        }
        let counts = volume.statistics();
        let all = if volume.components() > 1 { ", all components" } else { "" };
        if counts.finite == 0 {
            line("range", "none, as no value is finite".to_owned());
        } else {
            let [low, high] = Short::ends(counts.min, counts.max);
            line("range", format!("{low} to {high}{data}{all}"));
            line("mean", format!("{}{data}{all}", Short(counts.mean)));
        }
        if counts.nan + counts.infinite > 0 {
            line("absent", format!("{} NaN, {} infinite", counts.nan, counts.infinite));
        }
        self.choices.iter().for_each(|choice| line(choice.setting, in_flags(&choice.chosen)));
        self.warnings.iter().for_each(|warning| line("warning", warning.to_string()));
        text + &histogram::draw(&self.histogram, columns, 8)
    }

    fn json(&self) -> Value {
        let (volume, grid) = (&*self.volume, self.volume.grid());
        let counts = volume.statistics();
        let affine = grid.world_from_index();
        json!({
            "name": volume.name,
            "description": volume.description,
            "dims": grid.dims(),
            "type": volume.voxels().voxel_type().name(),
            "components": volume.components(),
            "value_map": { "scale": volume.value_map().scale, "offset": volume.value_map().offset },
            "value_unit": volume.value_unit,
            "length_unit": volume.length_unit,
            "spacing": grid.spacing(),
            "size": extent(grid),
            "origin": affine.translation.to_array(),
            "orientation": volume.is_anatomical.then(|| orientation(grid)),
            "world_from_index": affine.to_cols_array_2d(),
            "min": (counts.finite > 0).then_some(counts.min),
            "max": (counts.finite > 0).then_some(counts.max),
            "mean": (counts.finite > 0).then_some(counts.mean),
            "nan": counts.nan,
            "infinite": counts.infinite,
            "choices": choices_json(&self.choices),
            "warnings": self.warnings.iter().map(Warning::to_string).collect::<Vec<_>>(),
            "histogram": {
                "low": self.histogram.range().0,
                "bin_width": self.histogram.width(),
                "counts": self.histogram.counts(),
            },
        })
    }
}

/// Choices as JSON, in the order they were made.
pub fn choices_json(choices: &[Choice]) -> Vec<Value> {
    choices
        .iter()
        .map(|choice| json!({ "setting": choice.setting, "chosen": choice.chosen, "value": choice.value }))
        .collect()
}

fn components(n: usize) -> String {
    if n == 1 { "1 component".into() } else { format!("{n} components") }
}

fn triple(v: [f64; 3], between: &str) -> String {
    v.map(|v| Short(v).to_string()).join(between)
}

/// Length of the grid's edges in world units, from outermost sample to outermost sample.
fn extent(grid: &Grid) -> [f64; 3] {
    let (low, high) = grid.index_bounds();
    let spacing = grid.spacing();
    std::array::from_fn(|axis| (high - low)[axis] * spacing[axis])
}

/// The patient direction nearest to each index axis, as in "LPS"; small letters mark axes that
/// are oblique by more than a degree.
fn orientation(grid: &Grid) -> String {
    let affine = grid.world_from_index().matrix3;
    let letter = |column: [f64; 3]| {
        let largest = (0..3).max_by(|&a, &b| column[a].abs().total_cmp(&column[b].abs())).unwrap_or(0);
        let letter = [['L', 'R'], ['P', 'A'], ['S', 'I']][largest][usize::from(column[largest] < 0.0)];
        let length = column.iter().map(|v| v * v).sum::<f64>().sqrt();
        let aligned = column[largest].abs() >= length * 1f64.to_radians().cos();
        if aligned { letter } else { letter.to_ascii_lowercase() }
    };
    [affine.x_axis, affine.y_axis, affine.z_axis].map(|column| letter(column.to_array())).iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_names_the_nearest_patient_direction() {
        let grid = |spacing| Grid::with_spacing([2; 3], spacing, [0.0; 3]).unwrap();
        assert_eq!(orientation(&grid([1.0, 2.0, 3.0])), "LPS");
        assert_eq!(orientation(&grid([-1.0, -2.0, 3.0])), "RAS");
    }

    #[test]
    fn size_is_from_sample_to_sample() {
        assert_eq!(extent(&Grid::with_spacing([3, 5, 1], [0.5, 2.0, 7.0], [0.0; 3]).unwrap()), [1.0, 8.0, 7.0]);
    }
}
