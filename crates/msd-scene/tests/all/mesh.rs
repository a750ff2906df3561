//! Facts about reading meshes: four formats, one mesh.

use msd_core::glam::DVec3;
use msd_scene::mesh::{self, Format, Mesh};
use std::path::Path;

/// The faces of a unit cube, outward.
const QUADS: [[usize; 4]; 6] =
    [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn cube() -> [[f32; 3]; 8] {
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        .map(|corner| corner.map(|value| value as f32))
}

fn triangles() -> Vec<[usize; 3]> {
    QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn obj() -> String {
    let mut text = String::from("# cube\no cube\n");
    for [x, y, z] in cube() {
        text += &format!("v {x} {y} {z}\n");
    }
    for quad in QUADS {
        let [a, b, c, d] = quad.map(|corner| corner + 1);
        text += &format!("f {a} {b} {c} {d}\n");
    }
    text
}

fn ascii_stl() -> String {
    let mut text = String::from("solid\n");
    for triangle in triangles() {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle.map(|corner| cube()[corner]) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid\n"
}

fn binary_stl() -> Vec<u8> {
    // A header that starts like a text, as some programs write.
    let mut bytes = b"solid cube".to_vec();
    bytes.resize(80, 0);
    bytes.extend(12u32.to_le_bytes());
    for triangle in triangles() {
        let corners = triangle.map(|corner| cube()[corner]);
        let numbers = [[0.0; 3], corners[0], corners[1], corners[2]];
        bytes.extend(numbers.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

fn ply(format: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex 8\nproperty float x\nproperty float y\n\
         property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let float = |value: f32| match format {
        "binary_big_endian" => value.to_be_bytes(),
        _ => value.to_le_bytes(),
    };
    let int = |value: usize| match format {
        "binary_big_endian" => (value as i32).to_be_bytes(),
        _ => (value as i32).to_le_bytes(),
    };
    for [x, y, z] in cube() {
        match format {
            "ascii" => bytes.extend(format!("{x} {y} {z}\n").bytes()),
            _ => bytes.extend([x, y, z].into_iter().flat_map(float)),
        }
    }
    for [a, b, c, d] in QUADS {
        match format {
            "ascii" => bytes.extend(format!("4 {a} {b} {c} {d}\n").bytes()),
            _ => bytes.extend([4].into_iter().chain([a, b, c, d].into_iter().flat_map(int))),
        }
    }
    bytes
}

/// The numbers of the cube: 96 bytes of positions, 72 of indices.
fn gltf_buffer() -> Vec<u8> {
    let positions = cube().into_iter().flatten().flat_map(f32::to_le_bytes);
    let indices = triangles().into_iter().flatten().flat_map(|i| (i as u16).to_le_bytes());
    positions.chain(indices).collect()
}

fn gltf_json(uri: &str, node: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3",
        "min":[0,0,0],"max":[1,1,1]}},
        {{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":96}},
        {{"buffer":0,"byteOffset":96,"byteLength":72}}],
        "buffers":[{{{uri}"byteLength":168}}]}}"#
    )
}

fn glb() -> Vec<u8> {
    let mut json = gltf_json("", "").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let buffer = gltf_buffer();
    let mut bytes = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + buffer.len();
    for number in [2, length as u32, json.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

fn base64(bytes: &[u8]) -> String {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    // The buffer is a multiple of three bytes long: no padding.
    let groups = bytes.chunks_exact(3).flat_map(|b| {
        let bits = u32::from_be_bytes([0, b[0], b[1], b[2]]);
        [18, 12, 6, 0].map(|shift| digits[(bits >> shift & 63) as usize] as char)
    });
    groups.collect()
}

/// Every way to write the cube.
fn cubes() -> Vec<(&'static str, Format, Vec<u8>)> {
    let data =
        format!(r#""uri":"data:application/octet-stream;base64,{}","#, base64(&gltf_buffer()));
    vec![
        ("cube.obj", Format::Obj, obj().into_bytes()),
        ("ascii.stl", Format::Stl, ascii_stl().into_bytes()),
        ("binary.stl", Format::Stl, binary_stl()),
        ("ascii.ply", Format::Ply, ply("ascii")),
        ("little.ply", Format::Ply, ply("binary_little_endian")),
        ("big.ply", Format::Ply, ply("binary_big_endian")),
        ("cube.gltf", Format::Gltf, gltf_json(&data, "").into_bytes()),
        ("cube.glb", Format::Gltf, glb()),
    ]
}

fn parse(name: &str, format: Format, bytes: &[u8]) -> Mesh {
    mesh::parse(bytes, format, name).unwrap()
}

#[test]
fn the_same_cube_in_every_format_is_the_same_mesh() {
    let expected = parse("cube.obj", Format::Obj, obj().as_bytes());
    for (name, format, bytes) in cubes() {
        let mesh = parse(name, format, &bytes);
        assert_eq!(mesh.positions, expected.positions, "{name}");
        assert_eq!(mesh.triangles, expected.triangles, "{name}");
        assert!(mesh.is_closed(), "{name}");
    }
}

#[test]
fn the_corners_of_an_stl_cube_are_welded() {
    let mesh = parse("cube.stl", Format::Stl, &binary_stl());
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12));
    assert_eq!((mesh.report.vertices_read, mesh.report.welded), (36, 28));
}

#[test]
fn the_bunny_is_closed_and_the_teapot_is_not() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes");
    let bunny = mesh::read(&folder.join("bunny.obj")).unwrap();
    assert!(bunny.is_closed());
    assert_eq!((bunny.positions.len(), bunny.triangles.len()), (1839, 3674));
    // Euler: V − E + F = 2 for a sphere, with three edges for two faces.
    assert_eq!(1839 - 3 * 3674 / 2 + 3674, 2);
    assert_eq!((bunny.report.components, bunny.report.turned), (1, 0));
    let teapot = mesh::read(&folder.join("teapot.obj")).unwrap();
    assert!(!teapot.is_closed());
    assert_eq!(teapot.report.open_edges, 64);
    assert_eq!((teapot.report.vertices_read, teapot.report.welded), (792, 263));
    assert_eq!(
        teapot.report.to_string(),
        "read 792 vertices (263 welded, 0 unused) and 992 triangles (0 degenerate and 0 \
         duplicate dropped, 0 turned)\n529 vertices, 992 triangles, 3 components, open: 64 open \
         edges, 0 edges with more than two faces"
    );
}

#[test]
fn what_is_dropped_is_counted() {
    let mut text = obj();
    // Vertex 9 is vertex 1 again, 10 lies between 1 and 2, 11 is used by no face.
    text += "v 1e-7 0 0\nv 0.5 0 0\nv 7 7 7\n";
    text += "f 9 1 2\nf 1 10 2\nf 4 3 2\nf 2 3 4\n";
    let report = parse("cube.obj", Format::Obj, text.as_bytes()).report;
    assert_eq!((report.welded, report.unused), (1, 2));
    assert_eq!((report.degenerate, report.duplicate), (2, 2));
    assert_eq!((report.triangles_read, report.triangles), (16, 12));
    assert_eq!(report.vertices_read, report.vertices + report.welded + report.unused);
}

/// The area of all triangles.
fn area(mesh: &Mesh) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|corner| mesh.positions[corner as usize]);
        (b - a).cross(c - a).length() / 2.0
    };
    mesh.triangles.iter().map(of).sum()
}

