//! Extreme mass ratios under the implicit methods: masses that rounding loses beside their spring.

use crate::common::{simulation, two_masses};
use msd_core::{Integrator, Real};

/// The largest stretch from the second step on, metres.
fn stretch<R: Real>(light: f64, integrator: Integrator, h: f64) -> f64 {
    let scene = two_masses([1.0, light], 1000.0, 0.1 * (1000.0 * light).sqrt(), 0.1);
    let mut simulation = simulation::<R>(&scene, integrator, h);
    let mut largest = 0.0;
    for step in 0..60 {
        simulation.step().expect("a stable run");
        let [a, b] = [0, 1].map(|row| crate::common::positions(&simulation)[row]);
        if 0 < step {
            largest = f64::max(largest, ((b - a).length() - 1.0).abs());
        }
    }
    largest
}

/// Once the solve ended before it began, and the light mass flew on as if there were no spring.
#[test]
fn a_light_mass_on_a_stiff_spring_does_not_coast() {
    // Backward Euler leaves at most 1 / (h w) of the stretch after a step: h w is 1400 and more.
    let h = 0.046;
    for light in [1e-6, 1e-8, 1e-10, 1e-12] {
        let single = stretch::<f32>(light, Integrator::BackwardEuler, h);
        assert!(single < 1e-3, "{light} kg in f32: {single}");
        let double = stretch::<f64>(light, Integrator::BackwardEuler, h);
        assert!(double < 1e-3, "{light} kg in f64: {double}");
    }
}
