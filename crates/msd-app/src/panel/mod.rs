//! The panels: scenes and view options on the left, numbers on the right, a status line below, and
//! the 3D view between them.

pub mod theme;
mod axes;
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
mod over;
mod sheet;
#[cfg(target_arch = "wasm32")]
mod rehearsal;

use crate::viewer::Viewer;
use egui::scroll_area::ScrollAreaOutput;
use egui::{
    Align, CursorIcon, Frame, Id, Layout, Panel, Rect, Response, RichText, ScrollArea, Sense,
    Slider, Ui, Widget, WidgetInfo, vec2,
};
#[cfg(target_arch = "wasm32")]
pub use rehearsal::rehearse;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use sheet::LEAST;

/// Width of the left panel, points.
const LEFT: f32 = 158.0;
/// Width of the right panel, points.
const RIGHT: f32 = 292.0;
/// Gap between two rows of a panel, height of a row, and vertical padding of a button, points.
const TIGHT: (f32, f32, f32) = (3.0, 18.0, 1.0);
/// Width of the labels of sliders and choices, points.
const COLUMN: f32 = 70.0;

/// Lays out all widgets, which act on the viewer.
pub fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let is_small = sheet::is_small(ui.available_size());
    theme::fit(ui.ctx(), is_small || viewer.layout.by_touch);
    if viewer.layout.bare {
        viewer.choose_scale();
        view(ui, viewer);
        return overlay::show(ui, viewer);
    }
    // The edge of a list fades into this colour, so it must be that of the theme.
    let paper = Frame::new().fill(ui.visuals().panel_fill);
    let frame = paper.inner_margin(10.0);
    let line = paper.inner_margin(egui::Margin::symmetric(10, 5));
    match viewer.layout.panels {
        true if is_small => sheet::show(ui, viewer, frame),
        true => panels(ui, viewer, frame, line),
        false => {}
    }
    viewer.choose_scale();
    view(ui, viewer);
    overlay::show(ui, viewer);
    over::show(ui, viewer);
    if let Some(text) = viewer.wishes.clipboard.take() {
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
        scroll(ui, area, |ui| {
            tighten(ui, viewer);
            scenes::show(ui, viewer);
        });
    });
    Panel::right("numbers").resizable(false).exact_size(RIGHT).frame(frame).show(ui, |ui| {
        status::scrolled(ui, viewer, |ui, viewer| {
            tighten(ui, viewer);
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

/// Makes the panels compact enough to show the plot of the energy in a window of 1280 x 800 points,
/// except with touch input.
fn tighten(ui: &mut Ui, viewer: &Viewer) {
    if !viewer.layout.by_touch {
        let spacing = ui.spacing_mut();
        (spacing.item_spacing.y, spacing.interact_size.y, spacing.button_padding.y) = TIGHT;
    }
}

/// Shows the 3D view as a widget, so that egui decides which presses belong to it, for
/// [`crate::input::read_pointer`].
fn view(ui: &mut Ui, viewer: &mut Viewer) {
    let rect = ui.available_rect_before_wrap();
    viewer.layout.rect = rect;
    viewer.frame_once();
    // Keyboard focus skips the view: its shortcuts apply while no control has the focus.
    let view = ui.interact(rect, Viewer::view_id(), Sense::CLICK | Sense::DRAG);
    view.widget_info(|| WidgetInfo::labeled(egui::Role::Canvas, true, "View of the scene"));
    if viewer.session.is_holding() {
        ui.set_cursor_icon(CursorIcon::Grabbing);
    } else if viewer.hand.hovered.is_some() || viewer.hand.hovered_solid.is_some() {
        ui.set_cursor_icon(CursorIcon::Grab);
    }
}

/// Shows the title of a group of widgets.
fn heading(ui: &mut Ui, text: &str) {
    heading_with(ui, text, |_| {});
}

/// Shows the title of a group of widgets, with a control at its end.
fn heading_with(ui: &mut Ui, text: &str, control: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(text.to_uppercase()).small().strong().color(theme::FAINT));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            control(ui);
            let rest = ui.available_rect_before_wrap();
            let stroke = egui::Stroke::new(1.0, theme::LINE);
            ui.painter().hline(rest.x_range(), rest.center().y, stroke);
        });
    });
}

/// Shows scrolling contents and scrolls to the control that gets the focus. If that is in a nested
/// scroll area, it scrolls to this area.
fn scroll<T>(
    ui: &mut Ui,
    area: ScrollArea,
    contents: impl FnOnce(&mut Ui) -> T,
) -> ScrollAreaOutput<T> {
    let (key, pass) = (Id::unique("scrolled to"), ui.ctx().cumulative_pass_nr());
    let mut is_shown = false;
    let output = area.show(ui, |ui| {
        let shown = contents(ui);
        let focused = ui.memory(|memory| memory.focused());
        if let Some(control) = focused.and_then(|id| ui.ctx().read_response(id))
            && control.gained_focus()
            && control.layer_id == ui.layer_id()
        {
            let inner = ui.data(|data| data.get_temp::<(u64, Rect)>(key));
            let inner = inner.filter(|(shown_in, _)| *shown_in == pass);
            let rect = inner.map_or(control.rect, |(_, area)| area);
            if ui.min_rect().contains(rect.center()) {
                // Beyond the fading edge.
                let fade = ui.spacing().scroll.fade.size;
                ui.scroll_to_rect(rect.expand2(vec2(0.0, fade)), None);
                is_shown = true;
            }
        }
        shown
    });
    if is_shown {
        ui.data_mut(|data| data.insert_temp(key, (pass, output.inner_rect)));
    }
    output
}

/// Shows a label and a slider beside it; the label names both, and `hover` explains both.
fn slider(ui: &mut Ui, (label, hover): (&str, &str), slider: Slider<'_>) -> Response {
    ui.horizontal(|ui| {
        left_label(ui, label).on_hover_text(hover);
        let response = slider.ui(ui).on_hover_text(hover);
        // Not `labelled_by`: the number beside the slider inherits only a name of its own node.
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(label));
        response
    })
    .inner
}

/// Shows an entry of an open list, which closes after a choice.
fn listed<'a>(ui: &mut Ui, is_chosen: bool, text: impl egui::IntoAtoms<'a>) -> Response {
    let line = ui.selectable_label(is_chosen, text);
    // By default egui closes a list only after a click of the pointer.
    if line.clicked() {
        ui.close();
    }
    line
}

/// Shows a label, aligned left, with the width of a column.
fn left_label(ui: &mut Ui, text: &str) -> Response {
    let layout = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(vec2(COLUMN, 18.0), layout, |ui| {
        ui.set_min_width(COLUMN);
        ui.label(text)
    })
    .inner
}
