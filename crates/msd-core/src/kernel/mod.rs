//! How is a step taken fast? Springs are compiled to a plan, and swept sixteen particles at a time.
//!
//! Read in this order:
//!
//! - `pack`, `baseline` and `x86`: a few numbers side by side, and what a processor does with them;
//!   `records`: how x86 reads and writes sixteen of the records below;
//! - `columns`: positions as a column of x, one of y and one of z, instead of row after row. A
//!   number of a particle lies in its *slot* of each column; "own" columns are what a method
//!   remembers;
//! - `plan`: particles in slices of sixteen slots, and the springs of a slice in rows that reach as
//!   far ahead or back (a lattice, a *run*) or name each other end (anything else, a *gather*). For
//!   the latter the motion is kept a second time, as a *record* of eight numbers per particle;
//! - `sweep`: what happens to a slice: the springs of its rows pull, each evaluated from both ends
//!   so that no two slices write to the same place; at once `update` moves its particles on, and
//!   `contact` keeps them out of planes. What was taken away and met comes back as a *tally*;
//! - `links`: what springs add to the matrix of an implicit method, `solve`: what is done with it,
//!   and `matrix`: where it keeps both;
//! - `dispatch`: the same code compiled once for each set of instructions, and chosen here; slices
//!   are done in *parts* of 64, by several threads where that is worth it.
//!
//! A step of an explicit method, from `crate::engine`: `Kernel::advance` brings the state into
//! columns, unless it is there (`Known::here`); each substep is a sweep from one motion to the
//! other, in RK4 four, down from `dispatch::run` to `sweep::sweep`, `pulled` and the two halves of
//! `Stretched`, then `update` and `contact`; at the end the state is fetched. Other methods
//! ask for [`Kernel::set_forces`], the implicit ones for a matrix besides.
//!
//! Nothing outside this module knows about slots, lanes or packs, and all its results have the bits
//! of the plain loops in `crate::forces`, [`crate::explicit`] and [`crate::collision`], which are
//! its oracle, until a number is none: no operation is fused or approximate, and each particle sums
//! in the same order. Only the energy taken away, a sum over all springs, may differ in rounding.
//!
//! Every use of `unsafe` in this crate is here. It rests on three promises: a pack of a processor's
//! own is made only after the processor was asked (`dispatch`); rows reach only what is in columns
//! (`plan`); and a slice writes only to its own slots (`sweep`).
#![allow(unsafe_code)]

// Roughly in reading order.
mod pack;
mod baseline;
#[cfg(target_arch = "x86_64")]
mod records;
#[cfg(target_arch = "x86_64")]
mod x86;
mod columns;
mod plan;
mod sweep;
mod contact;
mod update;
mod links;
mod solve;
mod dispatch;
mod matrix;

pub use dispatch::Instructions;

use crate::forces;
use crate::integrator::Explicit;
use crate::real::{Real, Vector};
use crate::system::{Model, Motion, State};
use alloc::vec;
use alloc::vec::Vec;
use columns::Columns;
use contact::Planes;
use matrix::Solve;
use plan::Plan;
use sweep::{INVERSE_MASS, Job, MASS, POSITION, Push, Tally, VELOCITY};
use update::{Phase, Update, own_columns, rk4_stages};

/// Particles in a slice.
const LANES: usize = 16;

/// Bytes of records that the near caches hold beside what a sweep streams through them.
const NEAR_BYTES: usize = 1 << 19;

/// Where columns start in a page, see [`Columns::placed`].
const MOTION_PLACES: [usize; 2] = [0, 16];
const FIXED_PLACE: usize = 8;
const OWN_PLACE: usize = 24;

/// Numbers in a record: position, nothing, velocity, nothing.
const RECORD: usize = 8;

