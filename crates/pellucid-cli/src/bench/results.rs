//! Figures as text and as JSON.

use serde_json::{Value, json};

use super::reference::Error;
use super::subject::Subject;
use super::sweep::{Row, Sweep};
use super::timing::{HEADINGS, Timing};
use crate::info::choices_json;

/// A scene's figures.
pub struct Results {
    /// The scene.
    pub subject: Subject,
    /// What draws, in words.
    pub renderer: String,
    /// What the graphics adapter can do, if one draws.
    pub capabilities: Option<String>,
    /// What the frames of [`Results::orbit`] walked.
    pub degrees: f64,
    /// The frames of the walk.
    pub orbit: Timing,
    /// The error of its first picture, if it was asked for.
    pub error: Option<Error>,
    /// The sweeps, in the order asked for.
    pub sweeps: Vec<(Sweep, Vec<Row>)>,
}

impl Results {
    /// Tables for people.
    pub fn text(&self) -> String {
        let Subject { name, stage, load_seconds, first_ms, .. } = &self.subject;
        let (width, height) = (stage.viewpoint.width, stage.viewpoint.height);
        let frames = self.orbit.laps.len();
        let walk = format!("{frames} frames over {} degrees", self.degrees);
        let mut text = format!(
            "{name}, {width}x{height}: loaded in {load_seconds:.3} s, first picture {first_ms:.1} ms later, then {walk}\n"
        );
        text += &format!("drawn on: {}\n", self.renderer);
        text += &table("orbit", &[("".into(), &self.orbit)]);
        if let Some(ms) = self.orbit.device_ms() {
            text += &format!("by the adapter's own clock: {ms:.2} ms\n");
        }
        let (gigabytes, rate) = (self.voxel_gigabytes(), self.voxel_rate());
        text += &format!("voxels under samples: {gigabytes:.3} GB, {rate:.2} GB/s\n");
        text += &self.error.as_ref().map(Error::text).unwrap_or_default();
        for (sweep, rows) in &self.sweeps {
            let lines: Vec<(String, &Timing)> = rows.iter().map(|row| (row.label.clone(), &row.timing)).collect();
            text += &format!("\n{}", table(sweep.name(), &lines));
            text += &format!("slowest / fastest: {:.2}\n", spread(rows));
        }
        text
    }

    /// Voxels that the samples of a frame stand on, in gigabytes: eight for each.
    fn voxel_gigabytes(&self) -> f64 {
        let bytes = self.subject.volumes.first().map_or(0, |volume| volume.voxels().voxel_type().size());
        self.orbit.samples() * 8.0 * bytes as f64 / 1e9
    }

    /// The same in a second of drawing.
    fn voxel_rate(&self) -> f64 {
        self.voxel_gigabytes() / self.orbit.drawing_ms() * 1e3
    }

    /// Everything for programs.
    pub fn json(&self) -> Value {
        let Subject { name, volumes, stage, choices, warnings, load_seconds, first_ms, .. } = &self.subject;
        let volumes = volumes.iter().map(|volume| {
            let voxel_type = volume.voxels().voxel_type().name();
            json!({ "name": volume.name, "dims": volume.grid().dims(), "type": voxel_type })
        });
        let sweeps = self.sweeps.iter().map(|(sweep, rows)| {
            let row = |Row { label, timing }: &Row| json!({ "setting": label, "timing": timing.json() });
            let lines: Vec<Value> = rows.iter().map(row).collect();
            json!({ "sweep": sweep.name(), "rows": lines, "slowest_over_fastest": spread(rows) })
        });
        json!({
            "input": name,
            "renderer": self.renderer,
            "capabilities": self.capabilities,
            "voxel_gigabytes": self.voxel_gigabytes(),
            "voxel_gigabytes_per_second": self.voxel_rate(),
            "error": self.error.as_ref().map(Error::json),
            "volumes": volumes.collect::<Vec<_>>(),
            "width": stage.viewpoint.width,
            "height": stage.viewpoint.height,
            "step": stage.step,
            "choices": choices_json(choices),
            "warnings": warnings,
            "load_seconds": load_seconds,
            "first_frame_ms": first_ms,
            "orbit": { "degrees": self.degrees, "timing": self.orbit.json() },
            "sweeps": sweeps.collect::<Vec<_>>(),
        })
    }
}

/// How much the slowest setting takes of the time of the fastest.
fn spread(rows: &[Row]) -> f64 {
    let medians = || rows.iter().map(|row| row.timing.median_ms());
    medians().fold(0.0, f64::max) / medians().fold(f64::INFINITY, f64::min)
}

/// One line per timing under common headings, numbers flush right.
fn table(title: &str, rows: &[(String, &Timing)]) -> String {
    let cells: Vec<[String; HEADINGS.len()]> = rows.iter().map(|(_, timing)| timing.cells()).collect();
    let widest = |column: usize| cells.iter().map(|line| line[column].len()).fold(HEADINGS[column].len(), usize::max);
    let first = rows.iter().map(|(label, _)| label.len()).fold(title.len(), usize::max);
    let line = |label: &str, cells: [&str; HEADINGS.len()]| {
        let mut line = format!("{label:<first$}");
        for (column, cell) in cells.into_iter().enumerate() {
            line += &format!("  {cell:>width$}", width = widest(column));
        }
        line + "\n"
    };
    let mut text = line(title, HEADINGS);
    for ((label, _), cells) in rows.iter().zip(&cells) {
        text += &line(label, cells.each_ref().map(String::as_str));
    }
    text
}
