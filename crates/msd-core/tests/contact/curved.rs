//! Slides off round solids with friction: the place reached, and how it converges.

use crate::common::{grid_of_ball, weightless};
use crate::table::{G, Measures, after, is_double, run};
use crate::thick::points;
use crate::walls::{particle, unmoved};
use msd_core::glam::DVec3;
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Neighbours, Particle, Pin, Real, Scene, Settings, Shape,
    Simulation, Solid, Spring, Vector, shape,
};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

const RADIUS: f64 = 1.3;
const SECONDS: f64 = 0.4;

/// The angle from the top after a time, from rest at `angle`: θ'' = (g / R) (sin θ − μ cos θ) + μ
/// θ'² by the classical Runge-Kutta method in steps of 10 µs, whose error is far below 1e-12.
fn reference(friction: f64, angle: f64) -> [f64; 2] {
    let steps = 40_000;
    let h = SECONDS / f64::from(steps);
    let rate = |[angle, speed]: [f64; 2]| {
        let (sine, cosine) = angle.sin_cos();
        let pull = G / RADIUS * (sine - friction * cosine);
        [speed, pull + friction * speed * speed]
    };
    let at = |x: [f64; 2], k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
    (0..steps).fold([angle, 0.0], |x, _| {
        let k1 = rate(x);
        let k2 = rate(at(x, k1, 0.5 * h));
        let k3 = rate(at(x, k2, 0.5 * h));
        let k4 = rate(at(x, k3, h));
        let mean = |i: usize| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
        at(x, [mean(0), mean(1)], h)
    })
}

/// A ball, a cylinder and a capsule along z.
fn round(friction: f64) -> Vec<(Solid, &'static str)> {
    let axes = rotation(DVec3::X, FRAC_PI_2);
    let shapes = [
        (Shape::Sphere { radius: RADIUS }, "ball"),
        (Shape::Cylinder { radius: RADIUS, length: 3.0 }, "cylinder"),
        (Shape::Capsule { radius: RADIUS, length: 3.0 }, "capsule"),
    ];
    let friction = Friction::Coulomb(friction);
    let solids = shapes.map(|(shape, name)| {
        let solid = Solid { axes, friction, ..Solid::new(shape) };
        (solid, name)
    });
    solids.into()
}

/// It leaves a smooth solid where cos θ is two thirds of that at the start, 0.91 rad; the runs end
/// before. Sixteen times as many substeps leave a sixteenth of the error.
pub fn particles_slide_off<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for friction in [0.0, 0.15, 0.3] {
        let angle = 0.4f64;
        let [end, rate] = reference(friction, angle);
        assert!(end < 0.87 && rate * rate * RADIUS < 0.9 * G * end.cos(), "{friction}: {end}");
        let place = |angle: f64| DVec3::new(angle.sin(), angle.cos(), 0.0) * RADIUS;
        for (solid, kind) in round(friction) {
            for substeps in [8, 128] {
                let name = format!("{kind}, friction {friction}, {substeps} substeps");
                let mut scene = particle(place(angle), DVec3::ZERO);
                scene.solids = vec![solid.clone()];
                let settings = Settings { integrator, substeps, ..Settings::default() };
                let start = Simulation::<R>::new(&scene, settings);
                let mut simulation = start.expect("a valid scene");
                let ended = run(&mut simulation, SECONDS, |_| {});
                ended.unwrap_or_else(|error| measures.fail(&error, &name));
                let h = settings.substep();
                // Half a substep of the final speed for a method of first order, and as much for a
                // surface that is met at the ends of substeps. Dormand-Prince follows the surface
                // within its tolerance, 1e-6 of the size of the scene, in each of the tens of its
                // steps.
                let late = match integrator {
                    Integrator::DormandPrince => 30.0 * 1e-6 * RADIUS,
                    _ => rate * RADIUS * h,
                };
                // A rounding of a place in each substep.
                let rounding = SECONDS / h * R::EPSILON.to_f64() * RADIUS;
                let off = simulation.position(0).to_f64().distance(place(end));
                measures.see("off its place, m", (off, late + rounding), &name);
            }
        }
    }
    measures
}

