//! The head, the tables and the notes of a report, in HTML.

use crate::figure::relative;
use crate::ink;
use crate::pen::shown;
use crate::units::{change, number, percent, quantity};
use maud::{Markup, PreEscaped, html};
use msd_core::Integrator;
use msd_scene::Precision;
use msd_study::audit::Audit;
use msd_study::choice::{Choice, FRAME};
use msd_study::limits::Limit;
use msd_study::space::ErrorBalance;
use msd_study::trial::Trial;
use msd_study::{Study, words};

/// Text without the letters that no document may hold; its lines stay.
pub fn clean(text: &str) -> String {
    text.chars().map(|letter| if letter == '\n' { letter } else { shown(letter) }).collect()
}

/// Makes a line a sentence.
pub fn sentence(line: &str) -> String {
    let line = clean(line);
    let mut letters = line.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// Speed of a run, times real time: `39.2×`.
pub fn speed(cost: f64) -> String {
    if 0.0 < cost && cost.is_finite() { format!("{}×", number(1.0 / cost)) } else { "–".into() }
}

/// A drawing on the page.
pub fn chart(drawing: &str) -> Markup {
    html! { figure { (PreEscaped(drawing)) } }
}

/// Title, facts and conclusions.
pub fn head(study: &Study) -> Markup {
    let facts = [
        counted(study.particles, "particle"),
        counted(study.springs, "spring"),
        format!("{} across", quantity(study.size, "m")),
        format!("{} s simulated", number(study.duration)),
        counted(study.trials.len(), "trial"),
        study.machine.clone(),
        study.date.clone(),
    ];
    let paragraphs = study.words.split("\n\n").filter(|words| !words.trim().is_empty());
    html! {
        header {
            h1 { (clean(&study.scene)) }
            p.title { (clean(&study.title)) }
            ul.facts {
                @for fact in facts.iter().filter(|fact| !fact.is_empty()) { li { (clean(fact)) } }
            }
        }
        div.words { @for words in paragraphs { p { (clean(words)) } } }
    }
}

fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// The heads of a table of a front.
const FRONT: [&str; 7] =
    ["Method", "Setting", "Precision", "Per frame", "Times real time", "Error", "Of the size"];

/// The trials that no other trial beats, cheapest first.
pub fn front(study: &Study) -> Markup {
    let rows = study.front();
    if rows.is_empty() {
        let why = if study.trials.is_empty() { "was tried" } else { "stayed in the world" };
        return html! { p { "Nothing " (why) "." } };
    }
    let chosen = words::cheapest(study, study.wanted);
    let is_chosen = |trial| chosen.is_some_and(|chosen| std::ptr::eq(chosen, trial));
    let body = html! {
        @for row in rows {
            @let trial = &study.trials[row];
            tr data-row=(row) class=[is_chosen(trial).then_some("chosen")] {
                (short_cells(study, trial, trial.cost))
            }
            "\n"
        }
    };
    html! {
        (table(&FRONT, 3, &body))
        p.note {
            "No trial was both cheaper and more accurate than one of these. "
            @if chosen.is_some() {
                "The one in bold is the cheapest within the wanted error."
            } @else {
                "None is within the wanted error."
            }
        }
    }
}

/// Every trial, folded away.
pub fn trials(study: &Study) -> Markup {
    if study.trials.is_empty() {
        return html! {};
    }
    let body = html! {
        @for (row, trial) in study.trials.iter().enumerate() {
            tr data-row=(row) {
                (short_cells(study, trial, trial.cost))
                @match (&trial.diverged, trial.errors) {
                    (None, Some(errors)) => {
                        td { (quantity(errors.max, "m")) }
                        td { (quantity(errors.velocity, "m/s")) }
                        td { (quantity(errors.energy, "J")) }
                    }
                    (diverged, _) => {
                        td.text colspan="3" {
                            (clean(diverged.as_deref().unwrap_or("not compared")))
                        }
                    }
                }
            }
            "\n"
        }
    };
    let heads = [
        "Method",
        "Setting",
        "Precision",
        "Per frame",
        "Times real time",
        "Error",
        "Of the size",
        "Largest error",
        "Velocity error",
        "Energy error",
    ];
    html! {
        details {
            summary { (counted(study.trials.len(), "trial")) }
            (table(&heads, 3, &body))
        }
    }
}

/// The trials that no other one beats on the device of the study, cheapest first.
pub fn front_on_device(study: &Study) -> Markup {
    let Some(on_device) = &study.on_device else { return html! {} };
    let body = html! {
        @for (row, cost) in study.front_on_device() {
            tr { (short_cells(study, &study.trials[row], cost)) }
            "\n"
        }
    };
    html! {
        (table(&FRONT, 3, &body))
        p.note {
            "Wall-clock time of " (clean(&on_device.name)) ", transfers of the state included. The "
            "errors are those of the processor: all bits are the same."
        }
    }
}

fn short_cells(study: &Study, trial: &Trial, cost: f64) -> Markup {
    let both = |error: f64| (quantity(error, "m"), percent(relative(study, error)));
    let (error, part) = match trial.errors {
        // Closer to the reference than that is known to be right.
        Some(errors) if errors.rms < study.reference.uncertainty => {
            let (error, part) = both(study.reference.uncertainty);
            (format!("below {error}"), format!("below {part}"))
        }
        Some(errors) => both(errors.rms),
        None => ("diverged".into(), "–".into()),
    };
    html! {
        (choice_cells(&trial.choice))
        td { (quantity(FRAME * cost, "s")) }
        td { (speed(cost)) }
        td { (error) }
        td { (part) }
    }
}

fn choice_cells(choice: &Choice) -> Markup {
    html! {
        th scope="row" {
            (mark(choice.integrator, choice.precision == Precision::F64))
            (choice.integrator.name())
        }
        td.text { (choice.fineness()) }
        td.text { (choice.precision.name()) }
    }
}

/// The mark of a method, as the figure shows it.
fn mark(integrator: Integrator, filled: bool) -> Markup {
    let corners = ink::mark(integrator).into_iter();
    let points: Vec<String> = corners.map(|(x, y)| format!("{x:.2},{y:.2}")).collect();
    let fill = if filled { "currentColor" } else { "none" };
    html! {
        svg.mark.(integrator.name()) viewBox="-1.6 -1.6 3.2 3.2" aria-hidden="true" {
            polygon
                points=(points.join(" "))
                fill=(fill)
                stroke="currentColor"
                stroke-width="0.35" {}
        }
    }
}

/// A table whose first columns are words.
fn table(heads: &[&str], words: usize, body: &Markup) -> Markup {
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        @for (column, title) in heads.iter().enumerate() {
                            th scope="col" class=[(column < words).then_some("text")] { (title) }
                        }
                    }
                }
                tbody { (body) }
            }
        }
    }
}

