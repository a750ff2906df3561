//! The laws of the core, its methods, and their guarantees. One binary: linking takes long.

#[path = "../common/mod.rs"]
mod common;
mod air;
mod bad_input;
mod bending;
mod closed_forms;
mod conservation;
mod contact_points;
mod dormand_prince;
mod elements;
mod forces;
mod fused;
mod guides;
mod half_spaces;
mod hinges;
mod implicit;
mod interactions;
mod lattice;
mod mass_ratios;
mod radii;
mod slowest;
mod solids;
mod solved;
mod substances;
mod volumes;
mod witness;
mod xpbd;
