//! Maps of a method: its step against a property that makes a spring fast or slow.

use crate::extremes::judge::{Measure, Task, judge};
use crate::extremes::oscillator::Oscillator;
use crate::extremes::outcome::{Outcome, Verdict};
use msd_core::{Integrator, Settings, Simulation};
use msd_scene::Precision;
use serde::Serialize;

/// The quantity across a map; the step always goes up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Across {
    /// Stiffness, newtons per metre: masses of 1 kg, a damping ratio of 0.05.
    Stiffness,
    /// Damping ratio: masses of 1 kg on 1000 N/m.
    DampingRatio,
    /// Mass of both ends, kilograms: 1000 N/m, no damping.
    Mass,
    /// The one mass over the other, which is 1 kg: 1000 N/m, a damping ratio of 0.05.
    MassRatio,
}

/// Steps, seconds, from the shortest.
const STEPS: (f64, f64) = (1e-9, 10.0);
/// Steps of a run.
const LENGTH: u64 = 320;
/// The most evaluations of an adaptive method in a cell: it divides the long steps of a stiff
/// spring.
const EVALUATIONS: u64 = 100_000;

impl Across {
    /// Every map.
    pub const ALL: [Across; 4] =
        [Across::Stiffness, Across::DampingRatio, Across::Mass, Across::MassRatio];

    /// Title of the axis.
    pub fn title(self) -> &'static str {
        match self {
            Across::Stiffness => "Stiffness, N/m",
            Across::DampingRatio => "Damping ratio",
            Across::Mass => "Mass, kg",
            Across::MassRatio => "Mass ratio",
        }
    }

    /// A name for files.
    pub fn name(self) -> &'static str {
        match self {
            Across::Stiffness => "stiffness",
            Across::DampingRatio => "damping-ratio",
            Across::Mass => "mass",
            Across::MassRatio => "mass-ratio",
        }
    }

    /// The values across, so many, evenly spaced in powers; a damping ratio starts with 0.
    pub fn values(self, count: usize) -> Vec<f64> {
        match self {
            Across::Stiffness => powers((1e-9, 1e12), count),
            Across::DampingRatio => {
                std::iter::once(0.0).chain(powers((1e-3, 1e3), count - 1)).collect()
            }
            Across::Mass => powers((1e-9, 1e9), count),
            Across::MassRatio => powers((1.0, 1e12), count),
        }
    }

    /// The oscillator at a value.
    pub fn oscillator(self, value: f64) -> Oscillator {
        let usual = Oscillator { masses: [1.0; 2], stiffness: 1000.0, damping_ratio: 0.05 };
        match self {
            Across::Stiffness => Oscillator { stiffness: value, ..usual },
            Across::DampingRatio => Oscillator { damping_ratio: value, ..usual },
            Across::Mass => Oscillator { masses: [value; 2], damping_ratio: 0.0, ..usual },
            Across::MassRatio => Oscillator { masses: [1.0, value.recip()], ..usual },
        }
    }
}

/// So many powers of ten between two, both included, evenly spaced.
fn powers((from, to): (f64, f64), count: usize) -> Vec<f64> {
    let (from, to) = (libm::log10(from), libm::log10(to));
    let stride = (to - from) / (count.max(2) - 1) as f64;
    (0..count).map(|row| libm::pow(10.0, from + row as f64 * stride)).collect()
}

/// Numbers of cells of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Cells across.
    pub columns: usize,
    /// Cells up, one per step.
    pub rows: usize,
}

impl Grid {
    /// The steps, seconds.
    pub fn steps(self) -> Vec<f64> {
        powers(STEPS, self.rows)
    }

    /// Cells of a map.
    pub fn cells(self) -> usize {
        self.columns * self.rows
    }
}

/// A map: the outcome of every cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Map {
    /// The quantity across.
    pub across: Across,
    /// The method.
    pub integrator: Integrator,
    /// The precision.
    pub precision: Precision,
    /// The values across.
    pub values: Vec<f64>,
    /// The steps, seconds.
    pub steps: Vec<f64>,
    /// The largest stable step predicted for each value, seconds: 0 if none is, infinite if every
    /// one is.
    pub limits: Vec<f64>,
    /// The cells, step by step, each from the first value to the last.
    pub cells: Vec<Verdict>,
}

impl Map {
    /// The cell of a value and a step.
    pub fn cell(&self, column: usize, row: usize) -> &Verdict {
        &self.cells[row * self.values.len() + column]
    }

    /// The number of the longest step up to which a column keeps its energy; none if the shortest
    /// does not.
    pub fn observed(&self, column: usize) -> Option<usize> {
        let kept = |row: &usize| self.cell(column, *row).outcome.is_kept();
        (0..self.steps.len()).take_while(kept).last()
    }

    /// Cells of an outcome.
    pub fn count(&self, outcome: Outcome) -> usize {
        self.cells.iter().filter(|cell| cell.outcome == outcome).count()
    }
}

/// Runs a cell: the step and the value by their numbers.
pub fn cell(
    (across, integrator, precision): (Across, Integrator, Precision),
    (value, step): (f64, f64),
) -> Verdict {
    let known = across.oscillator(value);
    let task = Task {
        scene: &known.scene(),
        settings: settings(integrator, step),
        precision,
        steps: LENGTH,
        evaluations: EVALUATIONS,
    };
    judge(&task, &Measure::Largest(&|time, positions| known.error(time, positions)))
}

fn settings(integrator: Integrator, step: f64) -> Settings {
    Settings { integrator, step, substeps: 1, ..Settings::default() }
}

/// The largest stable step predicted at a value, seconds.
pub fn limit(across: Across, integrator: Integrator, value: f64) -> f64 {
    let mut scene = across.oscillator(value).scene();
    // Along the spring: sideways a stretched one swings without a damper, which explicit Euler does
    // not bear at any step, but nothing pushes it there.
    let [a, b] = [0, 1].map(|end| scene.particles[end].position);
    scene.springs[0].rest_length = a.distance(b);
    let simulation = Simulation::<f64>::new(&scene, settings(integrator, 1e-3));
    simulation.map_or(0.0, |simulation| simulation.stable_substep())
}