/// A patch of cloth and a soft block, let go on the shoulder of a ball.
fn bodies() -> [(Scene, &'static str); 2] {
    let turn = |axis, degrees: f64| rotation(axis, degrees.to_radians());
    let material = |stiffness, damping| Material { mass: 0.01, stiffness, damping };
    let mut cloth = shape::cloth([5, 5], 0.06, material(60.0, 0.05)).expect("a cloth");
    cloth.place(turn(DVec3::X, 90.0), DVec3::new(0.45, 1.24, 0.0));
    let mut block = shape::block([3, 3, 3], 0.06, material(100.0, 0.1)).expect("a block");
    block.place(turn(DVec3::Z, -20.0), DVec3::new(0.45, 1.3, 0.0));
    let friction = Friction::Coulomb(0.15);
    [("cloth", cloth), ("block", block)].map(|(name, part)| {
        let solid = Solid { friction, ..Solid::new(Shape::Sphere { radius: RADIUS }) };
        (Scene { solids: vec![solid], ..Scene::of(name, part) }, name)
    })
}

fn centre_after(scene: &Scene, settings: Settings) -> Result<DVec3, msd_core::Error> {
    let mut simulation = Simulation::<f64>::new(scene, settings)?;
    run(&mut simulation, 0.6, |_| {})?;
    Ok(simulation.centre_of_mass(0..scene.particles.len()))
}

/// The answer of every method tends to that of Dormand-Prince with more substeps: sixteen times as
/// many leave an eighth of the error, or less than a millimetre of the half metre of way.
pub fn bodies_slide_off<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    // Rounding adds nothing to a comparison of millimetres: in double precision only.
    if !is_double::<R>() || integrator == Integrator::DormandPrince {
        return measures;
    }
    for (scene, name) in bodies() {
        let exact = Settings {
            integrator: Integrator::DormandPrince,
            tolerance: 1e-8,
            ..Settings::default()
        };
        let after = |substeps| {
            let settings = Settings { integrator, substeps, ..Settings::default() };
            centre_after(&scene, settings)
        };
        let ends = centre_after(&scene, exact)
            .and_then(|exact| Ok([exact, after(16)?, after(256)?]))
            .map_err(|error| measures.fail(&error, name));
        if let Ok([exact, coarse, fine]) = ends {
            let [coarse, fine] = [coarse, fine].map(|end| end.distance(exact));
            let case = format!("{name}: {coarse:.2e} m at 16 substeps");
            measures.see("off its place at 256, m", (fine, (coarse / 8.0).max(1e-3)), &case);
        }
    }
    measures
}

/// A rope over a drum of 20 cm, a metre on either side, with 1 kg and 3 kg at its ends.
struct Rope {
    count: usize,
    masses: [f64; 2],
    friction: f64,
}

const DRUM: f64 = 0.2;
const HANGS: f64 = 1.0;
/// Of a particle of the rope, kg.
const BEAD: f64 = 1e-3;

impl Rope {
    fn scene(&self) -> Scene {
        let arc = PI * DRUM;
        let spacing = (arc + 2.0 * HANGS) / (self.count - 1) as f64;
        let place = |number: usize| {
            let along = number as f64 * spacing;
            let angle = (along - HANGS) / DRUM;
            match angle {
                ..0.0 => DVec3::new(-DRUM, along - HANGS, 0.0),
                0.0..=PI => DVec3::new(-angle.cos(), angle.sin(), 0.0) * DRUM,
                _ => DVec3::new(DRUM, HANGS + arc - along, 0.0),
            }
        };
        let mass = |number| match number {
            0 => self.masses[0],
            last if last == self.count - 1 => self.masses[1],
            _ => BEAD,
        };
        let particle = |number| Particle {
            position: place(number),
            velocity: DVec3::ZERO,
            mass: mass(number),
        };
        let spring = |number: usize| {
            let rest_length = place(number).distance(place(number + 1));
            Spring { ends: [number, number + 1], rest_length, stiffness: 1e6, damping: 20.0 }
        };
        let drum = Solid::new(Shape::Cylinder { radius: DRUM, length: 1.0 });
        let axes = rotation(DVec3::X, FRAC_PI_2);
        Scene {
            particles: (0..self.count).map(particle).collect(),
            springs: (0..self.count - 1).map(spring).collect(),
            solids: vec![Solid { axes, friction: Friction::Coulomb(self.friction), ..drum }],
            ..Scene::default()
        }
    }

