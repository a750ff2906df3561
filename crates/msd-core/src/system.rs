//! How does a scene run? As columns: a [`Model`] that a step reads, a [`State`] that it advances.

use crate::check::{check, check_mass, check_not_negative, check_scene, check_vector, is_finite};
use crate::error::Error;
use crate::real::{Real, Vector};
use crate::scene::{Body, Friction, Particle, Plane, Scene};
use alloc::vec::Vec;
use glam::DVec3;

/// A value per spring, stored once if all springs share it.
#[derive(Clone, Debug, PartialEq)]
pub enum Column<R> {
    /// One value for every spring.
    Same(R),
    /// A value for each spring.
    Each(Vec<R>),
}

impl<R: Real> Column<R> {
    /// The value of one spring.
    pub fn get(&self, spring: usize) -> R {
        match self {
            Column::Same(value) => *value,
            Column::Each(values) => values[spring],
        }
    }

    /// Whether every value is zero, so that a step can leave the term out.
    pub fn is_zero(&self) -> bool {
        *self == Column::Same(R::ZERO)
    }

    fn collect(values: impl ExactSizeIterator<Item = R> + Clone) -> Self {
        let first = values.clone().next().unwrap_or(R::ZERO);
        if values.clone().all(|value| value == first) {
            Column::Same(first)
        } else {
            Column::Each(values.collect())
        }
    }

    /// Sets the values of a range of springs out of `count`.
    pub(crate) fn set(&mut self, range: core::ops::Range<usize>, count: usize, value: R) {
        let mut values: Vec<R> = (0..count).map(|spring| self.get(spring)).collect();
        values[range].fill(value);
        *self = Column::collect(values.iter().copied());
    }

    /// Removes the value of one spring.
    pub(crate) fn remove(&mut self, spring: usize) {
        if let Column::Each(values) = self {
            values.remove(spring);
            // What is left may be all alike: a column has one form only.
            *self = Column::collect(values.iter().copied());
        }
    }

    fn convert<S: Real>(&self) -> Column<S> {
        match self {
            Column::Same(value) => Column::Same(S::of(value.to_f64())),
            Column::Each(values) => {
                Column::collect(values.iter().map(|value| S::of(value.to_f64())))
            }
        }
    }
}

/// A plane as a step reads it: its normal has length one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneColumn<R: Real> {
    /// Direction out of the solid, length one.
    pub normal: R::Vec3,
    /// Signed distance from the origin, metres.
    pub offset: R,
    /// Fraction of the normal speed returned, 0 to 1.
    pub restitution: R,
    /// What happens along the plane.
    pub friction: Friction,
}

/// A spring that holds a particle to a point in the world: the mouse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grab<R: Real> {
    /// The particle held.
    pub particle: u32,
    /// Where it is pulled to, metres.
    pub target: R::Vec3,
    /// Stiffness, newtons per metre.
    pub stiffness: R,
    /// Damping, newton seconds per metre.
    pub damping: R,
    /// The largest force, newtons.
    pub max_force: R,
}

/// What a step reads. Every column of particles has the same length, every end is a particle.
///
/// Built by [`Model::new`], changed only by interactions between two steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Model<R: Real> {
    pub(crate) masses: Vec<R>,
    /// 1 / mass, and 0 for a pinned particle: nothing moves it.
    pub(crate) inverse_masses: Vec<R>,
    pub(crate) ends: Vec<[u32; 2]>,
    pub(crate) rest_lengths: Vec<R>,
    pub(crate) stiffnesses: Column<R>,
    pub(crate) dampings: Column<R>,
    pub(crate) planes: Vec<PlaneColumn<R>>,
    pub(crate) grabs: Vec<Grab<R>>,
    /// Forces of one step on single particles, newtons.
    pub(crate) pushes: Vec<(u32, R::Vec3)>,
    pub(crate) gravity: R::Vec3,
    pub(crate) force: R::Vec3,
    pub(crate) drag: R,
    pub(crate) extent: R,
    pub(crate) size: f64,
    pub(crate) bodies: Vec<Body>,
}

/// What a step advances: as many positions as velocities as masses of the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<R: Real> {
    /// Positions, metres.
    pub positions: Vec<R::Vec3>,
    /// Velocities, metres per second.
    pub velocities: Vec<R::Vec3>,
}

/// Positions and velocities at which forces are wanted, one row per particle.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a, R: Real> {
    /// Positions, metres.
    pub positions: &'a [R::Vec3],
    /// Velocities, metres per second.
    pub velocities: &'a [R::Vec3],
}

