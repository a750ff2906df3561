//! Bit equality of the fast kernels with plain loops.
//!
//! They agree whatever the topology, the instructions, the precision and the method.

mod common;

use common::{Random, bits, state_bits};
use msd_core::elements::springs::{Sum, plain};
use msd_core::glam::DVec3;
use msd_core::{
    Friction, Instructions, Integrator, Interaction, Material, Model, Particle, Pin, Plane,
    PlaneColumn, Real, Scene, Select, Settings, Simulation, Spring, State, Vector, shape,
};
use proptest::prelude::*;

/// The sets of instructions that this machine has.
fn sets() -> impl Iterator<Item = Instructions> {
    Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best())
}

/// How often a property is tried: seldom where it is slow, in an emulator or in Miri.
const CASES: u32 = match (cfg!(debug_assertions), cfg!(target_arch = "x86_64"), cfg!(miri)) {
    (_, _, true) => 2,
    (false, _, _) => 128,
    (true, true, _) => 32,
    (true, false, _) => 8,
};

/// Explicit methods and contact with planes in plain loops over particles: the oracle.
struct Oracle<'a, R: Real> {
    model: &'a Model<R>,
    state: State<R>,
    forces: Vec<R::Vec3>,
    /// Energy dissipated, joules.
    counted: f64,
}

