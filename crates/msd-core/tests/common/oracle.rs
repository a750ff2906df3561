//! Explicit methods and contact with planes in plain loops, as a measure of the fast ones.
//!
//! Particles meet one plane at a time: `tests/contact/` has the laws of those at several.

use msd_core::elements::springs::Sum;
use msd_core::elements::springs::law::pull;
use msd_core::{
    Friction, Integrator, Model, PlaneColumn, Real, Settings, Simulation, State, Vector,
};
use std::collections::BTreeMap;

/// Explicit methods and contact with planes in plain loops over particles: the oracle.
pub struct Oracle<'a, R: Real> {
    pub model: &'a Model<R>,
    pub state: State<R>,
    pub forces: Vec<R::Vec3>,
    /// Energy dissipated, less the work of pins, joules.
    pub counted: f64,
}

impl<R: Real> Oracle<'_, R> {
    pub fn of(simulation: &Simulation<R>) -> Oracle<'_, R> {
        let forces = vec![R::Vec3::ZERO; simulation.model().particle_count()];
        Oracle { model: simulation.model(), state: simulation.state(), forces, counted: 0.0 }
    }

    /// Sets the forces at the positions of the state and some velocities; returns the power taken.
    pub fn evaluate(&mut self, velocities: Vec<R::Vec3>) -> f64 {
        let Oracle { model, state, forces, .. } = self;
        let motion = State { positions: state.positions.clone(), velocities };
        let mut power = set_fields(model, &motion, forces);
        let columns = [&motion.positions[..], &motion.velocities];
        power += add_springs(model, columns, forces);
        for grab in model.grabs() {
            let particle = grab.particle as usize;
            forces[particle] += grab.pull(motion.positions[particle], motion.velocities[particle]);
        }
        power
    }

    /// The same, less the power that pins give.
    fn evaluate_with_pins(&mut self, velocities: Vec<R::Vec3>) -> f64 {
        let power = self.evaluate(velocities.clone());
        let pins = (0..velocities.len()).filter(|&particle| self.model.is_pinned(particle));
        let pulled = pins.map(|pin| self.forces[pin].to_f64().dot(velocities[pin].to_f64()));
        power + pulled.sum::<f64>()
    }

    pub fn acceleration(&self, particle: usize) -> R::Vec3 {
        self.forces[particle] * self.model.inverse_masses()[particle]
    }

    pub fn step(&mut self, settings: Settings) {
        let h = R::of(settings.substep());
        let mut accelerations = [Vec::new(), Vec::new()];
        let (mut power, mut bounced) = (0.0, true);
        for _ in 0..settings.substeps {
            let velocities = self.state.velocities.clone();
            let (count, start) = (velocities.len(), self.state.positions.clone());
            match settings.integrator {
                Integrator::ExplicitEuler | Integrator::SymplecticEuler => {
                    self.counted += self.evaluate_with_pins(velocities) * h.to_f64();
                    let drift_first = settings.integrator == Integrator::ExplicitEuler;
                    for p in 0..count {
                        let kick = self.forces[p] * (self.model.inverse_masses()[p] * h);
                        let before = self.state.velocities[p];
                        self.state.velocities[p] += kick;
                        let v = if drift_first { before } else { self.state.velocities[p] };
                        self.state.positions[p] += v * h;
                    }
                }
                Integrator::VelocityVerlet => {
                    // At the start of a step, and after a bounce.
                    if bounced {
                        power = self.evaluate_with_pins(velocities);
                        let now: Vec<R::Vec3> = (0..count).map(|p| self.acceleration(p)).collect();
                        accelerations = [now.clone(), now];
                    }
                    power = self.verlet(h, &mut accelerations, power);
                }
                _ => self.rk4(h),
            }
            bounced = match settings.integrator {
                Integrator::ExplicitEuler => self.resolve(h, h, None),
                Integrator::SymplecticEuler => self.resolve(h, R::ZERO, None),
                Integrator::VelocityVerlet => self.resolve(h, h * R::HALF, None),
                _ => self.resolve(h, h * R::HALF, Some(&start)),
            };
        }
    }

    fn verlet(&mut self, h: R, [now, before]: &mut [Vec<R::Vec3>; 2], power_before: f64) -> f64 {
        let (half, count) = (h * R::HALF, now.len());
        for (p, &acceleration) in now.iter().enumerate() {
            self.state.velocities[p] += acceleration * half;
        }
        let places = self.state.positions.clone();
        let mut velocities = core::mem::take(&mut self.state.velocities);
        self.settle(&places, &mut velocities, now, (half, h, true));
        for (position, &velocity) in self.state.positions.iter_mut().zip(&velocities) {
            *position += velocity * h;
        }
        self.state.velocities = velocities;
        let damped = self.model.is_damped()
            || self.model.drag() != R::ZERO
            || !self.model.grabs().is_empty();
        let ahead = half * R::HALF;
        let mut predicted = self.state.velocities.clone();
        if damped {
            for p in 0..count {
                predicted[p] += (now[p] + before[p]) * ahead;
            }
            self.settle(&places, &mut predicted, now, (half, h, false));
        }
        let power = self.evaluate_with_pins(predicted);
        *before = now.clone();
        for (p, now) in now.iter_mut().enumerate() {
            *now = self.acceleration(p);
            self.state.velocities[p] += *now * half;
        }
        if self.lies(&places) {
            self.settle_state(now, (half, h, false));
        }
        self.counted += 0.5 * (power_before + power) * h.to_f64();
        power
    }

    fn rk4(&mut self, h: R) {
        let (half, two, sixth) = (h * R::HALF, R::ONE + R::ONE, h / R::of(6.0));
        let start = self.state.clone();
        let count = self.forces.len();
        let mut slopes: State<R> =
            State { positions: vec![R::Vec3::ZERO; count], velocities: vec![R::Vec3::ZERO; count] };
        let mut energy = 0.0;
        let lies = self.lies(&start.positions);
        for (weight, reach) in [(R::ONE, half), (two, half), (two, h)] {
            energy += weight.to_f64() * self.evaluate_with_pins(self.state.velocities.clone());
            for p in 0..count {
                let (velocity, acceleration) = (self.state.velocities[p], self.acceleration(p));
                slopes.positions[p] += velocity * weight;
                slopes.velocities[p] += acceleration * weight;
                self.state.positions[p] = start.positions[p] + velocity * reach;
                self.state.velocities[p] = start.velocities[p] + acceleration * reach;
            }
            if lies {
                self.settle_stage(&start.velocities, reach, h, false);
            }
        }
        energy += self.evaluate_with_pins(self.state.velocities.clone());
        for p in 0..count {
            let slope = slopes.positions[p] + self.state.velocities[p];
            self.state.positions[p] = start.positions[p] + slope * sixth;
            let slope = slopes.velocities[p] + self.acceleration(p);
            self.state.velocities[p] = start.velocities[p] + slope * sixth;
        }
        if lies {
            self.settle_stage(&start.velocities, h, h, true);
        }
        self.counted += energy * sixth.to_f64();
    }

    /// Whether a particle that something moves is on a plane.
    fn lies(&self, positions: &[R::Vec3]) -> bool {
        let on = |&x: &R::Vec3| self.model.planes().iter().any(|plane| is_on(plane, x));
        (0..positions.len()).any(|p| !self.model.is_pinned(p) && on(&positions[p]))
    }

    fn settle_stage(&mut self, starts: &[R::Vec3], reach: R, h: R, loses: bool) {
        let kicks = self.state.velocities.iter().zip(starts);
        let divided = |vector: R::Vec3| {
            R::Vec3::from_components(vector.components().map(|number| number / reach))
        };
        let kicks: Vec<R::Vec3> = kicks.map(|(&v, &start)| divided(v - start)).collect();
        self.settle_state(&kicks, (reach, h, loses));
    }

    fn settle_state(&mut self, accelerations: &[R::Vec3], kick: (R, R, bool)) {
        let places = self.state.positions.clone();
        let mut velocities = core::mem::take(&mut self.state.velocities);
        self.settle(&places, &mut velocities, accelerations, kick);
        self.state.velocities = velocities;
    }

    /// Holds velocities after a kick of a length, in a substep, that may take tangential losses.
    fn settle(
        &self,
        positions: &[R::Vec3],
        velocities: &mut [R::Vec3],
        accelerations: &[R::Vec3],
        (length, h, loses): (R, R, bool),
    ) {
        for p in (0..positions.len()).filter(|&p| !self.model.is_pinned(p)) {
            let planes = self.model.planes().iter().filter(|plane| is_on(plane, positions[p]));
            let planes: Vec<_> = planes.collect();
            let (v, a) = (&mut velocities[p], accelerations[p]);
            let start = *v - a * length;
            let [plane] = planes[..] else { continue };
            let pull = plane.normal.dot(a);
            let before = plane.normal.dot(*v) - pull * length;
            if lay(plane, before, (h + h) * pull, start)
                && pull < R::ZERO
                && plane.normal.dot(*v) < R::ZERO
            {
                *v = slowed(plane, loses, *v);
            }
        }
    }

    /// The stiffness of all springs at a particle.
    fn stiffness(&self, particle: usize) -> R {
        let springs = self.model.springs();
        let at = |ends: [usize; 2]| ends.contains(&particle);
        let all = springs.present().filter(|&(_, ends)| at(ends));
        all.fold(R::ZERO, |sum, (spring, _)| sum + springs.law(spring).stiffness)
    }

    /// Lets particles meet planes; the way of a substep was that from `starts` or, without them, h
    /// (v − lag a). Returns whether one of them bounced.
    fn resolve(&mut self, h: R, lag: R, starts: Option<&[R::Vec3]>) -> bool {
        let mut any = false;
        let shift = lag - h * R::HALF;
        for p in (0..self.forces.len()).filter(|&p| !self.model.is_pinned(p)) {
            let (x, v) = (self.state.positions[p], self.state.velocities[p]);
            let pull = self.acceleration(p);
            let start = starts.map_or_else(|| x - (v - pull * lag) * h, |starts| starts[p]);
            let (mut x, mut v) = (x, v);
            let stiffness = self.stiffness(p) * self.model.inverse_masses()[p];
            for plane in self.model.planes() {
                let depth = plane.offset - plane.normal.dot(x);
                // Forces were evaluated at the end of the substep, or at its start.
                let at_end = lag == h * R::HALF;
                let from = if at_end { depth } else { plane.normal.dot(x - start) + depth };
                let strain = [stiffness * from.abs(), from.abs()];
                let bounced;
                ((x, v), bounced) = met(plane, (h, shift), (pull, strain), start, (x, v));
                any |= bounced;
            }
            (self.state.positions[p], self.state.velocities[p]) = (x, v);
        }
        any
    }
}

