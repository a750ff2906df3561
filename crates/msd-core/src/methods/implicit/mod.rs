//! The implicit methods: stiff systems by long substeps, with a linear system for each.
//!
//! Both methods solve one stage for its velocity u: M (u − v) = τ f(x + τ u, u).
//!
//! | method | τ | x' | v' | evaluations per substep |
//! |---|---|---|---|---|
//! | backward Euler | h | x + h u | u | 1 per Newton iteration |
//! | implicit midpoint | h / 2 | x + h u | 2 u − v | 1 per Newton iteration |
//!
//! and one more for the energy where anything is damped. So the midpoint rule is backward Euler to
//! the middle and its mirror image from there.
//!
//! An iteration evaluates all forces at the stage as known so far, at first x + τ v, and solves (M
//! − τ ∂f/∂v − τ² ∂f/∂x) δu = M (v − u) + τ f (see [`tangent`]). Baraff and Witkin (1998) linearise
//! at x. From x + τ v the force is exact, only the matrix is not, and both methods keep their order
//! with one iteration and an approximate matrix. On a damped cloth at 1/240 s the midpoint rule is
//! then 10 times more accurate than from x with the same matrix (5e-6 of its size instead of 5e-5).
//!
//! # What to expect
//! Backward Euler damps a mode of frequency w by (1 + h² w²)^(−1/2) per step, whatever the dampers
//! do; that loss is not booked, so the total energy shows it. The midpoint rule damps no mode. At a
//! step that does not resolve a stiff motion of large amplitude it neither damps nor follows it. A
//! rope of 1 m, let go level, of 1e8 N/m and of 0.1 g and 1 kg in turn, swings on under backward
//! Euler at 1/60 s and flies apart under the linearised midpoint rule.
//!
//! A solve reduces its residual to 1e-3 for backward Euler and to 1e-6 for the midpoint rule, in
//! the norm of the preconditioner. Slow motions among stiff ones are then less accurate. The motion
//! of a body as a whole is solved separately (see [`whole`]): linear momentum is kept to rounding.
//! Where a solve does not get there, [`Solved`] reports how far it got, and a step that is of no
//! use is an error.
//!
//! # Contact
//! A particle on an obstacle is held in the solve, with Coulomb friction. A block at rest is in
//! balance at any step, where [`crate::contact::law`] alone would let it sag by some g h² per
//! substep. Shells that meet have their rows in the solve too (see [`row_solve`]).

mod conjugate;
mod resting;
mod tangent;
mod row_solve;
mod whole;

use super::StepContext;
use super::context::{Failure, Way};
use crate::columns::{Aligned, LANES, RECORD, vector};
use crate::contact::Evaluated;
use crate::elements::{Motion, Stage, column};
use crate::number::{Real, Vector, at_level};
use crate::system::{Columns, Model};
use alloc::boxed::Box;
use conjugate::{End, Goal, Solve};
use fearless_simd::Level;
use resting::{Holds, Span};
use row_solve::RowSolve;
use tangent::Tangent;
use whole::Wholes;

/// Scratch of a substep.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// The motion of the stage, x + τ u and u.
    stage: Columns<R>,
    tangent: Tangent<R>,
    solve: Solve<R>,
    holds: Holds<R>,
    wholes: Wholes,
    /// The momentum missing before a solve where there are shells, see [`RowSolve`].
    missing: Aligned<R>,
    course: Course,
}

/// Convergence of the solves of a step.
#[derive(Clone, Debug, Default)]
struct Course {
    /// The square of the largest residual that a solve of the substep started with.
    first: f64,
    /// Substeps of the step in which friction did not settle within the passes.
    unsettled: u32,
    /// Convergence of the solves of the step.
    solved: Solved,
}

/// The convergence of the linear solves of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Solved {
    /// Iterations of conjugate gradients.
    pub iterations: u64,
    /// The largest residual after a solve, as a fraction of that at its start; 0 where there was
    /// none.
    pub residual: f64,
    /// The residual that the method asks for, as such a fraction.
    pub tolerance: f64,
}

impl Solved {
    /// Adds the solves that followed.
    pub fn note(&mut self, other: Solved) {
        self.iterations += other.iterations;
        self.residual = self.residual.max(other.residual);
        self.tolerance = other.tolerance;
    }

    /// Whether a solve left a residual ten times as large as the method asks for.
    pub fn is_poor(&self) -> bool {
        10.0 * self.tolerance < self.residual
    }
}

impl<R: Real> Scratch<R> {
    fn new(model: &Model<R>) -> Self {
        let has_shells = model.shells.do_meet();
        Scratch {
            stage: Columns::new(&model.slots, 19),
            tangent: Tangent::new(model),
            solve: Solve::new(model),
            holds: Holds::new(model),
            wholes: Wholes::default(),
            missing: if has_shells { column(&model.slots, 35) } else { Aligned::default() },
            course: Course::default(),
        }
    }

