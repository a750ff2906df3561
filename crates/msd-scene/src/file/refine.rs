//! A scene at a part of its spacing: the same bodies, finer.
//!
//! A lattice keeps its particles and gets others between them; of a mesh every triangle is cut into
//! four and the lattice inside is set closer. A body made of a material stays one of that material.
//! A body of alike springs keeps its density and the moduli that its springs give inside. The row
//! of a key has the change of its value, [`Scale`](super::keys::Scale). Masses put on particles,
//! and links, stay at the particles that they had.

use crate::error::FileError;
use crate::file::bodies::MeshReader;
use crate::file::build::{Understood, understand_rows};
use crate::file::decode::decode;
use crate::file::schema::{
    BodyKey, BodyRow, EndRow, Kind, LinkRow, MassRow, MaterialRow, PinRow, SceneFile, TouchRow,
    WindRow, WorldRow, find,
};
use crate::file::sets::NamedSets;
use crate::file::sets::own::{Groups, OwnSets, groups};
use crate::file::sets::pins::masses as added;
use crate::file::substance::first_key;
use crate::file::tree::Source;
use crate::mesh::{Mesh, MeshError, MeshOptions, edge_ends, is_solid, own_spacing, subdivided};
use glam::DVec3;
use msd_core::{Body, Guide, Lattice, Lead, Material, Neighbours, Pin, Scene, Spring};
use std::collections::BTreeMap;

/// A scene file at a part of its spacing.
pub(crate) struct Refined {
    pub(crate) rows: SceneFile,
    pub(crate) understood: Understood,
    /// Pairs of particles that stand at one place, before and after.
    pub(crate) common: Vec<[usize; 2]>,
}

/// The structure by which the particles of a body are found in a finer one.
enum Nesting {
    /// A lattice of so many rows, columns and stacks.
    Lattice([u64; 3]),
    /// A mesh, by the vertices of its surface; whether it is filled.
    Surface(Box<Mesh>, bool),
}

impl Nesting {
    /// Directions in which the body extends.
    fn dimensions(&self) -> u32 {
        match self {
            Nesting::Lattice(size) => size.iter().filter(|&&length| 1 < length).count() as u32,
            Nesting::Surface(_, is_filled) => 2 + u32::from(*is_filled),
        }
    }
}

/// The most halvings of a spacing: further on no body fits a memory.
const MOST_HALVINGS: u32 = 8;
/// The most triangles that a surface is cut into.
const MOST_TRIANGLES: u128 = 1 << 22;

/// Halves the spacing of every body of a source so many times; `coarse` is the unrefined scene.
///
/// # Errors
/// A body of particles and springs one by one; a pin, a mass or a link inside a mesh; a material of
/// a set that is not a space; drag or a force on each particle of bodies of different dimensions;
/// more than fits.
pub(crate) fn refine(
    source: &Source<'_>,
    coarse: &Scene,
    halvings: u32,
    read_mesh: &MeshReader<'_>,
) -> Result<Refined, FileError> {
    if MOST_HALVINGS < halvings {
        let reason = format!("cannot be halved {halvings} times, at most {MOST_HALVINGS}");
        return Err(source.refuse(format_args!("the spacing"), reason));
    }
    let file: SceneFile = decode(source)?;
    let rows = file.bodies.iter().enumerate();
    let nestings = rows.map(|(row, body)| nesting(source, (row, body), (halvings, read_mesh)));
    let nestings = nestings.collect::<Result<Vec<Nesting>, FileError>>()?;
    let parts = 1u64 << halvings;
    let bodies =
        file.bodies.iter().zip(&nestings).map(|(body, nesting)| finer(body, nesting, parts));
    let own_sets = own_sets(&nestings, coarse);
    let sets = NamedSets::new(source, &file.sets, (coarse, &own_sets))?;
    let rows = SceneFile {
        world: world(source, (&file.world, coarse), &nestings, parts)?,
        bodies: bodies.collect(),
        sets: if file.materials.is_empty() && coarse.guides.is_empty() {
            Vec::new()
        } else {
            file.sets.clone()
        },
        pins: pins(source, (&file.pins, coarse), &nestings, halvings)?,
        masses: masses(source, (&sets, &file.masses, coarse), &nestings, parts)?,
        materials: materials(source, (&sets, &file, coarse), &nestings, parts)?,
        links: links(source, coarse, &nestings, parts)?,
        ..file.clone()
    };
    let understood = understand_rows(source, rows.clone(), &|file| {
        Ok((0..halvings).fold(read_mesh(file)?, |mesh, _| subdivided(&mesh)))
    })?;
    let common = common((coarse, &understood.scene), &nestings, parts);
    Ok(Refined { rows, understood, common })
}

