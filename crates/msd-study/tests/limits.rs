//! The built-in scenes blow up where it is predicted.

use msd_core::{Bending, Elasticity, Integrator, Scene, Substance, shape};
use msd_scene::mesh;
use msd_study::limits::limits;

fn scene(name: &str) -> Scene {
    msd_scene::open(name).unwrap().scene
}

/// A sheet in which bending is stiffer than stretching, rolled up by so much per row.
fn sheet(turn: f64, relaxation_time: f64) -> Scene {
    let bending = Bending { warp: 3e-3, weft: 1e-3, bias: 1.4e-3 };
    let elasticity = Elasticity::Sheet { warp: 9.0, weft: 4.0, shear: 0.6, bending };
    let substance = Substance { elasticity, density: 0.2, relaxation_time };
    let mut part = shape::body([9, 7, 1], 0.01, &substance).expect("a sheet");
    for row in part.particles.iter_mut().filter(|_| 0.0 < turn) {
        let (angle, radius) = (row.position.y / 0.01 * turn, 0.01 / turn);
        (row.position.y, row.position.z) = (radius * angle.sin(), radius * (1.0 - angle.cos()));
    }
    Scene::of("sheet", part)
}

#[test]
fn a_block_of_any_poissons_ratio_blows_up_where_predicted() {
    for poisson in [0.0, 0.45] {
        let elasticity = Elasticity::Solid { young: 1e4, poisson };
        for relaxation_time in [0.0, 1e-3] {
            let substance = Substance { elasticity, density: 1000.0, relaxation_time };
            let part = shape::body([4, 5, 4], 0.01, &substance).expect("a block");
            let name = format!("Poisson's ratio {poisson}, damped by {relaxation_time} s");
            blows_up_where_predicted(&name, &Scene::of("block", part));
        }
    }
}

#[test]
fn a_sheet_that_is_stiff_against_bending_blows_up_where_predicted_or_damped_a_little_later() {
    for turn in [0.0, 0.1] {
        blows_up_where_predicted(&format!("turn {turn}"), &sheet(turn, 0.0));
        let fixed = [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4];
        for limit in limits(&sheet(turn, 1e-3), 4).unwrap() {
            if !fixed.contains(&limit.integrator) {
                continue;
            }
            // Straight bends count as damped in all directions; other motions may give them one.
            let ratio = limit.predicted / limit.observed.expect("an edge");
            assert!((0.7..1.005).contains(&ratio), "turn {turn}: {limit:?}: {ratio}");
        }
    }
}

#[test]
fn a_shell_that_is_stiff_against_bending_blows_up_where_predicted_curved_or_shaken() {
    // A part of a cylinder, of half squares.
    let mut text = String::new();
    for row in 0..5 {
        for column in 0..6 {
            let angle = 0.3 * f64::from(column);
            text += &format!("v {} {} {}\n", angle.sin(), angle.cos(), 0.3 * f64::from(row));
        }
    }
    for a in (0..4).flat_map(|row| (1..6).map(move |column| row * 6 + column)) {
        text += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + 7, a + 7, a + 6);
    }
    let mesh = mesh::parse(text.as_bytes(), mesh::Format::Obj, "arch.obj").expect("a mesh");
    for (relaxation_time, shake) in [(0.0, 0.0), (1e-3, 0.0), (0.0, 0.02)] {
        let elasticity = Elasticity::sheet(1e4, 0.2);
        let substance = Some(Substance { elasticity, density: 100.0, relaxation_time });
        let options = mesh::MeshOptions { substance, ..mesh::MeshOptions::default() };
        let (mut part, _) = mesh::body(&mesh, &options).expect("a shell");
        for (number, row) in part.particles.iter_mut().enumerate() {
            row.position.y += shake * (number as f64 * 1.7).sin();
        }
        let name = format!("a shell damped by {relaxation_time} s, shaken by {shake} m");
        blows_up_where_predicted(&name, &Scene::of("shell", part));
    }
}

#[test]
fn every_built_in_scene_blows_up_where_predicted() {
    let small = ["cloth", "dice", "foam", "mattress", "snake", "waffle", "chain", "square4"];
    for name in small.into_iter().chain(["bunny"]) {
        blows_up_where_predicted(name, &scene(name));
    }
}

fn blows_up_where_predicted(name: &str, scene: &Scene) {
    for limit in limits(scene, 4).unwrap() {
        let observed = limit.observed.filter(|&observed| 0.0 < observed);
        if !Integrator::EXPLICIT.contains(&limit.integrator) {
            continue;
        }
        // Explicit Euler needs longer to grow than these runs last.
        let Some(observed) = observed else {
            assert_eq!(limit.integrator.name(), "explicit-euler", "{name}: {limit:?}");
            continue;
        };
        // It must grow by half in 100 substeps of the bunny: another 2.5 %.
        let slow = limit.integrator == Integrator::ExplicitEuler;
        let room = if slow { 0.03 } else { 0.005 };
        let ratio = limit.predicted / observed;
        assert!((ratio - 1.0).abs() < room, "{name}: {limit:?}: {ratio}");
    }
}
