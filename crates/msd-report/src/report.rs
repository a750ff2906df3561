//! The report of a study: one page to open in a browser, a table of numbers, and a figure.

use crate::balance_figure::{self, errors_side_by_side};
use crate::energy_figure::{self, energy_over_time};
use crate::figure::{self, Spot, relative, work_precision};
use crate::ink::{self, Ink};
use crate::pen::WIDTH;
use crate::tables::{self, clean, sentence};
use crate::{raster, units};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use msd_core::Integrator;
use msd_study::Study;
use msd_study::choice::{FRAME, Fineness};
use msd_study::trial::Trial;
use plotters::prelude::SVGBackend;
use std::fmt::Write;

/// Dots of a drawing per pixel of a page: plotters draws from dot to dot.
const DOTS: f64 = 10.0;
/// Width of the picture, pixels: twice the page, for screens that have as many.
const PICTURE_WIDTH: u32 = 1920;

/// The report: one page that needs nothing beside it.
pub fn html(study: &Study) -> String {
    let sections = [
        ("Error against cost", tables::chart(&costs(study))),
        ("The best trade-offs", tables::front(study)),
        ("The best trade-offs on a graphics device", tables::front_on_device(study)),
        ("Space, time and precision", balance(study)),
        ("Energy over time", energies(study)),
        ("Where methods blow up", tables::limits(study)),
        ("The stiffness and damping you get", tables::audit(study)),
        ("All trials", tables::trials(study)),
        ("What was left out", tables::left_out(study)),
        ("How it was measured", tables::reference(study)),
        ("How to read this", tables::glossary()),
    ];
    let filled = sections.iter().filter(|(_, section)| !section.0.is_empty());
    let page = html! {
        (DOCTYPE) "\n"
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (clean(&study.scene)) ": what accuracy costs" }
                style { (PreEscaped(include_str!("report.css"))) (PreEscaped(inks())) }
            }
            "\n"
            body {
                main {
                    (tables::head(study))
                    @for (title, section) in filled {
                        "\n"
                        section { h2 { (title) } "\n" (section) }
                    }
                }
                div #tip hidden {}
                script { (PreEscaped(include_str!("report.js"))) }
            }
        }
    };
    page.into_string()
}

/// The work-precision diagram as a drawing; a point shows its trial where it is pointed at.
pub fn svg(study: &Study) -> String {
    costs(study)
}

/// The work-precision diagram as a picture, PNG.
pub fn png(study: &Study) -> Vec<u8> {
    let height = (f64::from(PICTURE_WIDTH) * figure::HEIGHT / WIDTH).round() as u32;
    let size = (PICTURE_WIDTH, height);
    let pixels = raster::picture(size, |surface| {
        // A picture in memory refuses nothing.
        let drawn = work_precision(study, surface);
        debug_assert!(drawn.is_ok());
    });
    raster::png(size, &pixels)
}

/// One row per trial, CSV.
pub fn csv(study: &Study) -> Vec<u8> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let front = study.front();
    // Memory refuses nothing.
    let _ = table.write_record([
        "integrator",
        "fineness",
        "substeps",
        "tolerance",
        "precision",
        "cpu_seconds_per_second",
        "ms_per_frame",
        "device_ms_per_frame",
        "rms_error_m",
        "relative_error",
        "max_error_m",
        "velocity_error_m_per_s",
        "centre_error_m",
        "energy_error_j",
        "momentum_error_kg_m_per_s",
        "penetration_m",
        "on_front",
        "diverged",
    ]);
    for (row, trial) in study.trials.iter().enumerate() {
        let _ = table.write_record(record(study, trial, front.contains(&row)));
    }
    table.into_inner().unwrap_or_default()
}

fn record(study: &Study, trial: &Trial, on_front: bool) -> [String; 18] {
    let (substeps, tolerance) = match trial.choice.fineness {
        Fineness::Substeps(substeps) => (substeps.to_string(), String::new()),
        Fineness::Tolerance(tolerance) => (String::new(), format!("{tolerance:e}")),
    };
    let cell = |value: f64| format!("{value:e}");
    let error = |of: fn(&msd_study::errors::Errors) -> f64| {
        trial.errors.as_ref().map_or(String::new(), |errors| cell(of(errors)))
    };
    [
        trial.choice.integrator.to_string(),
        trial.choice.fineness(),
        substeps,
        tolerance,
        trial.choice.precision.to_string(),
        cell(trial.cost),
        cell(1e3 * FRAME * trial.cost),
        study.cost_on_device(trial.choice).map_or(String::new(), |cost| cell(1e3 * FRAME * cost)),
        error(|errors| errors.rms),
        trial.errors.map_or(String::new(), |errors| cell(relative(study, errors.rms))),
        error(|errors| errors.max),
        error(|errors| errors.velocity),
        error(|errors| errors.centre),
        error(|errors| errors.energy),
        error(|errors| errors.momentum),
        error(|errors| errors.penetration),
        on_front.to_string(),
        trial.diverged.clone().unwrap_or_default(),
    ]
}

fn costs(study: &Study) -> String {
    let mut spots = Vec::new();
    let label = format!("{}: position error against processor time, on log scales", study.scene);
    let drawing = drawing(figure::HEIGHT, &label, |surface| {
        spots = work_precision(study, surface).unwrap_or_default();
    });
    let front = study.front();
    // The best last, so that nothing hides them from the pointer.
    spots.sort_by_key(|spot| front.contains(&spot.row));
    let targets = html! {
        g.spots fill="none" pointer-events="all" {
            @for spot in &spots { (target(study, spot, front.contains(&spot.row))) "\n" }
        }
    };
    drawing.replacen("</svg>", &(targets.into_string() + "</svg>"), 1)
}

