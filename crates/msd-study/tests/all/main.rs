//! Studies, sweeps and inspections.

mod audit;
mod fleets;
mod inspection;
mod lessons;
mod space;
mod studies;
mod sweep;
mod terms;
