//! A simulation that a device steps, and what it leaves to the processor.

use crate::check::{Checker, Difference};
use crate::device::{Answer, Device};
use crate::error::GpuError;
use crate::instances::{Instances, MOST_GRABS, Outcome};
use crate::shader::{Kind, MOST_PLANES};
use msd_core::{Grab, Interaction, Simulation};
use wgpu::Buffer;

/// The most substeps of a step: each has numbers of its own.
const MOST_SUBSTEPS: u32 = 10_000;
/// Steps from one read-back to the next at most: after each a step may be checked.
pub const MOST_STEPS: u64 = 64;
/// Steps that the processor takes after one that the device refused, at most.
const MOST_PATIENCE: u64 = 64;

/// A simulation on a device.
///
/// The processor's [`Simulation`] keeps the model, the queue, the ledger and the last state that
/// was read back. The device takes up to 64 steps from one read-back to the next, and its state is
/// uploaded only where the simulation has another. It refuses a step that it cannot take with
/// the same bits, such as one in which a particle touches several planes. The processor takes that
/// step from the state before it.
#[derive(Debug)]
pub struct GpuSimulation {
    instances: Instances,
    /// Whether the device accepts what it was prepared with, until that is known.
    answer: Option<Answer>,
    /// Steps that the processor takes after the next one that is refused, and those left of them.
    patience: (u64, u64),
    tally: Tally,
    checker: Checker,
    /// Whether the batch under way is a step that is to be checked.
    is_checked: bool,
    /// The grabs at the last batch.
    grabs: Vec<Grab<f32>>,
}

/// The steps of a simulation by who took them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Steps of the device.
    pub device: u64,
    /// Steps that the device left to the processor.
    pub processor: u64,
    /// Steps of the device that the processor has repeated and compared.
    pub checked: u64,
}

impl GpuSimulation {
    /// Prepares a device to step a simulation.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] with the reason, [`GpuError::TooLarge`], [`GpuError::Refused`] or
    /// [`GpuError::Lost`].
    pub async fn new(device: &Device, simulation: &Simulation<f32>) -> Result<Self, GpuError> {
        let mut new = Self::prepare(device, simulation)?;
        if let Some(answer) = new.answer.take() {
            answer.await?;
        }
        Ok(new)
    }

    /// Prepares a device to step a simulation, without waiting for its answer. Until a browser has
    /// accepted buffers and programs, [`GpuSimulation::begin`] leaves steps to the processor.
    ///
    /// # Errors
    /// See [`GpuSimulation::new`].
    pub fn prepare(device: &Device, simulation: &Simulation<f32>) -> Result<Self, GpuError> {
        Self::check_supported(simulation)?;
        let (instances, answer) = device.attempt(|| Instances::prepare(device, &[simulation]))?;
        let mut new = GpuSimulation {
            instances,
            answer: Some(answer),
            patience: (1, 0),
            tally: Tally::default(),
            checker: Checker::new(),
            is_checked: false,
            grabs: simulation.model().grabs().to_vec(),
        };
        new.is_accepted()?;
        Ok(new)
    }

    /// Whether the device has accepted what it was prepared with.
    fn is_accepted(&mut self) -> Result<bool, GpuError> {
        let Some(answer) = &mut self.answer else { return Ok(true) };
        let Some(answered) = answer.now() else { return Ok(false) };
        self.answer = None;
        answered.map(|()| true)
    }

    /// Refuses a simulation that a device does not step, whatever the device.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] with the reason.
    pub fn check_supported(simulation: &Simulation<f32>) -> Result<(), GpuError> {
        unsupported(simulation).map_or(Ok(()), |reason| Err(GpuError::Unsupported(reason)))
    }

    /// The device.
    pub fn device(&self) -> &Device {
        self.instances.device()
    }

    /// The steps so far by who took them.
    pub fn tally(&self) -> Tally {
        Tally { checked: self.checker.checked(), ..self.tally }
    }

    /// The current state, eight `f32` or 32 bytes for each particle: x, y, z, reciprocal mass, vx,
    /// vy, vz, mass.
    pub fn state_buffer(&self) -> &Buffer {
        self.instances.state_buffer()
    }

    /// Advances by a number of steps, and waits for them.
    ///
    /// Pass the simulation that the device was prepared for; only state, grabs and queue may
    /// differ. A device does not measure the dissipated energy: after its steps, the ledger of the
    /// simulation holds NaN.
    ///
    /// # Errors
    /// [`GpuError::Step`] for a step that fails, as on the processor; the steps before it are
    /// taken. [`GpuError::Lost`] or [`GpuError::Refused`]: the simulation keeps the last state that
    /// was read back, and the processor may continue. [`GpuError::Differs`]: a check failed, and
    /// the simulation has the state before the step that differs.
    pub fn advance(
        &mut self,
        simulation: &mut Simulation<f32>,
        steps: u64,
    ) -> Result<(), GpuError> {
        let last = simulation.steps() + steps;
        while simulation.steps() < last {
            if !self.begin(simulation, last - simulation.steps())? {
                self.step_on_processor(simulation)?;
                continue;
            }
            let outcome = self.wait()?;
            self.take(simulation, &outcome)?;
        }
        Ok(())
    }

