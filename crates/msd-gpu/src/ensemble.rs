//! Many simulations of one method at once on a device: sweeps and studies of small scenes.

use crate::device::Device;
use crate::error::GpuError;
use crate::instances::{Instances, Outcome};
use crate::simulation::{Tally, prepare, steps_of_batch};
use msd_core::{Error, Ledger, Settings, Simulation};

/// Simulations on a device that step together. They may differ in all but the method and the number
/// of substeps; springs that are alike are stored once.
///
/// Small scenes do not fill a device, and each substep takes as long as its latency. Many of them
/// take hardly longer than one.
#[derive(Debug)]
pub struct Ensemble {
    instances: Instances,
    /// Why instances ended early.
    ended: Vec<Option<Error>>,
    batch: u64,
    tally: Tally,
}

impl Ensemble {
    /// Prepares a device to step simulations.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for none, for those of several methods or numbers of substeps, and
    /// as of [`crate::GpuSimulation::new`].
    pub async fn new(device: &Device, simulations: &[Simulation<f32>]) -> Result<Self, GpuError> {
        let of = |simulation: &Simulation<f32>| {
            let Settings { integrator, substeps, .. } = simulation.settings();
            (integrator, substeps)
        };
        let [first, rest @ ..] = simulations else {
            return Err(GpuError::Unsupported("an ensemble of no scenes".to_owned()));
        };
        if rest.iter().any(|other| of(other) != of(first)) {
            let reason = "an ensemble of several methods or numbers of substeps".to_owned();
            return Err(GpuError::Unsupported(reason));
        }
        Ok(Ensemble {
            instances: prepare(device, simulations).await?,
            ended: vec![None; simulations.len()],
            batch: steps_of_batch(simulations),
            tally: Tally::default(),
        })
    }

    /// The steps so far by who took them, of all simulations together.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Advances all simulations by so many steps, and returns why some of them ended early. Those
    /// keep their last good state, as on the processor.
    ///
    /// They must be those that the device was prepared for, or differ from them in their states
    /// alone. The ledger of each holds NaN afterwards.
    ///
    /// # Errors
    /// [`GpuError::Lost`]; each simulation then stands at the last state that was read back.
    pub fn advance(
        &mut self,
        simulations: &mut [Simulation<f32>],
        steps: u64,
    ) -> Result<&[Option<Error>], GpuError> {
        let mut left = steps;
        while 0 < left {
            self.instances.device().check_lost()?;
            let batch = left.min(self.batch);
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
        if 0 < outcome.steps {
            simulation.set_state(&outcome.state, simulation.steps() + outcome.steps)?;
            simulation.set_ledger(Ledger::of(f64::NAN));
            self.tally.device += outcome.steps;
        }
        for _ in outcome.steps..batch {
            simulation.step()?;
            self.tally.processor += 1;
        }
        Ok(())
    }
}
