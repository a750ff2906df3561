//! The stability light: the substep relative to the longest stable one.

use super::run::{PREDICTING, Reading, Run};
use msd_core::stability::Estimator;
use msd_core::{Integrator, Settings};
use msd_run::{Runner, on};

/// Shortest time between two predictions without a change of the run, seconds.
const REFRESH: f64 = 1.0;
/// Largest share of the wall clock for predictions.
const SHARE: f64 = 0.005;
/// The same while none is shown, after a change of the run.
const SHARE_OF_VOID: f64 = 0.1;

/// Share of a slow frame for a prediction in progress; none in a browser, where the page should
/// stay responsive.
const MOST_OF_FRAME: f64 = if cfg!(target_arch = "wasm32") { 0.0 } else { 0.1 };

/// The predicted longest stable substep, renewed at a bounded rate.
#[derive(Debug, Default)]
pub struct StabilityLight {
    /// Longest stable substep, seconds: 0 if no substep is stable, infinite if each is.
    stable: Option<Reading<f64>>,
    /// Age of the state of the prediction, seconds of wall clock.
    age: f64,
    /// Wall-clock time of the last prediction, seconds.
    cost: f64,
    /// The prediction in progress.
    under_way: Option<UnderWay>,
    estimator: Estimator,
}

/// A prediction over several frames.
#[derive(Debug)]
struct UnderWay {
    /// A copy of the run, which continues in the meantime.
    runner: Reading<Box<Runner>>,
    /// Wall-clock time since the copy, and time spent on the prediction, seconds.
    age: f64,
    spent: f64,
}

impl StabilityLight {
    /// Advances by `real` seconds of wall clock, and predicts again if a prediction is due.
    pub(super) fn refresh(&mut self, run: &Run, real: f64, stopwatch: &impl Fn() -> f64) {
        self.age += real.max(0.0);
        // Until the choice of substeps is complete, the substep is still that before the change.
        if run.runner().is_open() {
            return;
        }
        self.under_way.take_if(|under_way| under_way.runner.of(run).is_none());
        if self.under_way.is_none() && self.wait(run) <= self.age {
            self.begin(run);
        } else if let Some(under_way) = &mut self.under_way {
            under_way.age += real.max(0.0);
        }
        self.go_on(run, PREDICTING.max(MOST_OF_FRAME * real), stopwatch);
    }

    /// Begins a prediction for the current state. Only explicit methods have a limit: the others do
    /// not need the spectrum.
    fn begin(&mut self, run: &Run) {
        if !Integrator::EXPLICIT.contains(&run.runner().integrator()) {
            return self.set(Reading::new(f64::INFINITY, run), (0.0, 0.0));
        }
        self.estimator.restart();
        let runner = Reading::new(Box::new(run.runner().clone()), run);
        self.under_way = Some(UnderWay { runner, age: 0.0, spent: 0.0 });
    }

    /// Continues the prediction in progress for at most `most` seconds.
    fn go_on(&mut self, run: &Run, most: f64, stopwatch: &impl Fn() -> f64) {
        let Some(mut under_way) = self.under_way.take() else { return };
        let Some(runner) = under_way.runner.of(run) else { return };
        let Settings { integrator, substeps, .. } = runner.settings();
        let (start, estimator) = (stopwatch(), &mut self.estimator);
        loop {
            let stable = on!(&**runner, simulation => {
                simulation.stable_substep_piecewise(integrator, substeps, estimator)
            });
            let spent = stopwatch() - start;
            if let Some(stable) = stable {
                let UnderWay { age, spent: before, .. } = under_way;
                return self.set(Reading::new(stable, run), (age, before + spent));
            }
            if most < spent {
                under_way.spent += spent;
                return self.under_way = Some(under_way);
            }
        }
    }

    /// Drops the prediction: the next refresh makes another one at any cost.
    pub(super) fn forget(&mut self) {
        (self.stable, self.under_way, self.cost) = (None, None, 0.0);
    }

    /// Returns the longest stable substep, seconds: 0 if no substep is stable, infinite if each is;
    /// `None` until there is a prediction.
    pub fn stable(&self, run: &Run) -> Option<f64> {
        self.stable.as_ref().and_then(|stable| stable.of(run)).copied()
    }

