//! Runs compared with solutions in closed form.

use crate::common::{simulation, two_masses, weightless};
use msd_core::glam::DVec3;
use msd_core::{
    Friction, Integrator, Material, Particle, Plane, Scene, Settings, Simulation, Spring, shape,
};

const G: f64 = 9.82;

fn falling(position: DVec3, velocity: DVec3) -> Scene {
    Scene { particles: vec![Particle { position, velocity, mass: 2.0 }], ..Scene::default() }
}

fn floor(restitution: f64, friction: Friction) -> Plane {
    Plane { normal: DVec3::Y * 3.0, offset: 0.0, restitution, friction }
}

#[test]
fn free_fall_errs_by_the_first_order_term_of_each_method() {
    let (h, steps) = (1.0 / 128.0, 256);
    let t = h * f64::from(steps);
    let exact = 100.0 - 0.5 * G * t * t;
    // y'' = −g: symplectic Euler falls g h t / 2 too far, explicit Euler as much too little, the
    // others are exact. Rounding: 256 additions to numbers of about 100.
    let late = 0.5 * G * h * t;
    let cases = [
        (Integrator::SymplecticEuler, exact - late),
        (Integrator::ExplicitEuler, exact + late),
        (Integrator::VelocityVerlet, exact),
        (Integrator::Rk4, exact),
    ];
    for (integrator, expected) in cases {
        let scene = falling(DVec3::new(0.0, 100.0, 0.0), DVec3::ZERO);
        let mut simulation = simulation::<f64>(&scene, integrator, h);
        (0..steps).for_each(|_| simulation.step().unwrap());
        let y = simulation.position(0).y;
        assert!((y - expected).abs() < 1e-10, "{integrator}: {y} instead of {expected}");
        assert!((simulation.velocity(0).y + G * t).abs() < 1e-11);
    }
}

#[test]
fn a_bounce_returns_the_height_times_restitution_squared() {
    let (height, restitution) = (5.0, 0.8);
    for h in [1e-3, 1e-4] {
        let mut scene = falling(DVec3::new(0.0, height, 0.0), DVec3::ZERO);
        scene.planes = vec![floor(restitution, Friction::Coulomb(0.0))];
        let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, h);
        let impact = (2.0 * height / G).sqrt();
        let mut highest = 0.0f64;
        while simulation.time() < impact * (1.0 + 2.0 * restitution) {
            simulation.step().unwrap();
            if impact + 2.0 * h < simulation.time() {
                highest = highest.max(simulation.position(0).y);
            }
        }
        // The impact is found at the end of a substep: at most g h too fast, and lifted by the
        // depth v h. Both change the height by at most v h e^2 times two.
        let tolerance = 2.0 * (G * impact) * h;
        let exact = height * restitution * restitution;
        assert!((highest - exact).abs() < tolerance, "h = {h}: {highest} instead of {exact}");
    }
}

#[test]
fn a_resting_contact_does_not_buzz() {
    let mut scene = falling(DVec3::new(0.0, 0.5, 0.0), DVec3::ZERO);
    scene.planes = vec![floor(0.5, Friction::Coulomb(0.0))];
    let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, 1e-3);
    (0..4000).for_each(|_| simulation.step().unwrap());
    for _ in 0..100 {
        simulation.step().unwrap();
        assert_eq!(simulation.position(0).y, 0.0);
        assert_eq!(simulation.velocity(0).y, 0.0);
    }
}

#[test]
fn coulomb_friction_stops_a_slider_after_v_squared_over_two_mu_g_whatever_the_step() {
    let (speed, friction) = (3.0, 0.4);
    let exact = speed * speed / (2.0 * friction * G);
    for h in [1e-2, 1e-3, 1e-4] {
        let mut scene = falling(DVec3::ZERO, DVec3::new(speed, 0.0, 0.0));
        scene.planes = vec![floor(0.0, Friction::Coulomb(friction))];
        let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, h);
        while simulation.time() < 2.0 {
            simulation.step().unwrap();
        }
        let slid = simulation.position(0).x;
        // First order: each substep slides on at the speed it had at its start or end.
        assert!((slid - exact).abs() <= speed * h, "h = {h}: {slid} instead of {exact}");
        assert_eq!(simulation.velocity(0).x, 0.0);
    }
}

