//! The parts of the model that the user switches off, and on again, while it runs.

use super::run::{Reading, Run};
use super::{Deed, Session};
use glam::DVec3;
use msd_core::{Interaction, Model, Plane, Real, Scene, Select, Vector};
use msd_run::{Runner, on};
use msd_scene::{AnyState, Loaded, Precision};
use msd_study::parts::Part;
use std::mem::discriminant;
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
        // Planes can be taken away and put back, solids and shells cannot.
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
    /// The parts of the model that the scene has, and whether each is on; empty before it was
    /// looked at.
    pub fn parts(&self) -> &[(Part, bool)] {
        self.parts.of(&self.run)
    }

    /// Looks at the parts of the model; to be called before they are shown.
    pub fn look_at_parts(&mut self) {
        self.parts.refresh(&self.run, &self.loaded);
    }

    /// Switches a part of the model off, or on as the scene has it, in one edit. Springs come back
    /// as what else was set makes them.
    ///
    /// Springs that are switched off stay where they are, with neither stiffness nor damping. What
    /// fell through an obstacle is lifted out of it, body by body, before there is contact again.
    pub fn switch(&mut self, part: Part, on: bool) {
        self.look_at_parts();
        let off = self.off(part);
        let edits = match (on, is_of_springs(part)) {
            // All springs are set: those of the kinds that are off are off all the same.
            (false, _) if part == Part::Damping => {
                let again = self.off_again(&off[0]);
                Ok(off.iter().copied().chain(again).collect())
            }
            (false, _) => Ok(off.clone()),
            (true, false) => Ok(self.world_again(part)),
            (true, true) => self.springs_again(part, &off),
        };
        let edits = match edits {
            Ok(edits) if edits.is_empty() => return,
            Ok(edits) => edits,
            Err(error) => return self.refusal = Some(error.to_string()),
        };
        self.remember(Deed::Switch(part.name()));
        if part == Part::Contact && on {
            self.lift();
        }
        if !self.act_all(&edits) {
            self.undo.withdraw();
        } else if on && is_of_springs(part) {
            edits.iter().for_each(|edit| self.material.follow(edit));
            // A restart gives them back by itself, and a link needs no edit for each spring.
            self.material.give_up(&off);
        } else {
            edits.into_iter().for_each(|edit| self.material.keep(edit));
        }
    }

    /// What switches a part off.
    fn off(&self, part: Part) -> Vec<Interaction> {
        let count = self.loaded.scene.springs.len();
        let damping = |springs| Interaction::SetDamping { springs, value: 0.0 };
        match part {
            Part::Gravity => vec![Interaction::SetGravity { value: DVec3::ZERO }],
            Part::Drag => vec![Interaction::SetDrag { value: 0.0 }],
            Part::Contact => vec![Interaction::RemovePlanes],
            Part::Damping => {
                // Bends and volumes, which bodies of a material have, are damped too.
                let undamped = |bodies| Interaction::SetRelaxationTime { bodies, value: 0.0 };
                let made = self.made_bodies().map(undamped);
                std::iter::once(damping(Select::All)).chain(made).collect()
            }
            Part::FaceDiagonals | Part::SpaceDiagonals | Part::BendingSprings => {
                let kinds = self.parts.kinds.iter().flatten();
                let rows = kinds.filter(|kind| kind.0 == part).flat_map(|kind| kind.1.clone());
                rows.flat_map(|range| {
                    let springs = select(range, count);
                    [damping(springs), Interaction::SetStiffness { springs, value: 0.0 }]
                })
                .collect()
            }
        }
    }

    /// The bodies of the scene that are made of a material.
    fn made_bodies(&self) -> impl Iterator<Item = Select> + '_ {
        let made = self.loaded.made.iter().enumerate();
        made.filter(|(_, made)| made.is_some()).map(|(body, _)| Select::Body(body))
    }

    /// What keeps springs off that are off, after an edit that would give them something again.
    pub(super) fn off_again(&mut self, edit: &Interaction) -> Vec<Interaction> {
        use Interaction::{SetDamping, SetStiffness};
        let is_off = |edit: &Interaction| {
            matches!(edit, SetDamping { value: 0.0, .. } | SetStiffness { value: 0.0, .. })
        };
        // A slider that is dragged looks at no spring where none was switched off.
        if !is_of_constants(edit) || !self.material.kept().iter().any(is_off) {
            return Vec::new();
        }
        self.look_at_parts();
        let is_kind = |part: Part| is_of_springs(part) && part != Part::Damping;
        let parts = self.parts().iter().filter(|&&(part, on)| is_kind(part) && !on);
        let off = parts.flat_map(|&(part, _)| self.off(part));
        off.filter(|off| discriminant(off) == discriminant(edit)).collect()
    }

    /// What the scene has of a part of its world.
    fn world_again(&self, part: Part) -> Vec<Interaction> {
        let (planes, world) = (&self.loaded.scene.planes, self.loaded.scene.world);
        match part {
            Part::Gravity => vec![Interaction::SetGravity { value: world.gravity }],
            Part::Drag => vec![Interaction::SetDrag { value: world.drag }],
            _ => planes.iter().map(|&plane| Interaction::AddPlane { plane }).collect(),
        }
    }

    /// Gives the springs of a part what the scene and the edits give them but for those that
    /// switched it `off`.
    fn springs_again(
        &self,
        part: Part,
        off: &[Interaction],
    ) -> Result<Vec<Interaction>, msd_core::Error> {
        // In double precision no number of the scene is rounded.
        let settings = self.runner().settings();
        let mut whole = Runner::open_with(&self.loaded, settings, Precision::F64, false)?;
        let kept = self.material.kept().iter().filter(|edit| !off.contains(edit));
        kept.filter(|edit| is_of_constants(edit)).try_for_each(|&edit| whole.queue(edit))?;
        whole.apply_queued()?;
        let springs = whole.progress().0.springs;
        let kinds = self.parts.kinds.iter().flatten().filter(|kind| kind.0 == part);
        let rows: Vec<usize> = match part {
            Part::Damping => (0..springs.len()).collect(),
            _ => kinds.flat_map(|kind| kind.1.iter().cloned().flatten()).collect(),
        };
        let dampings = runs((&rows, springs.len()), |row| springs[row].damping);
        let damping = |(springs, value)| Interaction::SetDamping { springs, value };
        let mut edits: Vec<Interaction> = dampings.into_iter().map(damping).collect();
        if part == Part::Damping {
            // All of a body of a material, by what its springs have of it.
            let time = |bodies: Select| {
                let Select::Body(body) = bodies else { return None };
                let mut rows = springs[self.loaded.scene.bodies[body].springs.clone()].iter();
                let spring = rows.find(|spring| 0.0 < spring.stiffness)?;
                let value = spring.damping / spring.stiffness;
                Some(Interaction::SetRelaxationTime { bodies, value })
            };
            edits.extend(self.made_bodies().filter_map(time));
        }
        if part != Part::Damping {
            let runs = runs((&rows, springs.len()), |row| springs[row].stiffness);
            let stiffness = |(springs, value)| Interaction::SetStiffness { springs, value };
            edits.extend(runs.into_iter().map(stiffness));
        }
        Ok(edits)
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

/// Whether a part is of springs, rather than of the world.
fn is_of_springs(part: Part) -> bool {
    !matches!(part, Part::Gravity | Part::Drag | Part::Contact)
}

/// Whether an edit sets constants of springs.
fn is_of_constants(edit: &Interaction) -> bool {
    use Interaction::{ScaleMaterial, SetDamping, SetRelaxationTime, SetStiffness};
    matches!(
        edit,
        SetStiffness { .. } | SetDamping { .. } | ScaleMaterial { .. } | SetRelaxationTime { .. }
    )
}

/// The springs of a range of rows, of so many in all.
fn select(range: Range<usize>, count: usize) -> Select {
    if range == (0..count) { Select::All } else { Select::Range(range.start, range.end) }
}

/// Rows that have one value and follow each other, with that value, of so many rows in all.
fn runs((rows, count): (&[usize], usize), value: impl Fn(usize) -> f64) -> Vec<(Select, f64)> {
    let goes_on = |a: &usize, b: &usize| a + 1 == *b && value(*a) == value(*b);
    let runs = rows.chunk_by(goes_on);
    runs.map(|run| (select(run[0]..run[run.len() - 1] + 1, count), value(run[0]))).collect()
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
