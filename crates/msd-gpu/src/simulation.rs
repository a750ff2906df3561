//! A simulation that a device steps, and what it leaves to the processor.

#[cfg(not(target_arch = "wasm32"))]
use crate::check::{Checker, Difference};
use crate::device::{Device, Programs, STRIDE};
use crate::error::GpuError;
use crate::rows::Rows;
use crate::shader::{Kind, MOST_PLANES, THREADS};
use bytemuck::{Pod, Zeroable, cast_slice, pod_read_unaligned};
use msd_core::glam::Vec3A;
use msd_core::laws::PlaneLaw;
use msd_core::{Grab, Interaction, Ledger, Model, Settings, Simulation, State, Vector};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePass};

/// The most grabs: each particle looks through them.
const MOST_GRABS: usize = 64;
/// Evaluations of springs in a batch of steps: a fraction of a second of a slow device, so that no
/// driver resets it.
const BATCH: u64 = 200_000_000;
/// Steps of a batch at most: between two of them a step may be checked.
const MOST_STEPS: u64 = 64;
/// Steps that the processor takes after one that the device refused, at most.
const MOST_PATIENCE: u64 = 64;

/// The same as in `step.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Params {
    gravity: [f32; 4],
    force: [f32; 4],
    h: f32,
    half: f32,
    quarter: f32,
    sixth: f32,
    drag: f32,
    lag: f32,
    extent: u32,
    speed: u32,
    count: u32,
    planes: u32,
    grabs: u32,
    substeps: u32,
}

/// A simulation on a device.
///
/// The processor's [`Simulation`] keeps the model, the queue, the ledger and the last state that
/// was read back. The device takes batches of steps of it. A step that it cannot take to the bit,
/// such as one in which a particle meets several planes, it refuses before anything of it counts,
/// and the processor takes it.
#[derive(Debug)]
pub struct GpuSimulation {
    device: Device,
    kind: Kind,
    bounces: bool,
    programs: Programs,
    settings: Settings,
    buffers: Buffers,
    constants: BindGroup,
    /// From the first state to the second, and back.
    ways: [BindGroup; 2],
    numbers: BindGroup,
    /// The state that is current.
    current: usize,
    count: usize,
    evaluations: u64,
    pending: Option<Pending>,
    /// Steps that the processor takes after the next one that is refused, and those left of them.
    patience: (u64, u64),
    tally: Tally,
    #[cfg(not(target_arch = "wasm32"))]
    checker: Checker,
    /// Whether the batch under way is a step that is to be checked.
    is_checked: bool,
    /// The grabs at the last batch.
    grabs: Vec<Grab<f32>>,
}

#[derive(Debug)]
struct Buffers {
    params: Buffer,
    grabs: Buffer,
    states: [Buffer; 2],
    own: Buffer,
    flags: Buffer,
    good: Buffer,
    staging: Buffer,
}

/// Steps that are being computed.
#[derive(Debug)]
struct Pending {
    steps: u64,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

/// The steps of a simulation by who took them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Those of the device.
    pub device: u64,
    /// Those that it left to the processor.
    pub processor: u64,
    /// Those of the device that the processor has taken again, with the same bits.
    pub checked: u64,
}

/// Steps that were computed.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The number of them.
    pub steps: u64,
    /// Whether the device refused the step after them.
    pub refused: bool,
    /// The state after them, in the order of the scene.
    pub state: State<f32>,
}

impl GpuSimulation {
    /// Prepares a device to step a simulation.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] with the reason, [`GpuError::TooLarge`], [`GpuError::Refused`] or
    /// [`GpuError::Lost`].
    pub async fn new(device: &Device, simulation: &Simulation<f32>) -> Result<Self, GpuError> {
        if let Some(reason) = unsupported(simulation) {
            return Err(GpuError::Unsupported(reason));
        }
        device.checked(|| Self::prepare(device, simulation)).await
    }

