//! All methods survive the extremes, and the limit lies where theory puts it.

use msd_core::{Integrator, Witness};
use msd_run::Runner;
use msd_scene::Precision;
use std::sync::OnceLock;
use xtask::extremes::conduct::{Extremes, Plan, conduct};
use xtask::extremes::distance::{DISTANCES, loss};
use xtask::extremes::map::{Across, Grid, Map};
use xtask::extremes::outcome::Outcome;
use xtask::extremes::{figure, tables};

/// A small map of everything, made once.
fn extremes() -> &'static Extremes {
    static MADE: OnceLock<Extremes> = OnceLock::new();
    MADE.get_or_init(|| conduct(Plan::quick(2), &mut |_, _| {}))
}

#[test]
fn nothing_panics_hangs_lies_or_is_no_number() {
    let failures = extremes().failures();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert_eq!(extremes().maps.len(), 8 * 4 * 2);
    assert!(extremes().len() > 5000);
}

/// Returns whether a run of 320 steps shows that explicit Euler is unstable one cell beyond its
/// limit h w = 2 ζ. There the energy grows by more than 10 ζ² per step, which must come to more
/// than the tenth that is reported.
fn shows(map: &Map, value: f64) -> bool {
    let ratio = map.across.oscillator(value).damping_ratio;
    map.integrator != Integrator::ExplicitEuler || 0.02 < ratio
}

#[test]
fn the_limit_of_explicit_methods_lies_where_theory_puts_it() {
    let mut seen = 0;
    for map in &extremes().maps {
        if !Integrator::EXPLICIT.contains(&map.integrator) {
            continue;
        }
        // The step that the next row has more, and a hundredth for the rounding of the spectrum.
        let row = map.steps[1] / map.steps[0] * 1.01;
        for (column, (&value, &limit)) in map.values.iter().zip(&map.limits).enumerate() {
            let Some(last) = map.observed(column).filter(|_| shows(map, value)) else {
                continue;
            };
            let at = format!("{:?} {} {value:e}", map.across, map.integrator);
            assert!(map.steps[last] <= limit * row, "{at}: kept at {:e}", map.steps[last]);
            if let Some(&next) = map.steps.get(last + 1) {
                assert!(limit <= next * row, "{at}: lost at {next:e}, limit {limit:e}");
                seen += 1;
            }
        }
    }
    assert!(150 < seen, "{seen} columns show a limit");
}

/// Returns whether theory promises that a cell of an implicit method or XPBD stays bounded.
fn is_promised(map: &Map, value: f64, step: f64) -> bool {
    let epsilon = if map.precision == Precision::F32 { f32::EPSILON.into() } else { f64::EPSILON };
    let stretched = (step * map.across.oscillator(value).frequency()).powi(2);
    match map.integrator {
        Integrator::Xpbd => true,
        // Beside h² k a mass must keep some digits: with fewer a solve may find no way against a
        // weight, and says so.
        Integrator::BackwardEuler => epsilon * stretched < 1e-7,
        // Sideways a spring that is shortened by a tenth pushes with a tenth of its stiffness, and
        // the matrix leaves that out: it is an explicit method there, stable up to h² w² / 10 = 4.
        _ => 0.1 * stretched < 4.0,
    }
}

#[test]
fn implicit_methods_and_xpbd_are_bounded_wherever_theory_says_so() {
    let mut beyond = 0;
    for map in &extremes().maps {
        if !map.integrator.is_implicit() && map.integrator != Integrator::Xpbd {
            continue;
        }
        assert!(map.limits.iter().all(|&limit| limit == f64::INFINITY));
        for (row, &step) in map.steps.iter().enumerate() {
            for (column, &value) in map.values.iter().enumerate() {
                let outcome = map.cell(column, row).outcome;
                if is_promised(map, value, step) {
                    let at = format!("{:?} {value:e}, step {step:e}", map.across);
                    assert!(outcome.is_kept(), "{at}: {outcome:?} {}", map.integrator);
                    beyond += usize::from(1.0 < step * map.across.oscillator(value).frequency());
                }
            }
        }
    }
    assert!(300 < beyond, "only {beyond} cells are beyond what an explicit method bears");
}

