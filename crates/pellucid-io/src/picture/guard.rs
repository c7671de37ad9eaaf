//! Panics of other people's decoders, as errors.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::IoError;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is in a decoder whose panic becomes an error: a panic hook has nothing to tell then.
pub fn is_guarded() -> bool {
    GUARDED.get()
}

/// Does the work of a decoder that may panic on broken files, as exr 1.74.2 does where debug builds count beyond a
/// type, and png 0.18.1 did before palettes were checked. What the decoder was working on must not be used again.
pub(super) fn guarded<T>(
    damaged: impl FnOnce(String) -> IoError,
    work: impl FnOnce() -> Result<T, IoError>,
) -> Result<T, IoError> {
    let before = GUARDED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(before);
    done.unwrap_or_else(|_| Err(damaged("its numbers lead the decoder astray".to_owned())))
}