    fn prepare(device: &Device, simulation: &Simulation<f32>) -> Result<Self, GpuError> {
        let (model, settings) = (simulation.model(), simulation.settings());
        let kind = Kind::of(settings.integrator).expect("a method that is supported");
        let bounces = model.planes().iter().any(|plane| plane.restitution() != 0.0);
        let rows = Rows::new(model);
        let count = model.particle_count();
        let bytes = 32 * count.max(1) as u64;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let state = || device.empty("positions and velocities", bytes, storage);
        let staging = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let substeps = settings.substeps;
        let buffers = Buffers {
            params: device.uniform("parameters", &[params(simulation, kind)]),
            grabs: device.storage("grabs", &[[0u32; 4]; 2 * MOST_GRABS])?,
            states: [state()?, state()?],
            own: device.storage("work columns", &own_columns(model, kind, bounces))?,
            flags: device.storage("flags", &vec![0u32; 2 + 2 * substeps as usize])?,
            good: state()?,
            staging: device.empty("read-back", bytes + 8, staging)?,
        };
        let planes = device.uniform("planes", &planes(model));
        let topology = device.storage("rows of springs", &rows.topology)?;
        let springs = device.storage("laws of springs", &rows.springs)?;
        let number_buffer = device.uniform("numbers of substeps", &numbers(substeps));
        let [of_constants, of_states, of_numbers] = device.layouts();
        let all = [device.exact(), &buffers.params, &planes, &topology, &springs, &buffers.grabs];
        let way = |from: usize| {
            let Buffers { states, own, flags, good, .. } = &buffers;
            device.group(of_states, &[&states[from], &states[1 - from], own, flags, good])
        };
        let per_evaluation = model.spring_count() + count;
        let per_substep = if kind == Kind::Rk4 { 4 } else { 1 };
        Ok(GpuSimulation {
            constants: device.group(of_constants, &all),
            ways: [way(0), way(1)],
            numbers: device.dynamic_group(of_numbers, &number_buffer),
            programs: device.programs(kind, bounces),
            device: device.clone(),
            kind,
            bounces,
            settings,
            buffers,
            current: 0,
            count,
            evaluations: (per_evaluation as u64 * per_substep * u64::from(substeps)).max(1),
            pending: None,
            patience: (1, 0),
            tally: Tally::default(),
            #[cfg(not(target_arch = "wasm32"))]
            checker: Checker::new(),
            is_checked: false,
            grabs: model.grabs().to_vec(),
        })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The steps so far by who took them.
    pub fn tally(&self) -> Tally {
        #[cfg(not(target_arch = "wasm32"))]
        return Tally { checked: self.checker.checked(), ..self.tally };
        #[cfg(target_arch = "wasm32")]
        self.tally
    }

    /// The current positions, four numbers of which the last is a reciprocal mass, and velocities,
    /// of which the last is a mass, in turn: 32 bytes for each particle.
    pub fn state_buffer(&self) -> &Buffer {
        &self.buffers.states[self.current]
    }

    /// The steps of a batch.
    pub fn batch(&self) -> u64 {
        (BATCH / self.evaluations).clamp(1, MOST_STEPS)
    }

    /// Advances by so many steps, and waits for them.
    ///
    /// The simulation must be that which the device was prepared for, or one that differs from it
    /// in state, grabs and queue alone. The energy that steps on a device dissipate is not
    /// measured: the ledger of the simulation then holds NaN.
    ///
    /// # Errors
    /// [`GpuError::Step`] for a step that fails, as on the processor; the steps before it are
    /// taken. [`GpuError::Lost`] or [`GpuError::Refused`]: the simulation then stands at the last
    /// state that was read back, and the processor may go on.
    #[cfg(not(target_arch = "wasm32"))]
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

    /// Begins a batch of at most so many steps from the current state. Returns false where the next
    /// step is the processor's.
    ///
    /// # Errors
    /// See [`GpuSimulation::advance`].
    pub fn begin(&mut self, simulation: &mut Simulation<f32>, most: u64) -> Result<bool, GpuError> {
        self.device.check_lost()?;
        if 0 < self.patience.1 {
            self.patience.1 -= 1;
            return Ok(false);
        }
        if !takes_queue(simulation) {
            return Ok(false);
        }
        simulation.apply_queued()?;
        self.load(simulation);
        #[cfg(not(target_arch = "wasm32"))]
        {
            self.is_checked = self.checker.is_due(simulation.steps());
        }
        self.submit(if self.is_checked { 1 } else { most.min(self.batch()) });
        Ok(true)
    }

    /// Takes a step by the processor, and prepares the device anew where what is queued changes the
    /// model.
    ///
    /// # Errors
    /// See [`Simulation::step`] and [`GpuSimulation::new`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn step_on_processor(&mut self, simulation: &mut Simulation<f32>) -> Result<(), GpuError> {
        let is_changed = simulation.queued().iter().any(changes_model);
        if !simulation.queued().is_empty() {
            self.checker.renew();
        }
        simulation.step()?;
        self.tally.processor += 1;
        if is_changed {
            let mut renewed = pollster::block_on(Self::new(&self.device, simulation))?;
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
    #[cfg(not(target_arch = "wasm32"))]
    pub fn take(
        &mut self,
        simulation: &mut Simulation<f32>,
        outcome: &Outcome,
    ) -> Result<(), GpuError> {
        self.check(simulation, outcome)?;
        if 0 < outcome.steps {
            simulation.set_state(&outcome.state, simulation.steps() + outcome.steps)?;
            simulation.set_ledger(Ledger::of(f64::NAN));
            self.tally.device += outcome.steps;
        }
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
    #[cfg(not(target_arch = "wasm32"))]
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
    /// [`GpuError::Differs`]: the simulation then stands before the step that differs.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn finish_check(&mut self, simulation: &mut Simulation<f32>) -> Result<(), GpuError> {
        let found = self.checker.wait();
        self.refuse_difference(simulation, found)
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn refuse_difference(
        &self,
        simulation: &mut Simulation<f32>,
        found: Option<Difference>,
    ) -> Result<(), GpuError> {
        let Some(Difference { before, steps, particle }) = found else { return Ok(()) };
        simulation.set_state(&before, steps)?;
        Err(GpuError::Differs { adapter: self.device.name(), step: steps + 1, particle })
    }

    /// Uploads state and grabs.
    fn load(&mut self, simulation: &Simulation<f32>) {
        if self.grabs != simulation.model().grabs() {
            self.grabs = simulation.model().grabs().to_vec();
            #[cfg(not(target_arch = "wasm32"))]
            self.checker.renew();
        }
        let (model, state) = (simulation.model(), simulation.state());
        let rows = state.positions.iter().zip(&state.velocities);
        let masses = model.inverse_masses().iter().zip(model.masses());
        let numbers: Vec<[f32; 8]> = rows
            .zip(masses)
            .map(|((x, v), (&w, &m))| [x.x, x.y, x.z, w, v.x, v.y, v.z, m])
            .collect();
        let queue = &self.device.queue;
        queue.write_buffer(&self.buffers.states[self.current], 0, cast_slice(&numbers));
        let of_grab = |grab: &Grab<f32>| {
            let [x, y, z] = grab.target.components();
            let law = [grab.stiffness, grab.damping, grab.max_force, 0.0];
            let [x, y, z] = [x, y, z].map(f32::to_bits);
            [[x, y, z, grab.particle], law.map(f32::to_bits)]
        };
        let grabs: Vec<[u32; 4]> = model.grabs().iter().flat_map(of_grab).collect();
        queue.write_buffer(&self.buffers.grabs, 0, cast_slice(&grabs));
        let params = params(simulation, self.kind);
        queue.write_buffer(&self.buffers.params, 0, cast_slice(&[params]));
        queue.write_buffer(&self.buffers.flags, 0, cast_slice(&[0u32; 2]));
    }

    /// Submits steps, and the read-back of the state after them.
    fn submit(&mut self, steps: u64) {
        let mut encoder = self.device.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder, steps);
        let Buffers { states, flags, staging, .. } = &self.buffers;
        encoder.copy_buffer_to_buffer(flags, 0, staging, 0, HEAD);
        let state = states[self.current].clone();
        self.read_back(encoder, &state, steps);
    }

    /// Submits commands and the read-back of a state.
    fn read_back(&mut self, mut encoder: CommandEncoder, state: &Buffer, steps: u64) {
        let staging = &self.buffers.staging;
        encoder.copy_buffer_to_buffer(state, 0, staging, HEAD, 32 * self.count as u64);
        self.device.queue.submit([encoder.finish()]);
        let (send, mapped) = channel();
        // Nobody listens any more where the simulation is gone.
        staging.map_async(wgpu::MapMode::Read, .., move |result| drop(send.send(result)));
        self.pending = Some(Pending { steps, mapped });
    }

    /// Waits for the batch that was begun.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait(&mut self) -> Result<Outcome, GpuError> {
        loop {
            // A failure to wait shows in the outcome.
            drop(self.device.device.poll(wgpu::PollType::wait_indefinitely()));
            if let Some(outcome) = self.poll()? {
                return Ok(outcome);
            }
        }
    }

    /// The outcome of the batch that was begun, once it is there; never blocks.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    ///
    /// # Panics
    /// If none was begun.
    pub fn poll(&mut self) -> Result<Option<Outcome>, GpuError> {
        drop(self.device.device.poll(wgpu::PollType::Poll));
        let pending = self.pending.take().expect("a batch that was begun");
        match pending.mapped.try_recv() {
            Ok(Ok(())) => {}
            Err(TryRecvError::Empty) => {
                self.device.check_lost()?;
                self.pending = Some(pending);
                return Ok(None);
            }
            Ok(Err(_)) | Err(TryRecvError::Disconnected) => {
                self.device.check_lost()?;
                let reason = "the state cannot be read back".to_owned();
                return Err(GpuError::Lost { adapter: self.device.name(), reason });
            }
        }
        let (flags, state) = self.read();
        let [refused, begun] = flags.map(u64::from);
        if refused == 0 {
            return Ok(Some(Outcome { steps: pending.steps, refused: false, state }));
        }
        if pending.steps != REFUSED {
            let encoder = self.device.device.create_command_encoder(&Default::default());
            let good = self.buffers.good.clone();
            self.read_back(encoder, &good, REFUSED);
            return Ok(None);
        }
        Ok(Some(Outcome { steps: begun - 1, refused: true, state }))
    }

    /// The flags and the state that were read back.
    fn read(&self) -> ([u32; 2], State<f32>) {
        let staging = &self.buffers.staging;
        let bytes = staging.get_mapped_range(..).expect("a buffer that is mapped");
        let (head, rows) = bytes.split_at(HEAD as usize);
        let flags = [0, 1].map(|at| pod_read_unaligned(&head[4 * at..4 * at + 4]));
        let rows = rows[..32 * self.count].chunks_exact(32).map(pod_read_unaligned::<[f32; 8]>);
        let vector = |row: &[f32; 8], at: usize| Vec3A::new(row[at], row[at + 1], row[at + 2]);
        let mut state = State::default();
        for row in rows {
            state.positions.push(vector(&row, 0));
            state.velocities.push(vector(&row, 4));
        }
        drop(bytes);
        staging.unmap();
        (flags, state)
    }

    /// Records steps.
    pub(crate) fn encode(&mut self, encoder: &mut CommandEncoder, steps: u64) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, &self.constants, &[]);
        let substeps = self.settings.substeps;
        let each = 0..substeps;
        for _ in 0..steps {
            self.dispatch(&mut pass, "clear_flags", 0);
            self.dispatch(&mut pass, "begin_step", 0);
            match self.kind {
                Kind::Explicit | Kind::Symplectic => {
                    each.clone().for_each(|n| self.move_on(&mut pass, "advance", n));
                }
                Kind::Verlet if self.bounces => each.clone().for_each(|n| {
                    self.move_on(&mut pass, "first_part", n);
                    self.move_on(&mut pass, "last_part", n);
                }),
                Kind::Verlet => {
                    self.move_on(&mut pass, "first_part", 0);
                    let both = substeps..2 * substeps - 1;
                    both.for_each(|n| self.move_on(&mut pass, "both_parts", n));
                    self.move_on(&mut pass, "last_part", substeps - 1);
                }
                Kind::Rk4 => each.clone().for_each(|n| {
                    self.dispatch(&mut pass, "find_resting", n);
                    let stages = ["stage_1", "stage_2", "stage_3", "stage_4"];
                    stages.into_iter().for_each(|stage| self.move_on(&mut pass, stage, n));
                }),
            }
        }
    }

    /// Records a program that writes the next state.
    fn move_on(&mut self, pass: &mut ComputePass<'_>, program: &str, number: u32) {
        self.dispatch(pass, program, number);
        self.current = 1 - self.current;
    }

    fn dispatch(&self, pass: &mut ComputePass<'_>, program: &str, number: u32) {
        pass.set_pipeline(&self.programs[program]);
        pass.set_bind_group(1, &self.ways[self.current], &[]);
        pass.set_bind_group(2, &self.numbers, &[number * STRIDE as u32]);
        let groups = if program == "clear_flags" { 1 } else { self.count.div_ceil(THREADS) as u32 };
        pass.dispatch_workgroups(groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1);
    }
}

