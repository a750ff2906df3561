//! Divergence of a run: cause, fastest springs, recovery options.

use super::material::is_of_looks;
use super::run::{Reading, Run, act, open};
use super::solver::MOST_SUBSTEPS;
use super::{Session, Wind};
use msd_core::{Divergence, Error, Interaction, Vector};
use msd_run::live::set_all;
use msd_run::rescue::{LASTING, Offer, Origin, Remedy, Rescue};
use msd_run::{History, Runner, on};
use msd_scene::schema::SolverRow;
use msd_scene::{Edits, Loaded};
use msd_study::quantity::quantity;

/// Limits of the time per frame for the search for recovery options, seconds; between them it takes
/// half of the last frame. In a browser the page should respond within 50 ms.
const SEARCH: [f64; 2] = [0.02, if cfg!(target_arch = "wasm32") { 0.02 } else { 0.25 }];
/// Largest number of highlighted springs.
const MOST_MARKED: usize = 40;
/// Least energy of a highlighted spring, relative to the strongest one.
const MARKED: f64 = 0.2;

/// Reason why a run stopped by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunFailure {
    /// The reason, in whole sentences.
    pub text: String,
}

impl RunFailure {
    /// Describes an error; `gone_back` is whether the run shows an earlier state, at `time`
    /// seconds.
    pub(super) fn new(error: &Error, gone_back: bool, time: f64) -> Self {
        // A no-break space keeps a number and its unit together.
        let at = |time: f64| quantity(time, "s").replace(' ', "\u{a0}");
        let text = match error {
            Error::Diverged(Divergence { particle, step, time, .. }) => {
                format!("Particle {particle} left the world in step {step}, at {}.", at(*time))
            }
            other => format!("{other}."),
        };
        let shown = format!(" Shown is the last valid state, at {}.", at(time));
        RunFailure { text: if gone_back { text + &shown } else { text } }
    }
}

/// The states from which a run could resume.
pub struct Origins<'a> {
    /// The scene as it was loaded.
    pub loaded: &'a Loaded,
    /// The run.
    pub runner: &'a Runner,
    /// Its earlier states.
    pub history: &'a History,
    /// Keys of the scene that were set, which a restart keeps.
    pub edits: &'a Edits,
    /// The wind that a restart keeps.
    pub wind: Wind,
}

impl Origins<'_> {
    /// Lists the available origins.
    fn list(&self) -> Vec<Origin> {
        let is_as_written = self.runner.solver() == self.loaded.solver();
        let is_set_otherwise = !self.edits.iter().all(is_of_looks);
        let is_edited = !is_as_written || is_set_otherwise;
        let earlier = (!self.history.is_empty()).then_some(Origin::Earlier);
        let scene = is_edited.then_some(Origin::Scene);
        [Origin::Here, Origin::Start].into_iter().chain(earlier).chain(scene).collect()
    }

    /// Returns a copy of the run at an origin, with the same limit on the work of a step.
    pub(super) fn copy(&self, origin: Origin) -> Result<Runner, String> {
        let mut copy = self.unbounded(origin)?;
        copy.bound_work();
        Ok(copy)
    }

    fn unbounded(&self, origin: Origin) -> Result<Runner, String> {
        let refused = |error: Error| error.to_string();
        match origin {
            Origin::Here => Ok(self.runner.clone()),
            Origin::Earlier => {
                let mut runner = self.runner.clone();
                let moment = self.history.nth_back(self.steps_of_a_second());
                moment.map_or(Ok(()), |moment| runner.go_back(moment)).map_err(refused)?;
                Ok(runner)
            }
            Origin::Start => {
                let mut solver = self.runner.solver();
                if solver.automatic && self.loaded.automatic {
                    // The run then chooses the same substeps as when the scene was first opened.
                    solver.settings.substeps = self.loaded.settings.substeps;
                }
                let mut runner = open(self.loaded, solver).map_err(refused)?;
                set_all(&mut runner, self.loaded, self.edits)?;
                runner.calm();
                if self.wind.is_gusty() {
                    let value = self.loaded.force_in(self.wind.strongest(), 0.0);
                    act(&mut runner, Interaction::SetForce { value }).map_err(refused)?;
                }
                Ok(runner)
            }
            Origin::Scene => open(self.loaded, self.loaded.solver()).map_err(refused),
        }
    }

    /// Returns the steps of about a second, limited by the history.
    pub(super) fn steps_of_a_second(&self) -> usize {
        let steps = (1.0 / self.runner.settings().step).round().max(1.0);
        steps.min(self.history.len() as f64) as usize
    }
}

/// Recovery options after a divergence, and its fastest springs.
#[derive(Debug, Default)]
pub struct WaysOut {
    rescue: Option<Reading<Rescue>>,
    fastest: Option<Reading<Vec<usize>>>,
}

impl WaysOut {
    /// Returns the options found so far.
    pub fn offers(&self, run: &Run) -> &[Offer] {
        let rescue = self.rescue.as_ref().and_then(|rescue| rescue.of(run));
        rescue.map_or(&[], Rescue::offers)
    }

