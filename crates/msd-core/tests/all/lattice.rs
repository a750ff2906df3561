//! Closed-form indexing of lattices, against counting neighbours one by one.

use msd_core::glam::DVec3;
use msd_core::lattice::FAMILIES;
use msd_core::{Error, Lattice, Material, Neighbours, shape};
use std::collections::BTreeSet;

const SIZES: [[usize; 3]; 10] = [
    [1, 1, 1],
    [1, 5, 1],
    [7, 1, 1],
    [1, 1, 2],
    [4, 4, 1],
    [1, 3, 5],
    [6, 1, 2],
    [2, 2, 2],
    [3, 4, 5],
    [5, 2, 3],
];

fn neighbours_by_search(lattice: &Lattice, axes_only: bool) -> BTreeSet<[usize; 2]> {
    let mut pairs = BTreeSet::new();
    for a in 0..lattice.particle_count() {
        for b in a + 1..lattice.particle_count() {
            let (from, to) = (lattice.place(a), lattice.place(b));
            let steps = [0, 1, 2].map(|axis| from[axis].abs_diff(to[axis]));
            let near = steps.iter().all(|&step| step <= 1);
            if near && (!axes_only || steps.iter().sum::<usize>() == 1) {
                pairs.insert([a, b]);
            }
        }
    }
    pairs
}

#[test]
fn the_springs_are_exactly_the_pairs_of_neighbours_and_index_both_ways() {
    for size in SIZES {
        for (neighbours, axes_only) in [(Neighbours::All, false), (Neighbours::Axes, true)] {
            let lattice = Lattice::new(size, neighbours).unwrap();
            let mut found = BTreeSet::new();
            for spring in 0..lattice.spring_count() {
                let [a, b] = lattice.spring(spring);
                assert_eq!(lattice.spring_between([a, b]), Some(spring), "{size:?}");
                assert_eq!(lattice.spring_between([b, a]), Some(spring), "{size:?}");
                assert!(lattice.family(lattice.family_of(spring)).contains(&spring));
                assert!(found.insert([a.min(b), a.max(b)]), "{size:?}: twice {a}-{b}");
            }
            assert_eq!(found, neighbours_by_search(&lattice, axes_only), "{size:?}");
        }
    }
}

#[test]
fn particles_that_are_no_neighbours_have_no_spring() {
    let sheet = Lattice::new([4, 4, 1], Neighbours::Axes).unwrap();
    assert_eq!(sheet.spring_between([0, 5]), None); // a diagonal of a 4-neighbour sheet
    assert_eq!(sheet.spring_between([0, 2]), None);
    assert_eq!(sheet.spring_between([3, 4]), None); // last of a row, first of the next
}

#[test]
fn particles_index_both_ways() {
    for size in SIZES {
        let lattice = Lattice::new(size, Neighbours::All).unwrap();
        for particle in 0..lattice.particle_count() {
            assert_eq!(lattice.particle(lattice.place(particle)), particle);
        }
    }
}

#[test]
fn there_are_13_families_ordered_by_length() {
    let lengths: Vec<f64> = (0..FAMILIES.len()).map(Lattice::family_length).collect();
    assert!(lengths.is_sorted());
    let part = shape::block([3, 4, 5], 0.5, Material::default()).unwrap();
    let rests: Vec<f64> = part.springs.iter().map(|spring| spring.rest_length).collect();
    assert!(rests.is_sorted());
    for spring in &part.springs {
        let [a, b] = spring.ends.map(|end| part.particles[end].position);
        // Coordinates are multiples of 1/4 m, exact; the square root rounds once.
        assert!(((b - a).length() - spring.rest_length).abs() < 1e-15);
    }
}

#[test]
fn an_inner_particle_has_26_neighbours_in_a_block_and_8_or_4_in_a_sheet() {
    let degree = |size, neighbours, at| {
        let lattice = Lattice::new(size, neighbours).unwrap();
        let particle = lattice.particle(at);
        let ends = (0..lattice.spring_count()).map(|spring| lattice.spring(spring));
        ends.filter(|ends| ends.contains(&particle)).count()
    };
    assert_eq!(degree([3, 3, 3], Neighbours::All, [1, 1, 1]), 26);
    assert_eq!(degree([3, 3, 1], Neighbours::All, [1, 1, 0]), 8);
    assert_eq!(degree([3, 3, 1], Neighbours::Axes, [1, 1, 0]), 4);
}

#[test]
fn the_surface_of_a_block_is_closed_and_wound_outward() {
    for size in [[2, 2, 2], [3, 4, 5], [5, 2, 3]] {
        let part = shape::block(size, 1.0, Material::default()).unwrap();
        let surface = &part.surface;
        let particle = |corner: u32| surface.corners[corner as usize].particle as usize;
        let mut edges = BTreeSet::new();
        let mut volume = 0.0;
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(particle);
            for edge in [(a, b), (b, c), (c, a)] {
                assert!(edges.insert(edge), "{size:?}: edge {edge:?} twice the same way round");
            }
            let [a, b, c] = [a, b, c].map(|row| part.particles[row].position);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{size:?} has a hole");
        // Outward winding makes the divergence theorem give the volume with a plus sign.
        let exact: usize = size.iter().map(|length| length - 1).product();
        assert!((volume - exact as f64).abs() < 1e-9, "{size:?}: {volume}");
    }
}

#[test]
fn the_surface_of_a_sheet_covers_it_once_and_texture_spans_0_to_1() {
    let part = shape::cloth([4, 7], 1.0, Material::default()).unwrap();
    let surface = &part.surface;
    assert!(surface.two_sided);
    let point =
        |corner: u32| part.particles[surface.corners[corner as usize].particle as usize].position;
    let area: DVec3 = surface
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(point);
            (b - a).cross(c - a) / 2.0
        })
        .sum();
    assert!((area - DVec3::new(0.0, 0.0, 18.0)).length() < 1e-12);
    for axis in 0..2 {
        let range = surface.corners.iter().map(|corner| corner.uv[axis]);
        assert_eq!(range.clone().fold(f32::MAX, f32::min), 0.0);
        assert_eq!(range.fold(f32::MIN, f32::max), 1.0);
    }
}

#[test]
fn a_rope_and_a_point_have_no_surface_and_nothing_lies_past_the_last() {
    for size in [[1, 5, 1], [1, 1, 1]] {
        let lattice = Lattice::new(size, Neighbours::All).unwrap();
        assert_eq!((lattice.triangle_count(), lattice.corner_count()), (0, 0));
        assert_eq!((lattice.triangle(0), lattice.corner(0)), (None, None));
    }
    let block = Lattice::new([2, 2, 2], Neighbours::All).unwrap();
    assert_eq!(block.triangle(block.triangle_count()), None);
    assert_eq!(block.corner(block.corner_count()), None);
}

#[test]
fn a_size_that_is_zero_or_does_not_fit_is_refused_without_overflow() {
    let zero = Lattice::new([3, 0, 1], Neighbours::All).unwrap_err();
    assert_eq!(zero.to_string(), "size of dimension 1 is 0; it must be at least 1");
    for size in [[1 << 31; 3], [usize::MAX; 3], [300, 300, 300]] {
        let error = Lattice::new(size, Neighbours::All).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. }), "{size:?}: {error}");
    }
}
