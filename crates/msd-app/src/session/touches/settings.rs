//! Settings of touching: whether bodies do, and radius, stiffness and friction of their particles.
//!
//! What holds is in the run alone. It is set anew as a whole, as the pairs that do not touch follow
//! from radii and from where the particles are at rest.

use crate::session::{Deed, MixedValue, Session};
use msd_core::{Between, Body, Error, Scene, Select, Touch};
use msd_run::{Runner, on};
use msd_scene::default_touch;

/// A number of how the selected bodies touch each other and themselves, or whether they do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TouchEdit {
    /// Whether they touch; those that did not, by default as a scene file has it.
    On(bool),
    /// Radius of their particles, metres; at most twice the default.
    Radius(f64),
    /// Stiffness of their particles, newtons per metre; the damping goes with it.
    Stiffness(f64),
    /// Coulomb's factor.
    Friction(f64),
}

impl TouchEdit {
    /// What is set, in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            TouchEdit::On(_) => "touching",
            TouchEdit::Radius(_) => "radius",
            TouchEdit::Stiffness(_) => "stiffness of touches",
            TouchEdit::Friction(_) => "friction of touches",
        }
    }

    fn apply(self, touch: &mut Touch, widest: f64) {
        match self {
            TouchEdit::On(_) => {}
            TouchEdit::Radius(radius) => touch.radius = radius.min(widest),
            TouchEdit::Stiffness(stiffness) => {
                touch.damping *= stiffness / touch.stiffness;
                touch.stiffness = stiffness;
            }
            TouchEdit::Friction(friction) => touch.friction = friction,
        }
    }
}

/// How the selected bodies touch: the numbers of those that do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchValues {
    /// Whether all of them do.
    pub on: bool,
    /// Radius, metres; `None` where none of them does.
    pub radius: Option<MixedValue>,
    /// Stiffness, newtons per metre.
    pub stiffness: Option<MixedValue>,
    /// Coulomb's factor.
    pub friction: Option<MixedValue>,
}

/// The row of each body; `None` where a row is not of one body, and of all that touches of it.
pub fn touch_rows(rows: &[Touch], bodies: &[Body]) -> Option<Vec<Option<usize>>> {
    let mut of_bodies = vec![None; bodies.len()];
    for (row, touch) in rows.iter().enumerate() {
        // They are in order.
        let ends = [touch.particles.first(), touch.particles.last()];
        let is_of = |body: &Body| ends.iter().flatten().all(|end| body.particles.contains(*end));
        let body = bodies.iter().position(is_of)?;
        if of_bodies[body].replace(row).is_some() {
            return None;
        }
    }
    Some(of_bodies)
}

/// How particles touch: rows, and the pairs that do not.
pub fn touches_of(runner: &Runner) -> (&[Touch], &[[usize; 2]]) {
    on!(runner, simulation => simulation.model().touches().rows())
}

/// Lets a run touch as another does, or a scene.
pub(in crate::session) fn touch_as(
    runner: &mut Runner,
    (rows, exempt): (&[Touch], &[[usize; 2]]),
) -> Result<(), Error> {
    if touches_of(runner) == (rows, exempt) { Ok(()) } else { runner.set_touches(rows, exempt) }
}

/// How the bodies of a session touch.
impl Session {
    /// How the selected bodies touch; `None` where what touches is not body by body, and where
    /// bodies meet as shells.
    pub fn touch_values(&self) -> Option<TouchValues> {
        let (rows, _) = touches_of(self.runner());
        let (bodies, shells) = on!(self.runner(), simulation => {
            (simulation.model().bodies(), simulation.model().shells())
        });
        let all = touch_rows(rows, bodies).filter(|_| shells.is_empty())?;
        let select = self.material().values().select;
        let chosen = || all.iter().enumerate().filter(|(body, _)| is_chosen(select, *body));
        let number = |number: fn(&Touch) -> f64| {
            MixedValue::of(chosen().filter_map(|(_, row)| *row).map(|row| number(&rows[row])))
        };
        Some(TouchValues {
            on: chosen().count() != 0 && chosen().all(|(_, row)| row.is_some()),
            radius: number(|touch| touch.radius),
            stiffness: number(|touch| touch.stiffness),
            friction: number(|touch| touch.friction),
        })
    }

