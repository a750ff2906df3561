//! The watch over a run: its problems, since when and how bad they are, and advice.
//!
//! A [`Watch`] reads a run at whatever pace its owner can afford: [`Watch::follow`] after each step
//! of a run that somebody waits for, and its single readings now and then in a window. After each
//! reading it asks the rules of `finding.rs`, where each [`Kind`] has its rule, its words and its
//! advice: a new warning is written there alone.

mod piercing;
mod overturned;
mod finding;

pub use finding::{Finding, Kind};
pub use overturned::{Cells, Overturned};
pub use piercing::{Pierced, Piercing};

use crate::{Runner, on, steps_between, steps_between_counts};
use msd_core::methods::Solved;
use msd_core::stability::Estimator;
use msd_core::{Energy, Integrator, Scene, Witness};
use msd_scene::{Precision, Rounding};

/// The largest share of the work of a run that predictions may take.
const SHARE: f64 = 0.02;
/// The largest share of the work of a run that counts of crossings may take.
const COUNTS: f64 = 0.05;

/// Follows a run and knows its problems.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    read: Readings,
    found: Vec<Finding>,
    piercing: Piercing,
    cells: Cells,
    /// The springs of the bodies that the cells belong to.
    springs: usize,
    /// Number of steps of the run when the last one was noted.
    steps: u64,
    /// Whether work was done that no account holds, as by user input.
    is_handled: bool,
    estimator: Estimator,
    /// After how many steps the limit is predicted again, and crossings are counted again.
    every: [u64; 2],
}

/// Readings of a run, for the rules.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// The drift detector of the energy.
    pub witness: Witness,
    /// The energy at the last reading, and the steps of the run then.
    energy: Option<(Energy, u64)>,
    /// The most elastic energy that was read, joules.
    most_elastic: f64,
    /// The longest stable substep by the last prediction, and the substep then, seconds.
    limit: Option<[f64; 2]>,
    /// The shortest of all predictions of the longest stable substep, seconds.
    pub least: Option<f64>,
    /// The longest substep that resolves the stiffness of a scene for XPBD, seconds, if known.
    resolving: Option<f64>,
    /// Convergence of the solves of an implicit method.
    pub solved: Option<Solved>,
    /// Number of possible tunnellings of shells before the watch began.
    passes: u64,
    /// Pairs of triangles that crossed at the last count.
    pub crossings: Option<u64>,
    /// The first surface that a solid was seen to go through.
    pub pierced: Option<Pierced>,
    /// The body of which most corners of cells were flat or inside out at the last count.
    pub overturned: Option<Overturned>,
    /// Loss of single precision, where it shows.
    rounding: Option<Rounding>,
}

impl Watch {
    /// Begins to watch a run of a scene.
    pub fn new(runner: &Runner, scene: &Scene) -> Self {
        let rounding = Some(Rounding::of(scene, Precision::F32)).filter(Rounding::shows);
        let every = on!(runner, simulation => {
            [steps_between(simulation, SHARE), steps_between_counts(simulation, COUNTS)]
        });
        let passes = runner.passes();
        let mut watch = Watch {
            read: Readings { rounding, passes, ..Readings::default() },
            cells: Cells::new(runner),
            springs: runner.spring_count(),
            steps: runner.steps(),
            is_handled: on!(runner, simulation => simulation.is_handled()),
            every,
            ..Watch::default()
        };
        watch.read_energy(runner);
        watch.look(runner);
        watch
    }

    /// Forgets all that depends on state, material and settings, as these were changed other than
    /// by a step. Findings of past events are kept.
    pub fn change(&mut self, runner: &Runner) {
        let Readings { passes, rounding, .. } = self.read;
        self.read = Readings { passes, rounding, ..Readings::default() };
        self.found.retain(|finding| finding.kind.outlives_changes());
        if self.springs != runner.spring_count() {
            (self.cells, self.springs) = (Cells::new(runner), runner.spring_count());
        }
    }

    /// Notes a step of the run: the convergence of its solves, and the tunnelling in its contacts.
    pub fn step(&mut self, runner: &Runner) {
        self.note_step(runner);
        self.judge(runner);
    }

