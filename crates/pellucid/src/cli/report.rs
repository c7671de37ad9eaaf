//! What the command says: results to standard output, remarks to standard error.

use std::fmt;
use std::io::{ErrorKind, Write};

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
