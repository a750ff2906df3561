//! The parts of the model that the user switches off, and on again, while it runs.

use super::run::{Reading, Run};
use super::{Deed, Session};
use glam::DVec3;
use msd_core::{Interaction, Model, Plane, Real, Scene, Select, Vector};
use msd_run::{Runner, on};
use msd_scene::{AnyState, Loaded};
use msd_study::parts::Part;
use std::ops::Range;

/// A part that a scene has, with the springs that it consists of.
type Kind = (Part, Vec<Range<usize>>);

/// The parts that the scene of a session has, and which of them are on.
#[derive(Debug, Default)]
pub struct Parts {
    /// Worked out once, when they are asked for first.
    kinds: Option<Vec<Kind>>,
    now: Option<Reading<Vec<(Part, bool)>>>,
}

impl Parts {
    /// Looks at a run again, if it was changed.
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
        Part::Contact => !model.planes().is_empty(),
        Part::FaceDiagonals | Part::SpaceDiagonals | Part::BendingSprings => {
            let mut rows = springs.iter().cloned().flatten();
            rows.any(|row| model.stiffness(row) != R::ZERO || model.damping(row) != R::ZERO)
        }
    }
}

impl Session {
    /// The parts of the model that the scene has, and whether each is on; empty before it was
    /// looked at.
    pub fn parts(&self) -> &[(Part, bool)] {
        self.parts.of(&self.run)
    }

    /// Looks at the parts of the model; to be called before they are shown.
    pub fn look_at_parts(&mut self) {
        self.parts.refresh(&self.run, &self.loaded);
    }

    /// Switches a part of the model off, or on as the scene has it, in one edit.
    ///
    /// Springs that are switched off stay where they are, with neither stiffness nor damping. What
    /// fell through an obstacle is lifted out of it, body by body, before there is contact again.
    pub fn switch(&mut self, part: Part, on: bool) {
        self.look_at_parts();
        let edits = self.edits_of_switch(part, on);
        if edits.is_empty() {
            return;
        }
        self.remember(Deed::Switch(part.name()));
        if part == Part::Contact && on {
            self.lift();
        }
        if self.act_all(&edits) {
            edits.into_iter().for_each(|edit| self.material.keep(edit));
        } else {
            self.undo.withdraw();
        }
    }

    fn edits_of_switch(&self, part: Part, on: bool) -> Vec<Interaction> {
        let (scene, world) = (&self.loaded.scene, self.loaded.scene.world);
        match part {
            Part::Gravity => {
                vec![Interaction::SetGravity {
                    value: if on { world.gravity } else { DVec3::ZERO },
                }]
            }
            Part::Drag => vec![Interaction::SetDrag { value: if on { world.drag } else { 0.0 } }],
            Part::Contact if on => {
                scene.planes.iter().map(|&plane| Interaction::AddPlane { plane }).collect()
            }
            Part::Contact => vec![Interaction::RemovePlanes],
            kind => self.edits_of_springs(kind, on),
        }
    }

    /// Sets stiffness and damping of the springs of a part: those of the scene, or nothing.
    fn edits_of_springs(&self, part: Part, on: bool) -> Vec<Interaction> {
        let springs = &self.loaded.scene.springs;
        let is_off = |other: Part| match other == part {
            true => !on,
            false => self.parts().contains(&(other, false)),
        };
        let no_damping = is_off(Part::Damping);
        let mut is_gone = vec![false; springs.len()];
        let mut is_of = vec![part == Part::Damping; springs.len()];
        for (kind, ranges) in self.parts.kinds.iter().flatten() {
            for range in ranges {
                is_gone[range.clone()].fill(is_off(*kind));
                is_of[range.clone()].fill(*kind == part || part == Part::Damping);
            }
        }
        let rows = || (0..springs.len()).filter(|&row| is_of[row]);
        let stiffness = |row: usize| if is_gone[row] { 0.0 } else { springs[row].stiffness };
        let damping = |row: usize| match is_gone[row] || no_damping {
            true => 0.0,
            false => springs[row].damping,
        };
        let count = springs.len();
        let set_damping = runs((rows(), count), damping).into_iter();
        let mut edits: Vec<Interaction> = set_damping
            .map(|(springs, value)| Interaction::SetDamping { springs, value })
            .collect();
        if part != Part::Damping {
            let runs = runs((rows(), count), stiffness).into_iter();
            edits.extend(runs.map(|(springs, value)| Interaction::SetStiffness { springs, value }));
        }
        edits
    }

    /// Lifts every body out of the planes of the scene; there is no way back to where it was.
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

/// Rows that have one value and follow each other, with that value: all springs of `count` as such.
fn runs(
    (rows, count): (impl Iterator<Item = usize>, usize),
    value: impl Fn(usize) -> f64,
) -> Vec<(Select, f64)> {
    let mut found: Vec<(Range<usize>, f64)> = Vec::new();
    for row in rows {
        let value = value(row);
        match found.last_mut().filter(|(range, last)| range.end == row && *last == value) {
            Some((range, _)) => range.end += 1,
            None => found.push((row..row + 1, value)),
        }
    }
    let select = |range: Range<usize>| match range == (0..count) {
        true => Select::All,
        false => Select::Range(range.start, range.end),
    };
    found.into_iter().map(|(range, value)| (select(range), value)).collect()
}

/// Moves each body, and each particle of none, out of one plane after the other along its normal,
/// pins and all; returns whether anything had to be moved. What a later plane pushes back into an
/// earlier one is left to contact.
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