/// Largest stable substeps, predicted and observed.
pub fn limits(study: &Study) -> Markup {
    if study.limits.is_empty() {
        return html! {};
    }
    let substep = |seconds: f64| match seconds {
        0.0 => html! { "none: no substep is stable" },
        _ if seconds.is_infinite() => html! { "none: every substep is stable" },
        _ if 0.0 < seconds => html! {
            (quantity(seconds, "s")) " " small { ((FRAME / seconds).ceil()) " per frame" }
        },
        _ => html! { "–" },
    };
    let body = html! {
        @for &Limit { integrator, predicted, observed } in &study.limits {
            @let ratio = observed.map_or(f64::NAN, |observed| observed / predicted);
            tr {
                th scope="row" { (mark(integrator, true)) (integrator.name()) }
                td { (substep(predicted)) }
                td { @if let Some(seen) = observed { (substep(seen)) } @else { "not looked for" } }
                td { @if ratio.is_finite() && 0.0 < ratio { (number(ratio)) } @else { "–" } }
            }
            "\n"
        }
    };
    let heads = ["Method", "Limit predicted", "Limit observed", "Observed / predicted"];
    html! {
        (table(&heads, 1, &body))
        p.note {
            "The largest substep at which a method stays bounded: predicted from the stiffest "
            "motion at the start, and observed by trying. Not looked for is what grows too slowly "
            "to be seen in some hundred substeps."
        }
    }
}

/// The effective stiffness, damping and period of each method, the worst of each marked.
pub fn audit(study: &Study) -> Markup {
    if study.audit.is_empty() {
        return html! {};
    }
    let of: [fn(&Audit) -> f64; 4] =
        [|audit| audit.stiffness - 1.0, |audit| audit.damping - 1.0, |_| 0.0, |audit| audit.period];
    let worst = of.map(|off| {
        let sizes = study.audit.iter().map(|audit| off(audit).abs());
        sizes.filter(|size| !size.is_nan()).fold(0.0, f64::max)
    });
    let said = |row: &Audit| {
        [
            in_percent(row.stiffness),
            in_percent(row.damping),
            change(row.added_damping, 4, ""),
            change(100.0 * row.period, 2, " %"),
        ]
    };
    // Half a percent is nothing to warn of.
    let is_bad = |off: f64, worst: f64| 0.005 <= off && worst <= off;
    let body = html! {
        @for row in &study.audit {
            tr {
                (choice_cells(&row.choice))
                @for ((said, off), worst) in said(row).into_iter().zip(of).zip(worst) {
                    td class=[is_bad(off(row).abs(), worst).then_some("worst")] { (said) }
                }
            }
            "\n"
        }
    };
    let heads =
        ["Method", "Setting", "Precision", "Stiffness", "Damping", "Damping ratio added", "Period"];
    html! {
        (table(&heads, 3, &body))
        p.note {
            "A weight hung on springs and a plucked string, against what the formulas say: 100 % "
            "is exact, for the period 0 %. A method that damps what should swing makes it look "
            "duller; one that takes damping away, livelier. The worst of each column is marked "
            "where it is off by half a percent or more."
        }
    }
}

