//! Contact of bodies, from the keys `touch`: surfaces, ropes and points that keep a thickness.

mod starts;

pub(crate) use starts::{started_in_each_other, started_inside};

use crate::crossing::{Triangle, each_crossing};
use crate::error::{FileError, nearest, plain};
use crate::file::decode::decode;
use crate::file::keys::Live;
use crate::file::obstacles::short;
use crate::file::schema::{BodyKey, BodyRow, Kind, SceneFile, TouchRow, VERSION, WithRow};
use crate::file::substance::known;
use crate::file::tree::{Assignment, Node, Source, Value};
use msd_core::glam::DVec3;
use msd_core::scene::{Between, Shell};
use msd_core::{Scene, Settings, Shape, Simulation};

/// The thickness by default, as a part of the spacing.
const THICKNESS: f64 = 0.1;
/// The largest thickness, as a part of the spacing: features that share no particle are a spacing
/// apart at rest, and each keeps its thickness.
const THICKEST: f64 = 0.4;
/// The longest spring that is an edge, as a part of the spacing: longer ones span particles.
const LONGEST: f64 = 1.5;
const FRICTION: f64 = 0.5;

/// Lets the bodies meet that have a key `touch`; notes which of its keys have no effect.
///
/// # Errors
/// A number out of its domain, an unknown name, a body without a thickness.
pub(crate) fn touch(
    source: &Source<'_>,
    bodies: &[BodyRow],
    scene: &mut Scene,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let exempt = |scene: &Scene, row: usize, shell: &Shell| {
        if bodies[row].kind == Kind::Mesh { closed(scene, shell) } else { Vec::new() }
    };
    let rows: Vec<_> = bodies.iter().map(|body| body.touch.as_ref()).collect();
    scene.shells = shells(source, (&rows, &exempt), scene, notes)?;
    meet_materials(source, bodies, scene, notes)?;
    Ok(())
}

/// The collision settings of the bodies of a scene where some keys inside `bodies[N].touch` are
/// set; other keys are ignored.
///
/// # Errors
/// A number out of its domain, an unknown name, a body without a thickness.
pub fn shells_of<'e>(
    scene: &Scene,
    edits: impl Iterator<Item = &'e Assignment>,
) -> Result<Vec<Shell>, FileError> {
    let exempt = |scene: &Scene, row: usize, shell: &Shell| match own(&scene.shells, scene, row) {
        Some((_, written)) => written.exempt.clone(),
        None => closed(scene, shell),
    };
    let rows = touch_rows(scene, edits)?;
    let rows: Vec<_> = rows.iter().map(Option::as_ref).collect();
    let source = Source::of(Node { value: Value::Nothing, offset: None }, "contact");
    let mut each = rows.iter().enumerate().flat_map(|(row, touch)| entries(row, *touch));
    if let Some((key, _)) = each.find(|(_, with)| with.material.is_some()) {
        let reason = "counts in a scene file alone; name a `body`";
        return Err(source.refuse(format_args!("{key}.material"), reason));
    }
    shells(&source, (&rows, &exempt), scene, &mut Vec::new())
}

/// The collision settings of the bodies of a scene, as rows of a scene file, where some keys are
/// set as in [`shells_of`]. Settings of two bodies stand with the later one.
///
/// # Errors
/// A key or a value that a scene cannot have.
pub fn touch_rows<'e>(
    scene: &Scene,
    edits: impl Iterator<Item = &'e Assignment>,
) -> Result<Vec<Option<TouchRow>>, FileError> {
    let row = |row| BodyRow { touch: written(scene, row), ..BodyRow::default() };
    let bodies = (0..scene.bodies.len()).map(row).collect();
    let file = SceneFile { version: VERSION, bodies, ..SceneFile::default() };
    let refused = |error: &dyn std::fmt::Display| {
        let (file, reason) = ("contact".into(), error.to_string());
        FileError::Unreadable { file, reason }
    };
    let root = serde_json::to_value(file).and_then(serde_json::from_value);
    let mut source = Source::of(root.map_err(|error| refused(&error))?, "contact");
    edits.filter(|edit| edit.live() == Live::Touch).try_for_each(|edit| edit.apply(&mut source))?;
    let file: SceneFile = decode(&source)?;
    Ok(file.bodies.into_iter().map(|body| body.touch).collect())
}

