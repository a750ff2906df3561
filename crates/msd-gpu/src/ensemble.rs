//! Many simulations of one method at once on a device: sweeps and studies of small scenes.

use crate::check::{Checker, Difference};
use crate::device::Device;
use crate::error::GpuError;
use crate::instances::{Instances, Outcome};
use crate::simulation::{MOST_STEPS, Tally, prepare};
use msd_core::{Error, Settings, Simulation, State};
use std::borrow::{Borrow, BorrowMut};

/// Steps from one read-back to the next where the device refuses none, at most: each read-back
/// moves all states.
const MOST_UNREFUSED: u64 = 16 * MOST_STEPS;

/// Simulations on a device that step together. They may differ in all but the method and the number
/// of substeps. Equal tables of springs are stored once.
///
/// A small scene does not fill a device: a substep takes as long as the latency of the device. Many
/// small scenes take hardly longer than one. While they step, the processor repeats a step of one
/// of them now and then, of each in turn, and compares all bits.
#[derive(Debug)]
pub struct Ensemble {
    instances: Instances,
    /// Why instances ended early.
    ended: Vec<Option<Error>>,
    /// Steps to the next read-back, at most.
    most: u64,
    tally: Tally,
    checker: Checker,
    /// Checks that were due: the next is of the simulation of this number, counted round.
    begun: usize,
}

impl Ensemble {
    /// Prepares a device to step simulations.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if there are no simulations, or if they have several methods or
    /// numbers of substeps; otherwise see [`crate::GpuSimulation::new`].
    pub async fn new<S: Borrow<Simulation<f32>>>(
        device: &Device,
        simulations: &[S],
    ) -> Result<Self, GpuError> {
        let simulations: Vec<&Simulation<f32>> = simulations.iter().map(S::borrow).collect();
        let of = |simulation: &Simulation<f32>| {
            let Settings { integrator, substeps, .. } = simulation.settings();
            (integrator, substeps)
        };
        let [first, rest @ ..] = &simulations[..] else {
            return Err(GpuError::Unsupported("an ensemble of no scenes".to_owned()));
        };
        refuse_input(&simulations)?;
        if rest.iter().any(|other| of(other) != of(first)) {
            let reason = "an ensemble of several methods or numbers of substeps".to_owned();
            return Err(GpuError::Unsupported(reason));
        }
        Ok(Ensemble {
            instances: prepare(device, &simulations).await?,
            ended: vec![None; simulations.len()],
            most: MOST_STEPS,
            tally: Tally::default(),
            checker: Checker::new(),
            begun: 0,
        })
    }

    /// The steps of all simulations so far, by who took them.
    pub fn tally(&self) -> Tally {
        Tally { checked: self.checker.checked(), ..self.tally }
    }

    /// Advances all simulations by a number of steps, and returns why some of them ended early.
    /// Those keep their last good state, as on the processor.
    ///
    /// Pass the simulations that the device was prepared for; only their states may differ. The
    /// ledger of each holds NaN after steps on the device.
    ///
    /// # Errors
    /// [`GpuError::Lost`]; each simulation then stands at the last state that was read back.
    /// [`GpuError::Differs`]: a check failed, and no step of the ensemble is to be trusted.
    pub fn advance<S: BorrowMut<Simulation<f32>>>(
        &mut self,
        simulations: &mut [S],
        steps: u64,
    ) -> Result<&[Option<Error>], GpuError> {
        refuse_input(simulations)?;
        let mut left = steps;
        while 0 < left {
            self.instances.device().check_lost()?;
            let checked = self.due(simulations);
            let batch = if checked.is_some() { 1 } else { left.min(self.most) };
            for (number, simulation) in simulations.iter().enumerate() {
                match self.ended[number] {
                    None => self.instances.load(number, simulation.borrow()),
                    Some(_) => self.instances.remove(number),
                }
            }
            self.instances.submit(batch);
            let outcomes = self.instances.wait()?;
            // The processor takes the steps from a refused one to the next read-back.
            let is_live =
                |(outcome, ended): (&Outcome, &Option<Error>)| outcome.refused && ended.is_none();
            let is_any_refused = outcomes.iter().zip(&self.ended).any(is_live);
            let more = (2 * self.most).min(MOST_UNREFUSED);
            self.most = if is_any_refused { MOST_STEPS } else { more };
            if let Some(number) = checked {
                self.begun += 1;
                if outcomes[number].steps == 1 {
                    self.check(simulations[number].borrow(), &outcomes[number].state);
                }
            }
            for (number, (simulation, outcome)) in simulations.iter_mut().zip(outcomes).enumerate()
            {
                if self.ended[number].is_none() {
                    self.ended[number] = self.take(simulation.borrow_mut(), &outcome, batch).err();
                }
            }
            let found = self.checker.result();
            self.refuse_difference(found)?;
            left -= batch;
        }
        Ok(&self.ended)
    }

    /// Waits for the check that is under way.
    ///
    /// # Errors
    /// [`GpuError::Differs`].
    pub fn finish_check(&mut self) -> Result<(), GpuError> {
        let found = self.checker.wait();
        self.refuse_difference(found)
    }

    /// The number of the simulation whose next step is to be checked, if it is time to check one.
    fn due<S: Borrow<Simulation<f32>>>(&self, simulations: &[S]) -> Option<usize> {
        let going = |number: &usize| self.ended[*number].is_none();
        let turn = (0..simulations.len()).map(|number| (self.begun + number) % simulations.len());
        let number = turn.into_iter().find(going)?;
        self.checker.is_due(simulations[number].borrow().steps()).then_some(number)
    }

    /// Begins to check a step from the state of a simulation to another.
    fn check(&mut self, simulation: &Simulation<f32>, after: &State<f32>) {
        // Another one than the last.
        self.checker.renew();
        self.checker.begin(simulation, after);
    }

    fn refuse_difference(&self, found: Option<Difference>) -> Result<(), GpuError> {
        let Some(Difference { steps, particle, .. }) = found else { return Ok(()) };
        let adapter = self.instances.device().name();
        Err(GpuError::Differs { adapter, step: steps + 1, particle })
    }

    /// Puts the outcome of a batch into a simulation. The processor takes the steps from one that
    /// the device refused on.
    fn take(
        &mut self,
        simulation: &mut Simulation<f32>,
        outcome: &Outcome,
        batch: u64,
    ) -> Result<(), Error> {
        outcome.put_into(simulation)?;
        self.tally.device += outcome.steps;
        for _ in outcome.steps..batch {
            simulation.step()?;
            self.tally.processor += 1;
        }
        Ok(())
    }
}

/// Refuses simulations with queued interactions or pushes: these act on one step of one of them.
fn refuse_input<S: Borrow<Simulation<f32>>>(simulations: &[S]) -> Result<(), GpuError> {
    let has_input = |simulation: &S| {
        let simulation: &Simulation<f32> = simulation.borrow();
        !simulation.queued().is_empty() || !simulation.model().pushes().is_empty()
    };
    if simulations.iter().any(has_input) {
        return Err(GpuError::Unsupported("queued interactions in an ensemble".to_owned()));
    }
    Ok(())
}
