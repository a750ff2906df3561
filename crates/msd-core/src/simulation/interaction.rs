//! Interactions: user input between two steps, as values that are queued, checked, applied and
//! recorded.

use super::material::{self, MaterialNumber};
use crate::elements::grabs::Grab;
use crate::energy::{self, centre_of_mass};
use crate::error::Error;
use crate::number::{Real, Vector};
use crate::obstacles::{ContactLaw, Placed, PlaneColumn};
use crate::scene::check::{self, check, check_index};
use crate::scene::{Friction, Look, Plane};
use crate::system::{Columns, Model};
use core::ops::Range;
use glam::DVec3;

/// Some of the particles, or some of the springs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Select {
    /// All of them.
    #[default]
    All,
    /// Those of one body.
    Body(usize),
    /// A single one.
    One(usize),
    /// Those from the first number up to but not including the second: one kind of spring of a
    /// lattice, say.
    Range(usize, usize),
}

/// One act of the user.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Interaction {
    /// Holds a particle to a point by a spring; grabbing it again moves the point.
    Grab {
        /// The particle.
        particle: usize,
        /// The point that it is pulled to, metres.
        target: DVec3,
        /// Frequency of the particle alone on this spring, hertz. It is capped at a tenth of the
        /// substeps per second, so that user input cannot blow up the scene.
        frequency: f64,
        /// Damping ratio ζ: 1 is critical.
        damping_ratio: f64,
        /// The largest force, newtons; finite.
        max_force: f64,
    },
    /// Lets go of a particle.
    Release {
        /// The particle.
        particle: usize,
    },
    /// Pins a particle, held still or moved at a constant velocity.
    Pin {
        /// The particle.
        particle: usize,
        /// Velocity, metres per second.
        velocity: DVec3,
    },
    /// Frees a pinned particle.
    Unpin {
        /// The particle.
        particle: usize,
    },
    /// Pushes a particle for the length of the next step.
    Push {
        /// The particle.
        particle: usize,
        /// The force, newtons.
        force: DVec3,
    },
    /// Removes a spring for good, and the bends and volumes across it; the others keep their
    /// numbers.
    Cut {
        /// The spring.
        spring: usize,
    },
    /// Sets stiffnesses.
    SetStiffness {
        /// Of which springs.
        springs: Select,
        /// The stiffness, newtons per metre.
        value: f64,
    },
    /// Sets dampings.
    SetDamping {
        /// Of which springs.
        springs: Select,
        /// The damping, newton seconds per metre.
        value: f64,
    },
    /// Sets masses.
    SetMass {
        /// Of which particles.
        particles: Select,
        /// The mass of each, kilograms.
        value: f64,
    },
    /// Sets rest lengths.
    SetRestLength {
        /// Of which springs.
        springs: Select,
        /// The rest length of each, metres.
        value: f64,
    },
    /// Multiplies rest lengths, up to the extent of the world: a body grows or shrinks.
    ScaleRestLength {
        /// Of which springs.
        springs: Select,
        /// The factor, positive.
        factor: f64,
    },
    /// Makes the current lengths the rest lengths; bends stay straight at rest, and volumes keep
    /// theirs.
    Freeze {
        /// Of which springs.
        springs: Select,
    },
    /// Changes momentum at once, shared in proportion to mass.
    Impulse {
        /// Of which particles.
        particles: Select,
        /// The impulse in all, newton seconds.
        impulse: DVec3,
    },
    /// Adds a turn about the centre of mass.
    Spin {
        /// Of which particles.
        particles: Select,
        /// Angular velocity added, radians per second.
        velocity: DVec3,
    },
    /// Sets gravity.
    SetGravity {
        /// The acceleration, metres per second squared.
        value: DVec3,
    },
    /// Sets restitution and friction of a plane.
    SetPlane {
        /// The plane.
        plane: usize,
        /// Fraction of the normal speed that a bounce returns, 0 to 1.
        restitution: f64,
        /// Friction along the plane.
        friction: Friction,
    },
    /// Sets the uniform force: wind, say.
    SetForce {
        /// The force on every particle, newtons.
        value: DVec3,
    },
    /// Sets the drag of the air.
    SetDrag {
        /// The drag of each particle, newton seconds per metre.
        value: f64,
    },
    /// Removes every plane: nothing stops a particle but user-defined obstacles.
    RemovePlanes,
    /// Adds a plane after those there; the next substep moves out the particles inside it.
    AddPlane {
        /// The plane.
        plane: Plane,
    },
    /// Multiplies a number of the material of bodies: of their springs, bends, volumes and masses
    /// alike.
    ScaleMaterial {
        /// The bodies: all, or one.
        bodies: Select,
        /// The number.
        number: MaterialNumber,
        /// The factor, positive.
        factor: f64,
    },
    /// Damps springs, bends and volumes of bodies by their stiffness (Kelvin and Voigt).
    SetRelaxationTime {
        /// The bodies: all, or one.
        bodies: Select,
        /// Damping over stiffness, seconds.
        value: f64,
    },
    /// Puts a solid somewhere with its current rotation, and lets it move steadily from then on:
    /// its key frames are dropped. The next substep moves out the particles inside it.
    MoveSolid {
        /// The solid.
        solid: usize,
        /// Its new middle, metres.
        position: DVec3,
        /// Velocity of its middle, metres per second.
        velocity: DVec3,
        /// Angular velocity about its middle, radians per second.
        spin: DVec3,
    },
    /// Sets how a body looks, which changes nothing of its motion.
    SetLook {
        /// The body.
        body: usize,
        /// Its new appearance.
        look: Look,
    },
}

