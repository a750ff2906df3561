//! Time of one step, in groups named `scene/size`.
//!
//! Each group has the simple kernel, the textbook and the compiled kernel, by instruction set,
//! precision and integrator.
//!
//! `cargo bench --bench step` reports elements per second, where an element is one spring evaluated
//! once: a substep of RK4 counts each spring four times. All run on one thread but what is named
//! `2-threads`. The group `terms` shows that unused features add no cost, the group `substance`
//! what a uniform material, bends and volumes cost beside alike springs, the group `touch` what a
//! radius of particles does, the group `scene` what steps of built-in scenes cost in which
//! something touches, the group `xpbd` what steps of XPBD cost.
//!
//! Scenes of more than 100,000 springs take part where a filter names them (`-- cloth/316`), or all
//! of them where the environment sets `MSD_LARGE`. `docs/measured/performance.md` has the figures
//! of `cargo bench --bench performance`.

mod baselines;

use baselines::forces::{Forces, Incidence, Motion};
use baselines::simple::Simple;
use baselines::textbook::Textbook;
use baselines::{terms, works};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group};
use msd::core::glam::{DMat3, DVec3};
use msd::core::{
    Bending, Elasticity, Friction, Instructions, Integrator, Material, Neighbours, Plane, Real,
    Scene, Settings, Shape, Simulation, Solid, Substance, Vector, World, shape,
};
use msd::run::Runner;
use msd::scene::{Precision, open, workloads};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::{Duration, Instant};

const SMALL: [&str; 5] = ["cloth/31", "cloth/100", "block/10", "block/20", "irregular/10000"];
const LARGE: [&str; 6] =
    ["cloth/316", "cloth/1000", "block/46", "block/100", "irregular/100000", "irregular/1000000"];

/// Explicit Euler gains energy for ever: nothing to time that stays the same.
const INTEGRATORS: [Integrator; 3] =
    [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4];

fn settings(integrator: Integrator) -> Settings {
    Settings { integrator, ..workloads::settings() }
}

/// How often each spring is evaluated in a step.
fn evaluations(settings: Settings) -> u64 {
    let per_substep = if settings.integrator == Integrator::Rk4 { 4 } else { 1 };
    // Velocity Verlet evaluates once more per step.
    let first = u64::from(settings.integrator == Integrator::VelocityVerlet);
    u64::from(settings.substeps) * per_substep + first
}

/// The works to measure: small ones, and large ones that are asked for.
fn names() -> impl Iterator<Item = &'static str> {
    let all = std::env::var_os("MSD_LARGE").is_some();
    let asked = move |name: &&str| all || std::env::args().any(|argument| argument.contains(name));
    SMALL.into_iter().chain(LARGE.into_iter().filter(asked))
}

fn steps(criterion: &mut Criterion) {
    for name in names() {
        let scene = works::scene(name);
        let mut group = criterion.benchmark_group(name);
        for integrator in INTEGRATORS {
            let settings = settings(integrator);
            group.throughput(Throughput::Elements(
                scene.springs.len() as u64 * evaluations(settings),
            ));
            bench_steps::<f32>(&mut group, &scene, (settings, Precision::F32));
            bench_steps::<f64>(&mut group, &scene, (settings, Precision::F64));
        }
        let settings = settings(Integrator::SymplecticEuler);
        group.throughput(Throughput::Elements(scene.springs.len() as u64 * evaluations(settings)));
        let mut textbook = Textbook::new(&scene, settings);
        group.bench_function("textbook/f32/symplectic-euler", |bencher| {
            bencher.iter(|| textbook.step());
        });
        bench_threads(&mut group, &scene, settings);
        bench_forces(&mut group, &scene);
    }
}

/// The simple kernel, and the compiled one with each set of instructions that there is.
fn bench_steps<R: Real>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    scene: &Scene,
    (settings, precision): (Settings, Precision),
) {
    let name = |kernel: &str| format!("{kernel}/{precision}/{}", settings.integrator);
    let mut simple = Simple::<R>::new(scene, settings);
    check_same(simple.clone(), scene, settings);
    group.bench_function(name("simple"), |bencher| bencher.iter(|| simple.step()));
    for instructions in Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best()) {
        let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
        simulation.set_instructions(instructions);
        group.bench_function(name(instructions.name()), |bencher| {
            bencher.iter(|| simulation.step().expect("stable"));
        });
    }
}

