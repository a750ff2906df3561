//! Speeds of a graphics card beside those of the processor, for `docs/measured/gpu.md`.
//!
//! `cargo bench --bench gpu` measures the first adapter and rewrites the tables between the marks
//! of the page; `-- NAME` measures the adapter of that name, and `-- --test` runs small scenes once
//! and writes nothing.

#[path = "baselines/works.rs"]
mod works;

#[path = "measure"]
mod measure {
    pub mod compiler;
    pub mod machine;
    pub mod race;
    pub mod threaded;
}

use measure::machine;
use measure::race::{Patience, Rival, Speed, race, times};
use measure::threaded::{settings, threaded, updates};
use msd::core::{Integrator, Scene, Simulation};
use msd_gpu::{Device, Ensemble, GpuSimulation, Manner, Spelling, Verdict, probe};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fmt::Write;
use std::path::Path;

const WORKS: [&str; 5] = ["cloth/31", "cloth/316", "cloth/1000", "block/46", "block/100"];
/// Springs above which a device in software is not asked: it takes minutes.
const MOST_IN_SOFTWARE: usize = 1_500_000;
/// What a test runs.
const TEST_WORKS: [&str; 1] = ["cloth/31"];
/// Sides of the cloths among which the smallest is found from which a device pays.
const SIDES: [usize; 8] = [31, 50, 75, 100, 150, 200, 316, 500];
const TEST_SIDES: [usize; 1] = [31];
/// Cloths of 31 x 31 in an ensemble.
const INSTANCES: [usize; 4] = [1, 16, 264, 1056];
const TEST_INSTANCES: [usize; 1] = [2];

/// Measures, and makes the text of its table.
type Section = fn(&Bench) -> String;

struct Bench {
    device: Device,
    manner: Manner,
    patience: Patience,
    testing: bool,
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let testing = arguments.iter().any(|argument| argument == "--test");
    let name = arguments.iter().find(|argument| !argument.starts_with('-'));
    let device = match pollster::block_on(Device::open(name.map_or("", |name| name))) {
        Ok(device) => device,
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
            println!("SKIPPED: {error}");
            return Ok(());
        }
    };
    let verdict = pollster::block_on(probe(&device)).expect("a device that computes");
    let Verdict::SameBits(manner) = verdict else {
        println!("SKIPPED: {} has {verdict}", device.name());
        return Ok(());
    };
    let patience = if testing { Patience::Once } else { Patience::Seconds(1.0) };
    let bench = Bench { device: device.with_manner(manner), manner, patience, testing };
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/measured/gpu.md");
    let sections: [(&str, Section); 4] =
        [("machine", about), ("kernels", kernels), ("ensembles", ensembles), ("costs", costs)];
    for (name, section) in sections {
        let table = section(&bench);
        eprintln!("{name}\n{table}");
        if !testing {
            let text = std::fs::read_to_string(&page)?;
            let put = xtask::marks::put(&text, name, &table);
            std::fs::write(&page, put.unwrap_or_else(|| panic!("no marks for {name}")))?;
        }
    }
    Ok(())
}

fn about(bench: &Bench) -> String {
    let info = bench.device.info();
    let verdict = Verdict::SameBits(bench.manner);
    format!(
        "{}\n\n{}, {}, driver {}: {verdict}.\n",
        machine::in_words(),
        info.name,
        info.backend,
        info.driver_info
    )
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads")
}

impl Bench {
    /// A device that steps a scene, with sums in a spelling.
    fn rival(
        &self,
        scene: &Scene,
        integrator: Integrator,
        (name, spelling): (&str, Spelling),
    ) -> Option<Rival<'static>> {
        let manner = Manner { spelling, ..self.manner };
        let simulation = Simulation::new(scene, settings(integrator)).expect("a valid scene");
        let device = self.device.clone().with_manner(manner);
        let gpu = pollster::block_on(GpuSimulation::new(&device, &simulation));
        let mut gpu = match gpu {
            Ok(gpu) => gpu,
            Err(error) => {
                eprintln!("{error}");
                return None;
            }
        };
        let run = move |steps| gpu.compute(&simulation, steps).expect("a device that computes");
        let updates = updates(scene, settings(integrator));
        Some(Rival { name: name.into(), updates, run: Box::new(run) })
    }

    fn is_too_much(&self, scene: &Scene) -> bool {
        let is_in_software = self.device.info().device_type == wgpu::DeviceType::Cpu;
        is_in_software && MOST_IN_SOFTWARE < scene.springs.len()
    }
}

