//! Replay of a recorded run, as it was or stepped otherwise.

use crate::automatic::is_motion;
use crate::history::History;
use crate::on;
use crate::recording::{Event, Recording};
use crate::runner::Runner;
use msd_core::{Error, Interaction, Settings};
use msd_scene::Loaded;
use msd_scene::schema::{Solver, SolverRow};

/// A change of a replayed run, other than by steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// State, material, world or settings were changed.
    Edit,
    /// Another run began.
    Start,
}

/// A recorded run that happens again.
///
/// Without changes each step has the bits that it had. With changes the same is done to it after
/// the same steps, by a hand as strong as it was: a grab is capped by the substeps recorded.
#[derive(Clone, Debug)]
pub struct Replay<'a> {
    events: std::slice::Iter<'a, Event>,
    runner: Runner,
    changes: SolverRow,
    /// Settings with which the recorded run is stepped here.
    recorded: Settings,
    /// Steps to take before the next event.
    steps: u32,
    /// The states to return to; `None` for a recording that never returns.
    history: Option<History>,
    change: Option<Change>,
}

impl<'a> Replay<'a> {
    /// Gets ready to replay a recording; `changes` are the keys of the solver that are to be other
    /// than recorded.
    ///
    /// # Errors
    /// The first row or setting of its start that is out of its domain.
    pub fn new(recording: &'a Recording, changes: SolverRow) -> Result<Self, Error> {
        let returns = recording.events.contains(&Event::Back);
        Ok(Replay {
            events: recording.events.iter(),
            runner: open(&recording.start, &changes)?,
            changes,
            recorded: recording.start.settings,
            steps: 0,
            history: returns.then(History::default),
            change: None,
        })
    }

    /// The run.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// The change before its last step, except for looks and for motions of held particles.
    pub fn change(&self) -> Option<Change> {
        self.change
    }

    /// Takes the next step, after the events before it; returns `false` where the recording ends.
    ///
    /// # Errors
    /// A step that diverges, see [`msd_core::Simulation::step`], and an event that does not fit the
    /// run: the recording comes from elsewhere.
    pub fn advance(&mut self) -> Result<bool, Error> {
        self.change = None;
        while self.steps == 0 {
            let Some(event) = self.events.next() else { return Ok(false) };
            self.change = self.change.max(self.change_by(event));
            self.follow(event)?;
        }
        self.steps -= 1;
        let before = self.history.is_some().then(|| self.runner.moment());
        self.runner.step()?;
        if let (Some(history), Some(before)) = (&mut self.history, before) {
            history.push(before);
        }
        Ok(true)
    }

    fn change_by(&self, event: &Event) -> Option<Change> {
        let is_edit = match event {
            Event::Start(_) => return Some(Change::Start),
            Event::Act(Interaction::SetLook { .. }) => false,
            Event::Steps(_) | Event::End(_) | Event::Note(_) => false,
            Event::Act(act) => !on!(&self.runner, simulation => is_motion(simulation.model(), act)),
            // Automatic substeps that were chosen anew change nothing else.
            Event::Settings(settings) => {
                Settings { substeps: self.recorded.substeps, ..*settings } != self.recorded
            }
            Event::Precision(_) | Event::Back => true,
        };
        is_edit.then_some(Change::Edit)
    }

    fn follow(&mut self, event: &Event) -> Result<(), Error> {
        match event {
            Event::Act(interaction) => {
                let felt = as_felt(*interaction, self.recorded.substep());
                self.runner.queue(if self.changes == SolverRow::default() {
                    *interaction
                } else {
                    felt
                })?;
                self.runner.apply_queued()?;
            }
            Event::Settings(settings) => {
                self.recorded = *settings;
                let recorded = Solver { settings: *settings, ..self.runner.solver() };
                self.runner.set_settings(recorded.with(&self.changes).settings)?;
            }
            Event::Precision(precision) => {
                if self.changes.precision.is_none() {
                    self.runner = self.runner.convert(*precision)?;
                }
            }
            Event::Steps(count) => self.steps = *count,
            Event::Back => return self.go_back(),
            Event::Start(start) => {
                self.recorded = start.settings;
                self.runner = open(start, &self.changes)?;
                self.history = self.history.is_some().then(History::default);
            }
            Event::End(_) | Event::Note(_) => {}
        }
        Ok(())
    }

    fn go_back(&mut self) -> Result<(), Error> {
        let moment = self.history.as_mut().and_then(History::pop);
        let row = self.runner.steps() as usize;
        let (item, target) = ("return after step", "earlier state");
        let moment = moment.ok_or(Error::OutOfRange { item, row, target, index: 0, count: 0 })?;
        self.runner.go_back(&moment)
    }
}

/// A saved run made ready with changes. The recording holds the choices that were made while it was
/// recorded: nothing is chosen anew.
fn open(start: &Loaded, changes: &SolverRow) -> Result<Runner, Error> {
    let solver = start.solver().with(changes);
    Runner::open_with(start, Solver { automatic: false, ..solver })
}

/// A grab as weak as the core makes it for a substep of `h` seconds. A run with shorter substeps
/// would follow a stronger hand: another input, and no error of either.
///
/// The caps of the core: k ≤ m (2π 0.1 / h)², c ≤ 0.5 m / h, with k = m (2π f)² and c = 4π ζ m f.
pub fn as_felt(interaction: Interaction, h: f64) -> Interaction {
    let Interaction::Grab { particle, target, frequency, damping_ratio, max_force } = interaction
    else {
        return interaction;
    };
    let felt = frequency.min(0.1 / h);
    let turn = 2.0 * std::f64::consts::TAU;
    let damping = (turn * damping_ratio * frequency).min(0.5 / h);
    let damping_ratio = if 0.0 < felt { damping / (turn * felt) } else { 0.0 };
    Interaction::Grab { particle, target, frequency: felt, damping_ratio, max_force }
}
