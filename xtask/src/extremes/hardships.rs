//! The hardships that every method goes through, and the outcomes for the body.

use crate::extremes::bodies::{self, MATERIAL};
use crate::extremes::judge::{Measure, Task, judge};
use crate::extremes::oscillator::Oscillator;
use crate::extremes::outcome::Verdict;
use msd_core::glam::DVec3;
use msd_core::{Integrator, Material, Scene, Settings};
use msd_scene::Precision;

/// A scene that asks much.
#[derive(Clone, Debug)]
pub struct Hardship {
    /// Name of the hardship.
    pub name: &'static str,
    /// Description of the hardship.
    pub about: &'static str,
    /// The scene.
    pub scene: Scene,
    /// Length of a step and of the run, seconds.
    times: (f64, f64),
    /// Substeps per step; of an implicit method a quarter.
    substeps: u32,
    /// The motion, where it is known; else the strain of the edges is the measure.
    known: Option<Oscillator>,
}

/// A body for ten seconds.
fn body(name: &'static str, about: &'static str, scene: Scene) -> Hardship {
    Hardship { name, about, scene, times: (1.0 / 60.0, 10.0), substeps: 8, known: None }
}

/// Every hardship.
pub fn hardships() -> Vec<Hardship> {
    let mut all = motions();
    all.extend(shapes());
    all.extend(contacts());
    all.extend(materials());
    all.push(patience());
    all
}

fn motions() -> Vec<Hardship> {
    let far = |x: DVec3| x + DVec3::new(1e7, 0.0, 0.0);
    let fast = |_| DVec3::new(1e6, 0.0, 0.0);
    vec![
        body("at rest", "nothing happens: the measure of all others", bodies::block(MATERIAL)),
        body("fast", "flies at 1e6 m/s, for 1e7 m", bodies::in_a_wide_world(bodies::moving(fast))),
        body(
            "torn",
            "every particle is thrown another way, at up to 1e6 m/s",
            bodies::in_a_wide_world(bodies::torn(1e6)),
        ),
        body(
            "far away",
            "1e7 m from the origin, where a coordinate in f32 has steps of 1 m",
            bodies::in_a_wide_world(bodies::placed(far)),
        ),
    ]
}

fn shapes() -> Vec<Hardship> {
    let inverted = |x: DVec3| if 0.0 < x.y { DVec3::new(x.x, -x.y - 0.2, x.z) } else { x };
    vec![
        body("no length", "springs of rest length 0 shrink to a point", bodies::without_lengths()),
        body(
            "stretched",
            "let go from 1e6 times its size",
            bodies::in_a_wide_world(bodies::placed(|x| x * 1e6)),
        ),
        body("inside out", "let go mirrored at half its size", bodies::placed(|x| x * -0.5)),
        body("half inverted", "its upper half pushed through the lower", bodies::placed(inverted)),
        body("one point", "all particles at one point, exactly", bodies::placed(|_| DVec3::ZERO)),
        body("one speck", "all particles within 1e-9 m", bodies::scattered(1e-9)),
        body("flat", "all particles on a plane, exactly", {
            bodies::placed(|x| DVec3::new(x.x, 0.0, x.z))
        }),
        body("nearly flat", "a millionth of its height", {
            bodies::placed(|x| DVec3::new(x.x, 1e-6 * x.y, x.z))
        }),
        body("scattered", "every particle at random in the box of the body", {
            bodies::scattered(0.75)
        }),
    ]
}

fn contacts() -> Vec<Hardship> {
    let (still, slide) = (DVec3::ZERO, DVec3::new(10.0, 0.0, 0.0));
    vec![
        body("gap", "between two planes half its height apart", bodies::squeezed()),
        body("crushed", "its pinned upper side is driven through a floor", bodies::crushed()),
        body("restitution 0", "falls 1 m on a floor", bodies::dropped((0.0, 0.5), still)),
        body("restitution 1", "falls 1 m on a floor", bodies::dropped((1.0, 0.5), still)),
        body("friction 0", "lands on a floor at 10 m/s", bodies::dropped((0.0, 0.0), slide)),
        body("friction 1000", "lands on a floor at 10 m/s", bodies::dropped((0.0, 1e3), slide)),
    ]
}

fn materials() -> Vec<Hardship> {
    // The damping ratio of the usual block, whatever its stiffness and mass.
    let ratio = MATERIAL.damping / critical(MATERIAL);
    let of = |stiffness, mass, ratio: f64| {
        let undamped = Material { stiffness, mass, damping: 0.0 };
        let damping = ratio * critical(undamped);
        bodies::placed_of(Material { damping, ..undamped }, |x| x * 1.01)
    };
    let Material { mass, stiffness, .. } = MATERIAL;
    let by = "let go from 1.01 times its size";
    vec![
        body("1e12 N/m", by, of(1e12, mass, ratio)),
        body("1e-9 N/m", by, of(1e-9, mass, ratio)),
        body("1e-9 kg", by, of(stiffness, 1e-9, ratio)),
        body("1e9 kg", by, of(stiffness, 1e9, ratio)),
        body("masses 1e12 : 1", by, bodies::uneven(1e12)),
        body("damping 1000", by, of(stiffness, mass, 1e3)),
    ]
}

/// The damping at which a particle on one spring is just critical, newton seconds per metre.
fn critical(material: Material) -> f64 {
    2.0 * (material.stiffness * material.mass).sqrt()
}

/// A soft spring for a day and more: a period of 100 s and 200 steps in it.
fn patience() -> Hardship {
    let frequency = std::f64::consts::TAU / 100.0;
    let stiffness = 0.5 * frequency * frequency;
    let known = Oscillator { masses: [1.0; 2], stiffness, damping_ratio: 0.0 };
    Hardship {
        name: "100 000 s",
        about: "two masses on a spring swing a thousand times, 200 steps each",
        scene: known.scene(),
        times: (0.5, 1e5),
        substeps: 1,
        known: Some(known),
    }
}

/// Evaluations of the forces after which an adaptive method has been seen enough.
const EVALUATIONS: f64 = 500_000.0;

impl Hardship {
    /// Puts a method through it, for a part of its time.
    pub fn run(&self, integrator: Integrator, precision: Precision, part: f64) -> Verdict {
        let (step, time) = self.times;
        let substeps =
            if integrator.is_implicit() { self.substeps.div_ceil(4) } else { self.substeps };
        let task = Task {
            scene: &self.scene,
            settings: Settings { integrator, step, substeps, ..Settings::default() },
            precision,
            steps: (part * time / step).round() as u64,
            evaluations: (part * EVALUATIONS) as u64,
        };
        match &self.known {
            Some(known) => judge(&task, &Measure::Largest(&|time, at| known.error(time, at))),
            None => judge(&task, &Measure::Last(&|_, at| self.strain(at))),
        }
    }

    /// Returns whether the error of a run is the root mean square strain of the edges.
    pub fn tells_strain(&self) -> bool {
        self.known.is_none()
    }

    /// Root mean square strain of the springs that have a length; 1 where none has, as such a body
    /// has no shape to keep.
    fn strain(&self, positions: &dyn Fn(usize) -> DVec3) -> f64 {
        let with_length = self.scene.springs.iter().filter(|spring| 0.0 < spring.rest_length);
        let (mut sum, mut count) = (0.0, 0.0);
        for spring in with_length {
            let [a, b] = spring.ends.map(positions);
            sum += ((b - a).length() / spring.rest_length - 1.0).powi(2);
            count += 1.0;
        }
        if count == 0.0 { 1.0 } else { (sum / count).sqrt() }
    }
}
