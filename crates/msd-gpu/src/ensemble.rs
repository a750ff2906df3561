//! Many simulations of one method at once on a device: sweeps and studies of small scenes.

use crate::device::Device;
use crate::error::GpuError;
use crate::instances::{Instances, Outcome};
use crate::simulation::{MOST_STEPS, Tally, prepare};
use msd_core::{Error, Settings, Simulation};

/// Simulations on a device that step together. They may differ in all but the method and the number
/// of substeps. Equal tables of springs are stored once.
///
/// A small scene does not fill a device: a substep takes as long as the latency of the device. Many
/// small scenes take hardly longer than one. The processor repeats none of their steps as a check.
#[derive(Debug)]
pub struct Ensemble {
    instances: Instances,
    /// Why instances ended early.
    ended: Vec<Option<Error>>,
    tally: Tally,
}

impl Ensemble {
    /// Prepares a device to step simulations.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if there are no simulations, or if they have several methods or
    /// numbers of substeps; otherwise see [`crate::GpuSimulation::new`].
    pub async fn new(device: &Device, simulations: &[Simulation<f32>]) -> Result<Self, GpuError> {
        let of = |simulation: &Simulation<f32>| {
            let Settings { integrator, substeps, .. } = simulation.settings();
            (integrator, substeps)
        };
        let [first, rest @ ..] = simulations else {
            return Err(GpuError::Unsupported("an ensemble of no scenes".to_owned()));
        };
        refuse_input(simulations)?;
        if rest.iter().any(|other| of(other) != of(first)) {
            let reason = "an ensemble of several methods or numbers of substeps".to_owned();
            return Err(GpuError::Unsupported(reason));
        }
        Ok(Ensemble {
            instances: prepare(device, simulations).await?,
            ended: vec![None; simulations.len()],
            tally: Tally::default(),
        })
    }

    /// The steps of all simulations so far, by who took them; none of them is checked.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Advances all simulations by a number of steps, and returns why some of them ended early.
    /// Those keep their last good state, as on the processor.
    ///
    /// Pass the simulations that the device was prepared for; only their states may differ. The
    /// ledger of each holds NaN after steps on the device.
    ///
    /// # Errors
    /// [`GpuError::Lost`]; each simulation then stands at the last state that was read back.
    pub fn advance(
        &mut self,
        simulations: &mut [Simulation<f32>],
        steps: u64,
    ) -> Result<&[Option<Error>], GpuError> {
        refuse_input(simulations)?;
        let mut left = steps;
        while 0 < left {
            self.instances.device().check_lost()?;
            let batch = left.min(MOST_STEPS);
            for (number, simulation) in simulations.iter().enumerate() {
                self.instances.load(number, simulation);
            }
            self.instances.submit(batch);
            let outcomes = self.instances.wait()?;
            for (number, (simulation, outcome)) in simulations.iter_mut().zip(outcomes).enumerate()
            {
                if self.ended[number].is_none() {
                    self.ended[number] = self.take(simulation, &outcome, batch).err();
                }
            }
            left -= batch;
        }
        Ok(&self.ended)
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
fn refuse_input(simulations: &[Simulation<f32>]) -> Result<(), GpuError> {
    let has_input = |simulation: &Simulation<f32>| {
        !simulation.queued().is_empty() || !simulation.model().pushes().is_empty()
    };
    if simulations.iter().any(has_input) {
        return Err(GpuError::Unsupported("queued interactions in an ensemble".to_owned()));
    }
    Ok(())
}
