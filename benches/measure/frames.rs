//! Cost of a frame beyond its substeps: the same frames, with one thing more each.

use super::race::{Patience, Rival, times};
use super::rivals::settings;
use crate::baselines::works;
use msd::core::glam::{DVec3, Vec3};
use msd::core::{Integrator, Interaction, Pin, Scene, Settings, Simulation, Vector, Witness};
use msd::run::{History, Moment};
use msd::scene::AnyState;
use msd_app::session::Throttle;
use std::cell::RefCell;
use std::fmt::Write;
use std::hint::black_box;
use std::rc::Rc;
use std::time::Instant;

/// Frames that are also taken as one long step.
const FRAMES: u32 = 25;
/// How often each simulation is made: where its memory lies matters by some per cent, so rivals
/// share one, and there are several.
const COPIES: usize = 5;
/// The target for all together, percent.
const ASKED: f64 = 10.0;

const LONG: &str = "one long step";
const STEP: &str = "a step of its own";
const PLANE: &str = "a plane";
const HAND: &str = "a hand that holds a particle";

/// Takes a number of frames, and does the measured thing once in each.
type Frames = Box<dyn FnMut(&mut Simulation, u64)>;

/// Something that a frame may do.
struct Cost {
    name: &'static str,
    /// The name of what has all but this.
    beside: &'static str,
    /// Whether its body has a plane.
    planes: bool,
    frames: fn(&Simulation) -> Frames,
}

const COSTS: [Cost; 8] = [
    Cost { name: STEP, beside: LONG, planes: false, frames: plain },
    Cost { name: PLANE, beside: STEP, planes: true, frames: plain },
    Cost { name: HAND, beside: STEP, planes: false, frames: held },
    Cost { name: "the hand moves", beside: HAND, planes: false, frames: moved },
    Cost { name: "the energy, now and then", beside: PLANE, planes: true, frames: throttled },
    Cost { name: "positions to draw", beside: PLANE, planes: true, frames: drawn },
    Cost { name: "a state to step back to", beside: PLANE, planes: true, frames: kept },
    Cost { name: "the energy in every frame", beside: PLANE, planes: true, frames: watched },
];
/// How many of them are added up: collision, grabs, guard, energy and snapshot were asked for.
const ADDED: usize = 6;

/// What the things cost in some works, percent of the substeps alone.
pub fn table(works: &[&str], patience: Patience) -> String {
    let shares: Vec<Shares> = works.iter().map(|work| Shares::measure(work, patience)).collect();
    let mut table = format!("| | {} |\n|---|{}\n", works.join(" | "), "---|".repeat(works.len()));
    let mut row = |name: &str, cell: &dyn Fn(&Shares) -> String| {
        let cells = shares.iter().map(cell).collect::<Vec<_>>().join(" | ");
        let _ = writeln!(table, "| {name} | {cells} |");
    };
    row("the substeps alone", &|shares| format!("{:.0} µs", 1e6 * shares.alone));
    for (place, cost) in COSTS.iter().enumerate() {
        if place == ADDED {
            let sum = |shares: &Shares| shares.costs[..ADDED].iter().sum::<f64>();
            row("all of these", &|shares| percent(sum(shares)));
            row("asked, at most", &|_| percent(ASKED));
        }
        row(cost.name, &|shares| percent(shares.costs[place]));
    }
    table
}

fn percent(share: f64) -> String {
    format!("{share:+.1} %")
}

/// The results of a work.
struct Shares {
    /// The substeps of a frame alone at their best, seconds.
    alone: f64,
    /// Percent of the substeps alone of the same round, medians over rounds.
    costs: Vec<f64>,
}

impl Shares {
    fn measure(work: &str, patience: Patience) -> Self {
        let (copies, patience) = match patience {
            Patience::Once => (1, patience),
            Patience::Seconds(seconds) => (COPIES, Patience::Seconds(seconds / COPIES as f64)),
        };
        let bodies: Vec<[Shared; 2]> = (0..copies).map(|_| bodies(work)).collect();
        let mut times: Vec<Vec<f64>> = vec![Vec::new(); COSTS.len() + 1];
        for bodies in &bodies {
            let found = self::times(&mut rivals(bodies), patience);
            times.iter_mut().zip(found).for_each(|(all, found)| all.extend(found));
        }
        let [long, step] = [LONG, STEP].map(|name| &times[place(name)]);
        let alone: Vec<f64> =
            long.iter().zip(step).map(|(&long, &step)| alone(long, step)).collect();
        let cost = |cost: &Cost| {
            let without = if cost.beside == LONG { &alone } else { &times[place(cost.beside)] };
            let rounds = times[place(cost.name)].iter().zip(without).zip(&alone);
            median(rounds.map(|((with, without), alone)| 100.0 * (with - without) / alone))
        };
        let costs = COSTS.iter().map(cost).collect();
        let [long, step] = [long, step].map(|times| times.iter().copied().fold(f64::MAX, f64::min));
        Shares { alone: self::alone(long, step) / f64::from(FRAMES), costs }
    }
}

/// The substeps of all frames alone, seconds: with n frames of s + c, where s are substeps and c is
/// what a step costs besides, and a long step of n s + c, these are n s.
fn alone(long: f64, frames: f64) -> f64 {
    (f64::from(FRAMES) * long - frames) / f64::from(FRAMES - 1)
}

/// Where a rival is among the rivals: the long step is the first.
fn place(name: &str) -> usize {
    COSTS.iter().position(|cost| cost.name == name).map_or(0, |place| place + 1)
}

fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

type Shared = Rc<RefCell<Simulation>>;

/// A work without planes and with them. A block without hangs by its first particle, as it would
/// fall for ever.
fn bodies(work: &str) -> [Shared; 2] {
    let whole = works::scene(work);
    let mut free = Scene { planes: Vec::new(), ..whole.clone() };
    if free.pins.is_empty() {
        free.pins.push(Pin { particle: 0, velocity: DVec3::ZERO });
    }
    let settings = settings(Integrator::SymplecticEuler);
    let simulation = |scene| Simulation::new(scene, settings).expect("a valid scene");
    [&free, &whole].map(|scene| Rc::new(RefCell::new(simulation(scene))))
}

/// The long step, and everything that may cost something.
fn rivals([free, whole]: &[Shared; 2]) -> Vec<Rival<'static>> {
    let body = free.clone();
    let long = rival(LONG, move |times| {
        let (simulation, settings) =
            (&mut body.borrow_mut(), settings(Integrator::SymplecticEuler));
        let (step, substeps) = (settings.step * f64::from(FRAMES), settings.substeps * FRAMES);
        simulation.set_settings(Settings { step, substeps, ..settings }).expect("a usable step");
        take(simulation, times, |_| ());
        simulation.set_settings(settings).expect("a usable step");
    });
    let costs = COSTS.iter().map(|cost| {
        let body = if cost.planes { whole.clone() } else { free.clone() };
        let mut frames = (cost.frames)(&body.borrow());
        rival(cost.name, move |times| frames(&mut body.borrow_mut(), times * u64::from(FRAMES)))
    });
    core::iter::once(long).chain(costs).collect()
}

fn rival(name: &str, run: impl FnMut(u64) + 'static) -> Rival<'static> {
    Rival { name: name.into(), updates: 1.0, run: Box::new(run) }
}

/// Takes steps, and does something after each.
fn take(simulation: &mut Simulation, steps: u64, mut after: impl FnMut(&mut Simulation)) {
    for _ in 0..steps {
        simulation.step().expect("stable");
        after(simulation);
    }
}

fn plain(_: &Simulation) -> Frames {
    Box::new(|simulation, frames| take(simulation, frames, |_| ()))
}

fn held(simulation: &Simulation) -> Frames {
    let particle = simulation.model().particle_count() / 2;
    Box::new(move |simulation, frames| {
        let target = simulation.position(particle).to_f64();
        act(simulation, grab(particle, target));
        take(simulation, frames, |_| ());
        act(simulation, Interaction::Release { particle });
    })
}

/// As the pointer does in the window.
fn moved(simulation: &Simulation) -> Frames {
    let particle = simulation.model().particle_count() / 2;
    Box::new(move |simulation, frames| {
        let target = simulation.position(particle).to_f64();
        take(simulation, frames, |simulation| {
            let aside = 0.1 * f64::sin(simulation.time());
            act(simulation, grab(particle, target + DVec3::splat(aside)));
        });
        act(simulation, Interaction::Release { particle });
    })
}

/// A grab about as strong as that of the window on a cloth of 31 by 31.
fn grab(particle: usize, target: DVec3) -> Interaction {
    let (frequency, damping_ratio, max_force) = (45.0, 20.0, 3e5);
    Interaction::Grab { particle, target, frequency, damping_ratio, max_force }
}

fn act(simulation: &mut Simulation, interaction: Interaction) {
    let done = simulation.queue(interaction).and_then(|()| simulation.apply_queued());
    done.expect("a hand that can be");
}

/// The readings of the window when it has no processor time to spare.
fn throttled(_: &Simulation) -> Frames {
    let (mut witness, mut throttle, clock) =
        (Witness::default(), Throttle::default(), Instant::now());
    let stopwatch = move || clock.elapsed().as_secs_f64();
    Box::new(move |simulation, frames| {
        let mut start = stopwatch();
        take(simulation, frames, |simulation| {
            let spent = stopwatch() - start;
            throttle.save(spent, spent);
            if throttle.is_enough() {
                throttle.spend(&stopwatch, || black_box(witness.watch(simulation)));
            }
            start = stopwatch();
        });
    })
}

fn watched(_: &Simulation) -> Frames {
    let mut witness = Witness::default();
    Box::new(move |simulation, frames| {
        take(simulation, frames, |simulation| {
            black_box(witness.watch(simulation));
        });
    })
}

/// A snapshot borrows; its positions are copied for the picture, as the renderer does.
fn drawn(_: &Simulation) -> Frames {
    let mut positions: Vec<Vec3> = Vec::new();
    Box::new(move |simulation, frames| {
        take(simulation, frames, |simulation| {
            simulation.snapshot().copy_positions(&mut positions);
            black_box(&positions);
        });
    })
}

/// A window keeps the last states; here it has as many as it keeps already.
fn kept(simulation: &Simulation) -> Frames {
    let mut history = History::default();
    let mut states = None;
    while states != Some(history.len()) {
        states = Some(history.len());
        history.push(moment(simulation));
    }
    Box::new(move |simulation, frames| {
        take(simulation, frames, |simulation| history.push(moment(simulation)));
    })
}

fn moment(simulation: &Simulation) -> Moment {
    let state = AnyState::F32(simulation.state());
    let substeps = simulation.settings().substeps;
    let (steps, ledger) = (simulation.steps(), simulation.ledger().clone());
    Moment { state, steps, ledger, substeps, impulses: Vec::new() }
}
