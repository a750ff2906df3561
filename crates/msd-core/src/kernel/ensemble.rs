//! How do copies of a scene advance together? In groups of sixteen, with a lane for each of them.

use super::LANES;
use super::columns::{Columns, Slice};
use super::dispatch::{Instructions, run_group};
use super::ensemble_plan::{Pull, Table, lanes, order};
use super::ensemble_sweep::{INVERSE_MASS, Lanes, MASS, PlaneRow, Task, Turn};
use super::sweep::{POSITION, VELOCITY};
use super::update::{Phase, Update, own_columns, rk4_stages};
use crate::collision::resting_speed;
use crate::integrator::Explicit;
use crate::real::{Real, Vector};
use crate::scene::Friction;
use crate::system::{Model, PlaneColumn, State};
use alloc::vec::Vec;

/// The rows of a particle: forces between two motions, so that what springs read and write lies
/// side by side; what the particle is; a constant force; what the method remembers.
const MOTIONS: [usize; 2] = [0, 9];
const FORCE: usize = 6;
const FIXED: usize = 15;
const LOAD: usize = 17;
const OWN: usize = 20;

/// Copies of a topology.
#[derive(Clone, Debug)]
pub(crate) struct Groups<R: Real>(Vec<Group<R>>);

impl<R: Real> Groups<R> {
    /// Makes groups of models, which have the same springs' ends, of states and of the lengths of
    /// their substeps, seconds; of one copy at least.
    pub(crate) fn new(copies: &[(&Model<R>, &State<R>, f64)], method: Explicit) -> Self {
        let order = order(copies[0].0);
        Groups(copies.chunks(LANES).map(|copies| Group::new(copies, method, &order)).collect())
    }

    /// Advances the copies that still run by some substeps.
    pub(crate) fn advance(&mut self, substeps: u32) {
        for group in self.0.iter_mut().filter(|group| group.running != 0) {
            group.outside = group.advance(substeps) & group.running;
        }
    }

    /// A copy that still runs, though a particle of it is outside the world or has a velocity that
    /// is not finite.
    pub(crate) fn outside(&self) -> Option<usize> {
        let group = self.0.iter().position(|group| group.outside != 0)?;
        Some(group * LANES + self.0[group].outside.trailing_zeros() as usize)
    }

    /// Ends a copy.
    pub(crate) fn stop(&mut self, copy: usize) {
        self.0[copy / LANES].stop(copy % LANES);
    }

    /// The state of a copy, or that before the last step.
    pub(crate) fn state(&self, copy: usize, before: bool) -> State<R> {
        self.0[copy / LANES].state(copy % LANES, before)
    }

    /// The sums of the squares of the speeds of each copy, in `f64`, particle after particle; then
    /// some without meaning.
    pub(crate) fn squared_speeds(&self) -> impl Iterator<Item = f64> {
        self.0.iter().flat_map(Group::squared_speeds)
    }

    /// Sets the constant forces on the particles of a copy, newtons.
    pub(crate) fn set_load(&mut self, copy: usize, load: &[R::Vec3]) {
        self.0[copy / LANES].set_load(copy % LANES, load);
    }

    /// Chooses the instructions of the steps to come.
    pub(crate) fn set_instructions(&mut self, instructions: Instructions) {
        self.0.iter_mut().for_each(|group| group.instructions = instructions.within_reach());
    }
}

/// Up to sixteen copies, a lane each.
#[derive(Clone, Debug)]
struct Group<R: Real> {
    /// The lanes whose copies still run, and of those the ones outside the world.
    running: u16,
    outside: u16,
    instructions: Instructions,
    method: Explicit,
    particles: usize,
    width: usize,
    rows: Columns<R>,
    pulls: Vec<Pull>,
    values: Columns<R>,
    lanes: Lanes<R>,
    loaded: bool,
    /// Which motion is that of now; the other is that of a step ago.
    now: usize,
    /// Whether accelerations are known that would be found again to the bit.
    warm: bool,
}

