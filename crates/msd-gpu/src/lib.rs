//! Steps mass-spring-damper systems on a graphics card, with the same bits as `msd-core`.
//!
//! The laws of the core are functions over a number type. One such type records each operation and
//! writes the laws as WGSL, in a form that no compiler may fuse or reorder (`shader/`). Each
//! particle gathers its springs in the order in which the core adds them (`rows.rs`). So a device
//! computes the same bits: errors, limits and settings measured on the processor hold for it.
//!
//! ```no_run
//! use msd_gpu::{Device, GpuSimulation, Verdict, probe};
//! # use msd_core::{Material, Scene, Settings, Simulation, shape};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let cloth = shape::cloth([400, 400], 0.01, Material::default())?;
//! # let mut simulation = Simulation::<f32>::new(&Scene::of("cloth", cloth), Settings::default())?;
//! let device = pollster::block_on(Device::open(""))?;
//! if let Verdict::SameBits(manner) = pollster::block_on(probe(&device))? {
//!     let device = device.with_manner(manner);
//!     let mut gpu = pollster::block_on(GpuSimulation::new(&device, &simulation))?;
//!     gpu.advance(&mut simulation, 600)?;
//! }
//! # Ok(())
//! # }
//! ```

// In reading order: a file imports only from files above it (`tests/tidy/order.rs`).
mod error;
mod shader;
mod device;
mod rests;
mod probe;
mod bends;
mod rows;
mod params;
mod check;
mod instances;
mod simulation;
mod ensemble;

pub use device::{CAN_WAIT, Device, adapters};
pub use ensemble::Ensemble;
pub use error::GpuError;
pub use instances::Outcome;
pub use probe::{Verdict, manners, probe, sources};
pub use shader::symbol::Spelling;
pub use shader::{Manner, Roots};
pub use simulation::{GpuSimulation, Tally};
