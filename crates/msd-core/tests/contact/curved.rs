//! What slides off round solids with friction: the place it reaches, and how that converges.

use crate::table::{G, Measures, is_double, run};
use crate::walls::particle;
use msd_core::glam::DVec3;
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Real, Scene, Settings, Shape, Simulation, Solid, Vector, shape,
};
use std::f64::consts::FRAC_PI_2;

const RADIUS: f64 = 1.3;
const SECONDS: f64 = 0.4;

/// The angle from the top after a time, from rest at `angle`: θ'' = (g / R) (sin θ − μ cos θ) + μ θ'²
/// by the classical Runge-Kutta method in steps of 10 µs, whose error is far below 1e-12.
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
                // surface that is met at the ends of substeps. Dormand-Prince follows the surface within
                // its tolerance, 1e-6 of the size of the scene, in each of the tens of its steps.
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

/// The answer of every method tends to that of Dormand-Prince as substeps grow: sixteen times as many
/// leave an eighth of the error, or less than a millimetre of the half metre of way.
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

#[test]
fn the_reference_has_the_energy_of_a_smooth_slide() {
    let [end, rate] = reference(0.0, 0.4);
    let fallen = RADIUS * (0.4f64.cos() - end.cos());
    assert!((0.5 * (rate * RADIUS).powi(2) - G * fallen).abs() < 1e-12);
}

#[test]
fn the_reference_loses_what_friction_takes() {
    // With u = R θ'² / g: du/dθ = 2 (sin θ − μ (cos θ − u)), solved by A e^(2 μ θ) + B cos θ + C sin θ.
    let (mu, start) = (0.3f64, 0.4f64);
    let d = 1.0 + 4.0 * mu * mu;
    let (b, c) = ((4.0 * mu * mu - 2.0) / d, -6.0 * mu / d);
    let a = -(b * start.cos() + c * start.sin()) * (-2.0 * mu * start).exp();
    let [end, rate] = reference(mu, start);
    let u = a * (2.0 * mu * end).exp() + b * end.cos() + c * end.sin();
    assert!((RADIUS * rate * rate / G - u).abs() < 1e-9, "{u}");
}
