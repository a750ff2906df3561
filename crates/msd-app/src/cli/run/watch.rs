//! A watch over a run as it goes on: a limit of stability that moves, energy that the integrator
//! adds, solves that do not converge, and surfaces that something passes through.

use super::advice::appended;
use super::prepare::warn_of_step;
use super::report::{Chosen, Crossed, Gain};
use msd_core::methods::Solved;
use msd_core::stability::{Estimator, Mode};
use msd_core::{Integrator, Settings, Witness};
use msd_run::{Pierced, Piercing, Runner, on, steps_between, steps_between_counts};
use msd_study::quantity::{quantity, rounded};

/// The largest share of the work of a run that predictions may take.
const SHARE: f64 = 0.02;
/// The largest share of the work of a run that counts of crossings may take.
const COUNTS: f64 = 0.05;
/// The least part of the limit by which touches grow from one prediction to the next.
const GROWTH: f64 = 0.05;

/// Predicts the longest stable substep every so many steps, and reads the energy after each.
#[derive(Debug)]
pub struct Watch {
    estimator: Estimator,
    every: u64,
    /// The smallest prediction yet, seconds, and the time of the run when it was made.
    least: (f64, f64),
    /// The prediction for the start, seconds.
    stable: f64,
    /// What touched at the last prediction.
    touched: Mode,
    witness: Witness,
    /// Energy that the integrator has added.
    pub gain: Option<Gain>,
    /// How far the solves of an implicit method got.
    pub solved: Option<Solved>,
    /// Automatic substeps of the steps so far; `None` where they are not automatic.
    pub chosen: Option<Chosen>,
    /// Substeps taken.
    pub substeps: u64,
    /// Whether user input, such as a moving pin, did work.
    is_handled: bool,
    /// Pairs of particles that may have passed through each other before and since the start.
    passes: [u64; 2],
    /// The most pairs of triangles that were seen to cross at once.
    pub crossed: Option<Crossed>,
    /// After how many steps they are counted again.
    every_count: u64,
    /// Whether solids go through surfaces.
    pub piercing: Piercing,
    /// Whether obstacles left particles no room.
    squeezed: bool,
}

impl Watch {
    /// Begins with the prediction for the start, seconds.
    pub fn new(runner: &Runner, stable: f64) -> Self {
        let every = on!(runner, simulation => steps_between(simulation, SHARE));
        let mut watch = Watch {
            estimator: Estimator::default(),
            every,
            least: (stable, runner.time()),
            stable,
            touched: Mode::default(),
            witness: Witness::default(),
            gain: None,
            solved: None,
            chosen: None,
            substeps: 0,
            is_handled: on!(runner, simulation => simulation.is_handled()),
            passes: [runner.passes(), 0],
            crossed: None,
            every_count: on!(runner, simulation => steps_between_counts(simulation, COUNTS)),
            piercing: Piercing::default(),
            squeezed: false,
        };
        watch.piercing.look(runner);
        runner.show_to(&mut watch.witness);
        watch
    }

    /// Looks at a run after a step.
    pub fn look(&mut self, runner: &mut Runner) {
        let substeps = runner.settings().substeps;
        self.substeps += u64::from(substeps);
        if runner.is_automatic() && !runner.integrator().is_adaptive() {
            self.chosen = Some(Chosen::now(self.chosen, substeps));
        }
        runner.show_to(&mut self.witness);
        self.gain = Gain::now(self.gain, self.witness.gain(), runner.time());
        if let Some(solved) = runner.solved() {
            self.solved.get_or_insert_default().note(solved);
        }
        self.is_handled |= on!(runner, simulation => simulation.is_handled());
        self.passes[1] = runner.passes().saturating_sub(self.passes[0]);
        self.piercing.look(runner);
        self.squeezed = runner.contacts().squeezed;
        if runner.steps().is_multiple_of(self.every_count) {
            self.count_crossings(runner);
        }
        self.predict(runner);
    }

    /// Counts the triangles that cross now.
    pub fn count_crossings(&mut self, runner: &Runner) {
        if let Some(touched) = runner.touched() {
            self.crossed = Crossed::now(self.crossed, touched.crossings, runner.time());
        }
    }