/// What the substeps of a step came to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Substeps {
    /// Energy taken away, joules.
    pub(crate) counted: f64,
    /// Whether anything touched a plane, and whether it did in the last substep.
    pub(crate) touched: bool,
    pub(crate) last_met: bool,
    /// Whether every particle is known to be inside the world and every velocity finite.
    pub(crate) inside: bool,
    /// The particle for which an adaptive method gave up.
    pub(crate) stuck: Option<usize>,
}

/// What an advance may take for granted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Whether the state is the one that the last advance left.
    pub(crate) here: bool,
    /// Whether its accelerations are those of the last advance.
    pub(crate) warm: bool,
    /// Whether a force depends on velocity.
    pub(crate) damped: bool,
}

/// A topology compiled, with columns to work on.
#[derive(Clone, Debug)]
pub struct Kernel<R: Real> {
    plan: Plan<R>,
    instructions: Instructions,
    fixed: Columns<R>,
    /// A motion, and the one that comes out of it.
    motions: [Columns<R>; 2],
    records: [Columns<R>; 2],
    own: Columns<R>,
    solve: Solve<R>,
    /// What pushes single particles, by slot.
    pushes: Vec<Push<R>>,
    planes: Vec<Planes<R>>,
    tallies: Vec<Tally>,
    /// Power taken away at the accelerations that velocity Verlet remembers, watts.
    power: f64,
}

impl<R: Real> Kernel<R> {
    /// Compiles the springs of a model for a set of instructions, or for the best that this machine
    /// has if that is less.
    pub fn new(model: &Model<R>, instructions: Instructions) -> Self {
        let plan = Plan::new(model);
        let slices = plan.slices();
        let records = if plan.others.is_empty() { 0 } else { RECORD };
        let mut kernel = Kernel {
            instructions: instructions.within_reach(),
            fixed: Columns::placed(2, slices, FIXED_PLACE),
            motions: MOTION_PLACES.map(|place| Columns::placed(6, slices, place)),
            records: [Columns::new(records, slices), Columns::new(records, slices)],
            own: Columns::new(0, slices),
            solve: Solve::none(slices),
            pushes: Vec::new(),
            planes: Vec::new(),
            tallies: vec![Tally::default(); dispatch::parts(slices)],
            power: 0.0,
            plan,
        };
        kernel.renew(model);
        kernel
    }

    /// Takes over masses and pins that have changed.
    pub fn renew(&mut self, model: &Model<R>) {
        for particle in 0..model.particle_count() {
            let slot = self.plan.slot(particle as u32);
            self.fixed.column_mut(MASS)[slot] = model.masses[particle];
            self.fixed.column_mut(INVERSE_MASS)[slot] = model.inverse_masses[particle];
        }
    }

    /// Frees what another method remembers.
    pub(crate) fn forget_method(&mut self) {
        let slices = self.plan.slices();
        (self.own, self.solve) = (Columns::new(0, slices), Solve::none(slices));
    }

    /// Overwrites `forces` with all forces of a model at a motion, newtons, and returns the power
    /// taken away by dampers and drag, watts.
    ///
    /// The same bits as [`forces::set_external_forces`] and [`forces::add_spring_forces`] together.
    pub fn set_forces(
        &mut self,
        model: &Model<R>,
        motion: Motion<'_, R>,
        forces: &mut [R::Vec3],
    ) -> f64 {
        self.bring(motion);
        let tally = self.sweep(model, Update::Forces);
        self.fetch(POSITION, 1, forces);
        tally.power
    }

