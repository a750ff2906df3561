//! Files of other kinds than their names say, and slips that a file of a beginner has.

use msd_scene::mesh::{self, Format::Stl};

/// A binary STL of four facets, whose header announces so many.
fn binary_stl(announced: u32) -> Vec<u8> {
    let mut bytes = vec![b'b'; 80];
    bytes.extend(announced.to_le_bytes());
    let at = |k: usize| [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]][k];
    for corners in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flat_map(|&k| at(k)).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn bytes_after_the_facets_of_an_stl_file_are_reported_where_they_may_be_facets() {
    let left_over = |bytes: &[u8]| {
        let report = mesh::parse(bytes, Stl, "a.stl").expect("facets").report;
        let says = report.to_string().contains("announces 2 facets; 100 bytes after them are not");
        (report.left_over, says)
    };
    assert_eq!(left_over(&binary_stl(2)), (100, true));
    assert_eq!(left_over(&binary_stl(4)), (0, false));
    let padded = [binary_stl(4), vec![0; 17]].concat();
    assert_eq!(left_over(&padded), (0, false));
}
