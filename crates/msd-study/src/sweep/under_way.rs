//! A sweep whose cells are being run: its threads, references, rows and reports.

use crate::monitor::{Halt, Monitor, Progress};
use crate::sweep::measure::{CellRun, Measured, References, Slot, measure};
use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::row::row;
use crate::sweep::store::Store;
use msd_run::Runner;
use msd_scene::FileError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// A sweep whose cells are being run.
pub(super) struct UnderWay<'a, 'm> {
    pub(super) sweep: &'a Sweep,
    store: &'a Store,
    pub(super) jobs: usize,
    references: References,
    clock: Remaining,
    monitor: &'a Mutex<&'m mut (dyn Monitor + Send)>,
    /// Cells to run, and those that were run.
    all: usize,
    ran: Mutex<usize>,
}

impl<'a, 'm> UnderWay<'a, 'm> {
    /// Begins to run some cells, each with its expected work.
    pub(super) fn new(
        (sweep, store): (&'a Sweep, &'a Store),
        (todo, jobs): (&[(Cell, f64)], usize),
        monitor: &'a Mutex<&'m mut (dyn Monitor + Send)>,
    ) -> Self {
        UnderWay {
            sweep,
            store,
            jobs,
            references: References::new(jobs.max(1)),
            clock: Remaining::start(todo.iter().map(|cell| cell.1).sum()),
            monitor,
            all: todo.len(),
            ran: Mutex::new(0),
        }
    }

    /// Runs a cell on the processor; returns whether it diverged, `None` if it was cancelled.
    pub(super) fn run(&self, (cell, work): &(Cell, f64)) -> Result<Option<bool>, FileError> {
        let slot = (self.sweep.duration(), self.slot(cell));
        match measure(&self.sweep.load(cell)?, slot, &mut self.monitor()) {
            Ok(measured) => {
                let took = format!(", {:.3} s cpu", measured.cpu);
                self.save((cell, *work), &measured, &took).map(Some)
            }
            Err(Halt::Refused(error)) => Err(self.sweep.refuse(error, cell)),
            Err(Halt::Cancelled | Halt::Deadline) => Ok(None),
        }
    }

    /// Begins to measure a cell; returns `None` if it was cancelled.
    pub(super) fn begin(&self, cell: &Cell) -> Result<Option<(CellRun, Runner)>, FileError> {
        let slot = (self.sweep.duration(), self.slot(cell));
        match CellRun::begin(&self.sweep.load(cell)?, slot, &mut self.monitor()) {
            Ok(begun) => Ok(Some(begun)),
            Err(Halt::Refused(error)) => Err(self.sweep.refuse(error, cell)),
            Err(Halt::Cancelled | Halt::Deadline) => Ok(None),
        }
    }

    /// Writes the row of a cell that was run, and reports it; returns whether it diverged.
    pub(super) fn save(
        &self,
        (cell, work): (&Cell, f64),
        measured: &Measured,
        took: &str,
    ) -> Result<bool, FileError> {
        let diverged = measured.diverged.is_some();
        let outcome = if diverged { "diverged" } else { "finished" };
        let error = measured.comparison.map(|comparison| comparison.errors.rms);
        let error = error.map_or(String::new(), |error| format!(", rms error {error:.3e} m"));
        self.store.save(cell, row(self.sweep, cell, measured))?;
        let (number, words) = (cell.number, self.sweep.words(cell));
        let now = format!("cell {number} {outcome}{took}{error}: {words}");
        let mut done = lock(&self.ran);
        *done += 1;
        let (parts, left) = (Some([*done, self.all]), Some(self.clock.done(work)));
        lock(self.monitor).report(Progress { now, done: *done, parts, left });
        Ok(diverged)
    }

    /// Reports what is being done, but no cell.
    pub(super) fn report(&self, now: String) {
        let done = *lock(&self.ran);
        let parts = Some([done, self.all]);
        lock(self.monitor).report(Progress { now, done, parts, left: None });
    }

    fn slot(&self, cell: &Cell) -> Option<Slot> {
        self.sweep.has_error().then(|| self.references.slot(&cell.scene_hash))
    }

    /// Its monitor, for a thread.
    pub(super) fn monitor(&self) -> Shared<'a, 'm> {
        Shared(self.monitor)
    }
}

/// The monitor of a sweep, shared by its threads, which report no references.
pub(super) struct Shared<'a, 'm>(&'a Mutex<&'m mut (dyn Monitor + Send)>);

impl Monitor for Shared<'_, '_> {
    fn report(&mut self, _: Progress) {}

    fn proceed(&mut self) -> Result<(), Halt> {
        // Where another thread asks now, the next step is soon enough.
        self.0.try_lock().map_or(Ok(()), |mut monitor| monitor.proceed())
    }
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Remaining time, by the work that was done and the work that is left.
struct Remaining {
    start: Instant,
    total: f64,
    done: Mutex<f64>,
}

impl Remaining {
    fn start(total: f64) -> Self {
        Remaining { start: Instant::now(), total, done: Mutex::new(0.0) }
    }

    /// Adds finished work; returns the remaining time, seconds.
    fn done(&self, work: f64) -> f64 {
        let mut done = lock(&self.done);
        *done += work;
        self.start.elapsed().as_secs_f64() * (self.total - *done).max(0.0) / *done
    }
}

/// Does something with each item, on some threads; results in the order of the items, without
/// those that were given up. After an error no item is begun; of several errors that of the first
/// item is returned.
pub(super) fn in_parallel<T: Sync, R: Send>(
    items: &[T],
    jobs: usize,
    act: &(dyn Fn(&T) -> Result<Option<R>, FileError> + Sync),
) -> Result<Vec<R>, FileError> {
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(usize::MAX));
    let results = Mutex::new(Vec::with_capacity(items.len()));
    let work = || {
        loop {
            let row = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(row) else { break };
            if failed.load(Ordering::Relaxed) < row {
                break;
            }
            let result = act(item);
            if result.is_err() {
                failed.fetch_min(row, Ordering::Relaxed);
            }
            lock(&results).push((row, result));
        }
    };
    match jobs.clamp(1, items.len().max(1)) {
        // On this thread, which spares a start for every task of a cluster.
        1 => work(),
        jobs => std::thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work)))),
    }
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|result| result.0);
    results.into_iter().filter_map(|result| result.1.transpose()).collect()
}
