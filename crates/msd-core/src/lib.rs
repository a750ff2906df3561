//! Elastic things as particles joined by springs and dampers, in 3D.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("msd-core needs a square root: enable the feature `std` (default) or `libm`");

pub mod real;
pub mod error;
pub mod surface;
pub mod scene;
pub mod part;
pub mod system;
pub mod snapshot;

pub use error::{Divergence, Error};
pub use glam;
pub use part::{Material, Part};
pub use real::{Real, Vector};
pub use scene::{Body, Friction, Particle, Pin, Plane, Scene, Spring, World};
pub use snapshot::Snapshot;
pub use surface::{Corner, Surface};
pub use system::{Column, Grab, Model, State};
