//! Small scenes and runs of them, shared by the tests.
#![allow(dead_code)] // each test binary uses its own part of this file

use msd_core::glam::DVec3;
use msd_core::{
    DistanceGrid, Integrator, Material, Model, Particle, Real, Scene, Settings, Simulation, Spring,
    State, Vector, World, shape,
};

/// A world without gravity.
pub fn weightless() -> World {
    World { gravity: DVec3::ZERO, ..World::default() }
}

/// A simulation whose step is a single substep of `h`.
pub fn simulation<R: Real>(scene: &Scene, integrator: Integrator, h: f64) -> Simulation<R> {
    Simulation::new(scene, Settings { integrator, step: h, substeps: 1, ..Settings::default() })
        .expect("a valid scene")
}

/// Runs `steps` steps of `h` and returns the final state in double precision.
pub fn run(scene: &Scene, integrator: Integrator, h: f64, steps: usize) -> State<f64> {
    let mut simulation = simulation::<f64>(scene, integrator, h);
    for _ in 0..steps {
        simulation.step().expect("a stable run");
    }
    simulation.state()
}

/// The largest distance between particles of two states, metres.
pub fn distance(a: &State<f64>, b: &State<f64>) -> f64 {
    let pairs = a.positions.iter().zip(&b.positions);
    pairs.map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
}

/// A 3x3x3 block in free flight that turns and is sheared: every term of a spring contributes.
pub fn tumbling_block(damping: f64) -> Scene {
    let material = Material { mass: 1.0, stiffness: 100.0, damping };
    let mut part = shape::block([3, 3, 3], 1.0, material).unwrap();
    part.set_motion(DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.3, 1.0, -0.4));
    for particle in &mut part.particles {
        let DVec3 { x, y, z } = particle.position;
        particle.position += DVec3::new(0.10 * y, 0.05 * z, -0.08 * x * x);
    }
    Scene { world: weightless(), ..Scene::of("block", part) }
}

/// Two particles on the x axis, `stretch` metres longer than their spring of rest length 1.
pub fn two_masses(masses: [f64; 2], stiffness: f64, damping: f64, stretch: f64) -> Scene {
    let particle = |x: f64, mass: f64| Particle {
        position: DVec3::new(x, 0.0, 0.0),
        velocity: DVec3::ZERO,
        mass,
    };
    Scene {
        world: weightless(),
        particles: vec![particle(0.0, masses[0]), particle(1.0 + stretch, masses[1])],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness, damping }],
        ..Scene::default()
    }
}

/// All forces at a state, newtons, by the plain loops: gravity, the uniform force, grabs, drag, and
/// springs in their order.
pub fn forces_at<R: Real>(model: &Model<R>, state: &State<R>) -> Vec<R::Vec3> {
    let weight = |&mass: &R| model.gravity() * mass + model.force();
    let mut forces: Vec<R::Vec3> = model.masses().iter().map(weight).collect();
    for grab in model.grabs() {
        let held = grab.particle as usize;
        let pull = (grab.target - state.positions[held]) * grab.stiffness;
        let pull = pull - state.velocities[held] * grab.damping;
        let strength = pull.dot(pull).sqrt();
        let capped = grab.max_force < strength;
        forces[held] += pull * if capped { grab.max_force / strength } else { R::ONE };
    }
    for (force, &velocity) in forces.iter_mut().zip(&state.velocities) {
        *force -= velocity * model.drag();
    }
    for (spring, ends) in model.ends().iter().enumerate() {
        let [a, b] = ends.map(|end| end as usize);
        let across = state.positions[b] - state.positions[a];
        let squared = across.dot(across);
        if squared < R::SHORTEST_SQUARED {
            continue;
        }
        let length = squared.sqrt();
        let per_length = R::ONE / length;
        let rate = across.dot(state.velocities[b] - state.velocities[a]) * per_length;
        let tension = model.stiffness(spring) * (length - model.rest_lengths()[spring]);
        let pull = across * ((tension + model.damping(spring) * rate) * per_length);
        forces[a] += pull;
        forces[b] -= pull;
    }
    forces
}