/// Whether a particle is on a plane.
fn is_on<R: Real>(plane: &PlaneColumn<R>, x: R::Vec3) -> bool {
    (plane.normal.dot(x) - plane.offset).abs() <= rounding(plane, x)
}

/// The rounding of a gap.
fn rounding<R: Real>(plane: &PlaneColumn<R>, x: R::Vec3) -> R {
    let (n, x) = (plane.normal.components(), x.components());
    let [x, y, z] = [0, 1, 2].map(|axis| (n[axis] * x[axis]).abs());
    (x + y + z) * (R::EPSILON * R::of(4.0))
}

/// Whether a particle on a plane lay there, at a speed along the normal, a part of a velocity.
fn lay<R: Real>(plane: &PlaneColumn<R>, speed: R, limit: R, velocity: R::Vec3) -> bool {
    let rounding = R::EPSILON * R::of(8.0) * Real::sqrt(velocity.dot(velocity));
    speed <= rounding - limit * R::of(0.01) && (plane.restitution() == 0.0 || limit < speed)
}

/// Factor of Coulomb and tangential loss of a plane.
fn friction<R: Real>(plane: &PlaneColumn<R>) -> (R, R) {
    match plane.friction() {
        Friction::Coulomb(factor) => (R::of(factor), R::ZERO),
        Friction::TangentialLoss(loss) => (R::ZERO, R::of(loss)),
    }
}

