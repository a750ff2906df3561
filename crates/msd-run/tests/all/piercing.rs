//! The watch reports solids that go through a surface, but not those that only push it.

use msd_core::{Body, Vector};
use msd_run::{Pierced, Piercing, Runner, on};
use msd_scene::{Loaded, SceneFormat, parse};

fn load(text: &str) -> Loaded {
    parse(text, SceneFormat::Toml, "pierced").expect("a scene")
}

fn runner(text: &str) -> Runner {
    Runner::open(&load(text)).expect("it runs")
}

/// Runs until a time, with a look after each step.
fn watch(runner: &mut Runner, piercing: &mut Piercing, until: f64) {
    piercing.look(runner);
    while runner.time() < until {
        runner.step().expect("a step");
        piercing.look(runner);
    }
}

/// A ball that reaches a cloth of 1 x 1 m in the middle after 0.1 s. It hangs from its upper edge
/// across the way of the ball, which is along x.
fn ball(speed: f64, substeps: u32) -> Loaded {
    let at = -0.1 * speed - 0.1;
    load(&format!(
        r#"version = 1
        [solver]
        substeps = {substeps}
        [[world.solids]]
        kind = "sphere"
        radius = 0.1
        position = [{at}, 0.013, 0.007]
        velocity = [{speed}, 0, 0]
        [[bodies]]
        kind = "cloth"
        size = [21, 21]
        spacing = 0.05
        mass = 0.002
        stiffness = 60
        damping = 0.02
        rotation = {{ axis = [0, 1, 0], angle_deg = 90 }}
        [[pins]]
        set = "top"
        "#
    ))
}

/// The report after some seconds, and the number of particles in front of the ball, no further from
/// its way than its radius.
fn fly(speed: f64, substeps: u32, seconds: f64) -> (Option<Pierced>, usize) {
    let mut runner = Runner::open(&ball(speed, substeps)).expect("it runs");
    let mut piercing = Piercing::default();
    watch(&mut runner, &mut piercing, seconds);
    let middle = -0.1 * speed - 0.1 + speed * runner.time();
    let pushed = on!(&runner, simulation => {
        let places = simulation.positions().map(Vector::to_f64);
        places.filter(|place| middle < place.x && place.y.hypot(place.z) < 0.1).count()
    });
    (piercing.first(), pushed)
}

#[test]
fn a_surface_of_particles_of_another_body_is_watched_too() {
    let mut loaded = ball(30.0, 128);
    let bodies = &mut loaded.scene.bodies;
    let surface = std::mem::take(&mut bodies[0].surface);
    bodies.push(Body { name: "skin".into(), surface, ..Body::default() });
    let (mut runner, mut piercing) = (Runner::open(&loaded).expect("it runs"), Piercing::default());
    watch(&mut runner, &mut piercing, 0.5);
    assert!(matches!(piercing.first(), Some(Pierced { solid: 0, body: 1, .. })));
}

#[test]
fn a_ball_that_goes_through_a_cloth_is_told() {
    for (speed, substeps) in [(10.0, 64), (30.0, 128), (100.0, 400)] {
        let (told, pushed) = fly(speed, substeps, 0.5);
        let Some(Pierced { solid: 0, body: 0, time }) = told else {
            panic!("{speed} m/s: {told:?}")
        };
        assert!((0.1..0.5).contains(&time), "{speed} m/s: at {time} s");
        // One may stay on its nose.
        assert!(pushed <= 1, "{speed} m/s: {pushed} in front of it");
    }
}

#[test]
fn a_ball_that_pushes_a_cloth_is_not() {
    let (told, pushed) = fly(1.0, 64, 0.6);
    assert_eq!(told, None);
    assert!(5 <= pushed, "{pushed} in front of it");
}

