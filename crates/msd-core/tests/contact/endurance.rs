//! Sliding, bounces and minutes of rest on slopes in random directions, up to 1e6 m from the
//! origin.
//!
//! The rows of the table of docs/measured/trade.md, beside the tolerance of each:
//! `CONTACT_TABLE=FILE cargo test --release -p msd-core --test contact -- --ignored`.

use crate::table::{G, H, Measures, is_double, run, start};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Friction, Integrator, Material, Particle, Plane, Real, Scene, Settings, Simulation, Vector,
    World, shape,
};

/// A small generator (splitmix64): the scenes are the same on every machine.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A direction, each as likely as any other.
    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.roll(), self.roll(), self.roll()) * 2.0 - DVec3::ONE;
            if (0.1..=1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}

/// A plane in the world, a direction along it, and a place on it.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    pub normal: DVec3,
    down: DVec3,
    pub offset: f64,
    pub place: DVec3,
}

/// Twenty slopes at offsets from 0 to 1e6 m; those where the fall of a substep at rest, g h², is
/// less than 16 roundings of a coordinate in this precision are left out.
pub fn slopes<R: Real>() -> Vec<Slope> {
    let mut dice = Dice(7);
    let slope = |number: usize| {
        let (normal, other) = (dice.direction(), dice.direction());
        let down = (other - normal * other.dot(normal)).normalize();
        let offset = [0.0, 1.0, -20.0, 1e3, 1e6][number % 5];
        let place = normal * offset + down * (dice.roll() * offset) + normal.cross(down);
        Slope { normal, down, offset, place }
    };
    let resolved =
        |slope: &Slope| 16.0 * R::EPSILON.to_f64() * (1.0 + slope.offset.abs()) < G * H * H;
    (0..20).map(slope).filter(resolved).collect()
}

impl Slope {
    fn plane(&self, restitution: f64, factor: f64) -> Plane {
        let friction = Friction::Coulomb(factor);
        Plane { normal: self.normal, offset: self.offset, restitution, friction }
    }

    /// The pull on a slope of so many degrees, by gravity.
    fn world(&self, degrees: f64) -> World {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let gravity = (self.down * sine - self.normal * cosine) * G;
        World { gravity, extent: 1e8, ..World::default() }
    }

    /// The rounding of a coordinate, metres.
    pub fn rounding<R: Real>(&self) -> f64 {
        R::EPSILON.to_f64() * (2.0 + 2.0 * self.offset.abs())
    }

    fn particle(&self, velocity: DVec3) -> Vec<Particle> {
        vec![Particle { position: self.place, velocity, mass: 0.3 }]
    }
}

fn wait<R: Real>(simulation: &mut Simulation<R>, seconds: f64) {
    run(simulation, seconds, |_| {}).expect("a stable run");
}

fn position<R: Real>(simulation: &Simulation<R>) -> DVec3 {
    simulation.position(0).to_f64()
}

/// Measures each case beside its bound.
fn measures<C: std::fmt::Debug>(
    quantity: &'static str,
    cases: impl IntoIterator<Item = C>,
    measure: impl Fn(&C) -> (f64, f64),
) -> Measures {
    let mut measures = Measures::default();
    for case in cases {
        measures.see(quantity, measure(&case), &format!("{case:?}"));
    }
    measures
}

fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.fold(0.0, |worst, error| if error <= worst { worst } else { error })
}

/// At 0.95 of the critical slope nothing moves: by 8 roundings of its place in 20 s.
pub fn a_particle_sticks<R: Real>(integrator: Integrator) -> Measures {
    measures("moved, m", slopes::<R>(), |slope| {
        let degrees = (0.95f64 * 0.5).atan().to_degrees();
        let scene = Scene {
            world: slope.world(degrees),
            particles: slope.particle(DVec3::ZERO),
            planes: vec![slope.plane(0.5, 0.5)],
            ..Scene::default()
        };
        let mut simulation = start::<R>(&scene, integrator);
        let start = position(&simulation);
        wait(&mut simulation, 20.0);
        ((position(&simulation) - start).length(), 8.0 * slope.rounding::<R>())
    })
}

/// With a = g (sin α − μ cos α) the way is V t + a t²/2. Symplectic Euler is ahead of it by a h t /
/// 2 and explicit Euler as late; the others are right to rounding.
pub fn a_particle_slides<R: Real>(integrator: Integrator) -> Measures {
    let starts = [(0.0, 40.0), (1.0, 30.0), (2.0, 20.0)];
    let cases = slopes::<R>().into_iter().flat_map(|slope| starts.map(|start| (slope, start)));
    measures("off its place, m", cases, |&(slope, (speed, degrees))| {
        let factor = 0.3;
        let scene = Scene {
            world: slope.world(degrees),
            particles: slope.particle(slope.down * speed),
            planes: vec![slope.plane(0.5, factor)],
            ..Scene::default()
        };
        let mut simulation = start::<R>(&scene, integrator);
        let (start, time) = (position(&simulation), 1.0);
        wait(&mut simulation, time);
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let a = G * (sine - factor * cosine);
        let way = slope.down * (speed * time + 0.5 * a * time * time);
        let error = (position(&simulation) - start - way).length();
        let late = if integrator.order() == 1 { a * H * time } else { 0.0 };
        // Rounding of a position in each substep, and of a speed at the start for all.
        let steps = time / H;
        (error, late + slope.rounding::<R>() * steps)
    })
}

