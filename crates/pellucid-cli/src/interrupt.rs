//! Signals that ask the command to end: Ctrl-C and its kin.

use std::sync::atomic::{AtomicI32, Ordering};

use pellucid::io::discard_unfinished;
use pellucid::scene::Cancel;

use super::failure::Failure;

/// What a signal does: end the command [`AT_ONCE`], ask it to stop, or, if that is the number of the one that asked,
/// end it at once, too.
static STATE: AtomicI32 = AtomicI32::new(AT_ONCE);
const AT_ONCE: i32 = 0;
const GRACEFUL: i32 = -1;

/// From now on a signal ends the command with exit code 128 plus its number: at once, with the files that are not
/// finished removed; during [`gracefully`] by way of the returned switch, and at once at a second signal.
pub fn listen() -> Cancel {
    let cancel = Cancel::default();
    let switch = cancel.clone();
    each_signal(move |signal| match STATE.compare_exchange(GRACEFUL, signal, Ordering::SeqCst, Ordering::SeqCst) {
        Ok(_) => switch.cancel(),
        Err(_) => {
            discard_unfinished();
            exit(signal);
        }
    });
    cancel
}

/// Does work that watches the switch of [`listen`].
pub fn gracefully<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    match stoppable(work) {
        (done, None) => done,
        // The work may have been over by then.
        (_, Some(code)) => Err(Failure::cancelled().code(code)),
    }
}

/// Does work that watches the switch of [`listen`] and may have something to show when it is stopped: what it came to,
/// and, if a signal stopped it, the exit code. From then on, another signal ends the command at once.
pub fn stoppable<T>(work: impl FnOnce() -> Result<T, Failure>) -> (Result<T, Failure>, Option<u8>) {
    STATE.store(GRACEFUL, Ordering::SeqCst);
    let done = work();
    let signal = STATE.compare_exchange(GRACEFUL, AT_ONCE, Ordering::SeqCst, Ordering::SeqCst).err();
    (done, signal.map(|signal| 128 + signal as u8))
}

#[cfg(unix)]
fn each_signal(act: impl Fn(i32) + Send + 'static) {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc::channel;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;

    // A file larger than the system allows is an error of writing it.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::<AtomicBool>::default());
    let mut endings = vec![SIGINT, SIGTERM, SIGQUIT, SIGXCPU];
    if !is_ignored(SIGHUP) {
        endings.push(SIGHUP);
    }
    let (ready, is_ready) = channel();
    let listener = move || {
        let signals = Signals::new(endings);
        let _ = ready.send(());
        if let Ok(mut signals) = signals {
            signals.forever().for_each(act);
        }
    };
    // Without a listener the system ends the process, which is nearly as good.
    if std::thread::Builder::new().name("signals".into()).spawn(listener).is_ok() {
        let _ = is_ready.recv();
    }
}

/// Whether whoever started the command wants it to outlive a signal, as `nohup` does.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Without anything that libraries do at the end: they are in the middle of their work.
#[cfg(unix)]
fn exit(signal: i32) {
    signal_hook::low_level::exit(128 + signal);
}

#[cfg(not(unix))]
fn each_signal(act: impl Fn(i32) + Send + 'static) {
    const SIGINT: i32 = 2;
    let _ = ctrlc::set_handler(move || act(SIGINT));
}

#[cfg(not(unix))]
fn exit(signal: i32) {
    std::process::exit(128 + signal);
}
