//! The meaning of a study, in plain words.

use crate::measure::trial::Trial;
use crate::study::Study;
use msd_core::Integrator;
use msd_scene::Precision;

/// Says what to use, what more accuracy costs and what never pays.
pub fn words(study: &Study) -> String {
    let mut said = vec![recommendation(study, study.wanted)];
    if let Some(chosen) = cheapest(study, study.wanted) {
        said.extend(twice_as_accurate(study, chosen));
        said.extend(default_method(study, chosen));
        said.extend(implicit(study, chosen));
        said.extend(single(study, chosen));
    }
    said.extend(caveats(study));
    said.join(" ")
}

/// The cheapest trial within an error, metres.
pub fn cheapest(study: &Study, wanted: f64) -> Option<&Trial> {
    cheapest_of(study.trials.iter(), wanted)
}

fn cheapest_of<'a>(trials: impl Iterator<Item = &'a Trial>, wanted: f64) -> Option<&'a Trial> {
    let fine = trials.filter(|trial| trial.error() <= wanted);
    fine.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

fn recommendation(study: &Study, wanted: f64) -> String {
    match cheapest(study, wanted) {
        Some(trial) => format!(
            "For an error of {} use {}: {} per frame, {}.",
            metres(wanted),
            told(trial),
            milliseconds(trial.cost / 60.0),
            off(study, trial)
        ),
        None => {
            let best = study.trials.iter().min_by(|a, b| a.error().total_cmp(&b.error()));
            let best = best.filter(|trial| trial.errors.is_some());
            let nearest = best.map_or("nothing stayed in the world".into(), |trial| {
                format!("the nearest is {}, {}", told(trial), off(study, trial))
            });
            format!("Nothing that was tried comes within {}; {nearest}.", metres(wanted))
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
        "{} as accurate costs {} times as much ({}).",
        if gain < 3.0 { "Twice".into() } else { format!("{} times", short(gain)) },
        short(ratio),
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
    Some(format!("The default method costs {} times as much ({usual}).", short(ratio)))
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
            short(best.cost / chosen.cost)
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
            short(trial.cost / chosen.cost)
        ),
        None => format!("In {other} no choice that was tried is as good."),
    })
}

fn caveats(study: &Study) -> Vec<String> {
    let mut said = Vec::new();
    if study.left_out.iter().any(|line| line.contains("the time was up")) {
        said.push("Not everything was tried, for the time was up: --time gives more.".into());
    }
    let steppy = study.left_out.iter().find(|line| line.contains("tangential_loss"));
    said.extend(steppy.cloned());
    let note = &study.reference;
    if note.reliable_until < study.duration - 1e-9 {
        said.push(format!(
            "After t = {} s particles cannot be compared any more ({}); from there on only the \
             energy and the centre of mass were.",
            short(note.reliable_until),
            match note.horizon {
                Some(time) => format!("the scene is chaotic after t = {} s", short(time)),
                None =>
                    format!("the reference itself is only certain to {}", metres(note.uncertainty)),
            }
        ));
    }
    said
}

/// How far off a trial is, as far as the reference can tell.
pub fn off(study: &Study, trial: &Trial) -> String {
    let uncertainty = study.reference.uncertainty;
    if trial.error() < uncertainty {
        format!("less than {} off, which is what the reference is known to", metres(uncertainty))
    } else {
        format!("{} off", metres(trial.error()))
    }
}

/// A trial as a sentence names it.
pub fn told(trial: &Trial) -> String {
    let choice = trial.choice;
    format!("{} with {} in {}", choice.integrator, choice.fineness(), choice.precision)
}

/// A length in the unit that reads best.
pub fn metres(length: f64) -> String {
    let units = [(1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")];
    let fits = |(unit, _): &&(f64, &str)| *unit <= length;
    match units.iter().find(fits) {
        Some((unit, name)) => format!("{} {name}", short(length / unit)),
        None if length == 0.0 => "0 m".into(),
        None => format!("{length:.1e} m"),
    }
}

/// A time of the processor in milliseconds or microseconds.
pub fn milliseconds(seconds: f64) -> String {
    if seconds < 1e-4 {
        format!("{} µs", short(1e6 * seconds))
    } else {
        format!("{} ms", short(1e3 * seconds))
    }
}

/// A number with two or three digits.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !size.is_finite() => format!("{value}"),
        size if !(1e-3..1e5).contains(&size) => format!("{value:.1e}"),
        size if size < 1.0 => {
            let digits = (1.0 - size.log10().floor()) as usize;
            format!("{value:.digits$}")
        }
        size if size < 10.0 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}