/// Rivals compute the same, except for the order of their sums: some roundings in two steps.
fn check_same<R: Real>(mut simple: Simple<R>, scene: &Scene, settings: Settings) {
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    for _ in 0..2 {
        simple.step();
        simulation.step().expect("stable");
    }
    let size = simulation.model().size();
    let close = 1e3 * R::EPSILON.to_f64() * size;
    for (here, there) in simulation.positions().zip(&simple.positions) {
        assert!((here - *there).to_f64().length() <= close, "other positions");
    }
}

fn bench_threads(group: &mut BenchmarkGroup<'_, WallTime>, scene: &Scene, settings: Settings) {
    let pool = pool(2);
    let mut simulation = Simulation::<f32>::new(scene, settings).expect("a valid scene");
    group.bench_function("2-threads/f32/symplectic-euler", |bencher| {
        bencher.iter_custom(|count| {
            pool.install(|| time(count, || simulation.step().expect("stable")))
        });
    });
}

fn time(count: u64, mut run: impl FnMut()) -> Duration {
    let start = Instant::now();
    (0..count).for_each(|_| run());
    start.elapsed()
}

/// Forces alone, by the two algorithms of the source report.
fn bench_forces(group: &mut BenchmarkGroup<'_, WallTime>, scene: &Scene) {
    let start = Simple::<f32>::new(scene, settings(Integrator::SymplecticEuler));
    let motion = Motion { positions: &start.positions, velocities: &start.velocities };
    let forces = Forces::<f32>::new(scene);
    let incidence = Incidence::new(&forces);
    let mut pulls = vec![Vector::ZERO; scene.particles.len()];
    let pulls = black_box(&mut pulls);
    group.throughput(Throughput::Elements(scene.springs.len() as u64));
    group.bench_function("forces/by-spring", |bencher| {
        bencher.iter(|| forces.add_springs(motion, pulls));
    });
    group.bench_function("forces/by-particle", |bencher| {
        bencher.iter(|| forces.add_springs_by_particle(&incidence, motion, pulls));
    });
}

/// The same cloth with one feature more each, in the compiled kernel.
fn bench_terms(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("terms");
    let settings = settings(Integrator::SymplecticEuler);
    for (name, scene) in terms::scenes("cloth/31") {
        let mut simulation = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
        let updates = scene.springs.len() as u64 * evaluations(settings);
        group.throughput(Throughput::Elements(updates));
        group.bench_function(name, |bencher| {
            bencher.iter(|| simulation.step().expect("stable"));
        });
    }
}

/// Bodies of alike springs and of a material, in the compiled kernel: shares, bends and volumes.
///
/// A uniform material should cost at most 5 % more than alike springs. What bends and volumes add
/// to it is their own time; the group `substance/bends` and `substance/volumes` counts them.
fn bench_substances(criterion: &mut Criterion) {
    let settings = settings(Integrator::SymplecticEuler);
    let solid = |poisson| Elasticity::Solid { young: 1e4, poisson };
    let limp =
        Elasticity::Sheet { warp: 100.0, weft: 100.0, shear: 37.5, bending: Bending::default() };
    let of = |size, elasticity| {
        let substance = Substance { elasticity, density: 1000.0, relaxation_time: 0.0 };
        shape::body(size, 0.1, &substance).expect("a body")
    };
    let alike = |size| {
        let material = Material { mass: 1.0, stiffness: 1000.0, damping: 0.0 };
        shape::lattice(size, Neighbours::All, 0.1, material).expect("a body")
    };
    let (cloth, block) = ([100, 100, 1], [20, 20, 20]);
    let mut group = criterion.benchmark_group("substance");
    for (name, part) in [
        ("cloth/alike", alike(cloth)),
        ("cloth/uniform", of(cloth, limp)),
        ("bends/cloth", of(cloth, Elasticity::sheet(1e4, 0.01))),
        ("block/alike", alike(block)),
        ("block/uniform", of(block, solid(0.25))),
        ("volumes/positive", of(block, solid(0.45))),
        ("volumes/negative", of(block, solid(0.0))),
    ] {
        let elements = match name.split('/').next() {
            Some("bends") => part.bends.len(),
            Some("volumes") => part.volumes.len(),
            _ => part.springs.len(),
        };
        let mut simulation =
            Simulation::<f32>::new(&Scene::of("body", part), settings).expect("a valid scene");
        group.throughput(Throughput::Elements(elements as u64 * evaluations(settings)));
        group.bench_function(name, |bencher| {
            bencher.iter(|| simulation.step().expect("stable"));
        });
    }
}

