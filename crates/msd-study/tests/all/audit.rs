//! The audit finds the values of theory for each method, and the limits in their places.

use msd_core::glam::DVec2;
use msd_core::{Integrator, Material, Scene, World, shape};
use msd_scene::Precision;
use msd_study::audit::{Audit, LEAST_DAMPING, Probe, audit, audit_all};
use msd_study::choice::{Choice, FRAME, Fineness};
use msd_study::limits::limits;

fn choice(integrator: Integrator, substeps: u32) -> Choice {
    Choice { integrator, fineness: Fineness::Substeps(substeps), precision: Precision::F64 }
}

fn probe(damping: f64) -> Probe {
    Probe { links: 12, mass: 0.5, length: 0.2, stiffness: 800.0, damping }
}

fn measured(probe: &Probe, choice: Choice) -> Audit {
    audit(probe, choice).unwrap_or_else(|| panic!("{choice} blew up"))
}

fn times(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

fn over(a: DVec2, b: DVec2) -> DVec2 {
    times(a, DVec2::new(b.x, -b.y)) / b.length_squared()
}

/// The factor per substep of the slowest mode, as a complex number.
fn factor(integrator: Integrator, probe: &Probe, h: f64) -> DVec2 {
    let (w, zeta) = (probe.frequency(), probe.damping_ratio());
    // x ~ e^(s t).
    let z = DVec2::new(-zeta * w, w * (1.0 - zeta * zeta).sqrt()) * h;
    let one = DVec2::X;
    match integrator {
        Integrator::ExplicitEuler => one + z,
        Integrator::BackwardEuler => over(one, one - z),
        Integrator::ImplicitMidpoint => over(one + 0.5 * z, one - 0.5 * z),
        Integrator::Rk4 => {
            one + times(z, one + times(z, one + times(z, one + z / 4.0) / 3.0) / 2.0)
        }
        // v' = v − h (w² x + c v), x' = x + h v': trace and determinant of its matrix.
        _ => {
            let (trace, determinant) =
                (2.0 - 2.0 * zeta * w * h - (w * h).powi(2), 1.0 - 2.0 * zeta * w * h);
            DVec2::new(0.5 * trace, (determinant - 0.25 * trace * trace).sqrt())
        }
    }
}

/// Damping ratio, and period over that of the exact motion less 1, of a factor per substep.
fn expected(factor: DVec2, probe: &Probe, h: f64) -> [f64; 2] {
    let (decay, phase) = (-factor.length().ln(), factor.y.atan2(factor.x));
    let exact = probe.frequency() * (1.0 - probe.damping_ratio().powi(2)).sqrt();
    [decay / decay.hypot(phase), exact * h / phase - 1.0]
}

/// The exact answers are those of linear methods: only rounding is left, which the fit of a mode to
/// 24 samples makes no larger than 1e-9; that of implicit methods solves to a relative 1e-3.
fn compare(integrator: Integrator, damping: f64, substeps: u32, room: f64) {
    let (probe, h) = (probe(damping), FRAME / f64::from(substeps));
    let found = measured(&probe, choice(integrator, substeps));
    let [zeta, period] = expected(factor(integrator, &probe, h), &probe, h);
    let exact = probe.damping_ratio();
    let name = format!("{integrator}, b = {damping}, {substeps} substeps: {found:?}");
    assert!((found.added_damping + exact - zeta).abs() <= room, "{name}, ratio {zeta}");
    assert!((found.period - period).abs() <= room, "{name}, period {period}");
    let ratio = 1.0 + (zeta - exact) / exact.max(LEAST_DAMPING);
    assert!((found.damping - ratio).abs() <= room / exact.max(LEAST_DAMPING), "{name} {ratio}");
    // Whatever a method does to time, it hangs where forces balance.
    assert!((found.stiffness - 1.0).abs() < 1e-6, "{name}");
}

#[test]
fn explicit_methods_swing_as_their_factors_say() {
    for damping in [0.0, 1.0, 30.0] {
        for substeps in [4, 16] {
            compare(Integrator::SymplecticEuler, damping, substeps, 1e-9);
            compare(Integrator::Rk4, damping, substeps, 1e-9);
        }
    }
    // Explicit Euler makes its fastest mode grow too, out of rounding: only a fine step shows.
    compare(Integrator::ExplicitEuler, 1.0, 64, 1e-9);
}

#[test]
fn verlet_without_dampers_has_the_period_of_symplectic_euler() {
    let probe = probe(0.0);
    for substeps in [4u32, 16] {
        let h = FRAME / f64::from(substeps);
        let found = measured(&probe, choice(Integrator::VelocityVerlet, substeps));
        // sin(w' h / 2) = w h / 2.
        let w = probe.frequency();
        let period = 0.5 * w * h / (0.5 * w * h).asin() - 1.0;
        assert!((found.period - period).abs() < 1e-9, "{found:?}");
        assert!(found.added_damping.abs() < 1e-9 && (found.damping - 1.0).abs() < 1e-6);
    }
}

#[test]
fn implicit_methods_damp_as_their_factors_say() {
    for damping in [0.0, 1.0] {
        for substeps in [1, 4] {
            compare(Integrator::BackwardEuler, damping, substeps, 1e-3);
            compare(Integrator::ImplicitMidpoint, damping, substeps, 1e-3);
        }
    }
}

#[test]
fn backward_euler_at_a_frame_damps_by_the_textbook_factor() {
    // One particle on one spring, two radians per frame: nothing but (1 + h² w²)^(−1/2) per step
    // and a period of 2π h / atan(h w).
    let w = 2.0 / FRAME;
    let probe = Probe { links: 1, mass: 1.0, length: 1.0, stiffness: w * w, damping: 0.0 };
    assert!((probe.frequency() - w).abs() < 1e-9 * w);
    let found = measured(&probe, choice(Integrator::BackwardEuler, 1));
    let (decay, phase) = (0.5 * 5f64.ln(), 2f64.atan());
    assert!((found.added_damping - decay / decay.hypot(phase)).abs() < 1e-3, "{found:?}");
    assert!((found.period - (2.0 / phase - 1.0)).abs() < 1e-3, "{found:?}");
}

#[test]
fn an_adaptive_method_delivers_what_the_springs_are() {
    let fineness = Fineness::Tolerance(1e-8);
    let found = measured(&probe(1.0), Choice { fineness, ..choice(Integrator::DormandPrince, 1) });
    // A local error of 1e-8 of the size per substep, over some hundred substeps.
    assert!((found.stiffness - 1.0).abs() < 1e-5 && found.period.abs() < 1e-5, "{found:?}");
    assert!(found.added_damping.abs() < 1e-5, "{found:?}");
}

#[test]
fn xpbd_is_soft_in_a_long_stiff_chain_and_right_in_a_fine_step() {
    let stiff = Probe { links: 20, stiffness: 1e6, ..probe(0.0) };
    let soft = measured(&stiff, choice(Integrator::Xpbd, 1));
    // A sweep a step cannot hold a chain whose slowest mode turns by 2 radians a step.
    assert!(soft.stiffness < 0.5, "{soft:?}");
    let fine = measured(&probe(0.0), choice(Integrator::Xpbd, 256));
    // First order: at h w = 0.003 for the slowest and 0.05 for the fastest mode.
    assert!((fine.stiffness - 1.0).abs() < 0.05 && fine.period.abs() < 0.05, "{fine:?}");
}

#[test]
fn what_blows_up_is_left_out_and_what_has_no_springs_has_no_audit() {
    let material = Material { mass: 1.0, stiffness: 1e4, damping: 0.0 };
    let scene = Scene::of("cloth", shape::cloth([31, 31], 1.0, material).unwrap());
    let choices = [
        choice(Integrator::ExplicitEuler, 1),
        choice(Integrator::Rk4, 1),
        choice(Integrator::VelocityVerlet, 8),
    ];
    let audits = audit_all(&scene, &choices).unwrap();
    assert_eq!(audits.iter().map(|audit| audit.choice).collect::<Vec<_>>(), [choices[2]]);
    let free = Scene { springs: Vec::new(), bodies: Vec::new(), ..scene };
    assert_eq!(audit_all(&free, &choices).unwrap(), []);
    assert_eq!(limits(&free, 8).unwrap(), []);
}

#[test]
fn a_probe_is_of_the_material_of_its_scene() {
    let material = Material { mass: 3.0, stiffness: 500.0, damping: 2.0 };
    let scene = Scene::of("rope", shape::rope(9, 0.5, material).unwrap());
    let probe = Probe::of(&scene).unwrap().unwrap();
    let exact = Probe { links: 8, mass: 3.0, length: 0.5, stiffness: 500.0, damping: 2.0 };
    assert_eq!(probe, exact);
    // Dampers that leave nothing to swing are taken down to half of the critical.
    let mut thick = scene;
    thick.springs.iter_mut().for_each(|spring| spring.damping = 1e6);
    let probe = Probe::of(&thick).unwrap().unwrap();
    assert!((probe.damping_ratio() - 0.5).abs() < 1e-12);
}

#[test]
fn the_observed_limit_is_the_one_predicted() {
    for damping in [0.0, 1.0] {
        let material = Material { mass: 0.1, stiffness: 300.0, damping };
        let mut scene = Scene::of("cloth", shape::cloth([8, 8], 0.1, material).unwrap());
        // Held in its start state, a scene may well be moving and falling.
        scene.particles.iter_mut().for_each(|particle| particle.velocity.x = 3.0);
        scene.world = World::default();
        for limit in limits(&scene, 8).unwrap() {
            let explicit = limit.integrator == Integrator::ExplicitEuler;
            let Some(observed) = limit.observed else {
                assert!(explicit && damping == 0.0 && limit.predicted == 0.0, "{limit:?}");
                continue;
            };
            // Lanczos is within 0.2 % from below in w², bisection within 0.05 %; explicit Euler has
            // to grow by half in half of a run, at 2 h w² per second: another 1 %.
            let room = if explicit { 0.02 } else { 0.005 };
            assert!((observed / limit.predicted - 1.0).abs() < room, "{limit:?}");
        }
    }
}
