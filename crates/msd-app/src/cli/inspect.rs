//! `msd inspect`: mechanical properties of the bodies of a scene.

use super::arguments::InspectArguments;
use super::failure::{Failure, say, say_json};
use super::run::open_scene;
use super::steps::SlowNotice;
use msd_scene::{set_keys, shown_path, tame};
use msd_study::inspection::{Directions, InspectReport, Inspection, Touching, TouchingWith};
use msd_study::quantity::{counted, number, quantity, rounded};

/// Inspects a scene in its initial state.
pub fn run_inspect(arguments: &InspectArguments) -> Result<(), Failure> {
    let loaded = open_scene(&arguments.scene, &arguments.set.set)?;
    let refused = |error| Failure::input(format!("{}: {error}", shown_path(&arguments.scene)));
    let notice = SlowNotice::new("computing the slowest modes of the bodies".to_owned());
    let report = InspectReport::new(&loaded, set_keys(&arguments.set.set)).map_err(refused)?;
    drop(notice);
    if arguments.json {
        return say_json(&report);
    }
    let asked: Vec<_> = loaded.made.iter().map(|made| made.and_then(|made| made.young)).collect();
    say(&text(&report, &asked))
}

/// Returns the text on all bodies; `asked` holds their given Young's moduli, pascals.
fn text(report: &InspectReport, asked: &[Option<f64>]) -> String {
    let asked = asked.iter().copied().chain(core::iter::repeat(None));
    let bodies = report.bodies.iter().zip(asked);
    let mut lines: Vec<String> = bodies.flat_map(|(body, asked)| body_lines(body, asked)).collect();
    let limit = match report.stable_step {
        f64::INFINITY => "any substep is stable".to_owned(),
        limit => format!("substeps are stable up to {}", quantity(limit, "s")),
    };
    lines.push(format!("{}: {limit} with {}", report.scene, report.integrator));
    lines.extend(report.notes.iter().cloned());
    lines.join("\n")
}

/// Returns the lines on a body; `asked` is its given Young's modulus, pascals.
fn body_lines(body: &Inspection, asked: Option<f64>) -> Vec<String> {
    let Inspection { name, particles, springs, mass, .. } = body;
    let springs = counted(*springs as u64, "spring");
    let mut lines =
        vec![format!("{}: {particles} particles, {springs}, {} kg", tame(name), number(*mass))];
    if let Some(filled) = body.filled {
        let (noun, unit, modulus, count) = match filled.dimensions {
            1 => ("length", "m", "N", 2),
            2 => ("area", "m²", "N/m", 8),
            _ => ("volume", "m³", "Pa", 26),
        };
        let size = number(filled.size);
        let density = number(mass / filled.size);
        lines.push(format!("  {noun} {size} {unit}, density {density} kg/{unit}"));
        if let Some(moduli) = &body.moduli {
            lines.extend(moduli_lines(moduli, (modulus, count)));
        }
        lines.extend(body.pulled.map(|range| pulled_line(range, asked)));
        if let Some(stiffness) = body.bending {
            let unit = if filled.dimensions == 1 { "N m²" } else { "N m" };
            lines.push(format!("  bending stiffness {} {unit}", range(stiffness)));
        }
    }
    if body.is_open {
        lines.push("  its volume is unknown: its surface has holes".into());
    }
    // In the unit of the slowest modes.
    lines.push(format!("  fastest mode {} Hz", number(body.fastest)));
    if let Some(first) = body.slowest.first() {
        let frequencies = body.slowest.iter().map(|slow| rounded(slow.frequency, 3));
        let frequencies: Vec<String> = frequencies.collect();
        let damping = match first.damping_ratio {
            0.0 => String::new(),
            ratio => {
                let which = if body.slowest.len() == 1 { "" } else { "the first " };
                format!(", {which}with a damping ratio of {}", rounded(ratio, 2))
            }
        };
        let noun = if body.slowest.len() == 1 { "mode" } else { "modes" };
        lines.push(format!("  slowest {noun} {} Hz{damping}", frequencies.join(", ")));
    }
    lines.extend(body.slowest_unknown.map(|why| format!("  its slowest modes {why}")));
    lines.extend(body.touch.iter().flat_map(touch_lines));
    lines
}

/// Returns the line on the stiffness of an irregular solid that is pulled at its surface.
fn pulled_line([least, most]: [f64; 2], asked: Option<f64>) -> String {
    let off = asked.map(|young| {
        let [least, most] = [least, most].map(|modulus| 100.0 * (modulus / young - 1.0));
        format!(": {least:+.1} % to {most:+.1} % off the `young` given")
    });
    format!(
        "  pulled at its surface {} to {} Pa, a ratio of {}{}",
        number(least),
        number(most),
        number(most / least),
        off.unwrap_or_default()
    )
}

/// Returns the lines on the contact of a body with others.
fn touch_lines(touch: &Touching) -> Vec<String> {
    let Touching { thickness, friction, restitution, itself, obstacles, ignore, with } = touch;
    let [thickness, friction, restitution] =
        [thickness, friction, restitution].map(|&it| number(it));
    let whom = if *itself { "itself and others" } else { "others" };
    let mut lines = vec![format!(
        "  collides with {whom}: thickness {thickness} m, friction {friction}, restitution \
         {restitution}"
    )];
    lines.extend(obstacles.then(|| "  collides with obstacles at its thickness".to_owned()));
    lines.extend(with.iter().map(|TouchingWith { body, friction, restitution }| {
        let own = [("friction", friction), ("restitution", restitution)];
        let said =
            own.iter().filter_map(|(key, value)| Some(format!("{key} {}", number((**value)?))));
        format!("  collides with {}: {}", tame(body), said.collect::<Vec<_>>().join(", "))
    }));
    let ignored: Vec<String> = ignore.iter().map(|body| tame(body).to_string()).collect();
    lines.extend((!ignored.is_empty()).then(|| format!("  passes through {}", ignored.join(", "))));
    lines
}

/// Returns the lines on moduli in a unit, along `count` directions.
fn moduli_lines(moduli: &Directions, (unit, count): (&str, u32)) -> Vec<String> {
    let quantity = match unit {
        "N" => "Young's modulus times cross-section",
        "N/m" => "Young's modulus times thickness",
        _ => "Young's modulus",
    };
    let young = range(moduli.range());
    let ratio = match number(moduli.anisotropy).as_str() {
        "1" => String::new(),
        ratio => format!(", a ratio of {ratio}"),
    };
    let young = format!("  {quantity} {young} {unit} in {count} directions{ratio}");
    let poisson = moduli.poisson.map(|ratios| format!("  Poisson's ratio {}", range(ratios)));
    [Some(young), poisson].into_iter().flatten().collect()
}

/// Formats the bounds of a range, or one number if both print alike.
fn range(bounds: [f64; 2]) -> String {
    let [least, most] = bounds.map(number);
    if least == most { least } else { format!("{least} to {most}") }
}
