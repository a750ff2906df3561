//! The scene of a background study.

use glam::DVec3;
use msd_core::{Friction, Plane, Scene, Settings, Spring};
use msd_run::Runner;
use msd_scene::{Loaded, Precision};

/// The state that a study starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StudyFrom {
    /// The first state of the scene.
    #[default]
    Start,
    /// The state of the run at the beginning of the study.
    Here,
}

/// The scene as loaded, and the uniform force of the study, newtons, if that of the run is gusty.
pub(in crate::session) type Now<'a> = (&'a Loaded, Option<DVec3>);

/// Returns the current scene of a run without cut springs, in one of two states; `None` if
/// particles were removed.
pub(in crate::session) fn subject(
    runner: &Runner,
    (loaded, force): Now<'_>,
    from: StudyFrom,
) -> Option<Scene> {
    let (rows, progress) = runner.progress();
    if !progress.removed.is_empty() {
        return None;
    }
    let mut scene = without(rows, &progress.cut);
    scene.world.force = force.unwrap_or(scene.world.force);
    let start = &loaded.scene;
    scene.guides = progress.guides;
    if from == StudyFrom::Start && start.particles.len() == scene.particles.len() {
        for (particle, first) in scene.particles.iter_mut().zip(&start.particles) {
            (particle.position, particle.velocity) = (first.position, first.velocity);
        }
        // Unrounded, so that the cache may hold a study of it by the command line.
        if loaded.progress.is_none() && is_same(&scene, start) {
            return Some(start.clone());
        }
    }
    Some(scene)
}

/// Returns the same in the current state, for a run that starts at time 0.
pub(super) fn subject_here(runner: &Runner, now: Now<'_>) -> Option<Scene> {
    subject(runner, now, StudyFrom::Here).map(|scene| scene.from_time(runner.time()))
}

/// Returns the same for a study.
pub(super) fn loaded_of(
    scene: Scene,
    loaded: &Loaded,
    (settings, precision): (Settings, Precision),
) -> Loaded {
    let title = loaded.title.clone();
    let new = Loaded::new(&loaded.name, scene, settings);
    Loaded { title, precision, camera: loaded.camera, ..new }
}

/// Returns the scene without the springs of these rows, ascending.
fn without(mut scene: Scene, cut: &[usize]) -> Scene {
    if cut.is_empty() {
        return scene;
    }
    for body in &mut scene.bodies {
        let left = |row: usize| row - cut.partition_point(|&spring| spring < row);
        body.springs = left(body.springs.start)..left(body.springs.end);
    }
    let mut row = 0..;
    scene.springs.retain(|_| row.next().is_none_or(|row| cut.binary_search(&row).is_err()));
    scene
}

/// Returns whether two scenes differ only in the state of their particles. Each number is rounded
/// to single precision, as a run in it has rounded them.
pub(super) fn is_same(a: &Scene, b: &Scene) -> bool {
    let vector = |v: msd_core::glam::DVec3| v.to_array().map(round);
    let world = |s: &Scene| {
        (vector(s.world.gravity), vector(s.world.force), round(s.world.drag), s.world.extent)
    };
    let spring = |s: &Spring| (s.ends, [s.rest_length, s.stiffness, s.damping].map(round));
    let plane = |p: &Plane| {
        let (kind, factor) = match p.friction {
            Friction::Coulomb(factor) => (0, factor),
            Friction::TangentialLoss(loss) => (1, loss),
        };
        let normal = vector(p.normal.normalize_or_zero());
        // A rounded and renormalized normal may differ in its last bits.
        (normal.map(|part| (part * 1e6).round()), round(p.restitution), kind, round(factor))
    };
    let pins = |s: &Scene| {
        // A guide sets the velocities of its pins.
        let guided = s.guided();
        let free = s.pins.iter().filter(|pin| !guided.contains(&pin.particle));
        let mut pins: Vec<_> = free.map(|pin| (pin.particle, vector(pin.velocity))).collect();
        pins.sort_by_key(|pin| pin.0);
        pins
    };
    world(a) == world(b)
        && a.world.air == b.world.air
        && a.particles.len() == b.particles.len()
        && a.particles.iter().zip(&b.particles).all(|(a, b)| round(a.mass) == round(b.mass))
        && a.springs.len() == b.springs.len()
        && a.springs.iter().zip(&b.springs).all(|(a, b)| spring(a) == spring(b))
        && a.planes.iter().map(plane).eq(b.planes.iter().map(plane))
        && a.solids == b.solids
        && a.guides == b.guides
        && a.shells == b.shells
        && pins(a) == pins(b)
}

fn round(number: f64) -> f32 {
    number as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Interaction;
    use msd_scene::schema::Solver;

    fn jelly() -> Loaded {
        msd_scene::open("jelly").expect("a built-in scene")
    }

    #[test]
    fn every_built_in_scene_is_its_own_subject_in_either_precision() {
        for builtin in msd_scene::BUILTINS {
            let loaded = msd_scene::open(builtin.name).expect("a built-in scene");
            for precision in [Precision::F32, Precision::F64] {
                let solver = Solver { precision, automatic: false, ..loaded.solver() };
                let mut runner = Runner::open_with(&loaded, solver).expect("it runs");
                runner.step().expect("a first step");
                let scene =
                    subject(&runner, (&loaded, None), StudyFrom::Start).expect("nothing removed");
                assert_eq!(scene, loaded.scene, "{} in {precision}", builtin.name);
                let here =
                    subject(&runner, (&loaded, None), StudyFrom::Here).expect("nothing removed");
                assert!(is_same(&here, &scene) && here != scene, "{}", builtin.name);
            }
        }
    }

    #[test]
    fn a_cut_spring_is_not_studied_and_the_others_keep_their_bodies() {
        let loaded = jelly();
        let mut runner = Runner::open(&loaded).expect("it runs");
        for spring in [0, 7] {
            runner.queue(Interaction::Cut { spring }).expect("a spring of the scene");
        }
        runner.apply_queued().expect("room for it");
        let scene = subject(&runner, (&loaded, None), StudyFrom::Start).expect("nothing removed");
        assert!(!is_same(&scene, &loaded.scene));
        assert_eq!(scene.springs.len(), loaded.scene.springs.len() - 2);
        assert_eq!(scene.springs[0].ends, loaded.scene.springs[1].ends);
        assert_eq!(scene.bodies[0].springs, 0..scene.springs.len());
        Runner::new(&scene, loaded.settings, loaded.precision).expect("it runs");
    }
}