    /// Convergence of the solves of the last step.
    pub(crate) fn solved(&self) -> Solved {
        self.course.solved
    }
}

/// The differences between the two methods.
#[derive(Clone, Copy, Debug)]
struct Rule {
    /// Length of the stage, as a fraction of the substep.
    fraction: f64,
    /// Whether a substep ends at the mirror image of its start, seen from the stage.
    mirrors: bool,
    goal: Goal,
}

/// v' = v + h a(x', v'), x' = x + h v'.
pub(crate) fn backward_euler<R: Real>(step: &mut StepContext<'_, R>) {
    let goal = Goal { tolerance: 1e-3, fewest: 2 };
    advance(step, Rule { fraction: 1.0, mirrors: false, goal });
}

/// v' = v + h a and x' = x + h v, both at the middle of the substep.
pub(crate) fn midpoint<R: Real>(step: &mut StepContext<'_, R>) {
    // An unfinished solve is a kick of h a times the tolerance in every substep: an error that no
    // shorter step lowers. Two iterations leave but (h w)⁴ of the residual in any case (or (h c)²),
    // which saves the order. A tolerance of 1e-3 would still show in the midpoint rule's error as
    // jumps of a fifth. For backward Euler it is far below the error of the method.
    let goal = Goal { tolerance: 1e-6, fewest: 2 };
    advance(step, Rule { fraction: 0.5, mirrors: true, goal });
}

fn advance<R: Real>(step: &mut StepContext<'_, R>, rule: Rule) {
    let scratch = step.scratch.implicit.take();
    let mut scratch = scratch.unwrap_or_else(|| Box::new(Scratch::new(step.model)));
    scratch.course = Course::default();
    scratch.wholes.find(step.model);
    for _ in 0..step.substeps() {
        match advance_substep(step, rule, &mut scratch) {
            Ok(taken) => step.done.counted += taken,
            Err(failure) => {
                step.done.failure = Some(failure);
                break;
            }
        }
        // The displacement was h u: with the midpoint rule the velocity is half a substep ahead of
        // it.
        let lag = if rule.mirrors { 0.5 } else { 0.0 };
        step.finish(Way::Kicked(lag), Evaluated::Solved);
    }
    // Friction that goes back and forth holds particles that should slip. A start may take a few
    // substeps.
    step.done.turned |= step.substeps() < 2 * scratch.course.unsettled;
    step.scratch.implicit = Some(scratch);
}

/// Advances by one substep and returns the energy dissipated by dampers and drag, joules.
fn advance_substep<R: Real>(
    step: &mut StepContext<'_, R>,
    rule: Rule,
    scratch: &mut Scratch<R>,
) -> Result<f64, Failure> {
    let (h, start, length) = (step.substep(), step.time(), step.settings.substep());
    let (tau, time) = (h * R::of(rule.fraction), start + rule.fraction * length);
    let (model, level) = (step.model, step.level);
    let span = Span { h, tau, start, stage: time, end: start + length };
    step.lead();
    step.done.meet(scratch.holds.find(model, &span, step.state));
    if model.shells.do_meet() {
        let at = step.rows_at();
        step.rows.find_for_solve(&at, [&step.state.positions, &step.state.velocities], h);
        step.rows.set_partings(&model.shells, &step.state.velocities);
        // In the stage an impulse acts for a part of the substep.
        step.rows.scale(rule.fraction);
    }
    scratch.stage.velocities.copy_from_slice(&step.state.velocities);
    scratch.holds.restrict(&mut scratch.stage.velocities);
    scratch.course.first = 0.0;
    for _ in 0..step.settings.newton {
        at_level!(level, _simd => set_positions(step.state, tau, &mut scratch.stage));
        let motion = scratch.stage.motion(&model.slots, time);
        model.set_forces(level, &motion, &mut step.scratch.work, &mut step.scratch.forces);
        improve(step, (tau, time), rule.goal, scratch)?;
    }
    at_level!(level, _simd => set_positions(step.state, tau, &mut scratch.stage));
    let power = power_taken(step, time, scratch);
    step.done.drive(step.scratch.power_of_pins * length);
    let Scratch { stage, holds, .. } = scratch;
    let contacts = holds.contacts(&stage.velocities, rule.fraction);
    if step.has_rows() {
        step.rows.keep_starts(&model.shells, &step.state.velocities);
    }
    at_level!(level, _simd => finish(step.state, stage, h, rule.mirrors));
    if step.has_rows() {
        step.rows.scale(1.0 / rule.fraction);
        step.end_solved(&stage.velocities, rule.mirrors);
    }
    step.done.meet(contacts + holds.settle(model, (h, span.end, rule.mirrors), step.state));
    Ok(power * length)
}

