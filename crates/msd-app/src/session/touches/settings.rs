//! Contact settings: pairs of colliding bodies, thickness, friction and restitution.

use crate::session::{Deed, MixedValue, Session};
use msd_core::scene::{do_meet, law_between};
use msd_core::{Select, Shell};
use msd_run::{Runner, on};
use msd_scene::schema::{BodyKey, TouchRow, WithRow};
use msd_scene::{Assignment, Edits, FileError, default_shell, touch_rows};
use std::collections::BTreeMap;

/// An edit of the contact of the selected bodies with each other and themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TouchEdit {
    /// Whether they collide; newly colliding bodies get the defaults of a scene file.
    On(bool),
    /// Thickness, metres; at most four times the default.
    Thickness(f64),
    /// Coulomb friction coefficient.
    Friction(f64),
    /// Coefficient of restitution.
    Restitution(f64),
    /// Coulomb friction coefficient for one other body, instead of the one derived from both.
    FrictionWith(usize, f64),
    /// Coefficient of restitution for one other body.
    RestitutionWith(usize, f64),
}

impl TouchEdit {
    /// Returns the edited property in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            TouchEdit::On(_) => "touching",
            TouchEdit::Thickness(_) => "contact thickness",
            TouchEdit::Friction(_) => "friction between bodies",
            TouchEdit::Restitution(_) => "restitution between bodies",
            TouchEdit::FrictionWith(..) => "friction between two bodies",
            TouchEdit::RestitutionWith(..) => "restitution between two bodies",
        }
    }
}

/// Contact of the selected bodies; the numbers are of those that collide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchValues {
    /// Whether all of them collide.
    pub on: bool,
    /// Thickness, metres; `None` if none of them collides.
    pub thickness: Option<MixedValue>,
    /// Coulomb friction coefficient.
    pub friction: Option<MixedValue>,
    /// Coefficient of restitution.
    pub restitution: Option<MixedValue>,
}

/// Returns the contact shells of a run.
pub fn shells_of(runner: &Runner) -> &[Shell] {
    on!(runner, simulation => simulation.model().shells())
}

/// Contact between the bodies of a session.
impl Session {
    /// Returns the contact settings of the selected bodies.
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

    /// Returns the index of the shell of each body.
    fn rows_of(&self, shells: &[Shell]) -> Vec<Option<usize>> {
        let bodies = &self.loaded().scene.bodies;
        let row = |body| shells.iter().position(|shell| shell.is_of(body));
        bodies.iter().map(row).collect()
    }

    /// Returns the bodies that the selected one collides with; none if all are selected.
    pub fn touch_partners(&self) -> Vec<usize> {
        let shells = shells_of(self.runner());
        let rows = self.rows_of(shells);
        let Select::Body(body) = self.material().values().select else { return Vec::new() };
        let Some(own) = rows.get(body).copied().flatten() else { return Vec::new() };
        let meets = |row: usize| row != own && do_meet(shells, [own, row]);
        (0..rows.len()).filter(|&other| rows[other].is_some_and(meets)).collect()
    }

    /// Returns friction and restitution of the selected body and one that it collides with.
    pub fn touch_with(&self, other: usize) -> Option<[f64; 2]> {
        let Select::Body(body) = self.material().values().select else { return None };
        let shells = shells_of(self.runner());
        let rows = self.rows_of(shells);
        Some(law_between(shells, [rows[body]?, (*rows.get(other)?)?]))
    }

    /// Edits the contact of the selected bodies with each other and themselves.
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

    /// Returns the edits of the scene after a contact edit.
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

/// Returns the settings of a pair of bodies, in the row of the later one.
fn pair(rows: &mut [Option<TouchRow>], pair: [usize; 2]) -> Option<&mut WithRow> {
    let [first, last] = [pair[0].min(pair[1]), pair[0].max(pair[1])];
    let body = Some(BodyKey::Number(first as u64));
    let with = &mut rows.get_mut(last)?.as_mut()?.with;
    if !with.iter().any(|row| row.body == body) {
        with.push(WithRow { body: body.clone(), ..WithRow::default() });
    }
    with.iter_mut().find(|row| row.body == body)
}

/// Sets the pair keys of all bodies, as a scene may have a pair at either body.
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
