//! Steps of several instances of scenes at once on a device: buffers, programs, read-back.

use crate::check::first_difference;
use crate::device::{Device, Programs, STRIDE};
use crate::error::GpuError;
use crate::params::{Params, Place, params};
use crate::rows::{Rows, Structure};
use crate::shader::{Choice, Kind, THREADS};
use bytemuck::{Zeroable, bytes_of, cast_slice, pod_read_unaligned};
use msd_core::glam::Vec3A;
use msd_core::{Error, Grab, Integrator, Ledger, Model, Simulation, State, Vector};
use std::ops::Range;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePass};

/// The most grabs of an instance: each particle looks through them.
pub const MOST_GRABS: usize = 64;
/// Evaluations of springs in a batch of steps.
const BATCH: u64 = 200_000_000;
/// Bytes of a particle in a buffer of states.
const PARTICLE: u64 = 32;
/// Workgroups along an axis; as in `step.wgsl`.
const MOST_GROUPS: u32 = 65535;

/// Instances of scenes on a device, of one method and one number of substeps.
#[derive(Debug)]
pub struct Instances {
    device: Device,
    choice: Choice,
    substeps: u32,
    programs: Programs,
    buffers: Buffers,
    constants: BindGroup,
    /// From the first state to the second, and back.
    ways: [BindGroup; 2],
    numbers: BindGroup,
    /// The state that is current.
    current: usize,
    places: Vec<Place>,
    /// The states of instances on the device, where they are known: those need no upload.
    known: Vec<Option<State<f32>>>,
    slices: u32,
    /// Steps of a batch.
    pub(crate) batch: u64,
    pending: Option<Pending>,
}

#[derive(Debug)]
struct Buffers {
    params: Buffer,
    numbers: Buffer,
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
    /// The current states of instances, where the good ones are being read back.
    current: Option<Vec<State<f32>>>,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

/// Flags and states of all instances.
type ReadBack = (Vec<[u32; 2]>, Vec<State<f32>>);

/// Steps of an instance that were computed.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The number of steps.
    pub steps: u64,
    /// Whether the device refused the step after them.
    pub refused: bool,
    /// The state after the steps, particles in the order of the scene.
    pub state: State<f32>,
}

impl Outcome {
    /// Puts the state after the steps, if there are any, into their simulation. A device measures
    /// neither the dissipated energy, nor that which moving pins drive in, nor contacts. Particles
    /// may have touched any plane.
    pub(crate) fn put_into(&self, simulation: &mut Simulation<f32>) -> Result<(), Error> {
        if self.steps == 0 {
            return Ok(());
        }
        simulation.set_state(&self.state, simulation.steps() + self.steps)?;
        let moves = |(&w, &v): (&f32, &Vec3A)| w == 0.0 && v != Vec3A::ZERO;
        let mut pins = simulation.model().inverse_masses().iter().zip(&self.state.velocities);
        let given = if pins.any(moves) { f64::NAN } else { simulation.ledger().given() };
        simulation.set_ledger(Ledger::of(f64::NAN).with_given(given));
        let has_planes = !simulation.model().planes().is_empty();
        simulation.set_touched(has_planes);
        Ok(())
    }
}

/// Rows and numbers of instances, those that are alike once.
#[derive(Default)]
struct Assembly {
    structures: Vec<(Structure, u32)>,
    blocks: Vec<(Vec<[u32; 4]>, u32)>,
    /// First and last group, instance and lists of bends.
    slices: Vec<[u32; 4]>,
    numbers: Vec<[u32; 4]>,
}

impl Assembly {
    /// Adds the rows of an instance; returns the places of its laws and of its bends.
    fn add(&mut self, rows: Rows, instance: u32) -> [u32; 2] {
        let Rows { structure, numbers, bends_at } = rows;
        let known = self.structures.iter().position(|(known, _)| *known == structure);
        let at = known.unwrap_or_else(|| {
            let place = self.structures.last().map_or(0, |(last, place)| place + last.len());
            self.structures.push((structure, place));
            self.structures.len() - 1
        });
        let (structure, place) = &self.structures[at];
        self.slices.extend(structure.slices().map(|slice| {
            let [first, last, lists] = slice.map(|at| place + at);
            [first, last, instance, lists]
        }));
        let known = self.blocks.iter().find(|(known, _)| *known == numbers);
        let at = known.map(|(_, at)| *at).unwrap_or_else(|| {
            let at = self.numbers.len() as u32;
            self.numbers.extend(&numbers);
            self.blocks.push((numbers, at));
            at
        });
        [at, if bends_at == 0 { 0 } else { at + bends_at }]
    }

