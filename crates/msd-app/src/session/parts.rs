//! Model terms that the user can switch off and on again during a run.

use super::run::{Reading, Run};
use super::{Deed, Session};
use glam::DVec3;
use msd_core::{Interaction, Model, Plane, Real, Scene, Select, Vector};
use msd_run::live::{keep_off, made_bodies, off, off_again, parts_off, select, set_all};
use msd_run::{Runner, on};
use msd_scene::keys::Live;
use msd_scene::parts::Part;
use msd_scene::schema::Solver;
use msd_scene::{AnyState, Assignment, Edits, Loaded, Precision};
use std::ops::Range;

/// A term of a scene, with its springs.
type Kind = (Part, Vec<Range<usize>>);

/// The terms of the scene of a session, and whether each is on.
#[derive(Debug, Default)]
pub struct Parts {
    /// Found once, at the first use.
    kinds: Option<Vec<Kind>>,
    now: Option<Reading<Vec<(Part, bool)>>>,
}

impl Parts {
    /// Reads the terms of a run again if it was changed.
    pub(super) fn refresh(&mut self, run: &Run, loaded: &Loaded) {
        if self.now.as_ref().is_some_and(|now| now.of(run).is_some()) {
            return;
        }
        let kinds = self.kinds.get_or_insert_with(|| kinds(&loaded.scene));
        let now = kinds.iter().map(|kind| (kind.0, is_on(kind, run.runner()))).collect();
        self.now = Some(Reading::new(now, run));
    }

    fn of(&self, run: &Run) -> &[(Part, bool)] {
        self.now.as_ref().and_then(|now| now.of(run)).map_or(&[], Vec::as_slice)
    }
}

fn kinds(scene: &Scene) -> Vec<Kind> {
    Part::ALL.into_iter().filter_map(|part| Some((part, part.found_in(scene)?))).collect()
}

fn is_on((part, springs): &Kind, runner: &Runner) -> bool {
    on!(runner, simulation => is_on_in(*part, springs, simulation.model()))
}

fn is_on_in<R: Real>(part: Part, springs: &[Range<usize>], model: &Model<R>) -> bool {
    match part {
        Part::Damping => (0..model.ends().len()).any(|row| model.damping(row) != R::ZERO),
        Part::Gravity => model.gravity().to_f64() != DVec3::ZERO,
        Part::Drag => model.drag() != R::ZERO,
        // Planes can be removed and put back, solids and shells cannot.
        Part::Contact => {
            !model.do_bodies_meet() && model.solids().is_empty() && !model.planes().is_empty()
        }
        Part::FaceDiagonals | Part::SpaceDiagonals | Part::BendingSprings => {
            let mut rows = springs.iter().cloned().flatten();
            rows.any(|row| model.stiffness(row) != R::ZERO || model.damping(row) != R::ZERO)
        }
    }
}

impl Session {
    /// Returns the terms of the scene, and whether each is on; empty before
    /// [`Session::look_at_parts`].
    pub fn parts(&self) -> &[(Part, bool)] {
        self.parts.of(&self.run)
    }

    /// Reads the terms of the model; call it before they are shown.
    pub fn look_at_parts(&mut self) {
        self.parts.refresh(&self.run, &self.loaded);
    }

    /// Switches a term of the model off, or on with the values of the scene and its edits, as a
    /// single edit.
    ///
    /// Before contact returns, bodies that fell through an obstacle are lifted out of it.
    pub fn switch(&mut self, part: Part, on: bool) {
        let mut parts = parts_off(&self.material.set);
        parts.retain(|&other| other != part);
        if !on {
            parts.push(part);
        }
        let mut set = self.material.set.clone();
        keep_off(&parts, &mut set);
        let acts = match on {
            true => self.again(part, &set),
            false => Ok(off(part, &self.loaded)),
        };
        let mut acts = match acts {
            Ok(acts) if acts.is_empty() => return,
            Ok(acts) => acts,
            Err(refusal) => return self.refusal = Some(refusal),
        };
        // The edits set all springs; springs of the kinds that are off must stay off.
        acts.extend(off_again(&parts, &acts, &self.loaded));
        self.remember(Deed::Switch(part.name()));
        if part == Part::Contact && on {
            self.lift();
        }
        if self.act_all(&acts) {
            self.material.set = set;
        } else {
            self.undo.withdraw();
        }
    }

    /// Returns the terms that stay off after keys are set.
    pub(super) fn off_but_for(&self, keys: &[Assignment]) -> Vec<Part> {
        let mut parts = parts_off(&self.material.set);
        parts.retain(|&part| !keys.iter().any(|key| sets(key, part)));
        parts
    }

    /// Returns the interactions that switch on the terms that keys are about to set.
    pub(super) fn on_again(&self, keys: &[Assignment]) -> Vec<Interaction> {
        let (before, after) = (parts_off(&self.material.set), self.off_but_for(keys));
        let mut set = self.material.set.clone();
        keep_off(&after, &mut set);
        let on = before.into_iter().filter(|part| !after.contains(part));
        on.flat_map(|part| self.again(part, &set).unwrap_or_default()).collect()
    }