/// Bytes of the flags before the state that is read back.
const HEAD: u64 = 8;
/// Workgroups along an axis; as in `step.wgsl`.
const MOST_GROUPS: u32 = 65535;
/// In place of a number of steps: the state before a step that was refused is read back.
const REFUSED: u64 = u64::MAX;

/// What of a simulation a device does not step.
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
        (simulation.has_own_method(), "a user-defined method"),
        (0 < model.bends().count(), "bends"),
        (0 < model.volumes().count(), "volumes"),
        (model.air().is_some(), "air"),
        (0 < own, "user-defined elements"),
        (!model.shells().is_empty(), "bodies that meet each other or have a thickness"),
        (!model.solids().is_empty(), "solids other than planes"),
        (0 < own_obstacles, "user-defined obstacles"),
        (0 < guides, "guided pins"),
    ];
    let kind = kinds.into_iter().find(|(is_there, _)| *is_there);
    kind.map(|(_, what)| what.to_owned())
        .or_else(|| many(model.planes().len(), MOST_PLANES, "planes"))
        .or_else(|| many(model.grabs().len(), MOST_GRABS, "grabs"))
}

/// Whether the device can take the next step: what is queued changes grabs alone, and no push acts.
fn takes_queue(simulation: &Simulation<f32>) -> bool {
    use Interaction::{Grab, Release};
    let is_hand = |interaction: &Interaction| matches!(interaction, Grab { .. } | Release { .. });
    let model = simulation.model();
    let grabs = model.grabs().len() + simulation.queued().len();
    simulation.queued().iter().all(is_hand) && model.pushes().is_empty() && grabs <= MOST_GRABS
}

