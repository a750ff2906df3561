//! The rows of a model, and the moments at which methods use them.

use super::clusters::Clusters;
use super::features::At;
use super::find::Finder;
use super::lists::Candidates;
use super::margins::Margins;
use super::overlaps::Balls;
use super::passage::{ShellPassage, Through};
use super::patch::{Patch, gather, scatter};
use super::row::{ContactRow, InSolve, RowImpulse, add_shares};
use super::{Shells, sweep};
use crate::columns::extent::Extent;
use crate::columns::{load, vector};
use crate::contact::Contacts;
use crate::number::{Real, Vector, at_level};
use crate::pack::{Pack, zip};
use alloc::vec::Vec;
use fearless_simd::Simd;

/// The rows of a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShellRows<R: Real> {
    pub(super) rows: Vec<ContactRow<R>>,
    /// The rows of the substep before.
    last: Vec<ContactRow<R>>,
    pub(super) lists: Candidates<R>,
    margins: Margins<R>,
    pub(super) patch: Patch<R>,
    /// The impulses before a prediction.
    kept: Vec<(R, R::Vec3)>,
    /// The rows in a solve.
    pub(super) in_solve: Vec<InSolve<R>>,
    /// Notes of a search.
    keys: Vec<u64>,
    near: Vec<(u64, usize)>,
    are_held: Vec<bool>,
    overlapping: Vec<[usize; 2]>,
    balls: Balls<R>,
    /// The rows that were seen whose sides have gone through each other.
    through: Through,
}

impl<R: Real> ShellRows<R> {
    /// Lets the particles be pushed out that start inside another shell; none of two that springs
    /// join, whose author has put them there. The springs are given by their ends.
    pub(crate) fn start(
        &mut self,
        at: &At<'_, R>,
        positions: &[R],
        springs: impl Iterator<Item = [usize; 2]>,
    ) {
        let shells = at.shells;
        if !shells.do_meet() {
            return;
        }
        let count = shells.rows().len();
        let extents: Vec<Extent<R>> = (0..count)
            .map(|shell| {
                Extent::around(shells.vertices_of(shell).map(|v| shells.point(positions, v)))
            })
            .collect();
        let are_near = |&[a, b]: &[usize; 2]| {
            extents[a].is_near(extents[b], R::ZERO) && shells.do_shells_meet([a, b])
        };
        let pairs = (0..count).flat_map(|last| (0..last).map(move |first| [first, last]));
        let mut pairs: Vec<[usize; 2]> = pairs.filter(are_near).collect();
        if pairs.is_empty() {
            return;
        }
        let are_closed: Vec<bool> = (0..count).map(|shell| shells.is_closed(shell)).collect();
        pairs.retain(|&[a, b]| are_closed[a] || are_closed[b]);
        let of = shells.by_particle();
        for [a, b] in springs.map(|ends| ends.map(|end| of.get(&end).copied())) {
            if a != b {
                pairs.retain(|&[first, last]| {
                    ![[a, b], [b, a]].contains(&[Some(first), Some(last)])
                });
            }
        }
        if pairs.is_empty() {
            return;
        }
        self.lists.clusters = Clusters::new(shells);
        self.lists.vertices = (0..shells.vertices.len() as u32).collect();
        self.patch.fit(shells);
        self.read_points(at, positions);
        let finder = Finder::new(at, &self.patch, R::ZERO);
        for pair in pairs {
            self.rows.extend(finder.crossing(&self.lists.clusters, pair, &are_closed));
        }
        self.rows.sort_unstable_by_key(|row| row.key);
    }

    /// Discards the lists: features are other ones.
    pub(crate) fn forget(&mut self) {
        self.lists.forget();
    }

    /// The impulses from which the next substep starts.
    pub(crate) fn impulses(&self) -> Vec<RowImpulse> {
        let mut impulses = Vec::new();
        self.keep(&mut impulses);
        impulses
    }