    /// Returns the substep relative to the longest stable one: 1 is the limit, infinite if no
    /// substep is stable; `None` until there is a prediction.
    pub fn share(&self, run: &Run) -> Option<f64> {
        let substep = run.runner().settings().substep();
        let share = |stable| if stable == 0.0 { f64::INFINITY } else { substep / stable };
        self.stable(run).map(share)
    }

    /// Returns the age of the prediction, seconds of wall clock; it may lag behind the run.
    pub(crate) fn age(&self) -> f64 {
        self.age
    }

    /// Returns the age at which the next prediction is due, seconds. After a change a cheap one is
    /// due at once, an expensive one later.
    fn wait(&self, run: &Run) -> f64 {
        match self.stable(run) {
            None => self.cost / SHARE_OF_VOID,
            Some(_) => REFRESH.max(self.cost / SHARE),
        }
    }

    /// Stores a prediction, the age of its state and its cost, both in seconds.
    fn set(&mut self, stable: Reading<f64>, (age, cost): (f64, f64)) {
        // A prediction of less than a millisecond may be renewed after every change.
        self.cost = if cost < 1e-3 { 0.0 } else { cost };
        (self.stable, self.age) = (Some(stable), age);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_run::Runner;
    use std::cell::Cell;

    fn run() -> Run {
        let loaded = msd_scene::open("square").expect("a built-in scene");
        Run::new(Runner::open(&loaded).expect("a valid scene"))
    }

    #[test]
    fn a_change_voids_the_prediction_and_is_answered_at_once_where_cheap() {
        let (mut light, mut run) = (StabilityLight::default(), run());
        light.refresh(&run, 0.0, &|| 0.0);
        let share = light.share(&run).expect("predicted at once");
        run.change(|runner| {
            let settings = runner.settings();
            let halved = msd_core::Settings { substeps: 2 * settings.substeps, ..settings };
            runner.set_settings(halved).expect("valid settings");
        });
        assert_eq!(light.share(&run), None);
        light.refresh(&run, 0.0, &|| 0.0);
        // The limit of a damped step depends a little on the number of substeps.
        assert!((light.share(&run).expect("predicted") / share - 0.5).abs() < 0.05);
    }

    #[test]
    fn an_expensive_prediction_is_rare_and_void_until_it_is_made_again() {
        let (mut light, mut run) = (StabilityLight::default(), run());
        light.set(Reading::new(0.01, &run), (0.0, 0.1));
        let made = Cell::new(0);
        // Each piece takes longer than its share of a frame.
        let stopwatch = || made.replace(made.get() + 1) as f64;
        light.refresh(&run, 10.0, &stopwatch);
        assert_eq!((light.stable(&run), made.get()), (Some(0.01), 0));
        run.change(|_| ());
        light.age = 0.0;
        light.refresh(&run, 0.9, &stopwatch);
        assert_eq!((light.stable(&run), made.get()), (None, 0));
        light.refresh(&run, 0.2, &stopwatch);
        assert!(light.stable(&run).is_none() && 0 < made.get(), "a frame does a piece of it");
        let frames = (1..100).find(|_| {
            light.refresh(&run, 0.5, &stopwatch);
            light.stable(&run).is_some()
        });
        let frames = frames.expect("it ends");
        assert_eq!(light.age(), 0.5 * frames as f64, "it is of the state of its beginning");
        let alone = run.runner().stable_substep();
        assert_eq!(light.stable(&run), Some(alone));
        light.forget();
        light.refresh(&run, 0.0, &stopwatch);
        run.change(|_| ());
        light.refresh(&run, 0.0, &|| 0.0);
        assert_eq!(light.stable(&run), Some(alone), "a change begins it anew");
    }

    #[test]
    fn no_stable_step_is_infinitely_far_over_the_limit() {
        let (mut light, run) = (StabilityLight::default(), run());
        light.set(Reading::new(0.0, &run), (0.0, 0.0));
        assert_eq!(light.share(&run), Some(f64::INFINITY));
        light.set(Reading::new(f64::INFINITY, &run), (0.0, 0.0));
        assert_eq!(light.share(&run), Some(0.0));
    }
}
