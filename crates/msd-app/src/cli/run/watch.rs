//! A watch over a run as it goes on: a limit of stability that moves, energy that the integrator
//! adds, and solves that do not converge.

use super::advice::appended;
use super::prepare::warn_of_step;
use super::report::{Gain, evaluations};
use msd_core::methods::Solved;
use msd_core::stability::Estimator;
use msd_core::{Integrator, Model, Real, Settings, Witness};
use msd_run::Runner;
use msd_study::quantity::{quantity, rounded};

/// The largest share of the work of a run that predictions may take.
const SHARE: f64 = 0.02;
/// What a prediction costs in evaluations of the forces: see `cargo bench --bench stability`.
const COST: f64 = 300.0;
/// What it costs besides where dampers couple motions, in springs evaluated.
const COUPLED_COST: f64 = 8e6;

/// Predicts the longest stable substep every so many steps, and reads the energy after each.
#[derive(Debug)]
pub struct Watch {
    estimator: Estimator,
    every: u64,
    /// The smallest prediction yet, seconds, and the time of the run when it was made.
    least: (f64, f64),
    /// The prediction for the start, seconds.
    stable: f64,
    witness: Witness,
    /// Energy that the integrator has added.
    pub gain: Option<Gain>,
    /// How far the solves of an implicit method got.
    pub solved: Option<Solved>,
}

impl Watch {
    /// Begins with the prediction for the start, seconds.
    pub fn new(runner: &Runner, stable: f64) -> Self {
        let settings = runner.settings();
        let uneven = msd_run::on!(runner, simulation => is_damped_unevenly(simulation.model()));
        let coupled = if uneven { COUPLED_COST } else { 0.0 };
        let cost = COST + coupled / runner.spring_count().max(1) as f64;
        // Only explicit methods are predicted for, and the number of their evaluations is known.
        let evaluations = evaluations(settings.integrator).unwrap_or(1) as f64;
        let every = (cost / (SHARE * evaluations * f64::from(settings.substeps))).ceil() as u64;
        let mut watch = Watch {
            estimator: Estimator::default(),
            every,
            least: (stable, runner.time()),
            stable,
            witness: Witness::default(),
            gain: None,
            solved: None,
        };
        runner.show_to(&mut watch.witness);
        watch
    }

    /// Looks at a run after a step.
    pub fn look(&mut self, runner: &Runner) {
        runner.show_to(&mut self.witness);
        self.gain = Gain::now(self.gain, self.witness.gain(), runner.time());
        if let Some(solved) = runner.solved() {
            self.solved.get_or_insert_default().note(solved);
        }
        self.predict(runner);
    }

    /// The change of the total energy that nothing explains, joules.
    pub fn imbalance(&self) -> f64 {
        self.witness.imbalance()
    }

    /// The smallest prediction yet, seconds.
    pub fn least(&self) -> f64 {
        self.least.0
    }

    /// Whether the limit moved below the substep on the way.
    pub fn is_over(&self, settings: Settings) -> bool {
        let (least, _) = self.least;
        least < self.stable && least < settings.substep()
    }

    /// The warnings to print, with advice on the step if there is any.
    pub fn warnings(&self, settings: Settings, advice: Option<&str>) -> Vec<String> {
        let (least, time) = self.least;
        let moved = self.is_over(settings).then(|| warn_of_step(settings, least)).flatten();
        let advice = appended(advice);
        let moved = moved.map(|warning| {
            format!("at the latest from t = {} on, {warning}{advice}", quantity(time, "s"))
        });
        let gained = self.gain.map(|gain| gain.warning(settings.integrator));
        let poor =
            self.solved.filter(Solved::is_poor).map(|Solved { residual, tolerance, .. }| {
                format!(
                    "the solver of {} stopped at a relative residual of up to {}, not {}: slow \
                     motions among stiff ones may be lost; use f64 or more substeps",
                    settings.integrator,
                    rounded(residual, 2),
                    rounded(tolerance, 1)
                )
            });
        moved.into_iter().chain(gained).chain(poor).collect()
    }

    /// Predicts if it is time to; what is known to be over the limit is not asked again.
    fn predict(&mut self, runner: &Runner) {
        let (least, _) = self.least;
        let explicit = Integrator::EXPLICIT.contains(&runner.integrator());
        let over = least < runner.settings().substep();
        if !explicit || over || !runner.steps().is_multiple_of(self.every) {
            return;
        }
        let stable = runner.stable_substep_by(&mut self.estimator);
        if stable < least {
            self.least = (stable, runner.time());
        }
    }
}

/// Whether springs differ in damping.
fn is_damped_unevenly<R: Real>(model: &Model<R>) -> bool {
    let springs = (0..model.ends().len()).filter(|&spring| !model.is_cut(spring));
    let mut dampings = springs.map(|spring| model.damping(spring));
    let first = dampings.next();
    dampings.any(|damping| Some(damping) != first)
}
