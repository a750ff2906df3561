//! Ways out of a run that blew up, each tried on a copy before it is offered.

use crate::history::History;
use crate::on;
use crate::runner::Runner;
use msd_core::glam::DVec3;
use msd_core::{Energy, Error, Integrator, Settings, Vector, Witness};
use msd_scene::AnyState;
use std::collections::VecDeque;

/// The time that a way out must last on a copy of the run, simulated seconds.
pub const LASTING: f64 = 2.0;
/// Part of the longest stable substep that is aimed at: springs that turn and stretch move the
/// limit.
const CAUTION: f64 = 0.8;
/// Greatest number of times that substeps are doubled, or a tolerance is taken ten times, until a
/// trial lasts.
const TRIES: usize = 5;
/// The loosest tolerance that is offered.
const LOOSEST: f64 = 0.1;
/// Longest time of a trial, seconds of the wall clock; after it, settings that are predicted to
/// last are offered as predicted.
const PATIENCE: f64 = 1.0;

/// A run that gains more than this part of the most that was in motion will blow up, but later;
/// bounces of a stiff body add a few per cent.
const GAIN: f64 = 0.5;

/// How far back a state is looked for that is not debris, simulated seconds.
pub const SOUND: f64 = 2.0;
/// A state is debris where a spring has become longer by half, and by half of the mean length.
const STRETCH: f64 = 0.5;

/// The methods in the order in which they are tried, the cheapest of the accurate ones first.
const METHODS: [Integrator; 7] = [
    Integrator::VelocityVerlet,
    Integrator::SymplecticEuler,
    Integrator::Rk4,
    Integrator::BackwardEuler,
    Integrator::Xpbd,
    Integrator::ImplicitMidpoint,
    Integrator::DormandPrince,
];

/// A change under which a run may stay in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// None but another state to go on from.
    Back,
    /// So many substeps per step.
    Substeps(u32),
    /// Another tolerance of an adaptive method, a fraction of the size of the scene.
    Tolerance(f64),
    /// Another method, with so many substeps per step.
    Method(Integrator, u32),
    /// The settings and the values of the scene as it was written.
    SceneValues,
}

impl Remedy {
    /// The settings with the change.
    pub fn settings(self, now: Settings) -> Settings {
        match self {
            Remedy::Back | Remedy::SceneValues => now,
            Remedy::Substeps(substeps) => Settings { substeps, ..now },
            Remedy::Tolerance(tolerance) => Settings { tolerance, ..now },
            Remedy::Method(integrator, substeps) => Settings { integrator, substeps, ..now },
        }
    }

    /// Changes a run; so many substeps are automatic no longer.
    fn apply(self, run: &mut Runner) -> Result<(), Error> {
        if let Remedy::Substeps(_) = self {
            run.set_automatic(false)?;
        }
        run.set_settings(self.settings(run.settings()))
    }
}

/// The state that a remedy goes on from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The state of the run.
    Here,
    /// A state of the history.
    Earlier,
    /// The start of the scene, with the values that were set since.
    Start,
    /// The start of the scene as it was written.
    Scene,
}

/// A way out of a run that blew up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// The change.
    pub remedy: Remedy,
    /// The state to go on from.
    pub origin: Origin,
    /// Whether a copy lasted; else the limit of stability alone promises it, as the trial took too
    /// long or a step of it would have.
    pub is_tried: bool,
    /// Wall-clock time per simulated second on the copy, seconds: 1 is real time. `None` where that
    /// is not known.
    pub cost: Option<f64>,
}

/// A copy of the run on which a remedy is tried.
#[derive(Clone, Debug)]
struct Dry {
    offer: Offer,
    run: Runner,
    /// Watches for energy that the method adds.
    witness: Witness,
    /// The most kinetic and elastic energy so far, joules.
    most: f64,
    taken: u64,
    /// The wall-clock time of its steps, seconds.
    spent: f64,
}

/// A candidate: a change, and the state to go on from.
type Candidate = (Remedy, Origin);