    /// Advances a state by some substeps of `h` seconds, contact included.
    pub(crate) fn advance(
        &mut self,
        model: &Model<R>,
        (method, h, substeps): (Explicit, f64, u32),
        Known { here, warm, damped }: Known,
        state: &mut State<R>,
    ) -> Substeps {
        if !here {
            self.bring(state.motion());
        }
        if !self.own.has(own_columns(method)) {
            let slices = self.plan.slices();
            self.own = Columns::placed(own_columns(method), slices, OWN_PLACE);
        }
        let step = R::of(h);
        self.planes.clear();
        self.planes.extend(model.planes.iter().map(|p| Planes::new(p, model.gravity, step)));
        let mut done = Substeps::default();
        if method == Explicit::VelocityVerlet {
            let phase = if warm { Phase::Warm } else { Phase::Cold };
            let tally = self.turn(model, Update::VelocityVerlet { h: step, phase, damped });
            self.power = if warm { self.power } else { tally.power };
        }
        for substep in 0..substeps {
            let last = substep + 1 == substeps;
            let (power, met) = self.substep(model, (method, step), (last, damped));
            done.counted += power * h + met.energy;
            done.last_met = 0 < met.contacts;
            done.touched |= done.last_met;
        }
        self.fetch(POSITION, 0, &mut state.positions);
        self.fetch(VELOCITY, 0, &mut state.velocities);
        let [at, _] = &self.motions;
        done.inside = at.is_within(POSITION, model.extent) && at.is_within(VELOCITY, R::LARGEST);
        done
    }

    /// Advances by one substep; returns the mean power taken away, watts, and the contacts.
    fn substep(
        &mut self,
        model: &Model<R>,
        (method, h): (Explicit, R),
        (last, damped): (bool, bool),
    ) -> (f64, Tally) {
        let mut simple = |update| {
            let tally = self.turn(model, update);
            (tally.power, tally)
        };
        match method {
            Explicit::Euler => simple(Update::ExplicitEuler { h }),
            Explicit::SymplecticEuler => simple(Update::SymplecticEuler { h }),
            Explicit::VelocityVerlet => {
                let phase = if last { Phase::Last } else { Phase::Next };
                let tally = self.turn(model, Update::VelocityVerlet { h, phase, damped });
                let before = core::mem::replace(&mut self.power, tally.power);
                (0.5 * (before + tally.power), tally)
            }
            Explicit::Rk4 => {
                let mut power = 0.0;
                for (weight, stage) in rk4_stages::<R, R>(h * R::HALF, h) {
                    power += weight.to_f64() * self.turn(model, stage).power;
                }
                let tally = self.turn(model, Update::Rk4Last { h });
                ((power + tally.power) / 6.0, tally)
            }
        }
    }

    /// Copies a motion into the first columns, and into records if there are any.
    fn bring(&mut self, motion: Motion<'_, R>) {
        for (column, vectors) in [(POSITION, motion.positions), (VELOCITY, motion.velocities)] {
            let mut columns = self.motions[0].three_mut(column);
            if self.plan.slots().is_some() {
                spread(self.plan.slots(), columns, vectors.iter().copied());
                continue;
            }
            // Four at a time, which a compiler turns into a transposition.
            let (fours, rest) = vectors.as_chunks::<4>();
            for (place, four) in fours.iter().enumerate() {
                let four = four.map(Vector::components);
                for (axis, column) in columns.iter_mut().enumerate() {
                    let to = &mut column[4 * place..4 * place + 4];
                    to.copy_from_slice(&four.map(|vector| vector[axis]));
                }
            }
            let columns = columns.map(|column| &mut column[4 * fours.len()..]);
            spread(None, columns, rest.iter().copied());
        }
        if !self.plan.others.is_empty() {
            let [from, _] = &self.motions;
            for (half, column) in [POSITION, VELOCITY].into_iter().enumerate() {
                let records = self.records[0].flat_mut().as_chunks_mut::<RECORD>().0;
                for axis in 0..3 {
                    let numbers = from.column(column + axis).iter();
                    for (record, &number) in records.iter_mut().zip(numbers) {
                        record[half * RECORD / 2 + axis] = number;
                    }
                }
            }
        }
    }

    /// Copies three of the columns of a motion out.
    fn fetch(&self, column: usize, motion: usize, vectors: &mut [R::Vec3]) {
        let columns = [0, 1, 2].map(|axis| self.motions[motion].column(column + axis));
        taken(self.plan.slots(), columns, vectors, |to, from| *to = from);
    }