    /// Returns whether more options remain to be tried.
    pub fn is_searching(&self, run: &Run) -> bool {
        let rescue = self.rescue.as_ref().and_then(|rescue| rescue.of(run));
        rescue.is_none_or(|rescue| !rescue.is_done())
    }

    /// Returns the springs with the most energy in the fastest motion, the strongest first.
    pub fn fastest(&self, run: &Run) -> &[usize] {
        self.fastest.as_ref().and_then(|springs| springs.of(run)).map_or(&[], Vec::as_slice)
    }

    /// Continues the search, or restarts it if the run was changed; `stable` is the longest stable
    /// substep, and `real` the wall-clock time of a frame, seconds.
    pub(super) fn search(
        &mut self,
        (run, stable): (&Run, f64),
        origins: &Origins<'_>,
        real: f64,
        stopwatch: &impl Fn() -> f64,
    ) {
        if self.rescue.as_ref().is_none_or(|rescue| rescue.of(run).is_none()) {
            let settings = run.runner().settings();
            let rescue = Rescue::new(settings, stable, (&origins.list(), MOST_SUBSTEPS), LASTING);
            self.rescue = Some(Reading::new(rescue, run));
            self.fastest = Some(Reading::new(fastest_springs(run.runner()), run));
        }
        if let Some(rescue) = self.rescue.as_mut().and_then(|rescue| rescue.of_mut(run)) {
            let [least, most] = SEARCH;
            let budget = (0.5 * real).clamp(least, most);
            rescue.work(&|origin| origins.copy(origin).ok(), budget, stopwatch);
        }
    }
}

/// Returns the springs with the most energy in the fastest motion, the strongest first.
fn fastest_springs(runner: &Runner) -> Vec<usize> {
    let energies: Vec<f64> = on!(runner, simulation => {
        let (model, motion) = (simulation.model(), simulation.fastest_motion());
        let energy = |(spring, ends): (usize, &[u32; 2])| {
            let [a, b] = ends.map(|end| end as usize);
            if motion.is_empty() || model.is_cut(spring) {
                return 0.0;
            }
            let along = (simulation.position(b).to_f64() - simulation.position(a).to_f64())
                .normalize_or_zero();
            let stretch = (motion[b] - motion[a]).dot(along);
            msd_core::Real::to_f64(model.stiffness(spring)) * stretch * stretch
        };
        model.ends().iter().enumerate().map(energy).collect()
    });
    let least = MARKED * energies.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut springs: Vec<usize> =
        (0..energies.len()).filter(|&spring| least <= energies[spring]).collect();
    springs.sort_by(|&a, &b| energies[b].total_cmp(&energies[a]));
    springs.truncate(MOST_MARKED);
    springs
}

/// Recovery after a divergence.
impl Session {
    pub(super) fn search_ways_out(&mut self, real: f64, stopwatch: &impl Fn() -> f64) {
        let stable = self.stability_light.stable(&self.run);
        let (Some(_), Some(stable)) = (&self.failure, stable) else { return };
        let mut ways_out = std::mem::take(&mut self.ways_out);
        ways_out.search((&self.run, stable), &self.origins(), real, stopwatch);
        self.ways_out = ways_out;
    }

    /// Returns the states from which the run could resume.
    pub(super) fn origins(&self) -> Origins<'_> {
        let &Session { ref loaded, ref run, ref history, ref material, wind, .. } = self;
        Origins { loaded, runner: run.runner(), history, edits: material.set(), wind }
    }

    /// Returns the simulated time that a step back of about a second covers, seconds.
    pub(crate) fn way_back(&self) -> f64 {
        self.origins().steps_of_a_second() as f64 * self.runner().settings().step
    }

    /// Applies a recovery option and resumes the run.
    pub fn take(&mut self, offer: Offer) {
        self.settle();
        match offer.remedy {
            Remedy::Substeps(substeps) => self.tune(SolverRow::substeps(substeps)),
            Remedy::Tolerance(tolerance) => self.tune(SolverRow::tolerance(tolerance)),
            Remedy::Method(method, substeps) => {
                let is_other = substeps != self.runner().settings().substeps;
                // If the number is the same, automatic substeps stay automatic.
                let fixed =
                    if is_other { SolverRow::substeps(substeps) } else { SolverRow::default() };
                let change = SolverRow { integrator: Some(method), ..fixed };
                self.tune_as(change, "way out");
            }
            Remedy::SceneValues => {
                self.material.forget(&self.loaded);
                self.follow_wind();
            }
            Remedy::Back => {}
        }
        match offer.origin {
            Origin::Start | Origin::Scene => return self.restart_from(offer.origin),
            Origin::Earlier => {
                self.go_back(self.origins().steps_of_a_second());
                self.watch.change(self.run.runner());
            }
            Origin::Here => {}
        }
        (self.failure, self.paused) = (None, false);
        self.clock.resume();
    }
}
