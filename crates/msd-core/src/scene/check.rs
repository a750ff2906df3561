//! Checks of outside data: every number in its domain, every index in range.

use crate::error::Error;
use crate::number::{Real, Vector};
use crate::scene::{
    Air, Bend, Body, DistanceGrid, Friction, Guide, KeyFrame, Lead, Look, MOST_POINTS, Particle,
    Plane, Scene, Shape, Shell, Solid, Spring, Volume,
};
use alloc::vec;
use glam::{DMat3, DVec3};

/// The most particles a system may have.
pub const MAX_PARTICLES: usize = 1 << 24;
/// The most springs a system may have.
pub const MAX_SPRINGS: usize = 1 << 27;

/// More steps than a run may have taken: a double, of which time is made, counts them exactly.
const TOO_MANY_STEPS: u64 = 1 << 53;

/// Checks that `value` of row `row` lies in a domain.
pub(crate) fn check(
    ok: bool,
    quantity: &'static str,
    (item, row): (&'static str, usize),
    value: f64,
    expected: &'static str,
) -> Result<(), Error> {
    if ok { Ok(()) } else { Err(Error::OutOfDomain { quantity, item, row, value, expected }) }
}

/// Checks that `index` of row `row` names one of `count` targets.
pub(crate) fn check_index(
    (item, row): (&'static str, usize),
    target: &'static str,
    index: usize,
    count: usize,
) -> Result<(), Error> {
    if index < count { Ok(()) } else { Err(Error::OutOfRange { item, row, target, index, count }) }
}

/// Checks a number of steps taken.
pub(crate) fn check_steps(
    quantity: &'static str,
    at: (&'static str, usize),
    steps: u64,
) -> Result<(), Error> {
    check(steps < TOO_MANY_STEPS, quantity, at, steps as f64, "less than 2^53")
}

/// Checks every row of a scene for a run in precision `R`.
pub(crate) fn check_scene<R: Real>(scene: &Scene) -> Result<(), Error> {
    if scene.particles.is_empty() {
        return Err(Error::Empty);
    }
    check_count("the number of particles", scene.particles.len(), MAX_PARTICLES)?;
    check_world::<R>(scene)?;
    for (row, particle) in scene.particles.iter().enumerate() {
        check_particle::<R>(row, particle, scene.world.extent)?;
    }
    let count = scene.particles.len();
    check_joints::<R>(scene, [0; 3], count)?;
    for (row, plane) in scene.planes.iter().enumerate() {
        check_plane::<R>(row, plane)?;
    }
    for (row, solid) in scene.solids.iter().enumerate() {
        check_solid::<R>(row, solid)?;
    }
    check_shells(&scene.shells, count)?;
    for (row, pin) in scene.pins.iter().enumerate() {
        check_index(("pin", row), "particle", pin.particle, count)?;
        check_vector::<R>("velocity", ("pin", row), pin.velocity)?;
    }
    check_guides::<R>(&scene.guides, count, scene.solids.len())?;
    for (row, body) in scene.bodies.iter().enumerate() {
        check_body(row, body, scene)?;
    }
    Ok(())
}

/// Checks the guides of pins among so many particles and solids.
pub(crate) fn check_guides<R: Real>(
    guides: &[Guide],
    particles: usize,
    solids: usize,
) -> Result<(), Error> {
    let mut is_held = vec![false; if guides.is_empty() { 0 } else { particles }];
    for (row, guide) in guides.iter().enumerate() {
        let at = ("guide", row);
        for &(particle, place) in &guide.held {
            check_index(at, "particle", particle, particles)?;
            check_vector::<R>("place", at, place)?;
            let is_new = !core::mem::replace(&mut is_held[particle], true);
            check(is_new, "particle", at, particle as f64, "guided once")?;
        }
        if let Some(until) = guide.until {
            check(0.0 < until && until.is_finite(), "end", at, until, "positive and finite")?;
        }
        match &guide.lead {
            Lead::Solid(solid) => check_index(at, "solid", *solid, solids)?,
            Lead::Path { since, position, velocity, keys } => {
                check_time("start of the motion", at, *since)?;
                check_vector::<R>("position", at, *position)?;
                check_vector::<R>("velocity", at, *velocity)?;
                check_keys::<R>(at, (*since, velocity.extent()), keys)?;
            }
        }
    }
    Ok(())
}

/// Checks the springs, bends and volumes of a scene that join `count` particles, after so many of
/// each that are there.
pub(crate) fn check_joints<R: Real>(
    scene: &Scene,
    [springs, bends, volumes]: [usize; 3],
    count: usize,
) -> Result<(), Error> {
    check_count("the number of springs", springs + scene.springs.len(), MAX_SPRINGS)?;
    check_count("the number of bends", bends + scene.bends.len(), MAX_SPRINGS)?;
    check_count("the number of volumes", volumes + scene.volumes.len(), MAX_PARTICLES)?;
    for (row, spring) in (springs..).zip(&scene.springs) {
        check_spring::<R>(row, spring, count)?;
    }
    for (row, bend) in scene.bends.iter().enumerate() {
        check_bend::<R>(row, bend, count)?;
    }
    for (row, volume) in scene.volumes.iter().enumerate() {
        check_volume::<R>(row, volume, count)?;
    }
    Ok(())
}

/// Checks a particle of a world that reaches as far as `extent`, metres.
pub(crate) fn check_particle<R: Real>(
    row: usize,
    particle: &Particle,
    extent: f64,
) -> Result<(), Error> {
    let at = ("particle", row);
    check_mass::<R>(at, particle.mass)?;
    for value in particle.position.to_array() {
        check(value.abs() <= extent, "position", at, value, "finite and inside the world")?;
    }
    check_vector::<R>("velocity", at, particle.velocity)
}

/// Checks a spring between two of `count` particles.
pub(crate) fn check_spring<R: Real>(
    row: usize,
    spring: &Spring,
    count: usize,
) -> Result<(), Error> {
    let at = ("spring", row);
    for end in spring.ends {
        check_index(at, "particle", end, count)?;
    }
    if spring.ends[0] == spring.ends[1] {
        return Err(Error::Loop { row, particle: spring.ends[0] });
    }
    check_not_negative::<R>("rest length", at, spring.rest_length)?;
    check_not_negative::<R>("stiffness", at, spring.stiffness)?;
    check_not_negative::<R>("damping", at, spring.damping)
}

/// Checks a bend of some of `count` particles.
pub(crate) fn check_bend<R: Real>(row: usize, bend: &Bend, count: usize) -> Result<(), Error> {
    let at = ("bend", row);
    for particle in bend.particles {
        check_index(at, "particle", particle, count)?;
    }
    let (mut sum, mut largest) = (0.0, 0.0);
    for weight in bend.weights {
        check(is_finite::<R>(weight), "weight", at, weight, "finite")?;
        sum += weight;
        largest = f64::max(largest, weight.abs());
    }
    // An unbalanced sum would push the body as a whole. A run in single precision rounds weights.
    let balanced = sum.abs() <= 1e-6 * largest;
    check(balanced, "sum of the weights", at, sum, "0")?;
    check(is_finite::<R>(bend.rest), "tangent at rest", at, bend.rest, "finite")?;
    let [a, b, c, d] = bend.particles;
    let is_hinge = a != b && a != c && a != d && b != c && b != d && c != d;
    let expected = "0 unless its four particles differ";
    check(is_hinge || bend.rest == 0.0, "tangent at rest", at, bend.rest, expected)?;
    check_not_negative::<R>("stiffness", at, bend.stiffness)?;
    check_not_negative::<R>("damping", at, bend.damping)
}

/// Checks a volume between eight of `count` particles.
pub(crate) fn check_volume<R: Real>(
    row: usize,
    volume: &Volume,
    count: usize,
) -> Result<(), Error> {
    let at = ("volume", row);
    for particle in volume.particles {
        check_index(at, "particle", particle, count)?;
    }
    // The square of a side, its reciprocal and those of its fourth power must be numbers too.
    let rest = volume.rest_volume;
    let expected = "between 1e-24 and 1e24";
    check((1e-24..=1e24).contains(&rest), "rest volume", at, rest, expected)?;
    check(is_finite::<R>(volume.modulus), "modulus", at, volume.modulus, "finite")?;
    let alike = 0.0 <= volume.damping * volume.modulus.signum();
    let fits = alike && is_finite::<R>(volume.damping);
    check(fits, "damping", at, volume.damping, "finite and of the sign of the modulus")
}

pub(crate) fn check_body(row: usize, body: &Body, scene: &Scene) -> Result<(), Error> {
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
    world.air.iter().try_for_each(check_air::<R>)?;
    // A bound, not `is_finite`: the square of a length overflows long before a position does.
    let in_domain = 0.0 < world.extent && world.extent <= 1e12;
    check(in_domain, "extent", at, world.extent, "positive and at most 1e12")
}

/// Checks the air.
pub(crate) fn check_air<R: Real>(air: &Air) -> Result<(), Error> {
    let at = ("air", 0);
    check_not_negative::<R>("density", at, air.density)?;
    check_vector::<R>("velocity", at, air.velocity)?;
    check_not_negative::<R>("drag coefficient", at, air.drag)?;
    let fits = 0.0 <= air.lift && air.lift <= air.drag;
    check(fits, "lift coefficient", at, air.lift, "from 0 to the drag coefficient")?;
    let gust = &air.gust;
    check_not_negative::<R>("strength of gusts", at, gust.strength)?;
    check_vector::<R>("origin of gusts", at, gust.origin)?;
    for (quantity, value) in [("length of gusts", gust.length), ("time of gusts", gust.time)] {
        let fits = 0.0 < value && value <= 1e12;
        check(fits, quantity, at, value, "positive and at most 1e12")?;
    }
    Ok(())
}

pub(crate) fn check_plane<R: Real>(row: usize, plane: &Plane) -> Result<(), Error> {
    let at = ("plane", row);
    let largest = plane.normal.extent();
    let direction = largest.is_finite() && 0.0 < largest;
    check(direction, "normal", at, largest, "a finite vector that is not zero")?;
    check(is_finite::<R>(plane.offset), "offset", at, plane.offset, "finite")?;
    check_fraction("restitution", at, plane.restitution)?;
    check_friction(at, plane.friction)
}

fn check_solid<R: Real>(row: usize, solid: &Solid) -> Result<(), Error> {
    let at = ("solid", row);
    let positive = |quantity, value: f64| {
        let fits = 0.0 < value && value <= 1e12;
        check(fits, quantity, at, value, "positive and at most 1e12")
    };
    match solid.shape {
        Shape::Sphere { radius } => positive("radius", radius)?,
        Shape::Capsule { radius, length } | Shape::Cylinder { radius, length } => {
            positive("radius", radius)?;
            positive("length", length)?;
        }
        Shape::Box { size } => {
            size.to_array().into_iter().try_for_each(|side| positive("size", side))?;
        }
        Shape::Torus { radius, tube } => {
            positive("radius", radius)?;
            let fits = 0.0 < tube && tube < radius;
            check(fits, "tube", at, tube, "positive and smaller than the radius")?;
        }
        Shape::Mesh(ref grid) => {
            positive("edge of a cell", grid.cell)?;
            positive("reach", grid.reach)?;
            check_grid(at, grid)?;
        }
        Shape::HalfSpace => {}
    }
    let vectors =
        [("position", solid.position), ("velocity", solid.velocity), ("spin", solid.spin)];
    vectors.into_iter().try_for_each(|(quantity, value)| check_vector::<R>(quantity, at, value))?;
    check_axes(at, &solid.axes)?;
    check_time("start of the motion", at, solid.since)?;
    let steady = solid.velocity.extent().max(solid.spin.extent());
    check_keys::<R>(at, (solid.since, steady), &solid.keys)?;
    check_fraction("restitution", at, solid.restitution)?;
    check_friction(at, solid.friction)
}

fn check_axes(at: (&'static str, usize), axes: &DMat3) -> Result<(), Error> {
    let off = (axes.transpose() * *axes - DMat3::IDENTITY).to_cols_array();
    // A sum, as a NaN is not a rotation either.
    let off = off.into_iter().map(f64::abs).sum::<f64>();
    check(off <= 1e-9, "departure of the axes from a rotation", at, off, "0")
}

/// Checks the key frames of a motion from a time on, seconds, at a speed.
fn check_keys<R: Real>(
    at: (&'static str, usize),
    (mut before, steady): (f64, f64),
    keys: &[KeyFrame],
) -> Result<(), Error> {
    for key in keys {
        let is_later = before < key.time && key.time.is_finite();
        check(is_later, "time of a key frame", at, key.time, "later than the one before")?;
        check_vector::<R>("position of a key frame", at, key.position)?;
        check_axes(at, &key.axes)?;
        before = key.time;
    }
    let fits = keys.is_empty() || steady == 0.0;
    check(fits, "velocity or spin beside key frames", at, steady, "0")
}

fn check_grid(at: (&'static str, usize), grid: &DistanceGrid) -> Result<(), Error> {
    for count in grid.counts {
        check(2 <= count, "number of points along an axis", at, count as f64, "at least 2")?;
    }
    let points = grid.counts.into_iter().fold(1, usize::saturating_mul);
    check(points <= MOST_POINTS, "number of points", at, points as f64, "at most 4194304")?;
    let count = grid.distances.len();
    check(count == points, "number of distances", at, count as f64, "that of the points")?;
    let corners = grid.corners.iter().flat_map(|corner| corner.to_array());
    let numbers = grid.low.to_array().into_iter().chain([grid.error]).chain(corners);
    for number in numbers.chain(grid.distances.iter().copied()) {
        check(number.abs() <= 1e12, "length", at, number, "at most 1e12")?;
    }
    let mut corners = grid.triangles.iter().flatten();
    corners.try_for_each(|&corner| check_index(at, "corner", corner as usize, grid.corners.len()))
}

/// Checks the shells of so many particles.
pub(crate) fn check_shells(shells: &[Shell], count: usize) -> Result<(), Error> {
    let mut shell_of = vec![None; if shells.is_empty() { 0 } else { count }];
    for (row, shell) in shells.iter().enumerate() {
        let at = ("shell", row);
        let is_thick = 0.0 < shell.thickness && shell.thickness.is_finite();
        check(is_thick, "thickness", at, shell.thickness, "positive and finite")?;
        check_not_negative::<f32>("friction", at, shell.friction)?;
        check_fraction("restitution", at, shell.restitution)?;
        check_count("the number of triangles of shells", shell.triangles.len(), MAX_SPRINGS)?;
        check_count("the number of edges of shells", shell.edges.len(), MAX_SPRINGS)?;
        check_count("the number of points of shells", shell.points.len(), MAX_SPRINGS)?;
        let mut see = |what, number: usize, particles: &[usize]| -> Result<(), Error> {
            for (place, &particle) in particles.iter().enumerate() {
                check_index(at, "particle", particle, count)?;
                let is_new = !particles[..place].contains(&particle);
                check(is_new, what, at, number as f64, "between different particles")?;
                let is_own = *shell_of[particle].get_or_insert(row) == row;
                check(is_own, "particle", at, particle as f64, "in one shell")?;
            }
            Ok(())
        };
        for (number, corners) in shell.triangles.iter().enumerate() {
            see("triangle", number, corners)?;
        }
        for (number, ends) in shell.edges.iter().enumerate() {
            see("edge", number, ends)?;
        }
        for (number, &point) in shell.points.iter().enumerate() {
            see("point", number, &[point])?;
        }
        for &other in &shell.ignored {
            check_index(at, "shell before it", other, row)?;
        }
        check_count("the number of exempt pairs", shell.exempt.len(), MAX_SPRINGS)?;
        for &particle in shell.exempt.as_flattened() {
            check_index(at, "particle", particle, count)?;
        }
        check_between(row, shell)?;
    }
    Ok(())
}

/// Checks how a shell meets others, of those before it.
fn check_between(row: usize, shell: &Shell) -> Result<(), Error> {
    let at = ("shell", row);
    for (number, between) in shell.between.iter().enumerate() {
        check_index(at, "shell before it", between.shell, row)?;
        let is_new = shell.between[..number].iter().all(|before| before.shell != between.shell);
        let other = between.shell as f64;
        check(is_new, "other shell", at, other, "named once by what stands between them")?;
        check_not_negative::<f32>("friction between shells", at, between.friction.unwrap_or(0.0))?;
        let restitution = between.restitution.unwrap_or(0.0);
        check_fraction("restitution between shells", at, restitution)?;
    }
    Ok(())
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

/// Checks how a body is to look.
pub(crate) fn check_look(at: (&'static str, usize), look: &Look) -> Result<(), Error> {
    for part in look.colour.iter().chain(&look.back).flatten() {
        check_fraction("component of a colour", at, f64::from(*part))?;
    }
    check_fraction("roughness", at, f64::from(look.roughness))?;
    check_fraction("translucency", at, f64::from(look.translucency))?;
    check_not_negative::<f32>("size of a pattern", at, f64::from(look.pattern_size))
}

pub(crate) fn check_mass<R: Real>(at: (&'static str, usize), mass: f64) -> Result<(), Error> {
    // The reciprocal must fit too: a step multiplies by it.
    let rounded = R::of(mass);
    let usable =
        R::ZERO < rounded && is_finite::<R>(mass) && is_finite::<R>(1.0 / rounded.to_f64());
    check(usable, "mass", at, mass, "positive and finite")
}

fn check_time(quantity: &'static str, at: (&'static str, usize), value: f64) -> Result<(), Error> {
    check(value.is_finite(), quantity, at, value, "finite")
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

pub(crate) fn check_count(what: &'static str, count: usize, limit: usize) -> Result<(), Error> {
    if count <= limit { Ok(()) } else { Err(Error::TooLarge { what, count: count as u128, limit }) }
}

/// Whether a number is finite after rounding to precision `R`.
pub(crate) fn is_finite<R: Real>(value: f64) -> bool {
    R::of(value).to_f64().is_finite()
}
