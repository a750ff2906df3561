//! The energy: a bar of its parts, the plot, and the energy errors.

use super::axes::plot_over_time;
use super::{heading, theme};
use crate::session::{Sample, Session, TRACE_WINDOW as WINDOW};
use crate::viewer::Viewer;
use egui::{Color32, Rect, RichText, Sense, Ui, pos2, vec2};
use egui_plot::{Line, PlotPoints};
use msd_core::Energy;
use msd_study::quantity::{estimate, rounded};

/// A curve: name, colour, and value.
type Curve = (&'static str, Color32, fn(&Energy) -> f64);

const CURVES: [Curve; 6] = [
    ("kinetic", Color32::from_rgb(90, 160, 240), |energy| energy.kinetic),
    ("elastic", Color32::from_rgb(110, 196, 132), |energy| energy.elastic),
    ("gravity", Color32::from_rgb(180, 140, 230), |energy| energy.gravitational),
    ("dissipated", Color32::from_rgb(240, 150, 90), |energy| energy.dissipated),
    ("supplied", Color32::from_rgb(240, 170, 200), |energy| energy.supplied),
    ("total", Color32::from_rgb(225, 228, 235), Energy::total),
];
/// Share of the maximum energy below which the energy added by contact is rounding.
const NOISE: f64 = 1e-6;
/// Colour of the energy added by contact.
const CONTACT: Color32 = Color32::from_rgb(250, 205, 90);

/// Returns the curves of a run, with supplied energy only if solids, wind or elements supply any.
fn curves(session: &Session) -> impl Iterator<Item = Curve> {
    let is_driven = session.trace().samples().any(|sample| sample.energy.supplied != 0.0);
    CURVES.into_iter().filter(move |&(name, ..)| is_driven || name != "supplied")
}

/// Shows the bar, the plot and its legend with the current values.
pub(super) fn show(ui: &mut Ui, viewer: &Viewer) {
    heading(ui, "Energy");
    let session = &viewer.session;
    let trace = session.trace();
    let largest = trace.samples().map(magnitude).fold(0.0, f64::max);
    let (unit, scale) = unit(largest);
    bar(ui, session);
    plot(ui, session, (unit, scale));
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (name, colour, value) in curves(session) {
            // A no-break space keeps a name and its number together.
            let value = session.energy().map(|energy| short(value(&energy) / scale));
            // A graphics device does not measure what it dissipates.
            let value = value.map(|text| text.replace("NaN", "not measured"));
            let text = format!("{name}\u{a0}{}", value.as_deref().unwrap_or(theme::VOID));
            let label = ui.label(RichText::new(text).small().color(colour));
            if name == "supplied" {
                label.on_hover_text("Work of moving solids, wind and user-defined elements");
            }
        }
        ui.label(RichText::new(format!("in {unit}")).small().color(theme::FAINT));
    });
    errors(ui, session);
}

/// Shows the energy errors of the method and of contact.
fn errors(ui: &mut Ui, session: &Session) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let text = format!("energy error\u{a0}{}", imbalance(session));
        let hover = "Change of the total energy since the run was last changed or grabbed: the \
                     error of the method and its contacts";
        ui.label(RichText::new(text).small().color(theme::TEXT)).on_hover_text(hover);
        let told = NOISE * session.trace().most();
        if let Some(added) = session.energy_of_contact().filter(|&added| told < added) {
            let text = format!("contact error\u{a0}{}", estimate(added, "J"));
            let hover = "Energy error of contact since the last change of the run; dissipation \
                         offsets it. More substeps reduce it";
            ui.label(RichText::new(text).small().color(CONTACT)).on_hover_text(hover);
        }
    });
}

/// The energy error of the method in words. A graphics device does not measure it.
pub(super) fn imbalance(session: &Session) -> String {
    match (session.energy_imbalance(), session.energy()) {
        (Some(change), _) => estimate(change, "J"),
        (None, Some(_)) => "not measured".to_owned(),
        (None, None) => theme::VOID.to_owned(),
    }
}