/// One face as an OBJ and as a PLY file.
fn one_face(corners: &[[i32; 2]]) -> [Mesh; 2] {
    let (mut obj, mut ply) = (String::new(), String::from("ply\nformat ascii 1.0\n"));
    ply += &format!("element vertex {}\nproperty float x\nproperty float y\n", corners.len());
    ply += "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    // On a slope, so that no coordinate is zero everywhere.
    for [x, y] in corners {
        obj += &format!("v {x} {y} {y}\n");
        ply += &format!("{x} {y} {y}\n");
    }
    let numbers = |first: usize| {
        let numbers = (0..corners.len()).map(|corner| (corner + first).to_string());
        numbers.collect::<Vec<_>>().join(" ")
    };
    obj += &format!("f {}\n", numbers(1));
    ply += &format!("{} {}\n", corners.len(), numbers(0));
    [parse("obj", Format::Obj, obj.as_bytes()), parse("ply", Format::Ply, ply.as_bytes())]
}

#[test]
fn concave_faces_cover_what_their_outline_encloses_and_leave_holes_open() {
    let slope = 2f64.sqrt();
    let dart = vec![[0, 0], [4, 1], [0, 4], [1, 1]];
    let gamma = vec![[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]];
    // A square of 6 x 6 with a hole of 2 x 2, to which a slit leads.
    let outline = [[0, 0], [6, 0], [6, 6], [0, 6], [0, 0]];
    let hole = [[2, 2], [2, 4], [4, 4], [4, 2], [2, 2]];
    let keyhole: Vec<[i32; 2]> = outline.into_iter().chain(hole).collect();
    // Its first corner once more at the end, as some programs write.
    let closed = gamma.iter().copied().chain([gamma[0]]).collect();
    let cases = [(dart, 6.0), (gamma, 5.0), (closed, 5.0), (keyhole, 32.0)];
    for (corners, expected) in cases {
        for start in 0..corners.len() {
            let mut corners = corners.clone();
            corners.rotate_left(start);
            for mesh in one_face(&corners) {
                let area = area(&mesh);
                assert!((area - expected * slope).abs() < 1e-12, "{corners:?}: {area}");
                assert_eq!((mesh.report.crossed, mesh.report.degenerate), (0, 0), "{corners:?}");
            }
        }
    }
}

