//! Step context: the system, its state and the work columns that a method advances them with.

use super::Settings;
use super::dormand_prince;
use super::implicit;
use super::xpbd;
use crate::columns::Aligned;
use crate::columns::threads::Split;
use crate::contact::after_kick::Kick;
use crate::contact::ending::Substep;
use crate::contact::found::{Contact, When};
use crate::contact::passage::fastest;
use crate::contact::shells::{At, ShellRows};
use crate::contact::{Contacts, Evaluated};
use crate::elements::{ForceWork, Motion, column};
use crate::number::{Real, of_type};
use crate::system::{Columns, Model};
use alloc::boxed::Box;
use alloc::vec::Vec;
use fearless_simd::Level;

/// Scratch of a step.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// The forces of the last evaluation, newtons.
    pub(crate) forces: Aligned<R>,
    pub(crate) work: ForceWork<R>,
    /// Work columns of the method.
    pub(crate) columns: Vec<Aligned<R>>,
    /// The contacts of the positions at which they were found last.
    pub(crate) contacts: Vec<Contact>,
    /// Whether there is one among them.
    pub(crate) touches: bool,
    /// The largest speed after the first substep of the step where there are solids, metres per
    /// second.
    pub(crate) fastest: R,
    /// Power dissipated at the last evaluation, watts, and that which pins gave.
    pub(crate) power: f64,
    pub(crate) power_of_pins: f64,
    /// Whether velocity Verlet knows the accelerations at the current state, or XPBD the constants
    /// of springs. A step starts from positions and velocities alone, so this holds only where they
    /// would be found again to the bit.
    pub(crate) warm: bool,
    pub(crate) dormand_prince: Option<Box<dormand_prince::Scratch<R>>>,
    pub(crate) implicit: Option<Box<implicit::Scratch<R>>>,
    pub(crate) xpbd: Option<Box<xpbd::Scratch<R>>>,
}

impl<R: Real> Scratch<R> {
    /// Makes the columns of an evaluation and `columns` more.
    pub(crate) fn new(model: &Model<R>, columns: usize) -> Self {
        Scratch {
            forces: column(&model.slots, 4),
            work: ForceWork::new(&model.springs, &model.slots),
            columns: (0..columns).map(|number| column(&model.slots, 16 + number)).collect(),
            contacts: Vec::new(),
            touches: false,
            fastest: R::ZERO,
            power: 0.0,
            power_of_pins: 0.0,
            warm: false,
            dormand_prince: None,
            implicit: None,
            xpbd: None,
        }
    }
}

/// The outcome of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Done {
    /// Energy dissipated, joules, contact included.
    pub(crate) counted: f64,
    /// The effect of obstacles.
    pub(crate) contacts: Contacts,
    /// Whether anything touched an obstacle.
    pub(crate) touched: bool,
    /// Energy that pins and user-defined elements have driven into the system, joules.
    pub(crate) given: f64,
    /// Number of times that shells may have crossed in the step, and were seen to have before it.
    pub(crate) passes: u64,
    pub(crate) crossed: u64,
    /// Whether a solid turned or moved by too much in a substep in which it met a particle, or
    /// friction did not settle. A step of more substeps is needed then.
    pub(crate) turned: bool,
    /// Why the method gave up, if it did.
    pub(crate) failure: Option<Failure>,
}

/// Why a method gave up a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    /// The error of this particle stays above the tolerance of an adaptive method.
    Tolerance(usize),
    /// An adaptive method has used up its evaluations after this part of the step.
    Evaluations(f64),
    /// The force on this particle, or its velocity after a solve, is NaN or infinite.
    NotFinite(usize),
    /// A linear solve left so much of its residual that the step is of no use.
    Unsolved { residual: f64, iterations: u64 },
}

impl Done {
    /// Books the work of pins, joules: the energy that they take back counts as dissipated.
    pub(crate) fn drive(&mut self, work: f64) {
        self.counted -= work;
        self.given += work.max(0.0);
    }

