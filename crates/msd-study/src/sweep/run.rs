//! The run of a sweep: all cells checked first, then one after another on each thread.

use crate::measure::device::Device;
use crate::monitor::{Monitor, Progress};
use crate::sweep::fleet::run_fleets;
use crate::sweep::plan::{Cell, Sweep};
use crate::sweep::store::Store;
use crate::sweep::under_way::{UnderWay, in_parallel, lock};
use msd_core::Integrator;
use msd_scene::{FileError, Loaded};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Result of a sweep, or of the requested part of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Cells that were run now.
    pub run: usize,
    /// Cells that were done before.
    pub skipped: usize,
    /// Cells run now that diverged.
    pub diverged: usize,
    /// Cells that were not run, as the sweep was cancelled.
    pub left: usize,
    /// Cells that were run now on a device.
    pub on_device: usize,
    /// Reason for which the device failed; none if it did not.
    pub fault: Option<String>,
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
    run_on(sweep, store, (cells, jobs, None), monitor)
}

/// Runs cells as [`run`] does, with a device that steps many at once. The processor runs the cells
/// that the device cannot step, and all remaining ones if the device fails.
///
/// Rows of the device leave [`Sweep::columns_of_processor`] empty; all else has the same bits.
///
/// # Errors
/// See [`run`].
pub fn run_on(
    sweep: &Sweep,
    store: &Store,
    (cells, jobs, device): (Range<usize>, usize, Option<&mut dyn Device>),
    monitor: &mut (dyn Monitor + Send),
) -> Result<Summary, FileError> {
    let count = cells.len();
    let todo = unfinished(sweep, store, cells)?;
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
    let under_way = UnderWay::new((sweep, store), (&todo, jobs), &monitor);
    let (mut diverged, mut fault) = (Vec::new(), None);
    if let Some(device) = device {
        (diverged, todo, fault) = run_fleets(&under_way, device, todo)?;
    }
    let on_device = diverged.len();
    diverged.extend(in_parallel(&todo, jobs, &|cell| under_way.run(cell))?);
    let (run, left) = (diverged.len(), all - diverged.len());
    let diverged = diverged.into_iter().filter(|&diverged| diverged).count();
    Ok(Summary { run, skipped, diverged, left, on_device, fault })
}

/// Those of some cells that are not done.
///
/// # Errors
/// A key of the grid that has no place in the scene.
pub fn unfinished(
    sweep: &Sweep,
    store: &Store,
    cells: Range<usize>,
) -> Result<Vec<Cell>, FileError> {
    let mut todo = Vec::new();
    for number in cells {
        let cell = sweep.cell(number)?;
        if store.row(sweep, &cell).is_none() {
            todo.push(cell);
        }
    }
    Ok(todo)
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
