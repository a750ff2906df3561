//! Contact within an implicit substep: the particles that obstacles hold, and the impulses.
//!
//! A particle that lies on an obstacle keeps its height in the solve itself. Moved back afterwards,
//! it would have let the body sag by g h² and the springs above it push it into the obstacle. A
//! particle that would come to lie on it within the substep gets there in the solve. On a surface
//! that moves it is held as seen from there.
//!
//! The part of the residual in the held directions is set aside in every iteration (the filter of
//! Baraff and Witkin, 1998, section 5.3). It is the impulse of the surface, which no iteration may
//! solve. Where that impulse would pull, the particle is let go. Friction is Coulomb's with this
//! impulse, the weight of everything above included. A particle that sticks is held along the
//! surface too, as long as that takes at most μ times the pressure. A particle that slides gets
//! that much against its velocity, as a force in the solve. Slowing a particle after the solve, as
//! [`crate::contact::law`] does, would compare the momentum of one particle with the weight of all
//! above it, and hold a stiff block too well.

use super::conjugate::Solve;
use crate::columns::{Aligned, set_vector, single, vector};
use crate::contact::Contacts;
use crate::contact::held::{Facet, Facets, Limit, Limits, Stopped};
use crate::contact::law::{coulomb, resting_speed, rounding};
use crate::number::{Real, Vector};
use crate::obstacles::{ContactLaw, Obstacle};
use crate::system::{Columns, Model};
use alloc::vec::Vec;
use core::ops::Add;
use glam::DVec3;

/// A surface under a particle.
#[derive(Clone, Copy, Debug, Default)]
struct Face<R: Real> {
    obstacle: usize,
    /// Direction out of the obstacle, length one.
    normal: R::Vec3,
    /// Velocity of the surface, metres per second.
    velocity: R::Vec3,
    law: ContactLaw<R>,
    /// The gap up to which it is touched, metres.
    near: R,
    /// The speed at which a gap beyond that closes in the substep, metres per second.
    closing: R,
    /// Speed at which a sliding particle leaves the bent surface in the substep, metres per second;
    /// negative where it runs into it. It is half of the change of velocity by the turn.
    bend: R,
}

/// A particle that lies on one face, in an edge of two or in a corner of three.
#[derive(Clone, Copy, Debug)]
struct Hold<R: Real> {
    /// Its place in the columns.
    at: usize,
    faces: [Face<R>; 3],
    corner: Facets<R>,
    /// Velocity of the surface, metres per second; of several faces, along the normal of each.
    surface: R::Vec3,
    /// Velocity towards the faces that are not touched yet, metres per second.
    closing: R::Vec3,
    /// Whether it comes too fast into a face that it lies on.
    is_struck: bool,
    /// Whether friction holds it along the faces too.
    stuck: bool,
    /// About the effective mass of its own block along the faces, kilograms.
    weight: R,
    /// Impulse of friction where it slides, newton seconds.
    friction: R::Vec3,
    /// The part of the residual in the held directions, newton seconds: the impulse of the surface.
    held: R::Vec3,
}

/// The particles that obstacles hold.
#[derive(Clone, Debug)]
pub(crate) struct Holds<R: Real> {
    rows: Vec<Hold<R>>,
    /// The sum of squares of the changes of friction in the last review, newton seconds squared.
    unrest: R,
}

/// The substep for which holds are sought.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span<R> {
    /// Its length and that of its stage, seconds.
    pub(crate) h: R,
    pub(crate) tau: R,
    /// Its start, the time of the stage, and its end, seconds.
    pub(crate) start: f64,
    pub(crate) stage: f64,
    pub(crate) end: f64,
}

impl<R: Real> Holds<R> {
    pub(crate) fn new(model: &Model<R>) -> Self {
        let most = if model.obstacles.is_empty() { 0 } else { model.particle_count() };
        Holds { rows: Vec::with_capacity(most), unrest: R::ZERO }
    }