    /// The slices, and then all structures.
    fn topology(mut self) -> (Vec<u32>, Vec<[u32; 4]>) {
        let start = 4 * self.slices.len() as u32;
        for [first, last, _, lists] in &mut self.slices {
            for place in [first, last, lists] {
                *place += start;
            }
        }
        let placed = |(structure, place): &(Structure, u32)| structure.placed(start + place);
        let rest = self.structures.iter().flat_map(placed);
        (self.slices.into_iter().flatten().chain(rest).collect(), self.numbers)
    }
}

impl Instances {
    /// Prepares a device to step simulations that it supports, of one method and one number of
    /// substeps. At least one.
    pub fn prepare(device: &Device, all: &[&Simulation<f32>]) -> Result<Self, GpuError> {
        let settings = all[0].settings();
        let kind = Kind::of(settings.integrator).expect("a method that is supported");
        let bounce = |simulation: &&Simulation<f32>| {
            simulation.model().planes().iter().any(|plane| plane.restitution() != 0.0)
        };
        let bounces = all.iter().any(bounce);
        let bends = all.iter().any(|simulation| 0 < simulation.model().bends().count());
        let choice = Choice { kind, bounces, bends, are_several: 1 < all.len() };
        let (mut shared, mut places, mut own) = (Assembly::default(), Vec::new(), Vec::new());
        let flags = 2 + 2 * settings.substeps;
        for (number, simulation) in all.iter().enumerate() {
            let first = THREADS * shared.slices.len();
            let model = simulation.model();
            let [laws_at, bends_at] = shared.add(Rows::new(model), number as u32);
            let particles = first..first + model.particle_count();
            let flags_at = number as u32 * flags;
            places.push(Place { particles, laws_at, bends_at, grabs_at: 0, flags_at });
            own.resize(kind.columns() * first, [0.0; 4]);
            own.extend(own_columns(model, kind, bounces));
        }
        let slices = shared.slices.len() as u32;
        own.resize(kind.columns() * THREADS * slices as usize, [0.0; 4]);
        let (topology, mut numbers) = shared.topology();
        for place in &mut places {
            place.grabs_at = numbers.len() as u32;
            numbers.resize(numbers.len() + 2 * MOST_GRABS, [0; 4]);
        }
        let all_flags = flags * all.len() as u32;
        let buffers = Buffers::new(device, &numbers, &own, (slices, all_flags), all.len())?;
        let topology = device.storage("rows of springs", &topology)?;
        let of_substeps = substep_numbers(settings.substeps, [slices, all.len() as u32]);
        let of_substeps = device.uniform("numbers of substeps", &of_substeps)?;
        let [of_constants, of_states, of_numbers] = device.layouts();
        let constants = [device.exact(), &buffers.params, &topology, &buffers.numbers];
        let way = |from: usize| {
            let Buffers { states, own, flags, good, .. } = &buffers;
            device.group(of_states, &[&states[from], &states[1 - from], own, flags, good])
        };
        Ok(Instances {
            constants: device.group(of_constants, &constants),
            ways: [way(0), way(1)],
            numbers: device.dynamic_group(of_numbers, &of_substeps),
            programs: device.programs(choice),
            device: device.clone(),
            choice,
            substeps: settings.substeps,
            buffers,
            current: 0,
            known: vec![None; places.len()],
            places,
            slices,
            batch: steps_of_batch(all),
            pending: None,
        })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The current state; see `step.wgsl`.
    pub fn state_buffer(&self) -> &Buffer {
        &self.buffers.states[self.current]
    }

    /// Uploads parameters and grabs of an instance, and its state if the device has another.
    pub fn load(&mut self, number: usize, simulation: &Simulation<f32>) {
        let (model, state) = (simulation.model(), simulation.state());
        let is_known = |known: &State<f32>| first_difference(known, &state).is_none();
        if !self.known[number].as_ref().is_some_and(is_known) {
            self.load_state(number, model, &state);
            self.known[number] = Some(state);
        }
        let place = &self.places[number];
        let queue = &self.device.queue;
        let grabs: Vec<[u32; 4]> = model.grabs().iter().flat_map(grab_numbers).collect();
        let at = 16 * u64::from(place.grabs_at);
        queue.write_buffer(&self.buffers.numbers, at, cast_slice(&grabs));
        let params = params(simulation, self.choice.kind, place);
        let at = (number * size_of::<Params>()) as u64;
        queue.write_buffer(&self.buffers.params, at, cast_slice(&[params]));
        let at = 4 * u64::from(place.flags_at);
        queue.write_buffer(&self.buffers.flags, at, cast_slice(&[0u32; 2]));
    }

    /// Takes the particles of an instance out of further steps.
    pub fn remove(&self, number: usize) {
        let (queue, at) = (&self.device.queue, (number * size_of::<Params>()) as u64);
        queue.write_buffer(&self.buffers.params, at, bytes_of(&Params::zeroed()));
        let at = 4 * u64::from(self.places[number].flags_at);
        queue.write_buffer(&self.buffers.flags, at, cast_slice(&[0u32; 2]));
    }

    /// Forgets which states are on the device: masses may have changed as well.
    pub fn forget(&mut self) {
        self.known.fill(None);
    }

    fn load_state(&self, number: usize, model: &Model<f32>, state: &State<f32>) {
        let rows = state.positions.iter().zip(&state.velocities);
        let masses = model.inverse_masses().iter().zip(model.masses());
        let rows: Vec<[f32; 8]> = rows
            .zip(masses)
            .map(|((x, v), (&w, &m))| [x.x, x.y, x.z, w, v.x, v.y, v.z, m])
            .collect();
        let at = PARTICLE * self.places[number].particles.start as u64;
        let to = &self.buffers.states[self.current];
        self.device.queue.write_buffer(to, at, cast_slice(&rows));
    }

    /// Submits steps, and the read-back of all states after them.
    pub fn submit(&mut self, steps: u64) {
        let last = self.submit_all_but_last(steps);
        let mut encoder = self.device.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder, last);
        let state = self.state_buffer().clone();
        self.read_back(encoder, &state, (steps, None));
    }