/// One Newton iteration: changes the velocities of the stage.
fn improve<R: Real>(
    step: &mut StepContext<'_, R>,
    (tau, time): (R, f64),
    goal: Goal,
    scratch: &mut Scratch<R>,
) -> Result<(), Failure> {
    let (model, level) = (step.model, step.level);
    let Scratch { stage, tangent, solve, holds, wholes, missing, course } = scratch;
    let Columns { positions, velocities } = stage;
    let (h, at) = (step.substep(), step.rows_at());
    let motion = Motion { slots: &model.slots, positions, velocities: &*velocities, time };
    let stage = Stage { moment: model.moment(level, motion), tau };
    tangent.linearise(model, &stage);
    solve.changes.fill(R::ZERO);
    let before = &*step.state.velocities;
    let set_residuals = |forces: &[R], residuals: &mut [R]| {
        let missing = Missing { masses: &model.mass_column, forces, before, now: velocities };
        at_level!(level, _simd => missing.set_residuals(tau, residuals));
    };
    if !wholes.is_empty() {
        // Forces of springs cancel in a sum, except for their rounding.
        let (work, others) = (&mut step.scratch.work, &mut solve.products);
        model.set_outer_forces(level, &motion, work, others);
        set_residuals(others, &mut solve.residuals);
        wholes.begin(level, &solve.residuals, tangent.diagonals());
    }
    set_residuals(&step.scratch.forces, &mut solve.residuals);
    let mut row_solve = RowSolve {
        rows: &mut *step.rows,
        at,
        h,
        gravity: model.gravity().extent(),
        positions: &step.state.positions,
        velocities,
        missing,
        least: R::ZERO,
        is_fast: false,
    };
    row_solve.begin(tangent.inverses(), solve);
    holds.begin(velocities, tangent.inverses(), &mut solve.residuals);
    holds.precondition(tangent.inverses(), solve);
    go_on((model, &stage, tangent), (solve, holds, wholes), (&mut row_solve, goal), course)?;
    let is_fast = row_solve.is_fast;
    at_level!(level, _simd => add::<R>(&solve.changes, velocities));
    holds.restrict(velocities);
    step.note_fast(is_fast);
    Ok(())
}

