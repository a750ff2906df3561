//! The material that the bodies of a scene amount to: mass, moduli by direction, fastest motion.

use super::pulled::Pulled;
use core::f64::consts::{PI, TAU};
use msd_core::glam::DVec3;
use msd_core::scene::{Between, between, do_meet};
use msd_core::stability::Mode;
use msd_core::{
    Bend, Body, Error, Moduli, Pin, Scene, Settings, Shell, Simulation, Spring, Volume,
};
use msd_scene::{Loaded, SetKeys};
use serde::Serialize;

/// Slow motions that are sought, and the most particles of a body that they are sought in: they
/// take seconds.
const SLOWEST: usize = 5;
const MOST_SOUGHT: usize = 4000;
/// Motions that nothing resists, beyond which slow ones are not found among them.
const MOST_FREE: usize = 10;

/// Properties of the bodies of a scene at its start; the keys of `msd inspect --json`.
#[derive(Clone, Debug, Serialize)]
pub struct InspectReport {
    /// Name of the scene.
    pub scene: String,
    /// Keys of the scene that were set.
    pub set: SetKeys,
    /// Name of the method.
    pub integrator: &'static str,
    /// The longest stable substep, seconds; infinite where any is stable.
    pub stable_step: f64,
    /// Its bodies.
    pub bodies: Vec<Inspection>,
    /// Notes for the author of the file.
    pub notes: Vec<String>,
}

impl InspectReport {
    /// Inspects a scene of which some keys were set.
    ///
    /// # Errors
    /// As [`inspect`] and [`Simulation::new`].
    pub fn new(loaded: &Loaded, set: SetKeys) -> Result<Self, Error> {
        let Loaded { name, scene, settings, notes, .. } = loaded;
        Ok(InspectReport {
            scene: name.clone(),
            set,
            integrator: settings.integrator.name(),
            bodies: inspect(scene)?,
            stable_step: Simulation::<f64>::new(scene, *settings)?.stable_substep(),
            notes: notes.clone(),
        })
    }
}

/// A body as if it were of a uniform material; a part of `msd inspect --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// Its name.
    pub name: String,
    /// The number of particles.
    pub particles: usize,
    /// The number of springs.
    pub springs: usize,
    /// Mass, kilograms.
    pub mass: f64,
    /// The volume, area or length that it fills; `None` for particles and springs of no shape, and
    /// where the surface has holes.
    pub filled: Option<Filled>,
    /// Whether its surface has holes, so that it has no inside.
    pub is_open: bool,
    /// Its moduli, if it is a solid, a flat sheet or a straight rope.
    pub moduli: Option<Directions>,
    /// The smallest and the largest Young's modulus of an irregular solid, such as that of a mesh,
    /// pascals: a uniform stress pulls at its surface. `None` of a lattice, of which the moduli are
    /// exact, and of more than 4000 particles.
    pub pulled: Option<[f64; 2]>,
    /// Bending stiffness inside it, the smallest and the largest along its lattice and the
    /// diagonals of that: newton metres of a sheet, newton square metres of a rope; `None` of a
    /// solid, and of a body that does not resist bending.
    pub bending: Option<[f64; 2]>,
    /// Frequency of its fastest motion on its own, held by its pins, hertz.
    pub fastest: f64,
    /// Its slowest motions on its own, held by its pins, as it stands, slowest first; empty where
    /// they are not known.
    pub slowest: Vec<Slow>,
    /// Why the slowest motions are not known, in words; `None` where they are.
    pub slowest_unknown: Option<&'static str>,
    /// Its contact with other bodies and itself; `None` where it passes through all.
    pub touch: Option<Touching>,
}

/// Contact of a body with others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Touching {
    /// Distance that it keeps on each side of its surface, metres.
    pub thickness: f64,
    /// Coulomb's factor.
    pub friction: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Whether it meets itself.
    pub itself: bool,
    /// Whether it keeps its thickness from obstacles too.
    pub obstacles: bool,
    /// The names of the bodies that it passes through although both meet others.
    pub ignore: Vec<String>,
    /// Contact with single bodies, in place of the values that follow from both.
    pub with: Vec<TouchingWith>,
}

/// Contact of a body with another one, in place of the values that follow from both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchingWith {
    /// The name of the other body.
    pub body: String,
    /// Coulomb's factor of the two; `None` for the root of the product of theirs.
    pub friction: Option<f64>,
    /// Coefficient of restitution of the two; `None` for the larger one of theirs.
    pub restitution: Option<f64>,
}