fn kernels(bench: &Bench) -> String {
    let mut table =
        "| scene | springs | method | one core | all cores | exact | plain | hidden |\n\
                     |---|---|---|---|---|---|---|---|\n"
            .to_owned();
    let pools = [pool(1), pool(0)];
    for &work in if bench.testing { &TEST_WORKS[..] } else { &WORKS } {
        let scene = works::scene(work);
        for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
            let names = ["one core", "all cores"];
            let named = |(pool, name): (_, &str)| Rival {
                name: name.into(),
                ..threaded(&scene, settings(integrator), pool)
            };
            let mut all: Vec<Rival<'_>> = pools.iter().zip(names).map(named).collect();
            let forms = [
                ("exact", Spelling::Exact),
                ("plain", Spelling::Plain),
                ("hidden", Spelling::Hidden),
            ];
            let forms = forms.into_iter().filter(|_| !bench.is_too_much(&scene));
            let of_device = forms.filter_map(|form| bench.rival(&scene, integrator, form));
            all.extend(of_device);
            let speeds = race(all, bench.patience);
            let names = ["one core", "all cores", "exact", "plain", "hidden"];
            let cells = names.map(|name| in_words(&speeds, name)).join(" | ");
            let springs = scene.springs.len();
            let _ = writeln!(table, "| {work} | {springs} | {integrator} | {cells} |");
        }
    }
    table
}

/// The best speed of a name and its median, G/s.
fn in_words(speeds: &[Speed], name: &str) -> String {
    let found = speeds.iter().find(|speed| speed.name == name);
    let words = |speed: &Speed| format!("{:.2} ({:.2})", speed.best / 1e9, speed.median / 1e9);
    found.map_or("-".to_owned(), words)
}

fn ensembles(bench: &Bench) -> String {
    let mut table =
        "| cloths of 31 x 31 | a step of all | G/s | steps of one core in that time |\n\
                     |---|---|---|---|\n"
            .to_owned();
    let scene = works::scene("cloth/31");
    let (method, alone) = (Integrator::SymplecticEuler, pool(1));
    for &count in if bench.testing { &TEST_INSTANCES[..] } else { &INSTANCES } {
        let simulation = Simulation::new(&scene, settings(method)).expect("a valid scene");
        let mut all = vec![simulation; count];
        let ensemble = pollster::block_on(Ensemble::new(&bench.device, &all));
        let mut ensemble = ensemble.expect("scenes for a device");
        let run = move |steps| {
            ensemble.advance(&mut all, steps).expect("a device that computes");
        };
        let mut both = [
            Rival { name: String::new(), updates: 1.0, run: Box::new(run) },
            threaded(&scene, settings(method), &alone),
        ];
        let [step, of_core] = best(&mut both, bench.patience);
        let speed = count as f64 * updates(&scene, settings(method)) / step / 1e9;
        let ms = step * 1e3;
        let _ = writeln!(table, "| {count} | {ms:.2} ms | {speed:.2} | {:.1} |", step / of_core);
    }
    table
}

/// The best time of a step of each, seconds.
fn best<const N: usize>(rivals: &mut [Rival<'_>; N], patience: Patience) -> [f64; N] {
    let times = times(rivals, patience);
    core::array::from_fn(|at| times[at].iter().copied().fold(f64::INFINITY, f64::min))
}

fn costs(bench: &Bench) -> String {
    let method = Integrator::SymplecticEuler;
    let mut table = "| | |\n|---|---|\n".to_owned();
    let chain = works::scene("cloth/31");
    let rival = bench.rival(&chain, method, ("exact", Spelling::Exact)).expect("a small scene");
    let [step] = best(&mut [rival], bench.patience);
    let dispatches = f64::from(settings(method).substeps) + 2.0;
    let _ = writeln!(table, "| a dispatch of cloth/31 | {:.1} µs |", step / dispatches * 1e6);
    let large = works::scene(if bench.testing { "cloth/31" } else { "cloth/316" });
    let mut simulation = Simulation::new(&large, settings(method)).expect("a valid scene");
    let gpu = pollster::block_on(GpuSimulation::new(&bench.device, &simulation));
    let mut gpu = gpu.expect("a scene for a device");
    let run = move |steps| {
        for _ in 0..steps {
            gpu.advance(&mut simulation, 1).expect("stable");
        }
    };
    let alone = bench.rival(&large, method, ("exact", Spelling::Exact)).expect("a scene");
    let whole = Rival { name: String::new(), updates: 1.0, run: Box::new(run) };
    let [whole, alone] = best(&mut [whole, alone], bench.patience);
    let more = (whole - alone).max(0.0) * 1e3;
    let _ = writeln!(table, "| upload and read-back of cloth/316 in a step | {more:.2} ms |");
    let _ = writeln!(table, "| the smallest cloth from which the device pays | {} |", pays(bench));
    table
}

/// The smallest cloth that a device steps faster than one core, in batches without read-back.
fn pays(bench: &Bench) -> String {
    let (method, alone) = (Integrator::SymplecticEuler, pool(1));
    for &side in if bench.testing { &TEST_SIDES[..] } else { &SIDES } {
        let scene = works::scene(&format!("cloth/{side}"));
        let Some(device) = bench.rival(&scene, method, ("exact", Spelling::Exact)) else {
            continue;
        };
        let core = threaded(&scene, settings(method), &alone);
        let [device, core] = best(&mut [device, core], bench.patience);
        if device < core {
            return format!("{side} x {side}, {:.1} times one core", core / device);
        }
    }
    "none of those tried".to_owned()
}
