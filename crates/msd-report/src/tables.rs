//! The head, the tables and the notes of a report, in HTML.

use crate::figure::relative;
use crate::ink;
use crate::pen::shown;
use crate::units::{change, number, percent, quantity};
use msd_core::Integrator;
use msd_scene::Precision;
use msd_study::audit::Audit;
use msd_study::choice::{Choice, FRAME};
use msd_study::limits::Limit;
use msd_study::trial::Trial;
use msd_study::{Study, words};
use std::fmt::Write;

/// Text as HTML and SVG show it letter by letter.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' => safe.push('\n'),
            _ => safe.push(shown(letter)),
        }
    }
    safe
}

/// How fast it runs, times real time: `39.2×`.
pub fn speed(cost: f64) -> String {
    if 0.0 < cost && cost.is_finite() { format!("{}×", number(1.0 / cost)) } else { "–".into() }
}

/// A drawing on the page.
pub fn chart(drawing: &str) -> String {
    format!("<figure>{drawing}</figure>\n")
}

/// Title, facts and what it all means.
pub fn head(study: &Study) -> String {
    let facts = [
        counted(study.particles, "particle"),
        counted(study.springs, "spring"),
        format!("{} across", quantity(study.size, "m")),
        format!("{} s simulated", number(study.duration)),
        counted(study.trials.len(), "trial"),
        study.machine.clone(),
        study.date.clone(),
    ];
    let facts: Vec<String> = facts
        .iter()
        .filter(|fact| !fact.is_empty())
        .map(|fact| format!("<li>{}</li>", escaped(fact)))
        .collect();
    let paragraphs: Vec<String> = study
        .words
        .split("\n\n")
        .filter(|words| !words.trim().is_empty())
        .map(|words| format!("<p>{}</p>\n", escaped(words)))
        .collect();
    format!(
        "<header>\n<h1>{}</h1>\n<p class=\"title\">{}</p>\n<ul class=\"facts\">{}</ul>\n</header>\n\
         <div class=\"words\">\n{}</div>\n",
        escaped(&study.scene),
        escaped(&study.title),
        facts.concat(),
        paragraphs.concat()
    )
}

fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// What no other trial beats, cheapest first.
pub fn front(study: &Study) -> String {
    let rows = study.front();
    if rows.is_empty() {
        let why = if study.trials.is_empty() { "was tried" } else { "stayed in the world" };
        return format!("<p>Nothing {why}.</p>\n");
    }
    let chosen = words::cheapest(study, study.wanted);
    let mut body = String::new();
    for row in rows {
        let trial = &study.trials[row];
        let class = if chosen.is_some_and(|chosen| std::ptr::eq(chosen, trial)) {
            " class=\"chosen\""
        } else {
            ""
        };
        let _ = writeln!(body, "<tr data-row=\"{row}\"{class}>{}</tr>", short_cells(study, trial));
    }
    let heads =
        ["Method", "Setting", "Precision", "Per frame", "Times real time", "Error", "Of the size"];
    let mut said = table(&heads, 3, &body);
    said.push_str("<p class=\"note\">No trial was both cheaper and more accurate than one of ");
    said.push_str(if chosen.is_some() {
        "these. The one in bold is the cheapest within the wanted error.</p>\n"
    } else {
        "these. None is within the wanted error.</p>\n"
    });
    said
}

/// Every trial, folded away.
pub fn trials(study: &Study) -> String {
    if study.trials.is_empty() {
        return String::new();
    }
    let mut body = String::new();
    for (row, trial) in study.trials.iter().enumerate() {
        let _ = write!(body, "<tr data-row=\"{row}\">{}", short_cells(study, trial));
        match (&trial.diverged, trial.errors) {
            (None, Some(errors)) => {
                let cells = [
                    quantity(errors.max, "m"),
                    quantity(errors.velocity, "m/s"),
                    quantity(errors.energy, "J"),
                ];
                cells.iter().for_each(|cell| body.push_str(&format!("<td>{cell}</td>")));
            }
            (diverged, _) => {
                let why = diverged.as_deref().unwrap_or("not compared");
                let _ = write!(body, "<td colspan=\"3\" class=\"text\">{}</td>", escaped(why));
            }
        }
        body.push_str("</tr>\n");
    }
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
    let count = counted(study.trials.len(), "trial");
    format!("<details>\n<summary>{count}</summary>\n{}</details>\n", table(&heads, 3, &body))
}

fn short_cells(study: &Study, trial: &Trial) -> String {
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
    format!(
        "{}<td>{}</td><td>{}</td><td>{error}</td><td>{part}</td>",
        choice_cells(&trial.choice),
        quantity(FRAME * trial.cost, "s"),
        speed(trial.cost),
    )
}

fn choice_cells(choice: &Choice) -> String {
    format!(
        "<th scope=\"row\">{}{}</th><td class=\"text\">{}</td><td class=\"text\">{}</td>",
        mark(choice.integrator, choice.precision == Precision::F64),
        choice.integrator,
        choice.fineness(),
        choice.precision
    )
}

/// The mark of a method, as the figure shows it.
fn mark(integrator: Integrator, filled: bool) -> String {
    let corners = ink::mark(integrator).into_iter();
    let points: Vec<String> = corners.map(|(x, y)| format!("{x:.2},{y:.2}")).collect();
    let fill = if filled { "currentColor" } else { "none" };
    format!(
        "<svg class=\"mark {integrator}\" viewBox=\"-1.6 -1.6 3.2 3.2\" aria-hidden=\"true\">\
         <polygon points=\"{}\" fill=\"{fill}\" stroke=\"currentColor\" stroke-width=\"0.35\"/>\
         </svg>",
        points.join(" ")
    )
}

