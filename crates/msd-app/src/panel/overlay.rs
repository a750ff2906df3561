//! Overlay of the 3D view: the hint, the legend, the marks of particles and springs, the help.

use super::live_error::is_fresh;
use super::theme;
use crate::input::KEYS;
use crate::session::ErrorNow;
use crate::viewer::Viewer;
use egui::{
    Align2, Color32, FontId, Grid, Mesh, Painter, Pos2, Rect, RichText, Stroke, Ui, pos2, vec2,
};
use msd_core::Vector;
use msd_run::on;

/// Shows what lies over the 3D view.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let painter = ui.painter().with_clip_rect(viewer.rect);
    fastest_springs(&painter, viewer);
    marks(&painter, viewer);
    if viewer.style.springs {
        legend(&painter, viewer);
    }
    if viewer.hint {
        let text =
            "drag a particle to throw it  ·  drag beside it to turn  ·  wheel to zoom  ·  F1 help";
        hint(&painter, viewer.rect, text);
    }
    if viewer.help {
        help(ui, viewer);
    }
}

/// The place of a particle in the window.
fn place(viewer: &Viewer, particle: usize) -> Option<Pos2> {
    let position = on!(viewer.session.runner(), simulation => {
        let there = particle < simulation.model().particle_count();
        there.then(|| simulation.position(particle).to_f32())
    })?;
    viewer.viewport().project(position)
}

/// The springs that carry the fastest motion of a run that blew up.
fn fastest_springs(painter: &Painter, viewer: &Viewer) {
    let session = &viewer.session;
    let ends = |&spring: &usize| {
        on!(session.runner(), simulation => {
            simulation.model().ends().get(spring).copied()
        })
    };
    for ends in session.fastest_springs().iter().filter_map(ends) {
        if let [Some(a), Some(b)] = ends.map(|end| place(viewer, end as usize)) {
            painter.line_segment([a, b], Stroke::new(5.0, Color32::from_black_alpha(120)));
            painter.line_segment([a, b], Stroke::new(2.5, theme::BAD));
        }
    }
}

/// Rings around the particle under the pointer, the selected one and the one most wrong.
fn marks(painter: &Painter, viewer: &Viewer) {
    let place = |particle: usize| place(viewer, particle);
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
        Some(ErrorNow::Known(last)) if is_fresh(&viewer.session, last) => {
            (last.error.rounding < last.worst.1).then_some(last.worst.0)
        }
        _ => None,
    };
    ring(worst, 10.0, theme::BAD);
    if let Some(at) = worst.and_then(place) {
        let font = FontId::proportional(11.0);
        let text = painter.layout_no_wrap("most wrong".to_owned(), font, theme::BAD);
        let corner = at + vec2(18.0, -0.5 * text.size().y);
        paper(painter, Rect::from_min_size(corner, text.size()).expand2(vec2(5.0, 2.0)));
        painter.galley(corner, text, theme::BAD);
    }
    ring(viewer.session.selected(), 8.0, theme::WARN);
    ring(viewer.hovered, 6.0, Color32::WHITE);
}

fn hint(painter: &Painter, rect: Rect, text: &str) {
    let font = FontId::proportional(13.0);
    let text = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let at = pos2(rect.center().x - 0.5 * text.size().x, rect.bottom() - 40.0);
    paper(painter, Rect::from_min_size(at, text.size()).expand2(vec2(14.0, 7.0)));
    painter.galley(at, text, Color32::WHITE);
}

/// What makes a text over the scene readable.
fn paper(painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 0.5 * rect.height(), Color32::from_black_alpha(150));
}

/// The colours of strain with their scale.
fn legend(painter: &Painter, viewer: &Viewer) {
    let size = vec2(150.0, 10.0);
    let corner = viewer.rect.left_top() + vec2(22.0, 34.0);
    let bar = Rect::from_min_size(corner, size);
    let paper = Rect::from_min_max(bar.min - vec2(12.0, 24.0), bar.max + vec2(12.0, 22.0));
    painter.rect_filled(paper, 6.0, Color32::from_black_alpha(150));
    let full = viewer.style.strain_full_scale;
    let mut mesh = Mesh::default();
    let slices = 32;
    for slice in 0..=slices {
        let share = slice as f32 / slices as f32;
        let part = msd_render::strain_colour(share * full, full);
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
    text(bar.left_top() - vec2(0.0, 5.0), Align2::LEFT_BOTTOM, "strain of springs");
    let anchors = [Align2::LEFT_TOP, Align2::CENTER_TOP, Align2::RIGHT_TOP];
    for (share, anchor) in [0.0, 0.5, 1.0].into_iter().zip(anchors) {
        let at = pos2(egui::lerp(bar.x_range(), share), bar.bottom() + 4.0);
        text(at, anchor, &format!("{:.0} %", share * full * 100.0));
    }
}

const MOUSE: [(&str, &str); 5] = [
    ("Left drag on a particle", "hold it; let go to throw it"),
    ("Left drag beside, right drag", "turn"),
    ("Shift drag, middle drag", "move sideways"),
    ("Wheel, pinch", "zoom"),
    ("Drag a pin", "move the pin"),
];

fn help(ui: &Ui, viewer: &mut Viewer) {
    let mut open = true;
    let window = egui::Window::new("Help").open(&mut open).collapsible(false).resizable(false);
    let window = window.pivot(Align2::CENTER_CENTER).fixed_pos(viewer.rect.center());
    window.show(ui.ctx(), |ui| {
        Grid::new("help").num_columns(2).spacing([24.0, 6.0]).show(ui, |ui| {
            for (what, does) in MOUSE.into_iter().chain(KEYS) {
                ui.label(RichText::new(what).strong());
                ui.label(does);
                ui.end_row();
            }
        });
    });
    viewer.help &= open;
}