    fn note_step(&mut self, runner: &Runner) {
        // A step that is taken anew from an earlier state has another future.
        if runner.steps() <= self.steps {
            self.found.retain(|finding| finding.since < runner.time());
        }
        self.steps = runner.steps();
        if let Some(solved) = runner.solved() {
            self.read.solved.get_or_insert_default().note(solved);
        }
        self.is_handled |= on!(runner, simulation => simulation.is_handled());
    }

    /// Looks where solids and surfaces are, best after each step.
    pub fn look(&mut self, runner: &Runner) {
        self.piercing.look(runner);
        self.read.pierced = self.piercing.first();
        self.judge(runner);
    }

    /// Follows a step of a run that somebody waits for, or several, with all readings. Those that
    /// cost much take a bounded share of its work.
    pub fn follow(&mut self, runner: &Runner) {
        self.read_energy(runner);
        // Of a run on a graphics device several steps pass from one reading to the next.
        let before = self.steps.min(runner.steps().saturating_sub(1));
        let [predicts, counts] = self.every.map(|every| before / every < runner.steps() / every);
        if counts {
            self.count_crossings(runner);
        }
        if predicts {
            self.predict(runner);
        }
        if runner.integrator() == Integrator::Xpbd && self.read.resolving.is_none() {
            // XPBD has no stability limit.
            let verlet = Integrator::VelocityVerlet;
            let stable = on!(runner, simulation => simulation.stable_substep_of(verlet, 1));
            self.read.resolving = Some(stable);
        }
        self.note_step(runner);
        self.look(runner);
    }

    /// Counts the triangles that cross, and the corners of cells that are flat or inside out: at
    /// the end of a run, or now and then.
    pub fn count(&mut self, runner: &Runner) {
        self.count_crossings(runner);
        self.read.overturned = self.cells.overturned(runner);
        self.judge(runner);
    }

    /// Reads the energy, once after each step, and the energy that the method has added to it.
    pub fn read_energy(&mut self, runner: &Runner) -> Energy {
        // Gusts do work that is in no account.
        if runner.gust().is_some() {
            self.forget_energy();
        }
        let known = self.read.energy.filter(|&(_, steps)| steps == runner.steps());
        let energy = known.map_or_else(|| runner.show_to(&mut self.read.witness), |known| known.0);
        self.read.energy = Some((energy, runner.steps()));
        self.read.most_elastic = self.read.most_elastic.max(energy.elastic);
        energy
    }

    /// Forgets the energy of before, as something has done work that is in no account.
    pub fn forget_energy(&mut self) {
        (self.read.witness, self.read.energy) = (Witness::default(), None);
        self.read.most_elastic = 0.0;
    }

    /// Takes a prediction of the longest stable substep, seconds: 0 if none is, infinite if every
    /// one is.
    pub fn note_limit(&mut self, runner: &Runner, stable: f64) {
        self.read.limit = Some([stable, runner.settings().substep()]);
        self.read.least = Some(self.read.least.map_or(stable, |least| least.min(stable)));
        self.judge(runner);
    }

    /// The findings up to the current time of the run, in the order in which they were seen.
    pub fn findings(&self, runner: &Runner) -> Vec<Finding> {
        finding::known(&self.found, runner.time())
    }

    /// Number of findings that stay.
    pub fn found(&self) -> usize {
        self.found.iter().filter(|finding| finding.stays()).count()
    }

    /// The readings since the run was changed.
    pub fn read(&self) -> &Readings {
        &self.read
    }

    /// Returns whether work was done that no account holds, as by user input.
    pub fn is_handled(&self) -> bool {
        self.is_handled
    }

    /// Counts the triangles that cross.
    pub fn count_crossings(&mut self, runner: &Runner) {
        self.read.crossings = runner.touched().map(|touched| touched.crossings);
    }

    /// Predicts the limit, unless the step is already known to be over it.
    fn predict(&mut self, runner: &Runner) {
        let is_explicit = Integrator::EXPLICIT.contains(&runner.integrator());
        let is_over = self.read.limit.is_some_and(|[stable, substep]| stable < substep);
        if is_explicit && !is_over {
            let stable = runner.stable_substep_by(&mut self.estimator);
            self.note_limit(runner, stable);
        }
    }

    /// Asks the rules.
    fn judge(&mut self, runner: &Runner) {
        finding::merge(&mut self.found, finding::rules(&self.read, runner));
    }
}