/// A slow motion of a body.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Slow {
    /// Frequency, hertz.
    pub frequency: f64,
    /// Its damping ratio.
    pub damping_ratio: f64,
}

/// The volume of a solid, the area of a sheet or the length of a rope.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Filled {
    /// 3 for a solid, 2 for a sheet, 1 for a rope.
    pub dimensions: u32,
    /// Cubic metres, square metres or metres.
    pub size: f64,
}

/// Moduli along the directions to the neighbours in a lattice: the 26 of a solid, the 8 of a sheet
/// or the 2 of a rope, opposite ones once.
#[derive(Clone, Debug, Serialize)]
pub struct Directions {
    /// Young's modulus by direction: pascals, newtons per metre of a sheet, newtons of a rope.
    pub young: Vec<([f64; 3], f64)>,
    /// The smallest and the largest Poisson's ratio; `None` of a rope.
    pub poisson: Option<[f64; 2]>,
    /// The largest modulus over the smallest; infinite where nothing resists some pull.
    pub anisotropy: f64,
}

impl Directions {
    /// The smallest and the largest modulus.
    pub fn range(&self) -> [f64; 2] {
        let moduli = || self.young.iter().map(|&(_, modulus)| modulus);
        [moduli().fold(f64::INFINITY, f64::min), moduli().fold(0.0, f64::max)]
    }
}

/// Inspects every body of a scene as it stands at the start.
///
/// # Errors
/// A scene that a simulation refuses.
pub fn inspect(scene: &Scene) -> Result<Vec<Inspection>, Error> {
    let joints = joints(scene);
    let rows = scene.bodies.iter().zip(joints);
    rows.map(|(body, joints)| inspect_body(scene, body, joints)).collect()
}

/// The bends and volumes of a body, by its own particles.
#[derive(Clone, Default)]
struct Joints {
    bends: Vec<Bend>,
    volumes: Vec<Volume>,
}

/// Those of every body, in one pass.
fn joints(scene: &Scene) -> Vec<Joints> {
    let mut joints = vec![Joints::default(); scene.bodies.len()];
    // The body of each particle; those of none have no body's number.
    let mut body_of = vec![usize::MAX; scene.particles.len()];
    for (number, body) in scene.bodies.iter().enumerate() {
        body_of[body.particles.clone()].fill(number);
    }
    let place = |particles: &[usize]| {
        let number = body_of[particles[0]];
        let is_inside = particles.iter().all(|&particle| body_of[particle] == number);
        is_inside.then(|| (number, scene.bodies.get(number).map_or(0, |body| body.particles.start)))
    };
    for bend in &scene.bends {
        if let Some((number, first)) = place(&bend.particles)
            && let Some(joints) = joints.get_mut(number)
        {
            joints.bends.push(Bend { particles: bend.particles.map(|end| end - first), ..*bend });
        }
    }
    for volume in &scene.volumes {
        if let Some((number, first)) = place(&volume.particles)
            && let Some(joints) = joints.get_mut(number)
        {
            let particles = volume.particles.map(|end| end - first);
            joints.volumes.push(Volume { particles, ..*volume });
        }
    }
    joints
}

fn inspect_body(scene: &Scene, body: &Body, joints: Joints) -> Result<Inspection, Error> {
    let springs = &scene.springs[body.springs.clone()];
    let alone = alone(scene, body, joints);
    let simulation = Simulation::<f64>::new(&alone, Settings::default())?;
    let is_open = !body.surface.two_sided && !is_closed(body);
    let filled = filled(scene, body).filter(|_| !is_open);
    let across = |spring: &Spring| across(scene, spring);
    let rows = springs.iter().map(|spring| (spring.stiffness, across(spring)));
    let frame = frame(scene, body);
    // A curved shell has no principal directions.
    let flat = filled.filter(|filled| {
        let mut beside = frame[filled.dimensions as usize..].iter();
        beside.all(|axis| {
            springs.iter().map(across).all(|way| way.dot(*axis).abs() <= 1e-6 * way.length())
        })
    });
    let bending = flat.and_then(|filled| {
        bending(&alone, &extents(scene, body, filled.dimensions), filled, frame)
    });
    let (slowest, slowest_unknown) = match slowest(&simulation, &alone) {
        Ok(slowest) => (slowest, None),
        Err(why) => (Vec::new(), Some(why)),
    };
    Ok(Inspection {
        name: body.name.clone(),
        particles: body.particles.len(),
        springs: springs.len(),
        mass: scene.particles[body.particles.clone()].iter().map(|row| row.mass).sum(),
        moduli: flat.and_then(|filled| {
            let moduli = Moduli::of(rows, &alone.volumes, filled.size);
            let found = directions(&moduli, frame, filled.dimensions);
            // Springs without stiffness amount to no material.
            (0.0 < found.range()[1]).then_some(found)
        }),
        pulled: filled.filter(|_| is_irregular(springs)).and_then(|filled| {
            let surface = body.surface.particles();
            let own = |at: u32| at as usize - body.particles.start;
            let triangles: Vec<_> = surface.map(|corners| corners.map(own)).collect();
            pulled(&alone, (filled, &triangles), frame)
        }),
        filled,
        is_open,
        bending,
        fastest: simulation.fastest_mode().stiffness.sqrt() / TAU,
        slowest,
        slowest_unknown,
        touch: touching(scene, body),
    })
}