/// The velocity along a plane that friction leaves of one into it.
fn slowed<R: Real>(plane: &PlaneColumn<R>, loses: bool, v: R::Vec3) -> R::Vec3 {
    let speed = plane.normal.dot(v);
    let along = v - plane.normal * speed;
    let (factor, loss) = friction(plane);
    let (slip, grip) = (Real::sqrt(along.dot(along)), factor * -speed);
    let kept = if slip <= grip { R::ZERO } else { R::ONE - grip * (R::ONE / slip) };
    along * (kept * (R::ONE - if loses { loss } else { R::ZERO }))
}

/// Position and velocity of a particle that may have come into a plane, and whether it bounced.
fn met<R: Real>(
    plane: &PlaneColumn<R>,
    (h, shift): (R, R),
    (pull, [strain, from]): (R::Vec3, [R; 2]),
    start: R::Vec3,
    (x, v): (R::Vec3, R::Vec3),
) -> ((R::Vec3, R::Vec3), bool) {
    let (n, depth) = (plane.normal, plane.offset - plane.normal.dot(x));
    // Methods whose velocities are those of the end hold particles that lie, which may be inside by
    // rounding.
    let noise = if shift == R::ZERO { rounding(plane, x) } else { R::ZERO };
    if depth <= noise {
        return ((x, v), false);
    }
    let (e, two) = (R::of(plane.restitution()), R::ONE + R::ONE);
    let (factor, loss) = friction(plane);
    let (speed, press) = (n.dot(v), n.dot(pull));
    let (real, limit) = (speed - shift * press, (h + h) * press);
    let squared = real * real + (press + press) * depth - strain * from;
    let bounces = e != R::ZERO
        && speed < R::ZERO
        && real < R::ZERO
        && !(press < R::ZERO && squared < limit * limit);
    let (mut push, lift, mut reach) = ((-speed).max(R::ZERO), depth, depth);
    if bounces {
        let impact = squared.max(R::ZERO).sqrt();
        let after = e * impact;
        let time = (two * depth / (impact - real)).min(h);
        push = after - real;
        if shift != R::ZERO {
            push -= strain * h * R::HALF;
        }
        reach = push * time;
    }
    let (along, moved) = (v - n * speed, x - start);
    let (slip, grip, way) = (along.dot(along).sqrt(), factor * push, n.dot(moved));
    let kept = if slip <= grip { R::ZERO } else { R::ONE - grip * (R::ONE / slip) };
    let velocity = n * (speed + push) + along * (kept * (R::ONE - loss));
    if slip <= grip && R::ZERO < grip {
        let (gap, noise) = (-(way + depth), rounding(plane, x));
        let since = if gap <= noise { R::ONE } else { depth / -way };
        let lift = if gap.abs() <= noise { R::ZERO } else { lift + way };
        let before = (moved - n * way) * (R::ONE - since);
        return ((start + (n * lift + before), velocity), bounces);
    }
    let slid = if slip <= grip { R::ZERO } else { factor * reach * (R::ONE / slip) };
    ((x + (n * lift - along * slid), velocity), bounces)
}