    /// Lists the particles that lie on an obstacle and neither leave it nor hit it. A blow to a
    /// particle on several obstacles, as it slides from one to another, takes no time. It is over
    /// before the solve, which would spread it over the substep. Returns the contacts of such
    /// blows.
    ///
    /// A particle is at rest if it moves along the normal slower than the speed that gravity adds
    /// in two substeps, as in [`crate::contact::law`].
    pub(crate) fn find(
        &mut self,
        model: &Model<R>,
        span: &Span<R>,
        state: &mut Columns<R>,
    ) -> Contacts {
        self.rows.clear();
        let mut contacts = Contacts::default();
        if model.obstacles.is_empty() {
            return contacts;
        }
        for at in model.slots.places().filter(|&at| model.inverse_mass_column[at] != R::ZERO) {
            let (position, velocity) = state.get(at);
            let mut hold = Hold::of(model, at, span, (position, velocity));
            if hold.is_struck {
                let held = hold.strike(velocity);
                let lost = velocity.dot(velocity) - held.velocity.dot(held.velocity);
                let mass = model.mass_column[single(at)];
                let [taken, driven] = [lost * R::HALF + held.driven, held.driven]
                    .map(|energy| (energy * mass).to_f64());
                contacts += Contacts { driven, ..Contacts::one(taken) };
                state.put(at, (position, held.velocity));
                hold = Hold::of(model, at, span, (position, held.velocity));
            }
            if !hold.faces().is_empty() {
                self.rows.push(hold);
            }
        }
        contacts
    }

    /// Removes the velocities that the obstacles do not allow.
    pub(crate) fn restrict(&self, velocities: &mut [R]) {
        for hold in &self.rows {
            let velocity = hold.allowed(vector::<R>(velocities, hold.at));
            set_vector(velocities, hold.at, velocity);
        }
    }