/// The parts of a simulation that an interaction changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects {
    /// The springs, or their constants.
    pub springs: bool,
    /// Masses, or which particles are pinned.
    pub masses: bool,
    /// Positions or velocities.
    pub state: bool,
    /// The energy that a given state has.
    pub energy: bool,
    /// The grabs or their targets.
    pub grabs: bool,
}

impl Effects {
    /// The changes of either of two interactions.
    pub fn or(self, other: Effects) -> Effects {
        Effects {
            springs: self.springs | other.springs,
            masses: self.masses | other.masses,
            state: self.state | other.state,
            energy: self.energy | other.energy,
            grabs: self.grabs | other.grabs,
        }
    }
}

impl Interaction {
    /// The changes that the interaction makes. A push, the drag of the air, planes, solids and
    /// looks change none of these.
    pub fn effects(&self) -> Effects {
        use Interaction::*;
        let none = Effects::default();
        match self {
            Cut { .. } | SetStiffness { .. } | SetRestLength { .. } => {
                Effects { springs: true, energy: true, ..none }
            }
            ScaleRestLength { .. } | Freeze { .. } => {
                Effects { springs: true, energy: true, ..none }
            }
            SetDamping { .. } | SetRelaxationTime { .. } => Effects { springs: true, ..none },
            ScaleMaterial { .. } => {
                Effects { springs: true, masses: true, energy: true, grabs: true, ..none }
            }
            // A grab is weakened so that a lighter particle can follow it.
            SetMass { .. } => Effects { masses: true, energy: true, grabs: true, ..none },
            Pin { .. } => Effects { masses: true, state: true, ..none },
            Unpin { .. } => Effects { masses: true, ..none },
            Impulse { .. } | Spin { .. } => Effects { state: true, ..none },
            SetGravity { .. } | SetForce { .. } => Effects { energy: true, ..none },
            Grab { .. } | Release { .. } => Effects { grabs: true, ..none },
            Push { .. } | SetDrag { .. } => none,
            SetPlane { .. } | RemovePlanes | AddPlane { .. } | MoveSolid { .. } => none,
            SetLook { .. } => none,
        }
    }
}

