//! Scenes at a part of their spacing: the same bodies, finer.

use msd_core::glam::DVec3;
use msd_core::{Scene, Spring};
use msd_scene::{Draft, FileError, Finer, Loaded};
use std::path::Path;

/// A scene, and the same with its spacing halved so many times.
fn refined(text: &str, halvings: u32) -> Result<(Loaded, Finer), FileError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    opened(&Draft::open(Path::new("scene.toml"), folder.path())?, halvings)
}

fn opened(draft: &Draft, halvings: u32) -> Result<(Loaded, Finer), FileError> {
    let source = draft.source()?;
    let coarse = draft.load(&source)?;
    let finer = draft.finer(&source, &coarse.scene, halvings)?;
    Ok((coarse, finer))
}

fn builtin(name: &str, halvings: u32) -> (Loaded, Finer) {
    opened(&Draft::open(Path::new(name), Path::new("")).unwrap(), halvings).unwrap()
}

/// The stress of a uniform strain of size 1 along x, times the volume: Σ k L² nx⁴, joules. Where
/// the constants follow the continuum it does not change with the spacing.
fn stretch(scene: &Scene) -> f64 {
    let of = |spring: &Spring| {
        let [a, b] = spring.ends.map(|end| scene.particles[end].position);
        let across = b - a;
        spring.stiffness * across.x.powi(4) / across.length_squared()
    };
    scene.springs.iter().map(of).sum()
}

fn mass(scene: &Scene) -> f64 {
    scene.particles.iter().map(|particle| particle.mass).sum()
}

fn assert_same_places(coarse: &Loaded, finer: &Finer) {
    assert!(!finer.common.is_empty());
    for &[before, after] in &finer.common {
        let before = coarse.scene.particles[before];
        let after = finer.loaded.scene.particles[after];
        // A few roundings of coordinates of some metres.
        assert!(before.position.distance(after.position) < 1e-13, "{before:?} {after:?}");
    }
}

const GELATINE: &str = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [4, 3, 5]\nspacing = 0.1\n\
                        young = 1e4\ndensity = 1000\nrelaxation_time = 1e-3\n\
                        position = [0, 1, 0]\nrotation = { axis = [0, 0, 1], angle_deg = 30 }\n";

#[test]
fn a_body_of_a_material_keeps_its_places_mass_and_moduli() {
    let sheet = "version = 1\n[[bodies]]\nkind = 'cloth'\nsize = [4, 3]\nspacing = 0.1\n\
                 young = 1e4\nthickness = 1e-3\ndensity = 1000\n";
    let rope = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [4]\nspacing = 0.1\n\
                young = 1e4\ndiameter = 1e-2\ndensity = 1000\n";
    let straight = GELATINE.replace("rotation = { axis = [0, 0, 1], angle_deg = 30 }\n", "");
    for (text, dimensions) in [(straight.as_str(), 3), (sheet, 2), (rope, 1)] {
        for halvings in [1, 2] {
            let (coarse, finer) = refined(text, halvings).unwrap();
            let fine = &finer.loaded.scene;
            assert_eq!(finer.common.len(), coarse.scene.particles.len());
            assert_same_places(&coarse, &finer);
            assert!((mass(fine) / mass(&coarse.scene) - 1.0).abs() < 1e-13);
            let ratio = stretch(fine) / stretch(&coarse.scene);
            // A sum of some thousand springs.
            assert!((ratio - 1.0).abs() < 1e-12, "{dimensions}: {ratio}");
        }
    }
    let (coarse, finer) = refined(GELATINE, 1).unwrap();
    assert_same_places(&coarse, &finer);
}

