//! `msd tune --mesh`: spacing and setting with a bounded total error.

use super::arguments::TuneArguments;
use super::failure::{Failure, say, say_json};
use super::run::open_draft;
use super::steps::Terminal;
use super::tune::{writable, write_choice};
use msd_scene::schema::{
    BodyKey, BodyRow, EndRow, Kind, LinkRow, MassRow, MaterialRow, PinRow, SceneFile,
};
use msd_scene::{SceneFormat, SetKeys, plain, set_keys, shown_path};
use msd_study::choice::{Choice, FRAME};
use msd_study::monitor::Halt;
use msd_study::quantity::{estimate, quantity};
use msd_study::space::{Space, SpacePlan, Verdict};
use msd_study::tune::{ChoiceReport, FoundSpacing, TunedSpacing, tune_spacing, with_choice};
use serde::Serialize;

/// Result of tuning with the mesh; the keys of `--json`.
#[derive(Debug, Serialize)]
struct MeshReport {
    scene: String,
    set: SetKeys,
    max_error: f64,
    met: bool,
    /// Factor of the refinement of the spacing.
    parts: Option<u32>,
    /// Keys for the scene file if the spacing differs from its own.
    keys: Vec<String>,
    space_error: Option<f64>,
    total_error: Option<f64>,
    /// Uncertainty of the limit of finer spacings, metres.
    doubt: Option<f64>,
    #[serde(flatten)]
    best: Option<ChoiceReport>,
    space: Space,
    written: Option<String>,
}

/// Tunes spacing and setting, and prints the result; writes it if the spacing stays the same.
pub fn run_tune_mesh(arguments: &TuneArguments, max_error: f64) -> Result<(), Failure> {
    let path = &arguments.scene;
    let format = writable(path, arguments.write)?;
    let draft = open_draft(path, &arguments.set.set)?;
    let duration = arguments.duration;
    let plan = SpacePlan { duration, ..SpacePlan::default() };
    let plan = SpacePlan { budget: arguments.time.unwrap_or(plan.budget), ..plan };
    let tuned = tune_spacing(&draft, plan, max_error, &mut Terminal::new());
    let tuned = tuned.map_err(|halt| match halt {
        Halt::Refused(error) => Failure::input(error),
        Halt::Cancelled | Halt::Deadline => {
            Failure::interrupted("interrupted before a spacing was found")
        }
    })?;
    let source = draft.source().map_err(Failure::input)?;
    let name = draft.load(&source).map_err(Failure::input)?.name;
    let rows = msd_scene::decode(&source).map_err(Failure::input)?;
    let found = tuned.found.as_ref();
    let keys = found.and_then(|found| found.rows.as_ref()).map(|fine| changed(&rows, fine));
    let keys = keys.unwrap_or_default();
    let own = found.filter(|found| found.rows.is_none() && tuned.is_met());
    let choice = own.map(|found| found.tuned.best.trial.choice);
    let done = format.zip(choice).map(|(format, choice)| write_choice(path, format, choice));
    let written = matches!(done, Some(Ok(()))).then(|| shown_path(path));
    let unwritten = done.and_then(Result::err);
    let said = if arguments.json {
        let report = MeshReport {
            scene: name,
            set: set_keys(&arguments.set.set),
            max_error,
            met: tuned.is_met(),
            parts: found.map(|found| found.parts),
            keys,
            space_error: found.map(|found| found.space_error),
            total_error: found.map(|found| found.verified),
            doubt: tuned.doubt.is_finite().then_some(tuned.doubt),
            best: found.map(|found| ChoiceReport::new(&found.tuned.best, found.tuned.uncertainty)),
            space: tuned.space,
            written,
        };
        say_json(&report)
    } else {
        let mut lines = summary(&name, &tuned, &keys);
        match (written, arguments.write) {
            (Some(file), _) => lines.push(format!("written to the solver section of {file}")),
            (None, true) if tuned.is_met() => {
                lines.push("not written: --write cannot write a spacing".into());
            }
            (None, true) => lines.push("not written: the goal is not met".into()),
            _ => {}
        }
        say(&lines.join("\n"))
    };
    Failure::all(unwritten.into_iter().chain(said.err()))
}

