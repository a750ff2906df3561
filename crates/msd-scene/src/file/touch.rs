//! Contact of bodies, from the keys `touch`: by the thickness of their surfaces, or by the radii of
//! their particles where a body of the file has a key of these.

mod shells;
mod starts;

pub(crate) use starts::{started_in_each_other, started_inside};

use crate::error::{FileError, nearest, plain};
use crate::file::obstacles::{short, told};
use crate::file::schema::{BodyRow, TouchRow, WithRow};
use crate::file::tree::Source;
use msd_core::{Between, Scene, Shape, Touch};

/// The radius of a particle, as a part of the spacing: two are then not quite as far apart as
/// neighbours, and a sheet that is stretched by a quarter still lets nothing through.
const RADIUS: f64 = 0.45;
/// The stiffness of a particle, as a part of that of all its springs: contact on all sides then
/// shortens the stable step by less than a tenth.
const STIFFNESS: f64 = 0.125;
const FRICTION: f64 = 0.5;

/// Lets the bodies touch that have a key `touch`; says what will leak.
///
/// # Errors
/// A number out of its domain, a radius wider than the spacing, an unknown name.
pub(crate) fn touch(
    source: &Source<'_>,
    bodies: &[BodyRow],
    scene: &mut Scene,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let mut rows = vec![None; bodies.len()];
    let all = || bodies.iter().filter_map(|body| body.touch.as_ref());
    let are_balls = all().any(|touch| touch.thickness.is_none() && shells::has_radius(touch));
    for (row, body) in bodies.iter().enumerate() {
        let Some(touch) = &body.touch else { continue };
        let by_default = || shells::thickness(scene, row).filter(|_| !are_balls);
        if let Some(thickness) = touch.thickness.or_else(by_default) {
            rows[row] = Some(Meeting::Thickness(scene.shells.len()));
            let shell = shells::made(source, (row, touch), thickness, scene)?;
            notes.extend(touch.triangles.map(|_| superfluous(&scene.bodies[row].name)));
            scene.shells.push(shell);
            continue;
        }
        let made = made(source, (row, touch), scene)?;
        notes.extend(leak(scene, row, &made));
        rows[row] = Some(Meeting::Radius(scene.touches.len()));
        let key = format!("bodies[{row}].touch.radius");
        scene.add_touch(made).map_err(|error| source.refuse(format_args!("{key}"), error))?;
    }
    notes.extend(strangers(scene, &rows));
    for (row, body) in bodies.iter().enumerate() {
        for (at, name) in body.touch.iter().flat_map(|touch| touch.ignore.iter().enumerate()) {
            let key = format!("bodies[{row}].touch.ignore[{at}]");
            let other = named(source, &key, name, scene)?;
            if row == other && rows[row].is_some() {
                let reason = "is the body itself; that is what `itself = false` is for";
                return Err(source.refuse(format_args!("{key}"), reason));
            }
            match (rows[row], rows[other]) {
                (Some(Meeting::Radius(a)), Some(Meeting::Radius(b))) => {
                    scene.touches[a.max(b)].ignored.push(a.min(b));
                }
                (Some(Meeting::Thickness(a)), Some(Meeting::Thickness(b))) => {
                    scene.shells[a.max(b)].ignored.push(a.min(b));
                }
                _ => {}
            }
        }
    }
    for (row, body) in bodies.iter().enumerate() {
        for (at, with) in body.touch.iter().flat_map(|touch| touch.with.iter().enumerate()) {
            let key = format!("bodies[{row}].touch.with[{at}]");
            notes.extend(add_between(source, (&key, row, with), &rows, scene)?);
        }
    }
    Ok(())
}

/// How a body touches: its row of touches or of shells.
#[derive(Clone, Copy)]
enum Meeting {
    Radius(usize),
    Thickness(usize),
}

/// A line where triangles are asked for that meet by themselves.
fn superfluous(body: &str) -> String {
    format!(
        "{body}: `touch.triangles` has no effect: the surface meets others by its triangles, at a \
         `thickness`"
    )
}

