//! Studies: the cost of a scene at every accuracy, from every choice worth trying.

pub mod words;
mod course;
pub mod conduct;

use crate::behaviour::audit::Audit;
use crate::behaviour::limits::Limit;
use crate::candidates::choice::Choice;
use crate::measure::trial::Trial;
use crate::quantity::quantity;
use crate::space::{ErrorBalance, Space};
use msd_core::Integrator;
use serde::{Deserialize, Serialize};

/// Result of a study: all that its report shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Name of the scene.
    pub scene: String,
    /// One line that describes the scene.
    pub title: String,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// Size of the scene, metres: the unit of relative errors.
    pub size: f64,
    /// Time simulated, seconds.
    pub duration: f64,
    /// The error that the words are about, metres.
    pub wanted: f64,
    /// The reference of the trials.
    pub reference: ReferenceNote,
    /// Times of the samples, seconds.
    pub times: Vec<f64>,
    /// Kinetic, elastic and gravitational energy of the reference at those times, joules.
    pub energies: Vec<f64>,
    /// The trials.
    pub trials: Vec<Trial>,
    /// The choices that were not tried, and why, one line each.
    pub left_out: Vec<String>,
    /// Largest stable substeps, predicted and observed.
    pub limits: Vec<Limit>,
    /// The effective stiffness and damping of each method.
    pub audit: Vec<Audit>,
    /// The error of space: from [`conduct::add_space`], or as it was last found.
    pub space: Option<Space>,
    /// The errors of space, time and precision of the scene at its own settings; none without
    /// [`conduct::add_space`].
    pub balance: Option<ErrorBalance>,
    /// The cost of trials on a device; none without [`conduct::add_device`].
    pub on_device: Option<OnDevice>,
    /// The conclusions, in plain words.
    pub words: String,
    /// The machine, in words.
    pub machine: String,
    /// When, as year-month-day.
    pub date: String,
}

/// The cost of trials on a device. Their errors are those of the processor, as all bits are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnDevice {
    /// Name of the device.
    pub name: String,
    /// The choices that it steps, each with its wall-clock time per simulated second, seconds,
    /// which includes transfers of the state.
    pub costs: Vec<(Choice, f64)>,
    /// Why the device took no more steps, if it failed.
    pub fault: Option<String>,
}

/// The reference of the trials of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceNote {
    /// Tolerance of Dormand-Prince; 0 where a closed form was used.
    pub tolerance: f64,
    /// Substeps in a frame of RK4 where shells meet; 0 of Dormand-Prince.
    pub substeps: u32,
    /// Uncertainty over the time compared, metres.
    pub uncertainty: f64,
    /// Time up to which particles were compared, seconds; later only energy and centre of mass.
    pub reliable_until: f64,
    /// The time at which the scene becomes chaotic at the wanted error, seconds.
    pub horizon: Option<f64>,
    /// Time of the processor that it took, seconds.
    pub seconds: f64,
}

/// Keeps the rows of a smaller error than all before them.
fn keep_better<T>(rows: &mut Vec<T>, error: impl Fn(&T) -> f64) {
    let mut best = f64::INFINITY;
    rows.retain(|row| {
        let better = error(row) < best;
        best = best.min(error(row));
        better
    });
}

impl Study {
    /// Rows of the sound trials that no other one beats in both cost and error, cheapest first;
    /// below the uncertainty of the reference errors are alike.
    pub fn front(&self) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.trials.len()).collect();
        rows.retain(|&row| self.trials[row].is_sound());
        rows.sort_by(|&a, &b| self.trials[a].cost.total_cmp(&self.trials[b].cost));
        keep_better(&mut rows, |&row| self.trials[row].error().max(self.reference.uncertainty));
        rows
    }

    /// The most accurate trial that takes at most this time of the processor per simulated second,
    /// seconds.
    pub fn best_within(&self, cost: f64) -> Option<&Trial> {
        let rows = self.front().into_iter().map(|row| &self.trials[row]);
        rows.filter(|trial| trial.cost <= cost).min_by(|a, b| a.error().total_cmp(&b.error()))
    }

    /// The estimate of the error of space, which the trials leave out, in a line.
    pub fn space_line(&self) -> String {
        match (&self.balance, &self.space) {
            (Some(_), Some(space)) => space.words(),
            (None, Some(space)) => format!(
                "the error of space is not included; when last measured, over {}, {}",
                quantity(space.duration, "s"),
                space.words()
            ),
            _ => "the error of space is not included: --mesh measures it".into(),
        }
    }

    /// The cost of a trial on the device, wall-clock time per simulated second, seconds; none where
    /// it was not measured.
    pub fn cost_on_device(&self, choice: Choice) -> Option<f64> {
        let costs = self.on_device.as_ref()?.costs.iter();
        costs.into_iter().find(|cost| cost.0 == choice).map(|cost| cost.1)
    }

    /// Rows of the sound trials that no other one on the device beats in both cost and error,
    /// cheapest first, each with its cost there.
    pub fn front_on_device(&self) -> Vec<(usize, f64)> {
        let cost = |row: usize| Some((row, self.cost_on_device(self.trials[row].choice)?));
        let mut rows: Vec<(usize, f64)> = (0..self.trials.len()).filter_map(cost).collect();
        rows.retain(|&(row, cost)| self.trials[row].is_sound() && cost.is_finite());
        rows.sort_by(|a, b| a.1.total_cmp(&b.1));
        let error = |row: usize| self.trials[row].error();
        keep_better(&mut rows, |row| error(row.0).max(self.reference.uncertainty));
        rows
    }

    /// The trials of one method, in the order they were tried.
    pub fn of(&self, integrator: Integrator) -> impl Iterator<Item = &Trial> {
        self.trials.iter().filter(move |trial| trial.choice.integrator == integrator)
    }
}
