//! What the command says: results to standard output, remarks to standard error.

use std::fmt;
use std::io::{ErrorKind, Write};
use std::sync::Arc;

use pellucid::field::Volume;
use pellucid::scene::Choice;

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
            let _ = writeln!(std::io::stderr(), "pellucid: {line}");
        }
    }

    /// Something the user should hear of.
    pub fn warn(&self, line: impl fmt::Display) {
        self.say(format_args!("warning: {line}"));
    }

    /// What is about to be drawn: the volumes, what was chosen for them, what was lost.
    pub fn opening(&self, volumes: &[Arc<Volume>], choices: &[Choice], warnings: &[String]) {
        volumes.iter().for_each(|volume| self.say(describe(volume)));
        choices.iter().for_each(|choice| self.say(choice));
        warnings.iter().for_each(|warning| self.warn(warning));
    }
}

fn describe(volume: &Volume) -> String {
    let grid = volume.grid();
    let [x, y, z] = grid.dims();
    let [sx, sy, sz] = grid.spacing();
    let unit = volume.length_unit.as_deref().unwrap_or("world units");
    let voxel_type = volume.voxels().voxel_type();
    format!("{}: {x}x{y}x{z} {voxel_type}, spacing {sx:.4} x {sy:.4} x {sz:.4} {unit}", volume.name)
}

/// Prints a result to standard output. A reader that has seen enough (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::work(format_args!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a result as JSON.
pub fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    print(&format!("{value:#}\n"))
}