impl<R: Real> Group<R> {
    /// See [`Groups::new`]. The last copy fills the lanes that are left; `order` is from [`order`].
    fn new(copies: &[(&Model<R>, &State<R>, f64)], method: Explicit, order: &[u32]) -> Self {
        let copy = |lane: usize| copies[lane.min(copies.len() - 1)];
        let models: [&Model<R>; LANES] = core::array::from_fn(|lane| copy(lane).0);
        // An odd number of lines of the cache: particles would meet in few places of it otherwise.
        let width = (OWN + own_columns(method)) | 1;
        let mut table = Table::new();
        let pulls = table.pulls(models, order);
        let particles = models[0].particle_count();
        let mut group = Group {
            running: u16::MAX >> (LANES - copies.len()),
            outside: 0,
            instructions: Instructions::best(),
            method,
            particles,
            width,
            rows: Columns::new(1, particles * width),
            pulls,
            values: table.column(),
            lanes: lanes_of(models, core::array::from_fn(|lane| R::of(copy(lane).2))),
            loaded: false,
            now: 0,
            warm: false,
        };
        for lane in 0..LANES {
            let (model, state, _) = copy(lane);
            group.put_column(FIXED + MASS, lane, &model.masses);
            group.put_column(FIXED + INVERSE_MASS, lane, &model.inverse_masses);
            group.put(MOTIONS[0] + POSITION, lane, &state.positions);
            group.put(MOTIONS[0] + VELOCITY, lane, &state.velocities);
        }
        group.perform((0, 0), Task::SetExternal);
        group
    }

    /// Advances by some substeps. Returns the lanes in which a particle is now outside the world or
    /// has a velocity that is not finite; bits of no lane are zero.
    fn advance(&mut self, substeps: u32) -> u16 {
        let (h, half) = (self.lanes.h.0, self.lanes.half.0);
        let (h, half) = (&h, &half);
        let damped = (self.lanes.damped | self.lanes.dragged) != 0;
        let mut met = false;
        // The first turn leaves the motion of a step ago as it was.
        let mut from = self.now;
        self.now = 1 - self.now;
        let mut turn = |group: &mut Self, update| {
            let motions = (core::mem::replace(&mut from, group.now), group.now);
            group.perform(motions, Task::Advance(update)) != 0
        };
        if self.method == Explicit::VelocityVerlet {
            let phase = if self.warm { Phase::Warm } else { Phase::Cold };
            turn(self, Update::VelocityVerlet { h, phase, damped });
        }
        for substep in 1..=substeps {
            met = match self.method {
                Explicit::Euler => turn(self, Update::ExplicitEuler { h }),
                Explicit::SymplecticEuler => turn(self, Update::SymplecticEuler { h }),
                Explicit::VelocityVerlet => {
                    let phase = if substep == substeps { Phase::Last } else { Phase::Next };
                    turn(self, Update::VelocityVerlet { h, phase, damped })
                }
                Explicit::Rk4 => {
                    for (_, stage) in rk4_stages::<R, _>(half, h) {
                        turn(self, stage);
                    }
                    turn(self, Update::Rk4Last { h })
                }
            };
        }
        self.warm = !damped && !met;
        self.perform((self.now, self.now), Task::Guard)
    }

    /// Goes back to the state before the last step in one lane, and stays there for good: what
    /// becomes of it is of no interest, but it should not be slow.
    fn stop(&mut self, lane: usize) {
        self.running &= !(1 << lane);
        self.outside &= !(1 << lane);
        self.lanes.h.0[lane] = R::ZERO;
        self.lanes.half.0[lane] = R::ZERO;
        let [now, before] = [MOTIONS[self.now], MOTIONS[1 - self.now]];
        for particle in 0..self.particles {
            for row in 0..FORCE {
                *self.number(now + row, particle, lane) =
                    *self.number(before + row, particle, lane);
            }
        }
    }

    fn state(&self, lane: usize, before: bool) -> State<R> {
        let motion = MOTIONS[if before { 1 - self.now } else { self.now }];
        let numbers = self.rows.column(0);
        let vector = |row: usize| {
            move |particle: usize| {
                let at = (particle * self.width + motion + row) * LANES + lane;
                R::Vec3::from_components([0, 1, 2].map(|axis| numbers[at + axis * LANES]))
            }
        };
        State {
            positions: (0..self.particles).map(vector(POSITION)).collect(),
            velocities: (0..self.particles).map(vector(VELOCITY)).collect(),
        }
    }

    fn squared_speeds(&self) -> [f64; LANES] {
        let mut sums = [0.0; LANES];
        let rows = self.rows.column(0).as_chunks::<LANES>().0;
        for particle in rows.chunks_exact(self.width) {
            let [x, y, z] = [0, 1, 2].map(|axis| &particle[MOTIONS[self.now] + VELOCITY + axis]);
            for lane in 0..LANES {
                let [x, y, z] = [x[lane], y[lane], z[lane]].map(Real::to_f64);
                sums[lane] += x * x + y * y + z * z;
            }
        }
        sums
    }

    fn set_load(&mut self, lane: usize, load: &[R::Vec3]) {
        if !core::mem::replace(&mut self.loaded, true) {
            // To add minus zero changes nothing, not even the sign of a zero.
            for lane in 0..LANES {
                let nothing = R::Vec3::from_components([-R::ZERO; 3]);
                (0..self.particles)
                    .for_each(|particle| self.put_one(LOAD, particle, lane, nothing));
            }
        }
        self.put(LOAD, lane, load);
        self.warm = false;
    }

