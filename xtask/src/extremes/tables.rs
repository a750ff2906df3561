//! Tables of the results, for a page and for a program.

use crate::extremes::conduct::{Extremes, PRECISIONS, Row};
use crate::extremes::distance::Loss;
use crate::extremes::map::Map;
use crate::extremes::outcome::{Outcome, Verdict};
use msd_core::Integrator;
use msd_report::units;
use std::fmt::Write;

/// The table of hardships: a row each, a column per method.
pub fn hardships(extremes: &Extremes) -> String {
    let names = Integrator::ALL.map(Integrator::name).join(" | ");
    let mut table = format!("| hardship | what is done | {names} |\n|---|---|");
    table += &"---|".repeat(Integrator::ALL.len());
    for row in &extremes.rows {
        // Writing to a string cannot fail.
        let _ = write!(table, "\n| {} | {} |", row.name, row.about);
        for [double, single] in &row.verdicts {
            let (double, single) = (said(row, double), said(row, single));
            let both = if double == single { double } else { format!("{double}; f32: {single}") };
            let _ = write!(table, " {both} |");
        }
    }
    table + "\n"
}

/// A verdict in a few words; of a body that keeps its shape, its strain alone.
fn said(row: &Row, verdict: &Verdict) -> String {
    let kept = verdict.outcome == Outcome::Accurate;
    let error = verdict.error.map(|error| match error {
        error if error < 0.001 => "< 0.1 %".to_owned(),
        error if error < 9.995 => format!("{} %", two_digits(100.0 * error)),
        error if error < 1e4 => format!("{}×", two_digits(error)),
        error => format!("{error:.0e}×"),
    });
    match (error, row.strain) {
        (Some(error), true) if kept => error,
        (Some(error), false) if kept => format!("accurate, {error}"),
        (Some(error), _) => format!("{}, {error}", verdict.outcome.name()),
        (None, _) => verdict.outcome.name().to_owned(),
    }
}

fn two_digits(value: f64) -> String {
    let decimals = if value < 10.0 { 1 } else { 0 };
    format!("{value:.decimals$}")
}

/// Number of cells of the maps by outcome, per method, and the places where theory and maps differ.
pub fn summary(extremes: &Extremes) -> String {
    let told = Outcome::ALL.into_iter().filter(|outcome| !outcome.is_failure());
    let told: Vec<Outcome> = told.collect();
    let mut table = String::from("| method |");
    told.iter().for_each(|outcome| table = format!("{table} {} |", outcome.name()));
    table += " failures |\n|---|";
    table += &"---|".repeat(told.len() + 1);
    for integrator in Integrator::ALL {
        let count =
            |outcome| -> usize { extremes.maps_of(integrator).map(|map| map.count(outcome)).sum() };
        let _ = write!(table, "\n| {integrator} |");
        told.iter().for_each(|&outcome| {
            let _ = write!(table, " {} |", count(outcome));
        });
        let failed: usize =
            Outcome::ALL.into_iter().filter(|outcome| outcome.is_failure()).map(count).sum();
        let _ = write!(table, " {failed} |");
    }
    table + "\n"
}

/// The loss of single precision far from the origin.
pub fn distances(losses: &[Loss]) -> String {
    let mut table =
        "| from the origin, m | steps of f32 there at most, m | f32 | f32, recentred | f64 |\n\
                     |---|---|---|---|---|\n"
            .to_owned();
    for Loss { distance, rounding, single, recentred, double } in losses {
        let _ = writeln!(
            table,
            "| {} | {} | {} | {} | {} |",
            units::number(*distance),
            units::number(*rounding),
            units::number(*single),
            units::number(*recentred),
            units::number(*double)
        );
    }
    table
}

/// Every cell of every map, for a program.
pub fn maps_csv(extremes: &Extremes) -> String {
    let mut table = String::from("map,method,precision,value,step,limit,outcome,error\n");
    for map in &extremes.maps {
        let Map { across, integrator, precision, values, steps, limits, cells } = map;
        for (index, cell) in cells.iter().enumerate() {
            let column = index % values.len();
            let _ = writeln!(
                table,
                "{},{integrator},{precision},{:e},{:e},{:e},{:?},{}",
                across.name(),
                values[column],
                steps[index / values.len()],
                limits[column],
                cell.outcome,
                number(cell.error)
            );
        }
    }
    table
}

/// The table of hardships for a program.
pub fn hardships_csv(extremes: &Extremes) -> String {
    let mut table = String::from("hardship,method,precision,outcome,error\n");
    for row in &extremes.rows {
        for (verdicts, integrator) in row.verdicts.iter().zip(Integrator::ALL) {
            for (verdict, precision) in verdicts.iter().zip(PRECISIONS) {
                let _ = writeln!(
                    table,
                    "{},{integrator},{precision},{:?},{}",
                    row.name,
                    verdict.outcome,
                    number(verdict.error)
                );
            }
        }
    }
    table
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| format!("{value:e}"))
}
