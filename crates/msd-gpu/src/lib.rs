//! Steps mass-spring-damper systems on a graphics card, to the bits of `msd-core`.
//!
//! The laws of the core are functions over numbers. A number that records what is done to it writes
//! them as WGSL, in a form that no compiler may fuse or reorder (`shader/`). Springs are gathered
//! particle by particle in the order of the sums of the core (`rows.rs`). So a device computes the
//! same bits, and all that was measured on the processor holds for it: errors, limits, tuning.
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
mod probe;
mod rows;
mod check;
mod instances;
mod simulation;
mod ensemble;

pub use device::{Device, adapters};
pub use ensemble::Ensemble;
pub use error::GpuError;
pub use instances::Outcome;
pub use probe::Verdict;
pub use probe::probe;
pub use shader::symbol::Spelling;
pub use shader::{Manner, Roots};
pub use simulation::{GpuSimulation, Tally};
