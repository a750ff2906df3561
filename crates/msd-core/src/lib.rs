//! Mass-spring-damper systems in 3D: cloth, jelly, rope or any mesh, as particles joined by springs
//! and dampers.
//!
//! A [`Scene`] (rows that a person or a program writes) is checked and becomes a [`Model`] (columns
//! that a step reads) and a [`State`] (columns that a step advances). A [`Simulation`] steps them,
//! in `f32` or `f64`:
//!
//! ```
//! use msd_core::{Material, Scene, Settings, Simulation, shape};
//!
//! # fn main() -> Result<(), msd_core::Error> {
//! let material = Material { mass: 0.1, stiffness: 200.0, damping: 0.5 };
//! let scene = Scene::of("cloth", shape::cloth([10, 10], 0.1, material)?);
//! let mut simulation = Simulation::<f32>::new(&scene, Settings::default())?;
//! for _ in 0..60 {
//!     simulation.step()?;
//! }
//! assert!((simulation.time() - 1.0).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```
//!
//! SI units everywhere, y up, radians. The crate knows no clock, window, file or random source. The
//! same scene has the same bits in every build, with all [`Instructions`] and on any number of
//! threads.
//!
//! # Read positions
//!
//! Particles keep the order of the scene, and their numbers for good. [`Simulation::positions`]
//! iterates over all of them, [`Simulation::copy_positions`] fills a vertex buffer, and
//! [`Simulation::snapshot`] borrows all that a renderer needs.
//!
//! ```
//! # use msd_core::{Material, Scene, Settings, Simulation, shape};
//! # fn main() -> Result<(), msd_core::Error> {
//! # let scene = Scene::of("rope", shape::rope(5, 0.1, Material::default())?);
//! # let mut simulation = Simulation::<f32>::new(&scene, Settings::default())?;
//! simulation.step()?;
//! let lowest = simulation.positions().map(|position| position.y).fold(f32::MAX, f32::min);
//! let mut vertices: Vec<[f32; 3]> = Vec::new(); // kept from frame to frame
//! simulation.copy_positions(&mut vertices);
//! assert_eq!(vertices[0], simulation.position(0).to_array());
//! # assert!(lowest < 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! # Own force
//!
//! Implement [`Element`](elements::Element) and give it to a running simulation: the methods, the
//! energy, the [`Witness`] of drift and the predicted stable step take it into account.
//!
//! ```
//! use msd_core::elements::{Element, Motion, Vectors};
//! use msd_core::{Real, Vector, glam::DVec3};
//!
//! /// Air drag towards a wind along z, newton seconds per metre.
//! #[derive(Debug)]
//! struct Wind(f64);
//!
//! impl<R: Real> Element<R> for Wind {
//!     fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
//!         let mut dissipated = 0.0;
//!         for particle in 0..motion.particle_count() {
//!             let velocity = motion.velocity(particle).to_f64();
//!             let force = (4.0 * DVec3::Z - velocity) * self.0;
//!             forces.add(particle, R::Vec3::of(force));
//!             dissipated -= force.dot(velocity); // negative: the wind drives
//!         }
//!         dissipated
//!     }
//! }
//! # use msd_core::{Material, Scene, Settings, Simulation, shape};
//! # fn main() -> Result<(), msd_core::Error> {
//! # let scene = Scene::of("rope", shape::rope(5, 0.1, Material::default())?);
//! # let mut simulation = Simulation::<f32>::new(&scene, Settings::default())?;
//! simulation.add_element(Wind(0.05));
//! simulation.step()?;
//! # assert!(0.0 < simulation.given());
//! # Ok(())
//! # }
//! ```
//!
//! An [`Obstacle`](obstacles::Obstacle) (a gap and a normal) and a [`Method`](methods::Method) of
//! time integration are added alike, by [`Simulation::add_obstacle`] and
//! [`Simulation::set_method`]. [`testing`] checks the mathematics of elements and obstacles.
//!
//! # Which method
//!
//! | the scene | [`Integrator`] |
//! |---|---|
//! | most scenes: second order, one force evaluation per substep | `VelocityVerlet`, the default |
//! | stiff springs at long steps; damps fast motions | `BackwardEuler` |
//! | stiff springs at long steps, without damping them | `ImplicitMidpoint` |
//! | a smooth motion to many digits | `Rk4` |
//! | a reference: an error within a tolerance, impacts located in time | `DormandPrince` |
//! | a bounded cost per frame at any stiffness, accuracy aside | `Xpbd` |
//!
//! `SymplecticEuler` and `ExplicitEuler` are there to compare with. An explicit method is stable up
//! to a substep that [`Simulation::stable_substep`] predicts:
//!
//! ```
//! # use msd_core::{Integrator, Material, Scene, Settings, Simulation, shape};
//! # fn main() -> Result<(), msd_core::Error> {
//! # let material = Material { mass: 0.01, stiffness: 1e4, damping: 0.1 };
//! # let scene = Scene::of("rope", shape::rope(5, 0.1, material)?);
//! # let mut simulation = Simulation::<f32>::new(&scene, Settings::default())?;
//! let mut settings = simulation.settings();
//! let needed = settings.step / (0.8 * simulation.stable_substep());
//! if needed <= 64.0 {
//!     settings.substeps = needed.ceil().max(1.0) as u32;
//! } else {
//!     (settings.integrator, settings.substeps) = (Integrator::BackwardEuler, 1);
//! }
//! simulation.set_settings(settings)?;
//! simulation.step()?;
//! # Ok(())
//! # }
//! ```
//!
//! # Change while running
//!
//! User input is an [`Interaction`]: it is checked, queued, and applied at the start of the next
//! step. Particles, springs, bodies and planes are added and removed at any time; numbers are never
//! reused. The precision changes by [`Simulation::convert`].
//!
//! ```
//! # use msd_core::{Interaction, Material, Particle, Scene, Select, Settings, Simulation, Spring};
//! # use msd_core::{glam::DVec3, shape};
//! # fn main() -> Result<(), msd_core::Error> {
//! # let scene = Scene::of("rope", shape::rope(5, 0.1, Material::default())?);
//! # let mut simulation = Simulation::<f32>::new(&scene, Settings::default())?;
//! let springs = Select::Body(0);
//! simulation.queue(Interaction::SetStiffness { springs, value: 500.0 })?;
//! simulation.queue(Interaction::Pin { particle: 0, velocity: DVec3::ZERO })?;
//! simulation.queue(Interaction::Cut { spring: 2 })?;
//! let position = DVec3::new(0.3, 0.0, 0.0);
//! let end = simulation.add_particle(Particle { position, velocity: DVec3::ZERO, mass: 1.0 })?;
//! let (rest_length, stiffness, damping) = (0.1, 1000.0, 0.5);
//! simulation.add_spring(Spring { ends: [4, end], rest_length, stiffness, damping })?;
//! simulation.step()?;
//! assert!(simulation.model().is_cut(2));
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//!
//! | feature | default | |
//! |---|---|---|
//! | `std` | yes | the square root, and the best instructions of the processor at run time |
//! | `libm` | | the square root without `std`; one of the two is needed |
//! | `serde` | | rows, settings, interactions and [`Progress`] can be serialised |
//! | `parallel` | | bodies of 100,000 springs and more are stepped on the threads of rayon |
//!
//! # Debug builds
//!
//! A step evaluates sixteen springs at a time through small generic functions. Without optimisation
//! each of these is a call instead of an instruction, and a step takes some two hundred times as
//! long. The loops are compiled in this crate, for `f32` and `f64`, so that these lines in the
//! `Cargo.toml` of your workspace make them as fast in a debug build as in a release build. The
//! assertions of the standard library alone make a step of a mesh take five times as long.
//!
//! ```toml
//! [profile.dev.package.msd-core]
//! opt-level = 3
//! debug-assertions = false
//! ```
#![no_std]
#![deny(unsafe_code)]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("msd-core needs a square root: enable the feature `std` (default) or `libm`");