/// Whether an interaction changes what a device was prepared with.
fn changes_model(interaction: &Interaction) -> bool {
    use Interaction::{AddPlane, RemovePlanes, SetPlane};
    let effects = interaction.effects();
    let is_of_planes = matches!(interaction, AddPlane { .. } | RemovePlanes | SetPlane { .. });
    effects.springs || effects.masses || is_of_planes
}

fn params(simulation: &Simulation<f32>, kind: Kind) -> Params {
    let (model, settings) = (simulation.model(), simulation.settings());
    let h = settings.substep() as f32;
    // As the guard of the core.
    let crossing = 2.0 * f64::from(model.extent()) / settings.substep();
    let wide = |vector: Vec3A| [vector.x, vector.y, vector.z, 0.0];
    Params {
        gravity: wide(model.gravity()),
        force: wide(model.force()),
        h,
        half: h * 0.5,
        quarter: h * 0.5 * 0.5,
        sixth: h / 6.0,
        drag: model.drag(),
        lag: h * kind.lag(),
        extent: model.extent().to_bits(),
        speed: (crossing as f32).min(f32::MAX).to_bits(),
        count: model.particle_count() as u32,
        planes: model.planes().len() as u32,
        grabs: model.grabs().len() as u32,
        substeps: settings.substeps,
    }
}

