//! Contact points on springs: thin solids hold sparse bodies, and impulses are shared to the ends.

use crate::common::weightless;
use crate::table::{Measures, after};
use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Particle, Real, Scene, Settings, Shape, Simulation, Solid,
    Spring, Vector, shape,
};
use std::f64::consts::FRAC_PI_2;

/// A rod along z through the origin, of 10 cm.
fn rod(springs: bool) -> Solid {
    let rod = Solid::new(Shape::Capsule { radius: 0.05, length: 3.0 });
    let axes = rotation(DVec3::X, FRAC_PI_2);
    Solid { axes, friction: Friction::Coulomb(0.5), springs, ..rod }
}

/// A cloth of 6 x 6 particles, 25 cm apart, above the rod, which no particle meets. It hangs over
/// the rod by its springs, and without contact points nothing holds it.
pub fn sparse_cloths_hang<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    let material = Material { mass: 0.05, stiffness: 400.0, damping: 2.0 };
    let mut cloth = shape::cloth([6, 6], 0.25, material).expect("a cloth");
    cloth.place(DMat3::from_rotation_x(FRAC_PI_2), DVec3::new(0.01, 0.3, 0.03));
    let over = |springs| Scene { solids: vec![rod(springs)], ..Scene::of("cloth", cloth.clone()) };
    let name = "without contact points";
    let pierced = after::<R>(&over(false), (integrator, 32), 60, (&mut measures, name));
    // In a second it falls by 4.9 m.
    measures.see("above free fall, m", (4.5 + pierced.centre_of_mass(0..36).y, 0.1), name);
    let (scene, name) = (over(true), "contact points");
    let settings = Settings { integrator, ..Settings::default() };
    let before = Simulation::<R>::new(&scene, settings).expect("a scene").energy().total();
    // Dormand-Prince meets points where its long substeps end, between which they creep.
    let seconds = if integrator == Integrator::DormandPrince { 1 } else { 2 };
    let held = after::<R>(&scene, (integrator, 32), 60 * seconds, (&mut measures, name));
    let low = -held.centre_of_mass(0..36).y;
    measures.see("hangs low, m", (low, 0.5), name);
    // Springs lie outside of the rod, but for the penetration between points 5 cm apart.
    let sinks = 0.05 - (0.05f64 * 0.05 - 0.025 * 0.025).sqrt();
    for &[a, b] in held.model().springs().ends() {
        let [a, b] = [a, b].map(|end| held.position(end as usize).to_f64());
        for part in [0.25, 0.5, 0.75] {
            let point = a + (b - a) * part;
            measures.see("inside, m", (0.05 - point.x.hypot(point.y), sinks), name);
        }
    }
    // Backward Euler and XPBD damp by their nature: they may lose, not gain.
    let gain = held.energy().total() - before;
    let damps = matches!(integrator, Integrator::BackwardEuler | Integrator::Xpbd);
    let off = if damps { gain } else { gain.abs() };
    measures.see("imbalance, J", (off, 0.05 * held.dissipated()), name);
    measures
}

/// Two particles on a spring fall flat on the rod, a quarter of the way from the first. They are
/// rigid in no direction but along, so that each goes on as the shared impulse says, and the rod
/// took the missing energy.
pub fn impulses_are_shared<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, name) = (Measures::default(), "rod");
    let (masses, part, restitution) = ([0.3, 0.5], 0.25, 0.6);
    let weights = [1.0 - part, part];
    let particle = |end: usize| Particle {
        position: DVec3::new([-part, 1.0 - part][end], 0.2, 0.0),
        velocity: DVec3::Y * -3.0,
        mass: masses[end],
    };
    let scene = Scene {
        world: weightless(),
        particles: [0, 1].map(particle).into(),
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness: 1.0, damping: 0.0 }],
        solids: vec![Solid { restitution, friction: Friction::Coulomb(0.0), ..rod(true) }],
        ..Scene::default()
    };
    // The impact is after 50 ms.
    let simulation = after::<R>(&scene, (integrator, 64), 4, (&mut measures, name));
    let reciprocal: f64 = (0..2).map(|end| weights[end] * weights[end] / masses[end]).sum();
    let impulse = (1.0 + restitution) * 3.0 / reciprocal;
    for end in 0..2 {
        let expected = -3.0 + impulse * weights[end] / masses[end];
        let off = (simulation.velocity(end).to_f64().y - expected).abs();
        // The penetration of the point into a round rod turns the push a little.
        measures.see("off its speed, m/s", (off, 2e-3 * 3.0), name);
    }
    let lost = 0.5 * (1.0 - restitution * restitution) * 9.0 / reciprocal;
    let off = (simulation.contacts().taken - lost).abs();
    measures.see("off its loss, J", (off, 5e-3 * lost), name);
    let before = 0.5 * (masses[0] + masses[1]) * 9.0;
    let off = (simulation.energy().total() - before).abs();
    measures.see("imbalance, J", (off, 5e-3 * lost), name);
    measures
}