/// The shell of a body, with its place among all.
fn own<'s>(shells: &'s [Shell], scene: &Scene, body: usize) -> Option<(usize, &'s Shell)> {
    shells.iter().enumerate().find(|(_, shell)| shell.is_of(&scene.bodies[body]))
}

/// The collision settings of a body of a scene, as a row of a scene file.
fn written(scene: &Scene, row: usize) -> Option<TouchRow> {
    let (_, shell) = own(&scene.shells, scene, row)?;
    let key = |shell: usize| {
        let is_of = |body: &msd_core::Body| scene.shells[shell].is_of(body);
        BodyKey::Number(scene.bodies.iter().position(is_of).unwrap_or(row) as u64)
    };
    let with = |&Between { shell, friction, restitution }: &Between| WithRow {
        body: Some(key(shell)),
        friction,
        restitution,
        ..WithRow::default()
    };
    Some(TouchRow {
        thickness: Some(shell.thickness),
        friction: Some(shell.friction),
        restitution: Some(shell.restitution),
        itself: Some(shell.itself),
        obstacles: Some(shell.obstacles),
        ignore: shell.ignored.iter().map(|&shell| key(shell)).collect(),
        with: shell.between.iter().map(with).collect(),
        ..TouchRow::default()
    })
}

/// The pairs of particles of the shell of a body that do not meet each other.
type Exempt<'e> = &'e dyn Fn(&Scene, usize, &Shell) -> Vec<[usize; 2]>;

/// The shells of the bodies of a scene by their rows.
fn shells(
    source: &Source<'_>,
    (touches, exempt): (&[Option<&TouchRow>], Exempt<'_>),
    scene: &Scene,
    notes: &mut Vec<String>,
) -> Result<Vec<Shell>, FileError> {
    let (mut shells, mut rows) = (Vec::new(), vec![None; touches.len()]);
    for (row, touch) in touches.iter().enumerate() {
        let Some(touch) = touch else { continue };
        let thickness = thickness(source, (row, touch), scene, notes)?;
        rows[row] = Some(shells.len());
        let mut shell = made(source, (row, touch), thickness, scene)?;
        shell.exempt = exempt(scene, row, &shell);
        notes.extend(superfluous(&scene.bodies[row].name, touch));
        shells.push(shell);
    }
    for (row, touch) in touches.iter().enumerate() {
        for (at, name) in touch.iter().flat_map(|touch| touch.ignore.iter().enumerate()) {
            let key = format!("bodies[{row}].touch.ignore[{at}]");
            let other = named(source, &key, name, scene)?;
            if row == other && rows[row].is_some() {
                let reason = "is the body itself; use `itself = false` instead";
                return Err(source.refuse(format_args!("{key}"), reason));
            }
            if let (Some(a), Some(b)) = (rows[row], rows[other]) {
                shells[a.max(b)].ignored.push(a.min(b));
            }
        }
    }
    for (row, touch) in touches.iter().enumerate() {
        for (key, with) in entries(row, *touch) {
            if let Some(body) = other_body(source, (&key, with))? {
                let with = (&key[..], row, with, body);
                notes.extend(add_between(source, with, (&rows, scene), &mut shells)?);
            }
        }
    }
    Ok(shells)
}

/// The entries `with` of a body, each with its key.
fn entries(row: usize, touch: Option<&TouchRow>) -> impl Iterator<Item = (String, &WithRow)> {
    let with = touch.into_iter().flat_map(|touch| touch.with.iter().enumerate());
    with.map(move |(at, with)| (format!("bodies[{row}].touch.with[{at}]"), with))
}

/// The body that an entry names; none where it names a material.
fn other_body<'w>(
    source: &Source<'_>,
    (key, with): (&str, &'w WithRow),
) -> Result<Option<&'w BodyKey>, FileError> {
    let reason = match (&with.body, &with.material) {
        (Some(body), None) => return Ok(Some(body)),
        (None, Some(_)) => return Ok(None),
        (Some(_), Some(_)) => "has both `body` and `material`; remove one of them",
        (None, None) => "lacks the key `body` or `material`: whom the body meets so",
    };
    Err(source.refuse(format_args!("{key}"), reason))
}

