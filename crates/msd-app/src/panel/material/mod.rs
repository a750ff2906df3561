//! Sliders for world, wind and the material of bodies, in engineering units if a body has a
//! material.

mod looks;

use super::{heading, heading_with, slider, theme};
use crate::session::{MaterialEdit, MixedValue, Session, TouchEdit, TouchValues};
use crate::viewer::{Command, Layout, Viewer};
use egui::{Button, Checkbox, ComboBox, Rect, RichText, Slider, SliderClamping, Ui};
use msd_core::{Friction, Select};
use msd_run::on;
use msd_scene::materials::{MATERIALS, Made, Named, Numbers};
use msd_scene::schema::find;
use msd_study::quantity::{quantity, read};
use std::ops::RangeInclusive;

/// Units that span many decades, and so need prefixes.
const PREFIXED: [&str; 4] = ["N/m", "Pa", "s", "m"];

/// Hovers and units of sliders without a key of a scene, by their labels.
const OWN: [(&str, &str, &str); 5] = [
    ("Pattern size", "Size of a square, a stripe or a thread; 0 for automatic", "m"),
    ("Rest length", "Factor of the rest lengths of the springs", " ×"),
    ("Mass", "Mass of each particle", " kg"),
    ("Gravity", "Acceleration downwards", " m/s²"),
    ("Friction", "Friction of planes and solids, by the law below", ""),
];

/// Returns hover and unit of a slider: those of its key, or its own.
fn meaning(label: &str, key: &str) -> (String, String) {
    let own = || OWN.into_iter().find(|(name, ..)| *name == label);
    match (find(key), own()) {
        (Some(key), _) => {
            let space = if key.unit.is_empty() || PREFIXED.contains(&key.unit) { "" } else { " " };
            (key.what().replace('`', ""), format!("{space}{}", key.unit))
        }
        (None, Some((_, about, unit))) => (about.into(), unit.into()),
        (None, None) => Default::default(),
    }
}

/// Shows the sliders for material and world.
pub(super) fn show(ui: &mut Ui, viewer: &mut Viewer) {
    let Layout { looks, landmarks, .. } = &mut viewer.layout;
    heading_with(ui, "Material", |ui| {
        let hover = "Finish, colours and pattern: appearance only, no effect on the simulation";
        let toggle = ui.toggle_value(looks, RichText::new("Look").small()).on_hover_text(hover);
        landmarks.insert("look", toggle.rect);
    });
    bodies(ui, &mut viewer.session);
    let stiffness = match viewer.session.material().selected() {
        Some((_, made)) => Some(material(ui, &mut viewer.session, made)),
        None => springs(ui, &mut viewer.session),
    };
    if let Some(rect) = stiffness {
        viewer.layout.landmarks.insert("stiffness", rect);
    }
    ui.horizontal(|ui| {
        // Small gaps, so that all three fit into the width of the panel.
        ui.spacing_mut().item_spacing.x = 3.0;
        let hover = "Make the current shape the rest shape (F)";
        if ui.button("Set rest shape").on_hover_text(hover).clicked() {
            viewer.command(Command::Freeze);
        }
        let reset = Button::new("Reset to scene");
        let session = &viewer.session;
        let edited = session.material().is_edited();
        let hover = "Restore material and world of the scene, and restart";
        if ui.add_enabled(edited, reset).on_hover_text(hover).clicked() {
            viewer.let_go();
            viewer.session.reset_material();
        }
        touch(ui, viewer);
    });
    touching(ui, &mut viewer.session);
    looks::show(ui, viewer);
    heading(ui, "World");
    world(ui, &mut viewer.session);
    wind(ui, viewer);
}

/// Shows the selection of bodies for the sliders, if there are several.
fn bodies(ui: &mut Ui, session: &mut Session) {
    let names: Vec<String> = on!(session.runner(), simulation => {
        simulation.model().bodies().iter().map(|body| body.name.clone()).collect()
    });
    if names.len() < 2 {
        return;
    }
    let select = session.material().values().select;
    let text = |select| match select {
        Select::Body(body) => names.get(body).map_or("?", |name| name.as_str()),
        _ => "all bodies",
    };
    ui.horizontal(|ui| {
        let name = super::left_label(ui, "Of");
        let combo = ComboBox::from_id_salt("body").selected_text(text(select));
        let shown = combo.show_ui(ui, |ui| {
            let choices = std::iter::once(Select::All).chain((0..names.len()).map(Select::Body));
            choices
                .filter(|&choice| {
                    let label = text(choice).to_owned();
                    super::listed(ui, choice == select, label).clicked()
                })
                .last()
        });
        shown.response.labelled_by(name.id);
        if let Some(choice) = shown.inner.flatten() {
            session.select(choice);
        }
    });
}

