//! Streams of interactions on a small scene, with steps in between.
//!
//! The bytes make the scene, the method and the stream.

use super::numbers::{any, index, positive, vector};
use super::promise::{check_message, check_simulation, step};
use super::world;
use arbitrary::{Result, Unstructured};
use msd_core::{Interaction, Look, MaterialNumber, Real, Scene, Select, Settings, Simulation};

/// The most interactions of a stream.
const DEEDS: usize = 40;
/// A stream ends where an adaptive method has taken so many evaluations: some steps take a million.
const EVALUATIONS: u64 = 100_000;

/// Makes a scene of bytes, runs it, and interferes.
pub fn check(bytes: &[u8]) {
    let mut u = Unstructured::new(bytes);
    // Bytes that end early end the stream.
    let _ = stream(&mut u);
}

fn stream(u: &mut Unstructured) -> Result<()> {
    let first: u8 = u.arbitrary()?;
    let settings = world::settings(u)?;
    let mut scene = world::scene(u)?;
    world::spoil(&mut scene, first >> 1);
    if first & 1 == 1 {
        drive::<f64>(u, &scene, settings)
    } else {
        drive::<f32>(u, &scene, settings)
    }
}

fn drive<R: Real>(u: &mut Unstructured, scene: &Scene, settings: Settings) -> Result<()> {
    let mut simulation = match Simulation::<R>::new(scene, settings) {
        Ok(simulation) => simulation,
        Err(error) => {
            check_message(&error);
            return Ok(());
        }
    };
    check_simulation(&simulation);
    let start = simulation.state();
    for _ in 0..DEEDS {
        match u.arbitrary::<u8>()? % 32 {
            0..=15 => queue(u, &mut simulation)?,
            16 => check_messages(simulation.apply_queued()),
            17 => check_messages(simulation.set_settings(world::settings(u)?)),
            18 => check_messages(simulation.set_state(&start, u.arbitrary()?)),
            19 => check_converted(&simulation),
            20 => look(&simulation),
            _ => {
                step(&mut simulation);
            }
        }
        check_simulation(&simulation);
        if simulation.work().is_some_and(|work| EVALUATIONS < work.evaluations) {
            break;
        }
    }
    Ok(())
}

fn check_messages(done: std::result::Result<(), msd_core::Error>) {
    if let Err(error) = done {
        check_message(&error);
    }
}

/// Queues an interaction; one that is refused must leave the queue as it was.
fn queue<R: Real>(u: &mut Unstructured, simulation: &mut Simulation<R>) -> Result<()> {
    let interaction = interaction(u, simulation)?;
    let before = simulation.queued().len();
    match simulation.queue(interaction) {
        Ok(()) => assert_eq!(simulation.queued().len(), before + 1),
        Err(error) => {
            check_message(&error);
            assert_eq!(simulation.queued().len(), before, "{interaction:?} was refused");
        }
    }
    Ok(())
}

/// Checks that a converted simulation can be stepped, in the other precision too.
fn check_converted<R: Real>(simulation: &Simulation<R>) {
    match simulation.convert::<f32>() {
        Ok(mut other) => {
            check_simulation(&other);
            step(&mut other);
            check_simulation(&other);
        }
        Err(error) => check_message(&error),
    }
    match simulation.convert::<f64>() {
        Ok(other) => check_simulation(&other),
        Err(error) => panic!("double precision holds every number: {error}"),
    }
}

/// Takes every reading that a caller may take between two steps.
fn look<R: Real>(simulation: &Simulation<R>) {
    let stable = simulation.stable_substep();
    assert!(0.0 <= stable, "{stable}");
    let _ = (simulation.energy(), simulation.momentum(), simulation.dissipated());
}

fn interaction<R: Real>(u: &mut Unstructured, of: &Simulation<R>) -> Result<Interaction> {
    let (count, springs) = (of.model().particle_count(), of.model().ends().len());
    let kind = u.arbitrary::<u8>()? % 25;
    if kind < 7 {
        return for_one(u, kind, count);
    }
    Ok(match kind {
        7 => Interaction::Cut { spring: index(u, springs)? },
        8 => Interaction::SetStiffness { springs: select(u, springs)?, value: positive(u)? },
        9 => Interaction::SetDamping { springs: select(u, springs)?, value: positive(u)? },
        10 => Interaction::SetMass { particles: select(u, count)?, value: positive(u)? },
        11 => Interaction::SetRestLength { springs: select(u, springs)?, value: positive(u)? },
        12 => Interaction::ScaleRestLength { springs: select(u, springs)?, factor: positive(u)? },
        13 => Interaction::Freeze { springs: select(u, springs)? },
        14 => Interaction::Impulse { particles: select(u, count)?, impulse: vector(u)? },
        15 => Interaction::Spin { particles: select(u, count)?, velocity: vector(u)? },
        16 => Interaction::SetGravity { value: vector(u)? },
        17 => Interaction::SetDrag { value: positive(u)? },
        18 => Interaction::RemovePlanes,
        19 => Interaction::AddPlane { plane: world::plane(u)? },
        20 => Interaction::ScaleMaterial {
            bodies: select(u, count)?,
            number: [MaterialNumber::Young, MaterialNumber::Thickness, MaterialNumber::Density]
                [usize::from(u.arbitrary::<u8>()? % 3)],
            factor: positive(u)?,
        },
        21 => Interaction::SetRelaxationTime { bodies: select(u, count)?, value: positive(u)? },
        22 => Interaction::MoveSolid {
            solid: index(u, of.model().solids().len())?,
            position: vector(u)?,
            velocity: vector(u)?,
            spin: vector(u)?,
        },
        23 => Interaction::SetLook {
            body: index(u, of.model().bodies().len())?,
            look: Look {
                roughness: any(u)? as f32,
                pattern_size: any(u)? as f32,
                ..Look::default()
            },
        },
        _ => Interaction::SetPlane {
            plane: index(u, of.model().planes().len())?,
            restitution: world::fraction(u)?,
            friction: world::friction(u)?,
        },
    })
}

/// An interaction with one particle.
fn for_one(u: &mut Unstructured, kind: u8, count: usize) -> Result<Interaction> {
    let particle = index(u, count)?;
    Ok(match kind {
        0..=2 => Interaction::Grab {
            particle,
            target: vector(u)?,
            frequency: positive(u)?,
            damping_ratio: positive(u)?,
            max_force: if u.arbitrary()? { f64::MAX } else { any(u)? },
        },
        3 => Interaction::Release { particle },
        4 => Interaction::Pin { particle, velocity: vector(u)? },
        5 => Interaction::Unpin { particle },
        _ => Interaction::Push { particle, force: vector(u)? },
    })
}

fn select(u: &mut Unstructured, count: usize) -> Result<Select> {
    Ok(match u.arbitrary::<u8>()? % 4 {
        0 => Select::One(index(u, count)?),
        1 => Select::Body(index(u, 1)?),
        2 => Select::Range(index(u, count + 1)?, index(u, count + 1)?),
        _ => Select::All,
    })
}