/// Makes the cloth, about to fall on a ball and the floor, or at rest far from anything.
fn touching_cloth(falls: bool, touches: bool) -> Scene {
    let material = Material { mass: 4e-4, stiffness: 60.0, damping: 0.01 };
    let mut part = shape::cloth([100, 100], 0.02, material).expect("a cloth");
    part.place(DMat3::from_rotation_x(1.5), DVec3::ZERO);
    let mut scene = Scene::default();
    scene.add("cloth", part);
    if falls {
        let friction = Friction::Coulomb(0.5);
        scene.planes.push(Plane { normal: DVec3::Y, offset: -1.0, restitution: 0.0, friction });
        let ball = Solid::new(Shape::Sphere { radius: 0.15 });
        scene.solids.push(Solid { position: DVec3::Y * -0.8, friction, ..ball });
    } else {
        scene.world = World { gravity: DVec3::ZERO, ..scene.world };
    }
    if touches {
        scene.shells = workloads::shells(&scene, 0.002, 0.5);
    }
    scene
}

/// A cloth of 100 x 100 particles without and with a thickness: flat, and as it lies crumpled over
/// a ball. The thickness should cost at most 5 % of the flat one. And three small cloths on a ball,
/// whose frame of 1/60 s should take at most a fiftieth of that.
fn bench_touches(criterion: &mut Criterion) {
    let settings = Settings { substeps: 12, ..settings(Integrator::SymplecticEuler) };
    let drape = Settings { substeps: 5, integrator: Integrator::VelocityVerlet, ..settings };
    let mut group = criterion.benchmark_group("touch");
    for (name, scene, settings, falling) in [
        ("flat/bare", touching_cloth(false, false), settings, 0),
        ("flat/touch", touching_cloth(false, true), settings, 0),
        ("crumpled/bare", touching_cloth(true, false), settings, 90),
        ("crumpled/touch", touching_cloth(true, true), settings, 90),
        ("drape/three", works::scene("drape/13"), drape, 60),
    ] {
        let mut simulation = Simulation::<f32>::new(&scene, settings).expect("a valid scene");
        (0..falling).for_each(|_| simulation.step().expect("stable"));
        group.bench_function(name, |bencher| {
            bencher.iter(|| simulation.step().expect("stable"));
        });
    }
}

/// A step of built-in scenes two seconds after their start: what lies, falls and touches there. A
/// block of a thousand particles that lies on a plane from the start is among them.
fn bench_scenes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("scene");
    let settings = settings(Integrator::VelocityVerlet);
    let rest = Runner::new(&works::scene("rest/10"), settings, Precision::F32);
    let built_in = ["dice", "drape", "pile", "stairs"];
    let opened = built_in.map(|name| (name, Runner::open(&open(name).expect("a built-in scene"))));
    for (name, runner) in [("rest", rest)].into_iter().chain(opened) {
        let mut runner = runner.expect("a valid scene");
        (0..120).for_each(|_| runner.step().expect("stable"));
        group.bench_function(name, |bencher| {
            bencher.iter(|| runner.step().expect("stable"));
        });
    }
}

/// A step of XPBD: a cloth that swings, and a block that spins and bounces on planes.
fn bench_xpbd(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("xpbd");
    let jelly = open("jelly").expect("a built-in scene").scene;
    for (name, scene) in [("cloth/31", works::scene("cloth/31")), ("jelly", jelly)] {
        let settings = settings(Integrator::Xpbd);
        group.throughput(Throughput::Elements(scene.springs.len() as u64 * evaluations(settings)));
        for precision in [Precision::F32, Precision::F64] {
            let mut runner = Runner::new(&scene, settings, precision).expect("a valid scene");
            group.bench_function(format!("{name}/{precision}"), |bencher| {
                bencher.iter(|| runner.step().expect("stable"));
            });
        }
    }
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = steps, bench_terms, bench_substances, bench_touches, bench_scenes, bench_xpbd
}

fn main() {
    let alone = ThreadPoolBuilder::new().num_threads(1).build_global();
    alone.expect("nobody has made a pool yet");
    benches();
    Criterion::default().configure_from_args().final_summary();
}
