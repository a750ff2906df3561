//! Particles of bodies as rows choose them: one by its number or its place, every n-th of the top
//! row, or a set; [`pins`] hold them, [`links`] join them and [`materials`] set the springs between
//! them.
//!
//! A lattice has sets by its shape, a mesh those of its surface and those that its file names;
//! others are the particles inside a box or a sphere at the start.

pub(crate) mod own;
pub(crate) mod materials;
pub(crate) mod pins;
pub(crate) mod links;

use crate::error::{FileError, nearest, plain};
use crate::file::schema::{
    BodyKey, EndRow, Kind, MassRow, MaterialRow, PinRow, SceneFile, SetRow, SolidRow,
};
use crate::file::sets::own::{OwnSets, SHAPES};
use crate::file::tree::Source;
use crate::shown::tame;
use glam::DVec3;
use msd_core::{Lattice, Scene};
use std::collections::{BTreeMap, BTreeSet};

/// The choice of particles by a row; exactly one of its keys but `body` is given.
#[derive(Clone, Copy, Default)]
pub(crate) struct Choice<'r> {
    body: Option<&'r BodyKey>,
    particle: Option<i64>,
    at: Option<[u64; 3]>,
    every: Option<u64>,
    set: Option<&'r str>,
}

impl<'r> From<&'r PinRow> for Choice<'r> {
    fn from(row: &'r PinRow) -> Self {
        let PinRow { particle, at, every, .. } = *row;
        Choice { body: row.body.as_ref(), particle, at, every, set: row.set.as_deref() }
    }
}

impl<'r> From<&'r MassRow> for Choice<'r> {
    fn from(row: &'r MassRow) -> Self {
        let MassRow { particle, at, .. } = *row;
        Choice { body: row.body.as_ref(), particle, at, every: None, set: row.set.as_deref() }
    }
}

impl<'r> From<&'r MaterialRow> for Choice<'r> {
    fn from(row: &'r MaterialRow) -> Self {
        Choice { body: row.body.as_ref(), set: Some(&row.set), ..Choice::default() }
    }
}

impl<'r> From<&'r EndRow> for Choice<'r> {
    fn from(row: &'r EndRow) -> Self {
        let EndRow { particle, at, .. } = *row;
        Choice { body: row.body.as_ref(), particle, at, every: None, set: row.set.as_deref() }
    }
}

/// A side of a lattice: its name, the axis as (row, column, stack), whether it is the far end.
type Side = (&'static str, usize, bool);

/// The sides of a lattice before it is turned; rows run along y, columns along x, stacks along z.
const SIDES: [Side; 6] = [
    ("left", 1, false),
    ("right", 1, true),
    ("bottom", 0, false),
    ("top", 0, true),
    ("back", 2, false),
    ("front", 2, true),
];

/// The most names that a message lists.
const MOST_NAMES: usize = 20;

/// A space that particles are in.
#[derive(Clone, Copy)]
enum Space {
    /// A box: its middle, and half its sides.
    Box(DVec3, DVec3),
    /// A sphere: its middle and its radius.
    Sphere(DVec3, f64),
}

impl Space {
    fn holds(self, place: DVec3) -> bool {
        // Particles that are meant to lie on the surface are a few roundings off.
        let wide = 1.0 + 1e-9;
        match self {
            Space::Box(middle, half) => (place - middle).abs().cmple(wide * half).all(),
            Space::Sphere(middle, radius) => place.distance(middle) <= wide * radius,
        }
    }
}

/// The sets of a scene whose bodies are built.
pub(crate) struct NamedSets<'s> {
    pub(crate) source: &'s Source<'s>,
    pub(crate) scene: &'s Scene,
    own_sets: &'s [OwnSets],
    /// Those of the author: the body of each, and where its particles are.
    own: BTreeMap<&'s str, (usize, Space)>,
}