/// Checks an interaction against a model.
pub(crate) fn check_interaction<R: Real>(
    model: &Model<R>,
    interaction: &Interaction,
) -> Result<(), Error> {
    use Interaction::*;
    let at = ("interaction", 0);
    let one = |index| check_index(at, "particle", index, model.particle_count());
    let masses = |select| check_select(model, select, ("particle", model.particle_count()));
    let among = |select| check_select(model, select, ("spring", model.ends().len()));
    match *interaction {
        Grab { particle, target, frequency, damping_ratio, max_force } => {
            one(particle)?;
            check::check_vector::<R>("target", at, target)?;
            check::check_not_negative::<R>("frequency", at, frequency)?;
            check::check_not_negative::<R>("damping ratio", at, damping_ratio)?;
            // In f64 even for a run in f32, where the largest number means no cap.
            check::check_not_negative::<f64>("force cap", at, max_force)
        }
        Release { particle } | Unpin { particle } => one(particle),
        Pin { particle, velocity } => {
            one(particle)?;
            check::check_vector::<R>("velocity", at, velocity)
        }
        Push { particle, force } => {
            one(particle)?;
            check::check_vector::<R>("force", at, force)
        }
        Cut { spring } => check_index(at, "spring", spring, model.ends().len()),
        Freeze { springs }
        | SetStiffness { springs, .. }
        | SetDamping { springs, .. }
        | SetRestLength { springs, .. }
        | ScaleRestLength { springs, .. } => {
            among(springs)?;
            check_number::<R>(interaction)
        }
        SetMass { particles, value } => {
            masses(particles)?;
            check::check_mass::<R>(at, value)
        }
        Impulse { particles, impulse: vector } | Spin { particles, velocity: vector } => {
            masses(particles)?;
            check::check_vector::<R>("vector", at, vector)
        }
        SetGravity { value } => check::check_vector::<R>("gravity", at, value),
        SetForce { value } => check::check_vector::<R>("force", at, value),
        SetPlane { plane, restitution, friction } => {
            check_index(at, "plane", plane, model.planes().len())?;
            check::check_fraction("restitution", at, restitution)?;
            check::check_friction(at, friction)
        }
        SetDrag { value } => check::check_not_negative::<R>("drag", at, value),
        RemovePlanes => Ok(()),
        AddPlane { plane } => check::check_plane::<R>(model.planes().len(), &plane),
        MoveSolid { solid, position, velocity, spin } => {
            check_index(at, "solid", solid, model.solids().len())?;
            let all = [("position", position), ("velocity", velocity), ("spin", spin)];
            all.into_iter().try_for_each(|(what, v)| check::check_vector::<R>(what, at, v))
        }
        ScaleMaterial { bodies, .. } | SetRelaxationTime { bodies, .. } => {
            check_bodies(model, bodies)?;
            check_number::<R>(interaction)
        }
        SetLook { body, look } => check_set_look(model, body, &look),
    }
}

/// Checks the number that springs or bodies are to have, or to be multiplied by.
fn check_number<R: Real>(interaction: &Interaction) -> Result<(), Error> {
    use Interaction::*;
    let at = ("interaction", 0);
    match *interaction {
        SetStiffness { value, .. } => check::check_not_negative::<R>("stiffness", at, value),
        SetDamping { value, .. } => check::check_not_negative::<R>("damping", at, value),
        SetRestLength { value, .. } => check::check_not_negative::<R>("rest length", at, value),
        SetRelaxationTime { value, .. } => {
            check::check_not_negative::<R>("relaxation time", at, value)
        }
        ScaleRestLength { factor, .. } | ScaleMaterial { factor, .. } => {
            let usable = 0.0 < factor && check::is_finite::<R>(factor);
            check(usable, "factor", at, factor, "positive and finite")
        }
        _ => Ok(()),
    }
}

/// Checks how a body is to look.
fn check_set_look<R: Real>(model: &Model<R>, body: usize, look: &Look) -> Result<(), Error> {
    let at = ("interaction", 0);
    check_index(at, "body", body, model.bodies.len())?;
    check::check_look(at, look)
}

/// Checks that a selection is of bodies.
fn check_bodies<R: Real>(model: &Model<R>, select: Select) -> Result<(), Error> {
    let at = ("interaction", 0);
    match select {
        Select::One(index) | Select::Range(index, _) => {
            check(false, "selection", at, index as f64, "all, or a body")
        }
        Select::All | Select::Body(_) => {
            check_select(model, select, ("particle", model.particle_count()))
        }
    }
}

