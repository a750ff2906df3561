//! scratch
use glam::DVec3;
use msd_core::{
    Friction, Integrator, Particle, Plane, Real, Scene, Settings, Simulation, Vector, World, glam,
};

fn groove<R: Real>(degrees: f64, friction: f64, integrator: Integrator) -> (f64, f64, f64, f64) {
    let a = degrees.to_radians();
    let plane = |s: f64| Plane {
        normal: DVec3::new(s * a.sin(), a.cos(), 0.0),
        offset: 0.0,
        restitution: 0.0,
        friction: Friction::Coulomb(friction),
    };
    let scene = Scene {
        world: World { gravity: DVec3::new(0.0, -9.82, 0.0), ..World::default() },
        particles: vec![Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass: 1.0 }],
        planes: vec![plane(1.0), plane(-1.0)],
        ..Scene::default()
    };
    let mut sim =
        Simulation::<R>::new(&scene, Settings { integrator, ..Settings::default() }).unwrap();
    for _ in 0..600 {
        sim.step().unwrap();
    }
    let c = sim.contacts();
    (sim.velocity(0).to_f64().length(), sim.position(0).to_f64().length(), c.taken, c.added)
}
#[test]
fn grooves() {
    for i in Integrator::ALL {
        for d in [10.0, 30.0, 60.0, 80.0] {
            for f in [0.0, 0.3] {
                println!(
                    "{i} {d} {f}: f64 {:?} f32 {:?}",
                    groove::<f64>(d, f, i),
                    groove::<f32>(d, f, i)
                );
            }
        }
    }
}
#[test]
fn slope() {
    let scene = Scene {
        world: World { gravity: DVec3::new(0.0, -9.82, 0.0), ..World::default() },
        particles: vec![Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass: 1.0 }],
        planes: vec![Plane {
            normal: DVec3::new(3.0, 7.0, -2.0),
            offset: 0.0,
            restitution: 0.0,
            friction: Friction::Coulomb(0.4120630029101704),
        }],
        ..Scene::default()
    };
    let mut sim = Simulation::<f64>::new(
        &scene,
        Settings { integrator: Integrator::DormandPrince, ..Settings::default() },
    )
    .unwrap();
    for k in 0..120 {
        if let Err(e) = sim.step() {
            println!("{k} {e}");
            break;
        }
    }
    println!("{} {:?}", sim.position(0).length(), sim.velocity(0));
}
