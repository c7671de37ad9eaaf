//! The threads that parallel work runs on.

use std::cell::Cell;
use std::sync::{Arc, OnceLock};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// Why there are not so many threads.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("cannot start {threads} threads: {reason}")]
pub struct ThreadsError {
    /// Threads asked for.
    pub threads: usize,
    /// The system's reason.
    pub reason: String,
}

/// A number of threads to work on; clones are the same threads. What runs in parallel in this crate and those above
/// it runs on the ones that [`Threads::run`] chose, or else on some that are shared by the whole process and as many
/// as there are cores; never on rayon's global pool, which panics where the system has no threads to give.
#[derive(Clone, Debug)]
pub struct Threads(Arc<ThreadPool>);

thread_local! {
    /// Whether this thread is one of a [`Threads`], or does their work where there are none.
    static IS_OURS: Cell<bool> = const { Cell::new(false) };
}

impl Threads {
    /// The most threads. Systems hang rather than refuse far beyond.
    pub const MOST: usize = 1024;

    /// Room on a thread. Code that follows many rays at a time takes some megabytes where it was compiled without
    /// optimization, which is more than the two that threads have by default; only what is used is memory.
    const STACK: usize = if cfg!(debug_assertions) { 64 << 20 } else { 8 << 20 };

    /// Starts threads, 1 to [`Threads::MOST`].
    ///
    /// # Errors
    /// [`ThreadsError`] if there are too many or the system refuses them.
    pub fn new(threads: usize) -> Result<Self, ThreadsError> {
        if !(1..=Self::MOST).contains(&threads) {
            return Err(ThreadsError { threads, reason: format!("1 to {} are possible", Self::MOST) });
        }
        Self::start(threads).map_err(|error| ThreadsError { threads, reason: error.to_string() })
    }

    /// Starts threads; 0 are as many as there are cores, or as the environment says in `RAYON_NUM_THREADS`.
    fn start(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let builder = ThreadPoolBuilder::new().num_threads(threads).stack_size(Self::STACK);
        let pool =
            builder.thread_name(|number| format!("pellucid-{number}")).start_handler(|_| IS_OURS.set(true)).build()?;
        Ok(Self(Arc::new(pool)))
    }

    /// Does work on these threads, and returns when it is done.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.0.install(work)
    }
}

/// Does work that runs in parallel inside: on the threads that the caller is on by [`Threads::run`], else on those
/// shared by the process. Where the system has no threads to give, this thread does all of it.
pub fn parallel<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    static SHARED: OnceLock<Option<Threads>> = OnceLock::new();
    if IS_OURS.get() {
        return work();
    }
    match SHARED.get_or_init(|| Threads::start(0).ok()) {
        Some(threads) => threads.run(work),
        None => alone(work),
    }
}

/// Does work on this thread, as its only one.
fn alone<R>(work: impl FnOnce() -> R) -> R {
    // A thread that joins a pool belongs to it for good. If it belongs to one already, that one does the work.
    std::mem::forget(ThreadPoolBuilder::new().num_threads(1).use_current_thread().build());
    IS_OURS.set(true);
    work()
}

/// How many threads [`parallel`] work has.
pub fn thread_count() -> usize {
    parallel(rayon::current_num_threads)
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    fn sum() -> u64 {
        (0..100_000u64).into_par_iter().sum()
    }

    #[test]
    fn work_stays_on_the_threads_it_was_given() {
        let three = Threads::new(3).unwrap();
        let inside = || (thread_count(), parallel(|| std::thread::current().name().map(str::to_owned)), sum());
        let (count, name, sum) = three.run(inside);
        assert_eq!((count, sum), (3, 4_999_950_000));
        assert!(name.unwrap().starts_with("pellucid-"));
        // Not on those of somebody else, whose stacks are small.
        let other = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        assert!(other.install(|| parallel(|| IS_OURS.get())));
        for threads in [0, Threads::MOST + 1] {
            assert_eq!(Threads::new(threads).unwrap_err().threads, threads);
        }
    }

    #[test]
    fn without_threads_the_caller_works_alone() {
        let caller = std::thread::spawn(|| {
            let id = std::thread::current().id();
            let workers: Vec<_> = alone(|| (0..1000).into_par_iter().map(|_| std::thread::current().id()).collect());
            assert!(workers.iter().all(|worker| *worker == id));
            assert_eq!((parallel(sum), thread_count()), (4_999_950_000, 1));
        });
        caller.join().unwrap();
    }

    #[test]
    fn stacks_are_large() {
        /// Twice what rayon gives by default.
        fn deep(levels: usize) -> usize {
            let room = std::hint::black_box([1u8; 1 << 16]);
            if levels == 0 { 0 } else { deep(levels - 1) + usize::from(room[levels]) }
        }
        assert_eq!(parallel(|| deep(64)), 64);
    }
}