    /// The acceleration of a rope that slips, by Euler and Eytelwein with the mass of the rope:
    /// along the arc dT/dφ = μ (T + λ R g sin φ) + λ R (g cos φ + a), from (m + λ L) (g + a) on the
    /// light side to (m + λ L) (g − a) on the heavy one. Both sides are linear in a.
    fn acceleration(&self) -> f64 {
        let density = BEAD * (self.count - 2) as f64 / (PI * DRUM + 2.0 * HANGS);
        let off = |a: f64| {
            let steps = 10_000;
            let width = PI / f64::from(steps);
            let light = (self.masses[0] + density * HANGS) * (G + a);
            let tension = (0..steps).fold(light, |tension, step| {
                let (sine, cosine) = ((f64::from(step) + 0.5) * width).sin_cos();
                let pressed = tension + density * DRUM * G * sine;
                tension + width * (self.friction * pressed + density * DRUM * (G * cosine + a))
            });
            tension - (self.masses[1] + density * HANGS) * (G - a)
        };
        off(0.0) / (off(0.0) - off(1.0))
    }
}

/// The heavy end goes down. The springs span 6° of the drum. Their pressure is off by the square of
/// that, 1 %, as is the friction of the implicit methods, of the 2.6 times the weight that it
/// holds. That is a tenth of the acceleration of 0.6 m/s², and as much again for measuring over a
/// third of a second.
///
/// 1 MN/m on 1 g is for backward Euler alone: explicit methods need substeps of 30 µs, and implicit
/// midpoint keeps the vibrations of a rope that is loaded at once.
pub fn ropes_slip<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    // Rounding matters to nothing here: in double precision only.
    if !is_double::<R>() || integrator != Integrator::BackwardEuler {
        return measures;
    }
    let rope = Rope { count: 121, masses: [1.0, 3.0], friction: 0.3 };
    let exact = rope.acceleration();
    for substeps in [8, 32, 100] {
        let name = format!("1 and 3 kg, {substeps} substeps");
        let settings = Settings { integrator, substeps, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&rope.scene(), settings).expect("a scene");
        let mut heights = Vec::new();
        let ended = run(&mut simulation, 0.4, |now| heights.push(now.position(0).y));
        if let Err(error) = ended {
            measures.fail(&error, &name);
            continue;
        }
        let [first, second, third] = [6, 15, 24].map(|step| heights[step - 1]);
        let found = (third - 2.0 * second + first) / 0.15f64.powi(2);
        measures.see("off its acceleration, m/s²", ((found - exact).abs(), 0.2 * exact), &name);
    }
    measures
}

/// A smooth ball is left where the pressure ends, at two thirds of its height (v² = 2 g r (1 − cos)
/// and v² = g r cos): by a point, and by a particle of 5 cm at the sum of the radii.
pub fn leave_smooth_balls<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for (radius, shells, name) in [(1.0, Vec::new(), "point"), (0.95, points(vec![0]), "5 cm")] {
        let (sine, cosine) = 0.05f64.sin_cos();
        let start = particle(DVec3::new(sine, cosine, 0.0), DVec3::ZERO);
        let solids = vec![Solid::new(Shape::Sphere { radius })];
        let scene = Scene { shells, solids, ..start };
        let settings = Settings { integrator, step: 1e-3, substeps: 10, ..Settings::default() };
        let mut simulation = Simulation::<R>::new(&scene, settings).expect("a valid scene");
        let (mut height, mut deepest, mut has_left) = (1.0, 0f64, false);
        let threshold = 1e-6f64.max(128.0 * R::EPSILON.to_f64());
        let ended = run(&mut simulation, 1.4, |now| {
            let place = now.position(0).to_f64();
            has_left |= 1.0 + threshold <= place.length();
            if !has_left {
                (height, deepest) = (place.y, deepest.max(1.0 - place.length()));
            }
        });
        ended.unwrap_or_else(|error| measures.fail(&error, name));
        measures.see("inside, m", (deepest, threshold), name);
        // The gap grows with 3 g t³/6 or so: a micrometre takes 6 ms, in which it falls by 14 mm.
        // Implicit midpoint lets go half a per cent early.
        let late = cosine * 2.0 / 3.0 - height;
        measures.see("leaves late, m", (late, 16e-3 * (threshold / 1e-6).cbrt()), name);
        measures.see("leaves early, m", (-late, 5e-3), name);
    }
    measures
}

