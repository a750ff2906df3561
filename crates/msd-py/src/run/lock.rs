//! A run that several Python threads may share: its lock, and the threads of its steps.

use crate::errors::error;
use crate::run::force;
use msd_run::Runner;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// Value of [`forks`]. A child has neither the threads of its parent nor the locks that they would
/// have released.
static FORKS: AtomicU32 = AtomicU32::new(0);

/// Returns the number of forks between this process and the one that imported msd.
pub fn forks() -> u32 {
    FORKS.load(Ordering::Relaxed)
}

/// Called in a child that was forked.
#[pyfunction]
pub fn note_fork() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// A run, used by one thread at a time.
pub struct Shared {
    runner: Mutex<Runner>,
    /// Value of [`FORKS`] when the run was last locked.
    taken: AtomicU32,
    threads: Threads,
}

/// Reason why a run cannot be used.
enum Refusal {
    /// A callable force requests the run that is waiting for it.
    Force,
    /// The lock belongs to a thread of the parent process.
    Fork,
}

impl Shared {
    pub fn new(runner: Runner, threads: Threads) -> Self {
        Shared { runner: Mutex::new(runner), taken: AtomicU32::new(0), threads }
    }

    /// Returns the number of threads of a step.
    pub fn threads(&self) -> usize {
        self.threads.count
    }

    /// Runs `act` on the run without the GIL, and waits for other users of the run. An exception of
    /// a callable force has precedence over the result.
    pub fn work<T: Send>(
        &self,
        py: Python<'_>,
        act: impl FnOnce(&mut Runner) -> T + Send,
    ) -> PyResult<T> {
        let pool = self.threads.pool(py)?;
        let done = py.detach(|| -> Result<_, Refusal> {
            let mut runner = self.take()?;
            let runner = &mut *runner;
            let act = move || (act(runner), force::take_raised());
            Ok(match pool {
                Some(pool) => pool.install(act),
                None => act(),
            })
        });
        match done {
            Ok((done, None)) => Ok(done),
            Ok((_, Some(raised))) => Err(raised),
            Err(Refusal::Force) => Err(error(
                py,
                "a force cannot use a run that waits for it; use the arguments of the force",
            )),
            Err(Refusal::Fork) => Err(error(
                py,
                "another thread stepped this run as the process was forked, so its state here is \
                 unknown; open the run again in this process",
            )),
        }
    }

    fn take(&self) -> Result<MutexGuard<'_, Runner>, Refusal> {
        let forks = forks();
        let runner = match self.runner.try_lock() {
            Ok(runner) => runner,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) if force::is_asked() => return Err(Refusal::Force),
            Err(TryLockError::WouldBlock) if self.taken.load(Ordering::Relaxed) != forks => {
                return Err(Refusal::Fork);
            }
            Err(TryLockError::WouldBlock) => {
                self.runner.lock().unwrap_or_else(PoisonError::into_inner)
            }
        };
        self.taken.store(forks, Ordering::Relaxed);
        Ok(runner)
    }
}

/// The threads of the steps of a run: that of the caller, or a pool.
pub struct Threads {
    count: usize,
    /// The pool, with [`FORKS`] at its creation: a child creates a new one.
    pool: Mutex<Option<(u32, Arc<ThreadPool>)>>,
}

impl Threads {
    pub fn new(count: usize) -> Self {
        Threads { count, pool: Mutex::default() }
    }

    fn pool(&self, py: Python<'_>) -> PyResult<Option<Arc<ThreadPool>>> {
        if self.count < 2 {
            return Ok(None);
        }
        let forks = forks();
        // Held for a moment only, and not by who waits for Python.
        let mut pool = self.pool.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made, pool)) = &*pool
            && *made == forks
        {
            return Ok(Some(pool.clone()));
        }
        let built = ThreadPoolBuilder::new().num_threads(self.count).build();
        let refused = |reason| error(py, format!("threads={}: {reason}", self.count));
        let built = Arc::new(built.map_err(refused)?);
        // The pool of the parent has no threads here that could be joined.
        std::mem::forget(pool.replace((forks, built.clone())));
        Ok(Some(built))
    }
}