    /// Notes that forces, masses or pins were changed other than through the queue.
    pub fn renew_check(&mut self) {
        self.instances.forget();
        self.checker.renew();
    }

    /// Begins at most `most` steps from the current state. Returns false if the processor must take
    /// the next step.
    ///
    /// # Errors
    /// See [`GpuSimulation::advance`].
    pub fn begin(&mut self, simulation: &mut Simulation<f32>, most: u64) -> Result<bool, GpuError> {
        self.device().check_lost()?;
        if 0 < self.patience.1 {
            self.patience.1 -= 1;
            return Ok(false);
        }
        if !self.is_accepted()? || !can_take(simulation) {
            return Ok(false);
        }
        self.load(simulation);
        self.is_checked = self.checker.is_due(simulation.steps());
        self.instances.submit(if self.is_checked { 1 } else { most.min(MOST_STEPS) });
        Ok(true)
    }

    /// Takes a step on the processor, and prepares the device again if the queue changes the model.
    ///
    /// # Errors
    /// See [`Simulation::step`] and [`GpuSimulation::new`].
    pub fn step_on_processor(&mut self, simulation: &mut Simulation<f32>) -> Result<(), GpuError> {
        let is_changed = simulation.queued().iter().any(changes_model);
        if !simulation.queued().is_empty() {
            self.checker.renew();
        }
        simulation.step()?;
        self.tally.processor += 1;
        if is_changed {
            let mut renewed = Self::prepare(self.device(), simulation)?;
            std::mem::swap(&mut renewed.checker, &mut self.checker);
            (renewed.tally, renewed.patience) = (self.tally, self.patience);
            *self = renewed;
        }
        Ok(())
    }

    /// Puts the outcome of a batch into its simulation, and lets the processor take the step that
    /// the device refused.
    ///
    /// # Errors
    /// See [`GpuSimulation::advance`].
    pub fn take(
        &mut self,
        simulation: &mut Simulation<f32>,
        outcome: &Outcome,
    ) -> Result<(), GpuError> {
        self.check(simulation, outcome)?;
        outcome.put_into(simulation)?;
        self.tally.device += outcome.steps;
        if !outcome.refused {
            self.patience = (1, 0);
            return Ok(());
        }
        // Particles in a corner stay there for a while.
        let (next, _) = if outcome.steps == 0 { self.patience } else { (1, 0) };
        self.patience = ((2 * next).min(MOST_PATIENCE), next - 1);
        self.step_on_processor(simulation)
    }

    /// Begins the check of a step that was to be checked, and ends a run in which an earlier one
    /// has found a difference: the simulation then stands before that step.
    fn check(
        &mut self,
        simulation: &mut Simulation<f32>,
        outcome: &Outcome,
    ) -> Result<(), GpuError> {
        if std::mem::take(&mut self.is_checked) && outcome.steps == 1 {
            self.checker.begin(simulation, &outcome.state);
        }
        let found = self.checker.result();
        self.refuse_difference(simulation, found)
    }

    /// Waits for the check that is under way.
    ///
    /// # Errors
    /// [`GpuError::Differs`]: the simulation has the state before the step that differs.
    pub fn finish_check(&mut self, simulation: &mut Simulation<f32>) -> Result<(), GpuError> {
        let found = self.checker.wait();
        self.refuse_difference(simulation, found)
    }

    fn refuse_difference(
        &self,
        simulation: &mut Simulation<f32>,
        found: Option<Difference>,
    ) -> Result<(), GpuError> {
        let Some(Difference { before, steps, particle }) = found else { return Ok(()) };
        simulation.set_state(&before, steps)?;
        Err(GpuError::Differs { adapter: self.device().name(), step: steps + 1, particle })
    }

    /// Uploads state and grabs.
    fn load(&mut self, simulation: &Simulation<f32>) {
        if self.grabs != simulation.model().grabs() {
            self.grabs = simulation.model().grabs().to_vec();
            self.checker.renew();
        }
        self.instances.load(0, simulation);
    }

