//! Which particles does a plane hold during an implicit substep, and how hard?
//!
//! A particle that lies on a plane keeps its height in the solve itself: moved back afterwards, it
//! would have let the body sag by g h² and the springs above it push it into the plane.
//!
//! What the solve leaves undone in the held directions is the impulse of the plane. Where that
//! would pull, the particle is let go. Friction is Coulomb's with this impulse, the weight of all
//! that lies above included: what sticks is held along the plane too, as long as that takes no more
//! than μ times the pressure; what slides gets that much against its velocity, as a force in the
//! solve. Slowing a particle after the solve, as [`crate::collision`] does, would compare the
//! momentum of one particle with the weight of all above it, and hold a stiff block too well.

use crate::kernel::Kernel;
use crate::real::{Real, Vector};
use crate::scene::Friction;
use crate::system::{Model, PlaneColumn, State};
use alloc::vec::Vec;

/// A particle that lies on one plane, in an edge of two or in a corner of three.
#[derive(Clone, Copy, Debug)]
struct Hold<R: Real> {
    particle: usize,
    planes: [usize; 3],
    count: usize,
    /// The normals made orthogonal, and how much of each normal is along its own.
    axes: [R::Vec3; 3],
    slopes: [R; 3],
    /// Whether friction holds it along the planes too.
    stuck: bool,
    /// Impulse of friction where it slides, newton seconds.
    friction: R::Vec3,
}

/// The particles that planes hold.
#[derive(Clone, Debug, Default)]
pub(crate) struct Holds<R: Real> {
    rows: Vec<Hold<R>>,
}

/// Nearness at which a particle lies on a plane, as a fraction of the lengths at hand: a few
/// roundings in single precision.
const NEAR: f64 = 1e-6;

impl<R: Real> Holds<R> {
    pub(crate) fn new(model: &Model<R>) -> Self {
        let most = if model.planes.is_empty() { 0 } else { model.particle_count() };
        Holds { rows: Vec::with_capacity(most) }
    }

    /// Lists the particles that lie on a plane and neither leave it nor hit it.
    ///
    /// At rest is what moves along the normal slower than what gravity adds in two substeps, as in
    /// [`crate::collision`].
    pub(crate) fn find(&mut self, model: &Model<R>, h: R, state: &State<R>) {
        self.rows.clear();
        if model.planes.is_empty() {
            return;
        }
        for (particle, &inverse_mass) in model.inverse_masses.iter().enumerate() {
            let (x, v) = (state.positions[particle], state.velocities[particle]);
            let mut hold = Hold::new(particle);
            for (index, plane) in model.planes.iter().enumerate() {
                let resting = (h + h) * model.gravity.dot(plane.normal).abs();
                let near = height(plane, x) <= near(model, plane, x);
                if near && v.dot(plane.normal).abs() <= resting {
                    hold.add(model, index);
                }
            }
            if 0 < hold.count && inverse_mass != R::ZERO {
                let along = hold.free(v);
                hold.stuck = along.dot(along) == R::ZERO && hold.is_rough(model);
                self.rows.push(hold);
            }
        }
    }

    /// Takes away the velocities that the planes do not allow.
    pub(crate) fn restrict(&self, velocities: &mut [R::Vec3]) {
        for hold in &self.rows {
            let velocity = &mut velocities[hold.particle];
            *velocity = hold.project(*velocity);
        }
    }

    /// Keeps a solve from entering the directions that are held.
    pub(crate) fn restrict_blocks(&self, kernel: &mut Kernel<R>) {
        kernel.release();
        for hold in &self.rows {
            // S P S by columns: S P, its rows as columns since both are symmetric, and S again.
            let inverse = kernel.inverse(hold.particle);
            let half = transpose::<R>(inverse.map(|column| hold.project(column)));
            kernel.hold(hold.particle, half.map(|column| hold.project(column)));
        }
    }