/// Whether springs are of more lengths than those of a lattice, along its axes and diagonals.
fn is_irregular(springs: &[Spring]) -> bool {
    let mut lengths: Vec<f64> = springs.iter().map(|spring| spring.rest_length).collect();
    lengths.sort_unstable_by(f64::total_cmp);
    let longer = lengths.windows(2).filter(|pair| pair[0] * (1.0 + 1e-6) < pair[1]);
    2 < longer.take(3).count()
}

/// The smallest and the largest Young's modulus of springs that are pulled at the surface of a
/// solid.
fn pulled(
    alone: &Scene,
    (filled, triangles): (Filled, &[[usize; 3]]),
    frame: [DVec3; 3],
) -> Option<[f64; 2]> {
    let is_of_springs = alone.bends.is_empty() && alone.volumes.is_empty();
    if filled.dimensions != 3 || !is_of_springs || MOST_SOUGHT < alone.particles.len() {
        return None;
    }
    let pulled = Pulled::of(alone, triangles, filled.size)?;
    let frames = [frame, [DVec3::X, DVec3::Y, DVec3::Z]];
    let ways = frames.into_iter().flat_map(|frame| lattice_ways(frame, 3));
    let moduli = ways.map(|way| pulled.young(way));
    Some(
        moduli
            .fold([f64::INFINITY, 0.0], |[least, most], young| [least.min(young), most.max(young)]),
    )
}

fn touching(scene: &Scene, body: &Body) -> Option<Touching> {
    let own = scene.shells.iter().position(|shell| shell.is_of(body))?;
    let name = |row: usize| {
        let other = scene.bodies.iter().find(|body| scene.shells[row].is_of(body));
        other.map_or_else(|| format!("shell {row}"), |other| other.name.clone())
    };
    let others = || (0..scene.shells.len()).filter(|&other| other != own);
    let ignored = others().filter(|&other| !do_meet(&scene.shells, [own, other]));
    let with = others().filter_map(|other| {
        let &Between { friction, restitution, .. } = between(&scene.shells, [own, other])?;
        Some(TouchingWith { body: name(other), friction, restitution })
    });
    let &Shell { thickness, friction, restitution, itself, obstacles, .. } = &scene.shells[own];
    let (ignore, with) = (ignored.map(name).collect(), with.collect());
    Some(Touching { thickness, friction, restitution, itself, obstacles, ignore, with })
}

/// The slowest motions of a body, or why they are not known.
fn slowest(simulation: &Simulation<f64>, alone: &Scene) -> Result<Vec<Slow>, &'static str> {
    if MOST_SOUGHT < alone.particles.len() {
        return Err("are not sought in a body of more than 4000 particles");
    }
    let free = alone.particles.len() - alone.pins.len().min(alone.particles.len());
    if MOST_FREE < free && is_limp(alone) {
        return Err("are not sought: nothing resists motions across its springs");
    }
    let modes = simulation.slowest_modes(SLOWEST);
    if modes.is_empty() {
        return Err("were not found: nothing resists many motions, or they are too much alike");
    }
    let slow = |mode: &Mode| {
        let frequency = mode.stiffness.sqrt();
        Slow { frequency: frequency / TAU, damping_ratio: 0.5 * mode.damping / frequency }
    };
    Ok(modes.iter().map(slow).collect())
}

