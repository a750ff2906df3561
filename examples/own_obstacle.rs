//! A cloth that falls on a torus, an obstacle of our own.

use msd::core::glam::DVec3;
use msd::core::obstacles::{ContactLaw, Obstacle};
use msd::core::{Error, Friction, Material, Real, Scene, Settings, Simulation, Vector, shape};

/// A ring about the y axis.
#[derive(Debug)]
struct Torus {
    /// From the axis to the middle of the tube, metres.
    radius: f64,
    /// Of the tube, metres.
    tube: f64,
}

impl Torus {
    /// The vector from the nearest point of the middle of the tube.
    fn offset<R: Real>(&self, position: R::Vec3) -> DVec3 {
        let x = position.to_f64();
        let flat = DVec3::new(x.x, 0.0, x.z);
        x - flat * (self.radius / flat.length().max(1e-9))
    }
}

impl<R: Real> Obstacle<R> for Torus {
    fn gap(&self, position: R::Vec3, _: f64) -> R {
        R::of(self.offset::<R>(position).length() - self.tube)
    }

    fn normal(&self, position: R::Vec3, _: f64) -> R::Vec3 {
        R::Vec3::of(self.offset::<R>(position).normalize_or(DVec3::Y))
    }

    fn law(&self) -> ContactLaw<R> {
        ContactLaw::new(0.0, Friction::Coulomb(0.6))
    }
}

fn main() -> Result<(), Error> {
    let material = Material { mass: 0.005, stiffness: 100.0, damping: 0.05 };
    let mut part = shape::lattice([1, 31, 31], Default::default(), 0.05, material)?;
    part.particles.iter_mut().for_each(|particle| particle.position.y += 0.5);
    let mut cloth = Simulation::<f32>::new(
        &Scene::of("cloth", part),
        Settings { substeps: 16, ..Settings::default() },
    )?;
    cloth.add_obstacle(Torus { radius: 0.4, tube: 0.15 })?;
    for second in 1..=3 {
        for _ in 0..60 {
            cloth.step()?;
        }
        let (middle, corner) = (cloth.position(480), cloth.position(0));
        println!("t = {second} s: middle at y = {:+.3} m, corner at {:+.3} m", middle.y, corner.y);
    }
    Ok(())
}