/// The search for ways out: one of each kind, the first that lasts.
#[derive(Clone, Debug)]
pub struct Rescue {
    /// The time that a remedy must last, simulated seconds.
    lasting: f64,
    /// The substeps that the current method would need, and the most that are offered.
    needed: f64,
    most: u32,
    /// The candidates of each kind that are left, the next one first.
    kinds: VecDeque<VecDeque<Candidate>>,
    dry: Option<Box<Dry>>,
    offers: Vec<Offer>,
}

impl Rescue {
    /// Begins a search for recovery options from some `origins`, in this order; each is to last for
    /// `lasting` simulated seconds.
    ///
    /// `stable` is the longest substep predicted to be stable under the current `settings`,
    /// seconds; at most `most` substeps are offered.
    pub fn new(
        settings: Settings,
        stable: f64,
        (origins, most): (&[Origin], u32),
        lasting: f64,
    ) -> Self {
        let is_from = |origin: &&Origin| matches!(origin, Origin::Here | Origin::Start);
        let from_each =
            |remedy: Remedy| origins.iter().filter(is_from).map(move |&origin| (remedy, origin));
        let only = |remedy: Remedy, origin: Origin| {
            VecDeque::from_iter(origins.contains(&origin).then_some((remedy, origin)))
        };
        let methods = METHODS.into_iter().filter(|&method| method != settings.integrator);
        let kinds = VecDeque::from([
            only(Remedy::Back, Origin::Earlier),
            finer(settings, stable, most).into_iter().flat_map(from_each).collect(),
            methods
                .map(|method| Remedy::Method(method, settings.substeps))
                .flat_map(from_each)
                .collect(),
            only(Remedy::SceneValues, Origin::Scene),
        ]);
        let needed = fewest(settings, stable);
        Rescue { lasting, needed, most, kinds, dry: None, offers: Vec::new() }
    }

    /// The offers that were found so far.
    pub fn offers(&self) -> &[Offer] {
        &self.offers
    }

