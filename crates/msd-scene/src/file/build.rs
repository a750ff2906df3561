//! A scene from a scene file, row by row, each number checked against its domain.

use crate::error::{FileError, plain};
use crate::file::bodies::{Builder, MeshReader};
use crate::file::budget::Budget;
use crate::file::check::domain_of;
use crate::file::decode::decode;
use crate::file::keys::Domain;
use crate::file::look::{look, viewpoint};
use crate::file::obstacles::{Solids, plane};
use crate::file::schema::elsewhere::elsewhere;
use crate::file::schema::{
    AirRow, GustRow, LessonRow, OrAuto, SceneFile, SolverRow, WindRow, WorldRow,
};
use crate::file::sets::NamedSets;
use crate::file::sets::links::{Links, links};
use crate::file::sets::materials::set_materials;
use crate::file::sets::own::OwnSets;
use crate::file::sets::pins::{Pins, load, masses, pins};
use crate::file::substance::overburdened;
use crate::file::touch::{pierced, started_in_each_other, started_inside, touch};
use crate::file::tree::{Source, Value};
use crate::materials::Made;
use crate::model::Wind;
use crate::precision::Precision;
use crate::rounding::Rounding;
use crate::shown::tame;
use crate::viewpoint::Viewpoint;
use msd_core::glam::DVec3;
use msd_core::{Air, Gust, Integrator, Lead, Scene, Settings, World};
use std::ops::Range;

/// A scene file that has been understood.
pub(crate) struct Understood {
    pub(crate) title: Option<String>,
    pub(crate) scene: Scene,
    pub(crate) settings: Settings,
    pub(crate) automatic: bool,
    pub(crate) precision: Precision,
    pub(crate) camera: Viewpoint,
    pub(crate) notes: Vec<String>,
    pub(crate) made: Vec<Option<Made>>,
    pub(crate) rest_scales: Vec<(Range<usize>, f64)>,
    pub(crate) held: Vec<(String, Vec<usize>)>,
    pub(crate) wind: Option<(Wind, DVec3)>,
    pub(crate) lesson: Option<Box<LessonRow>>,
}

/// Understands a source.
///
/// # Errors
/// The first thing that is wrong, by key.
pub(crate) fn understand(
    source: &Source<'_>,
    read_mesh: &MeshReader<'_>,
) -> Result<Understood, FileError> {
    understand_rows(source, decode(source).map_err(elsewhere)?, read_mesh)
}

/// Understands rows; errors name the place in their source.
///
/// # Errors
/// The first thing that is wrong, by key.
pub(crate) fn understand_rows(
    source: &Source<'_>,
    file: SceneFile,
    read_mesh: &MeshReader<'_>,
) -> Result<Understood, FileError> {
    source.count(format_args!("version"), file.version.into())?;
    let precision = file.solver.precision.unwrap_or_default();
    // Its numbers fit this one at least.
    source.precision.set(precision);
    let substeps = substeps(source, &file.solver)?;
    let settings = settings(source, &file.solver, substeps)?;
    let mut world = world(source, &file.world)?;
    let wind = wind(source, file.world.wind, &mut world)?;
    let camera = viewpoint(source, file.camera.unwrap_or_default(), world.extent)?;
    let mut scene = Scene { world, ..Scene::default() };
    for (row, plane) in file.world.planes.iter().enumerate() {
        scene.planes.push(self::plane(source, (row, plane))?);
    }
    let mut notes = Vec::new();
    let mut solids = Solids { source, read_mesh, extent: world.extent, points: 0 };
    for (row, solid) in file.world.solids.iter().enumerate() {
        scene.solids.push(solids.build((row, solid), &mut notes)?);
    }
    if file.bodies.is_empty() {
        let reason = "is empty; a scene needs at least one body".to_string();
        return Err(source.refuse(format_args!("bodies"), reason));
    }
    let budget = Budget::default();
    let mut builder = Builder { source, read_mesh, extent: world.extent, precision, budget, notes };
    let (mut own_sets, mut made) = (Vec::new(), Vec::new());
    for (row, body) in file.bodies.iter().enumerate() {
        let built = builder.build(row, body)?;
        own_sets.push(built.own_sets);
        made.push(built.made);
        let name = body.name.clone().unwrap_or_else(|| body.kind.name().into());
        let look = look(source, (row, body), built.part.surface.two_sided)?;
        let number = scene.add(name, built.part);
        scene.bodies[number].look = look;
    }
    let Builder { mut notes, mut budget, .. } = builder;
    set_materials(source, (&file, &made), (&mut scene, &own_sets))?;
    touch(source, &file.bodies, &mut scene, &mut notes)?;
    notes.extend(pierced(&scene));
    let joined = join(source, &file, (&mut scene, &own_sets), (&mut budget, &mut notes))?;
    if let Some(height) = source.drop {
        raise(&mut scene, height);
    }
    file.off.iter().for_each(|part| part.switch_off(&mut scene));
    notes.extend(overburdened(&scene, &made));
    notes.extend(started_inside(source, &scene)?);
    notes.extend(started_in_each_other(&scene));
    let precision = file.solver.precision.unwrap_or_else(|| fitting(&scene, &mut notes));
    Ok(Understood {
        title: file.title,
        scene,
        settings,
        automatic: substeps == OrAuto::Auto,
        precision,
        camera,
        // They quote names of bodies and files.
        notes: notes.iter().map(|note| tame(note)).collect(),
        made,
        rest_scales: joined.rest_scales,
        held: joined.held,
        wind,
        lesson: lesson(source, file.lesson)?,
    })
}