/// A line where some bodies have a radius and others a thickness.
fn strangers(scene: &Scene, rows: &[Option<Meeting>]) -> Option<String> {
    let first = |is: fn(&Meeting) -> bool| rows.iter().position(|row| row.as_ref().is_some_and(is));
    let radius = first(|row| matches!(row, Meeting::Radius(_)))?;
    let thickness = first(|row| matches!(row, Meeting::Thickness(_)))?;
    let [radius, thickness] = [radius, thickness].map(|row| &scene.bodies[row].name);
    Some(format!(
        "{radius} touches by the radius of its particles and {thickness} by the thickness of its \
         surface: they pass through each other; give both a `thickness`"
    ))
}

/// Adds how a body touches another; a line where that one touches nothing.
fn add_between(
    source: &Source<'_>,
    (key, row, with): (&str, usize, &WithRow),
    rows: &[Option<Meeting>],
    scene: &mut Scene,
) -> Result<Option<String>, FileError> {
    let of_body = format!("{key}.body");
    let refuse = |reason: &str| Err(source.refuse(format_args!("{of_body}"), reason));
    let number = |name: &str, value: Option<f64>| {
        value.map(|value| source.number(format_args!("{key}.{name}"), value)).transpose()
    };
    let stiffness = number("stiffness", with.stiffness)?;
    let damping = number("damping", with.damping)?;
    let friction = number("friction", with.friction)?;
    let name = &with.body;
    let other = named(source, &of_body, name, scene)?;
    let (Some(Meeting::Radius(a)), Some(Meeting::Radius(b))) = (rows[row], rows[other]) else {
        let reason = match rows[other] {
            None => "has no table `touch`",
            Some(_) => "touches by its thickness",
        };
        return Ok(Some(format!("{key} has no effect: \"{name}\" {reason}")));
    };
    if a == b {
        return refuse("is the body itself; its own numbers stand in `touch`");
    }
    let touch = &mut scene.touches[a.max(b)];
    if touch.ignored.contains(&a.min(b)) {
        return refuse(&format!("is \"{name}\", and one of the two ignores the other"));
    }
    if touch.between.iter().any(|between| between.row == a.min(b)) {
        let reason = format!("is \"{name}\" again: how the two touch is said once, by one of them");
        return refuse(&reason);
    }
    touch.between.push(Between { row: a.min(b), stiffness, damping, friction });
    Ok(None)
}

/// The row of touches of a body.
fn made(
    source: &Source<'_>,
    (row, touch): (usize, &TouchRow),
    scene: &Scene,
) -> Result<Touch, FileError> {
    let key = format!("bodies[{row}].touch");
    let particles = outside(scene, row);
    let own = own(scene, row, &particles);
    let number = |name: &str, value: Option<f64>| {
        value.map(|value| source.number(format_args!("{key}.{name}"), value)).transpose()
    };
    let radius = number("radius", touch.radius)?.or(own.radius());
    let stiffness = number("stiffness", touch.stiffness)?.or(own.stiffness());
    let (Some(radius), Some(stiffness)) = (radius, stiffness) else {
        let reason = match (radius, stiffness) {
            (Some(_), _) => {
                "lacks the key `stiffness`: the body has no spring that it follows from"
            }
            (_, Some(_)) => "lacks the key `radius`: the body has no spring that it follows from",
            _ => {
                "lacks the keys `radius` and `stiffness`: the body has no springs that they follow \
                 from"
            }
        };
        return Err(source.refuse(format_args!("{key}"), reason));
    };
    if let Some(spacing) = own.spacing.filter(|&spacing| spacing < radius) {
        let expected = format!("at most the spacing, {spacing} m");
        let key = format_args!("{key}.radius");
        return Err(source.out_of_domain(key, plain(radius), expected));
    }
    let damping = touch.damping.unwrap_or(own.relaxation * stiffness);
    let friction = touch.friction.unwrap_or(FRICTION);
    Ok(Touch {
        particles,
        radius,
        stiffness,
        damping: source.number(format_args!("{key}.damping"), damping)?,
        friction: source.number(format_args!("{key}.friction"), friction)?,
        triangles: if touch.triangles == Some(true) {
            triangles(source, row, scene)?
        } else {
            Vec::new()
        },
        itself: touch.itself.unwrap_or(true),
        obstacles: touch.obstacles.unwrap_or(false),
        ignored: Vec::new(),
        between: Vec::new(),
    })
}