    /// Adds the friction on what slides to a fresh residual, estimated from the residual itself:
    /// the momentum that springs and gravity would press into the planes.
    pub(crate) fn add_friction(
        &mut self,
        model: &Model<R>,
        velocities: &[R::Vec3],
        kernel: &mut Kernel<R>,
    ) {
        for hold in &mut self.rows {
            if hold.stuck || !hold.is_rough(model) {
                continue;
            }
            let (pushes, _) = hold.pushes(model, -kernel.residual(hold.particle));
            let budget = hold.budget(model, pushes);
            hold.friction = slowing::<R>(hold.free(velocities[hold.particle]), budget);
            kernel.add_residual(hold.particle, hold.friction);
        }
    }

    /// Lets go of what a plane would have to pull, and brings friction in line with the pressure.
    /// Returns whether anything changed, so that the solve has to go on.
    pub(crate) fn review(
        &mut self,
        model: &Model<R>,
        velocities: &[R::Vec3],
        kernel: &mut Kernel<R>,
    ) -> bool {
        let mut changed = false;
        for hold in &mut self.rows {
            let particle = hold.particle;
            let velocity = velocities[particle] + kernel.change(particle);
            let before = hold.friction;
            changed |= hold.review(model, velocity, -kernel.residual(particle));
            kernel.add_residual(particle, hold.friction - before);
        }
        self.rows.retain(|hold| 0 < hold.count);
        changed
    }

    /// Energy taken away by friction in a stage at these velocities, joules.
    pub(crate) fn friction_energy(&self, velocities: &[R::Vec3]) -> f64 {
        let energy = |hold: &Hold<R>| -hold.friction.dot(velocities[hold.particle]).to_f64();
        self.rows.iter().map(energy).sum()
    }

    /// Sets what is held down on its planes, just outside, and slows it where friction is a factor.
    /// Returns the energy taken away, joules.
    pub(crate) fn settle(&self, model: &Model<R>, state: &mut State<R>) -> f64 {
        let mut energy = 0.0;
        for hold in &self.rows {
            let particle = hold.particle;
            let velocity = hold.project(state.velocities[particle]);
            let mut slowed = velocity;
            for &index in &hold.planes[..hold.count] {
                let plane = &model.planes[index];
                if let Friction::TangentialLoss(loss) = plane.friction {
                    slowed = slowed * (R::ONE - R::of(loss));
                }
                // Outside, so that `collision` does not take it for a second contact.
                let x = &mut state.positions[particle];
                let lift = near(model, plane, *x) * R::HALF - height(plane, *x);
                *x += plane.normal * lift.max(R::ZERO);
            }
            state.velocities[particle] = slowed;
            let slower = velocity.dot(velocity) - slowed.dot(slowed);
            energy += (slower * R::HALF * model.masses[particle]).to_f64();
        }
        energy
    }
}

impl<R: Real> Hold<R> {
    fn new(particle: usize) -> Self {
        Hold {
            particle,
            planes: [0; 3],
            count: 0,
            axes: [R::Vec3::ZERO; 3],
            slopes: [R::ZERO; 3],
            stuck: false,
            friction: R::Vec3::ZERO,
        }
    }

    /// Adds a plane unless its normal is a combination of those there.
    fn add(&mut self, model: &Model<R>, plane: usize) {
        let normal = model.planes[plane].normal;
        let rest = self.remove_axes(normal);
        let slope = rest.dot(rest).sqrt();
        if self.count < 3 && R::of(1e-3) < slope {
            self.planes[self.count] = plane;
            self.axes[self.count] = rest * (R::ONE / slope);
            self.slopes[self.count] = slope;
            self.count += 1;
        }
    }

    fn remove_axes(&self, vector: R::Vec3) -> R::Vec3 {
        self.axes[..self.count].iter().fold(vector, |rest, &axis| rest - axis * axis.dot(rest))
    }

    /// The part of a vector along the planes.
    fn free(&self, vector: R::Vec3) -> R::Vec3 {
        if self.count == 3 { R::Vec3::ZERO } else { self.remove_axes(vector) }
    }

