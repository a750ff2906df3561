//! The title of the scene and the transport controls: pause, steps, restart, speed, recording.

use crate::viewer::{Command, Viewer};
use egui::{Button, ComboBox, Label, RichText, Ui};

/// Available speeds, simulated seconds per second: they change the rate of steps, not the steps.
const SPEEDS: [(f64, &str); 9] = [
    (f64::INFINITY, "max"),
    (4.0, "4"),
    (2.0, "2"),
    (1.0, "1"),
    (0.5, "1/2"),
    (0.25, "1/4"),
    (0.1, "1/10"),
    (0.03, "1/33"),
    (0.01, "1/100"),
];

/// Shows the title of the scene and the transport controls.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        let loaded = viewer.session.loaded();
        ui.heading(&*loaded.name);
        ui.add(Label::new(RichText::new(&*loaded.title).small().weak()).truncate());
    });
    if !viewer.layout.in_page {
        transport(ui, viewer);
    }
    speed(ui, viewer);
    recording(ui, viewer);
}

/// Shows pause, steps and restart; on an embedded page its own bar and the timeline replace these.
fn transport(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y.max(26.0);
        let paused = viewer.session.is_paused();
        let text = if paused { "Run" } else { "Pause" };
        let pause = Button::new(text).min_size(egui::vec2(70.0, height)).selected(paused);
        let pause = ui.add(pause).on_hover_text("Space");
        viewer.layout.landmarks.insert("pause", pause.rect);
        if pause.clicked() {
            viewer.command(Command::TogglePause);
        }
        let small = |text| Button::new(text).min_size(egui::vec2(54.0, height));
        let can_go_back = 0 < viewer.session.steps_back();
        let back = ui.add_enabled(can_go_back, small("Back")).on_hover_text("One step back (,)");
        if back.clicked() {
            viewer.command(Command::StepBack);
        }
        if ui.add(small("Step")).on_hover_text("One step forward (.)").clicked() {
            viewer.command(Command::StepForward);
        }
        if ui.add(small("Restart")).on_hover_text("R").clicked() {
            viewer.command(Command::Restart);
        }
    });
}

fn recording(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        let name = viewer.session.recording().map(str::to_owned);
        let text = if name.is_some() { "End recording" } else { "Record" };
        let button = ui.add(Button::new(text).selected(name.is_some()));
        let button = button.on_hover_text("Record the run and all user input to a file (F9)");
        if button.clicked() {
            viewer.command(Command::Record);
        }
        match name {
            Some(name) => _ = ui.add(Label::new(RichText::new(name).weak()).truncate()),
            None => super::twin::begin(ui, viewer),
        }
    });
}

fn speed(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        let name = super::left_label(ui, "Speed");
        let now = viewer.session.speed();
        let text = SPEEDS.iter().find(|(speed, _)| *speed == now).map_or("?", |(_, text)| text);
        let combo = ComboBox::from_id_salt("speed").width(60.0).selected_text(text);
        let shown = combo.show_ui(ui, |ui| {
            for (speed, text) in SPEEDS {
                if super::listed(ui, speed == now, text).clicked() {
                    viewer.session.set_speed(speed);
                }
            }
        });
        shown
            .response
            .labelled_by(name.id)
            .on_hover_text("Fewer or more steps per second, same steps; max: as fast as possible");
        ui.label(RichText::new("× real time").weak());
    });
}