/// The distances of a ball of this radius on a grid, by its formula.
pub fn grid_of_ball(radius: f64, cell: f64) -> DistanceGrid {
    let side = (2.0 * radius / cell).ceil() as usize + 5;
    let low = DVec3::splat(-0.5 * cell * (side - 1) as f64);
    let mut distances = Vec::new();
    for z in 0..side {
        for y in 0..side {
            for x in 0..side {
                let point = low + cell * DVec3::new(x as f64, y as f64, z as f64);
                distances.push(point.length() - radius);
            }
        }
    }
    let (counts, corners, triangles) = ([side; 3], Vec::new(), Vec::new());
    DistanceGrid { low, cell, counts, distances, reach: radius, error: cell, corners, triangles }
}

/// A linear congruential generator (Knuth, 1997, section 3.3.4): a scene from one number, so that a
/// failure shrinks to a small one.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }
    /// A number from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.next() as f64 / (1u64 << 31) as f64
    }
    pub fn below(&mut self, bound: usize) -> usize {
        self.next() as usize % bound
    }
    /// A point in the unit cube.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }
    pub fn yes(&mut self) -> bool {
        self.below(2) == 0
    }
}

/// A scene of random particles and springs, some columns uniform and some not.
pub fn random_scene(seed: u64) -> Scene {
    let mut random = Random(seed);
    let count = 2 + random.below(40);
    let (same_stiffness, undamped) = (random.unit() < 0.5, random.unit() < 0.3);
    let particles = (0..count).map(|_| Particle {
        position: (random.vector() - 0.5) * 10.0,
        velocity: random.vector() - 0.5,
        mass: 0.1 + random.unit(),
    });
    let particles: Vec<Particle> = particles.collect();
    let springs = (0..3 * count).map(|_| {
        let a = random.below(count);
        let b = (a + 1 + random.below(count - 1)) % count;
        Spring {
            ends: [a, b],
            rest_length: random.unit() * 5.0,
            stiffness: if same_stiffness { 50.0 } else { random.unit() * 100.0 },
            damping: if undamped { 0.0 } else { random.unit() },
        }
    });
    Scene { springs: springs.collect(), particles, ..Scene::default() }
}

/// The positions of a simulation in double precision.
pub fn positions<R: Real>(simulation: &Simulation<R>) -> Vec<DVec3> {
    simulation.positions().map(|position| position.to_f64()).collect()
}

/// The bytes of vectors, for which 0 and −0 differ and a NaN equals itself.
pub fn bits<R: Real>(vectors: &[R::Vec3]) -> Vec<Vec<u8>> {
    let number = |x: R| x.to_le_bytes().into_iter();
    vectors.iter().map(|v| v.components().into_iter().flat_map(number).collect()).collect()
}

/// The bytes of positions and of velocities.
pub fn state_bits<R: Real>(state: &State<R>) -> [Vec<Vec<u8>>; 2] {
    [bits::<R>(&state.positions), bits::<R>(&state.velocities)]
}

/// Asserts that a run goes on in the same bits after it was saved, and that it is the same after a
/// conversion to double precision and back.
pub fn check_resumed(mut run: Simulation<f32>, what: &str) {
    let (rows, progress) = run.progress();
    let mut resumed = Simulation::<f32>::resume(&rows, &progress).expect("a saved run");
    for run in [&mut run, &mut resumed] {
        (0..20).for_each(|_| run.step().expect("a stable step"));
    }
    assert_eq!(state_bits(&run.state()), state_bits(&resumed.state()), "{what}");
    let there_and_back = run.convert::<f64>().expect("it fits").convert::<f32>().expect("fits");
    assert_eq!(there_and_back.forces(), run.forces());
}