    /// The change of the total energy that nothing explains, joules; `None` where user input did
    /// work.
    pub fn imbalance(&self) -> Option<f64> {
        (!self.is_handled).then(|| self.witness.imbalance())
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

    /// The warning that the balance of energy is wrong, unless a gain says so already.
    fn surplus(&self, integrator: Integrator) -> Option<String> {
        let surplus = self.witness.surplus();
        let is_told = self.is_handled || self.gain.is_some() || self.squeezed;
        let advice = match integrator.is_adaptive() {
            true => "take a tighter tolerance or another method",
            false => "shorten the step",
        };
        (0.0 < surplus && !is_told).then(|| {
            format!(
                "the total energy has risen by {}, more than a tenth of the most that was in \
                 motion, and nothing supplied it: errors of {integrator} or of bounces; {advice}",
                quantity(surplus, "J")
            )
        })
    }

    /// The warnings to print, with advice on the step if there is any.
    pub fn warnings(&self, settings: Settings, advice: Option<&str>) -> Vec<String> {
        let (least, time) = self.least;
        let moved = self.is_over(settings).then(|| warn_of_step(settings, least)).flatten();
        let advice = appended(advice);
        let moved = moved.map(|warning| {
            format!("at the latest from t = {} on, {warning}{advice}", quantity(time, "s"))
        });
        let squeezed = self.squeezed.then(|| {
            "obstacles left particles no room between them: the energy of what was squeezed means \
             nothing"
                .to_owned()
        });
        let gained = self.gain.filter(|_| !self.squeezed);
        let gained = gained.map(|gain| gain.warning(settings.integrator));
        let surplus = self.surplus(settings.integrator);
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
        let passed = (0 < self.passes[1]).then(|| {
            format!(
                "{} times two particles moved by more than their radii in a substep towards each \
                 other and may have passed through{}; shorten the step",
                self.passes[1],
                if self.chosen.is_some() {
                    ", in the most substeps that are automatic"
                } else {
                    ""
                }
            )
        });
        let crossed = self.crossed.map(|crossed| crossed.warning());
        let pierced = self.piercing.first().map(|Pierced { solid, body, time }| {
            format!(
                "world.solids[{solid}] goes through the surface of bodies[{body}] at t = {}, \
                 between particles; more substeps, a finer spacing, stiffer springs or a slower \
                 solid prevent that, or `springs = true` of a thin one",
                quantity(time, "s")
            )
        });
        let through = passed.into_iter().chain(crossed).chain(pierced);
        moved
            .into_iter()
            .chain(squeezed)
            .chain(gained)
            .chain(surplus)
            .chain(poor)
            .chain(through)
            .collect()
    }

    /// Predicts if it is time to, or where so much more touches that the limit may have fallen
    /// below the substep; what is known to be over the limit is not asked again.
    fn predict(&mut self, runner: &mut Runner) {
        let (least, _) = self.least;
        let explicit = Integrator::EXPLICIT.contains(&runner.integrator());
        let h = runner.settings().substep();
        if !explicit || least < h {
            return;
        }
        let touching = runner.touching_mode();
        let left = f64::max(1.0 - (h / least) * (h / least), GROWTH);
        let is_grown = self.touched.share(h) + left < touching.share(h);
        if !is_grown && !runner.steps().is_multiple_of(self.every) {
            return;
        }
        self.touched = touching;
        let stable = runner.stable_substep_by(&mut self.estimator);
        if stable < least {
            self.least = (stable, runner.time());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solve_that_stops_early_is_a_warning() {
        let loaded = msd_scene::open("chain").expect("a built-in scene");
        let runner = Runner::open(&loaded).expect("a valid scene");
        let warnings = |residual: f64| {
            let mut watch = Watch::new(&runner, f64::INFINITY);
            watch.solved = Some(Solved { iterations: 1, residual, tolerance: 1e-3 });
            watch.warnings(runner.settings(), None)
        };
        assert!(warnings(0.009).is_empty());
        assert!(warnings(0.02)[0].contains("stopped at a relative residual of up to 0.02, not"));
    }
}