    /// Overwrites `impulses` with those from which the next substep starts.
    pub(crate) fn keep(&self, impulses: &mut Vec<RowImpulse>) {
        impulses.clear();
        let stays = |row: &&ContactRow<R>| row.push != R::ZERO || row.is_of_overlap();
        let given = self.rows.iter().filter(stays);
        let impulse = |row: &ContactRow<R>| RowImpulse {
            key: row.key,
            push: row.push.to_f64(),
            rub: row.rub.to_f64(),
            normal: row.normal.to_f64(),
        };
        impulses.extend(given.map(impulse));
    }

    /// Scales these impulses to another substep.
    pub(crate) fn scale(&mut self, factor: f64) {
        let factor = R::of(factor);
        for row in &mut self.rows {
            (row.push, row.rub) = (row.push * factor, row.rub * factor);
        }
    }

    /// Replaces these impulses, in the order of their keys.
    pub(crate) fn set_impulses(&mut self, impulses: &[RowImpulse]) {
        let row = |impulse: &RowImpulse| ContactRow {
            key: impulse.key,
            push: R::of(impulse.push),
            rub: R::Vec3::of(impulse.rub),
            normal: R::Vec3::of(impulse.normal),
            ..ContactRow::default()
        };
        self.rows.clear();
        self.rows.extend(impulses.iter().map(row));
        // Crossings that were counted since then are undone.
        self.through = Through::default();
    }

    /// Takes the count of rows whose sides were seen to have gone through each other.
    pub(crate) fn take_crossed(&mut self) -> u64 {
        core::mem::take(&mut self.through.count)
    }

    /// Takes the shells of those rows.
    pub(crate) fn take_passages(&mut self) -> impl Iterator<Item = ShellPassage> {
        self.through.passages.drain(..)
    }

