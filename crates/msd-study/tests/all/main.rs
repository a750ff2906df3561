//! Studies, sweeps and inspections.

mod audit;
mod inspection;
mod space;
mod studies;
mod sweep;
mod terms;