    /// Submits steps alone.
    pub fn submit_alone(&mut self, steps: u64) {
        let last = self.submit_all_but_last(steps);
        self.submit_batch(last);
    }

    /// Submits batches of steps; returns the steps of the last batch, which it leaves to the
    /// caller. Waits for all but two of them: a driver should not queue hours of work.
    fn submit_all_but_last(&mut self, steps: u64) -> u64 {
        let (mut left, mut before) = (steps, None);
        while self.batch < left {
            let submission = self.submit_batch(self.batch);
            if let Some(before) = before.replace(submission) {
                let submission_index = Some(before);
                self.device.poll(wgpu::PollType::Wait { submission_index, timeout: None });
            }
            left -= self.batch;
        }
        left
    }

    fn submit_batch(&mut self, steps: u64) -> wgpu::SubmissionIndex {
        let mut encoder = self.device.device.create_command_encoder(&Default::default());
        self.encode(&mut encoder, steps);
        self.device.queue.submit([encoder.finish()])
    }

    /// Waits until nothing is under way.
    pub fn idle(&self) -> Result<(), GpuError> {
        self.device.wait()
    }

    /// Submits commands and the read-back of the flags and of a state.
    fn read_back(
        &mut self,
        mut encoder: CommandEncoder,
        state: &Buffer,
        (steps, current): (u64, Option<Vec<State<f32>>>),
    ) {
        let Buffers { flags, staging, .. } = &self.buffers;
        encoder.copy_buffer_to_buffer(flags, 0, staging, 0, flags.size());
        encoder.copy_buffer_to_buffer(state, 0, staging, flags.size(), state.size());
        self.device.queue.submit([encoder.finish()]);
        let (send, mapped) = channel();
        // Nobody listens any more where they are gone.
        staging.map_async(wgpu::MapMode::Read, .., move |result| drop(send.send(result)));
        self.pending = Some(Pending { steps, current, mapped });
    }

