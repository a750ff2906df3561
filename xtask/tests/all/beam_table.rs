//! The error of a coarse lattice: a clamped beam against theory, and the table of the page.

use msd_core::Particle;
use msd_core::glam::DVec3;
use xtask::beam_table::{Beam, LENGTH, THICKNESS, YOUNG, beam_table, text};

#[test]
fn a_coarse_beam_is_too_stiff_by_the_table_of_the_documentation() {
    let rows = beam_table().expect("four beams");
    // Computed by another program, of other authors.
    let expected =
        [[-54.0, 46.0, -82.0], [-23.0, 14.0, -63.0], [-7.4, 4.0, -42.0], [-3.7, 2.0, -31.0]];
    for (row, expected) in rows.iter().zip(expected) {
        for (found, expected) in [row.deflection, row.frequency, row.alike].iter().zip(expected) {
            assert!((found - expected).abs() <= 0.5, "{found} %, not {expected} %");
        }
        // The centre line ends where the tip is.
        let (_, tip) = *row.line.last().expect("a line");
        assert!((100.0 * (tip - 1.0) - row.deflection).abs() < 1.0, "{tip}");
    }
    let page = include_str!("../../../docs/measured/beams.md");
    let table = format!("<!-- begin beam -->\n{}<!-- end beam -->", text(&rows));
    assert!(page.contains(&table), "docs/measured/beams.md lacks this table:\n{table}");
}

#[test]
fn a_clamped_beam_that_is_pulled_stretches_and_narrows_as_hooke_says() {
    let area = THICKNESS * THICKNESS;
    let strain = 1.0 / (YOUNG * area);
    let mut lost = Vec::new();
    for cells in [2, 4, 8] {
        let beam = Beam::new(cells).expect("a beam");
        let load: Vec<DVec3> = beam.shares().iter().map(|share| DVec3::X * *share).collect();
        let moved = beam.solve(&load);
        let at = |place: DVec3| {
            let near = |row: &Particle| row.position.distance(place) < 1e-9;
            moved[beam.part.particles.iter().position(near).expect("a particle there")]
        };
        // Far from both ends the strain is uniform, and of that the lattice is exact. The effect of
        // the clamp decays at least by exp(−4) per thickness (Saint-Venant): to 1e-5 over 2.5.
        let [left, right] = [-0.25, 0.25].map(|part| at(DVec3::X * (part * LENGTH)).x);
        assert!(((right - left) / (0.5 * LENGTH * strain) - 1.0).abs() < 1e-4, "{cells}");
        let [low, high] = [-0.5, 0.5].map(|part| at(DVec3::Y * (part * THICKNESS)).y);
        assert!(((low - high) / (0.25 * THICKNESS * strain) - 1.0).abs() < 1e-4, "{cells}");
        // The clamp keeps the first of the beam from narrowing: there E is at most 6/5 of its value
        // elsewhere, over about half a thickness.
        let elongation: f64 = load.iter().zip(&moved).map(|(load, moved)| load.dot(*moved)).sum();
        let least = 1.0 - (1.0 - 5.0 / 6.0) * THICKNESS / LENGTH;
        let part = elongation / (LENGTH * strain);
        println!("{cells} cells: {part:.6} of F L/(E A)");
        assert!(least < part && part < 1.0, "{part}");
        lost.push(part);
    }
    // The edge of the clamp is a corner of the stress, so that the order is above 1, but not 2.
    let order = ((lost[0] - lost[1]) / (lost[1] - lost[2])).log2();
    println!("order {order:.2}");
    assert!(1.0 < order, "{order}");
}
