//! A cloth in a gusty wind, an element of our own: the energy balance closes, and the predicted
//! stable step includes the drag.

use msd::core::elements::{Element, Motion, Vectors};
use msd::core::glam::DVec3;
use msd::core::{Error, Material, Pin, Real, Scene, Settings, Simulation, Vector, shape};

/// A drag towards a wind along z that swells and falls.
#[derive(Debug)]
struct Wind {
    /// Mean speed, metres per second.
    speed: f64,
    /// Drag of a particle, newton seconds per metre.
    drag: f64,
}

impl<R: Real> Element<R> for Wind {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let gust = 1.0 + 0.5 * (3.0 * motion.time()).sin();
        let wind = DVec3::Z * (self.speed * gust);
        let mut power = 0.0;
        for particle in 0..motion.particle_count() {
            let velocity = motion.velocity(particle).to_f64();
            let force = (wind - velocity) * self.drag;
            forces.add(particle, R::Vec3::of(force));
            power -= force.dot(velocity);
        }
        power
    }
}

fn main() -> Result<(), Error> {
    let material = Material { mass: 0.01, stiffness: 100.0, damping: 0.02 };
    let mut scene = Scene::of("flag", shape::cloth([10, 10], 0.1, material)?);
    scene.pins = [90, 99].map(|particle| Pin { particle, velocity: DVec3::ZERO }).to_vec();
    let settings = Settings { substeps: 20, ..Settings::default() };
    let mut flag = Simulation::<f64>::new(&scene, settings)?;
    println!("stable up to {:.2e} s in calm air", flag.stable_substep());
    flag.add_element(Wind { speed: 4.0, drag: 0.05 });
    println!("stable up to {:.2e} s in the wind", flag.stable_substep());
    let start = flag.energy().total();
    for second in 1..=3 {
        for _ in 0..60 {
            flag.step()?;
        }
        let (energy, edge) = (flag.energy(), flag.position(4));
        let apart = energy.total() - start;
        println!("t = {second} s: edge at z = {:.3} m, energy off by {apart:+.1e} J", edge.z);
        assert!(apart.abs() < 1e-3 * flag.given(), "a balance that closes");
    }
    println!("the wind gave {:.3} J", flag.given());
    Ok(())
}