    fn put(&mut self, row: usize, lane: usize, vectors: &[R::Vec3]) {
        for (particle, &vector) in vectors.iter().enumerate() {
            self.put_one(row, particle, lane, vector);
        }
    }

    fn put_one(&mut self, row: usize, particle: usize, lane: usize, vector: R::Vec3) {
        for (axis, component) in vector.components().into_iter().enumerate() {
            *self.number(row + axis, particle, lane) = component;
        }
    }

    fn put_column(&mut self, row: usize, lane: usize, numbers: &[R]) {
        for (particle, &value) in numbers.iter().enumerate() {
            *self.number(row, particle, lane) = value;
        }
    }

    fn number(&mut self, row: usize, particle: usize, lane: usize) -> &mut R {
        &mut self.rows.column_mut(0)[(particle * self.width + row) * LANES + lane]
    }

    fn perform(&mut self, (from, to): (usize, usize), task: Task<'_, R>) -> u16 {
        let rows = &mut self.rows;
        let turn = Turn {
            pulls: &self.pulls,
            values: self.values.rows(0),
            particles: self.particles,
            width: self.width,
            from: rows.rows(MOTIONS[from]),
            to: rows.rows(MOTIONS[to]),
            forces: rows.rows(FORCE),
            fixed: rows.rows(FIXED),
            own: rows.rows(OWN),
            loads: self.loaded.then(|| rows.rows(LOAD)),
            lanes: &self.lanes,
        };
        // SAFETY: the instructions were made to be within reach; pulls name particles of the model
        // and rows of the table they were made with; the columns are borrowed.
        unsafe { run_group(self.instructions, &turn, task) }
    }
}

/// What models differ in, with the lengths of their substeps.
fn lanes_of<R: Real>(models: [&Model<R>; LANES], h: [R; LANES]) -> Lanes<R> {
    let vector = |of: fn(&Model<R>) -> R::Vec3| {
        [0, 1, 2].map(|axis| lanes(models, |model| of(model).components()[axis]))
    };
    let most = models.iter().map(|model| model.planes.len()).max().unwrap_or(0);
    Lanes {
        gravity: vector(|model| model.gravity),
        force: vector(|model| model.force),
        drag: lanes(models, |model| model.drag),
        dragged: lanes_where(models, |model| model.drag != R::ZERO),
        damped: lanes_where(models, |model| !model.dampings.is_zero()),
        half: Slice(h.map(|h| h * R::HALF)),
        extent: lanes(models, |model| model.extent),
        planes: (0..most).map(|row| plane_row(models, h, row)).collect(),
        h: Slice(h),
    }
}

fn lanes_where<R: Real>(models: [&Model<R>; LANES], wanted: impl Fn(&Model<R>) -> bool) -> u16 {
    let lanes = models.iter().enumerate();
    lanes.fold(0, |mask, (lane, model)| mask | u16::from(wanted(model)) << lane)
}

/// One plane of each model that has so many.
fn plane_row<R: Real>(models: [&Model<R>; LANES], h: [R; LANES], row: usize) -> PlaneRow<R> {
    let number = |of: &dyn Fn(&PlaneColumn<R>) -> R| {
        lanes(models, |model| model.planes.get(row).map_or(R::ZERO, of))
    };
    let resting = |lane: usize| {
        let model = models[lane];
        let plane = model.planes.get(row);
        plane.map_or(R::ZERO, |plane| resting_speed(plane, model.gravity, h[lane]))
    };
    let kept = |plane: &PlaneColumn<R>| match plane.friction {
        Friction::TangentialLoss(loss) => R::ONE - R::of(loss),
        Friction::Coulomb(_) => R::ZERO,
    };
    let factor = |plane: &PlaneColumn<R>| match plane.friction {
        Friction::TangentialLoss(_) => R::ZERO,
        Friction::Coulomb(factor) => R::of(factor),
    };
    let is_coulomb = |plane: &PlaneColumn<R>| matches!(plane.friction, Friction::Coulomb(_));
    PlaneRow {
        lanes: lanes_where(models, |model| row < model.planes.len()),
        normal: [0, 1, 2].map(|axis| number(&|plane| plane.normal.components()[axis])),
        offset: number(&|plane| plane.offset),
        resting_speed: Slice(core::array::from_fn(resting)),
        restitution: number(&|plane| plane.restitution),
        kept: number(&kept),
        factor: number(&factor),
        coulomb: lanes_where(models, |model| model.planes.get(row).is_some_and(is_coulomb)),
    }
}
