//! What the command says: results to standard output, remarks to standard error.

use std::fmt;
use std::io::{ErrorKind, Write};
use std::sync::Arc;

use pellucid::field::{Short, Volume, printable};
use pellucid::scene::{Choice, Scene, VolumeEntry};

use super::failure::Failure;

/// Remarks on standard error, one line each, unless silenced.
#[derive(Clone, Copy)]
pub struct Report {
    /// Whether nothing is said.
    pub quiet: bool,
}

impl Report {
    /// A fact.
    pub fn say(&self, line: impl fmt::Display) {
        if !self.quiet {
            // If standard error is gone there is nobody to tell.
            let line = line.to_string();
            let _ = writeln!(std::io::stderr(), "pellucid: {}", printable(&line));
        }
    }

    /// Something the user should hear of.
    pub fn warn(&self, line: impl fmt::Display) {
        self.say(format_args!("warning: {line}"));
    }

    /// What is about to be drawn: the volumes, what was chosen for them, what was lost.
    pub fn opening(&self, scene: &Scene, volumes: &[Arc<Volume>], choices: &[Choice], warnings: &[String]) {
        scene.volumes.iter().zip(volumes).for_each(|(entry, volume)| self.say(describe(entry, volume)));
        choices.iter().for_each(|choice| self.say(in_flags(choice)));
        warnings.iter().for_each(|warning| self.warn(warning));
    }
}

/// Advice of the library, which speaks of settings, in the flags that set them.
pub fn in_flags(advice: impl fmt::Display) -> String {
    const FLAGS: [(&str, &str); 6] = [
        ("volumes[0].colors = \"transfer_function\"", "--colors transfer-function"),
        ("volumes[0].component", "--component"),
        ("volumes[0].window, preset or opacity", "--window, --preset or --opacity"),
        ("volumes[0].unit_distance", "--unit-distance"),
        ("A crop or clips to the inside show", "--crop or --clip to the inside shows"),
        ("lighting.lights brings others", "--look studio, sky, skin or cloud bring others"),
    ];
    FLAGS.iter().fold(advice.to_string(), |advice, (settings, flags)| advice.replace(settings, flags))
}

/// A volume as it is drawn: with the spacing that the scene states.
fn describe(entry: &VolumeEntry, volume: &Volume) -> String {
    let [x, y, z] = volume.grid().dims();
    let [sx, sy, sz] = entry.spacing.unwrap_or(volume.grid().spacing()).map(Short);
    let unit = volume.length_unit.as_deref().unwrap_or("world units");
    let voxel_type = volume.voxels().voxel_type();
    format!("{}: {x}x{y}x{z} {voxel_type}, spacing {sx} x {sy} x {sz} {unit}", volume.name)
}

/// Prints a result to standard output.
pub fn print(text: &str) -> Result<(), Failure> {
    let lines: Vec<_> = text.split('\n').map(printable).collect();
    print_as_is(lines.join("\n").as_bytes())
}

/// Prints what nobody outside had a part in. A reader that has seen enough (`| head`) is no failure.
pub fn print_as_is(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::work(format_args!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a result as JSON. What would steer a terminal and is no control character to JSON is escaped as well.
pub fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    let mut text = String::new();
    for c in format!("{value:#}\n").chars() {
        if c == '\n' || printable(c.encode_utf8(&mut [0; 4])) != "?" || c == '?' {
            text.push(c);
        } else {
            text.push_str(&format!("\\u{:04x}", u32::from(c)));
        }
    }
    print(&text)
}
