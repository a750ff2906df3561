//! The left panel: list of scenes, drag tools, view options, camera, selected particle.

use super::heading;
use crate::viewer::{Command, Tool, Viewer};
use egui::{Button, Checkbox, ComboBox, Id, RichText, ScrollArea, Ui, WidgetInfo};
use msd_render::{Quality, Quantity};

/// Shows the left panel.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    list(ui, viewer);
    view(ui, viewer);
}

/// Shows the part below the list.
pub(super) fn view(ui: &mut Ui, viewer: &mut Viewer) {
    tools(ui, viewer);
    toggles(ui, viewer);
    camera(ui, viewer);
    keep(ui, viewer);
    #[cfg(not(target_arch = "wasm32"))]
    film(ui, viewer);
    window(ui, viewer);
    particle(ui, viewer);
}

/// Number of visible scenes; the list scrolls to the others.
const ROWS: f32 = 11.0;

fn list(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Scenes");
    let mut wanted = None;
    ui.spacing_mut().item_spacing.y = 1.0;
    let gap = ui.spacing().item_spacing.y;
    let row = ui.spacing().interact_size.y + gap;
    // Whole rows: the permanent scroll bar shows that there are more.
    let area = ScrollArea::vertical().id_salt("list").max_height(ROWS * row - gap);
    // Scrolls to the current scene only once, so that the user can scroll on.
    let key = Id::unique("scene in sight");
    let current = Some(viewer.current());
    let is_new = ui.data(|data| data.get_temp(key)) != current;
    ui.data_mut(|data| data.insert_temp(key, viewer.current()));
    super::scroll(ui, area, |ui| {
        let entries = viewer.catalogue.entries.iter().enumerate();
        for (index, entry) in entries.filter(|(_, entry)| !entry.is_lesson) {
            let key = if index < 9 { (index + 1).to_string() } else { String::new() };
            let button = Button::selectable(viewer.current() == Some(index), entry.name)
                .shortcut_text(key)
                .min_size(egui::vec2(ui.available_width(), 0.0));
            let button = ui.add(button).on_hover_text(entry.title);
            if is_new && viewer.current() == Some(index) {
                button.scroll_to_me(None);
            }
            if button.clicked() {
                wanted = Some(index);
            }
        }
    });
    // The scene of a file or a mesh stays accessible.
    let mut back = false;
    if let Some(opened) = viewer.opened() {
        // By file name: the scene itself may have the name of a built-in scene.
        let file = opened.files.first().and_then(|file| file.file_name());
        let name = file.map_or((&*opened.name).into(), |file| file.to_string_lossy());
        let button = Button::selectable(viewer.current().is_none(), name)
            .truncate()
            .min_size(egui::vec2(ui.available_width(), 0.0));
        back = ui.add(button).on_hover_text(&*opened.title).clicked();
    }
    ui.spacing_mut().item_spacing.y = 3.0;
    if !viewer.layout.in_page {
        ui.horizontal(|ui| {
            if ui.button("Open…").on_hover_text("Scene thumbnails, and files (O)").clicked() {
                viewer.command(Command::Open);
            }
            let hover = "Eight questions about springs, steps and friction";
            let lessons = ui.button("Lessons").on_hover_text(hover);
            viewer.layout.landmarks.insert("lessons", lessons.rect);
            if lessons.clicked() {
                viewer.command(Command::Lessons);
            }
        });
    }
    if let Some(index) = wanted {
        viewer.open_entry(index);
    }
    if back {
        viewer.reopen();
    }
}

