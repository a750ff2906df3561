//! Cells that are flat or inside out, of lattices that are turned, sheared, mirrored and squeezed.

use msd_core::glam::{DMat3, DVec3};
use msd_core::{Elasticity, Scene, Settings, State, Substance, Vector, shape};
use msd_run::{Cells, Overturned, Runner, on};
use msd_scene::Precision;

/// A block of 4 x 3 x 5 particles, of springs alone or with volumes.
fn block(poisson: f64) -> Runner {
    let elasticity = Elasticity::Solid { young: 1e4, poisson };
    let substance = Substance { elasticity, density: 1000.0, relaxation_time: 0.0 };
    let part = shape::body([4, 3, 5], 0.1, &substance).expect("a block");
    let scene = Scene::of("block", part);
    Runner::new(&scene, Settings::default(), Precision::F64).expect("a valid scene")
}

/// The corners found once a function has moved the particles.
fn found(runner: &mut Runner, move_to: impl Fn(DVec3) -> DVec3) -> Option<Overturned> {
    let cells = Cells::new(runner);
    let Runner::F64(simulation, _) = runner else { panic!("double precision") };
    let state = simulation.state();
    let positions = state.positions.iter().map(|&x| move_to(x)).collect();
    simulation.set_state(&State { positions, ..state }, 0).expect("of this system");
    cells.overturned(runner)
}

#[test]
fn each_cell_has_eight_corners_and_all_are_lost_in_a_mirror_or_a_mat() {
    for poisson in [0.25, 0.4] {
        let all = 8 * 3 * 2 * 4;
        let lost = Some(Overturned { body: 0, corners: all, of: all });
        let by = |scale: DVec3| found(&mut block(poisson), |x| x * scale);
        assert_eq!(by(DVec3::new(-1.0, 1.0, 1.0)), lost);
        assert_eq!(by(DVec3::new(1.0, 0.0, 1.0)), lost);
        assert_eq!(by(DVec3::new(1.0, 0.02, 1.0)), None, "squeezed, but not flat");
    }
}

#[test]
fn what_is_turned_sheared_and_stretched_loses_none() {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 2.0);
    // A determinant of 2.
    let shear = DMat3::from_cols_array(&[2.0, 0.0, 0.0, 1.5, 1.0, 0.0, -1.0, 0.7, 1.0]);
    assert_eq!(found(&mut block(0.25), |x| turn * (shear * x)), None);
}

#[test]
fn a_fold_between_two_layers_turns_the_cells_beyond_it_alone() {
    // The uppermost of four rows lies on the second: the third layer of 2 x 4 cells is mirrored.
    let mut runner = block(0.25);
    let lowest = on!(&runner, run => run.positions().map(|x| x.to_f64().y).fold(1.0, f64::min));
    let fold = |x: DVec3| {
        let row = ((x.y - lowest) / 0.1).round();
        if row == 3.0 { x - DVec3::Y * 0.2 } else { x }
    };
    let expected = Overturned { body: 0, corners: 8 * 2 * 4, of: 8 * 3 * 2 * 4 };
    assert_eq!(found(&mut runner, fold), Some(expected));
}

#[test]
fn sheets_and_ropes_have_no_cells() {
    for name in ["cloth", "chain"] {
        let loaded = msd_scene::open(name).expect("a built-in scene");
        let mut runner = Runner::open(&loaded).expect("a valid scene");
        let cells = Cells::new(&runner);
        (0..30).for_each(|_| runner.step().expect("a stable step"));
        assert_eq!(cells.overturned(&runner), None, "{name}");
    }
}