    /// Computes a number of steps from the current state of a simulation, and waits for them. It
    /// reads nothing back, for measurements of speed.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn compute(&mut self, simulation: &Simulation<f32>, steps: u64) -> Result<(), GpuError> {
        self.load(simulation);
        self.compute_on(steps)
    }

    /// Computes so many further steps from the state on the device, without an upload.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn compute_on(&mut self, steps: u64) -> Result<(), GpuError> {
        self.instances.submit_alone(steps);
        self.instances.idle()
    }

    /// Reads back the state after computed steps, and whether the device refused one. The device
    /// computes no step after a refused one.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn finish_computing(&mut self) -> Result<Outcome, GpuError> {
        self.instances.submit(0);
        self.wait()
    }

    /// Whether a batch was begun whose outcome was not fetched.
    pub fn is_begun(&self) -> bool {
        self.instances.is_pending()
    }

    /// Waits for the batch that was begun.
    ///
    /// # Errors
    /// [`GpuError::Lost`], or [`GpuError::NoWait`] where nothing [can wait](crate::CAN_WAIT).
    ///
    /// # Panics
    /// If none was begun.
    pub fn wait(&mut self) -> Result<Outcome, GpuError> {
        self.instances.wait().map(|mut outcomes| outcomes.remove(0))
    }

    /// The outcome of the batch that was begun, once it is there; never blocks.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    ///
    /// # Panics
    /// If none was begun.
    pub fn poll(&mut self) -> Result<Option<Outcome>, GpuError> {
        Ok(self.instances.poll()?.map(|mut outcomes| outcomes.remove(0)))
    }
}

/// Prepares a device to step simulations.
pub async fn prepare(
    device: &Device,
    simulations: &[&Simulation<f32>],
) -> Result<Instances, GpuError> {
    if let Some(reason) = simulations.iter().find_map(|simulation| unsupported(simulation)) {
        return Err(GpuError::Unsupported(reason));
    }
    device.checked(|| Instances::prepare(device, simulations)).await
}

/// The first part of a simulation that a device does not step.
fn unsupported(simulation: &Simulation<f32>) -> Option<String> {
    let (model, settings) = (simulation.model(), simulation.settings());
    let [guides, own] = model.guide_and_own_counts();
    let own_obstacles = model.obstacles().count() - model.planes().len() - model.solids().len();
    let many = |count: usize, most: usize, what: &str| {
        (most < count).then(|| format!("more than {most} {what}"))
    };
    if Kind::of(settings.integrator).is_none() && !simulation.has_own_method() {
        return Some(format!("the method {}", settings.integrator.name()));
    }
    let kinds = [
        (model.particle_count() == 0, "a scene without particles"),
        (MOST_SUBSTEPS < settings.substeps, "more than 10 000 substeps"),
        (simulation.has_own_method(), "a user-defined method"),
        (model.bends().rows().any(|bend| bend.rest != 0.0), "bends that are curved at rest"),
        (0 < model.volumes().count(), "volumes"),
        (model.air().is_some(), "air"),
        (0 < own, "user-defined elements"),
        (!model.shells().is_empty(), "bodies that collide with each other or have a thickness"),
        (!model.solids().is_empty(), "solids other than planes"),
        (0 < own_obstacles, "user-defined obstacles"),
        (0 < guides, "pins that follow key frames or a solid"),
    ];
    let kind = kinds.into_iter().find(|(is_there, _)| *is_there);
    kind.map(|(_, what)| what.to_owned())
        .or_else(|| many(model.planes().len(), MOST_PLANES, "planes"))
        .or_else(|| many(model.grabs().len(), MOST_GRABS, "grabs"))
}

/// Whether the device can take the next step: the processor applies what is queued, so that a step
/// that fails leaves the queue, and pushes particles.
fn can_take(simulation: &Simulation<f32>) -> bool {
    let model = simulation.model();
    let is_alone = simulation.queued().is_empty() && model.pushes().is_empty();
    is_alone && model.grabs().len() <= MOST_GRABS
}

/// Whether an interaction changes what a device was prepared with.
fn changes_model(interaction: &Interaction) -> bool {
    use Interaction::{AddPlane, RemovePlanes, SetPlane};
    let effects = interaction.effects();
    let is_of_planes = matches!(interaction, AddPlane { .. } | RemovePlanes | SetPlane { .. });
    effects.springs || effects.masses || is_of_planes
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Material, Scene, Settings, shape, state_hash};

    /// Steps in many batches end as those in one do, from a state that was uploaded once.
    #[test]
    fn batches_follow_one_another_on_the_device() {
        let Ok(device) = pollster::block_on(Device::open("")) else {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter");
            return println!("SKIPPED: no adapter");
        };
        let cloth = shape::cloth([9, 7], 0.1, Material::default()).expect("a cloth");
        let scene = Scene::of("cloth", cloth);
        let start = Simulation::<f32>::new(&scene, Settings::default()).expect("a scene");
        let [mut whole, mut parts] = [start.clone(), start];
        for (simulation, batch) in [(&mut whole, 1000), (&mut parts, 3)] {
            let mut gpu = pollster::block_on(GpuSimulation::new(&device, simulation));
            let gpu = gpu.as_mut().expect("a scene for a device");
            gpu.instances.batch = batch;
            gpu.advance(simulation, 20).expect("a run");
            assert_eq!(gpu.tally().device, 20);
        }
        assert_eq!(state_hash(&whole.state()), state_hash(&parts.state()));
    }
}
