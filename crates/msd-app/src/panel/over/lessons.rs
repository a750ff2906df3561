//! The lessons over the 3D view: a list, or a question with a field for the answer.

use crate::panel::{scroll, theme};
use crate::viewer::{Lessons, Viewer};
use egui::{Button, Key, RichText, ScrollArea, TextEdit, Ui, WidgetInfo, vec2};
use msd_scene::schema::LessonRow;
use msd_study::lesson::Grade;
use msd_study::quantity::rounded;

/// Width of the box, points.
const WIDTH: f32 = 300.0;

/// Shows the lessons, if they are open.
pub(super) fn show(ui: &Ui, viewer: &mut Viewer) {
    let Some(mut lessons) = viewer.layout.lessons.take() else { return };
    let lesson = viewer.session.loaded().lesson.clone().filter(|_| !lessons.is_list);
    let title = match &lesson {
        Some(_) => viewer.session.loaded().title.clone(),
        None => "Lessons".to_owned(),
    };
    let view = viewer.layout.rect;
    let mut is_open = true;
    let mut wanted = None;
    let window = egui::Window::new(title).id(egui::Id::unique("lessons")).open(&mut is_open);
    let window = window.resizable(false).constrain_to(view.shrink(6.0));
    window.default_pos(view.left_top() + vec2(14.0, 14.0)).show(ui.ctx(), |ui| {
        ui.set_width(WIDTH.min(view.width() - 50.0));
        let area = ScrollArea::vertical().max_height((view.height() - 70.0).max(80.0));
        scroll(ui, area, |ui| match lesson {
            Some(lesson) => wanted = question(ui, viewer, (&lesson, &mut lessons)),
            None => wanted = list(ui, viewer),
        });
    });
    viewer.layout.lessons = is_open.then_some(lessons);
    if let Some(at) = wanted {
        viewer.open_entry(at);
    }
}

/// Shows the list; returns the place of a chosen lesson in the catalogue.
fn list(ui: &mut Ui, viewer: &Viewer) -> Option<usize> {
    let mut wanted = None;
    let lessons = viewer.lessons();
    let done = lessons.iter().filter(|(_, is_done)| *is_done).count();
    ui.label(RichText::new(format!("{done} of {} done", lessons.len())).color(theme::FAINT));
    for (number, (at, is_done)) in (1..).zip(lessons) {
        let title = format!("{number}. {}", viewer.catalogue.entries[at].title);
        let is_current = viewer.current() == Some(at);
        let button = Button::selectable(is_current, title.as_str());
        let button = button.shortcut_text(if is_done { "done" } else { "" });
        let button = ui.add(button.min_size(vec2(ui.available_width(), 0.0)));
        let name = if is_done { format!("{title}, done") } else { title };
        button.widget_info(|| WidgetInfo::selected(egui::Role::Button, true, is_current, &name));
        if button.clicked() {
            wanted = Some(at);
        }
    }
    wanted
}

/// Shows a question; returns the place of the next lesson in the catalogue, if it was chosen.
fn question(
    ui: &mut Ui,
    viewer: &mut Viewer,
    (lesson, lessons): (&LessonRow, &mut Lessons),
) -> Option<usize> {
    ui.label(RichText::new(&lesson.question).strong());
    ui.add_space(4.0);
    for (number, step) in (1..).zip(&lesson.steps) {
        ui.label(format!("{number}. {step}"));
    }
    ui.add_space(4.0);
    if answer(ui, lesson, lessons) {
        viewer.check_answer(lessons);
    }
    match &lessons.grade {
        Some(Grade::Right(right)) => {
            ui.label(RichText::new(format!("Right: msd computes {right}.")).color(theme::GOOD));
            ui.label(&lesson.theory);
        }
        Some(Grade::Wrong(reason)) => _ = ui.label(RichText::new(reason).color(theme::WARN)),
        None => {}
    }
    ui.add_space(4.0);
    let mut wanted = None;
    ui.horizontal(|ui| {
        lessons.is_list = ui.button("All lessons").clicked();
        let all = viewer.lessons();
        let place = all.iter().position(|(at, _)| viewer.current() == Some(*at));
        let next = place.and_then(|place| all.get(place + 1));
        if let Some((at, _)) = next
            && ui.button("Next lesson").clicked()
        {
            wanted = Some(*at);
        }
    });
    wanted
}

/// Shows the field for the answer; returns whether it is to be checked.
fn answer(ui: &mut Ui, lesson: &LessonRow, lessons: &mut Lessons) -> bool {
    let percent = rounded(100.0 * lesson.tolerance, 2);
    let hover = format!("Accepted within {percent} %. {}", lesson.reason);
    ui.horizontal(|ui| {
        let name = ui.label("Answer");
        let field = TextEdit::singleline(&mut lessons.answer).desired_width(80.0);
        let field = ui.add(field).labelled_by(name.id).on_hover_text(hover);
        ui.label(lesson.answer.unit());
        let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let is_given = !lessons.answer.trim().is_empty();
        let is_pressed = ui.add_enabled(is_given, Button::new("Check")).clicked();
        is_given && (is_pressed || is_entered)
    })
    .inner
}