    /// Whether everything was tried.
    pub fn is_done(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Goes on with the search for about `budget` seconds by a stopwatch; `copy` gives a copy of
    /// the run at an origin, with its present settings.
    pub fn work(
        &mut self,
        copy: &impl Fn(Origin) -> Option<Runner>,
        budget: f64,
        stopwatch: &impl Fn() -> f64,
    ) {
        let start = stopwatch();
        while !self.is_done() && stopwatch() - start <= budget {
            match self.dry.take() {
                Some(dry) => self.go_on(dry, stopwatch),
                None => self.begin(copy),
            }
        }
    }

    /// Ends the search at once: the option under trial is offered as predicted. Where nothing was
    /// tried yet, the fewest substeps that are predicted to be stable are offered.
    pub fn end(&mut self) {
        let under_way = self.dry.take().map(|dry| dry.offer);
        let next = self.kinds.iter().flatten().next().filter(|_| self.offers.is_empty());
        let next = next.filter(|(remedy, _)| matches!(remedy, Remedy::Substeps(_)));
        let next =
            next.map(|&(remedy, origin)| Offer { remedy, origin, is_tried: false, cost: None });
        self.offers.extend(under_way.or(next));
        self.kinds.clear();
    }

    /// Begins to try the next candidate, if it is predicted to last.
    fn begin(&mut self, copy: &impl Fn(Origin) -> Option<Runner>) {
        let Some(kind) = self.kinds.front_mut() else { return };
        let Some((remedy, origin)) = kind.pop_front() else {
            self.kinds.pop_front();
            return;
        };
        let Some(mut run) = copy(origin) else { return };
        if remedy.apply(&mut run).is_err() {
            return;
        }
        let Some(remedy) = self.fitting(remedy, &mut run) else { return };
        let offer = Offer { remedy, origin, is_tried: false, cost: None };
        // A step cannot be interrupted, and the clock is read between steps alone.
        if !run.bound_work() {
            self.offers.push(offer);
            self.kinds.pop_front();
            return;
        }
        let mut witness = Witness::default();
        let most = moving(run.show_to(&mut witness));
        self.dry = Some(Box::new(Dry { offer, run, witness, most, taken: 0, spent: 0.0 }));
    }

    /// A remedy under which a run that has it is predicted to be stable: a method with more
    /// substeps where it takes less than half as many as the current method.
    fn fitting(&self, remedy: Remedy, run: &mut Runner) -> Option<Remedy> {
        let stable = run.stable_substep();
        if run.settings().substep() <= stable {
            return Some(remedy);
        }
        let Remedy::Method(method, _) = remedy else { return None };
        let fewest = fewest(run.settings(), stable);
        let is_fewer = 2.0 * fewest < self.needed && fewest <= f64::from(self.most);
        let remedy = Remedy::Method(method, fewest as u32);
        (is_fewer && remedy.apply(run).is_ok()).then_some(remedy)
    }

    /// Takes a step of a trial, and ends it where it has failed or lasted.
    fn go_on(&mut self, mut dry: Box<Dry>, stopwatch: &impl Fn() -> f64) {
        let start = stopwatch();
        let stepped = dry.run.step();
        dry.spent += stopwatch() - start;
        dry.taken += 1;
        if stepped.is_err() {
            return;
        }
        dry.most = dry.most.max(moving(dry.run.show_to(&mut dry.witness)));
        if GAIN * dry.most < dry.witness.gain() {
            return;
        }
        let step = dry.run.settings().step;
        dry.offer.is_tried = self.lasting <= (dry.taken as f64 + 1e-6) * step;
        if dry.offer.is_tried || PATIENCE < dry.spent {
            let cost = dry.spent / (dry.taken as f64 * step);
            dry.offer.cost = Some(cost).filter(|&cost| 0.0 < cost);
            self.offers.push(dry.offer);
            self.kinds.pop_front();
        } else {
            self.dry = Some(dry);
        }
    }
}

/// The kinetic and the elastic energy, joules.
fn moving(energy: Energy) -> f64 {
    energy.kinetic + energy.elastic
}

/// Settings of the same method that are finer, or of an adaptive one that can be kept.
fn finer(settings: Settings, stable: f64, most: u32) -> Vec<Remedy> {
    if settings.integrator.is_adaptive() {
        let looser =
            std::iter::successors(Some(10.0 * settings.tolerance), |last| Some(10.0 * last));
        return looser.take(TRIES).filter(|&t| t <= LOOSEST).map(Remedy::Tolerance).collect();
    }
    if stable == 0.0 {
        return Vec::new();
    }
    let first = fewest(settings, stable).max(2.0 * f64::from(settings.substeps));
    let doubled = std::iter::successors(Some(first), |last| Some(2.0 * last));
    let few = doubled.take(TRIES).filter(|&count| count <= f64::from(most));
    few.map(|count| Remedy::Substeps(count as u32)).collect()
}

/// The substeps with which a step is stable, given the longest stable substep, seconds.
fn fewest(settings: Settings, stable: f64) -> f64 {
    (settings.step / (CAUTION * stable)).ceil()
}

/// The number of states by which to go back from a run that blew up to one that is not debris: in
/// which no spring is longer by half than about two seconds before.
pub fn debris(runner: &Runner, history: &History) -> usize {
    let most = (SOUND / runner.settings().step).ceil().min(history.len() as f64) as usize;
    let state = |back: usize| match history.nth_back(back) {
        Some(moment) => lengths(runner, &moment.state),
        None => lengths(runner, &runner.state()),
    };
    let before = state(most);
    let mean = before.iter().sum::<f64>() / before.len().max(1) as f64;
    let is_sound = |now: &[f64]| {
        let mut pairs = now.iter().zip(&before);
        pairs.all(|(now, before)| *now <= (1.0 + STRETCH) * before + STRETCH * mean)
    };
    (0..most).find(|&back| is_sound(&state(back))).unwrap_or(most)
}

/// The lengths of all springs in a state of a run, metres; those of cut springs are 0.
fn lengths(runner: &Runner, state: &AnyState) -> Vec<f64> {
    let place = |particle: u32| -> DVec3 {
        match state {
            AnyState::F32(state) => state.positions[particle as usize].to_f64(),
            AnyState::F64(state) => state.positions[particle as usize].to_f64(),
        }
    };
    on!(runner, simulation => {
        let model = simulation.model();
        let springs = model.ends().iter().enumerate();
        let length = |(spring, &[a, b]): (usize, &[u32; 2])| {
            if model.is_cut(spring) { 0.0 } else { (place(b) - place(a)).length() }
        };
        springs.map(length).collect()
    })
}