/// Sets the contact of bodies with those of a material; an entry for a single body stands.
fn meet_materials(
    source: &Source<'_>,
    bodies: &[BodyRow],
    scene: &mut Scene,
    notes: &mut Vec<String>,
) -> Result<(), FileError> {
    let each = bodies.iter().enumerate();
    for (row, (key, with)) in each
        .flat_map(|(row, body)| entries(row, body.touch.as_ref()).map(move |entry| (row, entry)))
    {
        let Some(material) = &with.material else { continue };
        known(source, &format!("{key}.material"), material)?;
        let [friction, restitution] = law_of(source, (&key, with))?;
        let is_of = |&other: &usize| other != row && bodies[other].material == with.material;
        let place = |body: usize| own(&scene.shells, scene, body).map(|(place, _)| place);
        let Some(mine) = place(row) else { continue };
        let others: Vec<usize> = (0..bodies.len()).filter(is_of).filter_map(place).collect();
        if others.is_empty() {
            let has = format!("no other body of \"{material}\" has a table `touch`");
            notes.push(format!("{key} has no effect: {has}"));
        }
        for other in others {
            let [first, last] = [mine.min(other), mine.max(other)];
            let shell = &mut scene.shells[last];
            let is_said = shell.between.iter().any(|between| between.shell == first);
            if !is_said && !shell.ignored.contains(&first) {
                shell.between.push(Between { shell: first, friction, restitution });
            }
        }
    }
    Ok(())
}

/// Friction and restitution of an entry.
fn law_of(
    source: &Source<'_>,
    (key, with): (&str, &WithRow),
) -> Result<[Option<f64>; 2], FileError> {
    let number = |name: &str, value: Option<f64>| {
        value.map(|value| source.number(format_args!("{key}.{name}"), value)).transpose()
    };
    Ok([number("friction", with.friction)?, number("restitution", with.restitution)?])
}

/// The thickness of a body, metres; notes where it follows from the radius of an older file.
fn thickness(
    source: &Source<'_>,
    (row, touch): (usize, &TouchRow),
    scene: &Scene,
    notes: &mut Vec<String>,
) -> Result<f64, FileError> {
    let key = format!("bodies[{row}].touch");
    let spacing = spacing(scene, row);
    // By either rounding: the window sets four times the default.
    let most = |spacing: f64| f64::max(THICKEST * spacing, 4.0 * (THICKNESS * spacing));
    let most = spacing.map_or(f64::INFINITY, most);
    match (touch.thickness, touch.radius) {
        (Some(_), Some(_)) => {
            let reason = "is the older name of `thickness`, which is given too; remove `radius`";
            Err(source.refuse(format_args!("{key}.radius"), reason))
        }
        (Some(thickness), None) if most < thickness => {
            let expected = format!("at most {THICKEST} of the spacing, {} m", short(most));
            let key = format_args!("{key}.thickness");
            Err(source.out_of_domain(key, plain(thickness), expected))
        }
        (Some(thickness), None) => source.number(format_args!("{key}.thickness"), thickness),
        (None, Some(radius)) => {
            let thickness = source.number(format_args!("{key}.radius"), radius)?.min(most);
            notes.push(format!(
                "{}: `touch.radius` is an older key, read as `thickness = {}`",
                scene.bodies[row].name,
                short(thickness),
            ));
            Ok(thickness)
        }
        (None, None) => spacing.map(|spacing| THICKNESS * spacing).ok_or_else(|| {
            let reason = "lacks the key `thickness`: without springs it has no default";
            source.refuse(format_args!("{key}"), reason)
        }),
    }
}

