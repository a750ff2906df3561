//! The run of a sweep: all cells checked first, then one after another on each thread.

use crate::monitor::{Halt, Monitor, Progress};
use crate::sweep::measure::{References, measure};
use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::row::row;
use crate::sweep::store::Store;
use msd_core::Integrator;
use msd_scene::{FileError, Loaded};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Result of a sweep, or of the requested part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Cells that were run now.
    pub run: usize,
    /// Cells that were done before.
    pub skipped: usize,
    /// Cells run now that diverged.
    pub diverged: usize,
    /// Cells that were not run, as the sweep was cancelled.
    pub left: usize,
}

/// Runs those of some cells that are not done, on some threads. Every one is checked before the
/// first runs. A sweep that the monitor ends keeps the cells that are done.
///
/// A report after each cell that was checked has no time that is left; one after each that was run
/// has.
///
/// # Errors
/// The first cell, by number, with something wrong; files that cannot be written.
pub fn run(
    sweep: &Sweep,
    store: &Store,
    (cells, jobs): (Range<usize>, usize),
    monitor: &mut (dyn Monitor + Send),
) -> Result<Summary, FileError> {
    let mut todo = Vec::new();
    let count = cells.len();
    for number in cells {
        let cell = sweep.cell(number)?;
        if store.row(sweep, &cell).is_none() {
            todo.push(cell);
        }
    }
    let skipped = count - todo.len();
    let (all, monitor) = (todo.len(), Mutex::new(monitor));
    let report = |progress| lock(&monitor).report(progress);
    let checked = AtomicUsize::new(0);
    let checking = |done| Progress { done, parts: Some([done, all]), ..Progress::of("checking") };
    report(checking(0));
    let work = in_parallel(&todo, jobs, &|cell| {
        if lock(&monitor).proceed().is_err() {
            return Ok(None);
        }
        let loaded = sweep.load(cell)?;
        report(checking(checked.fetch_add(1, Ordering::Relaxed) + 1));
        Ok(Some(expected_work(sweep, &loaded)))
    })?;
    if work.len() < todo.len() {
        return Ok(Summary { skipped, left: todo.len(), ..Summary::default() });
    }
    store.prepare()?;
    let mut todo: Vec<(Cell, f64)> = todo.into_iter().zip(work).collect();
    // Cells that share a reference follow each other; scenes in the order of their first cells.
    let mut first = BTreeMap::new();
    for (cell, _) in &todo {
        first.entry(cell.scene_hash.clone()).or_insert(cell.number);
    }
    todo.sort_by_key(|(cell, _)| first.get(&cell.scene_hash).copied());
    let references = References::new(jobs.max(1));
    let clock = Remaining::start(todo.iter().map(|cell| cell.1).sum());
    let ran = Mutex::new(0);
    let diverged = in_parallel(&todo, jobs, &|(cell, work)| {
        let slot = sweep.has_error().then(|| references.slot(&cell.scene_hash));
        let slot = (sweep.duration(), slot.as_ref());
        let measured = match measure(&sweep.load(cell)?, slot, &mut Shared(&monitor)) {
            Ok(measured) => measured,
            Err(Halt::Refused(error)) => return Err(sweep.refuse(error, cell)),
            Err(Halt::Cancelled | Halt::Deadline) => return Ok(None),
        };
        let row = row(sweep, cell, &measured);
        let diverged = measured.diverged.is_some();
        let outcome = if diverged { "diverged" } else { "finished" };
        let error = store.value(&row, "rms_error").as_number();
        let error = error.map_or(String::new(), |error| format!(", rms error {error:.3e} m"));
        store.save(cell, row)?;
        let (number, cpu, words) = (cell.number, measured.cpu, sweep.words(cell));
        let now = format!("cell {number} {outcome}, {cpu:.3} s cpu{error}: {words}");
        let mut done = lock(&ran);
        *done += 1;
        let (parts, left) = (Some([*done, all]), Some(clock.done(*work)));
        report(Progress { now, done: *done, parts, left });
        Ok(Some(diverged))
    })?;
    let (run, left) = (diverged.len(), todo.len() - diverged.len());
    let diverged = diverged.into_iter().filter(|&diverged| diverged).count();
    Ok(Summary { run, skipped, diverged, left })
}

/// The monitor of a sweep, shared by its threads, which report no references.
struct Shared<'a, 'm>(&'a Mutex<&'m mut (dyn Monitor + Send)>);

impl Monitor for Shared<'_, '_> {
    fn report(&mut self, _: Progress) {}

    fn proceed(&mut self) -> Result<(), Halt> {
        // Where another thread asks now, the next step is soon enough.
        self.0.try_lock().map_or(Ok(()), |mut monitor| monitor.proceed())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Work of a cell in spring updates, roughly: accurate enough to separate minutes from hours.
fn expected_work(sweep: &Sweep, loaded: &Loaded) -> f64 {
    let settings = loaded.settings;
    let substeps = f64::from(settings.substeps);
    let (substeps, evaluations) = match settings.integrator {
        // The number of its substeps is not known in advance.
        Integrator::DormandPrince => (10.0, 7.0),
        Integrator::BackwardEuler | Integrator::ImplicitMidpoint => {
            (substeps, 30.0 * f64::from(settings.newton))
        }
        Integrator::Xpbd => (substeps, 2.0),
        Integrator::Rk4 => (substeps, 4.0),
        _ => (substeps, 1.0),
    };
    let steps = sweep.duration() / settings.step;
    let rows = loaded.scene.springs.len() + loaded.scene.particles.len();
    steps * substeps * evaluations * rows as f64
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
fn in_parallel<T: Sync, R: Send>(
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
