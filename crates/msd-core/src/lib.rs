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
//! # Elements, obstacles, methods
//! Three traits carry the crate, and each may be implemented outside it: an
//! [`Element`](elements::Element) pulls (springs, gravity and grabs are elements), an
//! [`Obstacle`](obstacles::Obstacle) stops (planes are obstacles), and a
//! [`Method`](methods::Method) advances (the [`Integrator`]s are methods). Give yours to a
//! simulation by [`Simulation::add_element`], [`Simulation::add_obstacle`] and
//! [`Simulation::set_method`]: energy, the [`Witness`] of drift and the predicted stable step see
//! them. [`testing`] checks their mathematics.
//!
//! Particles, springs and bodies keep their numbers for good, whatever is cut, removed or added
//! while a simulation runs. The same scene has the same bits in every build and with all
//! [`Instructions`].
//!
//! # Features
//! `std` (default) or `libm` for the square root; `serde` for rows, interactions and progress;
//! `parallel` for large bodies, cut into parts that are evaluated in parallel, with the same bits.
//! The crate knows no clock, window, file or random source. SI units everywhere, y up, radians.
#![no_std]
#![deny(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("msd-core needs a square root: enable the feature `std` (default) or `libm`");

// In reading order: a file imports only from files above it, but for the hooks in `number` that
// have the loops compiled here (`tests/tidy.rs`).
mod number;
mod error;
pub mod scene;
mod columns;
pub mod elements;
pub mod obstacles;
mod system;
pub mod stability;
pub mod methods;
pub mod energy;
mod simulation;
pub mod testing;

pub use elements::grabs::Grab;
pub use energy::{Energy, Ledger, Momentum};
pub use error::{Divergence, Error};
pub use glam;
pub use methods::{Integrator, Settings};
pub use number::{Instructions, Real, Vector};
pub use obstacles::{Contacts, PlaneColumn};
pub use scene::lattice;
pub use scene::shape;
pub use scene::{
    Body, Corner, Friction, Lattice, MAX_PARTICLES, MAX_SPRINGS, Material, Neighbours, Part,
    Particle, Pin, Plane, Scene, Spring, Surface, World,
};
pub use simulation::{Effects, Held, Interaction, Progress, Select, Simulation, Witness};
pub use system::hash::state_hash;
pub use system::{Model, Snapshot, State};