/// The shell of a body: its surface, or the springs and the lone particles of one that has none.
///
/// # Errors
/// A number out of its domain.
fn made(
    source: &Source<'_>,
    (row, touch): (usize, &TouchRow),
    thickness: f64,
    scene: &Scene,
) -> Result<Shell, FileError> {
    let number = |name: &str, value: Option<f64>, default: f64| {
        source.number(format_args!("bodies[{row}].touch.{name}"), value.unwrap_or(default))
    };
    let shell = shell(scene, row, thickness);
    Ok(Shell {
        friction: number("friction", touch.friction, FRICTION)?,
        restitution: number("restitution", touch.restitution, 0.0)?,
        itself: touch.itself.unwrap_or(shell.itself),
        obstacles: touch.obstacles.unwrap_or(false),
        ..shell
    })
}

/// The shell of a body with the default of every number but its thickness, metres.
fn shell(scene: &Scene, row: usize, thickness: f64) -> Shell {
    let body = &scene.bodies[row];
    let has_surface = !body.surface.triangles.is_empty();
    // A solid body seldom meets itself, and its whole surface is near: a search costs much.
    let itself = !has_surface || body.surface.two_sided;
    let mut shell = Shell { friction: FRICTION, itself, ..Shell::of(body, thickness) };
    if has_surface {
        return shell;
    }
    let longest = spacing(scene, row).map_or(f64::INFINITY, |spacing| LONGEST * spacing);
    let springs = &scene.springs[body.springs.clone()];
    let short = springs.iter().filter(|spring| spring.rest_length <= longest);
    shell.edges = short.map(|spring| spring.ends).collect();
    let mut is_end = vec![false; body.particles.len()];
    for &end in shell.edges.as_flattened() {
        is_end[end - body.particles.start] = true;
    }
    shell.points =
        body.particles.clone().zip(is_end).filter(|(_, is)| !is).map(|(at, _)| at).collect();
    shell
}

/// The default collision settings of a body of a scene; `None` where there is no such body, or no
/// springs from which its thickness follows.
pub fn default_shell(scene: &Scene, body: usize) -> Option<Shell> {
    scene.bodies.get(body)?;
    let spacing = spacing(scene, body)?;
    let shell = shell(scene, body, THICKNESS * spacing);
    Some(Shell { exempt: closed(scene, &shell), ..shell })
}