/// Springs and masses of the particles inside, where no face counts in full.
#[test]
fn a_body_of_alike_springs_keeps_its_density_and_its_moduli_inside() {
    let text = |kind: &str, size: &str| {
        format!(
            "version = 1\n[[bodies]]\nkind = '{kind}'\nsize = {size}\nspacing = 0.5\nmass = 3\n\
             stiffness = 70\ndamping = 2\n"
        )
    };
    // Stiffness over spacing to the power of dimensions less two, mass over spacing to that of
    // dimensions.
    for (kind, size, dimensions) in [
        ("block", "[3, 4, 5]", 3),
        ("cloth", "[3, 4]", 2),
        ("rope", "[5]", 1),
        ("block", "[1, 3, 4]", 2),
    ] {
        let (coarse, finer) = refined(&text(kind, size), 2).unwrap();
        let fine = &finer.loaded.scene;
        assert_same_places(&coarse, &finer);
        let parts = 4f64;
        let spring = fine.springs[0];
        assert_eq!(spring.stiffness, 70.0 * parts.powi(2 - dimensions), "{kind}");
        assert_eq!(spring.damping, 2.0 * parts.powi(2 - dimensions), "{kind}");
        assert_eq!(fine.particles[0].mass, 3.0 * parts.powi(-dimensions), "{kind}");
        assert_eq!(spring.rest_length, 0.125, "{kind}");
    }
}

#[test]
fn what_lies_between_pins_is_pinned_and_moves_between_them() {
    let text = "version = 1\n[[bodies]]\nkind = 'cloth'\nsize = [3, 4]\n\
                [[pins]]\nevery = 1\n\
                [[pins]]\nat = [0, 0, 0]\nvelocity = [1, 0, 0]\n\
                [[pins]]\nparticle = 1\nvelocity = [3, 0, 0]\n\
                [[pins]]\nat = [0, 3, 0]\n";
    let (_, finer) = refined(text, 1).unwrap();
    let scene = &finer.loaded.scene;
    let pinned = |row: usize| -> Vec<(usize, f64)> {
        let range = 7 * row..7 * (row + 1);
        let pins = scene.pins.iter().filter(|pin| range.contains(&pin.particle));
        let mut pins: Vec<(usize, f64)> =
            pins.map(|pin| (pin.particle - 7 * row, pin.velocity.x)).collect();
        pins.sort_by_key(|pin| pin.0);
        pins
    };
    // The whole top row; of the lowest the two at its left with those between, and one corner.
    assert_eq!(pinned(4), (0..7).map(|column| (column, 0.0)).collect::<Vec<_>>());
    assert_eq!(pinned(0), [(0, 1.0), (1, 2.0), (2, 3.0), (6, 0.0)]);
    assert_eq!(scene.pins.len(), 11);
}

#[test]
fn drag_and_force_are_shared_out_among_more_particles() {
    let text = "version = 1\n[world]\ndrag = 0.8\nforce = [0, 0, 1.6]\n\
                [[bodies]]\nkind = 'block'\nsize = [3, 3, 3]\n";
    let (_, finer) = refined(text, 1).unwrap();
    let world = finer.loaded.scene.world;
    assert_eq!((world.drag, world.force), (0.8 / 8.0, DVec3::Z * 1.6 / 8.0));
    let text = format!("{text}[[bodies]]\nkind = 'rope'\nsize = [3]\nposition = [9, 0, 0]\n");
    let error = refined(&text, 1).unwrap_err().to_string();
    assert!(error.contains("world.drag acts on each particle"), "{error}");
}