/// The heights of the apexes of a particle let go at 1 m, as the highest of all substeps between
/// two impacts.
fn apexes<R: Real>(slope: &Slope, integrator: Integrator, e: f64, seconds: f64) -> Vec<f64> {
    let mut particles = slope.particle(DVec3::ZERO);
    particles[0].position += slope.normal;
    let scene = Scene {
        world: slope.world(0.0),
        particles,
        planes: vec![slope.plane(e, 0.5)],
        ..Scene::default()
    };
    let settings = Settings { integrator, step: H, substeps: 1, ..Settings::default() };
    let mut simulation = Simulation::<R>::new(&scene, settings).expect("a scene");
    let (mut apexes, mut highest, mut was_falling) = (Vec::new(), 0.0f64, true);
    for _ in 0..(seconds / H) as usize {
        simulation.step().expect("a stable run");
        let falling = simulation.velocity(0).to_f64().dot(slope.normal) < 0.0;
        let height = position(&simulation).dot(slope.normal) - slope.offset;
        if falling && !was_falling {
            apexes.push(highest.max(height));
        }
        highest = if falling { 0.0 } else { highest.max(height) };
        was_falling = falling;
    }
    apexes
}

/// The highest of the substeps is below the apex by at most g h² / 8, and as much again for the
/// half substep by which velocities of the Euler methods are off. This bound falls with h², and
/// does not grow with the number of bounces.
pub fn apexes_last<R: Real>(integrator: Integrator) -> Measures {
    let near = slopes::<R>().into_iter().filter(|slope| slope.offset.abs() < 2.0);
    measures("off its apex, m", near, |slope| {
        let apexes = apexes::<R>(slope, integrator, 1.0, 60.0);
        assert!(50 < apexes.len(), "{integrator}: {} bounces", apexes.len());
        let error = worst(apexes.iter().map(|apex| (apex - 1.0).abs()));
        // Rounding of position and speed in each substep, as random as the places.
        let rounding = slope.rounding::<R>() * 8.0 * (60.0 / H).sqrt() * 4.0;
        (error, G * H * H + rounding)
    })
}

/// Apex k is at e^(2 k).
pub fn apexes_shrink<R: Real>(integrator: Integrator) -> Measures {
    let near = slopes::<R>().into_iter().filter(|slope| slope.offset.abs() < 2.0);
    measures("off its apex, m", near, |slope| {
        let e = 0.7f64;
        let apexes = apexes::<R>(slope, integrator, e, 2.0);
        let exact = (1..=3).map(|bounce| e.powi(2 * bounce));
        let error = worst(apexes.iter().zip(exact).map(|(apex, exact)| (apex - exact).abs()));
        let rounding = slope.rounding::<R>() * 8.0 * (2.0 / H).sqrt() * 4.0;
        (error, 2.0 * G * H * H + rounding)
    })
}

/// Thrown into a corner of three planes a particle loses its speed and stays.
pub fn a_corner_holds<R: Real>(integrator: Integrator) -> Measures {
    measures("inside and moved, m", slopes::<R>(), |slope| {
        let frame = [slope.normal, slope.down, slope.normal.cross(slope.down)];
        let diagonal = (frame[0] + frame[1] + frame[2]).normalize();
        let corner = slope.place;
        let planes = frame.map(|normal| Plane {
            normal: (normal + diagonal * 0.2).normalize(),
            offset: (normal + diagonal * 0.2).normalize().dot(corner),
            restitution: 0.3,
            friction: Friction::Coulomb(0.4),
        });
        let mut particles = slope.particle(-diagonal * 2.0);
        particles[0].position += frame[0] * 0.3 + frame[1] * 0.2 + frame[2] * 0.4;
        let world = World { gravity: -diagonal * G, extent: 1e8, ..World::default() };
        let scene = Scene { world, particles, planes: planes.to_vec(), ..Scene::default() };
        let mut simulation = start::<R>(&scene, integrator);
        wait(&mut simulation, 10.0);
        let before = position(&simulation);
        wait(&mut simulation, 20.0);
        let after = position(&simulation);
        let inside = planes.map(|plane| plane.offset - plane.normal.dot(after));
        // A gap counts as zero within four roundings of each of its terms, and a corner of three
        // planes is as good as their gaps.
        // Explicit Euler falls by g h² in every other substep, to each plane in its own time.
        let falls = if integrator == Integrator::ExplicitEuler { G * H * H } else { 0.0 };
        let allowed = 16.0 * slope.rounding::<R>() + falls;
        (worst(inside.into_iter().chain([(after - before).length()])), allowed)
    })
}