    /// Whether there are rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The pairs of particles, of one shell, whose features are closer than it stops itself at.
    pub(crate) fn closed_pairs(&self, shells: &Shells) -> Vec<[usize; 2]> {
        let closed = self.rows.iter().filter(|row| !row.is_of_obstacle() && row.gap < R::ZERO);
        let side = |row: &ContactRow<R>, is_first: bool| {
            let each = row.vertices.into_iter().zip(row.weights);
            let of_side = each.filter(move |(_, weight)| (R::ZERO < *weight) == is_first);
            of_side.filter(|(_, weight)| *weight != R::ZERO).map(|(vertex, _)| vertex)
        };
        let pairs = closed.flat_map(|row| {
            side(row, true).flat_map(move |a| side(row, false).map(move |b| [a, b]))
        });
        let mut pairs: Vec<[usize; 2]> =
            pairs.filter_map(|pair| shells.of_one_shell(pair)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Discards the known ways since the rows were found last: not drifts at the velocities after a
    /// kick alone made them.
    pub(crate) fn lose_track(&mut self) {
        self.lists.lose_track();
    }

    /// Finds the rows at a state, each with the impulse that it gave last, before a kick of
    /// `length` seconds by some forces and a drift of h seconds at the velocities after it, and
    /// those within a least margin, metres. Returns whether particles are so fast that some may
    /// cross.
    pub(crate) fn find(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities, forces]: [&[R]; 3],
        (length, h, least): (R, R, R),
    ) -> bool {
        let shells = at.shells;
        let columns = [velocities, forces, at.inverse_masses];
        let free = at_level!(at.level, simd => spread(simd, shells, columns, length));
        let spare = R::of(SPARE * (1.0 + shells.most_restitution));
        let margin_of = |all: Extent<R>| all.diagonal().sqrt() * h * spare + least;
        // Two vertices, or one and an obstacle that stands still, come closer at most that fast.
        let margin = margin_of(free.with_origin());
        core::mem::swap(&mut self.rows, &mut self.last);
        self.rows.clear();
        // In a run that diverges nothing is near anything.
        if !margin.to_f64().is_finite() {
            return true;
        }
        let most = R::of(MOST_MARGIN * shells.reach());
        let is_fast = most < margin;
        let margin = margin.min(most);
        let from = self.last.partition_point(ContactRow::is_of_features);
        let to = self.last.partition_point(|row| !row.is_of_obstacle());
        let inside = from..to;
        let margins = match inside.is_empty() {
            true => (margin_of(free), margin),
            false => (R::LARGEST, R::LARGEST),
        };
        if self.lists.are_apart(at, positions, margins) {
            return is_fast;
        }
        let times = (length, h * spare, least);
        let clusters = (at, &self.lists.clusters, &self.lists.corners[..]);
        self.margins.set(clusters, [velocities, forces], times, (&self.last, margin));
        let margins = (&self.margins, margin);
        let are_all = self.lists.serve(at.level, shells, positions, margins);
        let of_pairs = self.last[inside.clone()]
            .chunk_by(|a, b| a.overlapping(shells) == b.overlapping(shells));
        of_pairs.for_each(|rows| self.lists.mark_all(shells, rows[0].overlapping(shells)));
        if !self.lists.vertices.is_empty() {
            self.patch.fit(shells);
            self.read_points(at, positions);
            let mut found = Finder::new(at, &self.patch, margin);
            found.rows = core::mem::take(&mut self.rows);
            found.keys = core::mem::take(&mut self.keys);
            found.near = core::mem::take(&mut self.near);
            found.are_held = core::mem::take(&mut self.are_held);
            found.overlapping = core::mem::take(&mut self.overlapping);
            found.add_overlaps(&self.lists.clusters, &self.last[inside], &mut self.balls);
            found.find(&mut self.lists);
            (self.rows, self.keys) = (found.rows, found.keys);
            (self.near, self.are_held) = (found.near, found.are_held);
            self.overlapping = found.overlapping;
            self.warm(at);
        }
        is_fast || !are_all
    }

    /// Reads where the vertices near others are, and their masses.
    fn read_points(&mut self, at: &At<'_, R>, positions: &[R]) {
        let Patch { points, inverse_masses, .. } = &mut self.patch;
        for &vertex in &self.lists.vertices {
            let place = at.shells.vertices[vertex as usize].at as usize;
            points[vertex as usize] = vector::<R>(positions, place);
            inverse_masses[vertex as usize] = at.inverse_masses[place];
        }
    }

    /// Gives each row the impulse of that of the substep before between the same features.
    fn warm(&mut self, at: &At<'_, R>) {
        let finder = Finder::new(at, &self.patch, R::ZERO);
        let mut last = self.last.iter().filter(|row| row.push != R::ZERO).peekable();
        for row in &mut self.rows {
            while last.next_if(|before| before.key < row.key).is_some() {}
            if let Some(before) = last.next_if(|before| before.key == row.key) {
                (row.push, row.parting) = (before.push, before.parting);
                self.through.look(row, before.normal, at);
                row.rub = before.rub - row.normal * row.normal.dot(before.rub);
                finder.turn(row);
            }
        }
    }

    /// Reads the velocities of the vertices near others, and those before a kick.
    fn read_velocities(&mut self, at: &At<'_, R>, velocities: &[R], (forces, length): (&[R], R)) {
        let Patch { velocities: now, before, .. } = &mut self.patch;
        for &vertex in &self.lists.vertices {
            let place = at.shells.vertices[vertex as usize].at as usize;
            let velocity = vector::<R>(velocities, place);
            let kick = vector::<R>(forces, place) * (at.inverse_masses[place] * length);
            (now[vertex as usize], before[vertex as usize]) = (velocity, velocity - kick);
        }
    }

    /// Lets shells meet after the kick, before the drift.
    pub(crate) fn meet(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities]: [&mut [R]; 2],
        forces: &[R],
        (length, h): (R, R),
    ) -> Contacts {
        self.read_velocities(at, velocities, (forces, length));
        if 0.0 < at.shells.most_restitution {
            let Patch { velocities, before, .. } = &self.patch;
            sweep::set_partings(&mut self.rows, [before, velocities], h / length);
        }
        sweep::add(&self.rows, &mut self.patch.velocities, &self.patch.inverse_masses, R::ONE);
        self.sweep(at, h);
        let ShellRows { rows, lists, patch, .. } = self;
        rows.iter_mut().for_each(|row| row.parting = R::ZERO);
        let vertices = (at.shells, &lists.vertices[..]);
        scatter(vertices, &patch.velocities, velocities);
        if sweep::part(rows, &mut patch.points, &patch.inverse_masses, h) {
            scatter(vertices, &patch.points, positions);
        }
        sweep::work(rows, patch.means(&lists.vertices))
    }

