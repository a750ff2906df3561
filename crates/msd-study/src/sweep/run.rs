//! The run of a sweep: all cells checked first, then one after another on each thread.

use crate::measure::leave::Halt;
use crate::sweep::measure::{References, measure};
use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::row::row;
use crate::sweep::store::Store;
use msd_core::Integrator;
use msd_scene::{FileError, Loaded};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// What happens in a sweep.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// What is to be done is known: cells to run, and cells done before.
    Planned {
        /// Cells to run.
        todo: usize,
        /// Cells that were done before.
        skipped: usize,
    },
    /// A cell was found to be right.
    Checked,
    /// A cell was run and its file is in place.
    Finished {
        /// Its number.
        number: usize,
        /// Its keys and values.
        words: String,
        /// Whether it diverged.
        diverged: bool,
        /// Time of the processor that its steps took, seconds.
        cpu: f64,
        /// Root mean square error, metres, where it was compared.
        rms_error: Option<f64>,
        /// Time until all cells are done, seconds, if they cost what they are expected to.
        left: f64,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Event::Planned { todo, skipped } => {
                write!(f, "{todo} cells to run, {skipped} done before")
            }
            Event::Checked => f.write_str("a cell is right"),
            Event::Finished { number, words, diverged, cpu, rms_error, .. } => {
                let outcome = if *diverged { "diverged" } else { "finished" };
                write!(f, "cell {number} {outcome}, {cpu:.3} s cpu")?;
                if let Some(error) = rms_error {
                    write!(f, ", rms error {error:.3e} m")?;
                }
                write!(f, ": {words}")
            }
        }
    }
}

/// What came of a sweep, or of the part of it that was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Cells that were run now.
    pub run: usize,
    /// Cells that were done before.
    pub skipped: usize,
    /// Cells run now that diverged.
    pub diverged: usize,
    /// Cells that were not run, as leave to go on was not given.
    pub left: usize,
}

/// Runs those of some cells that are not done, on some threads. Every one is checked before the
/// first runs. `goes_on` is asked in every step: `false` ends the sweep, and what is not done then
/// is left.
///
/// # Errors
/// The first cell, by number, with something wrong; files that cannot be written.
pub fn run(
    sweep: &Sweep,
    store: &Store,
    (cells, jobs): (Range<usize>, usize),
    (tell, goes_on): (&(dyn Fn(Event) + Sync), &(dyn Fn() -> bool + Sync)),
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
    tell(Event::Planned { todo: todo.len(), skipped });
    let work = in_parallel(&todo, jobs, &|cell| {
        if !goes_on() {
            return Ok(None);
        }
        let loaded = sweep.load(cell)?;
        tell(Event::Checked);
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
    let diverged = in_parallel(&todo, jobs, &|(cell, work)| {
        let slot = sweep.has_error().then(|| references.slot(&cell.scene_hash));
        let measured = match measure(&sweep.load(cell)?, (sweep.duration(), slot.as_ref()), goes_on)
        {
            Ok(measured) => measured,
            Err(Halt::Refused(error)) => return Err(sweep.refuse(error, cell)),
            Err(Halt::Stopped | Halt::Late) => return Ok(None),
        };
        let row = row(sweep, cell, &measured);
        let diverged = measured.diverged.is_some();
        let rms_error = store.value(&row, "rms_error").as_number();
        let cpu = measured.cpu;
        store.save(cell, row)?;
        let (number, words, left) = (cell.number, sweep.words(cell), clock.done(*work));
        tell(Event::Finished { number, words, diverged, cpu, rms_error, left });
        Ok(Some(diverged))
    })?;
    let diverged_count = diverged.iter().filter(|&&diverged| diverged).count();
    let run = diverged.len();
    Ok(Summary { run, skipped, diverged: diverged_count, left: todo.len() - run })
}

/// Work of a cell in spring updates, roughly: good enough to tell minutes from hours.
fn expected_work(sweep: &Sweep, loaded: &Loaded) -> f64 {
    let settings = loaded.settings;
    let substeps = f64::from(settings.substeps);
    let (substeps, evaluations) = match settings.integrator {
        // How many substeps it will take is not known.
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

/// How long it may still take, by what was done and what is left.
struct Remaining {
    start: Instant,
    total: f64,
    done: Mutex<f64>,
}

impl Remaining {
    fn start(total: f64) -> Self {
        Remaining { start: Instant::now(), total, done: Mutex::new(0.0) }
    }

    /// Adds what was done; returns the time that is left, seconds.
    fn done(&self, work: f64) -> f64 {
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
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
            results.lock().unwrap_or_else(PoisonError::into_inner).push((row, result));
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