    /// Returns the interactions that give a term the values of the scene and its edits.
    fn again(&self, part: Part, set: &Edits) -> Result<Vec<Interaction>, String> {
        // In double precision no number of the scene is rounded.
        let settings = self.runner().settings();
        let solver = Solver { settings, precision: Precision::F64, automatic: false };
        let whole = Runner::open_with(&self.loaded, solver);
        let mut whole = whole.map_err(|error| error.to_string())?;
        set_all(&mut whole, &self.loaded, set)?;
        let Scene { springs, planes, world, .. } = whole.progress().0;
        match part {
            Part::Gravity => return Ok(vec![Interaction::SetGravity { value: world.gravity }]),
            Part::Drag => return Ok(vec![Interaction::SetDrag { value: world.drag }]),
            Part::Contact => {
                let add = |plane| Interaction::AddPlane { plane };
                return Ok(planes.into_iter().map(add).collect());
            }
            _ => {}
        }
        let rows: Vec<usize> = match part {
            Part::Damping => (0..springs.len()).collect(),
            _ => part.found_in(&self.loaded.scene).into_iter().flatten().flatten().collect(),
        };
        let dampings = runs((&rows, springs.len()), |row| springs[row].damping);
        let damping = |(springs, value)| Interaction::SetDamping { springs, value };
        let mut edits: Vec<Interaction> = dampings.into_iter().map(damping).collect();
        if part == Part::Damping {
            // One edit per body of a material, with the ratio of one of its springs.
            let time = |bodies: Select| {
                let Select::Body(body) = bodies else { return None };
                let mut rows = springs[self.loaded.scene.bodies[body].springs.clone()].iter();
                let spring = rows.find(|spring| 0.0 < spring.stiffness)?;
                let value = spring.damping / spring.stiffness;
                Some(Interaction::SetRelaxationTime { bodies, value })
            };
            edits.extend(made_bodies(&self.loaded).filter_map(time));
        } else {
            let runs = runs((&rows, springs.len()), |row| springs[row].stiffness);
            let stiffness = |(springs, value)| Interaction::SetStiffness { springs, value };
            edits.extend(runs.into_iter().map(stiffness));
        }
        Ok(edits)
    }

    /// Lifts every body out of the planes of the scene, and clears the history.
    pub(super) fn lift(&mut self) {
        let planes = self.loaded.scene.planes.clone();
        let lifted = self.change(|runner| lift(runner, &planes));
        match lifted {
            Ok(false) => {}
            Ok(true) => {
                self.history.clear();
                self.record_start();
                self.restart_twin();
            }
            Err(error) => self.refusal = Some(error.to_string()),
        }
    }
}

/// Returns whether a key sets a term.
fn sets(key: &Assignment, part: Part) -> bool {
    match key.live() {
        Live::Gravity => part == Part::Gravity,
        Live::Drag => part == Part::Drag,
        Live::Damping | Live::RelaxationTime | Live::Material => part == Part::Damping,
        _ => false,
    }
}

/// Returns the ranges of consecutive rows of equal value, with that value; `count` is of all rows.
fn runs((rows, count): (&[usize], usize), value: impl Fn(usize) -> f64) -> Vec<(Select, f64)> {
    let goes_on = |a: &usize, b: &usize| a + 1 == *b && value(*a) == value(*b);
    let runs = rows.chunk_by(goes_on);
    runs.map(|run| (select(run[0]..run[run.len() - 1] + 1, count), value(run[0]))).collect()
}

/// Moves each body, and each particle outside bodies, along the normal out of one plane after the
/// other, pins included. Contact resolves a body that a later plane pushes into an earlier one.
/// Returns whether anything was moved.
pub(super) fn lift(runner: &mut Runner, planes: &[Plane]) -> Result<bool, msd_core::Error> {
    let (count, bodies): (usize, Vec<Range<usize>>) = on!(&*runner, simulation => {
        let model = simulation.model();
        (model.particle_count(), model.bodies().iter().map(|body| body.particles.clone()).collect())
    });
    let is_free = |particle: &usize| !bodies.iter().any(|body| body.contains(particle));
    let alone = (0..count).filter(is_free).map(|particle| particle..particle + 1);
    let groups: Vec<Range<usize>> = bodies.iter().cloned().chain(alone).collect();
    let steps = runner.steps();
    let mut state = runner.state();
    let is_moved = match &mut state {
        AnyState::F32(state) => lift_all(&mut state.positions, &groups, planes),
        AnyState::F64(state) => lift_all(&mut state.positions, &groups, planes),
    };
    if is_moved {
        runner.set_state(&state, steps)?;
    }
    Ok(is_moved)
}

fn lift_all<V: Vector>(positions: &mut [V], groups: &[Range<usize>], planes: &[Plane]) -> bool {
    let mut is_moved = false;
    for plane in planes {
        let Some(normal) = plane.normal.try_normalize() else { continue };
        for group in groups {
            let gap = |position: &V| normal.dot(position.to_f64()) - plane.offset;
            let least = positions[group.clone()].iter().map(gap).fold(0.0, f64::min);
            if least < 0.0 {
                is_moved = true;
                for position in &mut positions[group.clone()] {
                    *position = V::of(position.to_f64() - normal * least);
                }
            }
        }
    }
    is_moved
}