fn energies(study: &Study) -> Markup {
    if study.energies.is_empty() {
        return html! {};
    }
    let label = format!("{}: energy over time", study.scene);
    let drawing = drawing(energy_figure::HEIGHT, &label, |surface| {
        // A drawing in memory refuses nothing.
        let drawn = energy_over_time(study, surface);
        debug_assert!(drawn.is_ok());
    });
    html! {
        (tables::chart(&drawing))
        p.note {
            "Of each method the trial whose error is nearest to the wanted one. Where a line hides "
            "the broad one of the reference, its energy is right; a cross ends a run that diverged."
        }
    }
}

/// The errors of the scene at its own settings side by side, or the estimate of that of space.
fn balance(study: &Study) -> Markup {
    let Some(balance) = &study.balance else {
        return html! { p { (sentence(&study.space_line())) } };
    };
    let label = format!("{}: errors of space, time and precision, on a log scale", study.scene);
    let drawing = drawing(balance_figure::HEIGHT, &label, |surface| {
        // A drawing in memory refuses nothing.
        let drawn = errors_side_by_side(study, balance, surface);
        debug_assert!(drawn.is_ok());
    });
    html! {
        p { (sentence(&balance.advice)) }
        (tables::chart(&drawing))
        (tables::balance(study, balance))
    }
}

/// Draws with plotters and gives the drawing the size of the page.
pub fn drawing(height: f64, label: &str, draw: impl FnOnce(SVGBackend<'_>)) -> String {
    let mut text = String::new();
    let (width, dots) = (WIDTH * DOTS, height * DOTS);
    draw(SVGBackend::with_string(&mut text, (width as u32, dots as u32)));
    let inside = text.split_once('>').map_or("", |(_, inside)| inside);
    let drawing = html! {
        svg
            xmlns="http://www.w3.org/2000/svg"
            width=(WIDTH)
            height=(height)
            viewBox=(format_args!("0 0 {width} {dots}"))
            role="img"
            aria-label=(clean(label))
            stroke-linejoin="round"
            stroke-linecap="round"
        {
            (PreEscaped(inside.trim_end().trim_end_matches("</svg>")))
        }
        "\n"
    };
    drawing.into_string()
}

/// The target of the pointer at a trial.
fn target(study: &Study, spot: &Spot, on_front: bool) -> Markup {
    let trial = &study.trials[spot.row];
    let mut said = trial.choice.to_string();
    if let Some(diverged) = &trial.diverged {
        let _ = write!(said, "\ndiverged: {diverged}");
    } else {
        let error = units::quantity(trial.error(), "m");
        let part = units::percent(relative(study, trial.error()));
        let _ = write!(said, "\nerror {error}, {part} of the size");
    }
    let frame = units::quantity(FRAME * trial.cost, "s");
    let _ = write!(said, "\n{frame} per frame, {} real time", tables::speed(trial.cost));
    if trial.error() < study.reference.uncertainty {
        let known = units::quantity(study.reference.uncertainty, "m");
        let _ = write!(said, "\nthe reference is known to {known} only");
    }
    if on_front {
        said.push_str("\non the Pareto front");
    }
    html! {
        circle
            data-row=(spot.row)
            data-method=(trial.choice.integrator.name())
            cx=(format_args!("{:.0}", DOTS * spot.at.0))
            cy=(format_args!("{:.0}", DOTS * spot.at.1))
            r=(10.0 * DOTS)
        {
            title { (clean(&said)) }
        }
    }
}

/// Styles by the colours of a drawing: those of a dark screen, and one method above the others.
fn inks() -> String {
    let uses = |colour: &str| format!("svg [fill=\"{colour}\"], svg [stroke=\"{colour}\"]");
    let swap = |Ink { light, dark }: Ink| {
        let (light, dark) = (ink::hex(light), ink::hex(dark));
        format!(
            "  svg [fill=\"{light}\"] {{ fill: {dark}; }}\n  \
             svg [stroke=\"{light}\"] {{ stroke: {dark}; }}\n"
        )
    };
    let own = Integrator::ALL.map(|method| [ink::line(method), ink::name(method)]);
    let all = ink::COMMON.iter().chain(own.iter().flatten());
    let mut css = String::from("@media screen and (prefers-color-scheme: dark) {\n");
    all.for_each(|&ink| css.push_str(&swap(ink)));
    css.push_str("}\n");
    for (method, inks) in Integrator::ALL.into_iter().zip(own) {
        let others = own.iter().filter(|&&other| other != inks).flatten();
        let dimmed: Vec<String> = others.map(|other| uses(&ink::hex(other.light))).collect();
        let under = format!("[data-method=\"{method}\"] ");
        let dimmed = dimmed.join(", ").replace("svg ", &format!("svg{under}"));
        let _ = writeln!(css, "{dimmed} {{ opacity: 0.13; }}");
        let Ink { light, dark } = ink::line(method);
        let (light, dark) = (ink::hex(light), ink::hex(dark));
        let _ = writeln!(css, ".{method} {{ color: light-dark({light}, {dark}); }}");
    }
    css
}