/// Damped so that a body settles, and soft enough for the explicit methods at the default substep.
pub const SOFT: Material = Material { mass: 0.1, stiffness: 1000.0, damping: 2.5 };

/// A body that stands on a slope of so many degrees and some friction, at its place.
pub fn standing(
    slope: &Slope,
    size: [usize; 3],
    material: Material,
    (degrees, friction): (f64, f64),
) -> Scene {
    let mut part = shape::block(size, 0.5, material).expect("a block");
    let low = part.particles.iter().map(|p| p.position.y).fold(f64::MAX, f64::min);
    let frame = DMat3::from_cols(slope.down, slope.normal, slope.down.cross(slope.normal));
    part.place(DMat3::IDENTITY, DVec3::Y * -low);
    part.place(frame, slope.place);
    let mut scene = Scene::of("block", part);
    scene.world = slope.world(degrees);
    scene.planes = vec![slope.plane(0.5, friction)];
    scene
}

/// The motion of a body once it has settled, beside 1e-5 of its size.
fn drift<R: Real>(mut simulation: Simulation<R>, (settle, seconds): (f64, f64)) -> (f64, f64) {
    wait(&mut simulation, settle);
    let before = simulation.state();
    wait(&mut simulation, seconds);
    let after = simulation.state();
    let pairs = before.positions.iter().zip(&after.positions);
    let moved = worst(pairs.map(|(a, b)| (b.to_f64() - a.to_f64()).length()));
    let place = before.positions[0].to_f64().abs().max_element();
    (moved, 1e-5 * simulation.model().size() + 8.0 * R::EPSILON.to_f64() * place)
}

pub fn a_block_rests<R: Real>(integrator: Integrator) -> Measures {
    let slopes = slopes::<R>();
    measures("moved, m", [(0, 24.0), (1, 0.0)], |&(number, degrees)| {
        let scene = standing(&slopes[number], [3, 3, 3], SOFT, (degrees, 0.5));
        drift(start::<R>(&scene, integrator), (20.0, 600.0))
    })
}

/// The fewest substeps of a step of 1/60 s that are at most 0.9 of the stable one; 8 where there is
/// no limit.
fn fewest_substeps<R: Real>(scene: &Scene, integrator: Integrator) -> u32 {
    let simulation = start::<R>(scene, integrator);
    let stable = |count: u32| simulation.stable_substep_of(integrator, count);
    let is_stable = |&count: &u32| 1.0 / 60.0 / f64::from(count) <= 0.9 * stable(count);
    if stable(1).is_infinite() { 8 } else { (1..).find(is_stable).expect("a stable substep") }
}

/// Neither a long substep nor a strong damper changes the slopes on which friction holds.
pub fn blocks_hold<R: Real>(integrator: Integrator) -> Measures {
    let slope = &slopes::<R>()[1];
    let materials = [(1e3, 2.5), (1e4, 2.5), (1e5, 30.0)];
    // In single precision the rounding of stiff springs is worth more than a hundredth.
    let most = if is_double::<R>() { 0.99 } else { 0.9 };
    let cases = materials.into_iter().flat_map(|material| [0.5, most].map(|part| (material, part)));
    measures("moved, m", cases, |&((stiffness, damping), part)| {
        let degrees = (0.5f64 * part).atan().to_degrees();
        let material = Material { mass: 0.1, stiffness, damping };
        let scene = standing(slope, [3, 3, 3], material, (degrees, 0.5));
        let substeps = fewest_substeps::<R>(&scene, integrator);
        let settings = Settings { integrator, substeps, ..Settings::default() };
        drift(Simulation::<R>::new(&scene, settings).expect("a scene"), (20.0, 60.0))
    })
}

pub fn a_column_stands<R: Real>(integrator: Integrator) -> Measures {
    measures("moved, m", [&slopes::<R>()[1]], |slope| {
        let scene = standing(slope, [6, 3, 3], SOFT, (4.0, 0.5));
        drift(start::<R>(&scene, integrator), (80.0, 120.0))
    })
}

/// Without gravity, a uniform force presses a particle to a wall that would give back half.
pub fn a_force_presses<R: Real>(integrator: Integrator) -> Measures {
    measures("moved, m", slopes::<R>(), |slope| {
        let scene = Scene {
            world: World {
                gravity: DVec3::ZERO,
                force: (slope.down * 0.4 - slope.normal) * 3.0,
                extent: 1e8,
                ..World::default()
            },
            particles: slope.particle(DVec3::ZERO),
            planes: vec![slope.plane(0.5, 0.5)],
            ..Scene::default()
        };
        let mut simulation = start::<R>(&scene, integrator);
        let start = position(&simulation);
        wait(&mut simulation, 20.0);
        ((position(&simulation) - start).length(), 8.0 * slope.rounding::<R>())
    })
}
