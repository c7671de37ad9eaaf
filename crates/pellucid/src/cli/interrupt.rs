//! Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};

use pellucid::scene::Cancel;

use super::failure::{CANCELLED, Failure};

/// Whether the command can stop by itself, which it can once it renders or writes.
static GRACEFUL: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C ends the command with exit code 130: at once as long as nothing can be left
/// half done; after [`gracefully`], by way of the returned switch; at a second Ctrl-C, at once.
pub fn listen() -> Cancel {
    let cancel = Cancel::default();
    let switch = cancel.clone();
    // Without a handler the system ends the process, which is nearly as good.
    let _ = ctrlc::set_handler(move || {
        if switch.is_cancelled() || !GRACEFUL.load(Ordering::SeqCst) {
            std::process::exit(CANCELLED.into());
        }
        switch.cancel();
    });
    cancel
}

/// Does work that must not be torn: it watches the switch of [`listen`], or is over soon.
pub fn gracefully<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    GRACEFUL.store(true, Ordering::SeqCst);
    let done = work();
    GRACEFUL.store(false, Ordering::SeqCst);
    done
}