#[test]
fn a_concave_face_of_too_many_corners_is_refused_with_its_line() {
    let mut comb = vec![[0, -1]];
    comb.extend((0..=5000).flat_map(|i| [[2 * i, 9], [2 * i + 1, 0]]));
    let text: String = comb.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
    let numbers: String = (1..=comb.len()).map(|corner| format!(" {corner}")).collect();
    let refused = mesh::parse(format!("{text}f{numbers}\n").as_bytes(), Format::Obj, "comb.obj");
    assert_eq!(
        refused.unwrap_err().to_string(),
        "comb.obj: line 10004: the number of corners is 10003; it must be at most 10000 where the \
         face is concave: cut it up"
    );
}

#[test]
fn a_corner_on_a_straight_side_leaves_no_crack() {
    // A cube, two faces of which have a corner in the middle of the edge that they share.
    let text = obj().replace("f 4 3 2 1\n", "v 0.5 0 0\nf 4 3 2 9 1\n");
    for face in ["f 1 9 2 6 5\n", "f 9 2 6 5 1\n", "f 2 6 5 1 9\n", "f 6 5 1 9 2\n"] {
        let mesh = parse("cube", Format::Obj, text.replace("f 1 2 6 5\n", face).as_bytes());
        assert!(mesh.is_closed(), "{face}{}", mesh.report);
        assert_eq!((mesh.positions.len(), area(&mesh)), (9, 6.0));
    }
}

#[test]
fn a_face_that_crosses_itself_is_counted() {
    for mesh in one_face(&[[0, 0], [2, 2], [2, 0], [0, 1]]) {
        assert_eq!(mesh.report.crossed, 1);
        assert!(mesh.report.to_string().contains("1 faces cross themselves"), "{}", mesh.report);
    }
}

#[test]
fn faces_are_turned_to_agree_and_to_face_outward() {
    let expected = parse("cube.obj", Format::Obj, obj().as_bytes());
    let flipped = |faces: &[usize]| {
        let mut text: String = obj().lines().take(10).map(|line| format!("{line}\n")).collect();
        for (row, [a, b, c]) in triangles().into_iter().enumerate() {
            let [a, b, c] = if faces.contains(&row) { [a, c, b] } else { [a, b, c] };
            text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        }
        parse("cube.obj", Format::Obj, text.as_bytes())
    };
    for faces in [vec![0], vec![3, 4, 9], (0..12).collect(), (1..12).collect()] {
        let mesh = flipped(&faces);
        assert_eq!(mesh.report.turned, faces.len());
        let volume = |mesh: &Mesh| {
            let at = |corner: u32| mesh.positions[corner as usize];
            mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c)))).sum::<f64>() / 6.0
        };
        assert!((volume(&mesh) - volume(&expected)).abs() <= 1e-15);
    }
}

#[test]
fn a_void_inside_a_solid_stays_a_void() {
    let corners = |scale: f64| cube().map(|c| scale * (DVec3::from(c.map(f64::from)) - 0.5));
    let mut text = String::new();
    for corner in corners(1.0).into_iter().chain(corners(0.5)) {
        text += &format!("v {} {} {}\n", corner.x, corner.y, corner.z);
    }
    for [a, b, c] in triangles() {
        text += &format!("f {} {} {}\nf {} {} {}\n", a + 1, b + 1, c + 1, a + 9, c + 9, b + 9);
    }
    let mesh = parse("hollow.obj", Format::Obj, text.as_bytes());
    assert_eq!((mesh.report.turned, mesh.report.components), (0, 2));
    let (part, report) = mesh::body(&mesh, &mesh::MeshOptions::default()).unwrap();
    assert!((report.volume - (1.0 - 0.125)).abs() <= 1e-15);
    let interior = &part.particles[report.surface_particles..];
    assert!(!interior.is_empty());
    assert!(interior.iter().all(|p| 0.25 < p.position.abs().max_element()));
}

