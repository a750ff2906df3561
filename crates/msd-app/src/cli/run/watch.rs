//! A watch over a run as it goes on: a limit of stability that moves, energy that the integrator
//! adds or loses, solves that do not converge, surfaces that cross or that solids go through, and
//! cells that are flat or inside out.

use super::advice::appended;
use super::prepare::warn_of_step;
use super::report::{Chosen, Crossed, Gain};
use msd_core::methods::Solved;
use msd_core::stability::Estimator;
use msd_core::{Integrator, Settings, Witness};
use msd_run::{
    Cells, Overturned, Pierced, Piercing, Runner, WentThrough, on, steps_between,
    steps_between_counts,
};
use msd_study::quantity::{quantity, rounded};

/// The largest share of the work of a run that predictions may take.
const SHARE: f64 = 0.02;
/// The largest share of the work of a run that counts of crossings may take.
const COUNTS: f64 = 0.05;
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
    /// The most energy that was missing, joules.
    lost: f64,
    /// The most by which the balance was too high for a while, joules.
    risen: f64,
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
    /// How often shells may have crossed, before and since the start.
    passes: [u64; 2],
    /// The bodies that were seen to go through each other since the start.
    went_through: Vec<WentThrough>,
    /// The most pairs of triangles that were seen to cross at once.
    pub crossed: Option<Crossed>,
    /// After how many steps they are counted again.
    every_count: u64,
    /// Whether solids go through surfaces.
    pub piercing: Piercing,
    /// Whether obstacles left particles no room.
    squeezed: bool,
    /// Elastic energy at the last look, joules.
    elastic: f64,
    /// The longest substep that resolves the stiffness of the scene, seconds.
    resolving: f64,
    cells: Cells,
    /// The body of which most cells are flat or inside out at the end.
    pub overturned: Option<Overturned>,
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
            witness: Witness::default(),
            lost: 0.0,
            risen: 0.0,
            gain: None,
            solved: None,
            chosen: None,
            substeps: 0,
            is_handled: on!(runner, simulation => simulation.is_handled()),
            passes: [runner.passes(), 0],
            went_through: Vec::new(),
            crossed: None,
            every_count: on!(runner, simulation => steps_between_counts(simulation, COUNTS)),
            piercing: Piercing::default(),
            squeezed: false,
            elastic: 0.0,
            resolving: resolving(runner),
            cells: Cells::new(runner),
            overturned: None,
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
        self.elastic = runner.show_to(&mut self.witness).elastic;
        self.lost = self.lost.max(self.witness.loss());
        self.risen = self.risen.max(self.witness.rise());
        let gain = self.witness.gain();
        self.gain = Gain::now(self.gain, gain, (runner.time(), self.elastic));
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
            self.went_through = touched.went_through;
        }
    }

    /// Counts the cells that are flat or inside out now.
    pub fn count_overturned(&mut self, runner: &Runner) {
        self.overturned = self.cells.overturned(runner);
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

    /// The most energy that was missing, joules; `None` where none was, or user input did work.
    pub fn loss(&self) -> Option<f64> {
        let is_known = !self.is_handled && !self.squeezed;
        Some(self.lost).filter(|&loss| is_known && 0.0 < loss)
    }

    /// The warning of energy that nothing took by any account: an error, or the damping that a
    /// method has by design.
    fn lost(&self, integrator: Integrator) -> Option<String> {
        let loss = quantity(self.loss()?, "J");
        Some(match integrator {
            Integrator::BackwardEuler | Integrator::Xpbd => format!(
                "{integrator} has damped {loss} of energy by itself, more than a tenth of the most \
                 that was in motion, beside what is dissipated: it does so by design, and less \
                 with more substeps"
            ),
            _ => format!(
                "the total energy has fallen by {loss}, more than a tenth of the most that was in \
                 motion, and nothing took it: errors of {integrator} or of bounces; {}",
                remedy(integrator)
            ),
        })
    }

    /// The warning that the balance of energy is wrong, unless a gain says so already.
    fn surplus(&self, integrator: Integrator) -> Option<String> {
        let surplus = self.risen.max(self.witness.surplus());
        let is_told = self.is_handled || self.gain.is_some() || self.squeezed;
        (0.0 < surplus && !is_told).then(|| {
            format!(
                "the total energy has risen by {}, more than a tenth of the most that was in \
                 motion, and nothing supplied it: errors of {integrator} or of bounces; {}",
                quantity(surplus, "J"),
                remedy(integrator)
            )
        })
    }

    /// The warning of energy that the method has added, or that XPBD is too soft.
    fn gained(&self, settings: Settings) -> Option<String> {
        let integrator = settings.integrator;
        let surplus = self.witness.surplus();
        let surplus = Gain::now(None, surplus, (self.least.1, self.elastic));
        let known = self.gain.or(surplus.filter(|_| !self.is_handled));
        let gain = known.filter(|_| !self.squeezed)?;
        if gain.is_softness(integrator) {
            return Some(gain.softness(settings, self.resolving));
        }
        if self.gain.is_some() { Some(gain.warning(integrator)) } else { self.surplus(integrator) }
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
        let gained = self.gained(settings);
        let lost = self.lost(settings.integrator);
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
        let went = self.went_through.iter().map(|went| {
            let time = quantity(went.time, "s");
            format!("{went} at t = {time}; shorten the step, or use a larger `touch.thickness`")
        });
        let passed = (0 < self.passes[1]).then(|| {
            format!(
                "possible crossings of bodies: {}{}; they went through each other, or were too \
                 fast for msd to find all contacts; shorten the step",
                self.passes[1],
                if self.chosen.is_some() { ", even at the most automatic substeps" } else { "" }
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
        let through = went.chain(passed).chain(crossed).chain(pierced);
        moved
            .into_iter()
            .chain(squeezed)
            .chain(gained)
            .chain(lost)
            .chain(poor)
            .chain(through)
            .chain(self.overturned.as_ref().filter(|found| is_much(found)).map(overturned))
            .collect()
    }

    /// Predicts if it is time to; what is known to be over the limit is not asked again.
    fn predict(&mut self, runner: &mut Runner) {
        let (least, _) = self.least;
        let explicit = Integrator::EXPLICIT.contains(&runner.integrator());
        let h = runner.settings().substep();
        if !explicit || least < h || !runner.steps().is_multiple_of(self.every) {
            return;
        }
        let stable = runner.stable_substep_by(&mut self.estimator);
        if stable < least {
            self.least = (stable, runner.time());
        }
    }
}

/// What makes the energy of a method better.
fn remedy(integrator: Integrator) -> &'static str {
    match integrator.is_adaptive() {
        true => "take a tighter tolerance or another method",
        false => "shorten the step",
    }
}

/// The longest substep that resolves the fastest motion, of which a method without a limit knows
/// nothing, seconds.
fn resolving(runner: &Runner) -> f64 {
    if runner.integrator() != Integrator::Xpbd {
        return f64::INFINITY;
    }
    on!(runner, simulation => simulation.stable_substep_of(Integrator::VelocityVerlet, 1))
}

/// Whether so many corners of cells are flat or inside out that the shape of the body is wrong: a
/// hard edge of an impact leaves a few in thousands.
fn is_much(Overturned { corners, of, .. }: &Overturned) -> bool {
    *of <= 100 * corners
}

/// The warning of cells that are flat or inside out.
fn overturned(Overturned { body, corners, of }: &Overturned) -> String {
    format!(
        "{corners} of the {of} corners of cells in bodies[{body}] are flat or inside out at the \
         end; a stiffer material, a softer impact or, for a block, `poisson = 0.45` prevents that"
    )
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