#[test]
fn short_steps_are_accurate_under_every_method() {
    for map in &extremes().maps {
        // h w < 1e-4 for the stiffest: every method of first order is right to 320 times that.
        let w = map.values.iter().map(|&value| map.across.oscillator(value).frequency());
        for (column, w) in w.enumerate() {
            let short = map.steps.iter().position(|h| 1e-4 < h * w).unwrap_or(map.steps.len());
            // With dampers beyond critical the fast root is faster than w.
            let ratio = map.across.oscillator(map.values[column]).damping_ratio;
            if ratio <= 1.0 {
                for row in 0..short {
                    let outcome = map.cell(column, row).outcome;
                    assert_eq!(outcome, Outcome::Accurate, "{:?}", map.cell(column, row));
                }
            }
        }
    }
}

#[test]
fn the_same_bits_at_any_number_of_threads() {
    let plan = Plan { grid: Grid { columns: 4, rows: 4 }, part: 0.01, ..Plan::quick(1) };
    let alone = conduct(plan, &mut |_, _| {});
    let together = conduct(Plan { threads: 5, ..plan }, &mut |_, _| {});
    assert_eq!(tables::maps_csv(&alone), tables::maps_csv(&together));
    assert_eq!(tables::hardships_csv(&alone), tables::hardships_csv(&together));
}

#[test]
fn a_figure_is_a_small_drawing_with_a_line_of_theory_where_there_is_a_limit() {
    let verlet = figure::svg(extremes(), Integrator::VelocityVerlet);
    let drawing = roxmltree::Document::parse(&verlet).expect("a drawing");
    let said: Vec<&str> = drawing.descendants().filter_map(|node| node.text()).collect();
    for words in ["velocity-verlet", "f32", "f64", "Step, s"] {
        assert!(said.iter().any(|text| text.trim() == words), "{words} is missing");
    }
    assert!(verlet.len() < 150_000);
    for across in Across::ALL {
        assert!(said.iter().any(|text| text.trim() == across.title()), "{across:?}");
    }
}

#[test]
fn far_from_the_origin_single_precision_loses_and_both_remedies_give_it_back() {
    let near = loss(DISTANCES[0]).unwrap();
    // A run rounds a coordinate of 1 m in each of 480 substeps, at random.
    assert!(near.single < 1e-5, "{near:?}");
    for distance in DISTANCES.into_iter().skip(2) {
        let far = loss(distance).unwrap();
        assert!(10.0 * near.single < far.single, "{far:?}");
        // The scene is moved by whole metres, so it is rounded anew by no more than before.
        assert!(far.recentred <= 3.0 * near.single, "{far:?}");
        // A double has 29 bits more.
        assert!(far.double < 1e-6 * far.single, "{far:?}");
    }
}

#[test]
fn no_built_in_scene_is_said_to_gain_energy() {
    // The test of scenes with contact is in `crates/msd-run/tests/all/touching_scenes.rs`.
    let elsewhere = ["trampoline", "twist", "funnel", "knot", "curtain"];
    let here = msd_scene::BUILTINS.iter().filter(|builtin| !elsewhere.contains(&builtin.name));
    for builtin in here {
        let loaded = msd_scene::open(builtin.name).unwrap();
        let mut runner = Runner::open(&loaded).unwrap();
        let mut witness = Witness::default();
        for _ in 0..300 {
            runner.step().unwrap();
            runner.show_to(&mut witness);
            assert_eq!(witness.gain(), 0.0, "{} at {:.2} s", builtin.name, runner.time());
        }
    }
}

#[test]
fn what_a_method_cannot_do_is_in_the_table() {
    let row = |name: &str| extremes().rows.iter().find(|row| row.name == name).expect("a row");
    let of = |name: &str, integrator: Integrator| {
        let column = Integrator::ALL.iter().position(|&other| other == integrator).unwrap();
        row(name).verdicts[column][0].outcome
    };
    for integrator in Integrator::ALL {
        assert_eq!(of("at rest", integrator), Outcome::Accurate, "{integrator}");
        // Springs know lengths only: a point has no directions in which to grow.
        assert_eq!(of("one point", integrator), Outcome::Bounded, "{integrator}");
    }
    for integrator in Integrator::EXPLICIT {
        assert_eq!(of("1e12 N/m", integrator), Outcome::Diverged, "{integrator}");
    }
    for integrator in [Integrator::BackwardEuler, Integrator::Xpbd] {
        assert!(of("1e12 N/m", integrator).is_kept(), "{integrator}");
    }
}
