//! The text of a scene with the values that the user has set; what else its author wrote stays.

use crate::session::{PairValues, Solver, pairs_of};
use msd_core::{Body, Friction, Integrator, Look, Model, Real, Shell, Vector};
use msd_run::{Runner, on};
use msd_scene::Loaded;
use msd_scene::materials::Made;
use msd_scene::schema::Finish;
use msd_study::tune::put;
use std::ops::Range;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// What a scene file says of a run: solver, world, and the material of each body where it is one
/// value for all of the body.
#[derive(Clone, Debug, PartialEq)]
struct Values {
    gravity: [f64; 3],
    force: [f64; 3],
    drag: f64,
    planes: Vec<(f64, Friction)>,
    bodies: Vec<[Option<f64>; 3]>,
    /// Stiffness and damping of the springs of no body.
    links: [Option<f64>; 2],
    /// How bodies meet.
    shells: Vec<Shell>,
    looks: Vec<Look>,
}

/// The keys of a body, in the order of its values; those of links are the last two.
const BODY_KEYS: [&str; 3] = ["mass", "stiffness", "damping"];

impl Values {
    fn of(runner: &Runner) -> Self {
        on!(runner, simulation => Values::read(simulation.model()))
    }

    /// Without those of bodies that are made of a material.
    fn but_of(mut self, made: &[Option<Made>]) -> Self {
        let made = self.bodies.iter_mut().zip(made).filter(|(_, made)| made.is_some());
        made.for_each(|(values, _)| *values = [None; 3]);
        self
    }

    fn read<R: Real>(model: &Model<R>) -> Self {
        let springs = |rows: Range<usize>| {
            let there = || rows.clone().filter(|&spring| !model.is_cut(spring));
            let stiffness = uniform(there().map(|spring| model.stiffness(spring).to_f64()));
            [stiffness, uniform(there().map(|spring| model.damping(spring).to_f64()))]
        };
        let body = |body: &Body| {
            let [stiffness, damping] = springs(body.springs.clone());
            let masses = body.particles.clone().map(|row| model.masses()[row].to_f64());
            [uniform(masses), stiffness, damping]
        };
        let own = model.bodies().last().map_or(0, |body| body.springs.end);
        let planes = model.planes().iter();
        Values {
            gravity: model.gravity().to_f64().to_array(),
            force: model.force().to_f64().to_array(),
            drag: model.drag().to_f64(),
            planes: planes.map(|plane| (plane.restitution(), plane.friction())).collect(),
            bodies: model.bodies().iter().map(body).collect(),
            links: springs(own..model.spring_count()),
            shells: model.shells().to_vec(),
            looks: model.bodies().iter().map(|body| body.look).collect(),
        }
    }

    /// How a body meets others.
    fn shell(&self, body: &Body) -> Option<&Shell> {
        self.shells.iter().find(|shell| shell.is_of(body))
    }
}

