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
//! at x; from x + τ v the force is exact, only the matrix is not, and both methods keep their order
//! with one iteration and an approximate matrix. On a damped cloth at 1/240 s the midpoint rule is
//! then 10 times more accurate than from x with the same matrix (5e-6 of its size instead of 5e-5).
//!
//! # What to expect
//! Backward Euler damps a mode of frequency w by (1 + h² w²)^(−1/2) per step, whatever the dampers
//! do; that loss is booked nowhere, so the total energy shows it. The midpoint rule damps no mode.
//! At a step that does not resolve a stiff motion of large amplitude it neither forgets nor follows
//! it: a rope of 1 m, let go level, of 1e8 N/m and of 0.1 g and 1 kg in turn, swings on under
//! backward Euler at 1/60 s and flies apart under the linearised midpoint rule.
//!
//! Linear momentum is kept to the tolerance of the solve, 1e-3 of the impulses in a substep for
//! backward Euler and 1e-6 for the midpoint rule.
//!
//! # Contact
//! What lies on an obstacle is held in the solve, with Coulomb friction: a block at rest is in
//! balance at any step, where [`crate::obstacles::contact`] alone would let it sag by some g h² per
//! substep.

mod conjugate;
mod resting;
mod tangent;

use super::StepContext;
use super::context::Way;
use crate::columns::{LANES, RECORD};
use crate::elements::Motion;
use crate::elements::springs::matrix::Stage;
use crate::number::{Real, at_level};
use crate::system::{Columns, Model};
use alloc::boxed::Box;
use conjugate::{Goal, Solve};
use resting::{Holds, Span};
use tangent::Tangent;

/// What a substep forgets.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// The motion of the stage, x + τ u and u.
    stage: Columns<R>,
    tangent: Tangent<R>,
    solve: Solve<R>,
    holds: Holds<R>,
}

impl<R: Real> Scratch<R> {
    fn new(model: &Model<R>) -> Self {
        Scratch {
            stage: Columns::new(&model.slots, 19),
            tangent: Tangent::new(model),
            solve: Solve::new(model),
            holds: Holds::new(model),
        }
    }
}

/// What the two methods differ in.
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
    // What a solve leaves undone is a kick of h a times the tolerance, in every substep: an error
    // that no shorter step lowers. Two iterations leave but (h w)⁴ of the residual in any case (or
    // (h c)²), which saves the order; a tolerance of 1e-3 would still show in the midpoint rule's
    // error as jumps of a fifth. For backward Euler it is far below the error of the method.
    let goal = Goal { tolerance: 1e-6, fewest: 2 };
    advance(step, Rule { fraction: 0.5, mirrors: true, goal });
}

fn advance<R: Real>(step: &mut StepContext<'_, R>, rule: Rule) {
    let scratch = step.scratch.implicit.take();
    let mut scratch = scratch.unwrap_or_else(|| Box::new(Scratch::new(step.model)));
    for _ in 0..step.substeps() {
        let taken = advance_substep(step, rule, &mut scratch);
        step.done.counted += taken;
        // The way was h u: with the midpoint rule the velocity is half a substep ahead of it.
        step.finish(Way::Kicked(if rule.mirrors { 0.5 } else { 0.0 }));
    }
    step.scratch.implicit = Some(scratch);
}

/// Advances by one substep and returns the energy taken away by dampers, drag and what is held,
/// joules.
fn advance_substep<R: Real>(
    step: &mut StepContext<'_, R>,
    rule: Rule,
    scratch: &mut Scratch<R>,
) -> f64 {
    let (h, start, length) = (step.substep(), step.time(), step.settings.substep());
    let (tau, time) = (h * R::of(rule.fraction), start + rule.fraction * length);
    let (model, level) = (step.model, step.level);
    let span = Span { h, start, stage: time, end: start + length };
    scratch.holds.find(model, &span, step.state);
    scratch.stage.velocities.copy_from_slice(&step.state.velocities);
    scratch.holds.restrict(&mut scratch.stage.velocities);
    for _ in 0..step.settings.newton {
        at_level!(level, _simd => set_positions(step.state, tau, &mut scratch.stage));
        let motion = scratch.stage.motion(&model.slots, time);
        model.set_forces(level, &motion, &mut step.scratch.springs, &mut step.scratch.forces);
        improve(step, (tau, time), rule.goal, scratch);
    }
    at_level!(level, _simd => set_positions(step.state, tau, &mut scratch.stage));
    let power = power_taken(step, time, scratch);
    let Scratch { stage, solve, holds, .. } = scratch;
    let held = holds.energy(&stage.velocities, &solve.residuals) / rule.fraction;
    at_level!(level, _simd => finish(step.state, stage, h, rule.mirrors));
    power * length + held + holds.settle(model, span.end, step.state)
}

/// One Newton iteration: changes the velocities of the stage.
fn improve<R: Real>(
    step: &mut StepContext<'_, R>,
    (tau, time): (R, f64),
    goal: Goal,
    scratch: &mut Scratch<R>,
) {
    let (model, level) = (step.model, step.level);
    let Scratch { stage: Columns { positions, velocities }, tangent, solve, holds } = scratch;
    let motion = Motion { slots: &model.slots, positions, velocities: &*velocities, time };
    let stage = Stage { level, motion, tau };
    tangent.linearise(model, &stage);
    solve.changes.fill(R::ZERO);
    let missing = Missing {
        masses: &model.mass_column,
        forces: &step.scratch.forces,
        before: &step.state.velocities,
        now: velocities,
    };
    at_level!(level, _simd => missing.set_residuals(tau, &mut solve.residuals));
    holds.add_friction(velocities, &mut solve.residuals);
    holds.precondition(tangent.inverses(), solve);
    let mut first = None;
    for _ in 0..PASSES {
        first = Some(solve.run(level, goal, first, |direction, products| {
            tangent.set_products(model, &stage, direction, products);
        }));
        if !holds.review(velocities, solve) {
            break;
        }
        holds.precondition(tangent.inverses(), solve);
    }
    at_level!(level, _simd => add::<R>(&solve.changes, velocities));
    holds.restrict(velocities);
}

/// Solves per Newton iteration at most, to find out what the obstacles hold. Each starts where the
/// one before it ended; at rest the first is the last.
const PASSES: usize = 4;

/// The power taken away at the stage, watts.
fn power_taken<R: Real>(step: &mut StepContext<'_, R>, time: f64, scratch: &mut Scratch<R>) -> f64 {
    let (model, level) = (step.model, step.level);
    if !model.is_damped_at_all() {
        return 0.0;
    }
    let motion = scratch.stage.motion(&model.slots, time);
    // Nothing else reads the products between two solves.
    let (work, forces) = (&mut step.scratch.springs, &mut scratch.solve.products);
    if model.is_damped() {
        model.set_forces(level, &motion, work, forces)
    } else {
        model.set_other_forces(level, &motion, work, forces)
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

/// What makes up a residual: velocities before and now, metres per second, masses and forces.
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