/// A ball made of distances, beside the ball itself. The normal of a facet is off by half a cell
/// over the radius, which turns the path as much. Over 0.7 s the error grows by sinh(t √(g / r)) =
/// 4.4, but for its share.
pub fn slide_on_grids<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let start = DVec3::new(0.18, 0.98, 0.1).normalize() * 1.001;
    let mut slide = |shape: Shape, name: &str| {
        let scene = Scene { solids: vec![Solid::new(shape)], ..particle(start, DVec3::ZERO) };
        let settings = Settings { integrator, step: 2e-3, substeps: 10, ..Settings::default() };
        let mut simulation = Simulation::<R>::new(&scene, settings).expect("a valid scene");
        let ended = run(&mut simulation, 0.7, |_| {});
        ended.unwrap_or_else(|error| measures.fail(&error, name));
        simulation.position(0).to_f64()
    };
    let cells = [1.0 / 16.0, 1.0 / 64.0];
    let right = slide(Shape::Sphere { radius: 1.0 }, "ball");
    let grids = cells.map(|cell| slide(Shape::Mesh(Arc::new(grid_of_ball(1.0, cell))), "grid"));
    for (cell, place) in cells.into_iter().zip(grids) {
        let name = format!("cells of {cell} m");
        measures.see("off its place, m", (place.distance(right), 2.2 * cell), &name);
    }
    measures
}

/// A rope that is drawn over a capsule at rest: the pulls at its two ends are as exp(μ angle)
/// (Euler and Eytelwein). It turns by π/32 at each particle, which is nearer than 0.1 % to a curve.
pub fn ropes_are_drawn<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "capsule");
    // The stretch of a spring of 0.4 mm is some hundred roundings in single precision.
    if !is_double::<R>() {
        return measures;
    }
    let (radius, friction, speed) = (0.5, 0.3, 0.1);
    let (corners, straight) = (32, 8);
    let turn = PI / f64::from(corners);
    let spacing = 2.0 * radius * (turn / 2.0).sin();
    let hangs = |x: f64, row: i32| DVec3::new(x * radius, -spacing * f64::from(row), 0.0);
    let mut path: Vec<_> = (1..=straight).rev().map(|row| (hangs(-1.0, row), DVec3::Y)).collect();
    path.extend((0..=corners).map(|corner| {
        let (sine, cosine) = (PI - turn * f64::from(corner)).sin_cos();
        (DVec3::new(cosine, sine, 0.0) * radius, DVec3::new(sine, -cosine, 0.0))
    }));
    path.extend((1..=straight).map(|row| (hangs(1.0, row), -DVec3::Y)));
    let particle = |&(position, along): &(DVec3, DVec3)| Particle {
        position,
        velocity: along * speed,
        mass: 1e-3,
    };
    let (stiffness, pull) = (5e4, 20.0);
    let rest_length = spacing - pull / stiffness;
    let last = path.len() - 1;
    let spring = |a| Spring { ends: [a, a + 1], rest_length, stiffness, damping: 5.0 };
    let capsule = Solid::new(Shape::Capsule { radius, length: 1.0 });
    let (axes, friction_law) = (rotation(DVec3::X, FRAC_PI_2), Friction::Coulomb(friction));
    let scene = Scene {
        world: weightless(),
        particles: path.iter().map(particle).collect(),
        springs: (0..last).map(spring).collect(),
        pins: [0, last].map(|row| Pin { particle: row, velocity: path[row].1 * speed }).into(),
        solids: vec![Solid { axes, friction: friction_law, ..capsule }],
        ..Scene::default()
    };
    let settings = Settings { integrator, step: 1e-3, substeps: 50, ..Settings::default() };
    let mut simulation = Simulation::<R>::new(&scene, settings).expect("a valid scene");
    let (mut before, mut behind) = (0.0, 0.0);
    // Once it slips all along, for as long as one particle takes to the place of the next.
    let ended = run(&mut simulation, 0.2, |_| {}).and_then(|()| {
        run(&mut simulation, spacing / speed, |now| {
            let place = |row| now.position(row).to_f64();
            before += place(1).distance(place(0)) - rest_length;
            behind += place(last).distance(place(last - 1)) - rest_length;
        })
    });
    ended.unwrap_or_else(|error| measures.fail(&error, name));
    let ratio = behind / before / (friction * PI).exp();
    measures.see("off the ratio of its pulls", ((ratio - 1.0).abs(), 0.02), name);
    measures
}