/// Shows the tools for a drag with the left button.
fn tools(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Drag to");
    const TOOLS: [(Tool, &str, &str); 3] = [
        (Tool::Grab, "Grab", "Grab a particle or its group, and throw it (Esc)"),
        (Tool::Select, "Box", "Select the particles in a box as a group (B, or Ctrl)"),
        (Tool::Cut, "Cut", "Cut every spring under the stroke, including hidden ones (C)"),
    ];
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (tool, name, hover) in TOOLS {
            let button = ui.selectable_label(viewer.hand.tool == tool, name).on_hover_text(hover);
            viewer.layout.landmarks.insert(name, button.rect);
            if button.clicked() {
                viewer.hand.tool = tool;
            }
        }
    });
    let count = viewer.session.group().len();
    if 0 < count {
        let text = RichText::new(format!("group of {count} particles")).small().weak();
        ui.label(text).on_hover_text("Drag one of them; Esc clears the group");
    }
}

fn toggles(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Show");
    let style = &mut viewer.style;
    // Reduced graphics draw no grid.
    let has_grid = viewer.quality == Quality::Full;
    ui.horizontal(|ui| {
        ui.checkbox(&mut style.surfaces, "Surface");
        ui.checkbox(&mut style.pattern, "Pattern");
    });
    ui.horizontal(|ui| {
        ui.checkbox(&mut style.wireframe, "Wireframe").on_hover_text("W");
        ui.add_enabled(has_grid, Checkbox::new(&mut style.grid, "Grid"))
            .on_disabled_hover_text("No grid on the ground without a GPU");
    });
    ui.checkbox(&mut style.particles, "Particles");
    ui.checkbox(&mut style.shadows, "Shadows");
    if viewer.quality == Quality::Fast {
        let mut is_half = viewer.sharpness.is_half();
        let hover = "Half the pixels in each direction, up to four times as fast; switched on \
                     automatically below 20 frames per second";
        if ui.checkbox(&mut is_half, "Half resolution").on_hover_text(hover).changed() {
            viewer.sharpness.set(is_half);
        }
    }
    colours(ui, viewer);
}

/// Shows the choice of the quantity that colours represent.
fn colours(ui: &mut Ui, viewer: &mut Viewer) {
    let now = viewer.style.colour_by;
    let text = |quantity: Option<Quantity>| quantity.map_or("body", Quantity::name);
    ui.horizontal(|ui| {
        let name = ui.label("Colour by");
        let combo = ComboBox::from_id_salt("colour by").width(70.0).selected_text(text(now));
        let shown = combo.show_ui(ui, |ui| {
            let choices = std::iter::once(None).chain(Quantity::ALL.map(Some));
            let clicked = |&choice: &Option<Quantity>| {
                let label = super::listed(ui, choice == now, text(choice));
                label.on_hover_text(meaning(choice)).clicked()
            };
            choices.filter(clicked).last()
        });
        let response = shown.response.labelled_by(name.id).on_hover_text(meaning(now));
        viewer.layout.landmarks.insert("colour by", response.rect);
        if let Some(choice) = shown.inner.flatten() {
            viewer.colour_by(choice);
        }
    });
}

/// Explains the colours.
fn meaning(quantity: Option<Quantity>) -> &'static str {
    match quantity {
        None => "Bodies have their own colours",
        Some(Quantity::Strain) => "Springs: compressed blue, at rest grey, stretched red",
        Some(Quantity::Force) => "Springs with their dampers: pushes blue, none grey, pulls red",
        Some(Quantity::Energy) => "Elastic energy of each spring, dark to light",
        Some(Quantity::Speed) => "Particles and surfaces, slow dark to fast light",
        Some(Quantity::Error) => "Particles and surfaces by their estimated error, dark to light",
    }
}

fn camera(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Camera");
    ui.horizontal(|ui| {
        let hover = "Frame the whole scene (A)";
        if !viewer.layout.in_page && ui.button("Frame all").on_hover_text(hover).clicked() {
            viewer.command(Command::FrameAll);
        }
        ui.checkbox(&mut viewer.aim.follow, "Follow").on_hover_text("Keep the scene in the middle");
    });
    let hover = "Link with scene, settings and camera, for the web page, msd view and msd run";
    if !viewer.layout.in_page && ui.button("Copy link").on_hover_text(hover).clicked() {
        viewer.copy_link();
    }
}