/// Returns whether springs in one plane, or on a line, are all that resists, at their rest lengths.
/// Then every particle may leave the plane, and a search among so many free motions is in vain.
fn is_limp(alone: &Scene) -> bool {
    let ways: Vec<DVec3> = alone.springs.iter().map(|spring| across(alone, spring)).collect();
    let is_relaxed = alone.springs.iter().zip(&ways).all(|(spring, way)| {
        let length = way.length();
        (length - spring.rest_length).abs() <= 1e-9 * length
    });
    let first = ways.first().map_or(DVec3::X, |way| way.normalize_or_zero());
    let beside = |way: &DVec3| first.cross(way.normalize_or_zero());
    let normal = ways.iter().map(beside).fold(DVec3::ZERO, |most, next| {
        if most.length_squared() < next.length_squared() { next } else { most }
    });
    let in_plane = |way: &DVec3| way.dot(normal).abs() <= 1e-9 * way.length();
    alone.bends.is_empty() && alone.volumes.is_empty() && is_relaxed && ways.iter().all(in_plane)
}

/// The body without the rest of its scene, held by its pins.
fn alone(scene: &Scene, body: &Body, Joints { bends, volumes }: Joints) -> Scene {
    let mut alone = Scene { world: scene.world, bends, volumes, ..Scene::default() };
    alone.particles = scene.particles[body.particles.clone()].to_vec();
    let first = body.particles.start;
    let inside = |spring: &&Spring| spring.ends.iter().all(|end| body.particles.contains(end));
    let springs = scene.springs[body.springs.clone()].iter().filter(inside);
    let moved = |spring: &Spring| Spring { ends: spring.ends.map(|end| end - first), ..*spring };
    alone.springs = springs.map(moved).collect();
    let pins = scene.pins.iter().filter(|pin| body.particles.contains(&pin.particle));
    alone.pins = pins.map(|pin| Pin { particle: pin.particle - first, ..*pin }).collect();
    alone
}

/// The smallest and the largest bending stiffness of a sheet or a rope along the axes and diagonals
/// of a frame.
///
/// Bent to a cylinder of curvature κ along n, a particle at x rises by κ (n·x)²/2. A bend then
/// stores k (Σ w (n·x)²/2)² κ²/2, and shares that among its particles by their weights. Particles
/// near an edge have too few bends: the one with most counts. `extents` are the areas or lengths of
/// the particles.
fn bending(alone: &Scene, extents: &[f64], filled: Filled, frame: [DVec3; 3]) -> Option<[f64; 2]> {
    if alone.bends.is_empty() || 2 < filled.dimensions {
        return None;
    }
    let along = |way: DVec3| {
        let mut shares = vec![0.0; alone.particles.len()];
        for bend in &alone.bends {
            let origin = alone.particles[bend.particles[0]].position;
            let rise = |(&end, weight): (&usize, &f64)| {
                let reach = way.dot(alone.particles[end].position - origin);
                weight * (0.5 * reach * reach)
            };
            let ends = || bend.particles.iter().zip(&bend.weights);
            let sum: f64 = ends().map(rise).sum();
            let weights: f64 = bend.weights.iter().map(|weight| weight.abs()).sum();
            for (&end, weight) in ends() {
                shares[end] += bend.stiffness * sum * sum * (weight.abs() / weights);
            }
        }
        extents.iter().zip(shares).map(|(extent, share)| share / extent).fold(0.0, f64::max)
    };
    let ways = lattice_ways(frame, filled.dimensions).into_iter().map(along);
    let range = |[least, most]: [f64; 2], found: f64| [least.min(found), most.max(found)];
    let found = ways.fold([f64::INFINITY, 0.0], range);
    (0.0 < found[1]).then_some(found)
}

/// The part of a sheet or a rope that each particle stands for, square metres or metres.
///
/// In a rope it is half of each of its springs. In a sheet it is a share of each triangle, by the
/// angle of its corner there over half a turn, so that a square counts alike whichever way it is
/// cut. Extra mass may be put on a particle, so masses do not show it.
fn extents(scene: &Scene, body: &Body, dimensions: u32) -> Vec<f64> {
    let mut extents = vec![0.0; body.particles.len()];
    let first = body.particles.start;
    if dimensions == 1 {
        for spring in &scene.springs[body.springs.clone()] {
            let length = across(scene, spring).length();
            spring.ends.iter().for_each(|end| extents[end - first] += 0.5 * length);
        }
    }
    for corners in body.surface.particles() {
        let corners = corners.map(|corner| corner as usize);
        let [a, b, c] = corners.map(|corner| scene.particles[corner].position);
        let area = 0.5 * (b - a).cross(c - a).length();
        let angles = [(b - a, c - a), (c - b, a - b), (a - c, b - c)];
        for (corner, (to, other)) in corners.into_iter().zip(angles) {
            extents[corner - first] += area * to.angle_between(other) / PI;
        }
    }
    extents
}