impl<'s> NamedSets<'s> {
    /// Reads the rows of sets.
    ///
    /// # Errors
    /// A name that is taken, a space without any or of no size, a set of no particle.
    pub(crate) fn new(
        source: &'s Source<'s>,
        rows: &'s [SetRow],
        (scene, own_sets): (&'s Scene, &'s [OwnSets]),
    ) -> Result<Self, FileError> {
        let mut sets = NamedSets { source, scene, own_sets, own: BTreeMap::new() };
        for (row, set) in rows.iter().enumerate() {
            let key = format!("sets[{row}]");
            let name = set.name.as_str();
            if SHAPES.contains(&name) || SIDES.iter().any(|side| side.0 == name) {
                let reason = format!("is `{name}`, which bodies have of their own: choose another");
                return Err(source.refuse(format_args!("{key}.name"), reason));
            }
            if name.is_empty() || sets.own.contains_key(name) {
                let expected = if name.is_empty() {
                    "a name, which rows can call it by"
                } else {
                    "a name that no other set has"
                };
                let value = format!("\"{name}\"");
                return Err(source.out_of_domain(format_args!("{key}.name"), value, expected));
            }
            let body = sets.body(&key, set.body.as_ref())?;
            let space = space(source, (&key, set), scene.world.extent)?;
            let mut places = scene.particles[scene.bodies[body].particles.clone()].iter();
            if !places.any(|particle| space.holds(particle.position)) {
                let reason = format!("holds no particle of {}", sets.title(body));
                return Err(source.refuse(format_args!("{key}"), reason + &sets.reach(body)));
            }
            sets.own.insert(name, (body, space));
        }
        Ok(sets)
    }

    /// The particles that the row at `key` means, ascending and never none.
    ///
    /// # Errors
    /// Not exactly one choice; a body, a particle or a set that is not there.
    pub(crate) fn particles(
        &self,
        key: &str,
        choice: impl Into<Choice<'s>>,
    ) -> Result<Vec<usize>, FileError> {
        let choice: Choice<'_> = choice.into();
        let source = self.source;
        let own = choice.set.and_then(|name| self.own.get(name));
        let body = match (choice.body, own) {
            (None, Some(&(body, _))) => body,
            (body, _) => self.body(key, body)?,
        };
        let range = self.scene.bodies[body].particles.clone();
        let lattice = self.lattice(body);
        if (choice.at.is_some() || choice.every.is_some()) && lattice.is_none() {
            let reason = format!("has the key `at` or `every`, but body {body} is not a lattice");
            return Err(source.refuse(format_args!("{key}"), reason));
        }
        let Choice { particle, at, every, set, .. } = choice;
        let particles: Vec<usize> = match (particle, at, every, set, lattice) {
            (Some(particle), None, None, None, _) => {
                let key = format_args!("{key}.particle");
                vec![source.index(key, particle, ("particle", range.len()))?]
            }
            (None, Some(at), None, None, Some(lattice)) => {
                let mut place = [0; 3];
                for (axis, name) in ["row", "column", "stack"].into_iter().enumerate() {
                    let key = format_args!("{key}.at[{axis}]");
                    place[axis] = source.index(key, at[axis], (name, lattice.size()[axis]))?;
                }
                vec![lattice.particle(place)]
            }
            (None, None, Some(every), None, Some(lattice)) => {
                let every = source.count(format_args!("{key}.every"), every)?;
                let every = usize::try_from(every).unwrap_or(usize::MAX);
                let top = lattice.particle([lattice.size()[0] - 1, 0, 0]);
                (top..lattice.particle_count()).step_by(every).collect()
            }
            (None, None, None, Some(name), _) => self.set(key, (body, name))?,
            _ => {
                let every = if key.starts_with("pins") { ", `every`" } else { "" };
                let reason =
                    format!("needs exactly one of the keys `particle`, `at`{every} and `set`");
                return Err(source.refuse(format_args!("{key}"), reason));
            }
        };
        Ok(particles.into_iter().map(|particle| range.start + particle).collect())
    }

    /// A line on each mesh of which rows choose particles by number: these are not the numbers of
    /// the vertices in its file, some of which may have been merged or left out.
    pub(crate) fn numbered(&self, file: &SceneFile) -> Vec<String> {
        let pins = file.pins.iter().map(Choice::from);
        let masses = file.masses.iter().map(Choice::from);
        let ends = file.links.iter().flat_map(|link| [&link.from, &link.to]);
        let ends = ends.filter(|end| end.solid.is_none()).map(Choice::from);
        let by_number = pins.chain(masses).chain(ends).filter(|choice| choice.particle.is_some());
        let bodies = by_number.filter_map(|choice| self.body("", choice.body).ok());
        let meshes = bodies.filter(|&body| file.bodies[body].kind == Kind::Mesh);
        let line = |body: usize| {
            let name = &self.scene.bodies[body].name;
            format!(
                "a `particle` of {name} is a number among its particles, not that of a vertex in \
                 its file; choose by place, with a set of a `sphere` or a `box`, or by the name \
                 of a group"
            )
        };
        meshes.collect::<BTreeSet<usize>>().into_iter().map(line).collect()
    }