/// With as many substeps as the limit of stability asks for, it moves by a quarter of its radius in
/// each. It parts the cloth and does less than two thirds of the work.
#[test]
fn automatic_substeps_are_enough_for_a_fast_ball() {
    let driven = |is_automatic: bool| {
        let mut runner = Runner::open(&ball(10.0, 64)).expect("it runs");
        runner.set_automatic(is_automatic).expect("substeps");
        while runner.time() < 0.2 {
            runner.step().expect("a step");
        }
        (runner.contacts().driven, runner.settings().substeps)
    };
    let ((fine, _), (chosen, substeps)) = (driven(false), driven(true));
    assert!(substeps < 64, "{substeps}");
    assert!((chosen - fine).abs() < 0.02 * fine, "{chosen} of {fine}, {substeps}");
}

/// In a substep of its own limit a plate of 2 cm moves by 3 cm. Its points on springs throw the
/// cube to pieces.
#[test]
fn automatic_substeps_are_enough_for_a_fast_plate() {
    let text = |substeps: &str| {
        format!(
            r#"version = 1
            [solver]
            substeps = {substeps}
            [world]
            gravity = [0, 0, 0]
            [[world.solids]]
            kind = "box"
            size = [1.03, 0.02, 1.03]
            position = [0.03, 2, 0.02]
            velocity = [0, -10, 0]
            springs = true
            [[bodies]]
            kind = "block"
            size = [7, 7, 7]
            spacing = 0.1
            mass = 0.01
            stiffness = 100
            damping = 0.05
            position = [0, 1, 0]
            "#
        )
    };
    let moving = |substeps| {
        let mut runner = runner(&text(substeps));
        while runner.time() < 0.15 {
            runner.step().expect("a step");
        }
        runner.energy().kinetic
    };
    let (fine, chosen) = (moving("64"), moving("\"auto\""));
    assert!((chosen - fine).abs() < 0.05 * fine, "{chosen} of {fine}");
}

/// Its ears come through a cloth that falls on it.
#[test]
fn a_part_of_a_mesh_that_goes_through_a_cloth_is_told() {
    let mut runner = runner(
        r#"version = 1
        [solver]
        substeps = 16
        [[world.solids]]
        kind = "mesh"
        file = "bunny.obj"
        length = 1.2
        position = [0, 0.6, 0]
        [[bodies]]
        kind = "cloth"
        size = [21, 21]
        spacing = 0.1
        mass = 0.005
        stiffness = 60
        damping = 0.02
        position = [0, 1.3, 0]
        rotation = { axis = [1, 0, 0], angle_deg = 90 }
        "#,
    );
    let mut piercing = Piercing::default();
    watch(&mut runner, &mut piercing, 0.5);
    assert!(piercing.first().is_some());
}

#[test]
fn a_run_that_goes_back_is_looked_at_anew() {
    let mut runner = Runner::open(&ball(30.0, 128)).expect("it runs");
    let start = runner.moment();
    let mut piercing = Piercing::default();
    for _ in 0..2 {
        watch(&mut runner, &mut piercing, 0.33);
        assert!(piercing.first().is_some());
        runner.go_back(&start).expect("the start");
        piercing.look(&runner);
        assert_eq!(piercing.first(), None);
    }
}

/// A cloth hangs from a box in which its upper row is pinned, and which swings about z.
fn held_inside(pin: &str) -> Option<Pierced> {
    let mut runner = runner(&format!(
        r#"version = 1
        [[world.solids]]
        kind = "box"
        size = [1, 0.3, 0.3]
        position = [0, 0.5, 0]
        key_frames = [{{ time = 0.5, position = [0.3, 0.8, 0.2], rotation = {{ axis = [0, 0, 1],
            angle_deg = 30 }} }}, {{ time = 1, position = [-0.2, 0.5, 0] }}]
        [[bodies]]
        kind = "cloth"
        size = [9, 11]
        spacing = 0.1
        mass = 0.005
        stiffness = 100
        damping = 0.05
        [[pins]]
        set = "top"
        {pin}
        "#
    ));
    let mut piercing = Piercing::default();
    watch(&mut runner, &mut piercing, 1.5);
    piercing.first()
}

#[test]
fn a_solid_that_holds_a_cloth_inside_has_not_gone_through_it() {
    assert_eq!(held_inside("follow = 'box'"), None);
    // Pinned at rest, where the box moves across it.
    assert!(held_inside("").is_some());
}