/// The value that all have.
fn uniform(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// Rewrites the text of a scene, TOML, so that it says what a run of it was set to.
///
/// # Errors
/// Text that is no TOML; a value that no key of the text stands for.
pub(super) fn with_values(
    text: &str,
    loaded: &Loaded,
    (runner, made): (&Runner, &[Option<Made>]),
) -> Result<String, String> {
    let mut file: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    write_solver(table(&mut file, "solver")?, loaded, runner);
    let author = Runner::open(loaded).map_err(|error| error.to_string())?;
    let (was, now) = (Values::of(&author), Values::of(runner));
    let world = table(&mut file, "world")?;
    for (key, was, now) in [("gravity", was.gravity, now.gravity), ("force", was.force, now.force)]
    {
        if was != now {
            put(world, key, Array::from_iter(now.map(shortest)).into());
        }
    }
    if was.drag != now.drag {
        put(world, "drag", shortest(now.drag).into());
    }
    if now.planes.is_empty() {
        world.remove("planes");
    }
    let mut planes = rows(world.get_mut("planes"));
    for (row, (was, now)) in was.planes.iter().zip(&now.planes).enumerate() {
        if was != now {
            let plane = planes.get_mut(row).ok_or("its planes are not written one by one")?;
            write_plane(&mut **plane, *now);
        }
    }
    let mut bodies = rows(file.get_mut("bodies"));
    write_touches(&mut bodies, [&was, &now], loaded)?;
    for (row, (was, now)) in was.looks.iter().zip(&now.looks).enumerate() {
        if was != now {
            let body = bodies.get_mut(row).ok_or("its bodies are not written one by one")?;
            write_look(&mut **body, now)?;
        }
    }
    for (row, (was, now)) in was.bodies.iter().zip(&now.bodies).enumerate() {
        let of_material = loaded.made.get(row).copied().flatten();
        if let (Some(was), Some(now)) = (of_material, made.get(row).copied().flatten()) {
            if was != now {
                let body = bodies.get_mut(row).ok_or("its bodies are not written one by one")?;
                write_material(&mut **body, [was, now]);
            }
            continue;
        }
        for (key, (was, now)) in BODY_KEYS.into_iter().zip(was.iter().zip(now)) {
            if was != now {
                let now = now.ok_or("a body has springs or particles that differ")?;
                let body = bodies.get_mut(row).ok_or("its bodies are not written one by one")?;
                put(&mut **body, key, shortest(now).into());
            }
        }
    }
    for (key, (was, now)) in BODY_KEYS[1..].iter().zip(was.links.iter().zip(now.links)) {
        if *was != now {
            let now = now.ok_or("its links have springs that differ")?;
            let links = rows(file.get_mut("links")).into_iter();
            links.for_each(|link| put(link, key, shortest(now).into()));
        }
    }
    Ok(file.to_string())
}

/// Writes what a body is made of now, where that differs.
fn write_material(body: &mut dyn TableLike, [was, now]: [Made; 2]) {
    if let Some(name) = now.material {
        // Its numbers are those of the name.
        for key in ["young", "density", "relaxation_time", "damping_ratio"] {
            body.remove(key);
        }
        put(body, "material", name.into());
    }
    let is_named = now.material.is_some() && was.material != now.material;
    let own = |value: Option<f64>| value.filter(|_| !is_named);
    let density = if now.young.is_some() { "density" } else { "area_density" };
    for (key, was, now) in [
        ("young", was.young, own(now.young)),
        (density, Some(was.density), own(Some(now.density))),
        ("relaxation_time", Some(was.relaxation_time), own(Some(now.relaxation_time))),
        ("thickness", was.thickness, now.thickness),
    ] {
        if let Some(now) = now.filter(|now| was != Some(*now)) {
            match key {
                "density" => _ = body.remove("area_density"),
                "area_density" => _ = body.remove("density"),
                "relaxation_time" => _ = body.remove("damping_ratio"),
                _ => {}
            }
            put(body, key, shortest(now).into());
        }
    }
}

/// Writes how bodies meet now, where that differs.
fn write_touches(
    bodies: &mut [&mut dyn TableLike],
    [was, now]: [&Values; 2],
    loaded: &Loaded,
) -> Result<(), String> {
    for (row, body) in loaded.scene.bodies.iter().enumerate() {
        let shells = [was, now].map(|values| values.shell(body));
        if shells[0] != shells[1] {
            let body = bodies.get_mut(row).ok_or("its bodies are not written one by one")?;
            write_touch(&mut **body, shells)?;
        }
    }
    let all = &loaded.scene.bodies;
    let [was, now] = [was, now].map(|values| pairs_of(&values.shells, all));
    for (pair, values) in now {
        if was.get(&pair) != Some(&values) {
            write_pair(bodies, (pair, values), all)?;
        }
    }
    Ok(())
}

/// Writes how two bodies meet: where one of them names the other, or else in the later one.
fn write_pair(
    bodies: &mut [&mut dyn TableLike],
    ([first, last], values): ([usize; 2], PairValues),
    all: &[Body],
) -> Result<(), String> {
    for [own, other] in [[first, last], [last, first]] {
        let touch = bodies.get_mut(own).and_then(|body| body.get_mut("touch"));
        let touch = touch.and_then(Item::as_table_like_mut);
        let entries = rows(touch.and_then(|touch| touch.get_mut("with")));
        let names = |entry: &&mut dyn TableLike| {
            entry.get("body").and_then(Item::as_str) == Some(all[other].name.as_str())
        };
        if let Some(entry) = entries.into_iter().find(names) {
            put_pair(entry, values);
            return Ok(());
        }
    }
    let name = &all[first].name;
    if 1 < all.iter().filter(|body| body.name == *name).count() {
        return Err(format!("two bodies are named \"{name}\": give each a `name` of its own"));
    }
    let body = bodies.get_mut(last).ok_or("its bodies are not written one by one")?;
    let touch = body.get_mut("touch").and_then(Item::as_table_like_mut);
    let touch = touch.ok_or("its touch is not a table")?;
    let empty = || toml_edit::value(Array::new());
    match touch.entry("with").or_insert_with(empty) {
        Item::ArrayOfTables(tables) => {
            let mut entry = Table::new();
            put(&mut entry, "body", name.into());
            put_pair(&mut entry, values);
            tables.push(entry);
        }
        with => {
            let mut entry = InlineTable::new();
            put(&mut entry, "body", name.into());
            put_pair(&mut entry, values);
            with.as_array_mut().ok_or("its with is not a list")?.push(entry);
        }
    }
    Ok(())
}

fn put_pair(entry: &mut dyn TableLike, PairValues { friction, restitution }: PairValues) {
    for (key, value) in [("friction", friction), ("restitution", restitution)] {
        if let Some(value) = value {
            put(entry, key, shortest(value).into());
        }
    }
}

/// Writes how a body meets others now.
fn write_touch(body: &mut dyn TableLike, [was, now]: [Option<&Shell>; 2]) -> Result<(), String> {
    let Some(now) = now else {
        body.remove("touch");
        return Ok(());
    };
    let empty = || toml_edit::value(toml_edit::InlineTable::new());
    let touch = body.entry("touch").or_insert_with(empty);
    let touch = touch.as_table_like_mut().ok_or("its touch is not a table")?;
    let number = |key, of: fn(&Shell) -> f64| (key, was.map(of), of(now));
    for (key, was, now) in [
        number("thickness", |shell| shell.thickness),
        number("friction", |shell| shell.friction),
        number("restitution", |shell| shell.restitution),
    ] {
        if was != Some(now) {
            put(touch, key, shortest(now).into());
        }
    }
    // The older key of the thickness.
    touch.remove("radius");
    Ok(())
}

/// Writes how a body looks now: a finish, and what differs from it.
fn write_look(body: &mut dyn TableLike, now: &Look) -> Result<(), String> {
    let empty = || toml_edit::value(toml_edit::InlineTable::new());
    let look = body.entry("look").or_insert_with(empty);
    let look = look.as_table_like_mut().ok_or("its look is not a table")?;
    let finish = Finish::of(now);
    let usual = finish.look();
    let own = |is_own: bool, value: Value| is_own.then_some(value);
    let number = |now: f32, usual: f32| own(now != usual, shortest(f64::from(now)).into());
    let colour = |colour: Option<[f32; 3]>| colour.map(|colour| hex(colour).into());
    for (key, value) in [
        ("finish", Some(finish.name().into())),
        ("colour", colour(now.colour.filter(|_| now.colour != usual.colour))),
        ("back", colour(now.back)),
        ("roughness", number(now.roughness, usual.roughness)),
        ("translucency", number(now.translucency, usual.translucency)),
        ("pattern", own(now.pattern != usual.pattern, now.pattern.name().into())),
        ("pattern_size", number(now.pattern_size, 0.0)),
    ] {
        match value {
            Some(value) => put(look, key, value),
            None => _ = look.remove(key),
        }
    }
    Ok(())
}

/// A colour as a scene file has it.
fn hex(colour: [f32; 3]) -> String {
    let [red, green, blue] = colour.map(|part| (part * 255.0).round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Whether a scene, as it was read from the new text, has the values of a run, whose bodies are
/// made of `made` now.
pub(super) fn says(written: &Loaded, runner: &Runner, made: &[Option<Made>]) -> bool {
    let is_same = |read: &Runner| {
        // What was multiplied is as near as single precision comes.
        let within = if made.iter().any(Option::is_some) { 1e-5 } else { 0.0 };
        Values::of(read).but_of(made) == Values::of(runner).but_of(made)
            && has_rows_of(&rows_of(read), &rows_of(runner), within)
    };
    Solver::written(written) == Solver::of(runner)
        && Runner::open(written).is_ok_and(|read| is_same(&read))
}

/// The mass of each particle, and stiffness and damping of each spring; nothing of one that is cut.
fn rows_of(runner: &Runner) -> (Vec<f64>, Vec<Option<[f64; 2]>>) {
    on!(runner, simulation => {
        let model = simulation.model();
        let spring = |row: usize| {
            let constants = || [model.stiffness(row).to_f64(), model.damping(row).to_f64()];
            (!model.is_cut(row)).then(constants)
        };
        let masses = model.masses().iter().map(|mass| mass.to_f64());
        (masses.collect(), (0..model.spring_count()).map(spring).collect())
    })
}

/// Whether rows that were read are those of a run, but for springs that it has cut.
fn has_rows_of(
    read: &(Vec<f64>, Vec<Option<[f64; 2]>>),
    run: &(Vec<f64>, Vec<Option<[f64; 2]>>),
    within: f64,
) -> bool {
    let is_near = |(read, run): (&f64, &f64)| (read - run).abs() <= within * run.abs();
    let is_same = |(read, run): (&Option<[f64; 2]>, &Option<[f64; 2]>)| match (read, run) {
        (_, None) => true,
        (None, Some(_)) => false,
        (Some(read), Some(run)) => read.iter().zip(run).all(is_near),
    };
    let is_long = read.0.len() == run.0.len() && read.1.len() == run.1.len();
    is_long && read.0.iter().zip(&run.0).all(is_near) && read.1.iter().zip(&run.1).all(is_same)
}

/// The shortest number that is the same in single precision, where it came from there.
fn shortest(value: f64) -> f64 {
    let single = value as f32;
    if f64::from(single) != value {
        return value;
    }
    single.to_string().parse().unwrap_or(value)
}

fn write_solver(solver: &mut dyn TableLike, loaded: &Loaded, runner: &Runner) {
    let (was, now) = (loaded.settings, runner.settings());
    if was.integrator != now.integrator {
        put(solver, "integrator", now.integrator.name().into());
    }
    // Another name for automatic substeps, which are written under their own.
    if solver.get("step").is_some_and(Item::is_str) {
        solver.remove("step");
    }
    if runner.is_automatic() {
        put(solver, "substeps", "auto".into());
    } else if loaded.automatic || was.substeps != now.substeps {
        put(solver, "substeps", i64::from(now.substeps).into());
    }
    if was.tolerance != now.tolerance && now.integrator == Integrator::DormandPrince {
        put(solver, "tolerance", now.tolerance.into());
    }
    if was.newton != now.newton {
        put(solver, "newton", i64::from(now.newton).into());
    }
    if loaded.precision != runner.precision() {
        put(solver, "precision", runner.precision().name().into());
    }
}

fn write_plane(plane: &mut dyn TableLike, (restitution, friction): (f64, Friction)) {
    for key in ["sticky", "friction", "tangential_loss"] {
        plane.remove(key);
    }
    put(plane, "restitution", shortest(restitution).into());
    let (key, value) = match friction {
        Friction::Coulomb(value) => ("friction", value),
        Friction::TangentialLoss(value) => ("tangential_loss", value),
    };
    put(plane, key, shortest(value).into());
}

/// A table of the file, made where there is none.
fn table<'a>(file: &'a mut DocumentMut, key: &str) -> Result<&'a mut dyn TableLike, String> {
    let item = file.entry(key).or_insert_with(toml_edit::table);
    item.as_table_like_mut().ok_or(format!("its {key} is not a table"))
}

/// The tables of an array, however it is written.
fn rows(item: Option<&mut Item>) -> Vec<&mut dyn TableLike> {
    match item {
        Some(Item::ArrayOfTables(tables)) => {
            tables.iter_mut().map(|table| table as &mut dyn TableLike).collect()
        }
        Some(Item::Value(Value::Array(array))) => {
            let tables = array.iter_mut().filter_map(Value::as_inline_table_mut);
            tables.map(|table| table as &mut dyn TableLike).collect()
        }
        _ => Vec::new(),
    }
}
