//! The meaning of a study, in plain words.

use crate::measure::trial::{Trial, adds};
use crate::quantity::{estimate, rounded};
use crate::study::{OnDevice, Study};
use msd_core::Integrator;
use msd_scene::Precision;

/// Recommends a choice, and states the price of more accuracy and the choices that never pay.
pub fn words(study: &Study) -> String {
    let mut said = vec![recommendation(study, study.wanted)];
    if let Some(chosen) = cheapest(study, study.wanted) {
        said.extend(twice_as_accurate(study, chosen));
        said.extend(default_method(study, chosen));
        said.extend(implicit(study, chosen));
        said.extend(single(study, chosen));
    }
    said.extend(on_device(study));
    said.extend(caveats(study));
    said.join(" ")
}

/// The cheapest trial within an error, metres.
pub fn cheapest(study: &Study, wanted: f64) -> Option<&Trial> {
    cheapest_of(study.trials.iter(), wanted)
}

fn cheapest_of<'a>(trials: impl Iterator<Item = &'a Trial>, wanted: f64) -> Option<&'a Trial> {
    let fine = trials.filter(|trial| trial.is_within(wanted));
    fine.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn recommendation(study: &Study, wanted: f64) -> String {
    match cheapest(study, wanted) {
        Some(trial) => format!(
            "For an error of {} use {}: {} per frame, {}.",
            estimate(wanted, "m"),
            told(trial),
            estimate(trial.cost / 60.0, "s"),
            off(study, trial)
        ),
        None => {
            let sound = study.trials.iter().filter(|trial| trial.is_sound());
            let best = sound.min_by(|a, b| a.error().total_cmp(&b.error()));
            let nearest = best.map_or("nothing stays in the world".into(), |trial| {
                format!("the nearest is {}, {}", told(trial), off(study, trial))
            });
            format!("Nothing that was tried comes within {}; {nearest}.", estimate(wanted, "m"))
        }
    }
}

fn twice_as_accurate(study: &Study, chosen: &Trial) -> Option<String> {
    if chosen.error() <= 2.0 * study.reference.uncertainty {
        return None;
    }
    let better = cheapest(study, 0.5 * chosen.error())?;
    let ratio = better.cost / chosen.cost;
    let gain = chosen.error() / better.error().max(study.reference.uncertainty);
    Some(format!(
        "{} costs {} times as much ({}).",
        if gain < 3.0 {
            "Half the error".into()
        } else {
            format!("An error {} times smaller", rounded(gain, 2))
        },
        rounded(ratio, 2),
        told(better)
    ))
}

fn default_method(study: &Study, chosen: &Trial) -> Option<String> {
    let method = Integrator::default();
    if chosen.choice.integrator == method {
        return None;
    }
    let usual = cheapest_of(study.of(method), study.wanted)?;
    let ratio = usual.cost / chosen.cost;
    let usual = told(usual);
    Some(format!("The default method costs {} times as much ({usual}).", rounded(ratio, 2)))
}

fn implicit(study: &Study, chosen: &Trial) -> Option<String> {
    let is_implicit = |trial: &&Trial| trial.choice.integrator.is_implicit();
    if is_implicit(&chosen) {
        return None;
    }
    let front = study.front();
    if front.iter().map(|&row| &study.trials[row]).any(|trial| is_implicit(&trial)) {
        return Some("Implicit methods pay at some other accuracy: see the front.".into());
    }
    let cut_short = |line: &String| {
        let mut implicit = Integrator::ALL.into_iter().filter(|method| method.is_implicit());
        implicit.any(|method| line.contains(method.name()))
    };
    Some(match cheapest_of(study.trials.iter().filter(is_implicit), study.wanted) {
        None if study.left_out.iter().any(cut_short) => {
            "Implicit methods were not tried to the end.".into()
        }
        Some(best) => format!(
            "Implicit never pays here: the cheapest that is as good costs {} times as much.",
            rounded(best.cost / chosen.cost, 2)
        ),
        None => "Implicit never pays here: none that was tried is as good.".into(),
    })
}