/// Overwrites forces with those of the fields; returns the power of the drag.
fn set_fields<R: Real>(model: &Model<R>, motion: &State<R>, forces: &mut [R::Vec3]) -> f64 {
    let mut power = 0.0;
    for (p, force) in forces.iter_mut().enumerate() {
        *force = model.gravity() * model.masses()[p] + model.force() + R::Vec3::ZERO;
        if model.drag() != R::ZERO {
            let v = motion.velocities[p];
            *force -= v * model.drag();
            power += (model.drag() * v.dot(v)).to_f64();
        }
    }
    power
}

/// Adds the pull of every spring to `forces`, newtons, and returns the power that their dampers
/// dissipate, watts. All columns are in the order of the scene.
///
/// Springs pull in the order of their rows, on sums that are added to the forces in the order of
/// [`Sum`]; then the extras of the layout.
fn add_springs<R: Real>(
    model: &Model<R>,
    [positions, velocities]: [&[R::Vec3]; 2],
    forces: &mut [R::Vec3],
) -> f64 {
    let springs = model.springs();
    let motion = |end: u32| [positions, velocities].map(|column| column[end as usize].components());
    let extras = springs.extras().map(|spring| {
        let [a, b] = springs.ends()[spring as usize];
        (spring, [a.min(b), a.max(b)], [Sum::Forces; 2])
    });
    let mut power = 0.0;
    let mut add = |turns: &mut dyn Iterator<Item = (u32, [u32; 2], [Sum; 2])>| {
        let mut sums: BTreeMap<(Sum, u32), R::Vec3> = BTreeMap::new();
        for (spring, ends, [here, there]) in turns {
            let (law, is_there) = (springs.law(spring as usize), !springs.is_cut(spring as usize));
            let (pull, burns) = pull::<R, true>(motion(ends[0]), motion(ends[1]), law, is_there);
            let pull = R::Vec3::from_components(pull);
            for (sum, end, pull) in [(here, ends[0], -pull), (there, ends[1], pull)] {
                match sum {
                    Sum::Forces => forces[end as usize] += pull,
                    sum => *sums.entry((sum, end)).or_default() += pull,
                }
            }
            power += burns.to_f64();
        }
        sums.into_iter().for_each(|((_, end), sum)| forces[end as usize] += sum);
    };
    add(&mut springs.turns(model.slots()));
    add(&mut { extras });
    power
}
