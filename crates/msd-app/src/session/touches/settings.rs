//! Contact settings: which bodies meet, and their thickness, friction and restitution.
//!
//! What holds is in the run alone.

use crate::session::{Deed, MixedValue, Session};
use msd_core::scene::{Between, do_meet, law_between};
use msd_core::{Body, Error, Select, Shell};
use msd_run::{Runner, on};
use msd_scene::default_shell;
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

    fn apply(self, shell: &mut Shell, thickest: f64) {
        match self {
            TouchEdit::On(_) | TouchEdit::FrictionWith(..) | TouchEdit::RestitutionWith(..) => {}
            TouchEdit::Thickness(thickness) => shell.thickness = thickness.min(thickest),
            TouchEdit::Friction(friction) => shell.friction = friction,
            TouchEdit::Restitution(restitution) => shell.restitution = restitution,
        }
    }

    /// Sets how one of the bodies meets another.
    fn apply_to_pair(self, body: usize, pairs: &mut BTreeMap<[usize; 2], PairValues>) {
        let pair = |other: usize| [body.min(other), body.max(other)];
        match self {
            TouchEdit::FrictionWith(other, friction) => {
                pairs.entry(pair(other)).or_default().friction = Some(friction);
            }
            TouchEdit::RestitutionWith(other, restitution) => {
                pairs.entry(pair(other)).or_default().restitution = Some(restitution);
            }
            _ => {}
        }
    }
}

/// How two bodies meet, in place of what follows from both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairValues {
    /// Coulomb's factor.
    pub friction: Option<f64>,
    /// Coefficient of restitution.
    pub restitution: Option<f64>,
}

/// The values of each pair of bodies that has its own, by the numbers of the bodies, the lower one
/// first.
pub fn pairs_of(shells: &[Shell], bodies: &[Body]) -> BTreeMap<[usize; 2], PairValues> {
    let body = |row: usize| bodies.iter().position(|body| shells[row].is_of(body));
    let pairs = (0..shells.len()).flat_map(|row| {
        shells[row].between.iter().filter_map(move |between| {
            let &Between { shell, friction, restitution } = between;
            Some(([body(shell)?, body(row)?], PairValues { friction, restitution }))
        })
    });
    pairs.collect()
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

/// Lets the bodies of a run meet as those of another do.
pub(in crate::session) fn meet_as(runner: &mut Runner, shells: &[Shell]) -> Result<(), Error> {
    if shells_of(runner) == shells { Ok(()) } else { runner.set_shells(shells) }
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

    /// Whether bodies meet otherwise than as the scene was loaded.
    pub fn is_touch_edited(&self) -> bool {
        shells_of(self.runner()) != self.loaded().scene.shells
    }

    /// Lets bodies meet as in the scene that was loaded.
    pub(in crate::session) fn reset_touches(&mut self) {
        let shells = self.loaded.scene.shells.clone();
        let reset = self.change(|runner| meet_as(runner, &shells));
        self.refuse(reset);
    }

    /// Sets how the selected bodies meet each other and themselves.
    pub fn edit_touch(&mut self, edit: TouchEdit) {
        let begins = self.remember(Deed::Edit(edit.words()));
        let edited = self.edited(edit).and_then(|shells| {
            let set = self.change(|runner| runner.set_shells(&shells));
            set.map_err(|error| error.to_string())
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

    /// The shells as they are now and as an edit makes them.
    fn edited(&self, edit: TouchEdit) -> Result<Vec<Shell>, String> {
        let scene = &self.loaded().scene;
        let (written, shells) = (&scene.shells, shells_of(self.runner()));
        let (now, first) = (self.rows_of(shells), self.rows_of(written));
        let select = self.material().values().select;
        let (mut edited, mut of_bodies) = (Vec::new(), vec![None; now.len()]);
        for body in 0..now.len() {
            let is_chosen = is_chosen(select, body);
            let mut shell = now[body].map(|row| shells[row].clone());
            if is_chosen && edit == TouchEdit::On(false) {
                shell = None;
            }
            if is_chosen && edit == TouchEdit::On(true) && shell.is_none() {
                let as_written = first[body].map(|row| written[row].clone());
                let made = as_written.or_else(|| default_shell(scene, body));
                let name = &scene.bodies[body].name;
                let why = "cannot touch: it has no springs, from which its thickness follows";
                shell = Some(made.ok_or_else(|| format!("{name} {why}"))?);
            }
            let Some(mut shell) = shell else { continue };
            if is_chosen {
                let by_default = default_shell(scene, body);
                let thickest = by_default.map_or(f64::INFINITY, |own| 4.0 * own.thickness);
                edit.apply(&mut shell, thickest);
            }
            shell.ignored.clear();
            shell.between.clear();
            of_bodies[body] = Some(edited.len());
            edited.push(shell);
        }
        let place = |row: usize| {
            let body = first.iter().position(|of| *of == Some(row))?;
            of_bodies[body]
        };
        for (row, shell) in written.iter().enumerate() {
            let Some(own) = place(row) else { continue };
            // Bodies keep their order, and so do their shells.
            edited[own].ignored.extend(shell.ignored.iter().filter_map(|&other| place(other)));
        }
        // Those of bodies that touch hold as they are now, those of others as written.
        let mut pairs = pairs_of(written, &scene.bodies);
        pairs.retain(|pair, _| pair.iter().any(|&body| now[body].is_none()));
        pairs.extend(pairs_of(shells, &scene.bodies));
        let chosen = (0..now.len()).filter(|&body| is_chosen(select, body));
        chosen.for_each(|body| edit.apply_to_pair(body, &mut pairs));
        for ([first, last], PairValues { friction, restitution }) in pairs {
            if let (Some(shell), Some(own)) = (of_bodies[first], of_bodies[last]) {
                edited[own].between.push(Between { shell, friction, restitution });
            }
        }
        Ok(edited)
    }
}

fn is_chosen(select: Select, body: usize) -> bool {
    matches!(select, Select::Body(chosen) if chosen == body) || select == Select::All
}