    /// Lets the rows of the substep hold after a kick that no drift follows, where their particles
    /// are now.
    pub(crate) fn hold(
        &mut self,
        at: &At<'_, R>,
        (positions, velocities): (&[R], &mut [R]),
        kick: (&[R], R),
    ) -> Contacts {
        self.read_points(at, positions);
        self.follow(at);
        self.read_velocities(at, velocities, kick);
        let ShellRows { rows, lists, patch, .. } = self;
        sweep::add(rows, &mut patch.velocities, &patch.inverse_masses, R::ONE);
        sweep::hold(rows, &mut patch.velocities, &patch.inverse_masses);
        scatter((at.shells, &lists.vertices), &patch.velocities, velocities);
        sweep::work(rows, patch.means(&lists.vertices))
    }

    /// Adds the impulses as forces that act for h seconds; or, for a second, as impulses.
    pub(crate) fn add_forces(&self, shells: &Shells, forces: &mut [R], h: R) {
        let per_second = R::ONE / h;
        for row in self.rows.iter().filter(|row| row.push != R::ZERO) {
            add_shares(row, shells, row.impulse() * per_second, forces);
        }
    }

    /// Sets the mean velocities of a substep.
    pub(crate) fn set_means(&mut self, shells: &Shells, means: &[R]) {
        gather((shells, &self.lists.vertices), means, &mut self.patch.velocities);
    }

    /// Corrects the outcome of a substep in the stages of which these forces acted, by its mean
    /// velocities, which are set, and then its last ones.
    ///
    /// An addition to impulses acts as if it were given at the start. Where `is_late`, the mean
    /// velocities are those of the start, and the addition is felt at the end alone.
    pub(crate) fn end(
        &mut self,
        at: &At<'_, R>,
        [positions, velocities]: [&mut [R]; 2],
        (h, is_late): (R, bool),
    ) -> Contacts {
        self.rows.iter_mut().for_each(|row| row.booked = row.impulse());
        let vertices = (at.shells, &self.lists.vertices[..]);
        let mut contacts = Contacts::default();
        if is_late {
            self.patch.set_before(vertices, velocities, R::HALF);
            contacts += sweep::work_of_stages(&self.rows, &self.patch.before);
        }
        self.patch.set_before(vertices, velocities, if is_late { R::ONE } else { -R::ONE });
        if 0.0 < at.shells.most_restitution {
            let Patch { velocities: means, before, .. } = &self.patch;
            let (start, then) = if is_late { (means, before) } else { (before, means) };
            let shorter = if is_late { R::ONE } else { R::ONE + R::ONE };
            sweep::set_partings(&mut self.rows, [start, then], shorter);
        }
        self.sweep(at, h);
        let ShellRows { rows, lists, patch, .. } = self;
        let vertices = (at.shells, &lists.vertices[..]);
        if !is_late {
            contacts += sweep::work_of_stages(rows, &patch.velocities);
        }
        sweep::add(rows, &mut patch.before, &patch.inverse_masses, R::HALF);
        contacts += sweep::work(rows, &patch.before);
        gather(vertices, velocities, &mut patch.velocities);
        gather(vertices, positions, &mut patch.points);
        sweep::add(rows, &mut patch.velocities, &patch.inverse_masses, R::ONE);
        sweep::add(rows, &mut patch.points, &patch.inverse_masses, h);
        sweep::part(rows, &mut patch.points, &patch.inverse_masses, h);
        scatter(vertices, &patch.points, positions);
        self.follow(at);
        contacts + self.hold_last(at.shells, velocities)
    }

