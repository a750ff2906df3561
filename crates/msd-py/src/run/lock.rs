//! A run that several threads of Python may use: who has it, and on which threads it steps.

use crate::errors::error;
use crate::run::force;
use msd_run::Runner;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// What [`forks`] returns. A child has neither the threads
/// of its parent nor the locks that they would have let go.
static FORKS: AtomicU32 = AtomicU32::new(0);

/// How often this process or one that it descends from was forked.
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
    /// [`FORKS`] when the run was last taken.
    taken: AtomicU32,
    threads: Threads,
}

/// Why a run cannot be had.
enum Refusal {
    /// It is asked for by a force that it waits for.
    Force,
    /// A thread had it that is not in this child.
    Fork,
}

impl Shared {
    pub fn new(runner: Runner, threads: Threads) -> Self {
        Shared { runner: Mutex::new(runner), taken: AtomicU32::new(0), threads }
    }

    /// How many threads it steps on.
    pub fn threads(&self) -> usize {
        self.threads.count
    }

    /// Does something with the run while other threads of Python go on; waits for whoever has it.
    /// An exception of a force that is a callable goes before what was done.
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

/// The threads that a run steps on: that of the caller, or a pool of its own.
pub struct Threads {
    count: usize,
    /// With [`FORKS`] when it was made: a child makes it anew.
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
        // The pool of a parent has no threads here that could be ended.
        std::mem::forget(pool.replace((forks, built.clone())));
        Ok(Some(built))
    }
}