    /// Whether steps were submitted whose outcomes were not fetched.
    pub fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// Waits for the steps that were submitted.
    pub fn wait(&mut self) -> Result<Vec<Outcome>, GpuError> {
        loop {
            self.device.wait()?;
            if let Some(outcomes) = self.poll()? {
                return Ok(outcomes);
            }
        }
    }

    /// The outcomes of the steps that were submitted, once they are there; never blocks. Where a
    /// step was refused, the states before it are read back as well.
    pub fn poll(&mut self) -> Result<Option<Vec<Outcome>>, GpuError> {
        self.device.poll(wgpu::PollType::Poll);
        let pending = self.pending.take().expect("steps that were submitted");
        match pending.mapped.try_recv() {
            Ok(Ok(())) => self.device.check_lost()?,
            Err(TryRecvError::Empty) => {
                self.device.check_lost()?;
                self.pending = Some(pending);
                return Ok(None);
            }
            Ok(Err(_)) | Err(TryRecvError::Disconnected) => {
                return Err(self.unreadable());
            }
        }
        let (flags, states) = self.read()?;
        let is_any_refused = flags.iter().any(|[refused, _]| *refused != 0);
        if is_any_refused && pending.current.is_none() {
            let encoder = self.device.device.create_command_encoder(&Default::default());
            let good = self.buffers.good.clone();
            self.read_back(encoder, &good, (pending.steps, Some(states)));
            return Ok(None);
        }
        let current = pending.current.unwrap_or_default().into_iter().map(Some);
        let rows = flags.into_iter().zip(states).zip(current.chain(std::iter::repeat(None)));
        let outcome = |(([refused, begun], state), current): (([u32; 2], _), Option<_>)| {
            if refused == 0 {
                let state = current.unwrap_or(state);
                return Outcome { steps: pending.steps, refused: false, state };
            }
            Outcome { steps: u64::from(begun) - 1, refused: true, state }
        };
        let outcomes: Vec<_> = rows.map(outcome).collect();
        for (known, outcome) in self.known.iter_mut().zip(&outcomes) {
            // After a refused step the device holds no state of use.
            *known = (!outcome.refused).then(|| outcome.state.clone());
        }
        Ok(Some(outcomes))
    }

    /// Why nothing can be read back.
    fn unreadable(&self) -> GpuError {
        let reason = "the state cannot be read back".to_owned();
        let lost = GpuError::Lost { adapter: self.device.name(), reason };
        self.device.check_lost().err().unwrap_or(lost)
    }

    /// Flags and states that were read back.
    fn read(&self) -> Result<ReadBack, GpuError> {
        let Buffers { flags, staging, .. } = &self.buffers;
        let bytes = staging.get_mapped_range(..).map_err(|_| self.unreadable())?;
        let (head, rows) = bytes.split_at(flags.size() as usize);
        let of_flags = |place: &Place| {
            let at = 4 * place.flags_at as usize;
            pod_read_unaligned(&head[at..at + 8])
        };
        let flags = self.places.iter().map(of_flags).collect();
        let of_state = |place: &Place| {
            let Range { start, end } = place.particles;
            let bytes = &rows[PARTICLE as usize * start..PARTICLE as usize * end];
            state_of(bytes.chunks_exact(PARTICLE as usize))
        };
        let states = self.places.iter().map(of_state).collect();
        drop(bytes);
        staging.unmap();
        Ok((flags, states))
    }