impl<R: Real> Oracle<'_, R> {
    fn of(simulation: &Simulation<R>) -> Oracle<'_, R> {
        let forces = vec![R::Vec3::ZERO; simulation.model().particle_count()];
        Oracle { model: simulation.model(), state: simulation.state(), forces, counted: 0.0 }
    }

    /// Sets the forces at the positions of the state and some velocities; returns the power taken.
    fn evaluate(&mut self, velocities: Vec<R::Vec3>) -> f64 {
        let Oracle { model, state, forces, .. } = self;
        let motion = State { positions: state.positions.clone(), velocities };
        let mut power = set_fields(model, &motion, forces);
        let columns = [&motion.positions[..], &motion.velocities];
        power += plain::add_forces(model.springs(), model.slots(), columns, forces);
        for grab in model.grabs() {
            let particle = grab.particle as usize;
            forces[particle] += grab.pull(motion.positions[particle], motion.velocities[particle]);
        }
        power
    }

    fn acceleration(&self, particle: usize) -> R::Vec3 {
        self.forces[particle] * self.model.inverse_masses()[particle]
    }

    fn step(&mut self, settings: Settings) {
        let h = R::of(settings.substep());
        let mut accelerations = [Vec::new(), Vec::new()];
        let (mut power, mut bounced) = (0.0, true);
        for _ in 0..settings.substeps {
            let velocities = self.state.velocities.clone();
            let (count, start) = (velocities.len(), self.state.positions.clone());
            match settings.integrator {
                Integrator::ExplicitEuler | Integrator::SymplecticEuler => {
                    self.counted += self.evaluate(velocities) * h.to_f64();
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
                        power = self.evaluate(velocities);
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
        let power = self.evaluate(predicted);
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
            energy += weight.to_f64() * self.evaluate(self.state.velocities.clone());
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
        energy += self.evaluate(self.state.velocities.clone());
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
            if let [plane] = planes[..] {
                let pull = plane.normal.dot(a);
                let before = plane.normal.dot(*v) - pull * length;
                if lay(plane, before, (h + h) * pull, start)
                    && pull < R::ZERO
                    && plane.normal.dot(*v) < R::ZERO
                {
                    *v = slowed(plane, loses, *v);
                }
                continue;
            }
            let (kicked, limit) = (*v, (h + h) * Real::sqrt(a.dot(a)));
            for _ in 0..128 {
                for plane in &planes {
                    let speed = plane.normal.dot(start);
                    if lay(plane, speed, -limit, start) && plane.normal.dot(*v) < R::ZERO {
                        *v = slowed(plane, loses, *v);
                    }
                }
            }
            let rounding = R::EPSILON * R::EPSILON * R::of(64.0) * kicked.dot(kicked);
            if v.dot(*v) <= rounding && !planes.is_empty() {
                *v = R::Vec3::ZERO;
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
    speed <= rounding && (plane.restitution() == 0.0 || limit < speed)
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
    // Methods whose velocities are those of the end hold what lies, which may be inside by rounding.
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

/// Rows that a user might write, and some that nobody would: ends that coincide, springs twice,
/// particles alone, numbers of their own or all alike, lattices with and without diagonals that
/// cross their ends, several bodies.
fn scenes() -> impl Strategy<Value = Scene> {
    // Columns are placed from 256 particles on, and bodies of as many have blocks of their own.
    let most: usize = if cfg!(miri) { 300 } else { 701 };
    let counts = prop_oneof![4 => 1..201usize, 2 => 256..most];
    let numbers = (counts, any::<u64>(), 0.0..8.0, any::<[bool; 7]>());
    numbers.prop_map(|(count, seed, degree, [alike, damped, floor, lattice, drag, corner, two])| {
        let mut random = Random(seed | 1);
        let particle = |random: &mut Random| Particle {
            position: random.vector() * 4.0,
            velocity: random.vector() - 0.5,
            mass: if alike { 1.0 } else { 0.5 + random.unit() },
        };
        let mut particles: Vec<Particle> = (0..count).map(|_| particle(&mut random)).collect();
        if 3 < count {
            particles[count / 2].position = particles[count / 2 - 1].position;
        }
        let springs = if 1 < count { (count as f64 * degree) as usize } else { 0 };
        let ends = |random: &mut Random, number: usize| {
            let a = if lattice { number % count } else { random.below(count) };
            let near = [1, 7, 8, 9, 7, 1, 57, 8][number / count % 8];
            // One in forty belongs to no family.
            let is_odd = random.below(40) == 0;
            let b = if lattice && !is_odd { (a + near) % count } else { random.below(count) };
            [a, if a == b { (a + 1) % count } else { b }]
        };
        let mut spring = |ends: [usize; 2]| Spring {
            ends,
            rest_length: if alike { 1.0 } else { random.unit() },
            stiffness: if alike { 50.0 } else { 100.0 * random.unit() },
            damping: if damped { if alike { 0.5 } else { random.unit() } } else { 0.0 },
        };
        let mut other = Random(seed.rotate_left(7) | 1);
        let springs = (0..springs).map(|number| spring(ends(&mut other, number))).collect();
        let mut planes = Vec::new();
        if floor {
            let friction = Friction::Coulomb(0.3);
            planes.push(Plane { normal: DVec3::Y, offset: 1.0, restitution: 0.5, friction });
        }
        if corner {
            let friction = Friction::TangentialLoss(0.1);
            let normal = DVec3::new(1.0, 0.5, 0.0);
            planes.push(Plane { normal, offset: 0.5, restitution: 0.9, friction });
        }
        let pins = if 2 < count { vec![Pin { particle: 1, velocity: DVec3::Y }] } else { vec![] };
        let mut scene = Scene { particles, springs, planes, pins, ..Scene::default() };
        if two {
            let half = count / 2;
            for particles in [0..half, half..count] {
                let body = msd_core::Body { particles, ..Default::default() };
                scene.bodies.push(body);
            }
        }
        scene.world.drag = if drag { 0.01 } else { 0.0 };
        scene
    })
}

/// Cuts, as a user makes them: one, a few, one twice.
fn cuts(scene: &Scene) -> Vec<Interaction> {
    let count = scene.springs.len();
    let springs: Vec<usize> =
        if count == 0 { vec![] } else { vec![0, count / 2, count / 2, count - 1] };
    springs.into_iter().map(|spring| Interaction::Cut { spring }).collect()
}

fn simulation<R: Real>(scene: &Scene, settings: Settings, queue: &[Interaction]) -> Simulation<R> {
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    for &interaction in queue {
        simulation.queue(interaction).expect("a valid interaction");
    }
    simulation.apply_queued().expect("finite");
    simulation
}

fn check_forces<R: Real>(scene: &Scene, queue: &[Interaction]) {
    for instructions in sets() {
        let mut simulation = simulation::<R>(scene, Settings::default(), queue);
        simulation.set_instructions(instructions);
        let mut oracle = Oracle::of(&simulation);
        let power = oracle.evaluate(oracle.state.velocities.clone());
        let (swept, swept_power) = simulation.forces();
        assert_eq!(bits::<R>(&swept), bits::<R>(&oracle.forces), "{}", instructions.name());
        // Each summand is rounded once, in the precision of the run, and their sum in f64.
        let rounding = 200.0 * R::EPSILON.to_f64() * power.abs();
        assert!((swept_power - power).abs() <= rounding, "{swept_power} {power}");
    }
}

fn check_steps<R: Real>(scene: &Scene, queue: &[Interaction]) {
    for integrator in Integrator::EXPLICIT {
        let settings = Settings { integrator, step: 0.02, substeps: 3, ..Settings::default() };
        for instructions in sets() {
            let mut simulation = simulation::<R>(scene, settings, queue);
            simulation.set_instructions(instructions);
            for _ in 0..3 {
                let before = simulation.clone();
                let mut oracle = Oracle::of(&before);
                oracle.step(settings);
                simulation.step().expect("short and soft");
                let what = (integrator.name(), instructions.name());
                assert_eq!(state_bits(&simulation.state()), state_bits(&oracle.state), "{what:?}");
                if scene.planes.is_empty() {
                    let taken = simulation.dissipated() - before.dissipated();
                    // Rounded once per spring, and speeds are differences of larger ones.
                    let rounding = 1e3
                        * R::EPSILON.to_f64()
                        * (oracle.counted.abs() + simulation.energy().kinetic);
                    assert!((taken - oracle.counted).abs() <= rounding, "{what:?}: {taken} J");
                }
            }
        }
    }
}

/// Implicit methods and XPBD have no oracle here: their bits are the same for all instructions.
fn check_other_steps<R: Real>(scene: &Scene, queue: &[Interaction]) {
    let others = Integrator::ALL.into_iter().filter(|other| !Integrator::EXPLICIT.contains(other));
    for integrator in others {
        let settings = Settings { integrator, step: 0.02, newton: 2, ..Settings::default() };
        let runs: Vec<_> = sets()
            .map(|instructions| {
                let mut simulation = simulation::<R>(scene, settings, queue);
                simulation.set_instructions(instructions);
                let steps: Vec<bool> = (0..3).map(|_| simulation.step().is_ok()).collect();
                (steps, state_bits(&simulation.state()))
            })
            .collect();
        assert!(runs.iter().all(|run| *run == runs[0]), "{integrator}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn forces_have_the_bits_of_the_plain_loop(scene in scenes()) {
        check_forces::<f32>(&scene, &[]);
        check_forces::<f64>(&scene, &cuts(&scene));
    }

    #[test]
    fn explicit_steps_have_the_bits_of_plain_loops(scene in scenes()) {
        let last = scene.particles.len() - 1;
        let grab = Interaction::Grab {
            particle: last,
            target: DVec3::ONE,
            frequency: 3.0,
            damping_ratio: 1.0,
            max_force: 50.0,
        };
        check_steps::<f32>(&scene, &[&cuts(&scene)[..], &[grab]].concat());
        check_steps::<f64>(&scene, &[]);
    }

    #[test]
    fn other_steps_have_the_same_bits_by_all_instructions(scene in scenes()) {
        check_other_steps::<f32>(&scene, &cuts(&scene));
        check_other_steps::<f64>(&scene, &[]);
    }
}

#[test]
fn lattices_of_all_shapes_have_the_bits_of_the_plain_loop() {
    let sizes = [[1, 1, 1], [1, 1, 2], [2, 2, 2], [1, 33, 1], [5, 7, 1]];
    let larger = [[3, 3, 3], [31, 31, 1], [10, 10, 10], [7, 11, 13], [40, 2, 2], [3, 1, 40]];
    for size in sizes.into_iter().chain(larger.into_iter().filter(|_| !cfg!(miri))) {
        let material = Material { mass: 0.3, stiffness: 70.0, damping: 0.4 };
        let mut part = shape::block(size, 0.5, material).expect("small");
        let mut random = Random(9);
        for particle in &mut part.particles {
            particle.position += random.vector() * 0.2;
            particle.velocity += random.vector();
        }
        let scene = Scene::of("block", part);
        check_forces::<f32>(&scene, &[]);
        check_forces::<f64>(&scene, &cuts(&scene));
        let springs = Select::Range(0, scene.springs.len() / 2);
        let stiffer = Interaction::SetStiffness { springs, value: 91.0 };
        check_forces::<f32>(&scene, &[stiffer]);
    }
}

#[test]
#[cfg_attr(miri, ignore = "it would take an hour")]
fn bodies_of_different_widths_keep_their_sums_apart() {
    let material = Material { mass: 0.3, stiffness: 70.0, damping: 0.4 };
    // Each large enough for a block of its own, with halos of different lengths.
    let sizes = [[20, 40, 1], [7, 7, 7], [300, 1, 1], [17, 18, 1], [9, 8, 7]];
    let mut scene = Scene::default();
    let mut random = Random(4);
    for (row, size) in sizes.into_iter().enumerate() {
        let mut part = shape::block(size, 0.5, material).expect("small");
        for particle in &mut part.particles {
            particle.position += random.vector() * 0.2;
            particle.velocity += random.vector();
        }
        scene.add(format!("body {row}"), part);
    }
    // And springs between them.
    for row in 0..40 {
        let ends = [row * 31, 1000 + row * 17];
        scene.springs.push(Spring { ends, rest_length: 1.0, stiffness: 3.0, damping: 0.1 });
    }
    check_forces::<f32>(&scene, &[]);
    check_forces::<f64>(&scene, &cuts(&scene));
    check_steps::<f32>(&scene, &[]);
}

/// A large block without segments, too, is in parts.
#[test]
fn a_large_unstructured_block_has_the_bits_of_the_plain_loop() {
    let count = 12_000;
    let mut random = Random(5);
    let particle = |random: &mut Random| Particle {
        position: random.vector() * 20.0,
        velocity: random.vector() - 0.5,
        mass: 1.0,
    };
    let particles: Vec<Particle> = (0..count).map(|_| particle(&mut random)).collect();
    let spring = |row: usize| Spring {
        ends: [row % count, (row % count + 1 + random.below(149)) % count],
        rest_length: random.unit(),
        stiffness: 100.0 * random.unit(),
        damping: random.unit(),
    };
    let springs = (0..12 * count).map(spring).collect();
    let scene = Scene { particles, springs, ..Scene::default() };
    let simulation = simulation::<f32>(&scene, Settings::default(), &[]);
    let model = simulation.model();
    let sums: Vec<Sum> = model.springs().turns(model.slots()).map(|turn| turn.2[1]).collect();
    let parts: Vec<Sum> = sums.iter().copied().filter(|sum| *sum != Sum::Named).collect();
    let is_first = |sum: &Sum| *sum == parts[0];
    assert!(!parts.is_empty() && !parts.iter().all(is_first), "one part");
    check_forces::<f32>(&scene, &cuts(&scene));
    check_forces::<f64>(&scene, &[]);
}

#[test]
#[cfg_attr(miri, ignore = "it would take an hour")]
fn large_lattices_have_the_bits_of_the_plain_loop() {
    let sizes = [[61, 17, 15], [170, 171, 1], [300, 290, 1]];
    for size in sizes.into_iter().take(if cfg!(debug_assertions) { 1 } else { 3 }) {
        let material = Material { mass: 0.3, stiffness: 70.0, damping: 0.4 };
        let mut part = shape::block(size, 0.5, material).expect("a lattice");
        assert!(100_000 < part.springs.len());
        let mut random = Random(9);
        for particle in &mut part.particles {
            particle.position += random.vector() * 0.2;
            particle.velocity += random.vector();
        }
        let scene = Scene::of("lattice", part);
        let mut queue = cuts(&scene);
        let simulation = simulation::<f32>(&scene, Settings::default(), &[]);
        let model = simulation.model();
        let sums: Vec<[Sum; 2]> = model.springs().turns(model.slots()).map(|turn| turn.2).collect();
        let is_later = |sums: &[Sum; 2]| matches!(sums[1], Sum::Later(_));
        let is_carried = |sums: &[Sum; 2]| sums[0] == Sum::Carried;
        assert!(sums.iter().any(is_later) && sums.iter().any(is_carried), "{size:?}: one part");
        check_forces::<f32>(&scene, &queue);
        queue.push(Interaction::SetStiffness { springs: Select::Range(0, 5000), value: 91.0 });
        check_forces::<f64>(&scene, &queue);
    }
}

/// Whether a number is one that some processors take a hundred cycles for.
fn is_subnormal(number: f64) -> bool {
    number != 0.0 && number.abs() < f64::from(f32::MIN_POSITIVE)
}

#[test]
#[cfg_attr(miri, ignore = "it would take an hour")]
fn a_motion_that_spreads_into_a_body_at_rest_is_never_subnormal() {
    // Each substep dampers hand on a thousandth of a motion by one more particle: without a least
    // motion a shell of subnormal numbers would run through the body, and stay in it.
    let material = Material { mass: 1.0, stiffness: 2200.0, damping: 1.0 };
    let mut scene = Scene::of("bar", shape::block([4, 4, 60], 1.0, material).expect("a lattice"));
    scene.world.gravity = DVec3::ZERO;
    scene.particles[0].velocity = DVec3::new(1.0, 0.5, 0.25);
    for integrator in Integrator::EXPLICIT {
        let settings = Settings { integrator, substeps: 12, ..Settings::default() };
        let mut simulation = Simulation::<f32>::new(&scene, settings).expect("valid");
        for _ in 0..30 {
            simulation.step().expect("stable");
            let (forces, _) = simulation.forces();
            let velocities = simulation.state().velocities;
            let mut numbers = forces.iter().chain(&velocities).flat_map(|v| v.to_array());
            assert!(!numbers.any(|number| is_subnormal(number.into())), "{integrator}");
        }
        let far = simulation.state().velocities[959];
        assert_eq!(far.to_array(), [0.0; 3], "{integrator}: the motion has come all the way");
    }
}

#[test]
fn faint_motions_have_the_bits_of_the_plain_loop() {
    for exponent in (-150..=-20).step_by(10) {
        let material = Material { mass: 1.0, stiffness: 2.0, damping: 1.0 };
        let mut scene = Scene::of("block", shape::block([4; 3], 1.0, material).expect("a lattice"));
        let mut random = Random(7);
        for particle in &mut scene.particles {
            particle.velocity = random.vector() * f64::powi(2.0, exponent);
        }
        check_forces::<f32>(&scene, &[]);
        check_forces::<f64>(&scene, &[]);
    }
}