fn planes(model: &Model<f32>) -> [[[f32; 4]; 2]; MOST_PLANES] {
    let mut planes = [[[0.0; 4]; 2]; MOST_PLANES];
    for (to, plane) in planes.iter_mut().zip(model.planes()) {
        let PlaneLaw { normal: [x, y, z], offset, restitution, friction, loss } = plane.into();
        *to = [[x, y, z, offset], [restitution, friction, loss, 0.0]];
    }
    planes
}

/// The work columns of a method, with the stiffness of all springs at each particle where something
/// bounces.
fn own_columns(model: &Model<f32>, kind: Kind, bounces: bool) -> Vec<[f32; 4]> {
    let columns = kind.columns();
    let mut own = vec![[0.0; 4]; columns * model.particle_count().max(1)];
    if bounces {
        for (spring, ends) in model.springs().present() {
            for end in ends {
                own[columns * end][3] += model.stiffness(spring);
            }
        }
    }
    own
}

/// For each substep its number twice, then for each its number and the next: those that a program
/// ends and begins.
fn numbers(substeps: u32) -> Vec<[u32; STRIDE as usize / 4]> {
    let pair = |ends: u32, begins: u32| {
        let mut numbers = [0; STRIDE as usize / 4];
        numbers[..2].copy_from_slice(&[ends, begins]);
        numbers
    };
    let alone = (0..substeps).map(|n| pair(n, n));
    alone.chain((0..substeps).map(|n| pair(n, n + 1))).collect()
}