/// Shows a slider for a key of a scene, or for its own number, logarithmic from `least` on; returns
/// a new value.
fn change(
    ui: &mut Ui,
    (label, key): (&str, &str),
    value: MixedValue,
    range: RangeInclusive<f64>,
    least: f64,
) -> (Option<f64>, Rect) {
    let (about, unit) = meaning(label, key);
    let mut number = value.first;
    // Fewer decimals would round the least value to zero.
    let decimals = if 0.0 < least { 3.max((-least.log10()).ceil() as usize) } else { 2 };
    // A scene may exceed the range of the slider: only edits are clamped.
    let widget = Slider::new(&mut number, range)
        .clamping(SliderClamping::Edits)
        .logarithmic(0.0 < least)
        .smallest_positive(least.max(1e-9))
        .max_decimals(decimals);
    let widget = match PREFIXED.into_iter().find(|prefixed| *prefixed == unit) {
        // The first value would look like the value of all bodies.
        _ if value.mixed => widget.custom_formatter(|_, _| "mixed".to_owned()),
        None => widget.suffix(unit),
        Some(unit) => {
            widget.custom_formatter(move |value, _| quantity(value, unit)).custom_parser(
                // If the focus only passes, the text must not round the value: it has fewer digits.
                move |text| match text == quantity(value.first, unit) {
                    true => Some(value.first),
                    false => read(text, unit),
                },
            )
        }
    };
    let mut response = slider(ui, (label, &about), widget);
    if value.mixed {
        response = response
            .on_hover_text("Springs or particles differ; moving the slider sets all of them");
    }
    (response.changed().then_some(number), response.rect)
}

/// Shows the sliders of a body with a material; returns the place of its modulus.
fn material(ui: &mut Ui, session: &mut Session, made: Made) -> Rect {
    let number = |first: f64| MixedValue { first, mixed: false };
    let mut rect = names(ui, session, made);
    let mut edits = Vec::new();
    if let Some(young) = made.young {
        let (value, at) = change(ui, ("Young", "bodies.young"), number(young), 1e2..=1e12, 1e2);
        edits.extend(value.map(MaterialEdit::Young));
        rect = at;
    }
    if let Some(poisson) = made.poisson {
        ui.horizontal(|ui| {
            super::left_label(ui, "Poisson");
            ui.label(format!("{poisson:.2}"))
        })
        .response
        .on_hover_text(
            "Poisson's ratio, fixed by the scene file: springs and cells are built for it",
        );
    }
    let (key, most) = match made.young {
        Some(_) => ("bodies.density", 2e4),
        None => ("bodies.area_density", 1e2),
    };
    let density = number(made.density);
    let (value, _) = change(ui, ("Density", key), density, most * 1e-5..=most, most * 1e-5);
    edits.extend(value.map(MaterialEdit::Density));
    let loss = number(made.relaxation_time);
    let (value, _) = change(ui, ("Relaxation", "bodies.relaxation_time"), loss, 0.0..=1.0, 1e-6);
    edits.extend(value.map(MaterialEdit::RelaxationTime));
    if let Some(thickness) = made.thickness {
        let (value, _) =
            change(ui, ("Thickness", "bodies.thickness"), number(thickness), 1e-5..=0.1, 1e-5);
        edits.extend(value.map(MaterialEdit::Thickness));
    }
    if let Some(scale) = session.material().values().rest_scale {
        let (value, _) = change(ui, ("Rest length", ""), scale, 0.25..=4.0, 0.25);
        edits.extend(value.map(MaterialEdit::RestScale));
    }
    edits.into_iter().for_each(|edit| session.edit(edit));
    rect
}

/// Shows whether the selected bodies collide with others.
fn touch(ui: &mut Ui, Viewer { session, layout, .. }: &mut Viewer) {
    let TouchValues { mut on, thickness, .. } = session.touch_values();
    let is_mixed = !on && thickness.is_some();
    let hover = "Collide with other bodies that touch; sheets and ropes also with themselves";
    let touch = Checkbox::new(&mut on, "Collide").indeterminate(is_mixed);
    let touch = ui.add(touch).on_hover_text(hover);
    layout.landmarks.insert("touch", touch.rect);
    if touch.changed() {
        session.edit_touch(TouchEdit::On(on));
    }
}