    /// The part of a vector in the directions that are not held.
    fn project(&self, vector: R::Vec3) -> R::Vec3 {
        if self.stuck { R::Vec3::ZERO } else { self.free(vector) }
    }

    fn is_rough(&self, model: &Model<R>) -> bool {
        let rough = |friction| matches!(friction, Friction::Coulomb(factor) if 0.0 < factor);
        self.planes[..self.count].iter().any(|&plane| rough(model.planes[plane].friction))
    }

    /// What each plane pushes along its normal to make up an impulse, newton seconds, and what is
    /// left along the planes.
    fn pushes(&self, model: &Model<R>, impulse: R::Vec3) -> ([R; 3], R::Vec3) {
        let (mut pushes, mut rest) = ([R::ZERO; 3], impulse);
        // Backwards: the last axis belongs to the last normal alone.
        for row in (0..self.count).rev() {
            pushes[row] = rest.dot(self.axes[row]) / self.slopes[row];
            rest -= model.planes[self.planes[row]].normal * pushes[row];
        }
        (pushes, rest)
    }

    /// The largest impulse of friction, newton seconds.
    fn budget(&self, model: &Model<R>, pushes: [R; 3]) -> R {
        let mut budget = R::ZERO;
        for (&plane, push) in self.planes[..self.count].iter().zip(pushes) {
            if let Friction::Coulomb(factor) = model.planes[plane].friction {
                budget += R::of(factor) * push.max(R::ZERO);
            }
        }
        budget
    }

    /// Decides for one particle, from the impulse that its planes would need to give.
    fn review(&mut self, model: &Model<R>, velocity: R::Vec3, impulse: R::Vec3) -> bool {
        let (pushes, along) = self.pushes(model, impulse);
        if pushes[..self.count].iter().any(|&push| push < R::ZERO) {
            self.release(model, pushes);
            return true;
        }
        if !self.is_rough(model) {
            return false;
        }
        let (budget, free) = (self.budget(model, pushes), self.free(velocity));
        if self.stuck {
            let needed = along.dot(along).sqrt();
            self.stuck = needed <= budget;
            self.friction = if self.stuck { R::Vec3::ZERO } else { along * (budget / needed) };
            return !self.stuck;
        }
        let turned = R::ZERO < free.dot(self.friction);
        if turned || free.dot(free) == R::ZERO {
            (self.stuck, self.friction) = (true, R::Vec3::ZERO);
            return true;
        }
        let friction = slowing::<R>(free, budget);
        let step = friction - self.friction;
        self.friction = friction;
        // One part in a hundred of friction is less than anybody knows of its factor.
        let tolerance = R::of(1e-2) * budget;
        tolerance * tolerance < step.dot(step)
    }

    /// Leaves the planes that pull.
    fn release(&mut self, model: &Model<R>, pushes: [R; 3]) {
        let before = *self;
        *self = Hold::new(before.particle);
        for (&plane, push) in before.planes[..before.count].iter().zip(pushes) {
            if R::ZERO <= push {
                self.add(model, plane);
            }
        }
    }
}

/// An impulse of size `budget` against a velocity.
fn slowing<R: Real>(velocity: R::Vec3, budget: R) -> R::Vec3 {
    let speed = velocity.dot(velocity).sqrt();
    if speed == R::ZERO { R::Vec3::ZERO } else { -(velocity * (budget / speed)) }
}

fn height<R: Real>(plane: &PlaneColumn<R>, position: R::Vec3) -> R {
    plane.normal.dot(position) - plane.offset
}

fn near<R: Real>(model: &Model<R>, plane: &PlaneColumn<R>, position: R::Vec3) -> R {
    R::of(NEAR) * (R::of(model.size) + plane.offset.abs() + position.extent())
}

fn transpose<R: Real>([a, b, c]: [R::Vec3; 3]) -> [R::Vec3; 3] {
    let axes = [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z].map(R::Vec3::of);
    let [a, b, c] = [a, b, c].map(Vector::components);
    core::array::from_fn(|row| axes[0] * a[row] + axes[1] * b[row] + axes[2] * c[row])
}
