//! Targets of speed and memory, and whether they are reached.

use super::memory::Memory;
use super::results::Results;
use msd::core::Instructions;
use std::fmt::Write;

/// A target speed, in giga-updates per second, and as a multiple of that of the simple kernel for a
/// machine that is weaker or busier.
struct Speed {
    work: &'static str,
    class: &'static str,
    instructions: Instructions,
    speed: f64,
    ratio: f64,
}

const fn speed(work: &'static str, class: &'static str, speed: f64, ratio: f64) -> Speed {
    Speed { work, class, instructions: Instructions::Avx512, speed, ratio }
}

const fn avx2(work: &'static str, speed: f64, ratio: f64) -> Speed {
    Speed { work, class: "f32", instructions: Instructions::Avx2, speed, ratio }
}

const SPEEDS: [Speed; 18] = [
    speed("cloth/31", "f32", 1.8, 8.0),
    speed("cloth/100", "f32", 1.8, 8.0),
    speed("cloth/316", "f32", 1.2, 8.0),
    speed("cloth/31", "f64", 0.7, 8.0),
    speed("cloth/100", "f64", 0.7, 8.0),
    speed("block/10", "f32", 2.0, 8.0),
    speed("block/20", "f32", 2.0, 8.0),
    speed("block/46", "f32", 2.0, 8.0),
    speed("block/100", "f32", 1.3, 8.0),
    speed("block/10", "f64", 0.7, 8.0),
    speed("block/20", "f64", 0.7, 8.0),
    speed("block/46", "f64", 0.7, 8.0),
    speed("irregular/10000", "f32", 0.85, 4.0),
    speed("irregular/100000", "f32", 0.75, 4.0),
    speed("irregular/1000000", "f32", 0.35, 4.0),
    avx2("cloth/31", 0.9, 8.0),
    avx2("block/20", 0.9, 8.0),
    avx2("irregular/10000", 0.65, 4.0),
];
/// Of the four evaluations in a substep of RK4 on the cloth/31.
const RK4: Speed = speed("cloth/31", "rk4", 1.6, 8.0);

/// The time of a frame of backward Euler before it used the kernels, in steps of 12 substeps by the
/// simple kernel in f32, measured in turn.
pub const FIRST_BACKWARD_EULER: [(&str, f64); 2] = [("f32", 0.90), ("f64", 1.53)];

/// All targets beside the measurements.
pub fn table(results: &Results, memories: &[(&str, Memory)]) -> String {
    let mut table =
        "| work | asked, G/s | reached | times the simple kernel: asked | reached | |\n\
                     |---|---|---|---|---|---|\n"
            .to_owned();
    for asked in SPEEDS.iter().chain([&RK4]) {
        let Speed { work, class, instructions, speed, ratio } = asked;
        let name = instructions.name();
        let Some(reached) = results.best(work, class, name) else { continue };
        let simple = results.best(work, class, "simple").unwrap_or(f64::NAN);
        let (reached, times) = (1e-9 * reached, reached / simple);
        let enough = verdict(*speed <= reached, *ratio <= times);
        let row = format!("{work} {class} {name} | {speed} | {reached:.2} | {ratio} | {times:.1}");
        let _ = writeln!(table, "| {row} | {enough} |");
    }
    table += "\n| else | asked | reached | |\n|---|---|---|---|\n";
    for (name, first) in FIRST_BACKWARD_EULER {
        let of = |name| results.best("cloth/31", "backward-euler", name);
        let Some((frames, steps)) = of(name).zip(of("simple step")) else { continue };
        let times = first / (steps / frames);
        let enough = verdict(4.0 <= times, false);
        let what = format!("backward Euler, cloth/31 {name}, times the first version");
        let _ = writeln!(table, "| {what} | 4 | {times:.1} | {enough} |");
    }
    for work in ["block/20", "cloth/316", "block/46", "irregular/100000"] {
        let of = |name| results.best(work, "threads", name);
        let Some((one, two)) = of("1").zip(of("2")) else { continue };
        let enough = verdict(1.6 <= two / one, false);
        let what = format!("2 threads, {work}, times one thread");
        let _ = writeln!(table, "| {what} | 1.6 | {:.2} | {enough} |", two / one);
    }
    for (work, memory) in memories {
        let each = memory.held / memory.springs as f64;
        let (held, asked, unit) = if *work == "block/100" {
            (1e-6 * memory.held, 400.0, "MB")
        } else {
            (each, 40.0, "bytes per spring")
        };
        let enough = verdict(held <= asked, false);
        let _ = writeln!(table, "| memory held, {work}, {unit} | {asked} | {held:.0} | {enough} |");
    }
    table
}

/// The verdict on a target, by the figure itself or by the ratio, which counts where the machine is
/// weaker.
fn verdict(figure: bool, ratio: bool) -> &'static str {
    match (figure, ratio) {
        (true, _) => "reached",
        (false, true) => "by ratio",
        (false, false) => "no",
    }
}
