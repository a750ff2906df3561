//! Memory that reading takes: of a mesh not for the promises of its header, of a scene file at most
//! the estimate.

use cap::Cap;
use msd_scene::mesh::{self, Format};
use msd_scene::{SceneFormat, parse};
use std::alloc::System;
use std::sync::Mutex;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// The measurement is of the whole program.
static ALONE: Mutex<()> = Mutex::new(());

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
    let _alone = ALONE.lock();
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
        // The text, its lines and the parts read of it: some copies of 4 kB.
        let taken = ALLOCATOR.total_allocated() - before;
        assert!(taken <= 1 << 20, "{taken} bytes to find out that {error}");
    }
}

#[test]
fn a_text_of_31_mebibytes_that_would_fill_the_memory_is_refused_before_it_is_read() {
    let _alone = ALONE.lock();
    let (toml, json) = (SceneFormat::Toml, SceneFormat::Json);
    for (format, start, row) in [
        (toml, "a = [", "0,"),
        (toml, "a = [", "[],"),
        (toml, "a = [", "{a=0},"),
        (toml, "", "[k0]\n"),
        (toml, "", "[[k]]\n"),
        (toml, "", "k0.a=0\n"),
        (toml, "a = [", "{ ends = [0, 1] },"),
        (toml, "a = [", "{ position = [0.1, 0.2, 0.3] },"),
        (toml, "a = 0", "\n"),
        (json, "[", "0,"),
        (json, "[", "[],"),
        (json, "[", "{\"a\":0},"),
    ] {
        let text = format!("{start}{}", row.repeat((31 << 20) / row.len()));
        let before = ALLOCATOR.total_allocated();
        let error = parse(&text, format, "s").expect_err(row).to_string();
        assert!(error.contains("so many values that reading them would take"), "{row}: {error}");
        assert!(ALLOCATOR.total_allocated() - before < 1 << 20, "{row}");
    }
}

#[test]
fn a_text_takes_no_more_memory_than_is_estimated_before_it_is_read() {
    let _alone = ALONE.lock();
    // A 300th of the largest: the estimate is a sum over the text.
    let most = 1_500_000_000 / 300;
    let (toml, json) = (SceneFormat::Toml, SceneFormat::Json);
    for (format, start, row, end, each) in [
        (toml, "a = [", "0,", "]", 160),
        (toml, "a = [", "[],", "]", 460),
        (toml, "a = [", "{a=0},", "]", 1720),
        (toml, "", "[k#]\n", "", 350),
        (toml, "", "[[k]]\n", "", 650),
        (toml, "", "k#.a=0\n", "", 1510),
        (toml, "a = [", "{ ends = [0, 1] },", "]", 2180),
        (json, "[", "0,", "0]", 100),
        (json, "[", "[],", "0]", 360),
        (json, "[", "{\"a\":0},", "0]", 800),
        (json, "{\"a\":0", ",\"#\":0", "}", 300),
    ] {
        let rows: String =
            (0..most / each).map(|number| row.replace('#', &number.to_string())).collect();
        let text = format!("{start}{rows}{end}");
        let held = ALLOCATOR.allocated();
        // An allocation beyond the limit aborts the program; a fifth more is for growing lists.
        ALLOCATOR.set_limit(held + most + most / 5).expect("room");
        let refused = parse(&text, format, "s").is_err();
        ALLOCATOR.set_limit(usize::MAX).expect("room");
        assert!(refused, "{row}");
    }
}