    /// The lattice that a body is.
    fn lattice(&self, body: usize) -> Option<&'s Lattice> {
        match &self.own_sets[body] {
            OwnSets::Lattice(lattice) => Some(lattice),
            OwnSets::Groups(_) => None,
        }
    }

    /// Whether the file of a mesh has a name.
    pub(crate) fn is_group(&self, name: &str) -> bool {
        let has =
            |own: &OwnSets| matches!(own, OwnSets::Groups(groups) if groups.contains_key(name));
        self.own_sets.iter().any(has)
    }

    /// The number of a body.
    fn body(&self, key: &str, body: Option<&BodyKey>) -> Result<usize, FileError> {
        let Some(body) = body else { return Ok(0) };
        let names = self.scene.bodies.iter().map(|body| &*body.name).collect::<Vec<&str>>();
        numbered(self.source, &format!("{key}.body"), body, ("body", "bodies", &names))
    }

    /// The particles of a set, counted in its body.
    fn set(&self, key: &str, (body, name): (usize, &str)) -> Result<Vec<usize>, FileError> {
        let scene = self.scene;
        let range = scene.bodies[body].particles.clone();
        let refused = |expected: String| {
            let value = format!("\"{name}\"");
            self.source.out_of_domain(format_args!("{key}.set"), value, expected)
        };
        if let Some(&(of, space)) = self.own.get(name) {
            if of != body {
                let (it, other) = (self.title(body), self.title(of));
                return Err(refused(format!("a set of {it}; this is one of {other}")));
            }
            let particles = scene.particles[range].iter().enumerate();
            let inside = particles.filter(|(_, particle)| space.holds(particle.position));
            return Ok(inside.map(|(number, _)| number).collect());
        }
        let known = self.known(body);
        if !known.contains(&name) {
            let own = self.own.iter().filter(|(_, set)| set.0 == body).map(|(&name, _)| name);
            let it = self.title(body);
            let near = nearest(name, known.iter().copied().chain(own));
            let meant = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            let more = known.len().saturating_sub(MOST_NAMES);
            let more = if 0 < more { format!(" and {more} more") } else { String::new() };
            let known: Vec<String> = known.iter().take(MOST_NAMES).map(|name| tame(name)).collect();
            let known = known.join(", ") + &more;
            return Err(refused(format!("a set of {it}: {known}, or one of [[sets]]{meant}")));
        }
        let count = range.len();
        Ok(match (name, &self.own_sets[body]) {
            ("all", _) => (0..count).collect(),
            ("first", _) => vec![0],
            ("last", _) => vec![count - 1],
            (_, OwnSets::Lattice(lattice)) => of_lattice(lattice, name),
            (_, OwnSets::Groups(groups)) => match groups.get(name) {
                Some(particles) => particles.clone(),
                None => self.of_surface(body, name),
            },
        })
    }

    /// The sets that a body has of its own.
    fn known(&self, body: usize) -> Vec<&str> {
        let mut known = vec!["all", "first", "last"];
        let lattice = match &self.own_sets[body] {
            OwnSets::Lattice(lattice) => lattice,
            OwnSets::Groups(groups) => {
                let surface = &self.scene.bodies[body].surface;
                known.extend((!surface.triangles.is_empty()).then_some("surface"));
                known.extend((surface.two_sided && !self.rim(body).is_empty()).then_some("edges"));
                known.extend(groups.keys().map(String::as_str));
                return known;
            }
        };
        let long = |axis: usize| 1 < lattice.size()[axis];
        known.push("corners");
        let extent = (0..3).filter(|&axis| long(axis)).count();
        known.extend((2 <= extent).then_some("edges"));
        known.extend((3 <= extent).then_some("surface"));
        known.extend(SIDES.iter().filter(|side| long(side.1)).map(|side| side.0));
        known
    }

    /// The particles of the surface of a mesh, or those of its rim.
    fn of_surface(&self, body: usize, name: &str) -> Vec<usize> {
        let first = self.scene.bodies[body].particles.start;
        let mut found = match name {
            "edges" => self.rim(body),
            _ => {
                let corners = &self.scene.bodies[body].surface.corners;
                corners.iter().map(|corner| corner.particle).collect()
            }
        };
        found.sort_unstable();
        found.dedup();
        found.into_iter().map(|particle| particle as usize - first).collect()
    }

    /// The ends of the edges of a surface that belong to one triangle only.
    fn rim(&self, body: usize) -> Vec<u32> {
        self.scene.bodies[body].surface.rim(|_| true).concat()
    }

    /// A body as a message calls it.
    pub(crate) fn title(&self, body: usize) -> String {
        format!("body {body}, `{}`", self.scene.bodies[body].name)
    }

    /// Where the particles of a body are, for a message.
    fn reach(&self, body: usize) -> String {
        let particles = &self.scene.particles[self.scene.bodies[body].particles.clone()];
        let places = particles.iter().map(|particle| particle.position);
        let Some(low) = places.clone().reduce(DVec3::min) else { return String::new() };
        let high = places.fold(low, DVec3::max);
        // Divided, a whole number of micrometres has few digits; nor is zero negative then.
        let words = |place: DVec3| place.to_array().map(|x| plain((x * 1e6).round() / 1e6 + 0.0));
        format!(", which lies from ({}) to ({})", words(low).join(", "), words(high).join(", "))
    }
}

