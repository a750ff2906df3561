//! The conduct of all maps and hardships.

use crate::extremes::crew::{self, Work};
use crate::extremes::hardships::{Hardship, hardships};
use crate::extremes::map::{self, Across, Grid, Map};
use crate::extremes::outcome::{Outcome, Verdict};
use msd_core::Integrator;
use msd_scene::Precision;
use serde::Serialize;
use std::sync::Arc;
use std::time::Duration;

/// Both precisions.
pub const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// The runs to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Cells of a map.
    pub grid: Grid,
    /// The part of its time that a hardship lasts, at most 1.
    pub part: f64,
    /// Threads.
    pub threads: usize,
    /// A run that takes longer hangs.
    pub deadline: Duration,
}

impl Plan {
    /// Everything: some minutes on two cores.
    pub fn full(threads: usize) -> Self {
        let grid = Grid { columns: 43, rows: 31 };
        Plan { grid, part: 1.0, threads, deadline: Duration::from_secs(300) }
    }

    /// A coarse look: seconds.
    pub fn quick(threads: usize) -> Self {
        let grid = Grid { columns: 8, rows: 11 };
        Plan { grid, part: 0.1, ..Plan::full(threads) }
    }
}

/// A row of the table of hardships.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the hardship.
    pub name: &'static str,
    /// Description of the hardship.
    pub about: &'static str,
    /// Whether errors are strains of the edges; else fractions of an amplitude.
    pub strain: bool,
    /// For each method in the order of [`Integrator::ALL`], in each precision.
    pub verdicts: Vec<[Verdict; 2]>,
}

/// Results of everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Extremes {
    /// For each method, each map, each precision.
    pub maps: Vec<Map>,
    /// The table.
    pub rows: Vec<Row>,
}

/// A run: a cell of a map or a hardship.
#[derive(Clone, Copy)]
enum Run {
    Cell { across: Across, column: usize, row: usize },
    Hardship(usize),
}

/// Runs everything; calls `hear` with the number of runs that are done, and of all runs.
pub fn conduct(plan: Plan, hear: &mut dyn FnMut(usize, usize)) -> Extremes {
    let hardships = Arc::new(hardships());
    let runs = Arc::new(runs(plan.grid, hardships.len()));
    let work = work(plan, &runs, &hardships);
    let all = runs.len();
    let verdicts =
        crew::run_all((work, all), plan.threads, plan.deadline, &mut |done| hear(done, all));
    let mut verdicts = verdicts.into_iter();
    let rows = hardships.iter().map(|hardship| Row {
        name: hardship.name,
        about: hardship.about,
        strain: hardship.tells_strain(),
        verdicts: Integrator::ALL.map(|_| take_two(&mut verdicts)).into(),
    });
    let rows = rows.collect();
    let mut maps = Vec::new();
    for integrator in Integrator::ALL {
        for across in Across::ALL {
            for precision in PRECISIONS {
                let cells = verdicts.by_ref().take(plan.grid.cells()).collect();
                maps.push(make_map((across, integrator, precision), plan.grid, cells));
            }
        }
    }
    Extremes { maps, rows }
}

type Numbered = (Run, Integrator, Precision);

/// Every run in order: the hardships first, which take longest.
fn runs(grid: Grid, hardships: usize) -> Vec<Numbered> {
    let mut runs = Vec::new();
    for hardship in 0..hardships {
        for integrator in Integrator::ALL {
            runs.extend(
                PRECISIONS.map(|precision| (Run::Hardship(hardship), integrator, precision)),
            );
        }
    }
    for integrator in Integrator::ALL {
        for across in Across::ALL {
            for precision in PRECISIONS {
                let cell = |index| Run::Cell {
                    across,
                    column: index % grid.columns,
                    row: index / grid.columns,
                };
                runs.extend((0..grid.cells()).map(|index| (cell(index), integrator, precision)));
            }
        }
    }
    runs
}

fn work(plan: Plan, runs: &Arc<Vec<Numbered>>, hardships: &Arc<Vec<Hardship>>) -> Work {
    let (runs, hardships) = (Arc::clone(runs), Arc::clone(hardships));
    let steps = plan.grid.steps();
    let values = Across::ALL.map(|across| across.values(plan.grid.columns));
    Arc::new(move |number| {
        let (run, integrator, precision) = runs[number];
        match run {
            Run::Hardship(row) => hardships[row].run(integrator, precision, plan.part),
            Run::Cell { across, column, row } => {
                let at = (values[across as usize][column], steps[row]);
                map::cell((across, integrator, precision), at)
            }
        }
    })
}

fn take_two(verdicts: &mut impl Iterator<Item = Verdict>) -> [Verdict; 2] {
    let missing = || Verdict::ended(Outcome::Panic, "no verdict".into());
    [(); 2].map(|()| verdicts.next().unwrap_or_else(missing))
}

fn make_map(
    (across, integrator, precision): (Across, Integrator, Precision),
    grid: Grid,
    cells: Vec<Verdict>,
) -> Map {
    let values = across.values(grid.columns);
    let limits = values.iter().map(|&value| map::limit(across, integrator, value)).collect();
    Map { across, integrator, precision, values, steps: grid.steps(), limits, cells }
}

impl Extremes {
    /// The maps of a method.
    pub fn maps_of(&self, integrator: Integrator) -> impl Iterator<Item = &Map> {
        self.maps.iter().filter(move |map| map.integrator == integrator)
    }

    /// Every run with an outcome that must never be, in words.
    pub fn failures(&self) -> Vec<String> {
        let mut found = Vec::new();
        for row in &self.rows {
            for (verdicts, integrator) in row.verdicts.iter().zip(Integrator::ALL) {
                for (verdict, precision) in verdicts.iter().zip(PRECISIONS) {
                    let at = || format!("{} under {integrator} in {precision}", row.name);
                    found.extend(failure(verdict, at));
                }
            }
        }
        for map in &self.maps {
            for (index, verdict) in map.cells.iter().enumerate() {
                let at = || {
                    let Map { across, integrator, precision, values, steps, .. } = map;
                    let (value, step) = (values[index % values.len()], steps[index / values.len()]);
                    let across = across.name();
                    format!("{across} {value:.1e}, step {step:.1e} s, {integrator} in {precision}")
                };
                found.extend(failure(verdict, at));
            }
        }
        found
    }

    /// Number of runs.
    pub fn len(&self) -> usize {
        let cells: usize = self.maps.iter().map(|map| map.cells.len()).sum();
        cells + self.rows.iter().map(|row| 2 * row.verdicts.len()).sum::<usize>()
    }

    /// Returns whether nothing was run.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

fn failure(verdict: &Verdict, at: impl Fn() -> String) -> Option<String> {
    let told = || {
        let said = verdict.said.as_deref().map_or(String::new(), |said| format!(" ({said})"));
        format!("{}: {}{said}", at(), verdict.outcome.name())
    };
    verdict.outcome.is_failure().then(told)
}