    /// Records steps.
    fn encode(&mut self, encoder: &mut CommandEncoder, steps: u64) {
        self.forget();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, &self.constants, &[]);
        let substeps = self.substeps;
        for _ in 0..steps {
            self.dispatch(&mut pass, "clear_flags", 0);
            self.dispatch(&mut pass, "begin_step", 0);
            match (self.choice.kind, self.choice.bounces) {
                (Kind::Explicit | Kind::Symplectic, _) => {
                    (0..substeps).for_each(|n| self.move_on(&mut pass, "advance", n));
                }
                (Kind::Verlet, true) => (0..substeps).for_each(|n| {
                    self.move_on(&mut pass, "first_part", n);
                    self.move_on(&mut pass, "last_part", n);
                }),
                (Kind::Verlet, false) => {
                    self.move_on(&mut pass, "first_part", 0);
                    let both = substeps..2 * substeps - 1;
                    both.for_each(|n| self.move_on(&mut pass, "both_parts", n));
                    self.move_on(&mut pass, "last_part", substeps - 1);
                }
                (Kind::Rk4, _) => (0..substeps).for_each(|n| {
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
        let is_of_flags = program == "clear_flags";
        let groups = if is_of_flags { self.places.len() as u32 } else { self.slices };
        pass.dispatch_workgroups(groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1);
    }
}

impl Buffers {
    fn new(
        device: &Device,
        numbers: &[[u32; 4]],
        own: &[[f32; 4]],
        (slices, flags): (u32, u32),
        instances: usize,
    ) -> Result<Self, GpuError> {
        let bytes = PARTICLE * THREADS as u64 * u64::from(slices);
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let state = || device.empty("positions and velocities", bytes, storage);
        let staging = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let params = (instances * size_of::<Params>()) as u64;
        let flags = 4 * u64::from(flags).next_multiple_of(4);
        Ok(Buffers {
            params: device.empty("parameters", params, storage)?,
            numbers: device.storage("laws of springs and grabs", numbers)?,
            states: [state()?, state()?],
            own: device.storage("work columns", own)?,
            flags: device.empty("flags", flags, storage)?,
            good: state()?,
            staging: device.empty("read-back", flags + bytes, staging)?,
        })
    }
}

/// Steps of a batch of some simulations: a fraction of a second of a slow device, so that no driver
/// resets it.
fn steps_of_batch(simulations: &[&Simulation<f32>]) -> u64 {
    let of_step = |simulation: &&Simulation<f32>| {
        let (model, settings) = (simulation.model(), simulation.settings());
        let per_substep = if settings.integrator == Integrator::Rk4 { 4 } else { 1 };
        // Each of the particles of a bend computes it. A dispatch takes as long as at least so many
        // evaluations.
        let pulls = model.spring_count() + 4 * model.bends().count();
        let each = (pulls + model.particle_count()).max(20_000);
        each as u64 * per_substep * u64::from(settings.substeps)
    };
    (BATCH / simulations.iter().map(of_step).sum::<u64>().max(1)).max(1)
}

fn state_of<'a>(particles: impl ExactSizeIterator<Item = &'a [u8]>) -> State<f32> {
    let vector = |row: &[f32; 8], at: usize| Vec3A::new(row[at], row[at + 1], row[at + 2]);
    let mut state = State::default();
    state.positions.reserve_exact(particles.len());
    state.velocities.reserve_exact(particles.len());
    for row in particles.map(pod_read_unaligned::<[f32; 8]>) {
        state.positions.push(vector(&row, 0));
        state.velocities.push(vector(&row, 4));
    }
    state
}

/// The bits of the goal of a grab, its particle, and the bits of its law.
fn grab_numbers(grab: &Grab<f32>) -> [[u32; 4]; 2] {
    let [x, y, z] = grab.target.components().map(f32::to_bits);
    let law = [grab.stiffness, grab.damping, grab.max_force, 0.0];
    [[x, y, z, grab.particle], law.map(f32::to_bits)]
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
/// ends and begins. Each with the numbers of slices and instances.
fn substep_numbers(
    substeps: u32,
    [slices, instances]: [u32; 2],
) -> Vec<[u32; STRIDE as usize / 4]> {
    let pair = |ends: u32, begins: u32| {
        let mut numbers = [0; STRIDE as usize / 4];
        numbers[..4].copy_from_slice(&[ends, begins, slices, instances]);
        numbers
    };
    let alone = (0..substeps).map(|n| pair(n, n));
    alone.chain((0..substeps).map(|n| pair(n, n + 1))).collect()
}