    /// The place of each particle, the directions in which it is held, zero if none, and friction
    /// on it, newton seconds.
    pub(crate) fn directions(&self) -> impl Iterator<Item = (usize, [DVec3; 3], DVec3)> + '_ {
        self.rows.iter().map(|hold| {
            let mut axes = [DVec3::ZERO; 3];
            for (axis, face) in axes.iter_mut().zip(hold.corner.faces()) {
                *axis = face.axis.to_f64();
            }
            let axes = if hold.stuck { [DVec3::X, DVec3::Y, DVec3::Z] } else { axes };
            (hold.at, axes, hold.friction.to_f64())
        })
    }

    /// Overwrites the preconditioner with the inverses of blocks, less the directions that are
    /// held, which a solve then never enters.
    pub(crate) fn precondition(&self, inverses: &[Aligned<R>; 2], solve: &mut Solve<R>) {
        let [upper, lower] = &mut solve.preconditioner;
        upper.copy_from_slice(&inverses[0]);
        lower.copy_from_slice(&inverses[1]);
        for hold in &self.rows {
            // S P S by columns: S P, its rows as columns since both are symmetric, and S again.
            let [a, b] = [&*upper, &*lower].map(|column| vector::<R>(column, hold.at).components());
            let inverse = [a, [a[1], b[0], b[1]], [a[2], b[1], b[2]]].map(R::Vec3::from_components);
            let half = transpose::<R>(inverse.map(|column| hold.project(column)));
            let [x, y, z] = half.map(|column| hold.project(column).components());
            set_vector(upper, hold.at, R::Vec3::from_components(x));
            set_vector(lower, hold.at, R::Vec3::from_components([y[1], y[2], z[2]]));
        }
    }

    /// Takes over new residuals. It decides which particles stick and adds friction to those that
    /// slide, as if each particle were alone (see [`Hold::decide`]), and sets the held part aside.
    pub(crate) fn begin(
        &mut self,
        velocities: &[R],
        inverses: &[Aligned<R>; 2],
        residuals: &mut [R],
    ) {
        self.unrest = R::of(f64::INFINITY);
        for hold in &mut self.rows {
            let [xx, _, _] = vector::<R>(&inverses[0], hold.at).components();
            let [yy, _, zz] = vector::<R>(&inverses[1], hold.at).components();
            hold.weight = R::of(3.0) / (xx + yy + zz);
            let residual = vector::<R>(residuals, hold.at);
            (hold.stuck, hold.friction, hold.held) = (false, R::Vec3::ZERO, R::Vec3::ZERO);
            if hold.is_rough() {
                let velocity = vector::<R>(velocities, hold.at) - hold.surface;
                let (pushes, along) = hold.corner.pushes(-residual);
                hold.decide(along - hold.free(velocity) * hold.weight, hold.budget(pushes));
            }
            let left = hold.set_aside(residual + hold.friction);
            set_vector(residuals, hold.at, left);
        }
    }

    /// Overwrites `changes` with those that stop the particles that have just begun to stick, and
    /// returns whether there are any.
    pub(crate) fn set_stops(&self, velocities: &[R], changed: &[R], changes: &mut [R]) -> bool {
        let mut any = false;
        for hold in self.rows.iter().filter(|hold| hold.stuck) {
            let velocity = vector::<R>(velocities, hold.at) + vector::<R>(changed, hold.at);
            let slip = hold.free(velocity - hold.surface);
            if slip != R::Vec3::ZERO {
                if !any {
                    changes.fill(R::ZERO);
                }
                any = true;
                set_vector(changes, hold.at, -slip);
            }
        }
        any
    }

    /// Takes over residuals that were found anew.
    pub(crate) fn renew(&mut self, residuals: &mut [R]) {
        for hold in &mut self.rows {
            hold.held = R::Vec3::ZERO;
            let residual = vector::<R>(residuals, hold.at) + hold.friction;
            let left = hold.set_aside(residual);
            set_vector(residuals, hold.at, left);
        }
    }

    /// Sets aside the held part of the residuals.
    pub(crate) fn set_aside(&mut self, residuals: &mut [R]) {
        for hold in &mut self.rows {
            let left = hold.set_aside(vector::<R>(residuals, hold.at));
            set_vector(residuals, hold.at, left);
        }
    }

    /// Releases particles that an obstacle would have to pull, and matches friction to the
    /// pressure. Returns whether anything changed, so that the solve has to go on.
    pub(crate) fn review(&mut self, velocities: &[R], solve: &mut Solve<R>) -> bool {
        let (mut changed, mut unrest) = (false, R::ZERO);
        for hold in &mut self.rows {
            let before = hold.friction;
            let velocity = vector::<R>(velocities, hold.at) + vector::<R>(&solve.changes, hold.at);
            let rest = vector::<R>(&solve.residuals, hold.at) + hold.held - hold.friction;
            changed |= hold.review(velocity - hold.surface);
            hold.held = R::Vec3::ZERO;
            let left = hold.set_aside(rest + hold.friction);
            set_vector(&mut solve.residuals, hold.at, left);
            let step = hold.friction - before;
            unrest += step.dot(step);
        }
        self.rows.retain(|hold| !hold.faces().is_empty());
        // A body yields to a turn or shift as a whole far more than the block of one particle says.
        // A weight that is too large makes friction swing from pass to pass.
        if R::of(0.25) * self.unrest < unrest {
            self.rows.iter_mut().for_each(|hold| hold.weight *= R::of(0.25));
        }
        self.unrest = unrest;
        changed
    }

    /// The effect of the surfaces in a substep, by the impulses of a stage of so long a fraction of
    /// it at these velocities.
    pub(crate) fn contacts(&self, velocities: &[R], fraction: f64) -> Contacts {
        let contacts = |hold: &Hold<R>| {
            let slip = vector::<R>(velocities, hold.at) - hold.surface;
            let taken = hold.held.dot(hold.closing) - hold.friction.dot(slip);
            let driven = (hold.friction - hold.held).dot(hold.surface).to_f64() / fraction;
            Contacts { count: 0, driven, ..Contacts::one(taken.to_f64() / fraction) }
        };
        self.rows.iter().map(contacts).fold(Contacts::default(), Contacts::add)
    }

    /// Puts held particles on their obstacles, just outside, and slows them where each contact
    /// takes a part of the velocity.
    pub(crate) fn settle(
        &self,
        model: &Model<R>,
        (h, end, mirrors): (R, f64, bool),
        state: &mut Columns<R>,
    ) -> Contacts {
        let mut contacts = Contacts::default();
        for hold in &self.rows {
            let (mut position, velocity) = state.get(hold.at);
            let surface = hold.surface_at(model, position, end);
            let mut slowed = surface + hold.project(velocity - surface);
            let (from, radius) = (position, model.radii().at(hold.at));
            for (face, own) in hold.faces().iter().zip(hold.corner.faces()) {
                slowed = surface + (slowed - surface) * (R::ONE - face.law.loss);
                // A particle further out has left a curved surface.
                let obstacle = model.obstacles.get(face.obstacle);
                let gap = obstacle.gap(from, end) - radius;
                let most = face.near + face.near + face.bend.abs() * (h + h);
                if most <= gap {
                    continue;
                }
                // A little outside: where walls meet at the origin, no gap is within its rounding.
                let noise = rounding(obstacle.terms(from, end), radius);
                let is_off = gap < -noise || face.near < gap || position != from;
                let lift = if is_off { face.near * R::HALF - gap } else { R::ZERO };
                let missing = lift - face.normal.dot(position - from);
                position += own.axis * (missing / own.slope);
                if face.bend != R::ZERO {
                    let normal = obstacle.normal(position, end);
                    // The velocity of a midpoint is that of the chord, between two of tangents.
                    let off = if mirrors { R::ZERO } else { face.bend };
                    slowed += normal * (off - normal.dot(slowed - surface));
                }
            }
            state.put(hold.at, (position, slowed));
            let mass = model.mass_column[single(hold.at)];
            let slower = (velocity.dot(velocity) - slowed.dot(slowed)) * R::HALF;
            let driven = (slowed - velocity).dot(surface);
            let taken = ((slower + driven) * mass).to_f64();
            let driven = (driven * mass).to_f64();
            contacts += Contacts { count: 0, driven, ..Contacts::one(taken) };
        }
        contacts
    }
}

