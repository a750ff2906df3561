//! How does a state advance by one substep with forces alone? One function per method, none of
//! which knows what a spring is: forces come from a closure.
//!
//! | method | evaluations per substep |
//! |---|---|
//! | explicit Euler | 1 |
//! | symplectic Euler | 1 |
//! | velocity Verlet | 1, and 1 more per step |
//! | RK4 | 4 |
//!
//! A step starts from positions and velocities alone, whatever the method: that is what makes
//! state files, stepping back and replay exact.

use crate::integrator::Explicit;
use crate::real::{Real, Vector};
use crate::system::{Motion, State};
use alloc::vec;
use alloc::vec::Vec;

/// What a substep forgets: work columns, as many as the method needs.
#[derive(Clone, Debug, Default)]
pub struct Scratch<R: Real> {
    forces: Vec<R::Vec3>,
    /// Accelerations of the last evaluation and of the one before it (velocity Verlet).
    accelerations: [Vec<R::Vec3>; 2],
    predicted: Vec<R::Vec3>,
    /// Start of the substep and weighted sums of its slopes (RK4).
    start: State<R>,
    slopes: State<R>,
    /// Power taken away at the last evaluation, watts.
    power: f64,
}

impl<R: Real> Scratch<R> {
    /// The forces of the last evaluation, newtons.
    pub fn forces(&self) -> &[R::Vec3] {
        &self.forces
    }

    /// Makes the work columns that a method needs for `count` particles.
    pub fn new(method: Explicit, count: usize) -> Self {
        let column = |wanted: bool| vec![R::Vec3::ZERO; if wanted { count } else { 0 }];
        let state = |wanted| State { positions: column(wanted), velocities: column(wanted) };
        let verlet = method == Explicit::VelocityVerlet;
        let rk4 = method == Explicit::Rk4;
        Scratch {
            forces: column(true),
            accelerations: [column(verlet), column(verlet)],
            predicted: column(verlet),
            start: state(rk4),
            slopes: state(rk4),
            power: 0.0,
        }
    }
}

/// One substep: how long, of what masses, and what the method may take for granted.
#[derive(Clone, Copy, Debug)]
pub struct Substep<'a, R: Real> {
    /// Length, seconds.
    pub h: R,
    /// Reciprocal masses, per kilogram; 0 holds a particle to its velocity.
    pub inverse_masses: &'a [R],
    /// Whether the scratch holds the accelerations at this state.
    pub warm: bool,
    /// Whether a force depends on velocity.
    pub damped: bool,
}

/// Advances `state` by one substep and returns the energy taken away by dampers and drag, joules.
///
/// `force` overwrites its last argument with the forces at a motion, newtons, and returns the
/// power taken away, watts.
///
/// Velocity Verlet evaluates dampers at v + h/2 a_n + h/4 (a_n + a_(n−1)). The mean of two
/// accelerations makes the method second order with dampers too, at one evaluation, and vanishes
/// for a motion that changes sign every substep, so that the stable step is about that of
/// symplectic Euler (see [`crate::region`]; Groot and Warren, 1997, extrapolate with a_n alone,
/// which costs up to half of the stable step).
pub fn advance<R: Real>(
    method: Explicit,
    substep: Substep<'_, R>,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    match method {
        Explicit::Euler => explicit_euler(substep, state, scratch, force),
        Explicit::SymplecticEuler => symplectic_euler(substep, state, scratch, force),
        Explicit::VelocityVerlet => velocity_verlet(substep, state, scratch, force),
        Explicit::Rk4 => rk4(substep, state, scratch, force),
    }
}

fn explicit_euler<R: Real>(
    Substep { h, inverse_masses, .. }: Substep<'_, R>,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let power = force(state.motion(), &mut scratch.forces);
    drift(state, h);
    kick(state, &scratch.forces, inverse_masses, h);
    power * h.to_f64()
}

