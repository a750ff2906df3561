//! The panels of a small screen, one at a time: below the view, or beside it in landscape.

use super::{RIGHT, energy, live_error, material, run, scenes, scroll, solver, status, theme};
use super::{timeline, trade, twin};
use crate::viewer::Viewer;
use egui::{Button, Frame, Panel, ScrollArea, Ui, Vec2, vec2};

/// Least size of a window for all panels, points; also the minimum size of a desktop window.
pub(crate) const LEAST: Vec2 = vec2(640.0, 400.0);
/// Share of the height for a sheet below the view.
const HEIGHT: f32 = 0.45;
/// Width of a sheet beside the view, points.
const WIDTH: f32 = 320.0;

/// A panel: the label of its tab, and its layout.
type Sheet = (&'static str, fn(&mut Ui, &mut Viewer));

/// All panels, in the order of their tabs.
const SHEETS: [Sheet; 5] = [
    ("Run", |ui, viewer| {
        run::show(ui, viewer);
        timeline::show(ui, viewer);
        twin::show(ui, viewer);
        status::show(ui, viewer);
    }),
    ("Material", |ui, viewer| material::show(ui, viewer)),
    ("Solver", |ui, viewer| {
        solver::show(ui, viewer);
        live_error::show(ui, viewer);
        trade::switch(ui, viewer);
        trade::stacked(ui, viewer);
    }),
    ("Energy", |ui, viewer| energy::show(ui, viewer)),
    ("View", |ui, viewer| match viewer.layout.in_page {
        // The bar of the page has a list of scenes.
        true => scenes::view(ui, viewer),
        false => scenes::show(ui, viewer),
    }),
];

/// Returns whether a window of this size has space for a single panel only.
pub(super) fn is_small(size: Vec2) -> bool {
    size.x < LEAST.x || size.y < LEAST.y
}

/// Shows the selected panel, below the tabs of all.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer, frame: Frame) {
    let size = ui.available_size();
    let panel = match size.y < size.x {
        true => Panel::right("sheet beside").exact_size(WIDTH),
        false => Panel::bottom("sheet below").exact_size(HEIGHT * size.y),
    };
    panel.resizable(false).frame(frame).show(ui, |ui| {
        tabs(ui, viewer);
        let (name, contents) = SHEETS[viewer.layout.sheet];
        let area = ScrollArea::vertical().id_salt(name).auto_shrink([false, false]);
        scroll(ui, area, |ui| {
            // The width beyond that of a desktop panel.
            ui.spacing_mut().slider_width += (ui.available_width() - RIGHT).max(0.0);
            contents(ui, viewer);
        });
    });
}

fn tabs(ui: &mut Ui, viewer: &mut Viewer) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.spacing_mut().button_padding.x = 2.0;
        let count = SHEETS.len() as f32;
        let width = (ui.available_width() - 2.0 * (count - 1.0)) / count;
        for (at, (name, _)) in SHEETS.into_iter().enumerate() {
            let tab = Button::selectable(viewer.layout.sheet == at, name);
            if ui.add(tab.min_size(vec2(width, theme::FINGER))).clicked() {
                viewer.layout.sheet = at;
            }
        }
    });
}