impl<R: Real> Model<R> {
    /// Checks a scene and turns its rows into columns.
    ///
    /// # Errors
    /// The first row that is out of its domain in precision `R`: a mass that is not positive, a
    /// number that is not finite, an index that names nothing, a spring from a particle to itself.
    pub fn new(scene: &Scene) -> Result<(Self, State<R>), Error> {
        check_scene::<R>(scene)?;
        let masses: Vec<R> = scene.particles.iter().map(|p| R::of(p.mass)).collect();
        let mut inverse_masses: Vec<R> = masses.iter().map(|&mass| R::ONE / mass).collect();
        let mut state = State {
            positions: scene.particles.iter().map(|p| R::Vec3::of(p.position)).collect(),
            velocities: scene.particles.iter().map(|p| R::Vec3::of(p.velocity)).collect(),
        };
        for pin in &scene.pins {
            inverse_masses[pin.particle] = R::ZERO;
            state.velocities[pin.particle] = R::Vec3::of(pin.velocity);
        }
        let springs = scene.springs.iter();
        let model = Model {
            masses,
            inverse_masses,
            ends: springs.clone().map(|s| s.ends.map(|end| end as u32)).collect(),
            rest_lengths: springs.clone().map(|s| R::of(s.rest_length)).collect(),
            stiffnesses: Column::collect(springs.clone().map(|s| R::of(s.stiffness))),
            dampings: Column::collect(springs.map(|s| R::of(s.damping))),
            planes: scene.planes.iter().map(plane_column).collect(),
            grabs: Vec::new(),
            pushes: Vec::new(),
            gravity: R::Vec3::of(scene.world.gravity),
            force: R::Vec3::of(scene.world.force),
            drag: R::of(scene.world.drag),
            extent: R::of(scene.world.extent),
            size: size(scene),
            bodies: scene.bodies.clone(),
        };
        Ok((model, state))
    }

    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        self.masses.len()
    }

    /// The number of springs that are there: of the rows of [`Model::ends`], those not cut.
    pub fn spring_count(&self) -> usize {
        self.ends.len()
    }

    /// Whether a spring has been cut.
    pub fn is_cut(&self, spring: usize) -> bool {
        let _ = spring;
        false
    }

    /// Masses, kilograms.
    pub fn masses(&self) -> &[R] {
        &self.masses
    }

    /// Reciprocal masses, per kilogram; 0 for a pinned particle.
    pub fn inverse_masses(&self) -> &[R] {
        &self.inverse_masses
    }

    /// Whether a particle is pinned.
    pub fn is_pinned(&self, particle: usize) -> bool {
        self.inverse_masses[particle] == R::ZERO
    }

    /// The two particles of each spring.
    pub fn ends(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// Rest lengths, metres.
    pub fn rest_lengths(&self) -> &[R] {
        &self.rest_lengths
    }

    /// The stiffness of a spring, newtons per metre.
    pub fn stiffness(&self, spring: usize) -> R {
        self.stiffnesses.get(spring)
    }

    /// The damping of a spring, newton seconds per metre.
    pub fn damping(&self, spring: usize) -> R {
        self.dampings.get(spring)
    }

    /// Whether any spring has damping.
    pub fn is_damped(&self) -> bool {
        !self.dampings.is_zero()
    }

    /// The planes.
    pub fn planes(&self) -> &[PlaneColumn<R>] {
        &self.planes
    }

    /// The grabs that hold now.
    pub fn grabs(&self) -> &[Grab<R>] {
        &self.grabs
    }

    /// Gravitational acceleration, metres per second squared.
    pub fn gravity(&self) -> R::Vec3 {
        self.gravity
    }

    /// The uniform force on every particle, newtons.
    pub fn force(&self) -> R::Vec3 {
        self.force
    }

    /// Air drag, newton seconds per metre.
    pub fn drag(&self) -> R {
        self.drag
    }

    /// Bound of every coordinate, metres.
    pub fn extent(&self) -> R {
        self.extent
    }

    /// Size of the largest body at the start of the scene, metres: the diagonal of the box around
    /// it; where that is 0 the longest rest length, and 1 where that is 0 too. Errors and
    /// tolerances are told as fractions of it.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The named parts.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Refuses the first number that another precision cannot hold.
    fn check_fits<S: Real>(&self) -> Result<(), Error> {
        for (row, mass) in self.masses.iter().enumerate() {
            check_mass::<S>(("particle", row), mass.to_f64())?;
        }
        let world = ("world", 0);
        check_vector::<S>("gravity", world, self.gravity.to_f64())?;
        check_vector::<S>("force", world, self.force.to_f64())?;
        check_not_negative::<S>("drag", world, self.drag.to_f64())?;
        for (row, plane) in self.planes.iter().enumerate() {
            let offset = plane.offset.to_f64();
            check(is_finite::<S>(offset), "offset", ("plane", row), offset, "finite")?;
        }
        for (row, grab) in self.grabs.iter().enumerate() {
            let at = ("grab", row);
            check_vector::<S>("target", at, grab.target.to_f64())?;
            check_not_negative::<S>("stiffness", at, grab.stiffness.to_f64())?;
            check_not_negative::<S>("damping", at, grab.damping.to_f64())?;
        }
        for (row, (_, force)) in self.pushes.iter().enumerate() {
            check_vector::<S>("force", ("push", row), force.to_f64())?;
        }
        for row in 0..self.spring_count() {
            let at = ("spring", row);
            check_not_negative::<S>("rest length", at, self.rest_lengths[row].to_f64())?;
            check_not_negative::<S>("stiffness", at, self.stiffnesses.get(row).to_f64())?;
            check_not_negative::<S>("damping", at, self.dampings.get(row).to_f64())?;
        }
        Ok(())
    }

    /// The same model in another precision, each number rounded once.
    ///
    /// # Errors
    /// The first number that the other precision cannot hold.
    pub fn convert<S: Real>(&self) -> Result<Model<S>, Error> {
        self.check_fits::<S>()?;
        let scalars = |column: &[R]| column.iter().map(|value| S::of(value.to_f64())).collect();
        let vector = |value: R::Vec3| S::Vec3::of(value.to_f64());
        let grab = |grab: &Grab<R>| Grab {
            particle: grab.particle,
            target: vector(grab.target),
            stiffness: S::of(grab.stiffness.to_f64()),
            damping: S::of(grab.damping.to_f64()),
            max_force: S::of(grab.max_force.to_f64()),
        };
        let plane = |plane: &PlaneColumn<R>| PlaneColumn {
            normal: vector(plane.normal),
            offset: S::of(plane.offset.to_f64()),
            restitution: S::of(plane.restitution.to_f64()),
            friction: plane.friction,
        };
        let pushes = self.pushes.iter();
        // From the mass, as everywhere: a reciprocal rounded before would not fit it.
        let reciprocal = |(&w, &mass): (&R, &R)| {
            if w == R::ZERO { S::ZERO } else { S::ONE / S::of(mass.to_f64()) }
        };
        let inverse_masses = self.inverse_masses.iter().zip(&self.masses).map(reciprocal);
        Ok(Model {
            masses: scalars(&self.masses),
            inverse_masses: inverse_masses.collect(),
            ends: self.ends.clone(),
            rest_lengths: scalars(&self.rest_lengths),
            stiffnesses: self.stiffnesses.convert(),
            dampings: self.dampings.convert(),
            planes: self.planes.iter().map(plane).collect(),
            grabs: self.grabs.iter().map(grab).collect(),
            pushes: pushes.map(|&(particle, force)| (particle, vector(force))).collect(),
            gravity: vector(self.gravity),
            force: vector(self.force),
            drag: S::of(self.drag.to_f64()),
            extent: S::of(self.extent.to_f64()),
            size: self.size,
            bodies: self.bodies.clone(),
        })
    }
}