/// So many names at most are listed where a key has none of them.
const FEW: usize = 8;

/// The number of the solid that a key calls by its number or its name.
fn solid(
    source: &Source<'_>,
    key: &str,
    called: &BodyKey,
    rows: &[SolidRow],
) -> Result<usize, FileError> {
    let name = |row: &'_ SolidRow| row.name.clone().unwrap_or_else(|| row.kind.name().into());
    let names: Vec<String> = rows.iter().map(name).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    numbered(source, key, called, ("solid", "solids", &names))
}

/// The number of a row that a key calls by its number or its name, among rows of these names.
fn numbered(
    source: &Source<'_>,
    key: &str,
    called: &BodyKey,
    (one, many, names): (&'static str, &str, &[&str]),
) -> Result<usize, FileError> {
    let key = format_args!("{key}");
    let name = match called {
        &BodyKey::Number(number) => return source.index(key, number, (one, names.len())),
        BodyKey::Name(name) => name,
    };
    let mut called = (0..names.len()).filter(|&number| names[number] == name);
    let expected = match (called.next(), called.next()) {
        (Some(number), None) => return Ok(number),
        (Some(a), Some(b)) => format!("one name of one {one}: {many} {a} and {b} have this one"),
        (None, _) => {
            let hint = match nearest(name, names.iter().copied()) {
                Some(near) => format!(": did you mean `{near}`?"),
                None if names.is_empty() => format!("; there are no {many}"),
                None if FEW < names.len() => String::new(),
                None => format!(": `{}`", names.join("`, `")),
            };
            format!("the number or the name of a {one}{hint}")
        }
    };
    Err(source.out_of_domain(key, format!("\"{name}\""), expected))
}

/// The particles of a set that lattices have by their shape.
fn of_lattice(lattice: &Lattice, name: &str) -> Vec<usize> {
    let size = lattice.size();
    let side = SIDES.iter().find(|side| side.0 == name);
    let long = size.iter().filter(|&&length| 1 < length).count();
    // The number of coordinates of a particle that must be at an end.
    let ends = match name {
        "corners" => long,
        "edges" => long - 1,
        _ => 1,
    };
    let is_in = |&particle: &usize| {
        let place = lattice.place(particle);
        if let Some(&(_, axis, is_far)) = side {
            return place[axis] == if is_far { size[axis] - 1 } else { 0 };
        }
        let is_end =
            |axis: usize| 1 < size[axis] && (place[axis] == 0 || place[axis] == size[axis] - 1);
        ends <= (0..3).filter(|&axis| is_end(axis)).count()
    };
    (0..lattice.particle_count()).filter(is_in).collect()
}

/// The space of the set at `key`.
fn space(
    source: &Source<'_>,
    (key, set): (&str, &SetRow),
    extent: f64,
) -> Result<Space, FileError> {
    match (set.cuboid, set.sphere) {
        (Some(cuboid), None) => {
            let position = format_args!("{key}.box.position");
            let middle = source.position(position, cuboid.position, extent)?;
            for (axis, &side) in cuboid.size.iter().enumerate() {
                source.number(format_args!("{key}.box.size[{axis}]"), side)?;
            }
            Ok(Space::Box(middle, 0.5 * DVec3::from_array(cuboid.size)))
        }
        (None, Some(sphere)) => {
            let position = format_args!("{key}.sphere.position");
            let middle = source.position(position, sphere.position, extent)?;
            let radius = source.number(format_args!("{key}.sphere.radius"), sphere.radius)?;
            Ok(Space::Sphere(middle, radius))
        }
        _ => {
            let reason = "needs exactly one of the keys `box` and `sphere`";
            Err(source.refuse(format_args!("{key}"), reason))
        }
    }
}
