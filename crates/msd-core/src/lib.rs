//! Elastic things as particles joined by springs and dampers, in 3D.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("msd-core needs a square root: enable the feature `std` (default) or `libm`");

pub mod collision;
pub mod energy;
pub mod error;
pub mod forces;
pub mod integrator;
pub mod interaction;
pub mod lattice;
pub mod part;
pub mod real;
pub mod scene;
pub mod shape;
pub mod simulation;
pub mod snapshot;
pub mod stability;
pub mod surface;
pub mod system;

pub use energy::{Energy, Momentum};
pub use error::{Divergence, Error};
pub use glam;
pub use integrator::Integrator;
pub use interaction::{Interaction, Select};
pub use lattice::{Lattice, Neighbours};
pub use part::{Material, Part};
pub use real::{Real, Vector};
pub use scene::{Body, Friction, Particle, Pin, Plane, Scene, Spring, World};
pub use simulation::{Settings, Simulation};
pub use snapshot::Snapshot;
pub use surface::{Corner, Surface};
pub use system::{Column, Grab, Model, Motion, State};
