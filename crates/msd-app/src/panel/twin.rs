//! The twin: the same scene with other settings, as a ghost, and the distance between the two.

use super::axes::plot_over_time;
use super::theme;
use crate::session::{Session, Twin};
use crate::viewer::Viewer;
use egui::{Button, Color32, ComboBox, Label, Mesh, Painter, Pos2, Rect, RichText, Ui, pos2, vec2};
use egui_plot::{Line, PlotPoints};
use glam::Vec3;
use msd_core::{Integrator, Settings};
use msd_study::quantity::{estimate, quantity};

/// The colour of the ghost and of its curve.
pub(super) const GHOST: Color32 = Color32::from_rgb(255, 120, 220);
/// Largest number of points of the ghost; of more particles it shows every n-th.
const MOST_POINTS: usize = 4000;

const HOVER: &str = "A copy of the run with another method, drawn as points over the view or \
                     beside it. Both get the same input. Their states are equal at the start of \
                     the comparison, after a change of the solver, a step back, or a restart.";

/// Shows the button that begins a twin, if there is none.
pub(super) fn begin(ui: &mut Ui, viewer: &mut Viewer) {
    let session = &mut viewer.session;
    if session.twin().is_some() {
        return;
    }
    let settings = session.runner().settings();
    let other = opponent(settings.integrator);
    let button = ui.button(format!("Compare with {}", other.name())).on_hover_text(HOVER);
    viewer.layout.landmarks.insert("twin", button.rect);
    if button.clicked() {
        session.set_twin(Some(Settings { integrator: other, ..settings }));
    }
}

/// Shows the method of the twin, its distance and its plot.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let Some(now) = viewer.session.twin().map(Twin::settings) else { return };
    let session = &mut viewer.session;
    ui.horizontal(|ui| {
        let name = super::left_label(ui, "Twin");
        let combo =
            ComboBox::from_id_salt("twin").width(118.0).selected_text(now.integrator.name());
        let shown = combo.show_ui(ui, |ui| {
            for integrator in Integrator::ALL {
                if super::listed(ui, integrator == now.integrator, integrator.name()).clicked() {
                    session.set_twin(Some(Settings { integrator, ..now }));
                }
            }
        });
        shown.response.labelled_by(name.id).on_hover_text(HOVER);
        if ui.add(Button::new("End twin")).clicked() {
            session.set_twin(None);
        }
    });
    let mut substeps = now.substeps;
    let slider = egui::Slider::new(&mut substeps, 1..=crate::session::MOST_SUBSTEPS)
        .logarithmic(true)
        .clamping(egui::SliderClamping::Edits)
        .suffix(" / step");
    let hover = "Number of substeps per step of the twin";
    if super::slider(ui, ("Its substeps", hover), slider).changed() {
        session.set_twin(Some(Settings { substeps, ..now }));
    }
    let mut beside = viewer.layout.side_by_side;
    let hover = "Two views, the run on the left and the twin on the right, with the same camera \
                 and input; otherwise the twin is drawn as points over the run";
    if ui.checkbox(&mut beside, "Side by side").on_hover_text(hover).changed() {
        viewer.set_side_by_side(beside);
    }
    distance(ui, &viewer.session);
}

/// Returns the method to compare with: explicit Euler, or Verlet for explicit Euler itself.
fn opponent(method: Integrator) -> Integrator {
    match method {
        Integrator::ExplicitEuler => Integrator::VelocityVerlet,
        _ => Integrator::ExplicitEuler,
    }
}

/// Shows the distance and its plot.
fn distance(ui: &mut Ui, session: &Session) {
    let Some(twin) = session.twin() else { return };
    let apart = twin.apart();
    let [rms, max] = [apart.rms, apart.max].map(|metres| estimate(metres, "m"));
    let text = format!("{rms} apart (rms), {max} at most, at t = {:.2} s", apart.time);
    let hover =
        format!("{} (rms), of particle {} at most", quantity(apart.rms, "m"), apart.particle);
    ui.label(RichText::new(text).small().color(GHOST)).on_hover_text(hover);
    let most = twin.trace().map(|apart| apart.rms).fold(0.0, f64::max);
    plot_over_time("twin", |metres| quantity(metres, "m"))
        .height(78.0)
        .include_y(0.0)
        .include_y(if most == 0.0 { 1e-3 } else { most })
        .show(ui, |plot| {
            let points: PlotPoints<'_> =
                twin.trace().map(|apart| [apart.time, apart.rms]).collect();
            plot.line(Line::new("distance", points).color(GHOST).width(1.5));
        });
    // In one line, so that a failure of the twin does not move the controls below.
    let (text, colour) = match twin.failure() {
        Some(failure) => (failure.to_owned(), theme::BAD),
        None => ("distance over time".to_owned(), theme::FAINT),
    };
    ui.add(Label::new(RichText::new(&text).small().color(colour)).truncate()).on_hover_text(text);
}

/// Draws the ghost: a point at each particle of the twin, over the view.
pub(super) fn ghost(painter: &Painter, viewer: &Viewer) {
    let Some(twin) = viewer.session.twin() else { return };
    let (positions, viewport) = (twin.positions(), viewer.viewport());
    let every = positions.len().div_ceil(MOST_POINTS).max(1);
    let mut mesh = Mesh::default();
    for position in positions.iter().step_by(every) {
        if let Some(at) = viewport.project(Vec3::from_array(*position))
            && viewer.layout.rect.contains(at)
        {
            point(&mut mesh, at);
        }
    }
    painter.add(mesh);
    let text = format!("{} as points", twin.settings().integrator.name());
    let font = egui::FontId::proportional(11.0);
    let corner = viewer.layout.rect.right_top() + vec2(-12.0, 12.0);
    painter.text(corner, egui::Align2::RIGHT_TOP, text, font, GHOST);
}

fn point(mesh: &mut Mesh, at: Pos2) {
    let size = vec2(3.0, 3.0);
    let colour = GHOST.gamma_multiply(0.7);
    mesh.add_colored_rect(Rect::from_center_size(pos2(at.x, at.y), size), colour);
}
