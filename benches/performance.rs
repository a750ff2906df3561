//! Speeds of the kernels, measured here and now for `docs/measured/performance.md`.
//!
//! Rewrites the tables between the marks of the page.
//!
//! `cargo bench --bench performance` takes about ten minutes; `-- threads terms` fills these tables
//! only; `-- --test` runs all but the large scenes once and writes nothing.

mod baselines;
mod measure;

use baselines::{terms, works};
use measure::memory::Memory;
use measure::race::{Patience, Rival, Speed, race};
use measure::results::{Results, in_words, of};
use measure::{asked, frames, machine, memory, rivals};
use msd::core::{Instructions, Integrator, Scene};
use rayon::ThreadPoolBuilder;
use std::fmt::Write;
use std::path::Path;

const WORKS: [&str; 10] = [
    "cloth/31",
    "cloth/100",
    "cloth/316",
    "block/10",
    "block/20",
    "block/46",
    "block/100",
    "irregular/10000",
    "irregular/100000",
    "irregular/1000000",
];
/// What a test runs: a scene of each kind.
const TEST_WORKS: [&str; 3] = ["cloth/31", "block/10", "irregular/2000"];
/// Springs above which only the simple kernel and the best compiled one run, in f32.
const HUGE: usize = 5_000_000;
/// For each that takes part in a race, seconds.
const PATIENCE: f64 = 1.0;

/// Measures, and makes the text of its table.
type Section = fn(&mut Bench) -> String;

const SECTIONS: [(&str, Section); 9] = [
    ("machine", |_| machine::in_words()),
    ("kernels", kernels),
    ("integrators", integrators),
    ("implicit", implicit),
    ("terms", features),
    ("frames", frames),
    ("threads", threads),
    ("memory", memories),
    ("asked", |bench| asked::table(&bench.results, &bench.memories)),
];

struct Bench {
    works: &'static [&'static str],
    patience: Patience,
    results: Results,
    memories: Vec<(&'static str, Memory)>,
}

impl Bench {
    fn race(&self, rivals: Vec<Rival<'_>>) -> Vec<Speed> {
        race(rivals, self.patience)
    }
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let alone = ThreadPoolBuilder::new().num_threads(1).build_global();
    alone.expect("nobody has made a pool yet");
    if let [argument, work] = &arguments[..]
        && argument == memory::ARGUMENT
    {
        memory::run(work);
        return Ok(());
    }
    let testing = arguments.iter().any(|argument| argument == "--test");
    let mut bench = Bench {
        works: if testing { &TEST_WORKS } else { &WORKS },
        patience: if testing { Patience::Once } else { Patience::Seconds(PATIENCE) },
        results: Results::default(),
        memories: Vec::new(),
    };
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/measured/performance.md");
    let everything = testing || arguments.is_empty();
    for (name, section) in SECTIONS {
        if !everything && !arguments.iter().any(|argument| argument == name) {
            continue;
        }
        let table = section(&mut bench);
        eprintln!("{name}\n{table}");
        if !testing {
            let text = std::fs::read_to_string(&page)?;
            let put = xtask::marks::put(&text, name, &table);
            let put = put.unwrap_or_else(|| panic!("the page has no marks for {name}"));
            std::fs::write(&page, put)?;
        }
    }
    Ok(())
}

/// The best that this machine has, by name.
fn best() -> &'static str {
    Instructions::best().name()
}

/// How many times as fast as the simple kernel one is.
fn ratio(speeds: &[Speed], name: &str) -> String {
    let (speed, simple) = (of(speeds, name), of(speeds, "simple"));
    let ratio = speed.zip(simple).map(|(speed, simple)| speed.best / simple.best);
    ratio.map_or("-".into(), |ratio| format!("{ratio:.1}"))
}

fn kernels(bench: &mut Bench) -> String {
    let mut table = "| scene | springs | | textbook | simple | plain | avx2 | avx512 | \
                     best / simple |\n|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for &work in bench.works {
        let scene = works::scene(work);
        let springs = scene.springs.len();
        let singles = bench.race(kernel_rivals(&scene, true));
        let huge = HUGE < springs;
        let doubles = if huge { vec![] } else { bench.race(kernel_rivals(&scene, false)) };
        for (class, speeds) in [("f32", singles), ("f64", doubles)] {
            if speeds.is_empty() {
                continue;
            }
            let names = ["textbook", "simple", "plain", "avx2", "avx512"];
            let cells = names.map(|name| in_words(of(&speeds, name))).join(" | ");
            let ratio = ratio(&speeds, best());
            let _ = writeln!(table, "| {work} | {springs} | {class} | {cells} | {ratio} |");
            bench.results.add(work, class, &speeds);
        }
    }
    table
}

fn kernel_rivals(scene: &Scene, single: bool) -> Vec<Rival<'static>> {
    let settings = rivals::settings(Integrator::SymplecticEuler);
    let huge = HUGE < scene.springs.len();
    let chosen = |&set: &Instructions| set <= Instructions::best();
    let chosen = Instructions::ALL.into_iter().filter(chosen);
    let sets = chosen.filter(|&set| !huge || set == Instructions::best());
    if single {
        let simple = [rivals::simple::<f32>(scene, settings), rivals::textbook(scene, settings)];
        let compiled = sets.map(|set| rivals::kernel::<f32>(scene, settings, set));
        simple.into_iter().chain(compiled).collect()
    } else {
        let compiled = sets.map(|set| rivals::kernel::<f64>(scene, settings, set));
        core::iter::once(rivals::simple::<f64>(scene, settings)).chain(compiled).collect()
    }
}

