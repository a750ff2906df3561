//! The trade-off between accuracy and cost: diagram, choice of a setting, and model terms.

mod diagram;
mod parts;

use super::{heading, theme};
use crate::session::{
    Report, STUDY_DURATION, STUDY_MANNERS, Search, Session, StudyFrom, choice_of,
};
use crate::viewer::{Layout, Viewer};
use egui::{Button, DragValue, Panel, Rect, RichText, ScrollArea, Slider, Ui, vec2};
use msd_study::Study;
use msd_study::choice::{Choice, FRAME};
use msd_study::quantity::{estimate, rounded};
use msd_study::tune::Goal;
use msd_study::words::{off, sources, told};
use std::time::Duration;

/// Height of the panel, points.
const HEIGHT: f32 = 236.0;
/// Width of the controls and of the model terms, points.
const SIDE: f32 = 226.0;
/// Width of a scroll bar, points.
const BAR: f32 = 10.0;
/// Least width of the diagram between them, points.
const DIAGRAM: f32 = 180.0;
/// Interval between checks for new points, seconds.
const LOOK: f64 = 0.2;

/// Shows the button that opens the panel.
pub(super) fn switch(ui: &mut Ui, viewer: &mut Viewer) {
    let mut on = viewer.session.trade().is_on();
    let button = Button::new("Accuracy vs. cost").selected(on);
    let hover = "Measures accuracy against cost for this scene, in the background; choose a \
                 setting from the result";
    let button = ui.add(button).on_hover_text(hover);
    viewer.layout.landmarks.insert("trade", button.rect);
    if button.clicked() {
        on = !on;
        viewer.session.set_trading(on);
    }
}

/// Shows the panel, if it is open.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer, frame: egui::Frame) {
    if !viewer.session.trade().is_on() {
        return;
    }
    let panel = Panel::bottom("trade").resizable(false).exact_size(HEIGHT).frame(frame);
    panel.show(ui, |ui| {
        let width = ui.available_width();
        let rest = width - 2.0 * SIDE - 24.0;
        if rest < DIAGRAM {
            // One below the other: side by side, the last one would leave the window.
            return column(ui, "trade", width, |ui| stacked(ui, viewer));
        }
        ui.ctx().request_repaint_after(Duration::from_secs_f64(LOOK));
        let report = viewer.session.study();
        ui.horizontal_top(|ui| {
            column(ui, "choices", SIDE, |ui| choices(ui, viewer, report.as_ref()));
            figure(ui, rest, viewer, report.as_ref());
            column(ui, "parts", SIDE, |ui| parts::show(ui, &mut viewer.session));
        });
    });
}

/// Shows the contents of the panel, one below the other, if it is open.
pub(super) fn stacked(ui: &mut Ui, viewer: &mut Viewer) {
    if viewer.session.trade().is_on() {
        ui.ctx().request_repaint_after(Duration::from_secs_f64(LOOK));
        let report = viewer.session.study();
        choices(ui, viewer, report.as_ref());
        figure(ui, ui.available_width(), viewer, report.as_ref());
        parts::show(ui, &mut viewer.session);
    }
}

fn figure(ui: &mut Ui, width: f32, viewer: &Viewer, report: Option<&Report<Study>>) {
    ui.allocate_ui(vec2(width, HEIGHT - 20.0), |ui| {
        let study = report.and_then(|report| report.found.as_deref());
        diagram::show(ui, study, choice_of(viewer.session.runner()));
    });
}

fn column(ui: &mut Ui, name: &str, width: f32, contents: impl FnOnce(&mut Ui)) {
    ui.allocate_ui(vec2(width, HEIGHT - 20.0), |ui| {
        ui.set_width(width);
        // The scroll bar beside the contents, not over them.
        ui.spacing_mut().scroll.floating_allocated_width = BAR;
        let area = ScrollArea::vertical().id_salt(name).auto_shrink([false, false]);
        crate::panel::scroll(ui, area, |ui| ui.vertical(contents));
    });
}

