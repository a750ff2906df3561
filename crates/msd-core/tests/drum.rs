//! scratch
use glam::DVec3;
use msd_core::*;
#[test]
fn bead_on_a_ball() {
    // Slides down a ball with friction: where after 0.4 s, against Dormand-Prince.
    for mu in [0.0, 0.15, 0.3] {
        let scene = || {
            let mut scene = Scene {
                world: World { gravity: DVec3::new(0.0, -9.82, 0.0), ..World::default() },
                particles: vec![Particle {
                    position: DVec3::new(0.5f64.sin() * 1.3, 0.5f64.cos() * 1.3, 0.0),
                    velocity: DVec3::ZERO,
                    mass: 1.0,
                }],
                ..Scene::default()
            };
            scene.solids = vec![Solid {
                friction: Friction::Coulomb(mu),
                ..Solid::new(Shape::Sphere { radius: 1.3 })
            }];
            scene
        };
        let run = |i: Integrator, n: u32| {
            let mut s = Simulation::<f64>::new(
                &scene(),
                Settings { integrator: i, substeps: n, tolerance: 1e-9, ..Settings::default() },
            )
            .unwrap();
            for _ in 0..30 {
                s.step().unwrap();
            }
            s.position(0)
        };
        let exact = run(Integrator::DormandPrince, 1);
        for i in [
            Integrator::VelocityVerlet,
            Integrator::Rk4,
            Integrator::SymplecticEuler,
            Integrator::BackwardEuler,
            Integrator::ImplicitMidpoint,
            Integrator::Xpbd,
        ] {
            let e: Vec<String> = [8, 32, 128, 512]
                .iter()
                .map(|&n| format!("{:.2e}", (run(i, n) - exact).length()))
                .collect();
            println!("mu {mu} {i}: {}  ({exact})", e.join(" "));
        }
    }
}
fn at(mut f: impl FnMut(usize) -> f64) -> f64 {
    ((f(30) - f(18)) / 0.2 - (f(18) - f(6)) / 0.2) / 0.2
}
#[test]
fn rope_over_a_drum() {
    let (g, r, n) = (9.81, 0.2, 121usize);
    let one = 1.0;
    let arc = std::f64::consts::PI * r;
    let ds = (arc + 2.0 * one) / (n as f64 - 1.0);
    let place = |i: usize| {
        let q = i as f64 * ds;
        if q < one {
            DVec3::new(-r, -one + q, 0.0)
        } else if q < one + arc {
            DVec3::new(-r * ((q - one) / r).cos(), r * ((q - one) / r).sin(), 0.0)
        } else {
            DVec3::new(r, -(q - one - arc), 0.0)
        }
    };
    let scene = || {
        let particles: Vec<Particle> = (0..n)
            .map(|i| Particle {
                position: place(i),
                velocity: DVec3::ZERO,
                mass: if i == 0 {
                    1.0
                } else if i == n - 1 {
                    3.0
                } else {
                    1e-3
                },
            })
            .collect();
        let springs = (0..n - 1)
            .map(|i| Spring {
                ends: [i, i + 1],
                rest_length: (place(i) - place(i + 1)).length(),
                stiffness: 1e6,
                damping: 20.0,
            })
            .collect();
        Scene {
            world: World { gravity: DVec3::new(0.0, -g, 0.0), ..World::default() },
            particles,
            springs,
            solids: vec![Solid {
                axes: glam::DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2),
                friction: Friction::Coulomb(0.3),
                ..Solid::new(Shape::Cylinder { radius: r, length: 1.0 })
            }],
            ..Scene::default()
        }
    };
    for n in [8, 16, 32, 100] {
        for i in [Integrator::BackwardEuler, Integrator::ImplicitMidpoint] {
            let mut s = Simulation::<f64>::new(
                &scene(),
                Settings { integrator: i, substeps: n, ..Settings::default() },
            )
            .unwrap();
            let mut y = vec![s.position(0).y];
            for _ in 0..30 {
                if s.step().is_err() {
                    break;
                }
                y.push(s.position(0).y);
            }
            println!(
                "rope {i} {n}: {:.4} taken {:?}",
                if y.len() == 31 { at(|k| y[k]) } else { f64::NAN },
                s.contacts()
            );
        }
    }
}
#[test]
fn turntable() {
    let scene = |block: bool, spin: f64, mu: f64| {
        let mut scene = if block {
            let mut part = shape::block(
                [4, 4, 4],
                0.05,
                Material { mass: 0.0158, stiffness: 400.0, damping: 0.2 },
            )
            .unwrap();
            let low = part.particles.iter().map(|p| p.position.y).fold(f64::MAX, f64::min);
            part.place(glam::DMat3::IDENTITY, DVec3::Y * -low);
            part.set_motion(DVec3::ZERO, DVec3::new(0.0, spin, 0.0));
            Scene::of("block", part)
        } else {
            Scene {
                particles: vec![Particle {
                    position: DVec3::new(0.3, 0.0, 0.1),
                    velocity: DVec3::new(0.0, spin, 0.0).cross(DVec3::new(0.3, 0.0, 0.1)),
                    mass: 1.0,
                }],
                ..Scene::default()
            }
        };
        scene.world = World { gravity: DVec3::new(0.0, -9.82, 0.0), ..World::default() };
        scene.solids = vec![Solid {
            position: DVec3::new(0.0, -0.1, 0.0),
            spin: DVec3::new(0.0, spin, 0.0),
            friction: Friction::Coulomb(mu),
            ..Solid::new(Shape::Box { size: DVec3::new(4.0, 0.2, 4.0) })
        }];
        scene
    };
    fn run<R: Real>(scene: &Scene, i: Integrator) -> String {
        let mut s =
            Simulation::<R>::new(scene, Settings { integrator: i, ..Settings::default() }).unwrap();
        let last = s.model().particle_count() - 1;
        let (mut low, mut high, mut low0, mut high0) = (f64::MAX, f64::MIN, f64::MAX, f64::MIN);
        for k in 0..300 {
            s.step().unwrap();
            if k > 120 {
                let h = s.position(last).to_f64().y - s.position(0).to_f64().y;
                low = low.min(h);
                high = high.max(h);
                let y = s.position(0).to_f64().y;
                low0 = low0.min(y);
                high0 = high0.max(y);
            }
        }
        let c = s.contacts();
        format!(
            "{:.1e} {:.1e} taken {:.2e} added {:.2e} driven {:.2e}",
            high - low,
            high0 - low0,
            c.taken,
            c.added,
            c.driven
        )
    }
    for block in [false, true] {
        for mu in [0.0, 0.5] {
            for spin in [0.2, 2.0] {
                let sc = scene(block, spin, mu);
                for i in [
                    Integrator::VelocityVerlet,
                    Integrator::SymplecticEuler,
                    Integrator::Rk4,
                    Integrator::BackwardEuler,
                ] {
                    println!(
                        "table block {block} mu {mu} spin {spin} {i}: f64 {} | f32 {}",
                        run::<f64>(&sc, i),
                        run::<f32>(&sc, i)
                    );
                }
            }
        }
    }
}
#[test]
fn valley() {
    let a: f64 = 0.3420201433256687;
    let b = 0.9396926207859084;
    let mut part =
        shape::block([7, 7, 7], 0.05, Material { mass: 0.003, stiffness: 60.0, damping: 0.06 })
            .unwrap();
    part.place(glam::DMat3::IDENTITY, DVec3::Y * 0.23);
    let plane = |s: f64| Plane {
        normal: DVec3::new(s * a, b, 0.0),
        offset: 0.0,
        restitution: 0.0,
        friction: Friction::Coulomb(0.3),
    };
    let mut scene = Scene::of("block", part);
    scene.world = World { gravity: DVec3::new(0.0, -9.82, 0.0), ..World::default() };
    scene.planes = vec![plane(1.0), plane(-1.0)];
    for i in Integrator::ALL {
        for n in [8, 16, 32] {
            let mut s = Simulation::<f64>::new(
                &scene,
                Settings { integrator: i, substeps: n, ..Settings::default() },
            )
            .unwrap();
            let e0 = s.energy();
            let mut worst: f64 = 0.0;
            let mut failed = false;
            for _ in 0..240 {
                if s.step().is_err() {
                    failed = true;
                    break;
                }
                {
                    let e = s.energy();
                    worst = worst.max(e.total() - e0.total() + s.dissipated() - s.given());
                }
            }
            let e = s.energy();
            let v = s.velocities().map(|v| v.length()).fold(0.0, f64::max);
            println!(
                "valley {i} {n}: failed {failed} speed {v:.2e} imbalance {:.3e} worst {worst:.3e} of {:.3} contacts {:?}",
                e.total() - e0.total() + s.dissipated() - s.given(),
                e0.total() - e.total(),
                s.contacts()
            );
        }
    }
}
