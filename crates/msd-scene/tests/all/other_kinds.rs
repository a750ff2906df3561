//! Files of other kinds than their names say, and slips that a file of a beginner has.

use msd_scene::mesh::{
    self,
    Format::{self, Gltf, Obj, Ply, Stl},
};
use msd_scene::{SceneFormat, open, parse};

/// Files that are not meshes, and the messages.
const OTHERS: [(Format, &str, &str); 11] = [
    (Obj, "<!DOCTYPE html><html></html>", "it is an HTML page, as servers send instead of a file"),
    (Ply, "version https://git-lfs.github.com/spec/v1\n", "it is a Git LFS pointer, not the file"),
    (Gltf, "PK\u{3}\u{4}", "it is a ZIP archive: unpack it"),
    (Obj, "solid a\nfacet normal 0 0 1\n", "it is an STL file: end its name in .stl"),
    (Obj, "ply\nformat ascii 1.0\n", "it is a PLY file: end its name in .ply"),
    (Stl, "<?xml version=\"1.0\"?>", "it is XML: export it as glTF, OBJ, STL or PLY"),
    (Ply, "v 0 0 0\n", "line 1: it does not begin with 'ply', as a PLY file does"),
    (Obj, "v 0 0 0\nv 1 0 0\nl 1 2\n", "no faces found; points and lines alone make no body"),
    (
        Ply,
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float z\n\
         end_header\n0 0\n",
        "its vertices have no property y",
    ),
    (
        Ply,
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
         property float z\nelement tristrips 1\nproperty list int int vertex_indices\n\
         end_header\n0 0 0\n3 0 0 0\n",
        "its triangles are strips (element 'tristrips'), which msd does not read",
    ),
    (
        Ply,
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
         property float z\nend_header\n0 what 0\n",
        "line 8: '0 what 0' cannot be read",
    ),
];

#[test]
fn a_file_of_another_kind_is_named_with_what_to_do() {
    for (format, text, expected) in OTHERS {
        let message = mesh::parse(text.as_bytes(), format, "a").unwrap_err().to_string();
        assert!(message.starts_with(&format!("a: {expected}")), "{message}\n{expected}");
    }
}

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
    let error = mesh::parse(b"v 0 0 0\n".repeat(20).as_slice(), Stl, "a.stl").unwrap_err();
    let expected = "a.stl: it is text that does not begin with 'solid', as an STL file does";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn an_obj_file_may_end_its_lines_in_carriage_returns() {
    let mesh = mesh::parse(b"v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r", Obj, "a.obj");
    assert_eq!(mesh.expect("a face").triangles.len(), 1);
}

#[test]
fn a_file_that_is_not_there_is_refused_with_the_one_that_may_be_meant() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["bridge.toml", "bridge.obj", "other.toml"] {
        std::fs::write(folder.path().join(name), "").expect("a file");
    }
    let refusal = |name: &str| open(folder.path().join(name)).unwrap_err().to_string();
    assert!(refusal("brige.toml").ends_with("bridge.toml`?"), "{}", refusal("brige.toml"));
    assert!(refusal("brdge.obj").ends_with("bridge.obj`?"));
    assert!(!refusal("quite_unlike.toml").contains("did you mean"));
}

#[test]
fn a_point_without_digits_on_both_sides_is_explained() {
    for number in [".5", "-.5", "5."] {
        let error = {
            let text = format!("version = 1\n[world]\ndrag = {number}\n");
            parse(&text, SceneFormat::Toml, "s.toml").unwrap_err().to_string()
        };
        let expected = "a number has digits on both sides of its point, such as 0.5 or 5.0";
        assert!(error.starts_with("s.toml:3:") && error.ends_with(expected), "{error}");
    }
}