// In reading order: a file imports only from files above it (`tests/tidy/order.rs`).
mod number;
mod pack;
mod error;
mod columns;
mod triangle;
pub mod scene;
pub mod elements;
pub mod obstacles;
mod contact;
pub mod laws;
mod system;
pub mod stability;
pub mod methods;
pub mod energy;
mod simulation;
pub mod testing;

pub use contact::Contacts;
pub use contact::shells::{RowImpulse, ShellPassage};
pub use elements::grabs::Grab;
pub use energy::{Energy, Ledger, Moduli, Momentum};
pub use error::{Divergence, Error};
pub use glam;
pub use methods::{Integrator, Settings};
pub use number::{Instructions, Real, Vector};
pub use obstacles::PlaneColumn;
pub use scene::lattice;
pub use scene::shape;
pub use scene::substance;
pub use scene::{
    Air, Bend, Bending, Between, Body, Corner, DistanceGrid, Elasticity, Friction, Guide, Gust,
    KeyFrame, Lattice, Lead, Look, MAX_PARTICLES, MAX_SPRINGS, Material, Neighbours, PALETTE, Part,
    Particle, Pattern, Pin, Plane, Scene, Shape, Shell, Solid, Spring, Substance, Surface, Volume,
    World,
};
pub use simulation::{
    Effects, Held, Interaction, MaterialNumber, Progress, Select, Simulation, Witness,
};
pub use system::hash::state_hash;
pub use system::{Model, Snapshot, State};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
