//! A bar for work that takes more than a second, on a terminal.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress of one piece of work.
pub struct Progress {
    title: &'static str,
    quiet: bool,
    started: Instant,
    bar: OnceLock<ProgressBar>,
}

const STEPS: u64 = 1000;
/// What is over sooner needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);

impl Progress {
    /// Work that begins now.
    pub fn new(title: &'static str, quiet: bool) -> Self {
        Self { title, quiet, started: Instant::now(), bar: OnceLock::new() }
    }

    /// The share done, 0 to 1.
    pub fn report(&self, share: f64) {
        if !self.quiet && self.started.elapsed() > PATIENCE {
            self.bar.get_or_init(|| self.begin()).set_position((share * STEPS as f64) as u64);
        }
    }

    fn begin(&self) -> ProgressBar {
        // Hidden by itself where standard error is no terminal.
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} %, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(self.title);
        bar
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