    /// Whether the energy that it books is a number.
    pub(crate) fn is_finite(&self) -> bool {
        (self.counted + self.given).is_finite()
    }

    /// Books the effect of obstacles. Energy that moving surfaces drive in counts as given, as only
    /// user-defined surfaces move.
    pub(crate) fn meet(&mut self, contacts: Contacts) {
        self.counted += contacts.taken - contacts.added - contacts.driven;
        self.given += contacts.driven.max(0.0);
        self.touched |= 0 < contacts.count;
        self.turned |= contacts.turned;
        self.contacts += Contacts { bounced: false, turned: false, ..contacts };
    }
}

/// The displacement of particles in a substep, by the method that made it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Way {
    /// By h (v' − s h a), with v' the velocity at its end, a the last acceleration, and s given.
    Kicked(f64),
    /// By h (v' − h a/2), between half kicks; the acceleration of the first is in the second work
    /// column. Contacts have been found.
    BetweenKicks,
    /// From positions that are kept in the first work column.
    Kept,
}

/// The functions with the loops that a user-defined method calls. The two tables below are not
/// generic, so these are compiled in this crate and not in that of the method.
struct Calls<R: Real> {
    set_forces: fn(&mut StepContext<'_, R>, f64) -> f64,
    finish_substep: fn(&mut StepContext<'_, R>, f64),
}

// Not statics: see `system/kinds.rs`.
#[inline(never)]
fn single() -> &'static Calls<f32> {
    const { &Calls::new() }
}

#[inline(never)]
fn double() -> &'static Calls<f64> {
    const { &Calls::new() }
}

impl<R: Real> Calls<R> {
    const fn new() -> Self {
        Calls {
            set_forces: |step, time| step.evaluate(time),
            finish_substep: |step, taken| step.end_substep(taken),
        }
    }

    /// The functions for a precision.
    fn of_precision() -> &'static Self {
        of_type(single(), double())
    }
}

/// A step: the system, its state, and the work columns of the method.
#[derive(Debug)]
pub struct StepContext<'a, R: Real> {
    pub(crate) model: &'a Model<R>,
    pub(crate) settings: &'a Settings,
    /// The most evaluations that an adaptive method may take.
    pub(crate) most_evaluations: u64,
    pub(crate) level: Level,
    /// Simulated time at the start of the step, seconds.
    pub(crate) start: f64,
    /// Substeps finished.
    pub(crate) finished: u32,
    pub(crate) state: &'a mut Columns<R>,
    pub(crate) scratch: &'a mut Scratch<R>,
    /// The rows of shells, and the impulses from which they start.
    pub(crate) rows: &'a mut ShellRows<R>,
    pub(crate) done: Done,
}

/// The columns of a step, each a flat slice in the order of slots: number i of one belongs to
/// number i of the others. Slots without a particle hold zeros.
#[derive(Debug)]
pub struct Parts<'a, R> {
    /// Positions, metres.
    pub positions: &'a mut [R],
    /// Velocities, metres per second.
    pub velocities: &'a mut [R],
    /// Forces of the last evaluation, newtons.
    pub forces: &'a mut [R],
    /// Reciprocal masses, per kilogram; 0 where nothing moves the particle.
    pub inverse_masses: &'a [R],
    /// The work columns that the method asked for.
    pub work: &'a mut [Aligned<R>],
}

/// The columns of a step and N work columns, or the same part of each: the data of a pass.
pub(crate) struct Pass<'a, R, const N: usize> {
    pub(crate) positions: &'a mut [R],
    pub(crate) velocities: &'a mut [R],
    pub(crate) forces: &'a [R],
    pub(crate) inverse_masses: &'a [R],
    pub(crate) work: [&'a mut [R]; N],
}