impl<R: Real> Hold<R> {
    fn new(at: usize) -> Self {
        Hold {
            at,
            faces: [Face::default(); 3],
            corner: Facets::default(),
            surface: R::Vec3::ZERO,
            closing: R::Vec3::ZERO,
            is_struck: false,
            stuck: false,
            weight: R::ZERO,
            friction: R::Vec3::ZERO,
            held: R::Vec3::ZERO,
        }
    }

    /// The particle at a place in the columns with the obstacles that it lies on.
    fn of(model: &Model<R>, at: usize, span: &Span<R>, motion: (R::Vec3, R::Vec3)) -> Self {
        let (obstacles, mut hold) = (&model.obstacles, Hold::new(at));
        for (index, plane) in obstacles.planes.iter().enumerate() {
            hold.meet(model, (index, plane), span, motion);
        }
        for (index, curved) in (obstacles.planes.len()..).zip(obstacles.curved()) {
            hold.meet(model, (index, curved), span, motion);
        }
        hold
    }

    /// The effect of a blow on it at a velocity.
    #[cold]
    fn strike(&self, velocity: R::Vec3) -> Stopped<R> {
        let mut limits = Limits::default();
        for &Face { normal, velocity: surface, law, .. } in self.faces() {
            limits.push(Limit { normal, surface, least: R::ZERO, law });
        }
        limits.hold(velocity)
    }

    /// Sets aside the held part of a residual and returns the rest, newton seconds.
    fn set_aside(&mut self, residual: R::Vec3) -> R::Vec3 {
        let left = self.project(residual);
        self.held += residual - left;
        left
    }