fn in_percent(ratio: f64) -> String {
    match ratio {
        _ if ratio.is_nan() => "–".into(),
        _ if ratio.is_infinite() => "beyond measure".into(),
        _ if ratio.abs() < 10.0 => format!("{:.1} %", 100.0 * ratio).replace('-', "−"),
        _ => percent(ratio),
    }
}

/// The choices that were not tried, and why.
pub fn left_out(study: &Study) -> Markup {
    if study.left_out.is_empty() {
        return html! {};
    }
    html! { ul { @for line in &study.left_out { li { (clean(line)) } "\n" } } }
}

/// The way in which the trials were judged.
pub fn reference(study: &Study) -> Markup {
    let note = &study.reference;
    html! {
        p {
            @if note.tolerance == 0.0 {
                "Where the particles should be is given by a closed form, exact but for rounding."
            } @else {
                @if note.substeps == 0 {
                    "Where the particles should be was found by Dormand-Prince in double "
                    "precision, its tolerance tightened tenfold to "
                    (format_args!("{:e}", note.tolerance))
                } @else {
                    "Where the particles should be was found by RK4 in double precision, with up "
                    "to " (note.substeps) " substeps in a frame, doubled each time"
                }
                "; the last tightening moved the particles by " (quantity(note.uncertainty, "m"))
                " (" (percent(relative(study, note.uncertainty))) " of the size). It took "
                (quantity(note.seconds, "s")) " of processor time."
            }
        }
        @if let Some(horizon) = note.horizon {
            p {
                "The scene is chaotic after t = " (number(horizon)) " s: from there on a change "
                "too small to measure grows beyond the wanted error."
            }
        }
        @if note.reliable_until < study.duration - 1e-9 {
            p {
                "Particles were compared one by one up to t = " (number(note.reliable_until))
                " s; later only energy, centre of mass and depth in planes."
            }
        }
        p {
            "Cost is the time of the processor, best of all runs, on one core: it leaves out "
            "drawing and reading files."
        }
    }
}

/// The errors of space, time and precision, each with the price of less, and the spacings that were
/// run.
pub fn balance(study: &Study, balance: &ErrorBalance) -> Markup {
    let body = html! {
        @for (name, share) in balance.shares() {
            tr {
                th scope="row" { (name) }
                @match share {
                    Some(share) => {
                        td {
                            @if share.is_bound { "below " }
                            (quantity(share.error, "m"))
                        }
                        td { (percent(relative(study, share.error))) }
                        @if share.remedy.is_empty() {
                            td.text colspan="3" { "nothing makes it less" }
                        } @else {
                            td { (share.remedy) }
                            td { (quantity(share.left, "m")) }
                            td {
                                (quantity(FRAME * share.cost, "s")) " ("
                                (number(share.cost / balance.cost)) "×)"
                            }
                        }
                    }
                    None => td.text colspan="5" { "not known" }
                }
            }
            "\n"
        }
    };
    let heads = ["Error of", "Error", "Of the size", "With", "It is", "Per frame"];
    html! {
        (table(&heads, 1, &body))
        p.note {
            "The scene as it is set: " (balance.choice.to_string()) ", "
            (quantity(FRAME * balance.cost, "s")) " per frame. The error of time is that of the "
            "same steps in f64, that of precision the distance of f32 from f64. The dark mark in a "
            "bar is what its remedy leaves."
        }
        @if let Some(space) = &study.space {
            p.note {
                (sentence(&space.words())) " Run as good as exactly in time:"
                @for spacing in &space.spacings {
                    @if spacing.parts == 1 {
                        " at its own spacing, "
                    } @else {
                        " at 1/" (spacing.parts) " of it, "
                    }
                    (counted(spacing.particles, "particle"))
                    @if let Some(error) = spacing.error { ", " (quantity(error, "m")) " off" }
                    ";"
                }
                " compared at " (counted(space.points, "point")) " that all have."
            }
        }
    }
}

/// The meanings of the words of the report.
pub fn glossary() -> Markup {
    PreEscaped(include_str!("report_glossary.html").into())
}
