//! Looks of bodies: finish, colours, pattern.

use super::change;
use crate::panel::{heading, left_label, listed, slider};
use crate::session::{LookEdit, LookValues};
use crate::viewer::Viewer;
use egui::{Button, Color32, ComboBox, Popup, PopupCloseBehavior, Response, Slider, Ui};
use msd_core::Pattern;
use msd_render::colour::PALETTE;
use msd_render::{back_colour, body_colour};
use msd_run::on;
use msd_scene::schema::Finish;

/// Shows the controls for the look of the selected bodies, if they are open.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let Some(now) = viewer.session.look_values().filter(|_| viewer.layout.looks) else { return };
    heading(ui, "Look");
    let mut edits = Vec::new();
    if now.has_surface {
        let text = now.finish.map_or("custom", Finish::name);
        let names = Finish::ALL.map(|finish| (finish, finish.name()));
        let (response, finish) = choice(ui, ("Finish", text), &names, now.finish);
        viewer.layout.landmarks.insert("finish", response.rect);
        edits.extend(finish.map(LookEdit::Finish));
    }
    edits.extend(colours(ui, viewer, &now));
    if now.has_surface {
        let roughness =
            change(ui, ("Roughness", "bodies.look.roughness"), now.roughness, 0.0..=1.0, 0.0).0;
        edits.extend(roughness.map(LookEdit::Roughness));
        let share = change(
            ui,
            ("Translucent", "bodies.look.translucency"),
            now.translucency,
            0.0..=1.0,
            0.0,
        )
        .0;
        edits.extend(share.map(LookEdit::Translucency));
        let text = now.pattern.map_or("mixed", Pattern::name);
        let names = Pattern::ALL.map(|pattern| (pattern, pattern.name()));
        edits.extend(choice(ui, ("Pattern", text), &names, now.pattern).1.map(LookEdit::Pattern));
    }
    if now.has_surface && now.pattern != Some(Pattern::None) {
        let size = change(ui, ("Pattern size", ""), now.pattern_size, 0.0..=10.0, 1e-3).0;
        edits.extend(size.map(LookEdit::PatternSize));
    }
    edits.into_iter().for_each(|edit| viewer.session.edit_look(edit));
}

/// Shows the colours of the first selected body; an edit sets them for all selected bodies.
fn colours(ui: &mut Ui, viewer: &mut Viewer, now: &LookValues) -> Option<LookEdit> {
    let body = now.body;
    let shown = on!(viewer.session.runner(), simulation => {
        let row = &simulation.model().bodies()[body];
        [body_colour(body, row), back_colour(body, row)]
    });
    ui.horizontal(|ui| {
        left_label(ui, "Colour");
        let (response, colour) = well(ui, "Colour", shown[0]);
        viewer.layout.landmarks.insert("colour", response.rect);
        let back = now.is_sheet.then(|| {
            ui.label("other side");
            well(ui, "Colour of the other side", shown[1]).1
        });
        colour.map(LookEdit::Colour).or(back.flatten().map(LookEdit::Back))
    })
    .inner
}

/// Shows a colour button that opens a picker; returns a new colour.
fn well(ui: &mut Ui, name: &str, colour: [f32; 3]) -> (Response, Option<[f32; 3]>) {
    let now @ [red, green, blue] = bytes(colour);
    let response = field(ui, now, [44.0, 16.0]);
    let response = response.on_hover_text(format!("#{red:02x}{green:02x}{blue:02x}"));
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
    let popup = Popup::menu(&response).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let picked = popup.show(|ui| picker(ui, now)).and_then(|shown| shown.inner);
    (response, picked.map(|bytes| bytes.map(|part| f32::from(part) / 255.0)))
}

/// Shows a palette and a slider for each component; returns a new colour.
///
/// egui's own picker has a symbol that the small font lacks.
fn picker(ui: &mut Ui, now: [u8; 3]) -> Option<[u8; 3]> {
    let mut picked = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for colour in PALETTE.into_iter().chain([[0.93; 3], [0.2; 3]]).map(bytes) {
            let [red, green, blue] = colour;
            let choice = field(ui, colour, [22.0, 22.0]);
            let name = format!("#{red:02x}{green:02x}{blue:02x}");
            ui.ctx().accesskit_node_builder(choice.id, |node| node.set_label(name));
            if choice.clicked() {
                picked = Some(colour);
            }
        }
    });
    let mut mixed = now;
    for (name, part) in ["Red", "Green", "Blue"].into_iter().zip(&mut mixed) {
        slider(ui, (name, "Component, 0 to 255"), Slider::new(part, 0..=255));
    }
    picked.or((mixed != now).then_some(mixed))
}

/// Shows a button filled with a colour.
fn field(ui: &mut Ui, [red, green, blue]: [u8; 3], size: [f32; 2]) -> Response {
    let colour = Color32::from_rgb(red, green, blue);
    ui.add(Button::new("").fill(colour).min_size(size.into()))
}

fn bytes(colour: [f32; 3]) -> [u8; 3] {
    colour.map(|part| (part * 255.0).round() as u8)
}

/// Shows a choice by name; returns the chosen value.
fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    (label, text): (&str, &str),
    names: &[(T, &str)],
    now: Option<T>,
) -> (Response, Option<T>) {
    ui.horizontal(|ui| {
        let name = left_label(ui, label);
        let combo = ComboBox::from_id_salt(label).selected_text(text);
        let shown = combo.show_ui(ui, |ui| {
            let clicked =
                |(choice, name): &&(T, &str)| listed(ui, Some(*choice) == now, *name).clicked();
            names.iter().filter(clicked).last().map(|(choice, _)| *choice)
        });
        (shown.response.labelled_by(name.id), shown.inner.flatten())
    })
    .inner
}
