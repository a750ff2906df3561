//! Elastic things as particles joined by springs and dampers, in 3D.
//!
//! A [`Scene`] (rows a person writes) is checked and becomes a [`Model`] (columns a step reads) and
//! a [`State`] (columns a step advances); a [`Simulation`] steps them:
//!
//! ```
//! use msd_core::{Interaction, Material, Scene, Select, Settings, Simulation, shape};
//!
//! # fn main() -> Result<(), msd_core::Error> {
//! let material = Material { mass: 0.1, stiffness: 200.0, damping: 0.5 };
//! let scene = Scene::of("cloth", shape::cloth([10, 10], 0.1, material)?);
//! let mut simulation = Simulation::<f32>::new(&scene, Settings::default())?;
//! simulation.queue(Interaction::Freeze { springs: Select::All })?;
//! for _ in 0..60 {
//!     simulation.step()?;
//! }
//! assert!((simulation.time() - 1.0).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! `std` (default) or `libm` for the square root, `serde` for rows, interactions and progress. The
//! crate knows no clock, window, file, thread or random source. SI units everywhere, y up, radians.
#![no_std]
#![deny(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("msd-core needs a square root: enable the feature `std` (default) or `libm`");

// In reading order: a file imports only from files above it (`tests/tidy.rs`).
pub mod real;
pub mod error;
pub mod surface;
pub mod scene;
mod check;
pub mod part;
mod origin;
pub mod system;
pub mod hash;
pub mod lattice;
pub mod shape;
pub mod snapshot;
pub mod forces;
pub mod integrator;
pub mod settings;
pub mod explicit;
pub mod tangent;
pub mod collision;
pub mod kernel;
mod conjugate;
mod resting;
pub mod implicit;
pub mod xpbd;
mod tableau;
mod pace;
mod stages;
mod support;
mod holds;
mod events;
pub mod dormand_prince;
mod engine;
pub mod energy;
pub mod ledger;
pub mod region;
mod dense;
mod spectrum;
mod few;
pub mod stability;
pub mod interaction;
mod effects;
mod guard;
pub mod simulation;
mod readings;
pub mod progress;
pub mod witness;

pub use check::{MAX_PARTICLES, MAX_SPRINGS};
pub use dormand_prince::Work;
pub use effects::Effects;
pub use energy::{Energy, Momentum};
pub use error::{Divergence, Error};
pub use glam;
pub use hash::state_hash;
pub use integrator::Integrator;
pub use interaction::{Interaction, Select};
pub use kernel::Instructions;
pub use lattice::{Lattice, Neighbours};
pub use ledger::Ledger;
pub use part::{Material, Part};
pub use progress::{Held, Progress};
pub use real::{Real, Vector};
pub use scene::{Body, Friction, Particle, Pin, Plane, Scene, Spring, World};
pub use settings::Settings;
pub use simulation::Simulation;
pub use snapshot::Snapshot;
pub use surface::{Corner, Surface};
pub use system::{Grab, Model, Motion, PlaneColumn, State};
pub use witness::Witness;