#[test]
fn the_tangential_factor_of_the_report_depends_on_the_step() {
    let slid = |h: f64| {
        let mut scene = falling(DVec3::ZERO, DVec3::new(3.0, 0.0, 0.0));
        scene.planes = vec![floor(0.0, Friction::TangentialLoss(0.3))];
        let mut simulation = simulation::<f64>(&scene, Integrator::SymplecticEuler, h);
        (0..200).for_each(|_| simulation.step().unwrap());
        simulation.position(0).x
    };
    // x = v h (1 + 0.7 + 0.49 + ...) = v h / 0.3: proportional to h, so it does not converge.
    for h in [1e-2, 1e-3] {
        let exact = 3.0 * h / 0.3;
        assert!((slid(h) - exact).abs() < 1e-9 * exact);
    }
}

#[test]
fn planes_of_any_orientation_keep_particles_out() {
    let normal = DVec3::new(1.0, 2.0, -2.0);
    let mut scene = falling(DVec3::new(0.0, 2.0, 0.0), DVec3::ZERO);
    scene.planes =
        vec![Plane { normal, offset: -1.0, restitution: 0.3, friction: Friction::Coulomb(0.1) }];
    let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, 1e-3);
    for _ in 0..3000 {
        simulation.step().unwrap();
        let above = normal.dot(simulation.position(0)) / 3.0 + 1.0;
        // Projection rounds once at coordinates of up to 50 m.
        assert!(-1e-13 < above, "{above}");
    }
    // Sliding down an incline of cos a = 2/3: acceleration g (sin a − mu cos a), so it is far away.
    assert!(10.0 < simulation.position(0).length());
}

/// Stretch of two masses on a spring and a damper after time t, from rest at `stretch`.
fn oscillator(w: f64, zeta: f64, stretch: f64, t: f64) -> f64 {
    if zeta < 1.0 {
        let d = w * (1.0 - zeta * zeta).sqrt();
        let decay = (-zeta * w * t).exp();
        stretch * decay * ((d * t).cos() + zeta * w / d * (d * t).sin())
    } else if zeta == 1.0 {
        stretch * (-w * t).exp() * (1.0 + w * t)
    } else {
        let root = w * (zeta * zeta - 1.0).sqrt();
        let (fast, slow) = (-zeta * w - root, -zeta * w + root);
        stretch * (fast * (slow * t).exp() - slow * (fast * t).exp()) / (fast - slow)
    }
}

#[test]
fn two_masses_and_a_damper_follow_the_solution_in_all_three_regimes() {
    let (masses, stiffness, stretch) = ([1.0, 3.0], 30.0, 0.4);
    let reduced: f64 = masses[0] * masses[1] / (masses[0] + masses[1]);
    let w = (stiffness / reduced).sqrt();
    for zeta in [0.1, 1.0, 4.0] {
        let damping = 2.0 * zeta * w * reduced;
        let scene = two_masses(masses, stiffness, damping, stretch);
        // Each method within its error constant times (h w max(1, 2 zeta))^order times stretch.
        for (integrator, h) in [
            (Integrator::ExplicitEuler, 1e-5),
            (Integrator::SymplecticEuler, 1e-5),
            (Integrator::VelocityVerlet, 1e-4),
            (Integrator::Rk4, 1e-3),
        ] {
            let mut simulation = simulation::<f64>(&scene, integrator, h);
            let unit = h * w * (2.0 * zeta).max(1.0);
            // Errors of an oscillator grow with the number of radians run through.
            let radians = w * 1.0;
            let tolerance = stretch * radians * unit.powi(integrator.order() as i32) + 1e-11;
            while simulation.time() < 1.0 {
                simulation.step().unwrap();
                let [a, b] = [0, 1].map(|row| simulation.position(row).x);
                let exact = oscillator(w, zeta, stretch, simulation.time());
                let error = (b - a - 1.0 - exact).abs();
                assert!(error < tolerance, "{integrator}, ζ = {zeta}: {error} at {b}");
            }
        }
    }
}