fn plot(ui: &mut Ui, session: &Session, (unit, scale): (&'static str, f64)) {
    let (now, trace) = (session.runner().time(), session.trace());
    let height = (ui.available_height() - 72.0).clamp(64.0, 220.0);
    plot_over_time("energy", |value| format!("{} {unit}", rounded(value, 3)))
        .height(height)
        .default_x_bounds((now - WINDOW).max(0.0), now.max(WINDOW))
        .show(ui, |plot| {
            for (name, colour, value) in curves(session) {
                let point = |sample: &Sample| [sample.time, value(&sample.energy) / scale];
                let is_known = |point: &[f64; 2]| !point[1].is_nan();
                let points: PlotPoints<'_> = trace.samples().map(point).filter(is_known).collect();
                plot.line(Line::new(name, points).color(colour).width(1.5));
            }
            plot.set_plot_bounds_x((now - WINDOW).max(0.0)..=now.max(WINDOW));
        });
}

/// A part of the bar: name, colour, and energy, joules.
type Part = (&'static str, Color32, f64);

/// Returns the parts of the bar: gravity above its minimum, dissipation since the start of the
/// plot, and the energy errors.
fn parts(session: &Session) -> Option<Vec<Part>> {
    let held = session.trace().held(session.energy()?);
    let held = Energy { dissipated: known(held.dissipated), ..held };
    let [kinetic, elastic, gravity, dissipated, ..] =
        CURVES.map(|(name, colour, value)| (name, colour, value(&held)));
    let imbalance = session.energy_imbalance().unwrap_or(0.0);
    let method = ("error of the method", theme::BAD, imbalance.max(0.0));
    let contact = ("error of contact", CONTACT, session.energy_of_contact()?);
    Some(vec![kinetic, elastic, gravity, dissipated, contact, method])
}

/// Returns start and end of the parts as shares of a bar that is full at `most` joules. They stand
/// side by side; the energy errors are included in the others and cover their end.
///
/// Not as shares of the current energy: a body at rest has little left, so that earlier errors
/// would fill the bar.
fn shares(parts: &[Part], most: f64) -> Vec<[f64; 2]> {
    let share = |part: &Part| (part.2 / most).clamp(0.0, 1.0);
    let (held, wrong) = parts.split_at(4);
    let mut left = 0.0;
    let mut shares = Vec::with_capacity(parts.len());
    for part in held {
        let right = f64::min(left + share(part), 1.0);
        shares.push([left, right]);
        left = right;
    }
    let mut left = (left - wrong.iter().map(share).sum::<f64>()).max(0.0);
    for part in wrong {
        let right = f64::min(left + share(part), 1.0);
        shares.push([left, right]);
        left = right;
    }
    shares
}

/// Draws the parts in a bar that is full at the maximum energy of the run.
fn bar(ui: &mut Ui, session: &Session) {
    let (whole, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), 14.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(whole, 2.0, theme::FIELD);
    let Some(parts) = parts(session) else { return };
    let most = session.trace().most();
    if !(most.is_finite() && 0.0 < most) {
        return;
    }
    for (row, (part, share)) in parts.iter().zip(shares(&parts, most)).enumerate() {
        let [left, right] = share.map(|share| whole.left() + whole.width() * share as f32);
        let top = if row < 4 { whole.top() } else { whole.center().y };
        let rect = Rect::from_min_max(pos2(left, top), pos2(right, whole.bottom()));
        painter.rect_filled(rect, 0.0, part.1);
    }
    response.on_hover_ui(|ui| {
        ui.label("Gravity above its minimum; dissipation since the start of the plot");
        for (name, colour, joules) in parts {
            let text = format!("{name}: {}", estimate(joules, "J"));
            ui.label(RichText::new(text).color(colour));
        }
        ui.label(format!("Full scale = maximum of this run: {}", estimate(most, "J")));
    });
}

/// Formats a value with fixed decimals, so that the legend does not move during a run.
fn short(value: f64) -> String {
    if value.abs() < 1e5 { format!("{value:.1}") } else { format!("{value:.1e}") }
}

fn magnitude(sample: &Sample) -> f64 {
    CURVES.iter().map(|(_, _, value)| known(value(&sample.energy)).abs()).fold(0.0, f64::max)
}

/// An energy, joules; 0 where it is not measured.
fn known(joules: f64) -> f64 {
    if joules.is_nan() { 0.0 } else { joules }
}

/// Returns the unit in which a value has at most four integer digits, and its size in joules.
fn unit(largest: f64) -> (&'static str, f64) {
    let units = [("mJ", 1e-3), ("J", 1.0), ("kJ", 1e3), ("MJ", 1e6), ("GJ", 1e9)];
    let fits = |&&(_, scale): &&(&str, f64)| largest < 2e3 * scale;
    *units.iter().find(fits).unwrap_or(&("TJ", 1e12))
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_study::choice::FRAME;

    #[test]
    fn the_unit_keeps_numbers_short() {
        assert_eq!(unit(0.3).0, "mJ");
        assert_eq!(unit(1500.0).0, "J");
        assert_eq!(unit(98_200.0).0, "kJ");
        assert_eq!(unit(f64::INFINITY).0, "TJ");
    }

    #[test]
    fn the_parts_of_the_bar_are_the_energy_and_none_is_negative() {
        let loaded = msd_scene::open("mattress").expect("a built-in scene");
        let mut session = Session::new(loaded).expect("a valid scene");
        session.advance(0.0, &|| 0.0);
        let first = session.energy().expect("read at the start");
        let lowest = |session: &Session| {
            let now = session.energy().expect("read").gravitational;
            let heights = session.trace().samples().map(|sample| sample.energy.gravitational);
            heights.fold(now, f64::min)
        };
        for _ in 0..180 {
            session.advance(FRAME + 1e-9, &|| 0.0);
            let parts = parts(&session).expect("read in every frame");
            assert!(parts.iter().all(|part| 0.0 <= part.2), "{parts:?}");
            let held: f64 = parts[..4].iter().map(|part| part.2).sum();
            let total = session.energy().expect("read").total() - first.dissipated;
            // The sums differ in their order.
            let off = (held + lowest(&session) - total).abs();
            assert!(off <= 1e-9 * total.abs().max(held), "{held} {total}");
        }
        // A fall onto the ground takes energy away.
        assert!(0.0 < parts(&session).expect("read")[3].2);
    }

    #[test]
    fn what_was_added_by_error_is_a_share_of_the_most_there_was() {
        let colour = Color32::WHITE;
        let joules = |joules: [f64; 6]| joules.map(|joules| ("", colour, joules));
        // In motion: over the end of the others.
        let moving = shares(&joules([30.0, 20.0, 10.0, 20.0, 4.0, 6.0]), 100.0);
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
        assert!(near(moving[3], [0.6, 0.8]), "{moving:?}");
        assert!(near(moving[4], [0.7, 0.74]) && near(moving[5], [0.74, 0.8]), "{moving:?}");
        // At rest, with less left than the errors: as wide as in motion, not the whole bar.
        let resting = shares(&joules([1e-9, 0.0, 0.0, 0.0, 4.0, 6.0]), 100.0);
        assert!(near(resting[4], [0.0, 0.04]) && near(resting[5], [0.04, 0.1]), "{resting:?}");
        // Nor do they leave the bar if there is more than the previous maximum.
        let beyond = shares(&joules([60.0, 60.0, 0.0, 0.0, 80.0, 900.0]), 100.0);
        assert!(beyond.iter().flatten().all(|share| (0.0..=1.0).contains(share)), "{beyond:?}");
    }

    #[test]
    fn a_body_at_rest_has_no_bar_full_of_red() {
        let loaded = msd_scene::open("mattress").expect("a built-in scene");
        let mut session = Session::new(loaded).expect("a valid scene");
        session.advance(0.0, &|| 0.0);
        // It falls for a second; later the plot contains only the rest.
        for _ in 0..60 * 20 {
            session.advance(FRAME + 1e-9, &|| 0.0);
        }
        let parts = parts(&session).expect("read in every frame");
        let (held, wrong) = parts.split_at(4);
        let sum = |parts: &[Part]| parts.iter().map(|part| part.2).sum::<f64>();
        assert!(sum(held) < 0.1 * session.trace().most(), "it rests: {held:?}");
        let red: f64 = shares(&parts, session.trace().most())[4..]
            .iter()
            .map(|[left, right]| right - left)
            .sum();
        assert!(red < 0.02, "{wrong:?} of {}", session.trace().most());
    }
}