    /// Whether bodies touch otherwise than as the scene was loaded.
    pub fn is_touch_edited(&self) -> bool {
        let Scene { touches, exempt, .. } = &self.loaded().scene;
        touches_of(self.runner()) != (&**touches, &**exempt)
    }

    /// Lets bodies touch as in the scene that was loaded.
    pub(in crate::session) fn reset_touches(&mut self) {
        let Scene { touches, exempt, .. } = &self.loaded.scene;
        let (touches, exempt) = (touches.clone(), exempt.clone());
        let reset = self.change(|runner| touch_as(runner, (&touches, &exempt)));
        self.refuse(reset);
    }

    /// Sets how the selected bodies touch each other and themselves.
    pub fn edit_touch(&mut self, edit: TouchEdit) {
        let begins = self.remember(Deed::Edit(edit.words()));
        let edited = self.edited(edit).and_then(|Scene { touches, exempt, .. }| {
            let set = self.change(|runner| runner.set_touches(&touches, &exempt));
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

    /// The scene as it was loaded, with what touches as it is now and as an edit makes it.
    fn edited(&self, edit: TouchEdit) -> Result<Scene, String> {
        let (rows, kept) = touches_of(self.runner());
        let mut scene = self.loaded().scene.clone();
        let written = std::mem::take(&mut scene.touches);
        scene.exempt.clear();
        let unknown = "what touches is not body by body";
        let now = touch_rows(rows, &scene.bodies).ok_or(unknown)?;
        let first = touch_rows(&written, &scene.bodies).ok_or(unknown)?;
        let select = self.material().values().select;
        let mut of_bodies = vec![None; now.len()];
        for body in 0..now.len() {
            let is_chosen = is_chosen(select, body);
            let mut touch = now[body].map(|row| rows[row].clone());
            if is_chosen && edit == TouchEdit::On(false) {
                touch = None;
            }
            if is_chosen && edit == TouchEdit::On(true) && touch.is_none() {
                let as_written = first[body].map(|row| written[row].clone());
                let made = as_written.or_else(|| default_touch(&scene, body));
                let name = &scene.bodies[body].name;
                let why = "cannot touch: its springs say no radius or no stiffness";
                touch = Some(made.ok_or_else(|| format!("{name} {why}"))?);
            }
            let Some(mut touch) = touch else { continue };
            if is_chosen {
                let widest =
                    default_touch(&scene, body).map_or(f64::INFINITY, |own| 2.0 * own.radius);
                edit.apply(&mut touch, widest);
            }
            touch.ignored.clear();
            touch.between.clear();
            of_bodies[body] = Some(scene.touches.len());
            scene.add_touch(touch).map_err(|error| error.to_string())?;
        }
        for (body, row) in first.iter().enumerate() {
            let ignored = row.iter().flat_map(|&row| &written[row].ignored);
            for other in ignored.filter_map(|row| first.iter().position(|of| *of == Some(*row))) {
                if let (Some(a), Some(b)) = (of_bodies[body], of_bodies[other]) {
                    scene.touches[a.max(b)].ignored.push(a.min(b));
                }
            }
            for between in row.iter().flat_map(|&row| &written[row].between) {
                let other = first.iter().position(|of| *of == Some(between.row));
                let rows = (of_bodies[body], other.and_then(|other| of_bodies[other]));
                if let (Some(a), Some(b)) = rows {
                    let between = Between { row: a.min(b), ..*between };
                    scene.touches[a.max(b)].between.push(between);
                }
            }
        }
        // Where a saved run goes on, its particles are not where they are at rest.
        if self.loaded().progress.is_some() {
            scene.exempt = kept.to_vec();
        }
        Ok(scene)
    }
}

fn is_chosen(select: Select, body: usize) -> bool {
    matches!(select, Select::Body(chosen) if chosen == body) || select == Select::All
}