#[test]
fn the_chain_of_five_is_the_sum_of_its_damped_normal_modes() {
    let (n, stiffness, damping, shift) = (5usize, 20.0, 0.4, 0.8);
    let material = Material { mass: 1.0, stiffness, damping };
    let mut scene = Scene::of("chain", shape::rope(n, 1.0, material).unwrap());
    scene.world = weightless();
    let rest: Vec<f64> = scene.particles.iter().map(|p| p.position.x).collect();
    scene.particles[n - 1].position.x += shift;
    let h = 1e-3;
    let mut simulation = simulation::<f64>(&scene, Integrator::Rk4, h);
    for _ in 0..5000 {
        simulation.step().unwrap();
    }
    let t = simulation.time();
    for (row, rest) in rest.iter().enumerate() {
        // A free chain: w_j = 2 √(k/m) sin(jπ/2n), shape cos(jπ(i+½)/n); j = 0 is the mean.
        let mut x = rest + shift / n as f64;
        for mode in 1..n {
            let angle = std::f64::consts::PI * mode as f64 / n as f64;
            let shape = |i: usize| (angle * (i as f64 + 0.5)).cos();
            let w = 2.0 * stiffness.sqrt() * (angle / 2.0).sin();
            let zeta = damping / stiffness * w / 2.0;
            let weight = 2.0 / n as f64 * shift * shape(n - 1);
            x += weight * shape(row) * oscillator(w, zeta, 1.0, t);
        }
        // RK4: (h w)^4 t w / 120 with w at most 8.5 is 2e-10 m.
        let found = simulation.position(row).x;
        assert!((found - x).abs() < 1e-9, "particle {row}: {found} instead of {x}");
    }
}

#[test]
fn drag_slows_a_particle_exponentially() {
    let mut scene = falling(DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0));
    scene.world = msd_core::World { drag: 3.0, ..weightless() };
    let mut simulation = simulation::<f64>(&scene, Integrator::Rk4, 1e-2);
    (0..100).for_each(|_| simulation.step().unwrap());
    let exact = 4.0 * (-3.0f64 / 2.0).exp();
    // RK4: (h c / m)^4 / 120 relative per unit of c t / m.
    assert!((simulation.velocity(0).x - exact).abs() < 1e-9);
    // Energy decays twice as fast: (2 h c / m)^4 / 120 of 16 J.
    let energy = simulation.energy();
    assert!((energy.total() - 16.0).abs() < 1.1e-7, "{energy:?}");
}

#[test]
fn pins_do_not_move_and_moving_pins_keep_their_velocity() {
    let material = Material { mass: 1.0, stiffness: 500.0, damping: 1.0 };
    let mut scene = Scene::of("rope", shape::rope(6, 1.0, material).unwrap());
    let velocity = DVec3::new(0.25, 0.5, 0.0);
    scene.pins = vec![
        msd_core::Pin { particle: 0, velocity: DVec3::ZERO },
        msd_core::Pin { particle: 5, velocity },
    ];
    for integrator in Integrator::EXPLICIT {
        let settings =
            Settings { integrator, step: 1.0 / 64.0, substeps: 16, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&scene, settings).unwrap();
        (0..64).for_each(|_| simulation.step().unwrap());
        assert_eq!(simulation.position(0), scene.particles[0].position);
        // 1024 additions of a power of two times (1/4, 1/2, 0): exact.
        assert_eq!(simulation.position(5), scene.particles[5].position + velocity);
    }
}

