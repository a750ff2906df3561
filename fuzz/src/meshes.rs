//! Meshes of any bytes.
//!
//! The first byte selects the format (o, s, p, g), the second how the mesh becomes a body.

use super::promise::check_message;
use msd_core::{Part, Scene, Settings, Simulation};
use msd_scene::mesh::{self, Filling, Format, Mesh, MeshOptions};

/// The largest mesh that is made a body, faces.
const LARGEST: usize = 300;

/// Reads bytes as a mesh, makes it a body and the body a model.
pub fn check(bytes: &[u8]) {
    let &[first, second, ref bytes @ ..] = bytes else { return };
    let format = match first {
        b'o' => Format::Obj,
        b's' => Format::Stl,
        b'p' => Format::Ply,
        _ => Format::Gltf,
    };
    match mesh::parse(bytes, format, "mesh") {
        Ok(mesh) => {
            check_mesh(&mesh);
            check_body(&mesh, second);
        }
        Err(error) => check_message(&error),
    }
}

fn check_mesh(mesh: &Mesh) {
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.positions.iter().all(|position| position.is_finite()));
    let corners = mesh.triangles.iter().flatten();
    assert!(corners.copied().all(|corner| (corner as usize) < mesh.positions.len()));
    if let Some(uvs) = &mesh.uvs {
        assert_eq!(uvs.len(), mesh.triangles.len());
        let inside = |uv: &f32| (0.0..=1.0).contains(uv);
        assert!(uvs.iter().flatten().flatten().all(inside), "{uvs:?}");
    }
    let report = mesh.report;
    assert_eq!(report.vertices_read, report.vertices + report.welded + report.unused);
    assert_eq!([report.vertices, report.triangles], [mesh.positions.len(), mesh.triangles.len()]);
}

fn check_body(mesh: &Mesh, choice: u8) {
    if LARGEST < mesh.triangles.len() {
        return;
    }
    let filling = [Filling::Auto, Filling::Solid, Filling::Shell][usize::from(choice % 3)];
    let default = MeshOptions::for_mesh(mesh, filling);
    let options = MeshOptions {
        size: [Some(1.0), None, Some(1e-9), Some(1e9)][usize::from(choice / 4 % 4)],
        // Of a mesh in its own units this is a lattice of a few points, of many, or one too fine.
        spacing: [Some(0.25), Some(1e8), Some(1e-10), None][usize::from(choice / 16 % 4)],
        ..default
    };
    // The spacing that is chosen for a mesh takes long to fill a large box.
    let options = match options {
        MeshOptions { spacing: None, size: Some(size), .. } => {
            MeshOptions { spacing: Some(size / 6.0), ..options }
        }
        options => options,
    };
    match mesh::body(mesh, &options) {
        Ok((part, report)) => {
            check_message(&report);
            assert_eq!(part.particles.len(), report.surface_particles + report.interior_particles);
            check_part(part);
        }
        Err(error) => check_message(&error),
    }
}

/// A part fits a scene, in double precision at least.
fn check_part(part: Part) {
    assert!(part.particles.iter().all(|particle| particle.position.is_finite()));
    assert!(part.springs.iter().all(|spring| spring.rest_length.is_finite()));
    let mut scene = Scene::of("mesh", part);
    scene.world.extent = 1e12;
    let settings = Settings::default();
    let double = Simulation::<f64>::new(&scene, settings).map(drop);
    for made in [double, Simulation::<f32>::new(&scene, settings).map(drop)] {
        if let Err(error) = made {
            panic!("{error}");
        }
    }
}
