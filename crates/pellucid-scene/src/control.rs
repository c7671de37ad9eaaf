//! Progress and cancellation of long work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A switch that stops a render from another thread. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks the work to stop; it returns within 50 ms.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Work was stopped by its [`Cancel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// How a caller watches and stops a render.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// Called with the share done, 0 to 1, from any thread and never backwards.
    pub progress: Option<&'a (dyn Fn(f64) + Sync)>,
    /// Stops the work.
    pub cancel: Option<&'a Cancel>,
    /// Whether the picture shall be there soon.
    pub haste: Option<Haste>,
}

/// A picture that shall be there soon: light that surfaces do not know of yet (`illumination.global`) is followed by few
/// paths, and not any more after some time. What is left is counted in the frame's statistics, and known to later pictures.
#[derive(Clone, Copy, Debug)]
pub struct Haste {
    /// When no more light is followed.
    pub due: Instant,
    /// Paths from each place, at most.
    pub paths: u32,
}

impl Control<'_> {
    /// Whether the work was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(Cancel::is_cancelled)
    }

    /// Reports the share done.
    pub fn report(&self, share: f64) {
        if let Some(progress) = self.progress {
            progress(share);
        }
    }
}