fn integrators(bench: &mut Bench) -> String {
    let mut table = "| scene | method | f32: simple | kernel | ratio | f64: simple | kernel | \
                     ratio |\n|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for work in ["cloth/31", "block/10"] {
        let scene = works::scene(work);
        for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4]
        {
            let (settings, set) = (rivals::settings(integrator), Instructions::best());
            let single = vec![
                rivals::simple::<f32>(&scene, settings),
                rivals::kernel::<f32>(&scene, settings, set),
            ];
            let double = vec![
                rivals::simple::<f64>(&scene, settings),
                rivals::kernel::<f64>(&scene, settings, set),
            ];
            let [single, double] = [single, double].map(|rivals| bench.race(rivals));
            let cells = [&single, &double].map(|speeds| {
                let speed = |name| in_words(of(speeds, name));
                format!("{} | {} | {}", speed("simple"), speed(best()), ratio(speeds, best()))
            });
            let _ = writeln!(table, "| {work} | {integrator} | {} |", cells.join(" | "));
            bench.results.add(work, integrator.name(), &single);
        }
    }
    table
}

fn implicit(bench: &mut Bench) -> String {
    let scene = works::scene("cloth/31");
    let yardstick = rivals::simple::<f32>(&scene, rivals::settings(Integrator::SymplecticEuler));
    let frame = Rival { name: "simple step".into(), updates: 1.0, run: yardstick.run };
    let rivals = vec![
        frame,
        rivals::backward_euler::<f32>(&scene, "f32"),
        rivals::backward_euler::<f64>(&scene, "f64"),
    ];
    let speeds = bench.race(rivals);
    bench.results.add("cloth/31", "backward-euler", &speeds);
    let step = of(&speeds, "simple step").map_or(f64::NAN, |speed| speed.best);
    let mut table =
        "| precision | ms per frame | simple steps of 12 substeps | the first version |\n\
         |---|---|---|---|\n"
            .to_owned();
    for (name, first) in asked::FIRST_BACKWARD_EULER {
        let Some(speed) = of(&speeds, name) else { continue };
        let (ms, steps) = (1e3 / speed.best, step / speed.best);
        let _ = writeln!(table, "| {name} | {ms:.2} | {steps:.1} | {first:.1} |");
    }
    table
}

fn features(bench: &mut Bench) -> String {
    let works: &[_] = &["cloth/31", "block/20", "cloth/316"];
    let works = if bench.patience == Patience::Once { &works[..1] } else { works };
    let races: Vec<Vec<Speed>> = works.iter().map(|work| bench.race(term_rivals(work))).collect();
    let mut table = format!("| | {} |\n|---|{}\n", works.join(" | "), "---|".repeat(works.len()));
    for name in races[0].iter().map(|speed| speed.name.as_str()) {
        let cells = races.iter().map(|speeds| {
            let (bare, speed) = (speeds[0].best, of(speeds, name).map_or(f64::NAN, |s| s.best));
            match name {
                "bare" => format!("{:.2} G/s", 1e-9 * bare),
                _ => format!("{:+.0} %", 100.0 * (bare / speed - 1.0)),
            }
        });
        let _ = writeln!(table, "| {name} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
    table
}

fn frames(bench: &mut Bench) -> String {
    let works: &[_] = &["cloth/31", "cloth/100", "block/20"];
    let works = if bench.patience == Patience::Once { &works[..1] } else { works };
    frames::table(works, bench.patience)
}

fn term_rivals(work: &str) -> Vec<Rival<'static>> {
    let settings = rivals::settings(Integrator::SymplecticEuler);
    let rival = |(name, scene): (&str, Scene)| {
        let rival = rivals::kernel::<f32>(&scene, settings, Instructions::best());
        Rival { name: name.into(), ..rival }
    };
    terms::scenes(work).into_iter().map(rival).collect()
}

fn threads(bench: &mut Bench) -> String {
    let pools = [1, 2].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
    });
    let mut table =
        "| scene | springs | 1 thread | 2 threads | ratio |\n|---|---|---|---|---|\n".to_owned();
    for &work in bench.works {
        let scene = works::scene(work);
        let springs = scene.springs.len();
        if HUGE < springs {
            continue;
        }
        let settings = rivals::settings(Integrator::SymplecticEuler);
        let rivals = pools.iter().map(|pool| rivals::threaded(&scene, settings, pool)).collect();
        let speeds = bench.race(rivals);
        let cells = ["1", "2"].map(|name| in_words(of(&speeds, name))).join(" | ");
        let ratio = speeds[1].best / speeds[0].best;
        let _ = writeln!(table, "| {work} | {springs} | {cells} | {ratio:.2} |");
        bench.results.add(work, "threads", &speeds);
    }
    table
}

fn memories(bench: &mut Bench) -> String {
    let works: &[_] =
        &["block/100", "own-block/46", "cloth/316", "irregular/100000", "irregular/1000000"];
    let works = if bench.patience == Patience::Once { &["own-block/10"] } else { works };
    let mut table =
        "| scene | springs | held | per spring | most held |\n|---|---|---|---|---|\n".to_owned();
    for &work in works {
        let Some(memory) = memory::measure(work) else { continue };
        let Memory { springs, held, most } = memory;
        let (each, held, most) = (held / springs as f64, 1e-6 * held, 1e-6 * most);
        let _ = writeln!(
            table,
            "| {work} | {springs} | {held:.1} MB | {each:.0} bytes | {most:.1} MB |"
        );
        bench.memories.push((work, memory));
    }
    table
}
