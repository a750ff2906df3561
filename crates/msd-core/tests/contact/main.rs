//! Contact with obstacles: one table of scenario, method and precision against a bound.
//!
//! Each method is a test that runs every scenario of [`table`] in f32 and f64, and lists what exceeds
//! its bound: `cargo test -p msd-core --test contact`.

#[path = "../common/mod.rs"]
mod common;
mod corners;
mod cubes;
mod curved;
mod slopes;
mod table;
mod turning;
mod walls;

use msd_core::Integrator;

#[test]
fn explicit_euler_keeps_its_bounds() {
    table::check(Integrator::ExplicitEuler);
}

#[test]
fn symplectic_euler_keeps_its_bounds() {
    table::check(Integrator::SymplecticEuler);
}

#[test]
fn velocity_verlet_keeps_its_bounds() {
    table::check(Integrator::VelocityVerlet);
}

#[test]
fn rk4_keeps_its_bounds() {
    table::check(Integrator::Rk4);
}

#[test]
fn dormand_prince_keeps_its_bounds() {
    table::check(Integrator::DormandPrince);
}

#[test]
fn backward_euler_keeps_its_bounds() {
    table::check(Integrator::BackwardEuler);
}

#[test]
fn implicit_midpoint_keeps_its_bounds() {
    table::check(Integrator::ImplicitMidpoint);
}

#[test]
fn xpbd_keeps_its_bounds() {
    table::check(Integrator::Xpbd);
}
