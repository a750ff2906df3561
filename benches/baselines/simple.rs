//! The simple kernel: plain loops over springs, particles and planes, which give the same bits as
//! the compiled kernels.

use super::forces::{Forces, Motion};
use msd::core::{Friction, Integrator, Plane, Real, Scene, Settings, Vector};

/// A system that is stepped by plain loops: no grabs, no pushes.
#[derive(Clone)]
pub struct Simple<R: Real> {
    forces: Forces<R>,
    masses: Vec<R>,
    inverse_masses: Vec<R>,
    planes: Vec<Plane>,
    gravity: R::Vec3,
    settings: Settings,
    pub positions: Vec<R::Vec3>,
    pub velocities: Vec<R::Vec3>,
    /// Forces of the last evaluation, newtons, and the power that they dissipate, watts.
    pulls: Vec<R::Vec3>,
    power: f64,
    /// Work columns, as many as the method needs.
    columns: [Vec<R::Vec3>; 4],
    /// Energy dissipated, joules.
    pub dissipated: f64,
}

impl<R: Real> Simple<R> {
    /// Makes a scene ready to be stepped by an explicit method.
    pub fn new(scene: &Scene, settings: Settings) -> Self {
        let method = settings.integrator;
        assert!(Integrator::EXPLICIT.contains(&method), "{method} is not explicit");
        let particles = || scene.particles.iter();
        let masses: Vec<R> = particles().map(|particle| R::of(particle.mass)).collect();
        let mut inverse_masses: Vec<R> = masses.iter().map(|&mass| R::ONE / mass).collect();
        let mut velocities: Vec<R::Vec3> = particles().map(|p| R::Vec3::of(p.velocity)).collect();
        for pin in &scene.pins {
            inverse_masses[pin.particle] = R::ZERO;
            velocities[pin.particle] = R::Vec3::of(pin.velocity);
        }
        let used = match method {
            Integrator::VelocityVerlet => 3,
            Integrator::Rk4 => 4,
            _ => 0,
        };
        let column =
            |column: usize| vec![R::Vec3::ZERO; if column < used { masses.len() } else { 0 }];
        Simple {
            forces: Forces::new(scene),
            planes: scene.planes.clone(),
            gravity: R::Vec3::of(scene.world.gravity),
            settings,
            positions: particles().map(|particle| R::Vec3::of(particle.position)).collect(),
            velocities,
            pulls: vec![R::Vec3::ZERO; masses.len()],
            power: 0.0,
            columns: [0, 1, 2, 3].map(column),
            dissipated: 0.0,
            masses,
            inverse_masses,
        }
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        let substep = self.settings.substep();
        let h = R::of(substep);
        for row in 0..self.settings.substeps {
            let power = match self.settings.integrator {
                Integrator::ExplicitEuler => self.explicit_euler(h),
                Integrator::VelocityVerlet => self.velocity_verlet(h, 0 < row),
                Integrator::Rk4 => self.rk4(h),
                _ => self.symplectic_euler(h),
            };
            self.dissipated += power * substep;
            for plane in 0..self.planes.len() {
                self.dissipated += self.meet(self.planes[plane], h);
            }
        }
    }

    /// Evaluates the forces at the present state.
    fn pull(&mut self) -> f64 {
        let motion = Motion { positions: &self.positions, velocities: &self.velocities };
        let power = self.forces.set_external(motion, &mut self.pulls);
        power + self.forces.add_springs(motion, &mut self.pulls)
    }

    fn explicit_euler(&mut self, h: R) -> f64 {
        let power = self.pull();
        self.drift(h);
        self.kick(h);
        power
    }

    fn symplectic_euler(&mut self, h: R) -> f64 {
        let power = self.pull();
        self.kick(h);
        self.drift(h);
        power
    }

    /// Dampers are evaluated at v + h/2 a_n + h/4 (a_n + a_(n−1)).
    fn velocity_verlet(&mut self, h: R, warm: bool) -> f64 {
        let half = h * R::HALF;
        let quarter = half * R::HALF;
        if !warm {
            self.power = self.pull();
            self.set_accelerations();
            let [now, before, ..] = &mut self.columns;
            before.copy_from_slice(now);
        }
        let power_before = self.power;
        self.kick_by_accelerations(half);
        self.drift(h);
        if self.forces.is_damped() {
            let Simple { forces, positions, velocities, pulls, columns, .. } = self;
            let [now, before, predicted, _] = columns;
            let rows = predicted.iter_mut().zip(&*velocities).zip(now.iter().zip(before.iter()));
            for ((predicted, &velocity), (&now, &before)) in rows {
                *predicted = velocity + (now + before) * quarter;
            }
            core::mem::swap(now, before);
            let motion = Motion { positions, velocities: predicted };
            self.power = forces.set_external(motion, pulls) + forces.add_springs(motion, pulls);
        } else {
            self.power = self.pull();
        }
        self.set_accelerations();
        self.kick_by_accelerations(half);
        0.5 * (power_before + self.power)
    }

