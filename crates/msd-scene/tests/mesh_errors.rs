//! Facts about what mesh import refuses: one line each, with the file, the row and the domain.

use msd_scene::mesh::{self, Format};
use std::path::Path;

fn refused(format: Format, bytes: &[u8]) -> String {
    let message = mesh::parse(bytes, format, "bad").unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

fn obj(text: &str) -> String {
    refused(Format::Obj, text.as_bytes())
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn a_face_with_fewer_than_three_corners_is_refused_with_its_row() {
    let expected = "bad: line 5: the number of corners is 2; it must be at least 3";
    assert_eq!(obj(&format!("{TRIANGLE}f 1 2\n")), expected);
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 2\nproperty list uchar int vertex_index\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n";
    let expected = "bad: face 1: the number of corners is 2; it must be at least 3";
    assert_eq!(refused(Format::Ply, ply.as_bytes()), expected);
}

#[test]
fn an_index_that_names_no_vertex_is_refused_with_its_row() {
    let expected = "bad: line 5: a vertex index is 4; it must be from 1 to 3, or from -3 to -1";
    assert_eq!(obj(&format!("{TRIANGLE}f 1 2 4\n")), expected);
    for face in ["f 1 2 0", "f 1 2 -4", "f 1 2 x", "f 1 2 99999999999999999999", "f 1/1 2/1 3/1"] {
        let message = obj(&format!("{TRIANGLE}{face}\n"));
        assert!(message.starts_with("bad: line 5: a "), "{message}");
    }
    // A negative index counts back.
    let mesh = mesh::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", Format::Obj, "back");
    assert_eq!(mesh.unwrap().triangles, [[0, 1, 2]]);
}

#[test]
fn a_coordinate_that_is_no_usable_number_is_refused_with_its_row() {
    let expected = "bad: line 1: y is NaN; it must be finite and within ±1e9";
    assert_eq!(obj("v 0 NaN 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), expected);
    assert_eq!(obj("v 0 zero 0\n"), "bad: line 1: 'zero' is not a number");
    assert_eq!(
        obj("v 0 1\n"),
        "bad: line 1: the number of coordinates is 2; it must be at least 3"
    );
    assert!(obj("v 1 1 1 0\n").contains("x is inf"));
    let mut stl = vec![0; 80];
    stl.extend(1u32.to_le_bytes());
    stl.extend([0; 48]);
    stl.extend([0, 0]);
    stl[84 + 12..84 + 16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let expected = "bad: vertex 0: x is inf; it must be finite and within ±1e9";
    assert_eq!(refused(Format::Stl, &stl), expected);
}

#[test]
fn a_polyline_is_no_face() {
    let text = format!("{TRIANGLE}v 5 5 5\nl 1 2 4\np 1\n");
    let mesh = mesh::parse(text.as_bytes(), Format::Obj, "lines").unwrap();
    assert_eq!((mesh.triangles.len(), mesh.report.unused), (1, 1));
}

#[test]
fn a_mesh_without_a_face_that_has_an_area_is_refused() {
    assert_eq!(obj("hello world\n"), "bad: no faces found");
    assert_eq!(obj(""), "bad: no faces found");
    let line = obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    assert_eq!(line, "bad: no face with an area is left of 1 read");
}

#[test]
fn a_header_that_announces_four_billion_rows_is_refused_at_once() {
    let mut stl = vec![0; 80];
    stl.extend(u32::MAX.to_le_bytes());
    let expected = "bad: the header announces 214748364750 bytes of facets, but only 0 follow";
    assert_eq!(refused(Format::Stl, &stl), expected);
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for element in ["vertex 4294967295\nproperty float x", "nothing 18446744073709551615"] {
            let ply = format!("ply\nformat {format} 1.0\nelement {element}\nend_header\n1 2 3\n");
            let message = refused(Format::Ply, ply.as_bytes());
            assert!(message.starts_with("bad: the header announces"), "{message}");
        }
    }
    let gltf = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":
        {"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3",
        "count":4294967295,"min":[0,0,0],"max":[1,1,1]}],"bufferViews":[{"buffer":0,
        "byteLength":3}],"buffers":[{"uri":"data:;base64,AAAA","byteLength":3}]}"#;
    let expected = "bad: accessor 0: it reaches beyond its buffer view";
    assert_eq!(refused(Format::Gltf, gltf.as_bytes()), expected);
}

#[test]
fn a_gltf_whose_nodes_run_in_a_circle_is_refused() {
    let gltf = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],
        "nodes":[{"children":[1]},{"children":[0]}]}"#;
    let expected = "bad: node 0 has more than one parent";
    assert_eq!(refused(Format::Gltf, gltf.as_bytes()), expected);
}

#[test]
fn a_parsed_gltf_touches_no_other_file() {
    let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":3}]}"#;
    let expected = "bad: buffer 'a.bin' lies in another file; read it by path, or as .glb";
    assert_eq!(refused(Format::Gltf, gltf.as_bytes()), expected);
}

#[test]
fn a_text_cut_short_is_refused() {
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
    let expected = "bad: the text ends without 'endsolid'; the file is cut short";
    assert_eq!(refused(Format::Stl, stl.as_bytes()), expected);
    let message = refused(Format::Stl, b"solid a\nfacet normal 0 0 1\nendsolid a\n");
    assert!(message.starts_with("bad: facet 0: "), "{message}");
    assert!(refused(Format::Ply, b"ply\nformat ascii 1.0\n").starts_with("bad: line "));
}

#[test]
fn a_file_is_known_by_its_ending() {
    let message = |path: &str| mesh::read(Path::new(path)).unwrap_err().to_string();
    assert_eq!(
        message("scene.toml"),
        "scene.toml: unknown mesh format 'toml'; it must be one of obj, stl, ply, gltf, glb"
    );
    assert!(message("not/there.OBJ").starts_with("not/there.OBJ: cannot be read: "));
}

#[test]
fn what_a_mesh_file_holds_cannot_move_the_cursor_of_a_terminal() {
    let ply = refused(Format::Ply, b"ply\nformat ascii 1.0\nelement \x1b[2J 1\nend_header\n");
    for message in [ply, obj("v 0 \u{1b}[2J 0\n"), obj(&format!("{TRIANGLE}f 1 2 \u{1b}[2J\n"))] {
        assert!(!message.contains(char::is_control), "{message:?}");
    }
}
