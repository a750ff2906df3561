//! How does a scene run? As columns: a [`Model`] that a step reads and a [`State`] that it advances.

use crate::error::{Error, check, check_index};
use crate::real::{Real, Vector};
use crate::scene::{Body, Friction, Plane, Scene};
use alloc::vec::Vec;
use glam::DVec3;

/// The most particles a system may have.
pub const MAX_PARTICLES: usize = 1 << 24;
/// The most springs a system may have.
pub const MAX_SPRINGS: usize = 1 << 27;

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
        }
    }

    fn convert<S: Real>(&self) -> Column<S> {
        match self {
            Column::Same(value) => Column::Same(S::of(value.to_f64())),
            Column::Each(values) => {
                Column::Each(values.iter().map(|value| S::of(value.to_f64())).collect())
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
            bodies: scene.bodies.clone(),
        };
        Ok((model, state))
    }

    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        self.masses.len()
    }

    /// The number of springs.
    pub fn spring_count(&self) -> usize {
        self.ends.len()
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

    /// Stiffnesses, newtons per metre.
    pub fn stiffnesses(&self) -> &Column<R> {
        &self.stiffnesses
    }

    /// Dampings, newton seconds per metre.
    pub fn dampings(&self) -> &Column<R> {
        &self.dampings
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

    /// The named parts.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The same model in another precision, each number rounded once.
    pub fn convert<S: Real>(&self) -> Model<S> {
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
        Model {
            masses: scalars(&self.masses),
            inverse_masses: scalars(&self.inverse_masses),
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
            bodies: self.bodies.clone(),
        }
    }
}

impl<R: Real> State<R> {
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

fn check_scene<R: Real>(scene: &Scene) -> Result<(), Error> {
    if scene.particles.is_empty() {
        return Err(Error::Empty);
    }
    check_count("the number of particles", scene.particles.len(), MAX_PARTICLES)?;
    check_count("the number of springs", scene.springs.len(), MAX_SPRINGS)?;
    check_world::<R>(scene)?;
    for (row, particle) in scene.particles.iter().enumerate() {
        let at = ("particle", row);
        check_mass::<R>(at, particle.mass)?;
        let bound = scene.world.extent;
        for value in particle.position.to_array() {
            check(value.abs() <= bound, "position", at, value, "finite and inside the world")?;
        }
        check_vector::<R>("velocity", at, particle.velocity)?;
    }
    let count = scene.particles.len();
    for (row, spring) in scene.springs.iter().enumerate() {
        let at = ("spring", row);
        for end in spring.ends {
            check_index(at, "particle", end, count)?;
        }
        if spring.ends[0] == spring.ends[1] {
            return Err(Error::Loop { row, particle: spring.ends[0] });
        }
        check_not_negative::<R>("rest length", at, spring.rest_length)?;
        check_not_negative::<R>("stiffness", at, spring.stiffness)?;
        check_not_negative::<R>("damping", at, spring.damping)?;
    }
    for (row, plane) in scene.planes.iter().enumerate() {
        check_plane::<R>(row, plane)?;
    }
    for (row, pin) in scene.pins.iter().enumerate() {
        check_index(("pin", row), "particle", pin.particle, count)?;
        check_vector::<R>("velocity", ("pin", row), pin.velocity)?;
    }
    for (row, body) in scene.bodies.iter().enumerate() {
        check_body(row, body, scene)?;
    }
    Ok(())
}

fn check_body(row: usize, body: &Body, scene: &Scene) -> Result<(), Error> {
    let at = ("body", row);
    let count = scene.particles.len();
    for (target, range, count) in
        [("particle", &body.particles, count), ("spring", &body.springs, scene.springs.len())]
    {
        check_index(at, target, range.end, count + 1)?;
        let ordered = range.start <= range.end;
        check(ordered, "start of a range", at, range.start as f64, "at most its end")?;
    }
    for corner in &body.surface.corners {
        check_index(at, "particle", corner.particle as usize, count)?;
    }
    for &corner in body.surface.triangles.iter().flatten() {
        check_index(at, "corner", corner as usize, body.surface.corners.len())?;
    }
    Ok(())
}

fn check_world<R: Real>(scene: &Scene) -> Result<(), Error> {
    let at = ("world", 0);
    let world = &scene.world;
    check_vector::<R>("gravity", at, world.gravity)?;
    check_vector::<R>("force", at, world.force)?;
    check_not_negative::<R>("drag", at, world.drag)?;
    // A bound, not `is_finite`: the square of a length overflows long before a position does.
    let in_domain = 0.0 < world.extent && world.extent <= 1e12;
    check(in_domain, "extent", at, world.extent, "positive and at most 1e12")
}

fn check_plane<R: Real>(row: usize, plane: &Plane) -> Result<(), Error> {
    let at = ("plane", row);
    let largest = plane.normal.extent();
    let direction = largest.is_finite() && 0.0 < largest;
    check(direction, "normal", at, largest, "a finite vector that is not zero")?;
    check(is_finite::<R>(plane.offset), "offset", at, plane.offset, "finite")?;
    check_fraction("restitution", at, plane.restitution)?;
    check_friction(at, plane.friction)
}

pub(crate) fn check_friction(at: (&'static str, usize), friction: Friction) -> Result<(), Error> {
    match friction {
        Friction::Coulomb(factor) => check_not_negative::<f32>("friction", at, factor),
        Friction::TangentialLoss(loss) => check_fraction("tangential loss", at, loss),
    }
}

pub(crate) fn check_fraction(
    quantity: &'static str,
    at: (&'static str, usize),
    value: f64,
) -> Result<(), Error> {
    check((0.0..=1.0).contains(&value), quantity, at, value, "from 0 to 1")
}

pub(crate) fn check_mass<R: Real>(at: (&'static str, usize), mass: f64) -> Result<(), Error> {
    // The reciprocal must fit too: it is what a step multiplies by.
    let rounded = R::of(mass);
    let usable =
        R::ZERO < rounded && is_finite::<R>(mass) && is_finite::<R>(1.0 / rounded.to_f64());
    check(usable, "mass", at, mass, "positive and finite")
}

pub(crate) fn check_not_negative<R: Real>(
    quantity: &'static str,
    at: (&'static str, usize),
    value: f64,
) -> Result<(), Error> {
    let in_domain = 0.0 <= value && is_finite::<R>(value);
    check(in_domain, quantity, at, value, "finite and not negative")
}

pub(crate) fn check_vector<R: Real>(
    quantity: &'static str,
    at: (&'static str, usize),
    value: DVec3,
) -> Result<(), Error> {
    for component in value.to_array() {
        check(is_finite::<R>(component), quantity, at, component, "finite")?;
    }
    Ok(())
}

fn check_count(what: &'static str, count: usize, limit: usize) -> Result<(), Error> {
    if count <= limit { Ok(()) } else { Err(Error::TooLarge { what, count: count as u128, limit }) }
}

/// Whether a number is finite after rounding to precision `R`.
pub(crate) fn is_finite<R: Real>(value: f64) -> bool {
    R::of(value).to_f64().is_finite()
}
