//! Studies of four scenes, measured here and now for `docs/measured/trade.md`.
//!
//! Rewrites the tables between the marks of the page, and its figures.
//!
//! `cargo bench --bench trade` takes some minutes; `-- --test` studies one small scene and writes
//! nothing.

use msd::core::{Integrator, Material, Scene, shape};
use msd::scene::{BUILTINS, Loaded, Precision};
use msd::study::Study;
use msd::study::choice::FRAME;
use msd::study::conduct::{Plan, study};
use msd::study::ladder::PRECISIONS;
use msd::study::live_error::calibrate;
use msd::study::monitor::Progress;
use msd::study::quantity::{estimate, rounded};
use msd::study::terms::terms;
use msd::study::trial::Trial;
use std::fmt::Write;
use std::path::Path;
use xtask::stability_table::{euler_steps, stability_table};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Scene, time simulated and time to spend, seconds.
const STUDIES: [(&str, f64, f64); 4] =
    [("cloth", 1.0, 30.0), ("jelly", 2.0, 60.0), ("rope", 1.0, 20.0), ("bunny", 1.0, 60.0)];

fn main() -> Result<()> {
    // A cost is that of one thread.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    alone.expect("nobody has made a pool yet");
    if std::env::args().any(|argument| argument == "--test") {
        let plan = Plan { budget: 1.0, duration: 0.2, fresh: true, ..Plan::default() };
        let (studied, _) = study(&msd::scene::open("chain")?, plan, &mut ())?;
        println!("{}\n{}", front(&studied), orders(&[studied]));
        return Ok(());
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = root.join("docs/measured/trade.md");
    let mut text = std::fs::read_to_string(&page)?;
    let mut studies = Vec::new();
    for (name, duration, budget) in STUDIES {
        let plan = Plan { duration, budget, ..Plan::default() };
        let mut print = |p: Progress| eprintln!("{name}: {} done, {}", p.done, p.now);
        let (studied, _) = study(&scene(root, name)?, plan, &mut print)?;
        let figure = root.join(format!("docs/measured/trade/{name}.svg"));
        std::fs::write(figure, msd::report::svg(&studied))?;
        text = put(&text, name, &front(&studied));
        std::fs::write(&page, &text)?;
        studies.push(studied);
    }
    let Study { machine, date, .. } = &studies[0];
    text = put(&text, "machine", &format!("Measured on {date}: {machine}.\n"));
    text = put(&text, "design", &beside_the_design(&studies[0]));
    text = put(&text, "orders", &orders(&studies));
    text = put(&text, "precision", &precisions(&studies));
    text = put(&text, "audit", &audits(&studies[0]));
    std::fs::write(&page, &text)?;
    text = put(&text, "stability", &stabilities()?);
    text = put(&text, "terms", &all_terms()?);
    std::fs::write(&page, &text)?;
    text = put(&text, "calibration", &calibrations()?);
    std::fs::write(page, text)?;
    Ok(())
}

fn scene(root: &Path, name: &str) -> Result<Loaded> {
    let file = root.join(format!("docs/measured/trade/{name}.toml"));
    Ok(if file.exists() { msd::scene::load(&file)? } else { msd::scene::open(name)? })
}

/// Puts a table between `<!-- begin NAME -->` and `<!-- end NAME -->`.
fn put(text: &str, name: &str, table: &str) -> String {
    let put = xtask::marks::put(text, name, table);
    put.unwrap_or_else(|| panic!("docs/measured/trade.md has no marks for {name}"))
}

fn front(study: &Study) -> String {
    let mut table = format!("> {}\n\n", study.words);
    table += "| method | setting | precision | per frame | error | of the size |\n";
    table += "|---|---|---|---|---|---|\n";
    for row in study.front() {
        let Trial { choice, cost, .. } = &study.trials[row];
        let error = study.trials[row].error();
        let _ = writeln!(
            table,
            "| {} | {} | {} | {} | {} | {} |",
            choice.integrator,
            choice.fineness(),
            choice.precision,
            estimate(cost * FRAME, "s"),
            estimate(error, "m"),
            rounded(error / study.size, 2),
        );
    }
    table
}

/// The figures of the design beside what this machine measures: cost over that of Verlet.
fn beside_the_design(study: &Study) -> String {
    // Method, substeps, cost over that of velocity Verlet at 4 substeps, error: design, section 6.
    let design = [
        (Integrator::SymplecticEuler, 4, 0.0040 / 0.0042, 6.2e-4),
        (Integrator::VelocityVerlet, 4, 1.0, 5.1e-6),
        (Integrator::Rk4, 2, 0.0085 / 0.0042, 3.5e-7),
        (Integrator::BackwardEuler, 1, 0.0147 / 0.0042, 2.4e-3),
        (Integrator::ImplicitMidpoint, 1, 0.0106 / 0.0042, 9.4e-5),
        (Integrator::Xpbd, 4, 0.0152 / 0.0042, 2.7e-3),
    ];
    let find = |integrator, substeps: u32| {
        study.of(integrator).find(|trial| {
            trial.choice.settings().substeps == substeps && trial.choice.precision == Precision::F64
        })
    };
    let mut table =
        "| method | substeps | cost / Verlet's: design | here | error / size: design | here |\n\
                     |---|---|---|---|---|---|\n"
            .to_owned();
    let Some(verlet) = find(Integrator::VelocityVerlet, 4) else { return table };
    for (integrator, substeps, cost, error) in design {
        let Some(trial) = find(integrator, substeps) else { continue };
        let (here, wrong) = (trial.cost / verlet.cost, trial.error() / study.size);
        let _ = writeln!(
            table,
            "| {integrator} | {substeps} | {} | {} | {error:.1e} | {wrong:.1e} |",
            rounded(cost, 2),
            rounded(here, 2)
        );
    }
    table
}

/// The order of convergence of each method in each scene.
fn orders(studies: &[Study]) -> String {
    let names: Vec<&str> = studies.iter().map(|study| study.scene.as_str()).collect();
    let mut table = format!("| method | {} |\n|---|", names.join(" | "));
    table += &"---|".repeat(names.len());
    table.push('\n');
    for integrator in Integrator::ALL.into_iter().filter(|method| !method.is_adaptive()) {
        let seen: Vec<String> = studies.iter().map(|study| order(study, integrator)).collect();
        let _ = writeln!(table, "| {integrator} | {} |", seen.join(" | "));
    }
    table
}

/// The median slope of error over substeps, above the error of rounding and of the reference.
fn order(study: &Study, integrator: Integrator) -> String {
    let floor = 30.0 * study.reference.uncertainty;
    let useful = |trial: &&Trial| {
        let error = trial.error();
        trial.choice.precision == Precision::F64 && floor < error && error < 0.1 * study.size
    };
    let trials: Vec<&Trial> = study.of(integrator).filter(useful).collect();
    let slope = |pair: &[&Trial]| {
        let finer = f64::from(pair[1].choice.settings().substeps)
            / f64::from(pair[0].choice.settings().substeps);
        (pair[0].error() / pair[1].error()).log2() / finer.log2()
    };
    let mut slopes: Vec<f64> = trials.windows(2).map(slope).collect();
    slopes.sort_by(f64::total_cmp);
    slopes.get(slopes.len() / 2).map_or("-".into(), |slope| format!("{slope:.1}"))
}

/// Best error and cost of velocity Verlet in both precisions.
fn precisions(studies: &[Study]) -> String {
    let mut table = "| scene | least error in f32 / size | in f64 | time of f64 / f32 |\n\
                     |---|---|---|---|\n"
        .to_owned();
    for study in studies {
        let of = |precision| study.trials.iter().filter(move |t| t.choice.precision == precision);
        let [least_32, least_64] = PRECISIONS
            .map(|precision| of(precision).map(Trial::error).fold(f64::INFINITY, f64::min));
        let twin = |trial: &Trial| {
            let choice = trial.choice;
            let same = |other: &&Trial| {
                other.choice.integrator == choice.integrator
                    && other.choice.fineness == choice.fineness
            };
            of(Precision::F64).find(same).map(|other| other.cost / trial.cost)
        };
        let verlet = |trial: &&Trial| trial.choice.integrator == Integrator::VelocityVerlet;
        let mut ratios: Vec<f64> = of(Precision::F32).filter(verlet).filter_map(twin).collect();
        ratios.sort_by(f64::total_cmp);
        let ratio = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
        let size = study.size;
        let _ = writeln!(
            table,
            "| {} | {:.1e} | {:.1e} | {} |",
            study.scene,
            least_32 / size,
            least_64 / size,
            rounded(ratio, 2)
        );
    }
    table
}

fn audits(study: &Study) -> String {
    let mut table =
        "| choice | stiffness | damping ratio | period |\n|---|---|---|---|\n".to_owned();
    for audit in &study.audit {
        let _ = writeln!(
            table,
            "| {} | {:.1} % | {:.1} % | {:+.2} % |",
            audit.choice,
            100.0 * audit.stiffness,
            100.0 * audit.damping,
            100.0 * audit.period
        );
    }
    table
}

fn all_terms() -> Result<String> {
    let mut table =
        "| scene | without | changes the answer by | saves |\n|---|---|---|---|\n".to_owned();
    for name in ["jelly", "cloth", "teapot", "bunny"] {
        for row in terms(&msd::scene::open(name)?, 1.0, &mut ())? {
            let change = row.relative.map_or("it diverges".into(), |part| {
                format!("{} % of the size", rounded(100.0 * part, 2))
            });
            let saves = row.cost_percent.map_or("-".into(), |percent| format!("{percent:.0} %"));
            let _ = writeln!(table, "| {name} | {} | {change} | {saves} |", row.term);
        }
    }
    Ok(table)
}

fn calibrations() -> Result<String> {
    let mut table =
        "| scene | from t, s | estimated | true | estimated / true |\n|---|---|---|---|---|\n"
            .to_owned();
    for builtin in &BUILTINS {
        let loaded = msd::scene::open(builtin.name)?;
        // Of scenes in which things touch, whose references take long, `drape` is enough.
        if !loaded.scene.shells.is_empty() && builtin.name != "drape" {
            continue;
        }
        for c in calibrate(&loaded, &[0.0, 1.0, 2.0], 30)? {
            let (estimated, right) = (estimate(c.estimated, "m"), estimate(c.true_error, "m"));
            let ratio = rounded(c.estimated / c.true_error, 2);
            let _ = writeln!(
                table,
                "| {} | {:.1} | {estimated} | {right} | {ratio} |",
                builtin.name, c.start
            );
        }
    }
    Ok(table)
}

fn stabilities() -> Result<String> {
    let material = Material { mass: 1.0, stiffness: 1.0, damping: 0.0 };
    let scene = Scene::of("cloth", shape::cloth([31, 31], 1.0, material)?);
    let table = stability_table(&scene, euler_steps(&scene)?)?;
    Ok(format!("```text\n{}\n```\n", table.text().trim_end()))
}
