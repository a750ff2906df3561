//! `msd tune`: the cheapest setting within an error, or the most accurate within a budget.

use super::arguments::{DeviceChoice, TuneArguments};
use super::device::{GpuFleet, open_for_settings, settle};
use super::failure::{self, Failure, say, say_json};
use super::run::open_scene;
use super::steps::Terminal;
use super::study::halted;
use msd_core::Scene;
use msd_scene::{SceneFormat, set_keys, shown_path, write_file};
use msd_study::choice::{Choice, FRAME};
use msd_study::device::Device;
use msd_study::monitor::Halt;
use msd_study::quantity::{estimate, quantity};
use msd_study::trial::adds;
use msd_study::tune::{Found, Goal, TuneReport, Tuned, Tuner, tune, tune_on, with_choice};
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
    let (fleet, note) = settle(&arguments.device, &loaded.name, |_| {
        open_for_settings(&arguments.device, &loaded.scene)
    })?;
    // Which one `auto` takes is known after both searches.
    let note = note.filter(|_| fleet.is_none() || arguments.device != DeviceChoice::Auto);
    note.iter().for_each(|line| failure::note(line));
    let (tuned, device) = tune_for(arguments, (&loaded.name, &loaded.scene), goal, fleet)?;
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
        let about = (&*loaded.name, device.as_deref());
        let lines = summary(about, &tuned, written.as_deref(), arguments.write);
        return Failure::all(unwritten.into_iter().chain(say(&lines).err()).chain(ended));
    }
    let report = TuneReport::new(&loaded.name, set_keys(&arguments.set.set), &tuned);
    let device = device.unwrap_or_else(|| report.device.clone());
    let report = TuneReport { device, written, ..report };
    let said = say_json(&report);
    Failure::all(unwritten.into_iter().chain(said.err()).chain(ended))
}

/// Tunes a scene for the processor, for a device, or for the better of both; returns also the name
/// of the device if it is that.
fn tune_for(
    arguments: &TuneArguments,
    (name, scene): (&str, &Scene),
    goal: Goal,
    fleet: Option<GpuFleet>,
) -> Result<(Tuned, Option<String>), Failure> {
    let (duration, mut terminal) = (arguments.duration, Terminal::new());
    let failed = |halt| halted(name, halt);
    let is_auto = arguments.device == DeviceChoice::Auto;
    let mut alone = || tune(scene, duration, goal, &mut terminal).map_err(failed);
    let Some(mut fleet) = fleet else { return Ok((alone()?, None)) };
    let here = match is_auto.then(&mut alone).transpose()? {
        Some(here) if here.is_cut_short => return Ok((here, None)),
        here => here,
    };
    let mut tuner = Tuner::new(&mut fleet);
    let there = tune_on((scene, &mut tuner), duration, goal, &mut terminal);
    let (fault, device) = (tuner.fault, fleet.name());
    if let Some(why) = fault {
        let Some(here) = here else { return Err(Failure::input(format!("{name}: {why}"))) };
        failure::tell(&format!("warning: {why}; the result is for the processor"));
        return Ok((here, None));
    }
    let Some(here) = here else { return Ok((there.map_err(failed)?, Some(device))) };
    let there = match there {
        Ok(there) => there,
        Err(Halt::Refused(_)) => return Ok((here, None)),
        Err(Halt::Cancelled | Halt::Deadline) => {
            return Ok((Tuned { is_cut_short: true, ..here }, None));
        }
    };
    let is_cut_short = there.is_cut_short;
    let takes_device = is_better(&there, &here);
    let chosen = if takes_device { &*device } else { "processor" };
    let [mine, its] = [&here, &there].map(in_words);
    failure::note(&format!(
        "device: {chosen}, as the best setting on the processor {mine}, and that on {device} {its}"
    ));
    Ok(if takes_device { (there, Some(device)) } else { (Tuned { is_cut_short, ..here }, None) })
}

/// The value of the best choice of a search, as two are compared.
fn in_words(tuned: &Tuned) -> String {
    let trial = &tuned.best.trial;
    let value = match tuned.goal {
        Goal::MaxError(_) => format!("takes {} per frame", estimate(trial.cost * FRAME, "s")),
        Goal::Budget(_) => format!("is {} off", estimate(trial.error(), "m")),
    };
    if tuned.met { value } else { format!("{value} and misses the goal") }
}

/// Returns whether a search found a better choice than another one for the same goal.
fn is_better(a: &Tuned, b: &Tuned) -> bool {
    let value = |tuned: &Tuned| match tuned.goal {
        Goal::MaxError(_) => tuned.best.trial.cost,
        Goal::Budget(_) => tuned.best.trial.error(),
    };
    if a.met == b.met { value(a) < value(b) } else { a.met }
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

fn summary(
    (name, device): (&str, Option<&str>),
    tuned: &Tuned,
    written: Option<&str>,
    asked_to_write: bool,
) -> String {
    let Tuned { goal, best, others, met, .. } = tuned;
    let wish = match goal {
        Goal::MaxError(error) => format!("an error of at most {}", estimate(*error, "m")),
        Goal::Budget(seconds) => format!("at most {} per frame", estimate(*seconds, "s")),
    };
    let nearest = || format!("{}; the nearest is", tuned.verdict());
    let verdict = if *met { "use".into() } else { nearest() };
    let mut lines = vec![
        format!(
            "{name}, {}, {wish}: {verdict} {}{}",
            quantity(tuned.duration, "s"),
            best.trial.choice,
            device.map_or(String::new(), |device| format!(", on {device}"))
        ),
        format!("  {}", line(best, device, tuned.uncertainty)),
    ];
    if let Some(second) = others.first() {
        lines.push(format!("second: {}", second.trial.choice));
        lines.push(format!("  {}", line(second, device, tuned.uncertainty)));
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
fn line(found: &Found, device: Option<&str>, uncertainty: f64) -> String {
    let known = |error: f64| match error < uncertainty {
        true => format!("below {}", estimate(uncertainty, "m")),
        false => estimate(error, "m"),
    };
    format!(
        "error {} (predicted {}), {} {} per frame{}",
        known(found.trial.error()),
        found.predicted_error.map_or("nothing".into(), known),
        estimate(found.trial.cost * FRAME, "s"),
        device.map_or("of CPU time", |_| "with transfers"),
        match found.trial.gained {
            0.0 => String::new(),
            gained => format!("; {}", adds(gained)),
        }
    )
}