fn summary(name: &str, tuned: &TunedSpacing, keys: &[String]) -> Vec<String> {
    let TunedSpacing { wanted, space, doubt, found } = tuned;
    let wish = format!(
        "{name}, {}, an error of at most {}, including that of space",
        quantity(space.duration, "s"),
        estimate(*wanted, "m")
    );
    let Some(FoundSpacing { parts, space_error, tuned: best, verified, .. }) = found else {
        let verdict = match space.verdict {
            _ if doubt.is_finite() => "no spacing tried is certain to meet it".into(),
            Verdict::Known { until, .. } => format!(
                "the error of space is known for the first {} of {} only",
                quantity(until, "s"),
                quantity(space.duration, "s")
            ),
            _ => "it is unknown whether a spacing meets it".to_owned(),
        };
        let finest = space.spacings.iter().rev().find_map(|row| Some((row.parts, row.error?)));
        let off = finest.filter(|(parts, _)| 1 < *parts).map_or(String::new(), |(parts, error)| {
            format!("; at 1/{parts} of the spacing it is {}", estimate(error, "m"))
        });
        return vec![
            format!("{wish}: {verdict}"),
            format!("  {}{off}", space.words()),
            format!("  no finer one: {}", space.stopped),
        ];
    };
    let verdict = if tuned.is_met() { "use" } else { "none meets it; the nearest is" };
    let spacing = match parts {
        1 => "the current spacing".to_owned(),
        parts => format!("1/{parts} of the spacing"),
    };
    let trial = &best.best.trial;
    let mut lines = vec![
        format!("{wish}: {verdict} {spacing} and {}", trial.choice),
        format!(
            "  space {}, time and precision {}; together {} ± {}, relative to the limit of fine \
             meshes",
            estimate(*space_error, "m"),
            estimate(trial.error(), "m"),
            estimate(*verified, "m"),
            estimate(*doubt, "m")
        ),
        format!("  {} of CPU time per frame", estimate(trial.cost * FRAME, "s")),
    ];
    lines.push("set in the scene:".into());
    lines.push(format!("  solver: {}", solver_keys(trial.choice)));
    lines.extend(keys.iter().map(|key| format!("  {key}")));
    lines.push(space.words());
    lines
}

/// Returns the keys of the solver section for a choice.
fn solver_keys(choice: Choice) -> String {
    let section = with_choice("version = 1\n", SceneFormat::Toml, "scene", choice);
    let section = section.unwrap_or_default();
    let keys = section.lines().skip_while(|line| !line.starts_with('[')).skip(1);
    keys.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(", ")
}

/// A property of a body, if it is given.
type NumberOf = fn(&BodyRow) -> Option<f64>;

/// Returns the keys that differ in a finer scene, as written.
fn changed(rows: &SceneFile, fine: &SceneFile) -> Vec<String> {
    let mut lines = Vec::new();
    if rows.bodies.iter().any(|body| body.kind == Kind::Mesh) {
        let cut = "no keys: the triangles of its meshes were refined too, which no key describes";
        return vec![cut.into()];
    }
    for (row, (before, after)) in rows.bodies.iter().zip(&fine.bodies).enumerate() {
        let keys: [(&str, NumberOf); 4] = [
            ("spacing", |body| body.spacing),
            ("mass", |body| body.mass),
            ("stiffness", |body| body.stiffness),
            ("damping", |body| body.damping),
        ];
        let mut said = Vec::new();
        if let Some(size) = after.size.as_ref().filter(|_| before.size != after.size) {
            said.push(format!("size = {size:?}"));
        }
        for (key, of) in keys {
            if let Some(value) = of(after).filter(|_| of(before) != of(after)) {
                said.push(format!("{key} = {}", plain(value)));
            }
        }
        if !said.is_empty() {
            lines.push(format!("bodies[{row}]: {}", said.join(", ")));
        }
    }
    if rows.world != fine.world {
        let drag = fine.world.drag.map(|drag| format!("drag = {}", plain(drag)));
        let force = fine.world.force.map(|force| format!("force = {force:?}"));
        let said: Vec<String> = drag.into_iter().chain(force).collect();
        lines.push(format!("world: {}", said.join(", ")));
    }
    lines.extend(joins(rows, fine));
    lines
}

