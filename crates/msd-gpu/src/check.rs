//! Checks of a device while it runs: a thread takes a step again now and then, on the processor,
//! and compares.

use msd_core::{Simulation, State, Vector};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Steps from one check to the next, at least.
const EVERY: u64 = 16;
/// Time from the end of a check to the start of the next, in durations of a check, at least: the
/// thread works for a tenth of the time at most.
const REST: u32 = 9;

/// A step that the device has taken.
struct Taken {
    /// The simulation before it, if its model is another than at the last check.
    simulation: Option<Box<Simulation<f32>>>,
    before: State<f32>,
    /// The steps before it.
    steps: u64,
    after: State<f32>,
}

/// A step of the device whose bits differ from those of the processor.
#[derive(Debug)]
pub struct Difference {
    /// The state before it.
    pub before: State<f32>,
    /// The steps before it.
    pub steps: u64,
    /// The first particle that differs.
    pub particle: usize,
}

/// The thread that takes steps again.
#[derive(Debug)]
pub struct Checker {
    send: Sender<Taken>,
    results: Receiver<Option<Difference>>,
    /// The steps at the last check.
    last: u64,
    /// When the check that is under way began, or the next one may.
    time: Instant,
    is_busy: bool,
    is_stale: bool,
    checked: u64,
}

impl Checker {
    pub fn new() -> Self {
        let (send, taken) = channel();
        let (send_result, results) = channel();
        thread::spawn(move || take_again(&taken, &send_result));
        let time = Instant::now();
        Checker { send, results, last: 0, time, is_busy: false, is_stale: true, checked: 0 }
    }

    /// The number of steps that were checked.
    pub fn checked(&self) -> u64 {
        self.checked
    }

    /// Notes that the model is not that of the last check any more.
    pub fn renew(&mut self) {
        self.is_stale = true;
    }

    /// Whether the next step is to be checked; the first always is.
    pub fn is_due(&self, steps: u64) -> bool {
        let is_first = self.checked == 0;
        let is_rested = self.last + EVERY <= steps && self.time <= Instant::now();
        !self.is_busy && (is_first || is_rested)
    }

    /// Begins the check of a step from the state of a simulation to another.
    pub fn begin(&mut self, simulation: &Simulation<f32>, after: &State<f32>) {
        let steps = simulation.steps();
        let is_stale = std::mem::take(&mut self.is_stale);
        let taken = Taken {
            simulation: is_stale.then(|| Box::new(simulation.clone())),
            before: simulation.state(),
            steps,
            after: after.clone(),
        };
        (self.last, self.time, self.is_busy) = (steps, Instant::now(), true);
        // The thread ends with the checker, not before.
        drop(self.send.send(taken));
    }

    /// The difference that a check has found.
    pub fn result(&mut self) -> Option<Difference> {
        match self.results.try_recv() {
            Ok(result) => self.end(result),
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => None,
        }
    }

    /// Waits for the check that is under way.
    pub fn wait(&mut self) -> Option<Difference> {
        if !self.is_busy {
            return None;
        }
        self.results.recv().ok().and_then(|result| self.end(result))
    }

    fn end(&mut self, result: Option<Difference>) -> Option<Difference> {
        let duration = self.time.elapsed();
        self.time = Instant::now() + duration.min(Duration::from_secs(60)) * REST;
        self.is_busy = false;
        self.checked += 1;
        result
    }
}

/// Takes steps again and compares, until nobody sends any more.
fn take_again(taken: &Receiver<Taken>, results: &Sender<Option<Difference>>) {
    let mut simulation = None;
    for Taken { simulation: other, before, steps, after } in taken {
        if let Some(other) = other {
            simulation = Some(other);
        }
        let Some(simulation) = &mut simulation else { break };
        let is_taken =
            simulation.set_state(&before, steps).and_then(|()| simulation.step()).is_ok();
        // A step that fails here fails on the device too: it refuses what leaves the world.
        let particle =
            if is_taken { first_difference(&simulation.state(), &after) } else { Some(0) };
        let difference = particle.map(|particle| Difference { before, steps, particle });
        if results.send(difference).is_err() {
            break;
        }
    }
}

/// The first particle whose bits differ in two states.
pub fn first_difference(a: &State<f32>, b: &State<f32>) -> Option<usize> {
    let bits = |state: &State<f32>, particle: usize| {
        let motion = [state.positions[particle], state.velocities[particle]];
        motion.map(|vector| vector.components().map(f32::to_bits))
    };
    (0..a.positions.len()).find(|&particle| bits(a, particle) != bits(b, particle))
}