/// The results of the rows that choose particles.
struct Joined {
    /// See [`crate::Loaded::rest_scales`].
    rest_scales: Vec<(Range<usize>, f64)>,
    /// See [`crate::Loaded::held`].
    held: Vec<(String, Vec<usize>)>,
}

/// Pins, masses and links of chosen particles.
fn join(
    source: &Source<'_>,
    file: &SceneFile,
    (scene, own_sets): (&mut Scene, &[OwnSets]),
    (budget, notes): (&mut Budget, &mut Vec<String>),
) -> Result<Joined, FileError> {
    let sets = NamedSets::new(source, &file.sets, (scene, own_sets))?;
    let Pins { pins, guides, held } = pins(&sets, (&file.pins, &file.world.solids))?;
    let loads = masses(&sets, &file.masses)?;
    let Links { springs, scales, anchors } =
        links(&sets, (&file.links, &file.world.solids), budget)?;
    notes.extend(sets.numbered(file));
    (scene.pins, scene.guides) = (pins, guides);
    let rest_scales = rest_scales(scene, file, scales);
    scene.springs.extend(springs);
    anchors.add_to(scene);
    load(source, scene, (&file.bodies, &loads))?;
    Ok(Joined { rest_scales, held })
}

/// The springs of each body and of each row of links, which follow those of a scene, with the
/// factors of their rest lengths.
fn rest_scales(
    scene: &Scene,
    file: &SceneFile,
    links: Vec<(Range<usize>, f64)>,
) -> Vec<(Range<usize>, f64)> {
    let own = scene.springs.len();
    let bodies = scene.bodies.iter().zip(&file.bodies);
    let bodies = bodies.map(|(body, row)| (body.springs.clone(), row.rest_scale.unwrap_or(1.0)));
    let moved = |(rows, scale): (Range<usize>, f64)| (own + rows.start..own + rows.end, scale);
    bodies.chain(links.into_iter().map(moved)).collect()
}

/// Moves all particles up or down so that the lowest is at a height, metres.
fn raise(scene: &mut Scene, height: f64) {
    let particles = &mut scene.particles;
    let lowest = particles.iter().map(|particle| particle.position.y).fold(f64::MAX, f64::min);
    let up = DVec3::Y * (height - lowest);
    particles.iter_mut().for_each(|particle| particle.position += up);
    for guide in &mut scene.guides {
        match &mut guide.lead {
            Lead::Path { position, keys, .. } => {
                *position += up;
                keys.iter_mut().for_each(|key| key.position += up);
            }
            Lead::Solid(solid) => {
                let back = scene.solids[*solid].axes.transpose() * up;
                guide.held.iter_mut().for_each(|(_, place)| *place += back);
            }
        }
    }
}

/// The precision of a scene that asks for none: single, unless that loses too much where it is.
fn fitting(scene: &Scene, notes: &mut Vec<String>) -> Precision {
    let loss = Rounding::of(scene, Precision::F32);
    if !loss.shows() {
        return Precision::F32;
    }
    let Rounding { distance, spacing, .. } = loss;
    notes.push(format!(
        "the scene gives no precision: f64, as {distance:.0} m from the origin f32 rounds \
         positions to {spacing:.1e} m"
    ));
    Precision::F64
}

/// The number of substeps, or automatic.
fn substeps(source: &Source<'_>, solver: &SolverRow) -> Result<OrAuto<u64>, FileError> {
    let step = source.walk("solver.step").last().flatten().map(|node| &node.value);
    match (step, solver.substeps) {
        (Some(Value::Text(_)), Some(OrAuto::Given(_))) => {
            let reason = "= \"auto\" and a number of solver.substeps exclude each other";
            Err(source.refuse(format_args!("solver.step"), reason))
        }
        (_, substeps) => Ok(substeps.unwrap_or(OrAuto::Auto)),
    }
}

