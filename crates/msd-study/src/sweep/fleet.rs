//! Cells whose steps a device takes, many at once.

use crate::measure::device::{Device, LoadError, Pace};
use crate::monitor::Monitor;
use crate::sweep::measure::CellRun;
use crate::sweep::plan::Cell;
use crate::sweep::under_way::{UnderWay, in_parallel};
use msd_run::Runner;
use msd_scene::FileError;
use std::time::Instant;

/// Springs and particles that step together, at most: a large card is busy, and the buffers of each
/// kind stay below 128 MiB.
const MOST: usize = 4_000_000;
/// The same where each cell may need a reference of its own, with sixty states in f64.
const MOST_COMPARED: usize = 400_000;
/// The longest that Ctrl-C waits for a device, seconds, and the most steps at once.
const PATIENCE: f64 = 0.25;
const MOST_STEPS: u64 = 64;

/// A cell with its expected work.
type Todo = (Cell, f64);
/// Whether each cell that was run diverged, the cells that the processor is to run, and why the
/// device has failed, if it has.
type Flown = (Vec<bool>, Vec<Todo>, Option<String>);

/// Runs on a device the cells that it can step.
///
/// # Errors
/// The first cell that the core refuses; files that cannot be written.
pub(super) fn run_fleets(
    under_way: &UnderWay<'_, '_>,
    device: &mut dyn Device,
    todo: Vec<Todo>,
) -> Result<Flown, FileError> {
    let (mut fleets, mut rest) = fleets(under_way, device, todo)?;
    fleets.reverse();
    let mut diverged = Vec::new();
    while let Some(mut fleet) = fleets.pop() {
        match fly(under_way, device, &fleet)? {
            Flight::Done(outcomes) => diverged.extend(outcomes),
            Flight::Cancelled => break,
            Flight::TooLarge if fleet.len() == 1 => rest.extend(fleet),
            Flight::TooLarge => {
                let half = fleet.split_off(fleet.len() / 2);
                fleets.extend([half, fleet]);
            }
            Flight::Failed(why) => {
                rest.extend(fleet);
                rest.extend(fleets.into_iter().rev().flatten());
                return Ok((diverged, rest, Some(why)));
            }
        }
    }
    Ok((diverged, rest, None))
}

/// The end of a flight.
enum Flight {
    /// Whether each cell diverged.
    Done(Vec<bool>),
    Cancelled,
    /// The device cannot hold so many runs.
    TooLarge,
    /// Why the device takes no more steps.
    Failed(String),
}

/// Groups the cells that a device takes by what runs on a device must have in common; returns also
/// those that it does not take.
fn fleets(
    under_way: &UnderWay<'_, '_>,
    device: &dyn Device,
    todo: Vec<Todo>,
) -> Result<(Vec<Vec<Todo>>, Vec<Todo>), FileError> {
    let most = if under_way.sweep.has_error() { MOST_COMPARED } else { MOST };
    let mut open: Vec<(Pace, usize, Vec<Todo>)> = Vec::new();
    let (mut full, mut rest) = (Vec::new(), Vec::new());
    for (cell, work) in todo {
        if under_way.monitor().proceed().is_err() {
            return Ok((Vec::new(), Vec::new()));
        }
        let runner = under_way.sweep.open_cell(&cell)?.1;
        if !device.takes(&runner) {
            rest.push((cell, work));
            continue;
        }
        let (pace, size) = (Pace::of(&runner), runner.spring_count() + runner.particle_count());
        let row = open.iter().position(|fleet| fleet.0 == pace).unwrap_or_else(|| {
            open.push((pace, 0, Vec::new()));
            open.len() - 1
        });
        let (_, sum, fleet) = &mut open[row];
        if most < *sum + size && !fleet.is_empty() {
            full.push(std::mem::take(fleet));
            *sum = 0;
        }
        fleet.push((cell, work));
        *sum += size;
    }
    full.extend(open.into_iter().map(|fleet| fleet.2));
    Ok((full, rest))
}

/// Runs cells together on a device, and writes their rows. If the device fails, it writes none.
fn fly(
    under_way: &UnderWay<'_, '_>,
    device: &mut dyn Device,
    fleet: &[Todo],
) -> Result<Flight, FileError> {
    let begun = in_parallel(fleet, under_way.jobs, &|(cell, _)| under_way.begin(cell))?;
    if begun.len() < fleet.len() {
        return Ok(Flight::Cancelled);
    }
    let (mut cells, mut runners): (Vec<CellRun>, Vec<Runner>) = begun.into_iter().unzip();
    match device.load(&runners) {
        Ok(()) => {}
        Err(LoadError::TooLarge(_)) => return Ok(Flight::TooLarge),
        Err(LoadError::Failed(why)) => return Ok(Flight::Failed(why)),
    }
    cells.iter_mut().for_each(CellRun::hand_over);
    let (mut taken, mut at_once) = (0, 1);
    while let Some(stop) = cells.iter().filter_map(CellRun::next_stop).min() {
        while taken < stop && cells.iter().any(|cell| cell.next_stop().is_some()) {
            if under_way.monitor().proceed().is_err() {
                return Ok(Flight::Cancelled);
            }
            let steps = at_once.min(stop - taken);
            let start = Instant::now();
            let ended = match device.advance(&mut runners, steps) {
                Ok(ended) => ended,
                Err(why) => return Ok(Flight::Failed(why)),
            };
            let each = start.elapsed().as_secs_f64() / steps as f64;
            at_once = ((PATIENCE / each.max(1e-9)) as u64).clamp(1, MOST_STEPS);
            taken += steps;
            for ((cell, ended), (of, _)) in cells.iter_mut().zip(ended).zip(fleet) {
                let Some(error) = ended.filter(|_| cell.next_stop().is_some()) else { continue };
                cell.end(error).map_err(|error| under_way.sweep.refuse(error, of))?;
            }
            let (count, name) = (fleet.len(), device.name());
            under_way.report(format!("{count} cells on {name}, step {taken}"));
        }
        for (cell, runner) in cells.iter_mut().zip(&runners) {
            if cell.next_stop() == Some(stop) {
                cell.arrive(runner);
            }
        }
    }
    if let Err(why) = device.finish() {
        return Ok(Flight::Failed(why));
    }
    let took = format!(" on {}", device.name());
    // All are done, before the first is written.
    let mut work = fleet.iter().map(|todo| todo.1).sum();
    let rows = cells.into_iter().zip(&runners).zip(fleet);
    let save = |((run, runner), (cell, _)): ((CellRun, &Runner), &Todo)| {
        under_way.save((cell, std::mem::take(&mut work)), &run.finish(runner), &took)
    };
    rows.map(save).collect::<Result<_, _>>().map(Flight::Done)
}
