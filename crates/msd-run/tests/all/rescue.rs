//! Recovery options after divergence: each offer lasts, and debris is left behind.

use msd_core::glam::DVec3;
use msd_core::{Integrator, Material, Scene, Settings, World, shape};
use msd_run::rescue::{Offer, Origin, Remedy, Rescue, debris};
use msd_run::{History, Runner, on};
use msd_scene::Precision;
use std::cell::Cell;

/// A rope of six masses that floats, stretched by a tenth.
fn rope(integrator: Integrator, substeps: u32) -> Runner {
    let material = Material { mass: 1.0, stiffness: 1e5, damping: 1.0 };
    let mut scene = Scene::of("rope", shape::rope(6, 1.0, material).expect("small"));
    scene.world = World { gravity: DVec3::ZERO, ..World::default() };
    scene.particles.iter_mut().for_each(|particle| particle.position *= 1.1);
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Runner::new(&scene, settings, Precision::F64).expect("a valid scene")
}

/// The offers for a run from its start, by a stopwatch.
fn offers(run: &Runner, most: u32, stopwatch: &impl Fn() -> f64) -> Vec<Offer> {
    let stable = run.stable_substep();
    let mut rescue = Rescue::new(run.settings(), stable, (&[Origin::Start], most), 2.0);
    rescue.work(&|_| Some(run.clone()), f64::INFINITY, stopwatch);
    assert!(rescue.is_done());
    rescue.offers().to_vec()
}

#[test]
fn what_is_offered_is_the_least_that_lasts() {
    let run = rope(Integrator::SymplecticEuler, 1);
    let found = offers(&run, 1000, &|| 0.0);
    let [Offer { remedy: Remedy::Substeps(count), .. }, method] = found[..] else {
        panic!("{found:?}");
    };
    // 0.8 of the limit: fewer substeps by one are above that.
    let share = run.settings().step / f64::from(count) / run.stable_substep();
    assert!(share <= 0.8 && 0.8 < share * f64::from(count) / f64::from(count - 1), "{share}");
    // No explicit method bears a substep that is many times the limit of this one.
    assert_eq!(method.remedy, Remedy::Method(Integrator::BackwardEuler, 1));
    for Offer { remedy, is_tried, .. } in found {
        assert!(is_tried);
        let mut copy = run.clone();
        copy.set_settings(remedy.settings(run.settings())).expect("valid settings");
        (0..120).for_each(|_| copy.step().expect("it lasts"));
    }
}

#[test]
fn explicit_euler_is_offered_verlet_at_the_same_substeps() {
    let run = rope(Integrator::ExplicitEuler, 16);
    let verlet = on!(&run, simulation => {
        simulation.stable_substep_of(Integrator::VelocityVerlet, 16)
    });
    assert!(run.stable_substep() < run.settings().substep() && run.settings().substep() < verlet);
    let remedies: Vec<Remedy> =
        offers(&run, 1000, &|| 0.0).iter().map(|offer| offer.remedy).collect();
    assert!(remedies.contains(&Remedy::Method(Integrator::VelocityVerlet, 16)), "{remedies:?}");
}

#[test]
fn explicit_euler_is_offered_verlet_with_the_few_substeps_that_it_needs() {
    let run = rope(Integrator::ExplicitEuler, 1);
    let found = offers(&run, 1000, &|| 0.0);
    let few = found.iter().find_map(|offer| match offer.remedy {
        Remedy::Method(Integrator::VelocityVerlet, substeps) => Some(substeps),
        _ => None,
    });
    let few = few.unwrap_or_else(|| panic!("{found:?}"));
    // 0.8 of the limit of Verlet, which is far beyond that of explicit Euler.
    let limit = on!(&run, simulation => {
        simulation.stable_substep_of(Integrator::VelocityVerlet, few)
    });
    let step = run.settings().step;
    assert!(step / f64::from(few) <= 0.8 * limit && 0.8 * limit < step / f64::from(few - 1));
}