/// Shows the subject of the study, and the ways to choose.
fn choices(ui: &mut Ui, viewer: &mut Viewer, report: Option<&Report<Study>>) {
    heading(ui, "Trade-off");
    let Viewer { session, layout: Layout { landmarks, .. }, .. } = viewer;
    landmarks.insert("rest", origin(ui, session));
    let progress = progress(session, report);
    let Some(study) = report.and_then(|report| report.found.as_deref()) else {
        return small(ui, &progress, theme::FAINT);
    };
    let wish = along_the_front(ui, session, study).and_then(|(slider, wish)| {
        landmarks.insert("fast to accurate", slider);
        wish
    });
    let (field, stop) = within(ui, session, study);
    landmarks.insert("within", field);
    landmarks.remove("stop");
    landmarks.extend(stop.map(|button| ("stop", button)));
    small(ui, &present(session, study), theme::TEXT);
    if let Some(text) = session.adopted() {
        small(ui, &format!("changed: {text}"), theme::WARN);
    }
    if let Some(why) = session.fault_of_adopted() {
        small(ui, &format!("unstable from the state in which it was chosen: {why}"), theme::BAD);
    }
    // Below the controls, which must not move with the number of lines.
    small(ui, &progress, theme::FAINT);
    for line in caveats(study) {
        small(ui, &line, theme::FAINT);
    }
    diagram::legend(ui, study);
    if let Some(choice) = wish {
        session.adopt(choice);
    }
}

fn small(ui: &mut Ui, text: &str, colour: egui::Color32) {
    ui.label(RichText::new(text).small().color(colour));
}

/// Shows the start of the study, and the pause button; returns the place of that button.
fn origin(ui: &mut Ui, session: &mut Session) -> Rect {
    let row = ui.horizontal(|ui| {
        let from = session.trade().from();
        let hover = "Study the scene from its initial state, with the current material, world, \
                     pins and cuts";
        if ui
            .selectable_label(from == StudyFrom::Start, "from start")
            .on_hover_text(hover)
            .clicked()
        {
            session.study_from(StudyFrom::Start);
        }
        let hover = "Re-run the study from the current state";
        if ui.selectable_label(from == StudyFrom::Here, "from here").on_hover_text(hover).clicked()
        {
            session.study_from(StudyFrom::Here);
        }
        let is_paused = session.trade().is_paused();
        // Another name than that of the button that pauses the run.
        let (text, name) =
            if is_paused { ("Resume", "Resume the study") } else { ("Pause", "Pause the study") };
        let button = ui.add(Button::new(text).small()).on_hover_text(STUDY_MANNERS);
        ui.ctx().accesskit_node_builder(button.id, |node| node.set_label(name));
        if button.clicked() {
            session.set_study_paused(!is_paused);
        }
        button.rect
    });
    row.inner
}

/// Describes the progress of the study.
fn progress(session: &Session, report: Option<&Report<Study>>) -> String {
    let trade = session.trade();
    let Some(report) = report else { return "waiting until you stop editing…".into() };
    let span = format!(
        "{} s from t = {} s",
        rounded(STUDY_DURATION, 2),
        rounded(trade.start().unwrap_or_default(), 3)
    );
    if let Some(failure) = &report.failure {
        return format!("{span}: cannot be studied: {failure}");
    }
    let points = report.found.as_ref().map_or(0, |study| study.trials.len());
    match &report.progress {
        _ if report.idle => format!("{span}: done, {points} settings measured"),
        _ if trade.is_paused() => format!("{span}: paused, {points} settings measured"),
        Some(progress) => {
            format!("{span}: {points} settings measured, {}", progress.words())
        }
        None => format!("{span}: starting"),
    }
}

/// Shows the slider along the Pareto front; returns its place, and the chosen setting.
fn along_the_front(
    ui: &mut Ui,
    session: &Session,
    study: &Study,
) -> Option<(Rect, Option<Choice>)> {
    let front = study.front();
    let last = front.len().checked_sub(1)?;
    let mut place = place_on(study, &front, choice_of(session.runner()));
    let name = ui.label("fast – accurate");
    ui.spacing_mut().slider_width = ui.available_width() - 8.0;
    let widget = Slider::new(&mut place, 0..=last).show_value(false);
    let hover = "Moves along the Pareto front: sets method, substeps and precision";
    let response = ui.add(widget).labelled_by(name.id).on_hover_text(hover);
    let chosen = study.trials[front[place]].choice;
    // A setting off the front is shown at a nearby place, and the user may want the one there.
    let is_meant = response.changed() || response.drag_stopped();
    let is_new = Some(chosen) != choice_of(session.runner());
    Some((response.rect, (is_meant && is_new).then_some(chosen)))
}

/// Returns the place of a choice on the front, or of the cheapest one with at most its error; 0 if
/// it was not measured.
fn place_on(study: &Study, front: &[usize], now: Option<Choice>) -> usize {
    let trial = now.and_then(|now| study.trials.iter().find(|trial| trial.choice == now));
    let Some(trial) = trial else { return 0 };
    let own = front.iter().position(|&row| study.trials[row].choice == trial.choice);
    let as_good = || front.iter().position(|&row| study.trials[row].error() <= trial.error());
    own.or_else(as_good).unwrap_or(front.len() - 1)
}

