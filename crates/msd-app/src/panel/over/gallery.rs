//! The gallery over the 3D view: a field for a path, and thumbnails of the scenes.

use crate::panel::{scroll, theme};
use crate::viewer::{Picture, Viewer};
use egui::{Align2, Button, Grid, Image, Response, RichText, ScrollArea, TextEdit, Ui, vec2};
use std::path::Path;
use std::time::Duration;

/// Size of a thumbnail, points.
const PICTURE: egui::Vec2 = vec2(144.0, 90.0);
/// Width of a thumbnail with its frame, points.
const CELL: f32 = 162.0;
/// Delay before the next thumbnail is rendered.
const SOON: Duration = Duration::from_millis(60);

/// Shows the gallery, if it is open.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    let Some(mut gallery) = viewer.layout.gallery.take() else { return };
    if gallery.is_busy() {
        ui.ctx().request_repaint_after(SOON);
    }
    let (mut open, mut wanted) = (true, None);
    let window = egui::Window::new("Open").open(&mut open).collapsible(false).resizable(false);
    let window = window.pivot(Align2::CENTER_CENTER).fixed_pos(viewer.layout.rect.center());
    let room = ui.ctx().content_rect().size() - vec2(60.0, 110.0);
    window.show(ui.ctx(), |ui| {
        ui.set_width(room.x.clamp(300.0, 640.0));
        ui.horizontal(|ui| {
            let name = ui.label("File");
            let field =
                TextEdit::singleline(&mut gallery.path).hint_text("scene, mesh or saved run");
            let field = ui.add(field.desired_width(ui.available_width() - 60.0));
            if std::mem::take(&mut gallery.is_new) {
                field.request_focus();
            }
            viewer.layout.landmarks.insert("file", field.rect);
            let is_entered = field.labelled_by(name.id).lost_focus()
                && ui.input(|input| input.key_pressed(egui::Key::Enter));
            let is_named = !gallery.path.trim().is_empty();
            let button = ui.add_enabled(is_named, Button::new("Open"));
            if is_named && (button.clicked() || is_entered) {
                wanted = Some(gallery.path.trim().to_owned());
            }
        });
        let text = "Or drop a file onto the window.";
        ui.label(RichText::new(text).small().color(theme::FAINT));
        if let Some(note) = &viewer.note {
            ui.label(RichText::new(note).small().color(theme::WARN));
        }
        let area = ScrollArea::vertical().max_height(room.y.clamp(150.0, 520.0));
        scroll(ui, area, |ui| {
            let columns = (ui.available_width() / (CELL + 8.0)).floor().max(1.0) as usize;
            Grid::new("pictures").spacing([8.0, 8.0]).show(ui, |ui| {
                for (place, picture) in (1..).zip(&gallery.pictures) {
                    let button = entry(ui, picture);
                    if place == 2 {
                        viewer.layout.landmarks.insert("second picture", button.rect);
                    }
                    if button.clicked() {
                        wanted = Some(picture.name.clone());
                    }
                    if place % columns == 0 {
                        ui.end_row();
                    }
                }
            });
        });
    });
    // The shortcuts of the view do not apply here, so the gallery handles Esc itself.
    open &= !ui.input(|input| input.key_pressed(egui::Key::Escape));
    // A path that cannot be opened stays, for corrections.
    let is_done = wanted.is_some_and(|name| viewer.open_named(&name)) || !open;
    if !is_done {
        viewer.layout.gallery = Some(gallery);
    }
}

/// Shows a scene with its thumbnail.
fn entry(ui: &mut Ui, picture: &Picture) -> Response {
    let short = Path::new(&picture.name).file_name().map(|name| name.to_string_lossy());
    let name = short.unwrap_or(picture.name.as_str().into()).into_owned();
    let inner = ui.vertical(|ui| {
        ui.set_width(CELL);
        let button = match &picture.texture {
            Some(texture) => Button::image(Image::new((texture.id(), PICTURE))),
            None => Button::new(RichText::new("…").color(theme::FAINT)),
        };
        let caption = ui.label(RichText::new(name).small());
        let button = ui.add(button.min_size(PICTURE)).labelled_by(caption.id);
        let about = if picture.title.is_empty() { &picture.name } else { &picture.title };
        button.on_hover_text(about)
    });
    inner.inner
}