#[test]
fn a_trial_that_takes_too_long_is_only_predicted_and_costs_are_measured() {
    let now = Cell::new(0.0);
    // Every look at the stopwatch is a twentieth of a second later.
    let stopwatch = || now.replace(now.get() + 0.05);
    let found = offers(&rope(Integrator::SymplecticEuler, 1), 1000, &stopwatch);
    assert!(!found.is_empty() && found.iter().all(|offer| !offer.is_tried), "{found:?}");
    // Each step of a sixtieth of a second took as long as one look: three times real time.
    let costs = found.iter().map(|offer| offer.cost.expect("it was measured"));
    assert!(costs.into_iter().all(|cost| (cost - 3.0).abs() < 1e-9), "{found:?}");
}

#[test]
fn a_search_without_time_offers_what_is_predicted() {
    let run = rope(Integrator::SymplecticEuler, 1);
    let whole = offers(&run, 1000, &|| 0.0);
    // No time at all, and time for a step of the first trial: each look takes a second.
    for budget in [-1.0, 0.5] {
        let now = Cell::new(0.0);
        let stopwatch = || now.replace(now.get() + 1.0);
        let from = (&[Origin::Start][..], 1000);
        let mut rescue = Rescue::new(run.settings(), run.stable_substep(), from, 2.0);
        rescue.work(&|_| Some(run.clone()), budget, &stopwatch);
        rescue.end();
        assert!(rescue.is_done());
        let found: Vec<_> = rescue.offers().iter().map(|o| (o.remedy, o.is_tried)).collect();
        assert_eq!(found, [(whole[0].remedy, false)], "within {budget} s");
    }
}

#[test]
fn a_step_that_would_take_too_long_is_not_tried() {
    // 11 rows at 1e15 N/m need some 5e7 substeps per step, 6e8 evaluations of rows: it would take
    // minutes before the clock is read again. The options that the limit promises are offered
    // untried.
    let material = Material { mass: 1.0, stiffness: 1e18, damping: 0.0 };
    let mut scene = Scene::of("rope", shape::rope(6, 1.0, material).expect("small"));
    scene.particles.iter_mut().for_each(|particle| particle.position *= 1.1);
    let settings = Settings { integrator: Integrator::VelocityVerlet, ..Settings::default() };
    let run = Runner::new(&scene, settings, Precision::F64).expect("a valid scene");
    let begun = std::time::Instant::now();
    let found = offers(&run, u32::MAX, &|| begun.elapsed().as_secs_f64());
    let finer = found.iter().find(|offer| matches!(offer.remedy, Remedy::Substeps(_)));
    let finer = finer.unwrap_or_else(|| panic!("{found:?}"));
    assert!(!finer.is_tried && finer.cost.is_none(), "{finer:?}");
    let Remedy::Substeps(count) = finer.remedy else { panic!("{finer:?}") };
    assert!(run.settings().step / f64::from(count) <= run.stable_substep());
    assert!(1e8 < 11.0 * f64::from(count), "else it might be tried: {count}");
    // Dormand-Prince needs as many, and gives up after its share of work.
    let adaptive = found
        .iter()
        .find(|offer| matches!(offer.remedy, Remedy::Method(Integrator::DormandPrince, _)));
    assert!(adaptive.is_none(), "{found:?}");
}

#[test]
fn no_more_substeps_are_offered_than_may_be() {
    let found = offers(&rope(Integrator::SymplecticEuler, 1), 2, &|| 0.0);
    assert!(!found.iter().any(|offer| matches!(offer.remedy, Remedy::Substeps(_))), "{found:?}");
}

#[test]
fn debris_is_left_behind_and_a_sound_run_is_not() {
    for (substeps, is_lost) in [(1, true), (64, false)] {
        let (mut run, mut history) =
            (rope(Integrator::SymplecticEuler, substeps), History::default());
        let failed = (0..200).any(|_| {
            let before = run.moment();
            let stepped = run.step();
            if stepped.is_ok() {
                history.push(before);
            }
            stepped.is_err()
        });
        assert_eq!(failed, is_lost);
        let back = debris(&run, &history);
        assert_eq!(0 < back, is_lost, "{back}");
        if let Some(moment) = history.nth_back(back) {
            run.go_back(moment).expect("a state of this run");
        }
        // A distance half as long again and half a mean length more than 1.1 m is not a spring.
        on!(&run, simulation => (0..5).for_each(|spring| {
            assert!(simulation.length(spring) <= 2.2 + 1e-9, "{}", simulation.length(spring));
        }));
    }
}