/// Shows the contact sliders of the selected bodies.
fn touching(ui: &mut Ui, session: &mut Session) {
    let now = session.touch_values();
    let TouchValues { thickness: Some(thickness), friction, restitution, .. } = now else {
        return;
    };
    let (thickness, _) = change(ui, ("Gap", "bodies.touch.thickness"), thickness, 1e-5..=1.0, 1e-5);
    let friction = friction
        .and_then(|now| change(ui, ("Grip", "bodies.touch.friction"), now, 0.0..=2.0, 0.0).0);
    let restitution = restitution
        .and_then(|now| change(ui, ("Bounce", "bodies.touch.restitution"), now, 0.0..=1.0, 0.0).0);
    let edits = thickness.map(TouchEdit::Thickness).into_iter();
    let edits = edits.chain(friction.map(TouchEdit::Friction));
    edits.chain(restitution.map(TouchEdit::Restitution)).for_each(|edit| session.edit_touch(edit));
    touching_with(ui, session);
}

/// Shows the bodies that the selected one collides with, and the settings for one of these pairs.
fn touching_with(ui: &mut Ui, session: &mut Session) {
    let partners = session.touch_partners();
    if partners.is_empty() {
        return;
    }
    let bodies = &session.loaded().scene.bodies;
    let names: Vec<_> = partners.iter().map(|&body| (body, bodies[body].name.clone())).collect();
    let memory = ui.scope_id().with("touching with");
    let chosen = ui.data(|data| data.get_temp::<usize>(memory));
    let chosen = names.iter().find(|(body, _)| Some(*body) == chosen);
    ui.horizontal(|ui| {
        let label = super::left_label(ui, "With");
        let text = chosen.map_or("choose a body", |(_, name)| name);
        let combo = ComboBox::from_id_salt("touching with").selected_text(text);
        let shown = combo.show_ui(ui, |ui| {
            for (body, name) in &names {
                let is_chosen = chosen.is_some_and(|(chosen, _)| chosen == body);
                if super::listed(ui, is_chosen, name.as_str()).clicked() {
                    ui.data_mut(|data| data.insert_temp(memory, *body));
                }
            }
        });
        let hover = "Friction and restitution between this body and one other";
        shown.response.labelled_by(label.id).on_hover_text(hover);
    });
    let Some(&(other, _)) = chosen else { return };
    let Some([friction, restitution]) = session.touch_with(other) else { return };
    let number = |first: f64| MixedValue { first, mixed: false };
    let (friction, _) =
        change(ui, ("Pair grip", "bodies.touch.with.friction"), number(friction), 0.0..=2.0, 0.0);
    let (restitution, _) = change(
        ui,
        ("Pair bounce", "bodies.touch.with.restitution"),
        number(restitution),
        0.0..=1.0,
        0.0,
    );
    let edits = friction.map(|friction| TouchEdit::FrictionWith(other, friction)).into_iter();
    let edits = edits.chain(restitution.map(|now| TouchEdit::RestitutionWith(other, now)));
    edits.for_each(|edit| session.edit_touch(edit));
}

/// Shows the choice of a material by name, with its source; returns its place.
fn names(ui: &mut Ui, session: &mut Session, made: Made) -> Rect {
    let fits = |named: &&Named| match named.numbers {
        Numbers::Uniform { .. } => made.young.is_some(),
        // There is a single fabric in the list, so there is no choice.
        Numbers::Fabric { .. } => made.young.is_none() && made.material == Some(named.name),
    };
    let text = made.material.unwrap_or("custom");
    ui.horizontal(|ui| {
        let name = super::left_label(ui, "Material");
        let combo = ComboBox::from_id_salt("material").selected_text(text);
        let shown = combo.show_ui(ui, |ui| {
            let choices = MATERIALS.iter().filter(fits);
            choices
                .filter(|named| {
                    let label = super::listed(ui, made.material == Some(named.name), named.name);
                    label.on_hover_text(about(named)).clicked()
                })
                .last()
        });
        let response = shown.response.labelled_by(name.id);
        if let Some(named) = MATERIALS.iter().find(|named| made.material == Some(named.name)) {
            response.on_hover_text(about(named));
        }
        if let Some(named) = shown.inner.flatten() {
            session.edit(MaterialEdit::Named(named));
        }
        name.rect
    })
    .inner
}

/// Returns the source of a material and its remarks.
fn about(named: &Named) -> String {
    format!("{}\n{}", named.source, named.remarks)
}