#[test]
fn a_mesh_keeps_its_surface_its_mass_and_its_volume() {
    let (coarse, finer) = builtin("bunny", 1);
    let fine = &finer.loaded.scene;
    assert_same_places(&coarse, &finer);
    assert!((mass(fine) / mass(&coarse.scene) - 1.0).abs() < 1e-9);
    // The vertices of the surface, not the lattice inside.
    assert!(finer.common.len() < coarse.scene.particles.len());
    assert_eq!(fine.springs[0].stiffness, 0.5 * coarse.scene.springs[0].stiffness);
    // The lattice inside is finer too: near eight times the particles but for the surface.
    let inside = |scene: &Scene, surface: usize| (scene.particles.len() - surface) as f64;
    let surface = finer.loaded.scene.bodies[0].surface.corners.iter();
    let surface = surface.map(|corner| corner.particle as usize + 1).max().unwrap();
    let ratio = inside(fine, surface) / inside(&coarse.scene, finer.common.len());
    assert!((6.0..14.0).contains(&ratio), "{ratio}");
    // A shell keeps its springs.
    let (coarse, finer) = builtin("teapot", 1);
    assert_same_places(&coarse, &finer);
    assert_eq!(finer.common.len(), coarse.scene.particles.len());
    assert_eq!(finer.loaded.scene.springs[0].stiffness, coarse.scene.springs[0].stiffness);
}

#[test]
fn all_built_in_scenes_but_explicit_ones_are_refined_and_run() {
    for builtin in msd_scene::BUILTINS {
        let draft = Draft::open(Path::new(builtin.name), Path::new("")).unwrap();
        match opened(&draft, 1) {
            Ok((coarse, finer)) => {
                assert_same_places(&coarse, &finer);
                // Half the spacing, half the substep, and a margin for squashed springs.
                let settings = finer.loaded.settings;
                let settings = msd_core::Settings { substeps: 4 * settings.substeps, ..settings };
                let mut simulation =
                    msd_core::Simulation::<f64>::new(&finer.loaded.scene, settings).unwrap();
                simulation.step().unwrap();
                // Written and read again it is the same scene.
                let text = msd_scene::write(&finer.rows, msd_scene::SceneFormat::Json).unwrap();
                let is_mesh = text.contains("\"file\"");
                let again = msd_scene::parse(&text, msd_scene::SceneFormat::Json, "again");
                assert!(is_mesh || again.unwrap().scene == finer.loaded.scene, "{}", builtin.name);
            }
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains("particles and springs one by one"), "{error}");
            }
        }
    }
}

#[test]
fn what_cannot_be_refined_is_named() {
    let explicit = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n\
                    [[bodies]]\nkind = 'explicit'\nname = 'truss'\n\
                    particles = [{ position = [0, 1, 0] }]\n";
    let error = refined(explicit, 1).unwrap_err().to_string();
    assert!(error.contains("bodies[1] is a body `truss` of particles and springs one"), "{error}");
    let error = refined(GELATINE, 9).unwrap_err().to_string();
    assert!(error.contains("cannot be halved 9 times"), "{error}");
    // More than fits a memory.
    let large = GELATINE.replace("[4, 3, 5]", "[40, 40, 40]");
    let error = refined(&large, 8).unwrap_err().to_string();
    assert!(error.contains("bodies[0].size asks for"), "{error}");
}

/// A thickness is a part of the spacing, and the values between two bodies are of their surfaces.
#[test]
fn a_finer_body_is_as_much_thinner() {
    let cloth = |name: &str, y: f64, with: &str| {
        format!(
            "[[bodies]]\nname = '{name}'\nkind = 'cloth'\nsize = [3, 3]\nposition = [0, {y}, 0]\n\
             young = 1e4\nthickness = 1e-3\ndensity = 1000\ntouch = {{ {with} }}\n"
        )
    };
    let with = "thickness = 0.08, with = [{ body = 'a', friction = 0.25 }]";
    let text = format!("version = 1\n{}{}", cloth("a", 0.0, ""), cloth("b", 5.0, with));
    let (coarse, finer) = refined(&text, 1).expect("a scene");
    let shells = [&coarse.scene.shells, &finer.loaded.scene.shells];
    let thickness = shells.map(|shells| [shells[0].thickness, shells[1].thickness]);
    assert_eq!(thickness, [[0.1, 0.08], [0.05, 0.04]]);
    assert_eq!(shells[0][1].between, shells[1][1].between);
}
