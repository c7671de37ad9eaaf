//! Where memory ends: the command promises an exit code, a line that says why, and no half-written files.
//!
//! Large memory is asked for by `pellucid::field::memory`, and its lack is an error like others. All other code takes
//! for granted that there is memory, and Rust aborts where there is none. This allocator, the system's otherwise,
//! ends the command in good order instead.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use pellucid::field::memory::is_attempt;
use pellucid::io::discard_unfinished;

/// The system's memory.
pub struct Memory;

// SAFETY: every request goes to the system's allocator as it is, and its answer goes back; or null, which any request
// may be answered with.
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those that the system's allocator needs.
        granted(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        granted(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        granted(size, || unsafe { System.realloc(old, layout, size) })
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[inline(always)]
fn granted(bytes: usize, ask: impl FnOnce() -> *mut u8) -> *mut u8 {
    let memory = if is_rehearsed(bytes) { null_mut() } else { ask() };
    if memory.is_null() {
        refused(bytes);
    }
    memory
}

/// Ends the command, unless whoever asked copes with a refusal.
#[cold]
fn refused(bytes: usize) {
    thread_local! {
        // Without a destructor, for it is read where memory is allocated.
        static IS_ENDING: Cell<bool> = const { Cell::new(false) };
    }
    static IS_ENDED: AtomicBool = AtomicBool::new(false);
    if is_attempt() || IS_ENDING.replace(true) {
        return;
    }
    if IS_ENDED.swap(true, Ordering::SeqCst) {
        // Another thread has met the same, and says so.
        loop {
            std::thread::park();
        }
    }
    let mut out = std::io::stderr();
    let _ = writeln!(out, "pellucid: error: memory is used up: {bytes} more bytes were refused");
    discard_unfinished();
    std::process::exit(1);
}

/// Large requests that are still to come until one is refused; tests count it up until the work succeeds.
static REHEARSED: AtomicU64 = AtomicU64::new(0);

/// Reads from the environment which request is to be refused, in `PELLUCID_FAULT_MEMORY`. Not in release builds.
pub fn rehearse() {
    if cfg!(debug_assertions)
        && let Some(number) = std::env::var("PELLUCID_FAULT_MEMORY").ok().and_then(|number| number.parse().ok())
    {
        REHEARSED.store(number, Ordering::SeqCst);
    }
}

#[inline(always)]
fn is_rehearsed(bytes: usize) -> bool {
    /// Tests have no time for every small one.
    const LARGE: usize = 1 << 13;
    let count = || REHEARSED.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| left.checked_sub(1));
    cfg!(debug_assertions) && bytes >= LARGE && count() == Ok(1)
}