/// A table whose first columns are words.
fn table(heads: &[&str], words: usize, body: &str) -> String {
    let mut head = String::new();
    for (column, title) in heads.iter().enumerate() {
        let class = if column < words { " class=\"text\"" } else { "" };
        let _ = write!(head, "<th scope=\"col\"{class}>{title}</th>");
    }
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n\
         <tbody>\n{body}</tbody>\n</table></div>\n"
    )
}

/// Largest stable substeps, predicted and observed.
pub fn limits(study: &Study) -> String {
    if study.limits.is_empty() {
        return String::new();
    }
    let substep = |seconds: f64| match seconds {
        0.0 => "none: no substep is stable".into(),
        _ if seconds.is_infinite() => "none: every substep is stable".into(),
        _ if 0.0 < seconds => {
            let count = (FRAME / seconds).ceil();
            format!("{} <small>{count} per frame</small>", quantity(seconds, "s"))
        }
        _ => "–".to_owned(),
    };
    let mut body = String::new();
    for &Limit { integrator, predicted, observed } in &study.limits {
        let foreseen = substep(predicted);
        let seen = observed.map_or("not looked for".into(), substep);
        let ratio = observed.map_or(f64::NAN, |observed| observed / predicted);
        let ratio = if ratio.is_finite() && 0.0 < ratio { number(ratio) } else { "–".into() };
        let _ = writeln!(
            body,
            "<tr><th scope=\"row\">{}{integrator}</th><td>{foreseen}</td><td>{seen}</td>\
             <td>{ratio}</td></tr>",
            mark(integrator, true)
        );
    }
    let heads = ["Method", "Limit predicted", "Limit observed", "Observed / predicted"];
    table(&heads, 1, &body)
        + "<p class=\"note\">The largest substep at which a method stays bounded: predicted from \
           the stiffest motion at the start, and observed by trying. Not looked for is what \
           grows too slowly to be seen in some hundred substeps.</p>\n"
}

/// What stiffness, damping and period each method delivers, the worst of each marked.
pub fn audit(study: &Study) -> String {
    if study.audit.is_empty() {
        return String::new();
    }
    let of: [fn(&Audit) -> f64; 4] =
        [|audit| audit.stiffness - 1.0, |audit| audit.damping - 1.0, |_| 0.0, |audit| audit.period];
    let worst = of.map(|off| {
        let sizes = study.audit.iter().map(|audit| off(audit).abs());
        sizes.filter(|size| !size.is_nan()).fold(0.0, f64::max)
    });
    let mut body = String::new();
    for row in &study.audit {
        let _ = write!(body, "<tr>{}", choice_cells(&row.choice));
        let percents = [in_percent(row.stiffness), in_percent(row.damping)];
        let said = percents
            .into_iter()
            .chain([change(row.added_damping, 4, ""), change(100.0 * row.period, 2, " %")]);
        for ((said, off), worst) in said.zip(of).zip(worst) {
            // Half a percent is nothing to warn of.
            let bad = 0.005 <= off(row).abs() && worst <= off(row).abs();
            let class = if bad { " class=\"worst\"" } else { "" };
            let _ = write!(body, "<td{class}>{said}</td>");
        }
        body.push_str("</tr>\n");
    }
    let heads =
        ["Method", "Setting", "Precision", "Stiffness", "Damping", "Damping ratio added", "Period"];
    table(&heads, 3, &body)
        + "<p class=\"note\">A weight hung on springs and a plucked string, against what the \
           formulas say: 100 % is exact, for the period 0 %. A method that damps what should \
           swing makes it look duller; one that takes damping away, livelier. The worst of each \
           column is marked where it is off by half a percent or more.</p>\n"
}

fn in_percent(ratio: f64) -> String {
    match ratio {
        _ if ratio.is_nan() => "–".into(),
        _ if ratio.is_infinite() => "beyond measure".into(),
        _ if ratio.abs() < 10.0 => format!("{:.1} %", 100.0 * ratio).replace('-', "−"),
        _ => percent(ratio),
    }
}

/// What was not tried, and why.
pub fn left_out(study: &Study) -> String {
    if study.left_out.is_empty() {
        return String::new();
    }
    let lines = study.left_out.iter().map(|line| format!("<li>{}</li>\n", escaped(line)));
    format!("<ul>\n{}</ul>\n", lines.collect::<String>())
}

/// How the trials were judged.
pub fn reference(study: &Study) -> String {
    let note = &study.reference;
    let made = if note.tolerance == 0.0 {
        "Where the particles should be is given by a closed form, exact but for rounding.".into()
    } else {
        format!(
            "Where the particles should be was found by Dormand-Prince in double precision, its \
             tolerance tightened tenfold to {:e}; the last tightening moved the particles by {} \
             ({} of the size). It took {} of processor time.",
            note.tolerance,
            quantity(note.uncertainty, "m"),
            percent(relative(study, note.uncertainty)),
            quantity(note.seconds, "s"),
        )
    };
    let mut said = format!("<p>{made}</p>\n");
    if let Some(horizon) = note.horizon {
        let _ = writeln!(
            said,
            "<p>The scene is chaotic after t = {} s: from there on a change too small to measure \
             grows beyond the wanted error.</p>",
            number(horizon)
        );
    }
    if note.reliable_until < study.duration - 1e-9 {
        let _ = writeln!(
            said,
            "<p>Particles were compared one by one up to t = {} s; later only energy, centre of \
             mass and depth in planes.</p>",
            number(note.reliable_until)
        );
    }
    said + "<p>Cost is the time of the processor, best of all runs, on one core: it leaves out \
            drawing and reading files.</p>\n"
}

/// What the words of the report mean.
pub fn glossary() -> String {
    include_str!("report_glossary.html").into()
}