#[test]
fn an_edge_with_three_faces_is_counted_and_is_not_closed() {
    let text = obj() + "v 2 2 0.5\nf 3 7 9\n";
    let mesh = parse("fin.obj", Format::Obj, text.as_bytes());
    assert_eq!((mesh.report.non_manifold_edges, mesh.report.open_edges), (1, 2));
    assert!(!mesh.is_closed());
}

#[test]
fn gltf_nodes_place_their_meshes() {
    let data = format!(r#""uri":"data:;base64,{}","#, base64(&gltf_buffer()));
    let node = r#","translation":[10,0,0],"scale":[-2,2,2]"#;
    let mesh = parse("cube.gltf", Format::Gltf, gltf_json(&data, node).as_bytes());
    let low = mesh.positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = mesh.positions.iter().copied().fold(DVec3::MIN, DVec3::max);
    assert_eq!((low, high), (DVec3::new(8.0, 0.0, 0.0), DVec3::new(10.0, 2.0, 2.0)));
    // The mirror image was turned over by its node already.
    assert_eq!(mesh.report.turned, 0);
}

#[test]
fn nodes_and_materials_of_a_gltf_name_their_triangles() {
    let data = format!(r#""uri":"data:;base64,{}","#, base64(&gltf_buffer()));
    let text = gltf_json(&data, r#","name":"the box""#)
        .replace(r#""indices":1}"#, r#""indices":1,"material":0}"#);
    let text = text.replace(r#""scene":0"#, r#""materials":[{"name":"paint"}],"scene":0"#);
    let mesh = parse("cube.gltf", Format::Gltf, text.as_bytes());
    let names: Vec<_> = mesh.groups.iter().map(|group| (&*group.name, &group.triangles)).collect();
    assert_eq!(names, [("paint", &(0..12)), ("the box", &(0..12))]);
}

#[test]
fn a_gltf_buffer_may_lie_beside_its_file_but_not_above() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my cube.bin"), gltf_buffer()).unwrap();
    let path = folder.path().join("CUBE.GLTF");
    std::fs::write(&path, gltf_json(r#""uri":"my%20cube.bin","#, "")).unwrap();
    assert_eq!(mesh::read(&path).unwrap().triangles.len(), 12);
    for uri in ["../my cube.bin", "/etc/passwd", "http://x/y.bin"] {
        std::fs::write(&path, gltf_json(&format!(r#""uri":"{uri}","#), "")).unwrap();
        let error = mesh::read(&path).unwrap_err().to_string();
        assert!(error.contains("does not lie beside or below the file"), "{error}");
    }
}

#[test]
fn texture_coordinates_follow_their_corners() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let mesh = parse("sheet.obj", Format::Obj, text.as_bytes());
    // Beyond 1 they are scaled down.
    assert_eq!(mesh.uvs, Some(vec![[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]));
    let half = text.to_owned() + "v 1 1 0\nf 2 4 3\n";
    assert_eq!(parse("half.obj", Format::Obj, half.as_bytes()).uvs, None);
    // Indices into a map that is not there.
    let none = text.replace("vt 0 0\nvt 2 0\nvt 0 1\n", "");
    let mesh = parse("none.obj", Format::Obj, none.as_bytes());
    assert_eq!((mesh.triangles.len(), mesh.uvs), (1, None));
}

/// However many accessors lack their numbers, all of which the format's own check would list.
#[test]
fn a_compressed_gltf_is_refused_by_the_name_of_its_compression() {
    for extension in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
        for count in [2, 12] {
            let accessors = vec![r#"{"componentType":5126,"count":3,"type":"VEC3"}"#; count];
            let accessors = accessors.join(",");
            let text = format!(
                r#"{{"asset":{{"version":"2.0"}},"extensionsRequired":["{extension}"],
                "accessors":[{accessors}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]}}"#
            );
            let error = mesh::parse(text.as_bytes(), Format::Gltf, "box.gltf").unwrap_err();
            let error = error.to_string();
            assert!(error.contains(extension) && error.len() < 200, "{error}");
            assert!(error.contains("export it without compression"), "{error}");
        }
    }
}

#[test]
fn quantised_numbers_of_a_gltf_are_read_and_other_extensions_refused_by_name() {
    // Corners of the cube from 0 to 2 in unsigned bytes, from -1 to 1 in normalised ones.
    for (normalized, kind, scale) in [(false, 5121, 2.0), (true, 5120, 127.0)] {
        let corners = cube().into_iter().flatten();
        let positions: Vec<u8> = corners.map(|x| (x * scale) as u8).collect();
        let indices = triangles().into_iter().flatten().flat_map(|i| (i as u16).to_le_bytes());
        let bytes: Vec<u8> = positions.into_iter().chain(indices).collect();
        let uri = format!(r#""uri":"data:;base64,{}","#, base64(&bytes));
        let text = gltf_json(&uri, r#","scale":[3,3,3]"#)
            .replace(r#""asset""#, r#""extensionsRequired":["KHR_mesh_quantization"],"asset""#)
            .replace("5126", &format!(r#"{kind},"normalized":{normalized}"#))
            .replace(r#""byteLength":96"#, r#""byteLength":24"#)
            .replace(r#""byteOffset":96"#, r#""byteOffset":24"#)
            .replace("168", "96");
        let mesh = parse("quantised.gltf", Format::Gltf, text.as_bytes());
        let expected = if normalized { 3.0 } else { 6.0 };
        assert_eq!((mesh.positions.len(), mesh.is_closed()), (8, true));
        let high = mesh.positions.iter().copied().fold(DVec3::MIN, DVec3::max);
        assert_eq!(high, DVec3::splat(expected));

        let text = text.replace("KHR_mesh_quantization", "EXT_mesh_gpu_instancing");
        let error = mesh::parse(text.as_bytes(), Format::Gltf, "box.gltf").unwrap_err();
        assert_eq!(
            error.to_string(),
            "box.gltf: it requires EXT_mesh_gpu_instancing, which msd does not read; export it \
             without"
        );
    }
}

#[test]
fn a_gltf_of_version_1_is_refused_by_its_version() {
    let named = r#"{"asset":{"version":"1.0"},"meshes":{"box":{"primitives":[]}}}"#;
    let bare = r#"{"meshes":{"box":{"primitives":[]}}}"#;
    let binary = b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0";
    for bytes in [named.as_bytes(), bare.as_bytes(), binary] {
        let error = mesh::parse(bytes, Format::Gltf, "old").unwrap_err().to_string();
        assert!(error.starts_with("old: it is glTF 1"), "{error}");
        assert!(error.ends_with("it must be glTF 2.0: export it anew, or convert it"), "{error}");
    }
}

#[test]
fn a_byte_order_mark_hides_nothing() {
    for (name, format, bytes) in cubes() {
        let text = String::from_utf8(bytes).ok().filter(|text| !text.contains('\0'));
        let Some(text) = text else { continue };
        let mesh = parse(name, format, format!("\u{feff}{text}").as_bytes());
        assert_eq!((mesh.positions.len(), mesh.is_closed()), (8, true), "{name}");
    }
    let obj = obj();
    let from_vertex = obj.split_once("cube\nv").unwrap().1.replace("o cube", "");
    let mesh = parse("cube", Format::Obj, format!("\u{feff}v{from_vertex}").as_bytes());
    assert_eq!(mesh.positions.len(), 8);
}

#[test]
fn a_binary_stl_that_begins_with_solid_may_go_on_after_its_facets() {
    let whole = binary_stl();
    let cube = parse("cube.stl", Format::Stl, &whole);
    let longer = [&whole[..], b"\x01\0trail"].concat();
    let mesh = parse("cube.stl", Format::Stl, &longer);
    assert_eq!((&mesh.positions, &mesh.triangles), (&cube.positions, &cube.triangles));
    // And a line break in the header.
    let mut broken = longer;
    broken[10] = b'\n';
    assert_eq!(parse("cube.stl", Format::Stl, &broken).triangles, cube.triangles);
    let error = mesh::parse(&whole[..400], Format::Stl, "cube.stl").unwrap_err().to_string();
    assert_eq!(error, "cube.stl: the header announces 600 bytes of facets, but only 316 follow");
}

#[test]
fn no_truncated_or_damaged_file_panics() {
    for (name, format, bytes) in cubes() {
        for end in 0..bytes.len() {
            let _ = mesh::parse(&bytes[..end], format, name);
        }
        for (at, value) in (0..bytes.len()).flat_map(|at| [0x00, 0x39, 0xff].map(|v| (at, v))) {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            let mesh = mesh::parse(&damaged, format, name);
            // A body of every eleventh: most damage leaves the shape alone.
            if let Ok(mesh) = mesh
                && at % 11 == 0
            {
                let _ = mesh::body(&mesh, &mesh::MeshOptions::default());
            }
        }
    }
}