    fn set_accelerations(&mut self) {
        let rows = self.columns[0].iter_mut().zip(&self.pulls).zip(&self.inverse_masses);
        rows.for_each(|((acceleration, &force), &w)| *acceleration = force * w);
    }

    fn kick_by_accelerations(&mut self, half: R) {
        for (velocity, &acceleration) in self.velocities.iter_mut().zip(&self.columns[0]) {
            *velocity += acceleration * half;
        }
    }

    fn rk4(&mut self, h: R) -> f64 {
        let [mut x, mut v, mut slopes, mut gains] = core::mem::take(&mut self.columns);
        x.copy_from_slice(&self.positions);
        v.copy_from_slice(&self.velocities);
        slopes.fill(R::Vec3::ZERO);
        gains.fill(R::Vec3::ZERO);
        let (half, two) = (h * R::HALF, R::ONE + R::ONE);
        let mut power = 0.0;
        for (weight, reach) in [(R::ONE, half), (two, half), (two, h)] {
            power += weight.to_f64() * self.pull();
            for row in 0..x.len() {
                let acceleration = self.pulls[row] * self.inverse_masses[row];
                let velocity = self.velocities[row];
                slopes[row] += velocity * weight;
                gains[row] += acceleration * weight;
                self.positions[row] = x[row] + velocity * reach;
                self.velocities[row] = v[row] + acceleration * reach;
            }
        }
        power += self.pull();
        let sixth = h / R::of(6.0);
        for row in 0..x.len() {
            let last = self.pulls[row] * self.inverse_masses[row];
            self.positions[row] = x[row] + (slopes[row] + self.velocities[row]) * sixth;
            self.velocities[row] = v[row] + (gains[row] + last) * sixth;
        }
        self.columns = [x, v, slopes, gains];
        power / 6.0
    }

    fn drift(&mut self, h: R) {
        for (position, &velocity) in self.positions.iter_mut().zip(&self.velocities) {
            *position += velocity * h;
        }
    }

    fn kick(&mut self, h: R) {
        let rows = self.velocities.iter_mut().zip(&self.pulls).zip(&self.inverse_masses);
        rows.for_each(|((velocity, &force), &w)| *velocity += force * (w * h));
    }

    /// Moves every particle out of a plane, bounces it and slows it along the plane; returns the
    /// energy dissipated, joules.
    fn meet(&mut self, plane: Plane, h: R) -> f64 {
        let scaled = plane.normal / plane.normal.abs().max_element();
        let normal = R::Vec3::of(scaled / scaled.length());
        let offset = R::of(plane.offset);
        let resting_speed = (h + h) * self.gravity.dot(normal).abs();
        let mut taken = 0.0;
        for (particle, &force) in self.pulls.iter().enumerate() {
            let depth = offset - normal.dot(self.positions[particle]);
            if depth <= R::ZERO || self.inverse_masses[particle] == R::ZERO {
                continue;
            }
            let (moved, velocity) = (normal * depth, self.velocities[particle]);
            let bounced = bounce((normal, &plane), velocity, resting_speed);
            self.positions[particle] += moved;
            self.velocities[particle] = bounced;
            let slower = velocity.dot(velocity) - bounced.dot(bounced);
            let slowed = slower * R::HALF * self.masses[particle];
            taken += slowed.to_f64() + force.dot(moved).to_f64();
        }
        taken
    }
}

/// The velocity after a bounce; a normal speed below `resting_speed` is not returned.
fn bounce<V: Vector>((normal, plane): (V, &Plane), velocity: V, resting_speed: V::Scalar) -> V
where
    V::Scalar: Real,
{
    let zero = V::Scalar::ZERO;
    let one = V::Scalar::ONE;
    let normal_speed = velocity.dot(normal);
    let tangential = velocity - normal * normal_speed;
    let restitution = V::Scalar::of(plane.restitution);
    let restitution = if -normal_speed < resting_speed { zero } else { restitution };
    let after = if zero <= normal_speed { normal_speed } else { -(restitution * normal_speed) };
    let kept = match plane.friction {
        Friction::TangentialLoss(loss) => one - V::Scalar::of(loss),
        Friction::Coulomb(factor) => {
            let speed = tangential.dot(tangential).sqrt();
            let loss = V::Scalar::of(factor) * (after - normal_speed);
            if speed <= loss { zero } else { one - loss / speed }
        }
    };
    normal * after + tangential * kept
}