fn across(scene: &Scene, spring: &Spring) -> DVec3 {
    let [a, b] = spring.ends.map(|end| scene.particles[end].position);
    b - a
}

/// The extent of a body: the inside of its surface, its surface if that has two sides, or the
/// length of a line of springs.
fn filled(scene: &Scene, body: &Body) -> Option<Filled> {
    let surface = &body.surface;
    let at = |corner: u32| {
        let particle = surface.corners[corner as usize].particle as usize;
        scene.particles[particle].position
    };
    let corners = surface.triangles.iter().map(|triangle| triangle.map(at));
    let (dimensions, size) = if surface.triangles.is_empty() {
        let springs = &scene.springs[body.springs.clone()];
        let is_line = springs.len() + 1 == body.particles.len()
            && springs.iter().zip(body.particles.clone()).all(|(s, at)| s.ends == [at, at + 1]);
        let length = springs.iter().map(|spring| across(scene, spring).length()).sum();
        (1, if is_line { length } else { 0.0 })
    } else if surface.two_sided {
        (2, corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum())
    } else {
        // Measured from a corner of the body: far from the origin the sum would lose its digits.
        let origin = scene.particles[body.particles.start].position;
        let corners = corners.map(|corners| corners.map(|corner| corner - origin));
        // Of either sign: a surface may be inside out.
        (3, corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum::<f64>().abs())
    };
    (0.0 < size).then_some(Filled { dimensions, size })
}

/// Whether every edge of the surface of a body is gone along as often one way as the other.
fn is_closed(body: &Body) -> bool {
    let mut edges = Vec::with_capacity(3 * body.surface.triangles.len());
    for [a, b, c] in body.surface.particles() {
        let edge = |a: u32, b: u32| ([a.min(b), a.max(b)], if a < b { 1 } else { -1 });
        edges.extend([edge(a, b), edge(b, c), edge(c, a)]);
    }
    edges.sort_unstable();
    let mut groups = edges.chunk_by(|a, b| a.0 == b.0);
    groups.all(|group| group.iter().map(|&(_, way)| way).sum::<i32>() == 0)
}

/// Three directions at right angles that go along the lattice of a body, if it is one; those in a
/// sheet and along a rope first.
fn frame(scene: &Scene, body: &Body) -> [DVec3; 3] {
    let springs = scene.springs[body.springs.clone()].iter();
    let mut ways = springs.map(|spring| across(scene, spring).normalize_or_zero());
    let first = ways.next().unwrap_or(DVec3::X);
    let square = |way: &DVec3| way.dot(first).abs() < 1e-6 && 0.5 < way.length_squared();
    let second = ways.find(square).unwrap_or_else(|| first.any_orthonormal_vector());
    [first, second, first.cross(second)]
}

/// The directions to the neighbours in a lattice of so many dimensions, opposite ones once.
fn lattice_ways(frame: [DVec3; 3], dimensions: u32) -> Vec<DVec3> {
    let neighbours = msd_core::lattice::FAMILIES
        .into_iter()
        .filter(|step| (dimensions as usize..3).all(|axis| step[axis] == 0));
    let way = |step: [isize; 3]| {
        let along = step.iter().zip(frame).map(|(&length, axis)| axis * length as f64);
        along.sum::<DVec3>().normalize()
    };
    neighbours.map(way).collect()
}

/// Moduli along the axes and diagonals of a frame.
fn directions(moduli: &Moduli, frame: [DVec3; 3], dimensions: u32) -> Directions {
    let ways = lattice_ways(frame, dimensions);
    let young: Vec<_> = ways.iter().map(|way| (way.to_array(), moduli.young(*way))).collect();
    let ratios = ways.iter().flat_map(|&way| {
        let normal = if dimensions == 2 { frame[2] } else { way.any_orthonormal_vector() };
        let transverse = [Some(normal.cross(way)), (dimensions == 3).then_some(normal)];
        transverse.into_iter().flatten().map(move |across| moduli.poisson(way, across))
    });
    let poisson =
        [ratios.clone().fold(f64::INFINITY, f64::min), ratios.fold(f64::NEG_INFINITY, f64::max)];
    let mut directions =
        Directions { young, poisson: (1 < dimensions).then_some(poisson), anisotropy: 1.0 };
    let [least, most] = directions.range();
    directions.anisotropy = most / least;
    directions
}