/// The triangles of the surface of a body, by their particles.
fn triangles(source: &Source<'_>, row: usize, scene: &Scene) -> Result<Vec<[usize; 3]>, FileError> {
    let surface = &scene.bodies[row].surface;
    if surface.triangles.is_empty() {
        let reason = "needs a surface, and this body has none: leave it out";
        return Err(source.refuse(format_args!("bodies[{row}].touch.triangles"), reason));
    }
    let all = surface.particles().map(|corners| corners.map(|particle| particle as usize));
    Ok(all.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

/// How the particles of a body of a scene touch by their radii by default; `None` where its springs
/// say no radius or no stiffness, or there is no such body.
pub fn default_touch(scene: &Scene, body: usize) -> Option<Touch> {
    let particles = scene.bodies.get(body).map(|_| outside(scene, body))?;
    if particles.is_empty() {
        return None;
    }
    let own = own(scene, body, &particles);
    let stiffness = own.stiffness()?;
    Some(Touch {
        radius: own.radius()?,
        stiffness,
        damping: own.relaxation * stiffness,
        friction: FRICTION,
        triangles: Vec::new(),
        itself: true,
        obstacles: false,
        ignored: Vec::new(),
        between: Vec::new(),
        particles,
    })
}

/// The particles of a body on its outside: of its surface, all of them where it has none.
fn outside(scene: &Scene, row: usize) -> Vec<usize> {
    let body = &scene.bodies[row];
    let corners = body.surface.corners.iter().map(|corner| corner.particle as usize);
    let mut particles: Vec<usize> = corners.collect();
    particles.sort_unstable();
    particles.dedup();
    if particles.is_empty() { body.particles.clone().collect() } else { particles }
}

/// What a body says of its particles: the median of the shortest spring of each, metres, the mean
/// stiffness of all springs of one, N/m, and the relaxation time of its springs, seconds.
struct Own {
    spacing: Option<f64>,
    stiffness: f64,
    relaxation: f64,
}

impl Own {
    /// The default radius, metres.
    fn radius(&self) -> Option<f64> {
        self.spacing.map(|spacing| RADIUS * spacing)
    }

    /// The default stiffness of a touch, N/m.
    fn stiffness(&self) -> Option<f64> {
        Some(STIFFNESS * self.stiffness).filter(|&stiffness| 0.0 < stiffness)
    }
}

fn own(scene: &Scene, row: usize, particles: &[usize]) -> Own {
    let body = &scene.bodies[row];
    let first = body.particles.start;
    let mut shortest = vec![f64::INFINITY; body.particles.len()];
    let mut sums = vec![0.0; body.particles.len()];
    let (mut stiffness, mut damping) = (0.0, 0.0);
    for spring in &scene.springs[body.springs.clone()] {
        (stiffness, damping) = (stiffness + spring.stiffness, damping + spring.damping);
        for end in spring.ends {
            shortest[end - first] = f64::min(shortest[end - first], spring.rest_length);
            sums[end - first] += spring.stiffness;
        }
    }
    let mut lengths: Vec<f64> = particles.iter().map(|&at| shortest[at - first]).collect();
    let (_, &mut spacing, _) = {
        let middle = lengths.len() / 2;
        lengths.select_nth_unstable_by(middle, f64::total_cmp)
    };
    let sum: f64 = particles.iter().map(|&at| sums[at - first]).sum();
    Own {
        spacing: Some(spacing).filter(|&spacing| spacing.is_finite() && 0.0 < spacing),
        stiffness: sum / particles.len() as f64,
        relaxation: if 0.0 < stiffness { damping / stiffness } else { 0.0 },
    }
}

/// A line on a sheet that does not touch by its triangles and lets particles of its own radius
/// through where it is hardly stretched: the middle of a square of side a is a / √2 from its
/// corners.
fn leak(scene: &Scene, row: usize, touch: &Touch) -> Option<String> {
    let body = &scene.bodies[row];
    let is_open = touch.particles.len() == body.particles.len()
        && touch.triangles.is_empty()
        && !body.surface.corners.is_empty();
    let spacing = own(scene, row, &touch.particles).spacing.filter(|_| is_open)?;
    let strain = 2.0 * touch.radius * 2.0_f64.sqrt() / spacing - 1.0;
    (strain < 0.05).then(|| {
        let where_to = match strain <= 0.0 {
            true => "already at rest".to_owned(),
            false => format!("where they are stretched by {} %", told(100.0 * strain)),
        };
        format!(
            "{}: two sheets of this radius leak {where_to}; from a radius of {} m on only where \
             they are stretched by a quarter and more; `triangles = true` closes them",
            body.name,
            short(RADIUS * spacing),
        )
    })
}

/// The largest ball that fits between a side of a square and its two diagonals, as a part of the
/// side: across, (√2 − 1).
const HOLE: f64 = 0.414;

/// The least extent of a shape and the next, metres; of a mesh both are that of the largest ball in
/// it, or a cell where none is seen: what is thin of it is told in a run.
fn extents(shape: &Shape) -> [f64; 2] {
    let thickness = shape.thickness();
    match *shape {
        Shape::Box { size } => {
            let mut sizes = size.to_array();
            sizes.sort_by(f64::total_cmp);
            [sizes[0], sizes[1]]
        }
        Shape::Cylinder { radius, .. } => [thickness, 2.0 * radius],
        Shape::Mesh(ref grid) => {
            let deepest = grid.distances.iter().copied().fold(0.0, f64::min);
            [f64::max(-2.0 * deepest, grid.cell); 2]
        }
        _ => [thickness; 2],
    }
}

/// A line on each solid and body that pass through each other: particles on both sides of what is
/// thinner than they are apart, or what fits through the squares of a sheet.
pub(crate) fn pierced(scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    let extents: Vec<_> = scene.solids.iter().map(|solid| extents(&solid.shape)).collect();
    for (row, body) in scene.bodies.iter().enumerate() {
        let particles: Vec<usize> = body.particles.clone().collect();
        let Some(spacing) = own(scene, row, &particles).spacing else { continue };
        let touch = scene.touch_of(body).filter(|touch| touch.obstacles);
        let radius = touch.map_or(0.0, |touch| touch.radius);
        let is_sheet =
            !body.surface.corners.is_empty() && outside(scene, row).len() == body.particles.len();
        for (number, (solid, &[thickness, width])) in scene.solids.iter().zip(&extents).enumerate()
        {
            let across = thickness + 2.0 * radius;
            let name = &body.name;
            if spacing <= across {
                continue;
            }
            if !solid.springs {
                let edges = if spacing < width { "its edges" } else { "it" };
                notes.push(format!(
                    "world.solids[{number}] is {} m thick, the particles of {name} are {} m apart \
                     and pass beside {edges}; with `springs = true` it meets the springs between \
                     them too",
                    short(thickness),
                    short(spacing),
                ));
            } else if is_sheet && across < HOLE * spacing {
                notes.push(format!(
                    "world.solids[{number}] is {} m thick: its ends fit through the squares of \
                     {name}, {} m wide, between the springs",
                    short(thickness),
                    short(spacing),
                ));
            }
        }
    }
    notes
}

/// The body of a name.
fn named(source: &Source<'_>, key: &str, name: &str, scene: &Scene) -> Result<usize, FileError> {
    let bodies = &scene.bodies;
    let mut called = (0..bodies.len()).filter(|&body| bodies[body].name == name);
    let reason = match (called.next(), called.next()) {
        (Some(body), None) => return Ok(body),
        (Some(a), Some(b)) => {
            format!("is \"{name}\", the name of bodies {a} and {b}: give each a `name` of its own")
        }
        (None, _) => {
            let near = nearest(name, bodies.iter().map(|body| body.name.as_str()));
            let meant = near.map_or(String::new(), |near| format!("; `{near}` is one"));
            format!("names no body: \"{name}\"{meant}")
        }
    };
    Err(source.refuse(format_args!("{key}"), reason))
}