    /// Adds an obstacle that a particle lies on at the end of the substep, if it neither leaves nor
    /// hits it. By itself it moves as fast as gravity lets it. Without restitution a particle that
    /// lies on it already does not hit it. A particle wrongly held back by this is released in
    /// [`Hold::review`].
    #[inline]
    fn meet<O: Obstacle<R> + ?Sized>(
        &mut self,
        model: &Model<R>,
        (index, obstacle): (usize, &O),
        span: &Span<R>,
        (position, velocity): (R::Vec3, R::Vec3),
    ) {
        let radius = model.radii().at(self.at);
        let moved = span.h * (velocity.extent() + span.h * model.gravity().extent());
        let gap = obstacle.gap(position, span.start) - radius;
        // The place where it ends is rounded, as its way is.
        let near = rounding(obstacle.terms(position, span.start) + moved, radius);
        let is_near = gap <= near + moved;
        if !is_near {
            return;
        }
        let normal = obstacle.normal(position, span.start);
        let surface = obstacle.velocity(position, span.stage);
        // Friction is along the surface, where the stage takes it; its way off is that of a chord.
        let there = obstacle.velocity(position + velocity * span.tau, span.stage);
        let stage = surface.dot(normal);
        let surface = there + normal * normal.dot(surface - there);
        let [before, middle, after] = [span.start, 0.5 * (span.start + span.end), span.end]
            .map(|time| obstacle.velocity(position, time).dot(normal));
        // It is where its mean velocity takes it (Simpson), which is exact between key frames.
        let lag = (before - stage) + (middle - stage) * R::of(4.0) + (after - stage);
        let surface = surface + normal * (lag * R::of(1.0 / 6.0));
        let resting = resting_speed::<R>(normal, model.gravity(), span.h);
        // A particle that moves by less than the rounding of its gap rests as well.
        let resting =
            resting + near / span.h + rounding(velocity.extent() + surface.extent(), R::ZERO);
        let speed = (velocity - surface).dot(normal);
        let falls = speed + span.h * model.gravity().dot(normal).min(R::ZERO);
        let bend = if index < model.obstacles.planes.len() {
            R::ZERO
        } else {
            let along = velocity - normal * speed;
            let end = position + along * span.h;
            let turn = obstacle.normal(end, span.end) - normal;
            let bend = along.dot(turn) * R::HALF;
            let slip = along - surface;
            // It goes over an edge.
            if R::of(0.25) * slip.dot(slip).sqrt() + resting < bend {
                return;
            }
            bend
        };
        // A particle that a surface presses does not leave it as the surface slows down.
        let bends = (bend.abs() + (after - before).abs()) * R::of(2.0);
        let law = obstacle.law();
        let lies = gap <= near && law.restitution == R::ZERO;
        let is_slow = speed <= resting + bends && (lies || -speed <= resting + bends);
        if is_slow && gap + span.h * (falls - bends) <= near {
            let off = if near < gap { (near * R::HALF - gap) / span.h } else { R::ZERO };
            self.is_struck |= resting + bends < -speed;
            let closing = off - bend;
            self.add(Face { obstacle: index, normal, velocity: surface, law, near, closing, bend });
        }
    }

    /// The faces that it lies on.
    fn faces(&self) -> &[Face<R>] {
        &self.faces[..self.corner.faces().len()]
    }

    /// Adds a face unless its normal is a combination of those there.
    fn add(&mut self, face: Face<R>) {
        let number = self.faces().len();
        if let Some(own) = self.corner.add(face.normal) {
            self.surface = carry(&own, self.surface, face.velocity, number);
            let missing = (face.closing - face.normal.dot(self.closing)) / own.slope;
            self.closing += own.axis * missing;
            self.faces[number] = face;
        }
    }

    /// The velocity of the surface at a time, seconds, as [`Hold::add`] has it for the stage: the
    /// start of the next substep. A velocity of a stage half a substep ago would be off by as much
    /// as the surface speeds up in between.
    fn surface_at(&self, model: &Model<R>, position: R::Vec3, time: f64) -> R::Vec3 {
        let faces = self.faces().iter().zip(self.corner.faces()).enumerate();
        faces.fold(R::Vec3::ZERO, |surface, (number, (face, own))| {
            let velocity = model.obstacles.get(face.obstacle).velocity(position, time);
            carry(own, surface, velocity, number)
        })
    }