impl<R: Real, const N: usize> Split for Pass<'_, R, N> {
    fn numbers(&self) -> usize {
        self.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_positions, positions) = self.positions.split_at_mut(numbers);
        let (low_velocities, velocities) = self.velocities.split_at_mut(numbers);
        let (low_forces, forces) = self.forces.split_at(numbers);
        let (low_inverse_masses, inverse_masses) = self.inverse_masses.split_at(numbers);
        let mut work = self.work.map(|column| column.split_at_mut(numbers));
        let low = Pass {
            positions: low_positions,
            velocities: low_velocities,
            forces: low_forces,
            inverse_masses: low_inverse_masses,
            work: work.each_mut().map(|halves| core::mem::take(&mut halves.0)),
        };
        let work = work.map(|halves| halves.1);
        (low, Pass { positions, velocities, forces, inverse_masses, work })
    }
}

impl<'a, R: Real> StepContext<'a, R> {
    /// The system that is stepped.
    pub fn model(&self) -> &'a Model<R> {
        self.model
    }

    /// The number of substeps in the step.
    pub fn substeps(&self) -> u32 {
        self.settings.substeps
    }

    /// Length of a substep, seconds.
    pub fn substep(&self) -> R {
        R::of(self.settings.substep())
    }

    /// Simulated time at the start of the current substep, seconds.
    pub fn time(&self) -> f64 {
        self.start + f64::from(self.finished) * self.settings.substep()
    }

    /// Simulated time at its end, seconds.
    pub(crate) fn end(&self) -> f64 {
        self.start + f64::from(self.finished + 1) * self.settings.substep()
    }

    /// The columns of the step.
    pub fn parts(&mut self) -> Parts<'_, R> {
        Parts {
            positions: &mut self.state.positions,
            velocities: &mut self.state.velocities,
            forces: &mut self.scratch.forces,
            inverse_masses: &self.model.inverse_mass_column,
            work: &mut self.scratch.columns,
        }
    }

    /// The columns of a pass with the first N work columns.
    pub(crate) fn pass<const N: usize>(&mut self) -> Pass<'_, R, N> {
        let work =
            self.scratch.columns.first_chunk_mut().expect("columns that the method asked for");
        Pass {
            positions: &mut self.state.positions,
            velocities: &mut self.state.velocities,
            forces: &self.scratch.forces,
            inverse_masses: &self.model.inverse_mass_column,
            work: work.each_mut().map(|column| &mut **column),
        }
    }

    /// Evaluates all forces at the current state and a time, seconds; returns the power dissipated,
    /// watts.
    pub fn set_forces(&mut self, time: f64) -> f64 {
        (Calls::of_precision().set_forces)(self, time)
    }

    /// The body of [`StepContext::set_forces`].
    fn evaluate(&mut self, time: f64) -> f64 {
        self.place(time);
        let Scratch { forces, work, power_of_pins, .. } = &mut *self.scratch;
        let motion = self.state.motion(&self.model.slots, time);
        let power = self.model.set_forces(self.level, &motion, work, forces);
        *power_of_pins = self.model.power_of_pins(forces, motion.velocities);
        power
    }

    /// Puts guided particles where they are at a time, seconds.
    pub(crate) fn place(&mut self, time: f64) {
        let Columns { positions, velocities } = &mut *self.state;
        self.model.place(time, [positions, velocities]);
    }

    /// Gives guided particles their mean velocities in the substep.
    pub(crate) fn lead(&mut self) {
        let (end, h) = (self.end(), self.settings.substep());
        self.model.lead((end, h), self.state);
    }

    /// Evaluates all forces at the current positions and the velocities in a work column, at the
    /// end of the substep; returns the power dissipated, watts.
    pub(crate) fn set_forces_predicted(&mut self, velocities: usize) -> f64 {
        let time = self.time() + self.settings.substep();
        let Scratch { forces, work, columns, power_of_pins, .. } = &mut *self.scratch;
        let Columns { positions, velocities: last } = &mut *self.state;
        self.model.place(time, [positions, last]);
        self.model.place(time, [positions, &mut columns[velocities]]);
        let motion =
            Motion { slots: &self.model.slots, positions, velocities: &columns[velocities], time };
        let power = self.model.set_forces(self.level, &motion, work, forces);
        *power_of_pins = self.model.power_of_pins(forces, motion.velocities);
        power
    }

    /// Ends a substep: lets every particle that has come into an obstacle rest, slide or bounce,
    /// and books `taken`, the energy that elements dissipated in it, joules.
    ///
    /// The displacement of a particle in the substep is taken to be h v', with v' the velocity at
    /// its end, and the last forces to be those at its start.
    pub fn finish_substep(&mut self, taken: f64) {
        (Calls::of_precision().finish_substep)(self, taken);
    }

    /// The body of [`StepContext::finish_substep`].
    fn end_substep(&mut self, taken: f64) {
        self.done.counted += taken;
        self.done.drive(self.scratch.power_of_pins * self.settings.substep());
        self.finish(Way::Kicked(0.0), Evaluated::AtStart);
    }

    /// Finds the contacts of the current positions at a time, seconds. Returns whether particles
    /// lie on obstacles, for a method that holds them there.
    pub(crate) fn find(&mut self, time: f64, evaluated: Evaluated) -> bool {
        let (positions, contacts) = (&self.state.positions, &mut self.scratch.contacts);
        let when = When { time, settles: evaluated.settles() };
        let [lies, touches] = self.model.find(self.level, positions, when, contacts);
        self.scratch.touches = touches;
        lies
    }

    /// Holds particles that lie on an obstacle after a kick with the accelerations in a work
    /// column: changes the current velocities, or those in another work column.
    pub(crate) fn settle(
        &mut self,
        velocities: Option<usize>,
        accelerations: usize,
        kick: Kick<R>,
    ) -> Contacts {
        let Columns { positions, velocities: present } = &mut *self.state;
        let Scratch { columns, contacts, .. } = &mut *self.scratch;
        let model = self.model;
        let Some(velocities) = velocities else {
            let pulls = (&*columns[accelerations], &**contacts);
            return model.settle(self.level, (positions, present), pulls, kick);
        };
        let two = columns.get_disjoint_mut([velocities, accelerations]);
        let [velocities, accelerations] = two.expect("two columns");
        model.settle(self.level, (positions, velocities), (accelerations, contacts), kick)
    }

    /// Whether shells have rows, in this substep.
    pub(crate) fn has_rows(&self) -> bool {
        !self.rows.is_empty()
    }

    /// The inputs of the rows of shells at the start of the substep.
    pub(super) fn rows_at(&self) -> At<'a, R> {
        self.model.shells_at(self.level, self.time())
    }

    /// Finds the rows of shells before a kick of `length` seconds by the forces of the last
    /// evaluation, and a drift of a substep at the velocities after it. Returns whether there are
    /// some. `is_drift` where that drift, and it alone, moves particles in every substep.
    pub(crate) fn find_rows(&mut self, length: R, is_drift: bool) -> bool {
        if !self.model.shells.do_meet() {
            return false;
        }
        if self.finished == 0 || !is_drift {
            self.rows.lose_track();
        }
        self.lead();
        let (h, at) = (self.substep(), self.rows_at());
        let Columns { positions, velocities } = &*self.state;
        let columns: [&[R]; 3] = [positions, velocities, &self.scratch.forces];
        let is_fast = self.rows.find(&at, columns, (length, h, R::ZERO));
        self.note_fast(is_fast);
        self.has_rows()
    }

    /// Takes note of whether particles are too fast for shells to be known to stop them, and of
    /// crossings that were seen.
    pub(super) fn note_fast(&mut self, is_fast: bool) {
        self.done.turned |= is_fast;
        self.done.passes += u64::from(is_fast);
        let crossed = self.rows.take_crossed();
        // More substeps of this step would not undo crossings before it.
        let to = if self.finished == 0 { &mut self.done.crossed } else { &mut self.done.passes };
        *to += crossed;
    }

    /// Ends a substep of these mean velocities in the solve of which shells met; `mirrors` where
    /// its last velocities are not those.
    pub(super) fn end_solved(&mut self, means: &[R], mirrors: bool) {
        let (h, at) = (self.substep(), self.rows_at());
        let Columns { positions, velocities } = &mut *self.state;
        let contacts = self.rows.end_solved(&at, ([positions, velocities], means), (h, mirrors));
        self.done.meet(contacts);
    }

    /// Lets shells meet after that kick, before the drift.
    pub(crate) fn meet_shells(&mut self, length: R) {
        let (h, at) = (self.substep(), self.rows_at());
        let Columns { positions, velocities } = &mut *self.state;
        let state: [&mut [R]; 2] = [positions, velocities];
        let contacts = self.rows.meet(&at, state, &self.scratch.forces, (length, h));
        self.done.meet(contacts);
    }

    /// Lets the rows of shells hold after a kick that no drift follows.
    pub(crate) fn hold_shells(&mut self, length: R) {
        let at = self.rows_at();
        let Columns { positions, velocities } = &mut *self.state;
        let kick = (&*self.scratch.forces, length);
        let contacts = self.rows.hold(&at, (positions, velocities), kick);
        self.done.passes += self.rows.take_crossed();
        self.done.meet(contacts);
    }

    /// Lets the rows of shells hold the velocities in a work column, which are predicted.
    pub(crate) fn hold_predicted(&mut self, velocities: usize) {
        self.rows.hold_predicted(&self.model.shells, &mut self.scratch.columns[velocities]);
    }

    /// Adds the impulses of shells to the forces, as forces that act for the substep.
    pub(crate) fn add_impulses(&mut self) {
        let h = self.substep();
        self.rows.add_forces(&self.model.shells, &mut self.scratch.forces, h);
    }

    /// Sets the mean velocities of the substep where shells are near each other: those in a work
    /// column, or the current ones.
    pub(crate) fn set_means(&mut self, column: Option<usize>) {
        let means = column.map_or(&self.state.velocities, |column| &self.scratch.columns[column]);
        self.rows.set_means(&self.model.shells, means);
    }

    /// Corrects the outcome of a substep of these mean velocities, whose stages had the impulses of
    /// shells as forces. `is_late` says whether those are the velocities of the start.
    pub(crate) fn end_shells(&mut self, is_late: bool) {
        let (h, at) = (self.substep(), self.rows_at());
        let Columns { positions, velocities } = &mut *self.state;
        let contacts = self.rows.end(&at, [positions, velocities], (h, is_late));
        self.done.passes += self.rows.take_crossed();
        self.done.meet(contacts);
    }

    /// Ends a substep, the displacement of which was made as `way` says; returns the contacts.
    pub(crate) fn finish(&mut self, way: Way, evaluated: Evaluated) -> Contacts {
        self.done.given -= self.scratch.work.own_power.min(0.0) * self.settings.substep();
        self.place(self.end());
        let contacts = self.meet_obstacles(way, evaluated);
        self.finished += 1;
        contacts
    }

    fn meet_obstacles(&mut self, way: Way, evaluated: Evaluated) -> Contacts {
        if self.model.obstacles.is_empty() {
            return Contacts::default();
        }
        let length = self.settings.substep();
        if self.finished == 0 && !self.model.obstacles.solids.is_empty() {
            self.scratch.fastest = fastest(self.level, &self.state.velocities);
        }
        let time = self.end();
        if !matches!(way, Way::BetweenKicks) {
            self.find(time, evaluated);
        }
        let Scratch { forces, columns, contacts, touches, fastest, .. } = &*self.scratch;
        // Particles may have gone through a solid.
        if !touches && self.model.obstacles.solids.is_empty() {
            return Contacts::default();
        }
        let (lag, starts, before) = match way {
            Way::Kicked(lag) => (lag, None, None),
            Way::BetweenKicks => (0.5, None, Some(&*columns[1])),
            Way::Kept => (0.5, Some(&*columns[0]), None),
        };
        let h = R::of(length);
        // Nothing gets twice as fast within a step unless it diverges.
        let reach = (*fastest + *fastest) * h;
        let substep = Substep { h, time, lag: h * R::of(lag), reach, starts, before, evaluated };
        let contacts = self.model.resolve(self.level, self.state, (forces, contacts), substep);
        self.done.meet(contacts);
        contacts
    }
}
