//! The panels: scenes and toggles on the left, numbers on the right, a status line below, and the
//! 3D view between them.

pub mod theme;
mod scenes;
mod twin;
mod run;
mod timeline;
mod material;
mod solver;
mod live_error;
mod energy;
mod trade;
mod status;
mod overlay;
mod failure;
mod over;
#[cfg(target_arch = "wasm32")]
mod rehearsal;

use crate::viewer::Viewer;
use egui::{
    Align, CursorIcon, Frame, Layout, Panel, Response, RichText, ScrollArea, Sense, Slider, Ui,
    Widget, WidgetInfo, vec2,
};
use egui_plot::Plot;
#[cfg(target_arch = "wasm32")]
pub use rehearsal::rehearse;

/// Width of the left panel, points.
const LEFT: f32 = 158.0;
/// Width of the right panel, points.
const RIGHT: f32 = 292.0;
/// Between two rows of the right panel, height of a row, and over and under the words of a button,
/// points.
const TIGHT: (f32, f32, f32) = (3.0, 18.0, 1.0);
/// Width of the names of sliders and choices, points.
const COLUMN: f32 = 70.0;

/// Lays out everything, and lets widgets act on the viewer.
pub fn show(ui: &mut Ui, viewer: &mut Viewer) {
    if viewer.bare {
        view(ui, viewer);
        return overlay::show(ui, viewer);
    }
    let frame = Frame::new().fill(theme::PANEL).inner_margin(10.0);
    let line = Frame::new().fill(theme::PANEL).inner_margin(egui::Margin::symmetric(10, 5));
    if viewer.panels {
        panels(ui, viewer, frame, line);
    }
    view(ui, viewer);
    overlay::show(ui, viewer);
    failure::show(ui, viewer);
    over::show(ui, viewer);
    if let Some(text) = viewer.clipboard.take() {
        ui.ctx().copy_text(text);
    }
}

fn panels(ui: &mut Ui, viewer: &mut Viewer, frame: Frame, line: Frame) {
    Panel::bottom("status").resizable(false).frame(line).show(ui, |ui| status::show(ui, viewer));
    Panel::bottom("timeline").resizable(false).frame(line).show(ui, |ui| {
        timeline::show(ui, viewer);
    });
    Panel::left("scenes").resizable(false).exact_size(LEFT).frame(frame).show(ui, |ui| {
        let area = ScrollArea::vertical().id_salt("left").auto_shrink([false, false]);
        area.show(ui, |ui| scenes::show(ui, viewer));
    });
    Panel::right("numbers").resizable(false).exact_size(RIGHT).frame(frame).show(ui, |ui| {
        status::scrolled(ui, viewer, |ui, viewer| {
            // Down to the plot of the energy in a window of 1280 x 800 points.
            let spacing = ui.spacing_mut();
            (spacing.item_spacing.y, spacing.interact_size.y, spacing.button_padding.y) = TIGHT;
            run::show(ui, viewer);
            twin::show(ui, viewer);
            material::show(ui, viewer);
            solver::show(ui, viewer);
            trade::switch(ui, viewer);
            live_error::show(ui, viewer);
            energy::show(ui, viewer);
        });
    });
    trade::show(ui, viewer, frame);
}

/// The 3D view as a widget: egui decides which presses are its own, for
/// [`crate::input::read_pointer`].
fn view(ui: &mut Ui, viewer: &mut Viewer) {
    let rect = ui.available_rect_before_wrap();
    viewer.rect = rect;
    viewer.frame_once();
    let view = ui.interact(rect, Viewer::view_id(), Sense::click_and_drag());
    view.widget_info(|| WidgetInfo::labeled(egui::Role::Canvas, true, "View of the scene"));
    if viewer.session.is_holding() {
        ui.set_cursor_icon(CursorIcon::Grabbing);
    } else if viewer.hovered.is_some() || viewer.hovered_solid.is_some() {
        ui.set_cursor_icon(CursorIcon::Grab);
    }
}

/// The title of a group of widgets.
fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(text.to_uppercase()).small().strong().color(theme::FAINT));
        let rest = ui.available_rect_before_wrap();
        let stroke = egui::Stroke::new(1.0, theme::LINE);
        ui.painter().hline(rest.x_range(), rest.center().y, stroke);
    });
}

/// A plot that the pointer does not move; it is a picture, so that the keyboard passes it by.
fn still_plot(name: &'static str) -> Plot<'static> {
    let plot = Plot::new(name).allow_drag(false).allow_zoom(false).allow_scroll(false);
    plot.allow_boxed_zoom(false).allow_double_click_reset(false).sense(Sense::hover())
}

/// A label and a slider beside it; the name of both is the label.
fn slider(ui: &mut Ui, label: &str, slider: Slider<'_>) -> Response {
    ui.horizontal(|ui| {
        left_label(ui, label);
        ui.spacing_mut().slider_width = 96.0;
        let response = slider.ui(ui);
        // Not by the label's id: the number beside the slider takes over only a name of its own.
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(label));
        response
    })
    .inner
}

/// A label that starts at the left edge and takes the width of a column.
fn left_label(ui: &mut Ui, text: &str) -> Response {
    let layout = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(vec2(COLUMN, 18.0), layout, |ui| {
        ui.set_min_width(COLUMN);
        ui.label(text)
    })
    .inner
}
