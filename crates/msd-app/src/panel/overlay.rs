//! Overlay of the 3D view: hint, legend, marks of particles and springs, mouse gestures, help.

use super::live_error::is_fresh;
use super::{theme, twin};
use crate::input::KEYS;
use crate::session::ErrorNow;
use crate::viewer::{Action, Side, Tool, Viewer};
use egui::{
    Align2, Area, Color32, FontId, Frame, Grid, Id, Label, Margin, Mesh, Painter, Pos2, Rect,
    RichText, ScrollArea, Stroke, Ui, pos2, vec2,
};
use msd_core::{Settings, Vector};
use msd_render::Scale;
use msd_run::{Runner, on};
use msd_study::quantity::estimate;

/// Shows the overlays of the 3D view.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let painter = ui.painter().with_clip_rect(viewer.layout.rect);
    match viewer.sides() {
        [_, _] => captions(&painter, viewer),
        _ => twin::ghost(&painter, viewer),
    }
    fastest_springs(&painter, viewer);
    for &side in viewer.sides() {
        let painter = painter.with_clip_rect(viewer.viewport_of(side).rect);
        marks(&painter, viewer, side);
    }
    gesture(&painter, viewer);
    if let Some(scale) = viewer.scale() {
        legend(&painter, viewer.layout.rect, scale);
    }
    let text = match viewer.hand.tool {
        Tool::Cut if viewer.layout.by_touch => "draw a line across springs to cut them",
        Tool::Select if viewer.layout.by_touch => "draw a box around a group of particles",
        Tool::Grab if viewer.layout.by_touch => {
            "drag the body to throw it  ·  drag on empty space to orbit  ·  two fingers zoom and \
             pan"
        }
        Tool::Cut => "draw a line across springs to cut them  ·  C or Esc: grab again",
        Tool::Select => "draw a box around a group of particles  ·  B or Esc: back to grabbing",
        Tool::Grab if viewer.has_solids() => {
            "drag a particle to throw it, or a solid to push with it  ·  drag on empty space to \
             orbit  ·  wheel to zoom  ·  F1 help"
        }
        Tool::Grab => {
            "drag a particle to throw it  ·  drag on empty space to orbit  ·  wheel to zoom  ·  \
             F1 help"
        }
    };
    let is_new = viewer.layout.hint && viewer.layout.guide.is_none();
    if is_new || viewer.hand.tool != Tool::Grab {
        hint(&painter, viewer, text);
    }
    notes(ui, viewer);
    if viewer.layout.help {
        help(ui, viewer);
    }
}

/// Shows the last message and the last refusal, where they cover no control.
fn notes(ui: &Ui, viewer: &Viewer) {
    let note = viewer.note.as_deref().map(|text| (text, theme::TEXT));
    let refusal = viewer.session.refusal().map(|text| (text, theme::BAD));
    let notes = Vec::from_iter(note.into_iter().chain(refusal));
    if notes.is_empty() {
        return;
    }
    // Below the hint and the legend, above the tour.
    let top = if viewer.scale().is_some() { 78.0 } else { 50.0 };
    let at = viewer.layout.rect.left_top() + vec2(8.0, top);
    // The pointer passes through.
    let area = Area::new(Id::unique("notes")).fixed_pos(at).interactable(false);
    area.show(ui.ctx(), |ui| {
        // On the panel colour, against which these colours are readable in both themes.
        let frame = Frame::new().fill(theme::PANEL).corner_radius(6.0);
        frame.inner_margin(Margin::symmetric(12, 6)).show(ui, |ui| {
            ui.set_max_width((viewer.layout.rect.width() - 60.0).max(100.0));
            for (text, colour) in notes {
                let text = RichText::new(text).size(12.0).color(colour);
                ui.add(Label::new(text).selectable(false));
            }
        });
    });
}

/// Returns the position of a particle of a side in the window.
fn place(viewer: &Viewer, side: Side, particle: usize) -> Option<Pos2> {
    let position = on!(viewer.runner_of(side), simulation => {
        let there = particle < simulation.model().particle_count();
        there.then(|| simulation.position(particle).to_f32())
    })?;
    viewer.viewport_of(side).project(position)
}

/// Draws the springs with the fastest motion of a diverged run.
fn fastest_springs(painter: &Painter, viewer: &Viewer) {
    let session = &viewer.session;
    let ends = |&spring: &usize| {
        on!(session.runner(), simulation => {
            simulation.model().ends().get(spring).copied()
        })
    };
    for ends in session.fastest_springs().iter().filter_map(ends) {
        if let [Some(a), Some(b)] = ends.map(|end| place(viewer, Side::Run, end as usize)) {
            painter.line_segment([a, b], Stroke::new(5.0, Color32::from_black_alpha(120)));
            painter.line_segment([a, b], Stroke::new(2.5, theme::BAD));
        }
    }
}

