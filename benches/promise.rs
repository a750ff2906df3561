//! The promise of tuning, checked on all built-in and many generated scenes.
//!
//! The error delivered is at most the error asked for, at no more than 1.5 times the cost of the
//! best setting there is.
//!
//! `cargo bench --bench promise` takes some minutes; `-- --scenes N` takes N generated scenes
//! instead of 200, and `-- --test` a few, to see that it runs. Twenty more have two bodies that
//! meet.

use msd::scene::BUILTINS;
use msd::study::choice::Choice;
use xtask::promise::{Case, keep, random_scene, touching_scene};

/// Errors asked for, as fractions of the size, in turn.
const ASKED: [f64; 3] = [1e-2, 1e-3, 1e-4];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A cost is that of one thread.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    alone.expect("nobody has made a pool yet");
    let arguments: Vec<String> = std::env::args().collect();
    let brief = arguments.iter().any(|argument| argument == "--test");
    let given = arguments.iter().position(|argument| argument == "--scenes");
    let given = given.and_then(|at| arguments.get(at + 1)).map(|count| count.parse());
    let count: usize = given.transpose()?.unwrap_or(if brief { 3 } else { 200 });
    let mut cases = Vec::new();
    for seed in 0..count {
        let scene = random_scene(seed as u64)?;
        let case = keep(&scene, 0.5, ASKED[seed % ASKED.len()])?;
        tell(&format!("generated {seed}"), &case);
        cases.push(case);
    }
    for seed in 0..if brief { 2 } else { 20 } {
        let case = keep(&touching_scene(seed)?, 0.4, ASKED[seed as usize % 2])?;
        tell(&format!("touching {seed}"), &case);
        cases.push(case);
    }
    let builtins = BUILTINS.iter().filter(|builtin| !brief || builtin.name == "chain");
    for (row, builtin) in builtins.enumerate() {
        let loaded = msd::scene::open(builtin.name)?;
        // Of scenes in which things touch, whose references take long, `drape` is enough.
        if !loaded.scene.shells.is_empty() && builtin.name != "drape" {
            continue;
        }
        let case = keep(&loaded.scene, 0.5, ASKED[row % ASKED.len()])?;
        tell(builtin.name, &case);
        cases.push(case);
    }
    let percent = |good: &dyn Fn(&Case) -> bool| {
        100.0 * cases.iter().filter(|case| good(case)).count() as f64 / cases.len() as f64
    };
    println!("{} scenes", cases.len());
    println!("delivered error <= asked: {:.1} % (promised: 95 %)", percent(&Case::kept));
    println!("cost <= 1.5 x the best: {:.1} % (promised: 90 %)", percent(&Case::is_cheap));
    println!("told that nothing meets the wish: {:.1} %", percent(&|case| case.chosen.is_none()));
    Ok(())
}

fn tell(name: &str, case: &Case) {
    let Case { asked, delivered, chosen, best, cost_ratio } = case;
    let word = |good: bool| if good { "" } else { "  <- missed" };
    let shown = |choice: &Option<Choice>| match choice {
        Some(choice) => format!("{choice}"),
        None => "nothing".into(),
    };
    let (chosen, best): (String, String) = (shown(chosen), shown(best));
    println!(
        "{name:<14} asked {asked:.1e} m, delivered {delivered:.1e} m{}; {chosen}; \
         cost {cost_ratio:.2} x that of {best}{}",
        word(case.kept()),
        word(case.is_cheap())
    );
}