/// The pairs of particles of a shell whose features are closer at the start than the distance at
/// which it stops itself, or go through each other.
fn closed(scene: &Scene, shell: &Shell) -> Vec<[usize; 2]> {
    if !shell.itself {
        return Vec::new();
    }
    let positions: Vec<DVec3> = scene.particles.iter().map(|row| row.position).collect();
    let triangles = shell.triangles.iter().map(|&corners| Triangle::new(corners, &positions));
    let mut pairs = Vec::new();
    each_crossing(triangles.collect(), |[one, other]| {
        pairs.extend(one.into_iter().flat_map(|a| other.map(|b| [a, b])));
    });
    let (particles, world) = (scene.particles.clone(), scene.world);
    let mut alone = Scene { particles, world, shells: vec![shell.clone()], ..Scene::default() };
    // Where the nearest features are exempt, others may be next.
    for _ in 0..MOST_ROUNDS {
        alone.shells[0].exempt = pairs.clone();
        let run = Simulation::<f64>::new(&alone, Settings::default());
        let found = run.map_or(Vec::new(), |run| run.closed_pairs());
        if found.is_empty() {
            break;
        }
        pairs.extend(found);
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Rounds of exempting features after which the rest is left to contact.
const MOST_ROUNDS: usize = 8;

/// A line on the keys of older files that have no effect, as contact has no stiffness.
fn superfluous(body: &str, touch: &TouchRow) -> Option<String> {
    let keys = [
        ("stiffness", touch.stiffness.is_some()),
        ("damping", touch.damping.is_some()),
        ("triangles", touch.triangles.is_some()),
    ];
    let there: Vec<String> =
        keys.iter().filter(|(_, is)| *is).map(|(name, _)| format!("`touch.{name}`")).collect();
    let (last, first) = there.split_last()?;
    let (names, have) = match first {
        [] => (last.clone(), "has"),
        _ => (format!("{} and {last}", first.join(", ")), "have"),
    };
    Some(format!(
        "{body}: {names} {have} no effect: surfaces meet by their triangles, without a stiffness"
    ))
}

/// Adds how a body meets another; a line where that has no effect.
fn add_between(
    source: &Source<'_>,
    (key, row, with, body): (&str, usize, &WithRow, &BodyKey),
    (rows, scene): (&[Option<usize>], &Scene),
    shells: &mut [Shell],
) -> Result<Option<String>, FileError> {
    let of_body = format!("{key}.body");
    let refuse = |reason: &str| Err(source.refuse(format_args!("{of_body}"), reason));
    let [friction, restitution] = law_of(source, (key, with))?;
    let other = named(source, &of_body, body, scene)?;
    let name = &scene.bodies[other].name;
    let (Some(a), Some(b)) = (rows[row], rows[other]) else {
        return Ok(Some(format!("{key} has no effect: \"{name}\" has no table `touch`")));
    };
    if a == b {
        return refuse("is the body itself; set its own values in `touch`");
    }
    let shell = &mut shells[a.max(b)];
    if shell.ignored.contains(&a.min(b)) {
        return refuse(&format!("is \"{name}\", and one of the two ignores the other"));
    }
    if shell.between.iter().any(|between| between.shell == a.min(b)) {
        let reason = format!("is \"{name}\" again; give each pair of bodies one entry");
        return refuse(&reason);
    }
    shell.between.push(Between { shell: a.min(b), friction, restitution });
    let is_older = with.stiffness.is_some() || with.damping.is_some();
    Ok(is_older.then(|| {
        format!(
            "{key}: `stiffness` and `damping` have no effect: surfaces meet without a stiffness"
        )
    }))
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

/// The median of the shortest spring of each particle on the outside of a body, metres; none where
/// it has no springs.
fn spacing(scene: &Scene, row: usize) -> Option<f64> {
    spacing_of(scene, row, &outside(scene, row))
}

/// The same of some particles of it.
fn spacing_of(scene: &Scene, row: usize, particles: &[usize]) -> Option<f64> {
    let body = &scene.bodies[row];
    let first = body.particles.start;
    let mut shortest = vec![f64::INFINITY; body.particles.len()];
    for spring in &scene.springs[body.springs.clone()] {
        for end in spring.ends {
            shortest[end - first] = f64::min(shortest[end - first], spring.rest_length);
        }
    }
    let mut lengths: Vec<f64> = particles.iter().map(|&at| shortest[at - first]).collect();
    let middle = lengths.len() / 2;
    let (_, &mut spacing, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    Some(spacing).filter(|&spacing| spacing.is_finite() && 0.0 < spacing)
}

/// The largest ball that fits between a side of a square and its two diagonals, as a part of the
/// side: across, (√2 − 1).
const HOLE: f64 = 0.414;

/// The least extent of a shape and the next, metres. Of a mesh both are that of the largest ball in
/// it, or a cell where none is seen: a run reports particles that pass through thin parts.
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

/// A line on each solid and body that pass through each other. Such a solid is thinner than the
/// distance of two particles, or fits through the squares of a sheet.
pub(crate) fn pierced(scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    let extents: Vec<_> = scene.solids.iter().map(|solid| extents(&solid.shape)).collect();
    for (row, body) in scene.bodies.iter().enumerate() {
        let particles: Vec<usize> = body.particles.clone().collect();
        let Some(spacing) = spacing_of(scene, row, &particles) else { continue };
        let shell = scene.shell_of(body).filter(|shell| shell.obstacles);
        let radius = shell.map_or(0.0, |shell| shell.thickness);
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

/// The body of a name or a number.
fn named(source: &Source<'_>, key: &str, by: &BodyKey, scene: &Scene) -> Result<usize, FileError> {
    let bodies = &scene.bodies;
    let name = match by {
        &BodyKey::Number(number) => {
            return source.index(format_args!("{key}"), number, ("body", bodies.len()));
        }
        BodyKey::Name(name) => name,
    };
    let mut called = (0..bodies.len()).filter(|&body| bodies[body].name == *name);
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