/// Draws rings around the hovered particle, the selected one and the one with the largest error.
fn marks(painter: &Painter, viewer: &Viewer, side: Side) {
    let place = |particle: usize| place(viewer, side, particle);
    let ring = |particle: Option<usize>, radius: f32, colour: Color32| {
        if let Some(at) = particle.and_then(place) {
            painter.circle_stroke(
                at,
                radius + 1.0,
                Stroke::new(1.0, Color32::from_black_alpha(90)),
            );
            painter.circle_stroke(at, radius, Stroke::new(2.0, colour));
        }
    };
    let worst = match viewer.session.error() {
        Some(ErrorNow::Known(last)) if side == Side::Run && is_fresh(&viewer.session, last) => {
            (last.error.rounding < last.worst.1).then_some(last.worst.0)
        }
        _ => None,
    };
    for &particle in viewer.session.group() {
        if let Some(at) = place(particle) {
            painter.circle_filled(at, 3.0, theme::WARN);
        }
    }
    ring(worst, 10.0, theme::BAD);
    if let Some(at) = worst.and_then(place) {
        note(painter, at + vec2(18.0, 0.0), "largest error", theme::BAD);
    }
    ring(viewer.session.selected(), 8.0, theme::WARN);
    ring(viewer.hand.hovered, 6.0, Color32::WHITE);
}

/// Draws the gesture of the mouse: a box, a cut, or the force of a grab.
fn gesture(painter: &Painter, viewer: &Viewer) {
    let Some(gesture) = viewer.hand.gesture else { return };
    let line = Stroke::new(1.5, Color32::WHITE);
    match gesture.action {
        Action::Select { from } => {
            let area = Rect::from_two_pos(from, gesture.last);
            painter.rect_filled(area, 0.0, Color32::from_white_alpha(18));
            painter.rect_stroke(area, 0.0, line, egui::StrokeKind::Middle);
        }
        Action::Cut => {
            let path = viewer.hand.stroke.clone();
            painter.line(path.clone(), Stroke::new(4.0, Color32::from_black_alpha(120)));
            painter.line(path, Stroke::new(2.0, theme::BAD));
        }
        Action::Grab { .. } => {
            if let Some(force) = viewer.session.grab_force() {
                let large = 1e3 <= force;
                let text = if large { estimate(force * 1e-3, "kN") } else { estimate(force, "N") };
                note(painter, gesture.last + vec2(22.0, 14.0), &text, Color32::WHITE);
            }
        }
        Action::Orbit | Action::Pan => {}
    }
}

/// Draws a short text on a dark background, to the right of a point.
fn note(painter: &Painter, at: Pos2, text: &str, colour: Color32) {
    let text = painter.layout_no_wrap(text.to_owned(), FontId::proportional(11.0), colour);
    // Inside the view, even if the pointer is near its edge.
    let most = painter.clip_rect().right() - text.size().x - 6.0;
    let corner = pos2(at.x.min(most), at.y - 0.5 * text.size().y);
    paper(painter, Rect::from_min_size(corner, text.size()).expand2(vec2(5.0, 2.0)));
    painter.galley(corner, text, colour);
}

fn hint(painter: &Painter, viewer: &Viewer, text: &str) {
    let (rect, font) = (viewer.layout.rect, FontId::proportional(13.0));
    let width = (rect.width() - 60.0).max(100.0);
    let text = painter.layout(text.to_owned(), font, Color32::WHITE, width);
    // The tour is at the bottom.
    let top = match viewer.layout.guide {
        Some(_) => rect.top() + 14.0,
        None => rect.bottom() - 24.0 - text.size().y,
    };
    let at = pos2(rect.center().x - 0.5 * text.size().x, top);
    let area = Rect::from_min_size(at, text.size()).expand2(vec2(14.0, 7.0));
    painter.rect_filled(area, 12.0, Color32::from_black_alpha(150));
    painter.galley(at, text, Color32::WHITE);
}

/// Draws the dark background of a text over the scene.
fn paper(painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 0.5 * rect.height(), Color32::from_black_alpha(150));
}