/// Shows the fields that search by error or by cost, and the result. Returns the places of the
/// first field and of the stop button.
fn within(ui: &mut Ui, session: &mut Session, study: &Study) -> (Rect, Option<Rect>) {
    let memory = egui::Id::unique("within");
    // The values in the fields, and whether a search for them is due.
    type Fields = ([f64; 2], [bool; 2]);
    let known = ui.data(|data| data.get_temp::<Fields>(memory));
    let begin = || ([1e3 * study.wanted, 1e3 * FRAME / 4.0], [false; 2]);
    let (mut fields, mut changed) = known.unwrap_or_else(begin);
    let (mut places, mut stop) = ([Rect::NOTHING; 2], None);
    ui.horizontal(|ui| {
        let units = [" mm", " ms"];
        for (row, (label, unit)) in ["within", "or in"].into_iter().zip(units).enumerate() {
            let name = ui.label(label);
            let speed = 0.02 * fields[row].max(1e-6);
            let widget = DragValue::new(&mut fields[row]).range(1e-9..=1e9).speed(speed);
            let widget = widget.custom_formatter(|value, _| rounded(value, 3)).suffix(unit);
            // Esc restores the value of the field.
            let widget = widget.update_while_editing(false);
            let hover = [
                "Finds the cheapest setting below this error, like msd tune, tries it from the \
                 current state, and applies it",
                "Finds the most accurate setting within this time per frame, like msd tune, \
                 tries it from the current state, and applies it",
            ][row];
            let response = ui.add(widget).labelled_by(name.id).on_hover_text(hover);
            places[row] = response.rect;
            changed[row] |= response.changed();
            // Not during a drag or while the user types.
            let is_done = !response.dragged() && !response.has_focus();
            if changed[row] && is_done {
                changed[row] = false;
                let value = 1e-3 * fields[row];
                session.search([Goal::MaxError(value), Goal::Budget(value)][row]);
            }
        }
        if session.searched().is_some_and(Search::is_busy) {
            let hover = "Stops the search without a change";
            let button = ui.add(Button::new("Stop").small()).on_hover_text(hover);
            stop = Some(button.rect);
            if button.clicked() {
                session.end_search();
            }
        }
    });
    ui.data_mut(|data| data.insert_temp(memory, (fields, changed)));
    if let Some(search) = session.searched() {
        small(ui, &search.words(), theme::TEXT);
    }
    (places[0], stop)
}

/// Compares the current setting with the measurements.
fn present(session: &Session, study: &Study) -> String {
    let Some(now) = choice_of(session.runner()) else {
        return "current setting not comparable: different step or Newton iterations".into();
    };
    let Some(trial) = study.trials.iter().find(|trial| trial.choice == now) else {
        return format!("current: {now}: being measured{}", theme::VOID);
    };
    match &trial.diverged {
        Some(why) => format!("current: {now}: {why}"),
        None => format!(
            "current: {}: {}, {} per frame",
            told(trial),
            off(study, trial),
            estimate(trial.cost * FRAME, "s")
        ),
    }
}

/// Returns the limitations of a study.
fn caveats(study: &Study) -> Vec<String> {
    let mut lines = Vec::new();
    let until = study.reference.reliable_until;
    if until < study.duration - 1e-9 {
        let text = "particles are compared up to {} s only: chaotic after that";
        lines.push(text.replace("{}", &rounded(until, 2)));
    }
    lines.extend(sources(study));
    lines.extend(study.left_out.iter().find(|line| line.contains("tangential_loss")).cloned());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Integrator;
    use msd_scene::schema::SolverRow;

    #[test]
    fn the_label_of_every_method_has_a_colour_of_its_own() {
        let colours = Integrator::ALL.map(diagram::colour);
        for (row, colour) in colours.iter().enumerate() {
            assert!(!colours[..row].contains(colour), "{}", Integrator::ALL[row]);
        }
    }

    #[test]
    fn what_is_not_measured_has_no_place() {
        let loaded = msd_scene::open("chain").expect("a built-in scene");
        let mut session = Session::new(loaded).expect("a valid scene");
        session.tune(SolverRow::integrator(Integrator::BackwardEuler));
        assert!(choice_of(session.runner()).is_some());
        session.tune(SolverRow::newton(3));
        assert_eq!(choice_of(session.runner()), None);
    }
}