fn check_select<R: Real>(
    model: &Model<R>,
    select: Select,
    (target, count): (&'static str, usize),
) -> Result<(), Error> {
    let at = ("interaction", 0);
    match select {
        Select::All => Ok(()),
        Select::Body(body) => check_index(at, "body", body, model.bodies.len()),
        Select::One(index) => check_index(at, target, index, count),
        Select::Range(start, end) => {
            check_index(at, target, start, count + 1)?;
            check_index(at, target, end, count + 1)?;
            check(start <= end, "start of a range", at, start as f64, "at most its end")
        }
    }
}

/// Applies a checked interaction, with `h` the substep and `time` the simulated time, in seconds.
pub(crate) fn apply<R: Real>(
    model: &mut Model<R>,
    state: &mut Columns<R>,
    (h, time): (f64, f64),
    interaction: Interaction,
) {
    use Interaction::*;
    match interaction {
        // It may have been removed since this was queued.
        Grab { particle, .. } | Pin { particle, .. } | Push { particle, .. }
            if model.is_removed(particle) => {}
        Grab { .. } => grab(model, h, interaction),
        Release { particle } => model.grabs.0.retain(|grab| grab.particle as usize != particle),
        Pin { particle, velocity } => pin(model, state, particle, R::Vec3::of(velocity)),
        Unpin { particle } if model.is_removed(particle) => {}
        Unpin { particle } => {
            model.guides.release(particle);
            model.inverse_masses[particle] = R::ONE / model.masses[particle];
        }
        Push { particle, force } => model.pushes.0.push((particle as u32, R::Vec3::of(force))),
        Cut { spring } => model.springs.cut(spring),
        SetMass { particles, value } => {
            set_mass(model, particles_of(model, particles), value);
            cap_grabs(model, h);
        }
        SetStiffness { springs, .. }
        | SetDamping { springs, .. }
        | SetRestLength { springs, .. }
        | ScaleRestLength { springs, .. }
        | Freeze { springs } => {
            let range = springs_of(model, springs);
            set_springs(model, state, range, interaction);
        }
        Impulse { particles, impulse } => {
            push_all(model, state, particles_of(model, particles), impulse)
        }
        Spin { particles, velocity } => {
            spin(model, state, particles_of(model, particles), velocity)
        }
        SetGravity { value } => model.fields.gravity = R::Vec3::of(value),
        SetForce { value } => model.fields.force = R::Vec3::of(value),
        SetPlane { plane, restitution, friction } => {
            // It may have been removed since this was queued.
            if let Some(plane) = model.obstacles.planes.get_mut(plane) {
                (plane.law, plane.friction) = (ContactLaw::new(restitution, friction), friction);
            }
        }
        SetDrag { value } => model.fields.drag = R::of(value),
        RemovePlanes => model.obstacles.planes.clear(),
        AddPlane { plane } => model.obstacles.planes.push(PlaneColumn::new(&plane)),
        MoveSolid { solid, position, velocity, spin } => {
            let solid = &mut model.obstacles.solids[solid];
            solid.axes = Placed::new(solid, time).axes;
            (solid.since, solid.position) = (time, position);
            (solid.velocity, solid.spin) = (velocity, spin);
            solid.keys.clear();
        }
        ScaleMaterial { bodies, number, factor } => {
            let rows = (particles_of(model, bodies), springs_of(model, bodies));
            material::scale(model, rows, (number, factor));
            cap_grabs(model, h);
        }
        SetRelaxationTime { bodies, value } => {
            let rows = (particles_of(model, bodies), springs_of(model, bodies));
            material::damp(model, &rows, value);
        }
        SetLook { body, look } => model.bodies[body].look = look,
    }
}

fn pin<R: Real>(model: &mut Model<R>, state: &mut Columns<R>, particle: usize, velocity: R::Vec3) {
    model.guides.release(particle);
    model.inverse_masses[particle] = R::ZERO;
    set_velocity(model, state, particle, velocity);
}

/// Sets stiffness, damping or rest length of a range of springs.
fn set_springs<R: Real>(
    model: &mut Model<R>,
    state: &Columns<R>,
    range: Range<usize>,
    interaction: Interaction,
) {
    use Interaction::*;
    match interaction {
        SetStiffness { value, .. } => model.springs.change(range, |[_, b]| [R::of(value), b]),
        SetDamping { value, .. } => model.springs.change(range, |[k, _]| [k, R::of(value)]),
        SetRestLength { value, .. } => model.springs.rest_lengths_mut(range).fill(R::of(value)),
        ScaleRestLength { factor, .. } => {
            let longest = model.extent;
            for rest in model.springs.rest_lengths_mut(range) {
                *rest = (*rest * R::of(factor)).min(longest);
            }
        }
        Freeze { .. } => {
            for spring in range {
                let length = R::of(energy::length(model, state, spring));
                model.springs.rest_lengths_mut(spring..spring + 1).fill(length);
            }
        }
        _ => {}
    }
}

fn particles_of<R: Real>(model: &Model<R>, select: Select) -> Range<usize> {
    match select {
        Select::All => 0..model.particle_count(),
        Select::Body(body) => model.bodies[body].particles.clone(),
        Select::One(particle) => particle..particle + 1,
        Select::Range(start, end) => start..end,
    }
}

fn springs_of<R: Real>(model: &Model<R>, select: Select) -> Range<usize> {
    match select {
        Select::All => 0..model.ends().len(),
        Select::Body(body) => model.bodies[body].springs.clone(),
        Select::One(spring) => spring..spring + 1,
        Select::Range(start, end) => start..end,
    }
}

fn grab<R: Real>(model: &mut Model<R>, h: f64, interaction: Interaction) {
    let Interaction::Grab { particle, target, frequency, damping_ratio, max_force } = interaction
    else {
        return;
    };
    let mass = model.masses[particle].to_f64();
    let rate = core::f64::consts::TAU * frequency;
    let damping = 2.0 * damping_ratio * mass * rate;
    let hold = Grab {
        particle: particle as u32,
        target: R::Vec3::of(target),
        stiffness: R::of(mass * rate * rate),
        // NaN only where one factor is 0 and the others overflow.
        damping: R::of(if damping.is_nan() { 0.0 } else { damping }),
        max_force: R::of(max_force),
    };
    match model.grabs.0.iter_mut().find(|grab| grab.particle as usize == particle) {
        Some(grab) => *grab = hold,
        None => model.grabs.0.push(hold),
    }
    cap_grabs(model, h);
}

/// Weakens grabs that a substep of `h` seconds could not follow. They keep a frequency of at most a
/// tenth of the substeps per second, and no more damping than takes half of a velocity per substep.
pub(crate) fn cap_grabs<R: Real>(model: &mut Model<R>, h: f64) {
    let fastest = core::f64::consts::TAU * 0.1 / h;
    for grab in &mut model.grabs.0 {
        let mass = model.masses[grab.particle as usize].to_f64();
        // The cap of a mass near the largest number overflows itself.
        grab.stiffness = grab.stiffness.min(R::of(mass * fastest * fastest)).min(R::LARGEST);
        grab.damping = grab.damping.min(R::of(mass * 0.5 / h)).min(R::LARGEST);
    }
}

fn set_mass<R: Real>(model: &mut Model<R>, particles: Range<usize>, mass: f64) {
    for particle in particles {
        if model.is_removed(particle) {
            continue;
        }
        model.masses[particle] = R::of(mass);
        if !model.is_pinned(particle) {
            model.inverse_masses[particle] = R::ONE / model.masses[particle];
        }
    }
}

fn push_all<R: Real>(
    model: &Model<R>,
    state: &mut Columns<R>,
    particles: Range<usize>,
    impulse: DVec3,
) {
    let free = particles.filter(|&particle| !model.is_pinned(particle));
    let mass: f64 = free.clone().map(|particle| model.masses[particle].to_f64()).sum();
    for particle in free {
        let (_, velocity) = state.get(model.slots.at(particle));
        set_velocity(model, state, particle, velocity + R::Vec3::of(impulse / mass));
    }
}

fn spin<R: Real>(model: &Model<R>, state: &mut Columns<R>, particles: Range<usize>, spin: DVec3) {
    let centre = centre_of_mass(model, state, particles.clone());
    for particle in particles.filter(|&particle| !model.is_pinned(particle)) {
        let (position, velocity) = state.get(model.slots.at(particle));
        let arm = position.to_f64() - centre;
        set_velocity(model, state, particle, velocity + R::Vec3::of(spin.cross(arm)));
    }
}

fn set_velocity<R: Real>(
    model: &Model<R>,
    state: &mut Columns<R>,
    particle: usize,
    velocity: R::Vec3,
) {
    let at = model.slots.at(particle);
    let (position, _) = state.get(at);
    state.put(at, (position, velocity));
}