/// Draws the solver of each side in its corner, and a line between the two.
fn captions(painter: &Painter, viewer: &Viewer) {
    for (&side, colour) in viewer.sides().iter().zip([Color32::WHITE, twin::GHOST]) {
        let text = how(viewer.runner_of(side));
        let text = painter.layout_no_wrap(text, FontId::proportional(12.0), colour);
        let corner = viewer.viewport_of(side).rect.right_top() + vec2(-16.0, 12.0);
        let at = corner - vec2(text.size().x, 0.0);
        paper(painter, Rect::from_min_size(at, text.size()).expand2(vec2(8.0, 3.0)));
        painter.galley(at, text, colour);
    }
    let stroke = Stroke::new(1.0, theme::LINE);
    painter.vline(viewer.layout.rect.center().x, viewer.layout.rect.y_range(), stroke);
}

/// Describes the solver of a run.
fn how(runner: &Runner) -> String {
    let Settings { integrator, substeps, tolerance, .. } = runner.settings();
    let fineness = match integrator.is_adaptive() {
        true => format!("tolerance {tolerance:e}"),
        false if substeps == 1 => "1 substep".into(),
        false => format!("{substeps} substeps"),
    };
    format!("{integrator}, {fineness}, {}", runner.precision())
}

/// Draws a colour scale in a corner of the view.
fn legend(painter: &Painter, view: Rect, scale: Scale) {
    let size = vec2(150.0, 10.0);
    let corner = view.left_top() + vec2(22.0, 34.0);
    let bar = Rect::from_min_size(corner, size);
    let paper = Rect::from_min_max(bar.min - vec2(12.0, 24.0), bar.max + vec2(12.0, 22.0));
    painter.rect_filled(paper, 6.0, Color32::from_black_alpha(150));
    let mut mesh = Mesh::default();
    let slices = 32;
    for slice in 0..=slices {
        let share = slice as f32 / slices as f32;
        let part = msd_render::scale_colour(scale, scale.value(share));
        let [red, green, blue] = part.map(|part| (part * 255.0).round() as u8);
        let x = egui::lerp(bar.x_range(), share);
        for y in [bar.top(), bar.bottom()] {
            mesh.colored_vertex(pos2(x, y), Color32::from_rgb(red, green, blue));
        }
        if 0 < slice {
            let last = 2 * slice as u32;
            mesh.add_triangle(last - 2, last - 1, last);
            mesh.add_triangle(last - 1, last, last + 1);
        }
    }
    painter.add(mesh);
    let font = FontId::proportional(11.0);
    let text = |at: Pos2, anchor: Align2, text: &str| {
        painter.text(at, anchor, text, font.clone(), Color32::WHITE);
    };
    text(bar.left_top() - vec2(0.0, 5.0), Align2::LEFT_BOTTOM, &scale.title());
    let anchors = [Align2::LEFT_TOP, Align2::CENTER_TOP, Align2::RIGHT_TOP];
    for ((share, number), anchor) in scale.ticks().into_iter().zip(anchors) {
        text(pos2(egui::lerp(bar.x_range(), share), bar.bottom() + 4.0), anchor, &number);
    }
}

const MOUSE: [(&str, &str); 7] = [
    ("Left drag on a particle", "hold it; release to throw it"),
    ("Drag on empty space, right drag", "orbit"),
    ("Ctrl drag", "select a group"),
    ("Shift drag, middle drag", "pan"),
    ("Wheel, pinch", "zoom"),
    ("Drag a pin", "move the pin"),
    ("Drag a solid", "push it through the scene; release to leave it there"),
];

const FINGERS: [(&str, &str); 6] = [
    ("Drag the body", "hold it; release to throw it"),
    ("Drag on empty space", "orbit"),
    ("Two fingers", "zoom and pan"),
    ("Long touch", "pin or free a particle"),
    ("Drag a pin", "move the pin"),
    ("Drag a solid", "push it through the scene"),
];

fn help(ui: &Ui, viewer: &mut Viewer) {
    let mut open = true;
    let window = egui::Window::new("Help").open(&mut open).collapsible(false).resizable(false);
    let window = window.pivot(Align2::CENTER_CENTER).fixed_pos(viewer.layout.rect.center());
    // Below the title, for any height of the view.
    let rows = ScrollArea::vertical().max_height((viewer.layout.rect.height() - 60.0).max(60.0));
    window.show(ui.ctx(), |ui| {
        rows.show(ui, |ui| {
            Grid::new("help").num_columns(2).spacing([24.0, 6.0]).show(ui, |ui| {
                let (hands, keys) = match viewer.layout.by_touch {
                    true => (&FINGERS[..], &[][..]),
                    false => (&MOUSE[..], KEYS),
                };
                for &(what, does) in hands.iter().chain(keys) {
                    ui.label(RichText::new(what).strong());
                    ui.label(does);
                    ui.end_row();
                }
            });
        });
    });
    viewer.layout.help &= open;
}