/// Returns the pins, masses, materials and links that differ in a finer scene, as written.
fn joins(rows: &SceneFile, fine: &SceneFile) -> Vec<String> {
    let mut lines = Vec::new();
    let mut say =
        |key: &str, rows: Vec<String>| lines.push(format!("{key} = [{}]", rows.join(", ")));
    let place = |pin: &PinRow| (number(pin.body.as_ref()), pin.at, pin.particle);
    if !fine.pins.iter().map(place).eq(rows.pins.iter().map(place)) {
        let row = |pin: &PinRow| {
            let velocity = pin.velocity.map(|velocity| format!(", velocity = {velocity:?}"));
            let velocity = velocity.unwrap_or_default();
            format!("{{ {}{velocity} }}", particle(pin.body.as_ref(), pin.at, pin.particle))
        };
        say("pins", fine.pins.iter().map(row).collect());
    }
    if fine.masses != rows.masses {
        let row = |load: &MassRow| {
            let place = particle(load.body.as_ref(), load.at, load.particle);
            format!("{{ {place}, mass = {} }}", plain(load.mass))
        };
        say("masses", fine.masses.iter().map(row).collect());
    }
    if fine.materials != rows.materials {
        let row = |material: &MaterialRow| {
            let numbers = [
                ("stiffness", material.stiffness),
                ("damping", material.damping),
                ("young", material.young),
                ("relaxation_time", material.relaxation_time),
            ];
            let numbers = numbers.into_iter().filter_map(|(key, value)| {
                value.map(|value| format!(", {key} = {}", plain(value)))
            });
            let body = match &material.body {
                Some(BodyKey::Number(number)) => format!("body = {number}, "),
                Some(BodyKey::Name(name)) => format!("body = \"{name}\", "),
                None => String::new(),
            };
            let set = &material.set;
            format!("{{ {body}set = \"{set}\"{} }}", numbers.collect::<String>())
        };
        say("materials", fine.materials.iter().map(row).collect());
    }
    if fine.links != rows.links {
        let row = |link: &LinkRow| {
            let ends = [("from", &link.from), ("to", &link.to)]
                .map(|(key, end)| format!("{key} = {{ {} }}", place_of(end)));
            let numbers = [
                ("rest_length", link.rest_length),
                ("stiffness", link.stiffness),
                ("damping", link.damping),
            ];
            let numbers = numbers
                .into_iter()
                .filter_map(|(key, value)| value.map(|value| format!("{key} = {}", plain(value))));
            let said: Vec<String> = ends.into_iter().chain(numbers).collect();
            format!("{{ {} }}", said.join(", "))
        };
        say("links", fine.links.iter().map(row).collect());
    }
    lines
}

/// Returns the index of a body of a finer scene, whose rows have no names.
fn number(body: Option<&BodyKey>) -> u64 {
    match body {
        Some(&BodyKey::Number(number)) => number,
        _ => 0,
    }
}

/// Returns the keys of an end of a link of a finer scene.
fn place_of(end: &EndRow) -> String {
    match &end.solid {
        Some(solid) => format!("solid = {}", number(Some(solid))),
        None => particle(end.body.as_ref(), end.at, end.particle),
    }
}

/// Returns the keys of a particle of a finer scene.
fn particle(body: Option<&BodyKey>, at: Option<[u64; 3]>, particle: Option<i64>) -> String {
    let place = match at {
        Some(at) => format!("at = {at:?}"),
        None => format!("particle = {}", particle.unwrap_or_default()),
    };
    format!("body = {}, {place}", number(body))
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_study::space::Spacing;

    #[test]
    fn a_limit_that_is_known_in_part_and_an_error_too_large_are_told_apart() {
        let spacing =
            |parts, error| Spacing { parts, particles: 0, springs: 0, error, seconds: 1.0 };
        let told = |until, compared, wanted| {
            let verdict =
                Verdict::Known { error: 7.2e-3, band: 1e-3, order: 2.0, is_seen: true, until };
            let space = Space {
                duration: 1.0,
                compared,
                points: 27,
                spacings: vec![spacing(1, Some(7.2e-3)), spacing(2, Some(1.8e-3))],
                verdict,
                stopped: "the time is up".into(),
            };
            let doubt = if until < 1.0 { f64::INFINITY } else { 1e-3 };
            summary("cube", &TunedSpacing { wanted, space, doubt, found: None }, &[]).join("\n")
        };
        // The error is below the goal, but known for a part of the time only.
        for (compared, why) in [(1.0, "do not approach one motion"), (0.4, "is not certain enough")]
        {
            let part = told(0.4, compared, 0.5);
            assert!(
                part.contains("the error of space is known for the first 400 ms of 1 s only"),
                "{part}"
            );
            assert!(part.contains("7.2 mm up to t = 0.4 s (after that "), "{part}");
            assert!(part.contains(why), "{part}");
        }
        let large = told(1.0, 1.0, 1e-4);
        assert!(large.contains("no spacing tried is certain to meet it"), "{large}");
        assert!(large.contains("at 1/2 of the spacing it is 1.8 mm"), "{large}");
    }
}
