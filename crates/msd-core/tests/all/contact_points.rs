//! Contact points on springs: which springs have them. `contact/` tests their effect.

use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{Friction, Material, Scene, Settings, Shape, Simulation, Solid, shape};
use std::f64::consts::FRAC_PI_2;

/// A rod along z through the origin, of 10 cm.
fn rod(springs: bool) -> Solid {
    let mut rod = Solid::new(Shape::Capsule { radius: 0.05, length: 3.0 });
    rod.axes = rotation(DVec3::X, FRAC_PI_2);
    Solid { friction: Friction::Coulomb(0.5), springs, ..rod }
}

/// A cloth of 6 x 6 particles, 25 cm apart, above the rod, which no particle would meet.
fn cloth(springs: bool) -> Scene {
    let material = Material { mass: 0.05, stiffness: 400.0, damping: 2.0 };
    let mut cloth = shape::cloth([6, 6], 0.25, material).expect("a cloth");
    let flat = DMat3::from_rotation_x(FRAC_PI_2);
    cloth.place(flat, DVec3::new(0.01, 0.3, 0.03));
    Scene { solids: vec![rod(springs)], ..Scene::of("cloth", cloth) }
}

fn simulation(scene: &Scene) -> Simulation<f64> {
    let settings = Settings { substeps: 32, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

/// Obstacles add no stiffness: the predicted step is that without.
#[test]
fn points_leave_the_stable_step_as_it_is() {
    let stable = |springs| simulation(&cloth(springs)).stable_substep();
    assert_eq!(stable(true), stable(false));
}

/// Springs that are cut have no points, and none that is shorter than the solid is thick.
#[test]
fn only_long_springs_that_are_there_have_points() {
    let mut thick = cloth(true);
    thick.solids[0].shape = Shape::Capsule { radius: 0.18, length: 3.0 };
    let springs = thick.springs.len();
    let mut cut = simulation(&cloth(true));
    for spring in 0..springs {
        let interaction = msd_core::Interaction::Cut { spring };
        cut.queue(interaction).expect("a spring of the scene");
    }
    (0..90).for_each(|_| cut.step().expect("a calm run"));
    // Each particle falls on its own, beside the rod.
    assert!((0..36).all(|particle| cut.position(particle).y < -5.0));
    // A rod of 36 cm is met by the particles themselves, whether it meets springs or not.
    let mut end = |springs: bool| {
        thick.solids[0].springs = springs;
        let mut run = simulation(&thick);
        (0..60).for_each(|_| run.step().expect("a calm run"));
        run.state()
    };
    assert_eq!(end(true), end(false));
}