fn springs(ui: &mut Ui, session: &mut Session) -> Option<Rect> {
    let shown = *session.material().values();
    if let Some(mass) = shown.mass
        && let (Some(value), _) = change(ui, ("Mass", ""), mass, 0.01..=100.0, 0.01)
    {
        session.edit(MaterialEdit::Mass(value));
    }
    let (Some(stiffness), Some(damping)) = (shown.stiffness, shown.damping) else { return None };
    let (value, rect) = change(ui, ("Stiffness", "bodies.stiffness"), stiffness, 0.0..=1e6, 0.1);
    if let Some(value) = value {
        session.edit(MaterialEdit::Stiffness(value));
    }
    if let (Some(value), _) = change(ui, ("Damping", "bodies.damping"), damping, 0.0..=1e3, 1e-3) {
        session.edit(MaterialEdit::Damping(value));
    }
    let resists_more = on!(session.runner(), simulation => {
        let model = simulation.model();
        0 < model.bends().count() + model.volumes().count()
    });
    if resists_more {
        let text = "springs only: bends and cells keep the values of the material";
        ui.label(RichText::new(text).small().color(theme::FAINT));
    }
    if let Some(scale) = shown.rest_scale
        && let (Some(value), _) = change(ui, ("Rest length", ""), scale, 0.25..=4.0, 0.25)
    {
        session.edit(MaterialEdit::RestScale(value));
    }
    Some(rect)
}

fn world(ui: &mut Ui, session: &mut Session) {
    let shown = *session.material().values();
    let gravity = MixedValue { first: shown.gravity, mixed: false };
    if let (Some(value), _) = change(ui, ("Gravity", ""), gravity, 0.0..=100.0, 0.1) {
        session.edit(MaterialEdit::Gravity(value));
    }
    let (Some(restitution), Some(friction)) = (shown.restitution, shown.friction) else {
        let has_planes = !session.loaded().scene.planes.is_empty();
        let text = if has_planes { "contact is switched off" } else { "no planes in this scene" };
        ui.label(RichText::new(text).small().color(theme::FAINT));
        return;
    };
    if let (Some(value), _) =
        change(ui, ("Restitution", "world.planes.restitution"), restitution, 0.0..=1.0, 0.0)
    {
        session.edit(MaterialEdit::Restitution(value));
    }
    let (value, most) = match friction {
        Friction::Coulomb(factor) => (factor, 2.0),
        Friction::TangentialLoss(loss) => (loss, 1.0),
    };
    let value = MixedValue { first: value, mixed: false };
    let law: fn(f64) -> Friction = match friction {
        Friction::Coulomb(_) => Friction::Coulomb,
        Friction::TangentialLoss(_) => Friction::TangentialLoss,
    };
    if let (Some(value), _) = change(ui, ("Friction", ""), value, 0.0..=most, 0.0) {
        session.edit(MaterialEdit::Friction(law(value)));
    }
    laws(ui, session, friction);
}

/// Shows the choice of a law of friction; both take a number from 0 to 1.
fn laws(ui: &mut Ui, session: &mut Session, friction: Friction) {
    ui.horizontal(|ui| {
        ui.add_space(super::COLUMN + 6.0);
        let (coulomb, value) = match friction {
            Friction::Coulomb(value) => (true, value),
            Friction::TangentialLoss(value) => (false, value),
        };
        let hover = "At most this factor times the normal impulse";
        if ui.selectable_label(coulomb, "Coulomb").on_hover_text(hover).clicked() {
            session.edit(MaterialEdit::Friction(Friction::Coulomb(value)));
        }
        let hover = "Share of the tangential speed lost per contact substep: depends on the step";
        if ui.selectable_label(!coulomb, "Tangential loss").on_hover_text(hover).clicked() {
            session.edit(MaterialEdit::Friction(Friction::TangentialLoss(value.min(1.0))));
        }
    });
}

/// Shows the strength of the wind and, while it blows, its heading and gusts.
fn wind(ui: &mut Ui, Viewer { session, layout, .. }: &mut Viewer) {
    let now = session.wind();
    let mut wanted = now;
    let number = |first: f64| MixedValue { first, mixed: false };
    let (value, rect) =
        change(ui, ("Wind", "world.wind.strength"), number(now.strength), 0.0..=100.0, 0.01);
    layout.landmarks.insert("wind", rect);
    wanted.strength = value.unwrap_or(now.strength);
    if 0.0 < now.strength {
        let heading = number(now.heading.to_degrees());
        let (value, rect) =
            change(ui, ("Heading", "world.wind.heading_deg"), heading, -180.0..=180.0, 0.0);
        layout.landmarks.insert("heading", rect);
        wanted.heading = value.map_or(now.heading, f64::to_radians);
        let (value, rect) =
            change(ui, ("Gusts", "world.wind.gusts"), number(now.gusts), 0.0..=1.0, 0.0);
        layout.landmarks.insert("gusts", rect);
        wanted.gusts = value.unwrap_or(now.gusts);
        let text = RichText::new("on every particle; 0° is along x").small().color(theme::FAINT);
        ui.label(text);
    }
    if wanted != now {
        session.set_wind(wanted);
    }
}