impl<R: Real> State<R> {
    /// Checks that every position is inside a world of this extent and every velocity finite;
    /// `inside` says so in words.
    pub(crate) fn check(&self, extent: R, inside: &'static str) -> Result<(), Error> {
        for (row, (position, velocity)) in self.positions.iter().zip(&self.velocities).enumerate() {
            let (at, reach) = (("particle", row), position.extent());
            check(reach <= extent, "position", at, reach.to_f64(), inside)?;
            let speed = velocity.extent().to_f64();
            check(speed.is_finite(), "velocity", at, speed, "finite")?;
        }
        Ok(())
    }

    /// Borrows the columns at which forces are evaluated.
    pub fn motion(&self) -> Motion<'_, R> {
        Motion { positions: &self.positions, velocities: &self.velocities }
    }

    /// The same state in another precision, each number rounded once.
    pub fn convert<S: Real>(&self) -> State<S> {
        let vectors =
            |column: &[R::Vec3]| column.iter().map(|value| S::Vec3::of(value.to_f64())).collect();
        State { positions: vectors(&self.positions), velocities: vectors(&self.velocities) }
    }
}

fn size(scene: &Scene) -> f64 {
    let diagonal = |particles: &[Particle]| {
        let mut positions = particles.iter().map(|particle| particle.position);
        let first = positions.next().unwrap_or_default();
        let grow = |(low, high): (DVec3, DVec3), x: DVec3| (low.min(x), high.max(x));
        let (low, high) = positions.fold((first, first), grow);
        let across = high - low;
        Real::sqrt(across.dot(across))
    };
    let bodies = scene.bodies.iter().map(|body| &scene.particles[body.particles.clone()]);
    let largest = bodies.map(diagonal).fold(0.0, f64::max);
    let whole = || diagonal(&scene.particles);
    let longest = || scene.springs.iter().map(|spring| spring.rest_length).fold(0.0, f64::max);
    let positive = |size: &f64| 0.0 < *size;
    let found = Some(largest).filter(positive).or_else(|| Some(whole()).filter(positive));
    found.or_else(|| Some(longest()).filter(positive)).unwrap_or(1.0)
}

fn plane_column<R: Real>(plane: &Plane) -> PlaneColumn<R> {
    // Divided by its largest component first: the square of a tiny or huge normal would not fit.
    let scaled = plane.normal / plane.normal.abs().max_element();
    let length = Real::sqrt(scaled.dot(scaled));
    PlaneColumn {
        normal: R::Vec3::of(scaled / length),
        offset: R::of(plane.offset),
        restitution: R::of(plane.restitution),
        friction: plane.friction,
    }
}
