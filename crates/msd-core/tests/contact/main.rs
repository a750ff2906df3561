//! Contact with obstacles: tables of scenario, method and precision against a bound.
//!
//! Each method is a test that runs every scenario of [`table::TABLE`] in f32 and f64, and lists the
//! measurements that exceed their bounds: `cargo test -p msd-core --test contact keeps_its_bounds`.
//! Those of [`table::ENDURANCE`] take longer.

#[path = "../common/mod.rs"]
mod common;
mod blocks;
mod corners;
mod cubes;
mod curved;
mod endurance;
mod impacts;
mod moving;
mod rods;
mod slopes;
mod table;
mod thick;
mod turning;
mod walls;

use msd_core::Integrator;
use table::{ENDURANCE, TABLE};

#[test]
fn explicit_euler_keeps_its_bounds() {
    table::check(TABLE, Integrator::ExplicitEuler);
}

#[test]
fn explicit_euler_endures() {
    table::check(ENDURANCE, Integrator::ExplicitEuler);
}

#[test]
fn symplectic_euler_keeps_its_bounds() {
    table::check(TABLE, Integrator::SymplecticEuler);
}

#[test]
fn symplectic_euler_endures() {
    table::check(ENDURANCE, Integrator::SymplecticEuler);
}

#[test]
fn velocity_verlet_keeps_its_bounds() {
    table::check(TABLE, Integrator::VelocityVerlet);
}

#[test]
fn velocity_verlet_endures() {
    table::check(ENDURANCE, Integrator::VelocityVerlet);
}

#[test]
fn rk4_keeps_its_bounds() {
    table::check(TABLE, Integrator::Rk4);
}

#[test]
fn rk4_endures() {
    table::check(ENDURANCE, Integrator::Rk4);
}

#[test]
fn dormand_prince_keeps_its_bounds() {
    table::check(TABLE, Integrator::DormandPrince);
}

#[test]
fn dormand_prince_endures() {
    table::check(ENDURANCE, Integrator::DormandPrince);
}

#[test]
fn backward_euler_keeps_its_bounds() {
    table::check(TABLE, Integrator::BackwardEuler);
}

#[test]
fn backward_euler_endures() {
    table::check(ENDURANCE, Integrator::BackwardEuler);
}

#[test]
fn implicit_midpoint_keeps_its_bounds() {
    table::check(TABLE, Integrator::ImplicitMidpoint);
}

#[test]
fn implicit_midpoint_endures() {
    table::check(ENDURANCE, Integrator::ImplicitMidpoint);
}

#[test]
fn xpbd_keeps_its_bounds() {
    table::check(TABLE, Integrator::Xpbd);
}

#[test]
fn xpbd_endures() {
    table::check(ENDURANCE, Integrator::Xpbd);
}

#[test]
#[ignore = "writes the table of docs/measured/trade.md to the file named by CONTACT_TABLE"]
fn the_page_is_written() {
    let file = std::env::var("CONTACT_TABLE").expect("the name of a file");
    std::fs::write(file, table::page()).expect("a file that can be written");
}
