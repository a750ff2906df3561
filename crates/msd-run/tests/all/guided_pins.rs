//! Runs with pins that end: their automatic substeps, and runs that are saved on the way.

use msd_run::Runner;
use msd_scene::{SceneFormat, parse, read_saved, saved_bytes, state_hash};

/// Two particles on a stiff spring, of which one is pinned until a tenth of a second.
const PINNED: &str = "version = 1
[[bodies]]
kind = 'rope'
size = [2]
spacing = 0.5
mass = 0.1
stiffness = 1e5
[[pins]]
set = 'first'
until = 0.1
";

fn runner() -> Runner {
    let loaded = parse(PINNED, SceneFormat::Toml, "pinned.toml").expect("a valid scene");
    Runner::open(&loaded).expect("a run")
}

#[test]
fn automatic_substeps_are_chosen_anew_where_a_pin_ends() {
    let mut runner = runner();
    let mut chosen = Vec::new();
    for _ in 0..12 {
        runner.step().expect("a step");
        chosen.push(runner.settings().substeps);
    }
    // w² is k/m where one particle is held and 2 k/m where both are free: at the limit of 2/w, of
    // which 0.9 is taken, a sixtieth of a second has 9.26 and 13.1 substeps. The pin ends after six
    // steps.
    assert_eq!(chosen, [[10; 6], [14; 6]].concat());
}

#[test]
fn a_run_that_is_saved_where_a_pin_ends_goes_on_with_the_same_bits() {
    for steps in [5, 6, 7] {
        let mut runner = runner();
        (0..steps).for_each(|_| runner.step().expect("a step"));
        let bytes = saved_bytes(&runner.to_loaded("pinned", "two")).expect("bytes");
        let mut other = Runner::open(&read_saved(&bytes, "s.msd").expect("whole")).expect("a run");
        for run in [&mut runner, &mut other] {
            (0..20).for_each(|_| run.step().expect("a step"));
        }
        assert_eq!(state_hash(&runner.state()), state_hash(&other.state()), "{steps} steps");
        assert_eq!(runner.settings(), other.settings());
    }
}
