//! Contact settings: which bodies meet, and their thickness, friction and restitution.

use crate::session::{Deed, MixedValue, Session};
use msd_core::scene::{do_meet, law_between};
use msd_core::{Select, Shell};
use msd_run::{Runner, on};
use msd_scene::schema::{BodyKey, TouchRow, WithRow};
use msd_scene::{Assignment, Edits, FileError, default_shell, touch_rows};
use std::collections::BTreeMap;

/// A number of how the selected bodies touch each other and themselves, or whether they do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TouchEdit {
    /// Whether they touch; those that did not, by default as a scene file has it.
    On(bool),
    /// Thickness, metres; at most four times the default.
    Thickness(f64),
    /// Coulomb's factor.
    Friction(f64),
    /// Coefficient of restitution.
    Restitution(f64),
    /// Coulomb's factor of a body and another one, in place of what follows from both.
    FrictionWith(usize, f64),
    /// Coefficient of restitution of a body and another one.
    RestitutionWith(usize, f64),
}

impl TouchEdit {
    /// What is set, in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            TouchEdit::On(_) => "touching",
            TouchEdit::Thickness(_) => "thickness of contact",
            TouchEdit::Friction(_) => "friction between bodies",
            TouchEdit::Restitution(_) => "restitution between bodies",
            TouchEdit::FrictionWith(..) => "friction between two bodies",
            TouchEdit::RestitutionWith(..) => "restitution between two bodies",
        }
    }
}

/// How the selected bodies touch: the numbers of those that do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchValues {
    /// Whether all of them do.
    pub on: bool,
    /// Thickness, metres; `None` where none of them does.
    pub thickness: Option<MixedValue>,
    /// Coulomb's factor.
    pub friction: Option<MixedValue>,
    /// Coefficient of restitution.
    pub restitution: Option<MixedValue>,
}

/// How the bodies of a run meet.
pub fn shells_of(runner: &Runner) -> &[Shell] {
    on!(runner, simulation => simulation.model().shells())
}

/// How the bodies of a session meet.
impl Session {
    /// How the selected bodies meet others.
    pub fn touch_values(&self) -> TouchValues {
        let shells = shells_of(self.runner());
        let all = self.rows_of(shells);
        let select = self.material().values().select;
        let chosen = || all.iter().enumerate().filter(|(body, _)| is_chosen(select, *body));
        let number = |number: fn(&Shell) -> f64| {
            MixedValue::of(chosen().filter_map(|(_, row)| *row).map(|row| number(&shells[row])))
        };
        TouchValues {
            on: chosen().count() != 0 && chosen().all(|(_, row)| row.is_some()),
            thickness: number(|shell| shell.thickness),
            friction: number(|shell| shell.friction),
            restitution: number(|shell| shell.restitution),
        }
    }

    /// The shell of each body, by its number.
    fn rows_of(&self, shells: &[Shell]) -> Vec<Option<usize>> {
        let bodies = &self.loaded().scene.bodies;
        let row = |body| shells.iter().position(|shell| shell.is_of(body));
        bodies.iter().map(row).collect()
    }

    /// The bodies that the selected one meets; none where all are selected.
    pub fn touch_partners(&self) -> Vec<usize> {
        let shells = shells_of(self.runner());
        let rows = self.rows_of(shells);
        let Select::Body(body) = self.material().values().select else { return Vec::new() };
        let Some(own) = rows.get(body).copied().flatten() else { return Vec::new() };
        let meets = |row: usize| row != own && do_meet(shells, [own, row]);
        (0..rows.len()).filter(|&other| rows[other].is_some_and(meets)).collect()
    }

    /// Friction and restitution of the selected body and one that it meets.
    pub fn touch_with(&self, other: usize) -> Option<[f64; 2]> {
        let Select::Body(body) = self.material().values().select else { return None };
        let shells = shells_of(self.runner());
        let rows = self.rows_of(shells);
        Some(law_between(shells, [rows[body]?, (*rows.get(other)?)?]))
    }