    /// The part of a vector along the faces.
    fn free(&self, vector: R::Vec3) -> R::Vec3 {
        self.corner.free(vector)
    }

    /// The part of a vector in the directions that are not held.
    fn project(&self, vector: R::Vec3) -> R::Vec3 {
        if self.stuck { R::Vec3::ZERO } else { self.free(vector) }
    }

    /// The velocity that the faces allow, metres per second.
    fn allowed(&self, velocity: R::Vec3) -> R::Vec3 {
        self.surface + self.closing + self.project(velocity - self.surface)
    }

    fn is_rough(&self) -> bool {
        self.faces().iter().any(|face| R::ZERO < face.law.friction)
    }

    /// The largest impulse of friction, newton seconds.
    fn budget(&self, pushes: [R; 3]) -> R {
        let faces = self.faces().iter().zip(pushes);
        faces.fold(R::ZERO, |sum, (face, push)| sum + face.law.friction * push.max(R::ZERO))
    }

    /// Decides for one particle, from its velocity along the faces and the impulse that these would
    /// need to give.
    fn review(&mut self, velocity: R::Vec3) -> bool {
        let (pushes, along) = self.corner.pushes(-self.held);
        if pushes[..self.faces().len()].iter().any(|&push| push < R::ZERO) {
            self.release(pushes);
            return true;
        }
        if !self.is_rough() {
            return false;
        }
        let (budget, before) = (self.budget(pushes), (self.stuck, self.friction));
        let slip = self.free(velocity);
        if self.stuck {
            self.decide(along, budget);
        } else if R::ZERO < slip.dot(self.friction) {
            // It has come to rest on the way: friction drives nothing.
            (self.stuck, self.friction) = (true, R::Vec3::ZERO);
        } else {
            self.decide(self.friction - slip * self.weight, budget);
        }
        let step = self.friction - before.1;
        // No friction coefficient is known to one part in a hundred.
        let tolerance = R::of(1e-2) * budget;
        self.stuck != before.0 || tolerance * tolerance < step.dot(step)
    }

    /// Decides by the impulse that would stop it along the faces, newton seconds: a particle that
    /// needs more than friction can give slides. (Coulomb's law as a projection: friction is right
    /// where it is the projection of itself, less any weight times the velocity, on the largest;
    /// Alart and Curnier, 1991. With the weight of its block a solution is found for each particle
    /// alone.)
    fn decide(&mut self, wanted: R::Vec3, budget: R) {
        let (left, per_slip) = coulomb(wanted.dot(wanted).sqrt(), budget);
        self.stuck = left == R::ZERO && R::ZERO < budget;
        // Not 1 - left, which cancels: a block near the critical slope would creep.
        self.friction = wanted * (budget * per_slip);
    }

    /// Leaves the faces that pull.
    fn release(&mut self, pushes: [R; 3]) {
        let before = *self;
        *self = Hold { weight: before.weight, ..Hold::new(before.at) };
        for (&face, push) in before.faces().iter().zip(pushes) {
            if R::ZERO <= push {
                self.add(face);
            }
        }
    }
}

/// The velocity that the surface of the faces before and this one, so many after the first, has
/// where this one moves at a velocity. It is along an axis of its own, which leaves those before
/// unchanged.
fn carry<R: Real>(own: &Facet<R>, surface: R::Vec3, velocity: R::Vec3, number: usize) -> R::Vec3 {
    let missing = own.normal.dot(velocity - surface) / own.slope;
    if number == 0 { velocity } else { surface + own.axis * missing }
}

fn transpose<R: Real>(columns: [R::Vec3; 3]) -> [R::Vec3; 3] {
    let [a, b, c] = columns.map(Vector::components);
    [0, 1, 2].map(|row| R::Vec3::from_components([a[row], b[row], c[row]]))
}
