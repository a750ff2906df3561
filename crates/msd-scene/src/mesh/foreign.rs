//! Files that are not the mesh that their names promise.

/// Beginnings of files, each with the format of the file and advice.
const BEGINNINGS: [(&[u8], &str); 12] = [
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself: run `git lfs pull`"),
    (b"PK\x03\x04", "a ZIP archive: unpack it"),
    (b"\x1f\x8b", "compressed by gzip: unpack it"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"Kaydara FBX", "an FBX file: export it as glTF, OBJ, STL or PLY"),
    (b"; FBX", "an FBX file: export it as glTF, OBJ, STL or PLY"),
    (b"BLENDER", "a Blender file: export it as glTF, OBJ, STL or PLY"),
    (b"\xff\xfe", "UTF-16 text: save it as UTF-8"),
    (b"\xfe\xff", "UTF-16 text: save it as UTF-8"),
    (b"<!doctype html", "an HTML page, as servers send instead of a file"),
    (b"<html", "an HTML page, as servers send instead of a file"),
];

/// The true format of a file that could not be read by its ending, if its beginning shows it.
pub(crate) fn foreign(bytes: &[u8], ending: &str) -> Option<String> {
    let start = bytes.trim_ascii_start();
    let begins =
        |with: &[u8]| start.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with));
    if let Some((_, what)) = BEGINNINGS.iter().find(|(with, _)| begins(with)) {
        return Some(format!("it is {what}"));
    }
    let other = if begins(b"glTF") {
        ("gltf", "a binary glTF file", "glb")
    } else if begins(b"ply") {
        ("ply", "a PLY file", "ply")
    } else if begins(b"solid") && start.windows(5).take(1000).any(|word| word == b"facet") {
        ("stl", "an STL file", "stl")
    } else if begins(b"<?xml") {
        return Some("it is XML: export it as glTF, OBJ, STL or PLY".into());
    } else {
        return None;
    };
    let (own, what, meant) = other;
    (own != ending).then(|| format!("it is {what}: end its name in .{meant}"))
}