    /// Sets how the selected bodies meet each other and themselves.
    pub fn edit_touch(&mut self, edit: TouchEdit) {
        let begins = self.remember(Deed::Edit(edit.words()));
        let edits = self.touched(edit).map_err(|error| error.to_string());
        let edited = edits.and_then(|edits| {
            let shells = msd_scene::shells_of(&self.loaded.scene, edits.iter());
            let shells = shells.map_err(|error| error.to_string())?;
            let set = self.change(|runner| runner.set_shells(&shells));
            set.map_err(|error| error.to_string())?;
            self.material.set = edits;
            Ok(())
        });
        if edited.is_ok() {
            self.limit_of = self.runner().steps();
            self.record_start();
            self.restart_twin();
        } else if begins {
            self.undo.withdraw();
        }
        self.refusal = edited.err();
    }

    /// The keys that are set once the selected bodies touch as an edit says.
    fn touched(&self, edit: TouchEdit) -> Result<Edits, FileError> {
        let (scene, mut edits) = (&self.loaded.scene, self.material.set.clone());
        let select = self.material().values().select;
        let mut rows = touch_rows(scene, edits.iter())?;
        for body in (0..rows.len()).filter(|&body| is_chosen(select, body)) {
            let key = format!("bodies[{body}].touch");
            let is_written = scene.shell_of(&scene.bodies[body]).is_some();
            let mut number = |name: &str, value: f64| {
                if rows[body].is_some() {
                    edits.set(Assignment::new(&format!("{key}.{name}"), value));
                }
            };
            match edit {
                TouchEdit::On(on) if on == rows[body].is_some() => {}
                TouchEdit::On(on) => {
                    edits.forget(&key);
                    if on != is_written {
                        let row = on.then(BTreeMap::<(), ()>::new);
                        edits.set(Assignment::new(&key, row));
                    }
                }
                TouchEdit::Thickness(thickness) => {
                    let by_default = default_shell(scene, body);
                    let most = by_default.map_or(f64::INFINITY, |own| 4.0 * own.thickness);
                    number("thickness", thickness.min(most));
                }
                TouchEdit::Friction(friction) => number("friction", friction),
                TouchEdit::Restitution(restitution) => number("restitution", restitution),
                TouchEdit::FrictionWith(other, friction) => {
                    let pair = pair(&mut rows, [body, other]);
                    pair.into_iter().for_each(|pair| pair.friction = Some(friction));
                }
                TouchEdit::RestitutionWith(other, restitution) => {
                    let pair = pair(&mut rows, [body, other]);
                    pair.into_iter().for_each(|pair| pair.restitution = Some(restitution));
                }
            }
        }
        let is_pair = |edit: &Assignment| edit.key().ends_with(".touch.with");
        if matches!(edit, TouchEdit::FrictionWith(..) | TouchEdit::RestitutionWith(..)) {
            write_pairs(&rows, &mut edits);
        } else if edits.iter().any(is_pair) {
            write_pairs(&touch_rows(scene, edits.iter())?, &mut edits);
        }
        Ok(edits)
    }
}

/// How two bodies meet, in the row of the later one.
fn pair(rows: &mut [Option<TouchRow>], pair: [usize; 2]) -> Option<&mut WithRow> {
    let [first, last] = [pair[0].min(pair[1]), pair[0].max(pair[1])];
    let body = Some(BodyKey::Number(first as u64));
    let with = &mut rows.get_mut(last)?.as_mut()?.with;
    if !with.iter().any(|row| row.body == body) {
        with.push(WithRow { body: body.clone(), ..WithRow::default() });
    }
    with.iter_mut().find(|row| row.body == body)
}

/// Says of all bodies how each meets single others: a scene may say it with either of two.
fn write_pairs(rows: &[Option<TouchRow>], edits: &mut Edits) {
    for (body, row) in rows.iter().enumerate() {
        if let Some(row) = row {
            edits.set(Assignment::new(&format!("bodies[{body}].touch.with"), &row.with));
        }
    }
}

fn is_chosen(select: Select, body: usize) -> bool {
    matches!(select, Select::Body(chosen) if chosen == body) || select == Select::All
}