#[test]
fn a_hanging_weight_stretches_its_spring_by_m_g_over_k() {
    let mut scene = two_masses([1.0, 3.0], 200.0, 20.0, 0.0);
    scene.world.gravity = DVec3::new(G, 0.0, 0.0);
    scene.pins = vec![msd_core::Pin { particle: 0, velocity: DVec3::ZERO }];
    let mut simulation = simulation::<f64>(&scene, Integrator::VelocityVerlet, 1e-3);
    (0..20_000).for_each(|_| simulation.step().unwrap());
    let length = simulation.position(1).x;
    // After 20 s the swing has decayed by exp(−20 · 20 / 6).
    assert!((length - 1.0 - 3.0 * G / 200.0).abs() < 1e-12);
}

#[test]
fn rounding_can_change_the_energy_by_what_each_number_can() {
    // Masses of 2 and 3 kg at 4 and 7 m, thrown at 5 m/s, on a spring of 50 N/m and 2 m.
    let mut scene = two_masses([2.0, 3.0], 50.0, 2.0, 0.0);
    for (particle, x) in scene.particles.iter_mut().zip([4.0, 7.0]) {
        (particle.position, particle.velocity) = (DVec3::X * x, DVec3::Z * 5.0);
    }
    scene.world.gravity = DVec3::Y * -G;
    scene.springs[0].rest_length = 2.0;
    let simulation = simulation::<f32>(&scene, Integrator::SymplecticEuler, 1e-3);
    let (energy, rounding) = simulation.energy_and_rounding();
    assert_eq!(energy, simulation.energy());
    let epsilon = f64::from(f32::EPSILON);
    let delta = 7.0 * epsilon;
    let expected = 50.0 * delta * (1.0 + delta) + 5.0 * G * delta + epsilon * 5.0 * 25.0;
    // Gravity is rounded to f32.
    assert!((rounding / expected - 1.0).abs() < 1e-7, "{rounding} instead of {expected}");
}

#[test]
fn force_energy_and_strain_of_a_spring_are_those_of_hooke_and_of_its_damper() {
    let spring = Spring { ends: [0, 1], rest_length: 2.0, stiffness: 30.0, damping: 4.0 };
    let particle = |x: f64, speed: f64| Particle {
        position: DVec3::new(x, 2.0 * x, 2.0 * x),
        velocity: DVec3::new(speed, 0.0, 7.0),
        mass: 1.0,
    };
    // Three metres apart along (1, 2, 2) / 3, and 6 m/s times a third away from each other.
    let particles = vec![particle(0.0, 0.0), particle(1.0, 6.0)];
    let scene = Scene { particles, springs: vec![spring, spring], ..Scene::default() };
    let mut simulation = simulation::<f64>(&scene, Integrator::Rk4, 1e-3);
    let expected = 30.0 * (3.0 - 2.0) + 4.0 * 2.0;
    assert!((simulation.tension(0) - expected).abs() < 1e-12);
    let snapshot = simulation.snapshot();
    let found = [snapshot.tension(0), snapshot.elastic_energy(0), snapshot.strain(0)];
    for (found, expected) in found.into_iter().zip([expected, 30.0 * (3.0 - 2.0) / 2.0, 0.5]) {
        assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
    }
    // A root of 6² + 7² m²/s².
    assert!((snapshot.speed(1) - 85f64.sqrt()).abs() < 1e-12);
    simulation.remove_spring(1).unwrap();
    let snapshot = simulation.snapshot();
    assert_eq!([simulation.tension(1), snapshot.elastic_energy(1)], [0.0; 2]);
    let together = Scene { particles: vec![particle(0.0, 0.0), particle(0.0, 6.0)], ..scene };
    let simulation = crate::common::simulation::<f64>(&together, Integrator::Rk4, 1e-3);
    assert_eq!(simulation.tension(0), 0.0, "no direction");
}