fn symplectic_euler<R: Real>(
    Substep { h, inverse_masses, .. }: Substep<'_, R>,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let power = force(state.motion(), &mut scratch.forces);
    kick(state, &scratch.forces, inverse_masses, h);
    drift(state, h);
    power * h.to_f64()
}

fn velocity_verlet<R: Real>(
    Substep { h, inverse_masses, warm, damped }: Substep<'_, R>,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let half = h * R::HALF;
    let quarter = half * R::HALF;
    let Scratch { forces, accelerations: [now, before], predicted, power, .. } = scratch;
    if !warm {
        *power = force(state.motion(), forces);
        set_accelerations(now, forces, inverse_masses);
        before.copy_from_slice(now);
    }
    let power_before = *power;
    for (velocity, &acceleration) in state.velocities.iter_mut().zip(now.iter()) {
        *velocity += acceleration * half;
    }
    drift(state, h);
    if damped {
        let rows = predicted.iter_mut().zip(&state.velocities).zip(now.iter().zip(before.iter()));
        for ((predicted, &velocity), (&now, &before)) in rows {
            *predicted = velocity + (now + before) * quarter;
        }
        core::mem::swap(now, before);
        *power = force(Motion { positions: &state.positions, velocities: predicted }, forces);
    } else {
        *power = force(state.motion(), forces);
    }
    set_accelerations(now, forces, inverse_masses);
    for (velocity, &acceleration) in state.velocities.iter_mut().zip(now.iter()) {
        *velocity += acceleration * half;
    }
    0.5 * (power_before + *power) * h.to_f64()
}

fn rk4<R: Real>(
    Substep { h, inverse_masses, .. }: Substep<'_, R>,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let Scratch { forces, start, slopes, .. } = scratch;
    start.positions.copy_from_slice(&state.positions);
    start.velocities.copy_from_slice(&state.velocities);
    slopes.positions.fill(R::Vec3::ZERO);
    slopes.velocities.fill(R::Vec3::ZERO);
    let two = R::ONE + R::ONE;
    let half = h * R::HALF;
    let mut energy = 0.0;
    for (weight, reach) in [(R::ONE, half), (two, half), (two, h)] {
        energy += weight.to_f64() * force(state.motion(), forces);
        for row in 0..forces.len() {
            let (velocity, acceleration) =
                (state.velocities[row], forces[row] * inverse_masses[row]);
            slopes.positions[row] += velocity * weight;
            slopes.velocities[row] += acceleration * weight;
            state.positions[row] = start.positions[row] + velocity * reach;
            state.velocities[row] = start.velocities[row] + acceleration * reach;
        }
    }
    energy += force(state.motion(), forces);
    let sixth = h / R::of(6.0);
    for row in 0..forces.len() {
        let last = forces[row] * inverse_masses[row];
        let slope = slopes.positions[row] + state.velocities[row];
        state.positions[row] = start.positions[row] + slope * sixth;
        state.velocities[row] = start.velocities[row] + (slopes.velocities[row] + last) * sixth;
    }
    energy * sixth.to_f64()
}

fn drift<R: Real>(state: &mut State<R>, h: R) {
    for (position, &velocity) in state.positions.iter_mut().zip(&state.velocities) {
        *position += velocity * h;
    }
}

fn kick<R: Real>(state: &mut State<R>, forces: &[R::Vec3], inverse_masses: &[R], h: R) {
    let rows = state.velocities.iter_mut().zip(forces).zip(inverse_masses);
    for ((velocity, &force), &inverse_mass) in rows {
        *velocity += force * (inverse_mass * h);
    }
}

fn set_accelerations<R: Real>(
    accelerations: &mut [R::Vec3],
    forces: &[R::Vec3],
    inverse_masses: &[R],
) {
    let rows = accelerations.iter_mut().zip(forces).zip(inverse_masses);
    for ((acceleration, &force), &inverse_mass) in rows {
        *acceleration = force * inverse_mass;
    }
}