fn nesting(
    source: &Source<'_>,
    (row, body): (usize, &BodyRow),
    (halvings, read_mesh): (u32, &MeshReader<'_>),
) -> Result<Nesting, FileError> {
    let named = || body.name.as_deref().map_or(String::new(), |name| format!(" `{name}`"));
    match (body.kind, body.size.as_deref(), body.file.as_deref()) {
        (Kind::Rope, Some(&[count]), _) => Ok(Nesting::Lattice([1, count, 1])),
        (Kind::Cloth, Some(&[rows, columns]), _) => Ok(Nesting::Lattice([rows, columns, 1])),
        (Kind::Block, Some(&[rows, columns, stacks]), _) => {
            Ok(Nesting::Lattice([rows, columns, stacks]))
        }
        (Kind::Mesh, _, Some(file)) => {
            let mesh = read_mesh(file).map_err(FileError::from)?;
            let count = (mesh.triangles.len() as u128) << (2 * halvings);
            if MOST_TRIANGLES < count {
                let (what, limit) = ("the number of triangles, each cut up,", MOST_TRIANGLES);
                return Err(MeshError::TooLarge { file: mesh.name, what, count, limit }.into());
            }
            let is_filled = is_solid(&mesh, body.filling.unwrap_or_default());
            Ok(Nesting::Surface(Box::new(mesh), is_filled))
        }
        _ => {
            let reason = format!(
                "is a body{} of particles and springs one by one, which has no spacing to refine",
                named()
            );
            Err(source.refuse(format_args!("bodies[{row}]"), reason))
        }
    }
}

/// A body at a part of its spacing.
fn finer(body: &BodyRow, nesting: &Nesting, parts: u64) -> BodyRow {
    let scaled = |key: &str, value: f64| {
        value * factor(&format!("bodies.{key}"), parts, nesting.dimensions())
    };
    let mut fine = body.clone();
    fine.touch = body.touch.as_ref().map(|touch| TouchRow {
        thickness: touch.thickness.map(|value| scaled("touch.thickness", value)),
        radius: touch.radius.map(|value| scaled("touch.radius", value)),
        ..touch.clone()
    });
    let default = match nesting {
        Nesting::Lattice(_) => {
            let length = |&length: &u64| length.saturating_sub(1).saturating_mul(parts) + 1;
            fine.size = body.size.as_ref().map(|size| size.iter().map(length).collect());
            fine.spacing = Some(scaled("spacing", body.spacing.unwrap_or(1.0)));
            Material::default()
        }
        Nesting::Surface(mesh, is_filled) => {
            if *is_filled {
                let own = || own_spacing(mesh, body.length.unwrap_or(1.0));
                fine.spacing = Some(scaled("spacing", body.spacing.unwrap_or_else(own)));
            }
            let options = MeshOptions::for_mesh(mesh, body.filling.unwrap_or_default());
            let MeshOptions { mass, stiffness, damping, .. } = options;
            Material { mass, stiffness, damping }
        }
    };
    if first_key(body).is_none() {
        // That of a mesh is the mass of the whole.
        if matches!(nesting, Nesting::Lattice(_)) {
            fine.mass = Some(scaled("mass", body.mass.unwrap_or(default.mass)));
        }
        fine.stiffness = Some(scaled("stiffness", body.stiffness.unwrap_or(default.stiffness)));
        fine.damping = Some(scaled("damping", body.damping.unwrap_or(default.damping)));
    }
    fine
}

/// The factor of the value at a path in a body of so many dimensions whose spacing has so many
/// parts.
fn factor(path: &str, parts: u64, dimensions: u32) -> f64 {
    find(path).map_or(1.0, |key| key.scale.factor(parts, dimensions))
}

/// The world of finer bodies: forces on each particle are shared out among more.
fn world(
    source: &Source<'_>,
    (world, coarse): (&WorldRow, &Scene),
    nestings: &[Nesting],
    parts: u64,
) -> Result<WorldRow, FileError> {
    let key = match (coarse.world.drag != 0.0, coarse.world.force != DVec3::ZERO) {
        (true, _) => "drag",
        (_, true) => "force",
        _ => return Ok(world.clone()),
    };
    let dimensions = nestings.first().map_or(0, Nesting::dimensions);
    if nestings.iter().any(|nesting| nesting.dimensions() != dimensions) {
        let reason = "acts on each particle, whose number grows otherwise in a block than in a \
                      cloth or a rope: one scene with several of them cannot be refined";
        return Err(source.refuse(format_args!("world.{key}"), reason));
    }
    let factor = |path| factor(path, parts, dimensions);
    Ok(WorldRow {
        drag: world.drag.map(|drag| drag * factor("world.drag")),
        force: world.force.map(|force| force.map(|part| part * factor("world.force"))),
        wind: world.wind.map(|wind| WindRow {
            strength: wind.strength.map(|strength| strength * factor("world.wind.strength")),
            ..wind
        }),
        ..world.clone()
    })
}

/// The pins of the finer scene: the particles in the places of pins, and those between pins.
fn pins(
    source: &Source<'_>,
    (pins, coarse): (&[PinRow], &Scene),
    nestings: &[Nesting],
    halvings: u32,
) -> Result<Vec<PinRow>, FileError> {
    let is_guided =
        |row: &PinRow| row.key_frames.is_some() || row.follow.is_some() || row.until.is_some();
    let mut rows = Vec::new();
    for (row, pin) in pins.iter().enumerate().filter(|(_, row)| is_guided(row)) {
        if pin.set.is_none() {
            let reason = "has `key_frames`, `follow` or `until`: choose its particles by `set`, \
                          which a finer spacing has too";
            return Err(source.refuse(format_args!("pins[{row}]"), reason));
        }
        rows.push(pin.clone());
    }
    let guided = coarse.guided();
    let steady = |pin: &&Pin| !guided.contains(&pin.particle);
    for (number, (body, nesting)) in coarse.bodies.iter().zip(nestings).enumerate() {
        let pins = coarse.pins.iter().filter(steady);
        let of_body = pins.filter(|pin| body.particles.contains(&pin.particle));
        let held: BTreeMap<usize, DVec3> =
            of_body.map(|pin| (pin.particle - body.particles.start, pin.velocity)).collect();
        let row = |velocity: DVec3| PinRow {
            body: Some(BodyKey::Number(number as u64)),
            velocity: Some(velocity.to_array()).filter(|_| velocity != DVec3::ZERO),
            ..PinRow::default()
        };
        match nesting {
            Nesting::Lattice(size) => {
                let held = held_in_lattice(size.map(|length| length as usize), &held, halvings);
                rows.extend(
                    held.into_iter().map(|(at, pull)| PinRow { at: Some(at), ..row(pull) }),
                );
            }
            Nesting::Surface(mesh, _) => {
                let last = held.keys().next_back().map(|&last| (number, last));
                last.map_or(Ok(()), |last| check_outside(source, "pins", mesh, last))?;
                let held = held_in_surface(mesh, held, halvings);
                let pin = |(vertex, pull)| PinRow { particle: Some(vertex as i64), ..row(pull) };
                rows.extend(held.into_iter().map(pin));
            }
        }
    }
    Ok(rows)
}

/// Refuses a particle of a body that is inside a mesh.
fn check_outside(
    source: &Source<'_>,
    key: &str,
    mesh: &Mesh,
    (body, particle): (usize, usize),
) -> Result<(), FileError> {
    if particle < mesh.positions.len() {
        return Ok(());
    }
    let reason = format!(
        "hold particle {particle} of body {body}, which is inside the mesh: a finer lattice has \
         none at its place"
    );
    Err(source.refuse(format_args!("{key}"), reason))
}

/// The particle of the finer scene that stands where one of the scene stood.
fn end(
    source: &Source<'_>,
    (key, particle): (&str, usize),
    coarse: &Scene,
    (nestings, parts): (&[Nesting], u64),
) -> Result<EndRow, FileError> {
    let body = coarse.bodies.partition_point(|body| body.particles.end <= particle);
    if body == coarse.bodies.len() {
        let holds = |guide: &&Guide| guide.held.iter().any(|(held, _)| *held == particle);
        let solid = match coarse.guides.iter().find(holds).map(|guide| &guide.lead) {
            Some(&Lead::Solid(solid)) => Some(BodyKey::Number(solid as u64)),
            _ => None,
        };
        return Ok(EndRow { solid, ..EndRow::default() });
    }
    let number = particle - coarse.bodies[body].particles.start;
    let row = EndRow { body: Some(BodyKey::Number(body as u64)), ..EndRow::default() };
    match &nestings[body] {
        Nesting::Lattice(size) => {
            let [_, columns, stacks] = size.map(|length| length as usize);
            let at = [number / stacks / columns, number / stacks % columns, number % stacks];
            Ok(EndRow { at: Some(at.map(|step| step as u64 * parts)), ..row })
        }
        Nesting::Surface(mesh, _) => {
            check_outside(source, key, mesh, (body, number))?;
            Ok(EndRow { particle: Some(number as i64), ..row })
        }
    }
}

/// Where the own sets of each body come from.
fn own_sets(nestings: &[Nesting], coarse: &Scene) -> Vec<OwnSets> {
    let own = |(nesting, body): (&Nesting, &Body)| match nesting {
        Nesting::Lattice(size) => {
            let lattice = Lattice::new(size.map(|length| length as usize), Neighbours::All);
            lattice.map_or_else(|_| OwnSets::Groups(Groups::new()), OwnSets::Lattice)
        }
        Nesting::Surface(mesh, _) => {
            OwnSets::Groups(groups(mesh, &body.surface, body.particles.start))
        }
    };
    nestings.iter().zip(&coarse.bodies).map(own).collect()
}

/// The masses of the finer scene: each stays where it was.
fn masses(
    source: &Source<'_>,
    (sets, rows, coarse): (&NamedSets<'_>, &[MassRow], &Scene),
    nestings: &[Nesting],
    parts: u64,
) -> Result<Vec<MassRow>, FileError> {
    let loads = added(sets, rows)?;
    let row = |(particle, mass)| {
        let end = end(source, ("masses", particle), coarse, (nestings, parts))?;
        let EndRow { body, particle, at, set, .. } = end;
        Ok(MassRow { body, particle, at, set, mass })
    };
    loads.into_iter().map(row).collect()
}

/// The materials of the finer scene: of the same sets, which are spaces.
fn materials(
    source: &Source<'_>,
    (sets, file, coarse): (&NamedSets<'_>, &SceneFile, &Scene),
    nestings: &[Nesting],
    parts: u64,
) -> Result<Vec<MaterialRow>, FileError> {
    let fine = |(number, row): (usize, &MaterialRow)| {
        let key = format!("materials[{number}]");
        let is_space = row.set == "all" || file.sets.iter().any(|set| set.name == row.set);
        if !is_space && !sets.is_group(&row.set) {
            let reason = format!(
                "is `{}`: the particles of a finer body along it are not those of the same part; \
                 give a box or a sphere of [[sets]]",
                row.set
            );
            return Err(source.refuse(format_args!("{key}.set"), reason));
        }
        let first = sets.particles(&key, row)?[0];
        let body = coarse.bodies.partition_point(|body| body.particles.end <= first);
        let factor = |path| factor(path, parts, nestings[body].dimensions());
        Ok(MaterialRow {
            stiffness: row.stiffness.map(|stiffness| stiffness * factor("materials.stiffness")),
            damping: row.damping.map(|damping| damping * factor("materials.damping")),
            ..row.clone()
        })
    };
    file.materials.iter().enumerate().map(fine).collect()
}

/// The links of the finer scene: each joins the particles in the places of its ends.
fn links(
    source: &Source<'_>,
    coarse: &Scene,
    nestings: &[Nesting],
    parts: u64,
) -> Result<Vec<LinkRow>, FileError> {
    let own = coarse.bodies.last().map_or(0, |body| body.springs.end);
    let row = |spring: &Spring| {
        let end = |end| self::end(source, ("links", end), coarse, (nestings, parts));
        Ok(LinkRow {
            from: end(spring.ends[0])?,
            to: end(spring.ends[1])?,
            within: None,
            rest_length: Some(spring.rest_length),
            rest_scale: None,
            stiffness: Some(spring.stiffness),
            damping: Some(spring.damping),
        })
    };
    coarse.springs[own..].iter().map(row).collect()
}

/// Row, column, stack and velocity of the pins of a finer lattice: a particle between others is
/// pinned where all of those are, and moves between them.
fn held_in_lattice(
    size: [usize; 3],
    held: &BTreeMap<usize, DVec3>,
    halvings: u32,
) -> Vec<([u64; 3], DVec3)> {
    let [_, columns, stacks] = size;
    let parts = 1usize << halvings;
    let [up, across, deep] = size.map(|length| if 1 < length { parts } else { 1 });
    let mut found = Vec::new();
    for &number in held.keys() {
        let low = [number / stacks / columns, number / stacks % columns, number % stacks];
        for index in 0..up * across * deep {
            let inside = [index / deep / across, index / deep % across, index % deep];
            // The corners of the least cell around it, each by its weight; one that is off the
            // lattice is not held either.
            let mut velocity = Some(DVec3::ZERO);
            for corner in 0..8usize {
                let up = [corner / 4, corner / 2 % 2, corner % 2];
                let weight = |axis: usize| {
                    let part = inside[axis] as f64 / parts as f64;
                    if up[axis] == 1 { part } else { 1.0 - part }
                };
                let weight = weight(0) * weight(1) * weight(2);
                if weight == 0.0 {
                    continue;
                }
                let [row, column, stack] = [0, 1, 2].map(|axis| low[axis] + up[axis]);
                let is_on = column < columns && stack < stacks;
                let at = (row * columns + column) * stacks + stack;
                let pull = held.get(&at).filter(|_| is_on);
                velocity = velocity.zip(pull).map(|(sum, &pull)| sum + weight * pull);
            }
            let at = [0, 1, 2].map(|axis| (low[axis] * parts + inside[axis]) as u64);
            found.extend(velocity.map(|velocity| (at, velocity)));
        }
    }
    found
}

/// The pinned vertices of a finer mesh and their velocities: the middle of an edge is pinned where
/// both ends are.
fn held_in_surface(
    mesh: &Mesh,
    mut held: BTreeMap<usize, DVec3>,
    halvings: u32,
) -> BTreeMap<usize, DVec3> {
    if held.is_empty() {
        return held;
    }
    let mut mesh = mesh.clone();
    for _ in 0..halvings {
        for (edge, ends) in edge_ends(&mesh).into_iter().enumerate() {
            let [a, b] = ends.map(|end| held.get(&(end as usize)).copied());
            if let (Some(a), Some(b)) = (a, b) {
                held.insert(mesh.positions.len() + edge, 0.5 * (a + b));
            }
        }
        mesh = subdivided(&mesh);
    }
    held
}

/// Pairs of particles that stand at one place: all of a lattice, the surface of a mesh.
fn common((coarse, fine): (&Scene, &Scene), nestings: &[Nesting], parts: u64) -> Vec<[usize; 2]> {
    let parts = parts as usize;
    let bodies = coarse.bodies.iter().zip(&fine.bodies).zip(nestings);
    let of_body = bodies.flat_map(|((coarse, fine), nesting)| {
        let (first, fine) = (coarse.particles.start, fine.particles.start);
        let numbers: Vec<usize> = match nesting {
            Nesting::Lattice(size) => {
                let [rows, columns, stacks] = size.map(|length| length as usize);
                let [across, deep] = [columns, stacks].map(|length| (length - 1) * parts + 1);
                let each = (0..rows * columns * stacks).map(|number| {
                    let at =
                        [number / stacks / columns, number / stacks % columns, number % stacks];
                    let [row, column, stack] = at.map(|step| step * parts);
                    (row * across + column) * deep + stack
                });
                each.collect()
            }
            Nesting::Surface(mesh, _) => (0..mesh.positions.len()).collect(),
        };
        numbers.into_iter().enumerate().map(move |(number, at)| [first + number, fine + at])
    });
    of_body.collect()
}