    /// Lets the rows of the substep hold its last velocities, which are known as are positions.
    pub(super) fn hold_last(&mut self, shells: &Shells, velocities: &mut [R]) -> Contacts {
        let ShellRows { rows, lists, patch, .. } = self;
        patch.before.copy_from_slice(&patch.velocities);
        rows.iter_mut().for_each(|row| row.booked = row.impulse());
        sweep::hold(rows, &mut patch.velocities, &patch.inverse_masses);
        scatter((shells, &lists.vertices), &patch.velocities, velocities);
        let contacts = sweep::work(rows, patch.means(&lists.vertices));
        for row in rows {
            (row.booked, row.parting) = (R::Vec3::ZERO, R::ZERO);
        }
        contacts
    }

    /// Corrects the impulses of the rows for a drift of h seconds.
    fn sweep(&mut self, at: &At<'_, R>, h: R) {
        let mut now = core::mem::take(&mut self.patch.velocities);
        let finder = Finder::new(at, &self.patch, R::ZERO);
        sweep::sweep(&mut self.rows, &mut now, &self.patch.inverse_masses, h, |row, velocity| {
            let passes = finder.passes(row, velocity, h);
            if !passes {
                finder.turn(row);
            }
            !passes
        });
        self.patch.velocities = now;
    }

    /// Lets the rows of the substep hold velocities that are predicted for its end; they keep their
    /// impulses.
    pub(crate) fn hold_predicted(&mut self, shells: &Shells, velocities: &mut [R]) {
        let ShellRows { rows, lists, patch, kept, .. } = self;
        let Patch { velocities: now, inverse_masses, .. } = patch;
        kept.clear();
        kept.extend(rows.iter().map(|row| (row.push, row.rub)));
        gather((shells, &lists.vertices), velocities, now);
        sweep::add(rows, now, inverse_masses, R::ONE);
        sweep::hold(rows, now, inverse_masses);
        scatter((shells, &lists.vertices), now, velocities);
        for (row, &kept) in rows.iter_mut().zip(&*kept) {
            (row.push, row.rub) = kept;
        }
    }

    /// Lets the rows that have given an impulse follow their features to their current places.
    fn follow(&mut self, at: &At<'_, R>) {
        let finder = Finder::new(at, &self.patch, R::LARGEST.sqrt() * R::HALF);
        let acts = |row: &&mut ContactRow<R>| row.is_of_features() && row.push != R::ZERO;
        for row in self.rows.iter_mut().filter(acts) {
            let before = row.normal;
            finder.follow(row);
            // Two that went through each other have their normal turned about.
            self.through.look(row, before, at);
        }
    }
}

/// The box around all velocities after a kick of `length` seconds.
#[inline(always)]
fn spread<S: Simd, R: Real>(
    simd: S,
    shells: &Shells,
    [velocities, forces, inverse_masses]: [&[R]; 3],
    length: R,
) -> Extent<R> {
    let length = Pack::<S, R>::new(simd, length);
    let after = |at: usize, part| {
        let masses = load(simd, &inverse_masses[at..], part);
        let kick = zip(load(simd, &forces[at..], part), masses, |force, w| force * (w * length));
        zip(load(simd, &velocities[at..], part), kick, |velocity, kick| velocity + kick)
    };
    Extent::of(simd, &shells.records, after)
}

/// More than the part by which particles get faster in a sweep.
const SPARE: f64 = 1.1;
/// The largest margin of a row, in reaches: beyond it lists would be of no use.
const MOST_MARGIN: f64 = 20.0;
