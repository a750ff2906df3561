//! The slowest motions, against strings, beams and bars.

use msd_core::glam::DVec3;
use msd_core::substance::SOLID_POISSON;
use msd_core::{
    Elasticity, Part, Particle, Pin, Scene, Settings, Simulation, Spring, Substance, World, shape,
};
use std::f64::consts::{PI, TAU};

fn frequencies(scene: &Scene) -> Vec<f64> {
    let simulation = Simulation::<f64>::new(scene, Settings::default()).expect("valid");
    let modes = simulation.slowest_modes(5);
    modes.iter().map(|mode| mode.stiffness.sqrt() / TAU).collect()
}

fn scene(part: Part) -> Scene {
    let world = World { gravity: DVec3::ZERO, ..World::default() };
    Scene { world, ..Scene::of("body", part) }
}

#[test]
fn a_stretched_string_swings_at_the_frequencies_of_lagrange() {
    // n particles between two that are held: w = 2 √(T/(m a)) sin(π j/(2 (n + 1))) across, in two
    // directions each, and √(k/m) for √(T/(m a)) along, here as large as the fifth.
    let (count, stiffness, mass) = (9, 40.0, 0.1);
    let at = |row: usize| DVec3::X * row as f64;
    let particle = |row| Particle { position: at(row), velocity: DVec3::ZERO, mass };
    let particles = (0..count + 2).map(particle).collect();
    let spring = |row| Spring { ends: [row, row + 1], rest_length: 0.9, stiffness, damping: 0.0 };
    let mut scene =
        scene(Part { particles, springs: (0..=count).map(spring).collect(), ..Part::default() });
    let velocity = DVec3::ZERO;
    scene.pins = [0, count + 1].map(|particle| Pin { particle, velocity }).to_vec();
    let found = frequencies(&scene);
    let expected = |j: f64| {
        let tension = 0.1 * stiffness;
        2.0 * (tension / mass).sqrt() * (PI * j / (2.0 * 10.0)).sin() / TAU
    };
    for (found, j) in found.iter().zip([1.0, 1.0, 2.0, 2.0, 3.0]) {
        assert!((found / expected(j) - 1.0).abs() < 1e-6, "{found}, {}", expected(j));
    }
    assert_eq!(found.len(), 5);
}

/// A square bar so many cells thick and ten times as long.
fn bar(cells: usize, poisson: f64) -> Scene {
    let size = [cells + 1, 10 * cells + 1, cells + 1];
    let elasticity = Elasticity::Solid { young: 1e6, poisson };
    let solid = Substance { elasticity, density: 1000.0, relaxation_time: 0.0 };
    scene(shape::body(size, 0.1 / cells as f64, &solid).expect("a bar"))
}

/// The first frequencies of a free bar of 1 m of E = 1e6 Pa, 1000 kg/m³ and 0.1 m square by
/// Timoshenko's beam theory, two directions alike: √(E I/(ρ A)) β²/(2π L²) with β = 4.730 and 7.853
/// for Euler's, less by the rotation and the shear of sections.
fn free_bar(beta: f64, poisson: f64) -> f64 {
    let (young, density, side) = (1e6f64, 1000.0, 0.1f64);
    let radius_squared = side * side / 12.0;
    let euler = beta * beta * (young / density * radius_squared).sqrt() / TAU;
    // Of second order in the slenderness (Timoshenko, 1921), for β tanh-like end factors of free
    // ends near 1: w = w0 / √(1 + β² r² (1 + E/(κ G))).
    let shear = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    euler / (1.0 + beta * beta * radius_squared * (1.0 + 2.0 * (1.0 + poisson) / shear)).sqrt()
}

#[test]
fn the_first_three_frequencies_of_a_free_bar_are_those_of_beams_and_of_torsion() {
    for poisson in [SOLID_POISSON, 0.45] {
        let [coarse, fine] = [2, 4].map(|cells| twist_last(frequencies(&bar(cells, poisson))));
        // Bent in two directions alike, which is stiffer by the cells as the clamped one is.
        for found in [&coarse, &fine] {
            for pair in [0, 2] {
                assert!((found[pair] / found[pair + 1] - 1.0).abs() < 1e-6, "{found:?}");
            }
        }
        let expected = [(free_bar(4.730_04, poisson), 0.01), (free_bar(7.853_2, poisson), 0.03)];
        let expected = expected.into_iter().chain([(twist(poisson), 0.01)]);
        for (row, (expected, within)) in [0, 2, 4].into_iter().zip(expected) {
            // Of order 2.
            let limit = fine[row] + (fine[row] - coarse[row]) / 3.0;
            println!("{poisson}, {row}: {expected} Hz, {}, {}", fine[row], limit / expected - 1.0);
            assert!((limit / expected - 1.0).abs() < within, "{poisson}: {limit}, {expected}");
        }
    }
}

/// The frequencies of pairs of motions first, those of bending, then that of the twist, wherever
/// that is among them.
fn twist_last(mut found: Vec<f64>) -> Vec<f64> {
    let is_alone = |row: &usize| {
        let alike = found.iter().filter(|other| (*other / found[*row] - 1.0).abs() < 1e-6);
        alike.count() == 1
    };
    let twist = (0..found.len()).find(is_alone).expect("a twist");
    let twist = found.remove(twist);
    found.push(twist);
    found
}

/// The first frequency of a free bar that twists, by the torsion constant of a square, 0.1406 a⁴
/// (Saint-Venant, 1855), over its polar moment, a⁴/6: √(G J/(ρ I))/(2 L).
fn twist(poisson: f64) -> f64 {
    let shear = 1e6 / (2.0 * (1.0 + poisson));
    (shear * 0.140_58 * 6.0 / 1000.0).sqrt() / 2.0
}