/// Solves until the particles that obstacles and shells hold have settled.
fn go_on<R: Real>(
    (model, stage, tangent): (&Model<R>, &Stage<'_, R>, &mut Tangent<R>),
    (solve, holds, wholes): (&mut Solve<R>, &mut Holds<R>, &mut Wholes),
    (row_solve, goal): (&mut RowSolve<'_, R>, Goal),
    course: &mut Course,
) -> Result<(), Failure> {
    let level = stage.moment.level;
    let mut asked = if wholes.is_empty() { 0.0 } else { solve.square(level) };
    let mut stalls = false;
    for pass in 1..=PASSES {
        // Rows push bodies as wholes.
        if row_solve.rows.is_empty() {
            wholes.shift(level, holds, tangent.diagonals(), solve);
        }
        let mut multiply = |direction: &[R], products: &mut [R]| {
            tangent.set_products(model, stage, direction, products);
            row_solve.rows.add_products(&model.shells, direction, products);
        };
        if holds.set_stops(row_solve.velocities, &solve.changes, &mut solve.directions) {
            solve.jump(level, &mut multiply);
            holds.set_aside(&mut solve.residuals);
        }
        let hold = |residuals: &mut [R]| holds.set_aside(residuals);
        let end = solve.run(level, (goal, asked), hold, multiply);
        asked = end.first;
        course.first = course.first.max(asked);
        let residual = judge(model, (level, stage.tau), solve, (&end, course.first))?;
        let (iterations, tolerance) = (end.iterations as u64, goal.tolerance);
        course.solved.note(Solved { iterations, residual, tolerance });
        let is_last = pass == PASSES;
        let goes_on =
            row_solve.has_shells() && row_solve.review(tangent.inverses(), solve, (pass, is_last));
        if is_last {
            course.unsettled += u32::from(stalls);
            break;
        }
        let changed = holds.review(row_solve.velocities, solve);
        // While impulses of rows change, so may the particles that lie on obstacles.
        stalls = changed && !goes_on;
        if !changed && !goes_on {
            break;
        }
        if row_solve.has_shells() {
            row_solve.renew((model, stage, tangent), (solve, holds));
        }
        holds.precondition(tangent.inverses(), solve);
    }
    if row_solve.has_shells() {
        wholes.give(level, &solve.products);
    }
    wholes.shift(level, holds, tangent.diagonals(), solve);
    Ok(())
}

/// The residual after a solve, as a fraction of `first`, a square, or the reason why the solve is
/// of no use. It met a NaN or an infinity, or did nothing against the weight of a particle that is
/// free to fall. The residual may have grown where it was rounding alone: that is reported and is
/// not an error.
fn judge<R: Real>(
    model: &Model<R>,
    (level, tau): (Level, R),
    solve: &Solve<R>,
    (end, first): (&End, f64),
) -> Result<f64, Failure> {
    let unsolved = |residual| Failure::Unsolved { residual, iterations: end.iterations as u64 };
    if !end.left.is_finite() {
        let particle = solve.first_not_finite(model.slots.places());
        return Err(particle.map_or(unsolved(f64::INFINITY), Failure::NotFinite));
    }
    let residual = if end.left == 0.0 { 0.0 } else { Real::sqrt((end.left / first).abs()) };
    if end.iterations == 0 && solve.is_left(level) && hangs(model, tau, &solve.residuals) {
        return Err(unsolved(1.0));
    }
    Ok(residual)
}

/// Whether a particle that is free to fall keeps half of its weight in its residual. The products
/// of residuals and changes, which an iteration relies on, may underflow.
#[cold]
fn hangs<R: Real>(model: &Model<R>, tau: R, residuals: &[R]) -> bool {
    model.slots.places().any(|at| {
        let [weight, left] =
            [&*model.fields.weights, residuals].map(|column| vector::<R>(column, at).extent());
        model.inverse_mass_column[at] != R::ZERO && R::HALF * (tau * weight) < left
    })
}

/// Solves per Newton iteration at most, to find the particles that obstacles hold. Each starts
/// where the one before it ended; at rest the first is the last.
const PASSES: usize = 16;

/// The power dissipated at the stage, watts.
fn power_taken<R: Real>(step: &mut StepContext<'_, R>, time: f64, scratch: &mut Scratch<R>) -> f64 {
    let (model, level) = (step.model, step.level);
    let do_pins_move = model.do_pins_move(&scratch.stage.velocities);
    step.scratch.power_of_pins = 0.0;
    if !model.is_damped_at_all() && !do_pins_move {
        return 0.0;
    }
    let motion = scratch.stage.motion(&model.slots, time);
    // Nothing else reads the products between two solves.
    let (work, forces) = (&mut step.scratch.work, &mut scratch.solve.products);
    if model.is_damped() || do_pins_move {
        let power = model.set_forces(level, &motion, work, forces);
        step.scratch.power_of_pins = model.power_of_pins(forces, motion.velocities);
        power
    } else {
        model.set_outer_forces(level, &motion, work, forces)
    }
}

/// x + τ u.
#[inline(always)]
fn set_positions<R: Real>(state: &Columns<R>, tau: R, stage: &mut Columns<R>) {
    let n = state.positions.len();
    let (x, u) = (&state.positions[..n], &stage.velocities[..n]);
    let positions = &mut stage.positions[..n];
    for i in 0..n {
        positions[i] = x[i] + u[i] * tau;
    }
}

/// x' = x + h u, and v' = u or 2 u − v.
#[inline(always)]
fn finish<R: Real>(state: &mut Columns<R>, stage: &Columns<R>, h: R, mirrors: bool) {
    let n = state.positions.len();
    let (x, v) = (&mut state.positions[..n], &mut state.velocities[..n]);
    let u = &stage.velocities[..n];
    for i in 0..n {
        x[i] += u[i] * h;
    }
    if !mirrors {
        v.copy_from_slice(u);
        return;
    }
    for i in 0..n {
        v[i] = (u[i] + u[i]) - v[i];
    }
}

#[inline(always)]
fn add<R: Real>(changes: &[R], velocities: &mut [R]) {
    for (velocity, &change) in velocities.iter_mut().zip(changes) {
        *velocity += change;
    }
}

/// The terms of a residual: previous and current velocities, metres per second, masses and forces.
struct Missing<'a, R> {
    masses: &'a [R],
    forces: &'a [R],
    before: &'a [R],
    now: &'a [R],
}

impl<R: Real> Missing<'_, R> {
    /// τ f − M (u − v), the momentum still missing, kilogram metres per second.
    #[inline(always)]
    fn set_residuals(&self, tau: R, residuals: &mut [R]) {
        let rows = residuals.as_chunks_mut::<RECORD>().0.iter_mut();
        let rows = rows.zip(self.masses.as_chunks::<LANES>().0);
        let rows = rows.zip(self.forces.as_chunks::<RECORD>().0);
        let before = self.before.as_chunks::<RECORD>().0.iter();
        let velocities = before.zip(self.now.as_chunks::<RECORD>().0);
        for (((residual, mass), force), (before, now)) in rows.zip(velocities) {
            for axis in 0..3 {
                for (lane, &mass) in mass.iter().enumerate() {
                    let i = axis * LANES + lane;
                    residual[i] = force[i] * tau - (now[i] - before[i]) * mass;
                }
            }
        }
    }
}
