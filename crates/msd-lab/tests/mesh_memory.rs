//! Does a mesh take memory for what is there, not for what its header promises?

use cap::Cap;
use msd_lab::mesh::{self, Format};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Rows promised: positions alone would take a gigabyte.
const ROWS: u32 = 90_000_000;

fn stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(ROWS.to_le_bytes());
    bytes.resize(4000, 0);
    bytes
}

fn ply(format: &str, header: &str) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {format} 1.0\n{header}end_header\n").into_bytes();
    // The length of a list, the largest that there is in either order of bytes.
    bytes.extend([0xff; 4]);
    bytes.resize(4000, b'1');
    bytes
}

/// A structure that promises rows, with a buffer of three bytes that does not.
fn gltf(view: &str, buffer: &str) -> Vec<u8> {
    let accessor = format!(
        r#"{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{ROWS},"min":[0,0,0],
        "max":[1,1,1]}}"#
    );
    let mesh = r#"{"primitives":[{"attributes":{"POSITION":0}}]}"#;
    format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{mesh}],"accessors":[{accessor}],
        "bufferViews":[{{"buffer":0,"byteLength":{view}}}],
        "buffers":[{{"uri":"data:;base64,AAAA","byteLength":{buffer}}}]}}"#
    )
    .into_bytes()
}

fn glb() -> Vec<u8> {
    let mut bytes = b"glTF".to_vec();
    for length in [2, 1 << 30, 1 << 29] {
        bytes.extend(u32::to_le_bytes(length));
    }
    bytes.extend(b"JSON{}");
    bytes
}

#[test]
fn a_header_that_promises_a_gigabyte_takes_a_megabyte_at_most() {
    let vertices = format!("element vertex {ROWS}\nproperty float x\n");
    let list = "element face 1\nproperty list uint float vertex_indices\n";
    let mut files = vec![("stl", Format::Stl, stl()), ("glb", Format::Gltf, glb())];
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        files.push((format, Format::Ply, ply(format, &vertices)));
        files.push((format, Format::Ply, ply(format, list)));
    }
    for (view, buffer) in [("3", "3"), ("1080000000", "3"), ("1080000000", "1080000000")] {
        files.push(("gltf", Format::Gltf, gltf(view, buffer)));
    }
    for (name, format, bytes) in files {
        let before = ALLOCATOR.total_allocated();
        let error = mesh::parse(&bytes, format, name).expect_err("a promise that is not kept");
        // The text, its lines and what is read of it: some copies of 4 kB.
        let taken = ALLOCATOR.total_allocated() - before;
        assert!(taken <= 1 << 20, "{taken} bytes to find out that {error}");
    }
}