    /// Sweeps, and takes what comes out for what goes in next.
    fn turn(&mut self, model: &Model<R>, update: Update<R>) -> Tally {
        let tally = self.sweep(model, update);
        self.motions.swap(0, 1);
        self.records.swap(0, 1);
        tally
    }

    fn sweep(&mut self, model: &Model<R>, update: Update<R>) -> Tally {
        self.gather_pushes(model);
        let [from, to] = &mut self.motions;
        let far = NEAR_BYTES < self.records[0].bytes();
        let [records_from, records_to] = &mut self.records;
        let records = [records_from, records_to].map(|records| records.flat_mut().as_mut_ptr());
        let job = Job {
            plan: &self.plan,
            fixed: self.fixed.start(),
            from: from.start(),
            to: to.start(),
            own: self.own.start(),
            records,
            far,
            fields: [model.gravity, model.force],
            drag: model.drag,
            pushes: &self.pushes,
            planes: &self.planes,
        };
        // SAFETY: the instructions were made to be within reach, and the columns are borrowed.
        unsafe { dispatch::run(self.instructions, &job, update, &mut self.tallies) }
    }

    /// Lists what pushes and grabs single particles at the motion that is swept next.
    fn gather_pushes(&mut self, model: &Model<R>) {
        self.pushes.clear();
        if model.pushes.is_empty() && model.grabs.is_empty() {
            return;
        }
        for &(particle, force) in &model.pushes {
            self.push(self.plan.slot(particle), force);
        }
        for grab in &model.grabs {
            let (position, velocity) = self.brought(grab.particle);
            let pull = forces::grab_pull(grab, position, velocity);
            self.push(self.plan.slot(grab.particle), pull);
        }
        self.pushes.sort_unstable_by_key(|push| (push.slot, push.number));
    }

    fn push(&mut self, slot: usize, force: R::Vec3) {
        self.pushes.push(Push { slot: slot as u32, number: self.pushes.len() as u32, force });
    }

    /// Position and velocity of a particle in the first columns.
    fn brought(&self, particle: u32) -> (R::Vec3, R::Vec3) {
        let slot = self.plan.slot(particle);
        let vector = |column: usize| {
            let axes = [0, 1, 2].map(|axis| self.motions[0].column(column + axis)[slot]);
            R::Vec3::from_components(axes)
        };
        (vector(POSITION), vector(VELOCITY))
    }
}

/// Writes vectors to three columns, each to the slot of its particle.
fn spread<R: Real>(
    slots: Option<&[u32]>,
    [xs, ys, zs]: [&mut [R]; 3],
    vectors: impl Iterator<Item = R::Vec3>,
) {
    if let Some(slots) = slots {
        for (&slot, vector) in slots.iter().zip(vectors) {
            let slot = slot as usize;
            [xs[slot], ys[slot], zs[slot]] = vector.components();
        }
    } else {
        for (((x, y), z), vector) in xs.iter_mut().zip(ys).zip(zs).zip(vectors) {
            [*x, *y, *z] = vector.components();
        }
    }
}

/// Does something to each of some vectors with that in three columns.
fn taken<R: Real>(
    slots: Option<&[u32]>,
    [xs, ys, zs]: [&[R]; 3],
    vectors: &mut [R::Vec3],
    mut change: impl FnMut(&mut R::Vec3, R::Vec3),
) {
    if let Some(slots) = slots {
        for (&slot, vector) in slots.iter().zip(vectors) {
            let slot = slot as usize;
            change(vector, R::Vec3::from_components([xs[slot], ys[slot], zs[slot]]));
        }
    } else {
        for (((vector, &x), &y), &z) in vectors.iter_mut().zip(xs).zip(ys).zip(zs) {
            change(vector, R::Vec3::from_components([x, y, z]));
        }
    }
}