fn single(study: &Study, chosen: &Trial) -> Option<String> {
    let other = match chosen.choice.precision {
        Precision::F32 => Precision::F64,
        Precision::F64 => Precision::F32,
    };
    let same = |trial: &&Trial| trial.choice.precision == other;
    let other_trial = cheapest_of(study.trials.iter().filter(same), study.wanted);
    Some(match other_trial {
        Some(trial) => format!(
            "In {other} the same error costs {} times as much.",
            rounded(trial.cost / chosen.cost, 2)
        ),
        None => format!("In {other} no choice that was tried is as good."),
    })
}

/// The choice for a device, and its cost beside that of the best on the processor.
fn on_device(study: &Study) -> Option<String> {
    let OnDevice { name, fault, costs } = study.on_device.as_ref()?;
    let mut rows = study.front_on_device().into_iter();
    let rows = rows.find(|&(row, _)| study.trials[row].is_within(study.wanted));
    let known = rows.map(|(row, cost)| (&study.trials[row], cost));
    let said = match (known, cheapest(study, study.wanted)) {
        (Some((trial, cost)), Some(best)) => format!(
            "On {name} the cheapest is {}: {} per frame, transfers included, {} times the CPU time \
             of the cheapest on the processor.",
            told(trial),
            estimate(cost / 60.0, "s"),
            rounded(cost / best.cost, 2)
        ),
        _ if costs.is_empty() => format!("No setting was timed on {name}."),
        _ => format!("No setting timed on {name} is within that error."),
    };
    let failed =
        fault.as_ref().map(|why| format!(" The timing on the device stopped early: {why}."));
    Some(said + &failed.unwrap_or_default())
}

fn caveats(study: &Study) -> Vec<String> {
    let mut said = Vec::new();
    if study.left_out.iter().any(|line| line.contains("the time was up")) {
        said.push("Not everything was tried, for the time was up: --time gives more.".into());
    }
    said.extend(sources(study));
    let steppy = study.left_out.iter().find(|line| line.contains("tangential_loss"));
    said.extend(steppy.cloned());
    let note = &study.reference;
    if note.reliable_until < study.duration - 1e-9 {
        said.push(format!(
            "After t = {} s particles cannot be compared any more ({}); from there on only the \
             energy and the centre of mass were.",
            rounded(note.reliable_until, 2),
            match note.horizon {
                Some(time) => format!("the scene is chaotic after t = {} s", rounded(time, 2)),
                None => format!(
                    "the reference itself is only certain to {}",
                    estimate(note.uncertainty, "m")
                ),
            }
        ));
    }
    said
}

/// The number of tried settings that are sources of energy, in words; `None` where none is.
pub fn sources(study: &Study) -> Option<String> {
    let count = study.trials.iter().filter(|trial| 0.0 < trial.gained).count();
    match count {
        0 => None,
        1 => Some("One setting gains energy and is excluded.".into()),
        _ => Some(format!("{count} settings gain energy and are excluded.")),
    }
}

/// The error of a trial, as far as the reference can resolve it.
pub fn off(study: &Study, trial: &Trial) -> String {
    let uncertainty = study.reference.uncertainty;
    if 0.0 < trial.gained {
        format!("{} off, and {}", estimate(trial.error(), "m"), adds(trial.gained))
    } else if trial.error() < uncertainty {
        format!(
            "less than {} off, which is what the reference is known to",
            estimate(uncertainty, "m")
        )
    } else {
        format!("{} off", estimate(trial.error(), "m"))
    }
}

/// A trial as a sentence names it.
pub fn told(trial: &Trial) -> String {
    let choice = trial.choice;
    format!("{} with {} in {}", choice.integrator, choice.fineness(), choice.precision)
}
