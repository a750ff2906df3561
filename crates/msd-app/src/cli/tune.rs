//! `msd tune`: the cheapest setting within an error, or the most accurate within a budget.

use super::arguments::TuneArguments;
use super::failure::{Failure, say, say_json};
use super::run::open_scene;
use super::steps::Terminal;
use super::study::halted;
use msd_scene::{SceneFormat, set_keys, shown_path, write_file};
use msd_study::choice::{Choice, FRAME};
use msd_study::quantity::{estimate, quantity};
use msd_study::trial::adds;
use msd_study::tune::{Found, Goal, TuneReport, Tuned, tune, with_choice};
use std::path::Path;

/// Tunes a scene and prints, or writes, the result.
pub fn run_tune(arguments: &TuneArguments) -> Result<(), Failure> {
    let loaded = open_scene(&arguments.scene, &arguments.set.set)?.restarted();
    let path = &arguments.scene;
    let format = writable(path, arguments.write)?;
    let goal = match (arguments.max_error, arguments.budget) {
        (Some(error), _) => Goal::MaxError(error),
        (None, budget) => Goal::Budget(1e-3 * budget.unwrap_or_default()),
    };
    let tuned = tune(&loaded.scene, arguments.duration, goal, &mut Terminal::new());
    let tuned = tuned.map_err(|halt| halted(&loaded.name, halt))?;
    let ended = tuned.is_cut_short.then(|| {
        let tried = tuned.tried;
        Failure::interrupted(format!("interrupted; this is the best of the {tried} settings tried"))
    });
    let write = |format| write_choice(path, format, tuned.best.trial.choice);
    // After an interruption or a missed goal, a better setting may exist: nothing is written.
    let done = format.filter(|_| tuned.met && ended.is_none()).map(write);
    let written = matches!(done, Some(Ok(()))).then(|| shown_path(path));
    let unwritten = done.and_then(Result::err);
    if !arguments.json {
        let lines = summary(&loaded.name, &tuned, written.as_deref(), arguments.write);
        return Failure::all(unwritten.into_iter().chain(say(&lines).err()).chain(ended));
    }
    let report = TuneReport::new(&loaded.name, set_keys(&arguments.set.set), &tuned);
    let report = TuneReport { written, ..report };
    let said = say_json(&report);
    Failure::all(unwritten.into_iter().chain(said.err()).chain(ended))
}

/// Returns the format of a scene file for `--write`; `None` without it.
pub fn writable(path: &Path, wanted: bool) -> Result<Option<SceneFormat>, Failure> {
    if !wanted {
        return Ok(None);
    }
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("toml") => Ok(Some(SceneFormat::Toml)),
        Some("json") => Ok(Some(SceneFormat::Json)),
        _ => Err(Failure::input(format!(
            "--write changes a scene file (.toml or .json); {} is not one",
            shown_path(path)
        ))),
    }
}

/// Writes a choice into the solver section of a scene file.
pub fn write_choice(path: &Path, format: SceneFormat, choice: Choice) -> Result<(), Failure> {
    let name = shown_path(path);
    let refused = |error| Failure::input(format!("{name}: {error}"));
    let text = std::fs::read_to_string(path).map_err(refused)?;
    let text = with_choice(&text, format, &name, choice);
    write_file(path, text.map_err(Failure::input)?.as_bytes()).map_err(Failure::input)
}

fn summary(name: &str, tuned: &Tuned, written: Option<&str>, asked_to_write: bool) -> String {
    let Tuned { goal, best, others, met, .. } = tuned;
    let wish = match goal {
        Goal::MaxError(error) => format!("an error of at most {}", estimate(*error, "m")),
        Goal::Budget(seconds) => format!("at most {} per frame", estimate(*seconds, "s")),
    };
    let nearest = || format!("{}; the nearest is", tuned.verdict());
    let verdict = if *met { "use".into() } else { nearest() };
    let mut lines = vec![
        format!(
            "{name}, {}, {wish}: {verdict} {}",
            quantity(tuned.duration, "s"),
            best.trial.choice
        ),
        format!("  {}", line(best, tuned.uncertainty)),
    ];
    if let Some(second) = others.first() {
        lines.push(format!("second: {}", second.trial.choice));
        lines.push(format!("  {}", line(second, tuned.uncertainty)));
    }
    lines.push(format!(
        "{} settings tried; uncertainty of the reference: {}",
        tuned.tried,
        estimate(tuned.uncertainty, "m")
    ));
    if tuned.compared < tuned.duration - 1e-9 {
        lines.push(format!(
            "compared only up to t = {}: {}",
            quantity(tuned.compared, "s"),
            match tuned.horizon {
                Some(time) => format!("the scene is chaotic after t = {}", quantity(time, "s")),
                None => "after that the reference is too uncertain".into(),
            }
        ));
    }
    if !met && asked_to_write {
        lines.push("not written, as it does not meet the goal".into());
    } else if written.is_none() && asked_to_write {
        lines.push("not written, as there may be a better one".into());
    }
    lines.extend(written.map(|file| format!("written to the solver section of {file}")));
    lines.join("\n")
}

/// Formats a choice; errors below the uncertainty of the reference, metres, print as bounds.
fn line(found: &Found, uncertainty: f64) -> String {
    let known = |error: f64| match error < uncertainty {
        true => format!("below {}", estimate(uncertainty, "m")),
        false => estimate(error, "m"),
    };
    format!(
        "error {} (predicted {}), {} of CPU time per frame{}",
        known(found.trial.error()),
        found.predicted_error.map_or("nothing".into(), known),
        estimate(found.trial.cost * FRAME, "s"),
        match found.trial.gained {
            0.0 => String::new(),
            gained => format!("; {}", adds(gained)),
        }
    )
}