/// A ball at 10 m/s takes along the cloth that it meets: no particle of it is left inside the ball
/// or behind it.
pub fn cloths_are_taken_along<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "ball at 10 m/s");
    let material = Material { mass: 1e-3, stiffness: 200.0, damping: 0.02 };
    let cloth = shape::lattice([21, 21, 1], Neighbours::All, 0.05, material).expect("a cloth");
    let mut scene = Scene { world: weightless(), ..Scene::of("cloth", cloth) };
    let (position, velocity) = (DVec3::new(0.013, 0.007, -0.3), DVec3::Z * 10.0);
    let ball = Solid::new(Shape::Sphere { radius: 0.2 });
    scene.solids.push(Solid { position, velocity, ..ball });
    let simulation = after::<R>(&scene, (integrator, 32), 6, (&mut measures, name));
    let middle = position + velocity * 0.1;
    for (row, particle) in scene.particles.iter().enumerate() {
        let off = particle.position - position;
        let now = simulation.position(row).to_f64() - middle;
        // Contact ends a substep on the surface; a rounding of it is left.
        measures.see("inside, m", (0.2 - now.length(), 1e-9f64.max(unmoved::<R>(1.0))), name);
        if off.x.hypot(off.y) < 0.15 {
            measures.see("behind, m", (-now.z, unmoved::<R>(1.0)), name);
        }
    }
    measures
}

#[test]
fn the_reference_has_the_energy_of_a_smooth_slide() {
    let [end, rate] = reference(0.0, 0.4);
    let fallen = RADIUS * (0.4f64.cos() - end.cos());
    assert!((0.5 * (rate * RADIUS).powi(2) - G * fallen).abs() < 1e-12);
}

#[test]
fn the_reference_loses_what_friction_takes() {
    // With u = R θ'² / g: du/dθ = 2 (sin θ − μ (cos θ − u)), solved by A e^(2 μ θ) + B cos θ + C
    // sin θ.
    let (mu, start) = (0.3f64, 0.4f64);
    let d = 1.0 + 4.0 * mu * mu;
    let (b, c) = ((4.0 * mu * mu - 2.0) / d, -6.0 * mu / d);
    let a = -(b * start.cos() + c * start.sin()) * (-2.0 * mu * start).exp();
    let [end, rate] = reference(mu, start);
    let u = a * (2.0 * mu * end).exp() + b * end.cos() + c * end.sin();
    assert!((RADIUS * rate * rate / G - u).abs() < 1e-9, "{u}");
}

#[test]
fn a_rope_without_mass_slips_as_euler_and_eytelwein_say() {
    let rope = Rope { count: 2, masses: [1.0, 3.0], friction: 0.3 };
    let ratio = (0.3 * PI).exp();
    let exact = G * (3.0 - ratio) / (3.0 + ratio);
    // The sum over the arc has steps of 3e-4.
    assert!((rope.acceleration() - exact).abs() < 2e-3, "{}", rope.acceleration());
}