/// Shows the buttons for saving.
fn keep(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Save");
    const KEEP: [(&str, Command, &str); 3] = [
        ("Save run", Command::SaveRun, "The run in its current state, to resume later (S)"),
        ("Save scene", Command::SaveScene, "The scene with the current values (Ctrl + S)"),
        ("Copy command", Command::CopyCommand, "The command line for this view (Ctrl + C)"),
    ];
    for (name, command, hover) in KEEP {
        if viewer.layout.in_page && command == Command::SaveRun {
            continue;
        }
        if ui.button(name).on_hover_text(hover).clicked() {
            viewer.command(command);
        }
    }
}

/// Shows the film of the last seconds, or its progress.
#[cfg(not(target_arch = "wasm32"))]
fn film(ui: &mut Ui, viewer: &mut Viewer) {
    use crate::viewer::FilmFormat::{Mp4, Png, WebP};
    if let Some(filming) = &viewer.filming {
        let [done, all] = filming.progress();
        ui.label(RichText::new(format!("frame {done} of {all}")).small().weak());
        let cancel = ui.button("Cancel film");
        viewer.layout.landmarks.insert("cancel film", cancel.rect);
        if cancel.clicked() {
            filming.cancel();
        }
        return;
    }
    const FORMATS: [(&str, &str, crate::viewer::FilmFormat); 3] = [
        ("Film", "as an animated WebP, some 0.3 MB a second", WebP),
        ("PNG", "as a PNG per frame, lossless", Png),
        ("MP4", "as an MP4 (needs ffmpeg)", Mp4),
    ];
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (name, hover, format) in FORMATS {
            let hover = format!("Film the states of the timeline with the current view, {hover}");
            let button = ui.button(name).on_hover_text(hover);
            viewer.layout.landmarks.insert(name, button.rect);
            if button.clicked() {
                viewer.film(format);
            }
        }
    });
}

/// Shows the options of the window itself.
fn window(ui: &mut Ui, viewer: &mut Viewer) {
    heading(ui, "Window");
    let light = ui.checkbox(&mut viewer.layout.light, "Light theme");
    viewer.layout.landmarks.insert("light", light.rect);
    let hover = "Fill the screen (F11)";
    ui.checkbox(&mut viewer.wishes.full_screen, "Full screen").on_hover_text(hover);
    if !viewer.layout.in_page {
        ui.horizontal(|ui| {
            if ui.button("Hide panels").on_hover_text("H brings them back").clicked() {
                viewer.command(Command::Panels);
            }
            if ui.button("Tour").on_hover_text("Five-step tour").clicked() {
                viewer.command(Command::Guide);
            }
        });
    }
    ui.horizontal(|ui| {
        ui.label("UI scale").on_hover_text("Of text and controls (Ctrl + and Ctrl -)");
        let scale = ui.ctx().zoom_factor();
        for (sign, name, factor) in [("−", "Smaller", 1.0 / 1.1), ("+", "Larger", 1.1)] {
            let button = ui.button(sign);
            button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, name));
            if button.clicked() {
                ui.ctx().set_zoom_factor((scale * factor).clamp(0.5, 3.0));
            }
        }
    });
}

fn particle(ui: &mut Ui, viewer: &mut Viewer) {
    let Some(particle) = viewer.session.selected() else { return };
    heading(ui, "Particle");
    let pinned = viewer.session.is_pinned(particle);
    let state = if pinned { "pinned" } else { "free" };
    ui.label(format!("number {particle}, {state}"));
    ui.label(RichText::new(place(viewer, particle)).small().weak());
    let text = if pinned { "Unpin" } else { "Pin" };
    if ui.button(text).on_hover_text("P, also while dragging").clicked() {
        viewer.session.pin_toggle(particle);
    }
}

fn place(viewer: &Viewer, particle: usize) -> String {
    let at = viewer.session.position(particle);
    format!("{:.2}, {:.2}, {:.2} m", at.x, at.y, at.z)
}