/// The settings; automatic substeps are chosen where the scene becomes a run.
fn settings(
    source: &Source<'_>,
    solver: &SolverRow,
    substeps: OrAuto<u64>,
) -> Result<Settings, FileError> {
    let step = match (solver.step, solver.steps_per_second) {
        (OrAuto::Given(_), Some(_)) => {
            let reason = "and solver.steps_per_second exclude each other";
            return Err(source.refuse(format_args!("solver.step"), reason));
        }
        (OrAuto::Given(step), None) => source.number(format_args!("solver.step"), step)?,
        (OrAuto::Auto, rate) => {
            let rate = rate.unwrap_or(60.0);
            1.0 / source.number(format_args!("solver.steps_per_second"), rate)?
        }
    };
    let default = Settings::default();
    let substeps = match substeps {
        OrAuto::Auto => default.substeps,
        OrAuto::Given(substeps) => count(source, "solver.substeps", substeps)?,
    };
    let newton = solver.newton.unwrap_or(default.newton.into());
    let newton = count(source, "solver.newton", newton)?;
    let substep = step / f64::from(substeps);
    if !Domain::Step.holds(substep, source.precision.get()) {
        let (key, value) = match solver.steps_per_second {
            Some(rate) => ("solver.steps_per_second", rate),
            None => ("solver.step", step),
        };
        let expected = domain_of(key).words();
        return Err(source.out_of_domain(format_args!("{key}"), plain(value), expected));
    }
    let tolerance = solver.tolerance.unwrap_or(default.tolerance);
    source.number(format_args!("solver.tolerance"), tolerance)?;
    let integrator: Integrator = solver.integrator.unwrap_or_default();
    Ok(Settings { integrator, step, substeps, tolerance, newton })
}

/// A whole number of at least 1.
fn count(source: &Source<'_>, key: &str, value: u64) -> Result<u32, FileError> {
    // Its domain ends where a count does.
    Ok(u32::try_from(source.count(format_args!("{key}"), value)?).unwrap_or(u32::MAX))
}

fn world(source: &Source<'_>, row: &WorldRow) -> Result<World, FileError> {
    let default = World::default();
    let gravity = row.gravity.unwrap_or(default.gravity.to_array());
    let force = row.force.unwrap_or(default.force.to_array());
    let extent = row.extent.unwrap_or(default.extent);
    source.number(format_args!("world.extent"), extent)?;
    Ok(World {
        gravity: source.vector(format_args!("world.gravity"), gravity)?,
        force: source.vector(format_args!("world.force"), force)?,
        drag: source.number(format_args!("world.drag"), row.drag.unwrap_or(default.drag))?,
        air: row.air.as_ref().map(|row| air(source, row)).transpose()?,
        extent,
    })
}

/// The wind and the uniform force without it, to which its mean is added.
fn wind(
    source: &Source<'_>,
    row: Option<WindRow>,
    world: &mut World,
) -> Result<Option<(Wind, DVec3)>, FileError> {
    let Some(row) = row else { return Ok(None) };
    let number = |key: &str, value: Option<f64>| {
        source.number(format_args!("world.wind.{key}"), value.unwrap_or(0.0))
    };
    number("strength", row.strength)?;
    number("heading_deg", row.heading_deg)?;
    number("gusts", row.gusts)?;
    let (wind, calm) = (Wind::from(row), world.force);
    world.force += wind.mean().force(0.0);
    Ok((wind != Wind::default()).then_some((wind, calm)))
}

fn air(source: &Source<'_>, row: &AirRow) -> Result<Air, FileError> {
    let default = Air::default();
    let velocity = row.velocity.unwrap_or(default.velocity.to_array());
    let density = row.density.unwrap_or(default.density);
    let drag = row.drag.unwrap_or(default.drag);
    let drag = source.number(format_args!("world.air.drag"), drag)?;
    let lift = row.lift.unwrap_or(Air::LIFT_OF_DRAG * drag);
    let lift = source.number(format_args!("world.air.lift"), lift)?;
    if drag < lift {
        let expected = format!("at most world.air.drag, {}", plain(drag));
        return Err(source.out_of_domain(format_args!("world.air.lift"), plain(lift), expected));
    }
    Ok(Air {
        density: source.number(format_args!("world.air.density"), density)?,
        velocity: source.vector(format_args!("world.air.velocity"), velocity)?,
        drag,
        lift,
        gust: row.gust.as_ref().map_or(Ok(default.gust), |row| gust(source, row))?,
    })
}

/// Gusts; those of a scene that has a table of them are not still by default.
fn gust(source: &Source<'_>, row: &GustRow) -> Result<Gust, FileError> {
    let default = Gust { strength: 1.0, ..Gust::default() };
    let number = |key: &str, value: f64| source.number(format_args!("world.air.gust.{key}"), value);
    Ok(Gust {
        strength: number("strength", row.strength.unwrap_or(default.strength))?,
        length: number("length", row.length.unwrap_or(default.length))?,
        time: number("time", row.time.unwrap_or(default.time))?,
        seed: row.seed.unwrap_or(default.seed),
        origin: default.origin,
    })
}

/// Checks the numbers of a lesson.
fn lesson(
    source: &Source<'_>,
    row: Option<LessonRow>,
) -> Result<Option<Box<LessonRow>>, FileError> {
    let Some(row) = row else { return Ok(None) };
    source.number(format_args!("lesson.tolerance"), row.tolerance)?;
    source.number(format_args!("lesson.time"), row.time.unwrap_or(1.0))?;
    for (number, row) in row.mistakes.iter().enumerate() {
        for (name, value) in [("times", row.times), ("power", row.power), ("plus", row.plus)] {
            let key = format_args!("lesson.mistakes[{number}].{name}");
            source.number(key, value.unwrap_or(1.0))?;
        }
    }
    Ok(Some(Box::new(row)))
}
