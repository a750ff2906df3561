//! Bodies made of a material, from scene files, and the materials by name.

use msd_core::glam::DVec3;
use msd_core::{Moduli, Scene, Settings, Simulation, Vector};
use msd_scene::materials::{
    ARCSIM_DENIM_BENDING, ARCSIM_DENIM_STRETCHING, MATERIALS, Named, Numbers, named,
};
use msd_scene::{Loaded, SceneFormat, parse};
use std::f64::consts::PI;

const PAGE: &str = include_str!("../../../../docs/explanation/materials.md");

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

fn body(lines: &str) -> Result<Loaded, String> {
    toml(&format!("version = 1\n[solver]\nprecision = 'f64'\n[[bodies]]\n{lines}\n"))
}

/// Moduli of a scene of one body that fills a volume, an area or a length, and its density.
fn measured(scene: &Scene, volume: f64) -> (Moduli, f64) {
    let spring = |spring: &msd_core::Spring| {
        let [a, b] = spring.ends.map(|end| scene.particles[end].position);
        (spring.stiffness, b - a)
    };
    let mass: f64 = scene.particles.iter().map(|particle| particle.mass).sum();
    (Moduli::of(scene.springs.iter().map(spring), &scene.volumes, volume), mass / volume)
}

/// Moduli and density of a body that fills a cubic metre.
fn measured_of_a_cube(lines: &str) -> (Moduli, f64) {
    measured(&body(lines).expect("a body").scene, 1.0)
}

fn is_near(value: f64, expected: f64) -> bool {
    (value / expected - 1.0).abs() < 1e-12
}

#[test]
fn a_block_a_cloth_and_a_rope_have_the_moduli_and_the_mass_of_their_keys() {
    let keys = "spacing = 0.1\nyoung = 5e4\ndensity = 800\nrelaxation_time = 0.01\n";
    let block = body(&format!("kind = 'block'\nsize = [3, 4, 5]\npoisson = 0.25\n{keys}"));
    let scene = block.expect("a block").scene;
    let (moduli, density) = measured(&scene, 0.024);
    assert!(scene.volumes.is_empty());
    assert!(is_near(moduli.young(DVec3::ONE.normalize()), 5e4) && is_near(density, 800.0));
    assert!(scene.springs.iter().all(|spring| is_near(spring.damping, 0.01 * spring.stiffness)));
    for poisson in [0.0, 0.45] {
        let lines = format!("kind = 'block'\nsize = [3, 4, 5]\npoisson = {poisson}\n{keys}");
        let block = body(&lines);
        let scene = block.expect("a block").scene;
        let (moduli, _) = measured(&scene, 0.024);
        assert!(is_near(moduli.young(DVec3::ONE.normalize()), 5e4));
        assert!((moduli.poisson(DVec3::X, DVec3::Y) - poisson).abs() < 1e-12);
        assert!(scene.volumes.iter().all(|row| is_near(row.damping, 0.01 * row.modulus)));
    }
    let cloth = format!("kind = 'cloth'\nsize = [3, 4]\nthickness = 0.002\npoisson = 0.33\n{keys}");
    let (moduli, density) = measured(&body(&cloth).expect("a cloth").scene, 0.06);
    assert!(is_near(moduli.young(DVec3::X), 100.0) && is_near(density, 1.6));
    let rope =
        body(&format!("kind = 'rope'\nsize = [5]\ndiameter = 0.02\n{keys}")).expect("a rope");
    let (moduli, density) = measured(&rope.scene, 0.4);
    let area = 1e-4 * PI;
    assert!(is_near(moduli.young(DVec3::X), 5e4 * area) && is_near(density, 800.0 * area));
    let woven = "kind = 'cloth'\nsize = [4, 4]\nyoung_warp = 300\nyoung_weft = 200\nshear = 20\n\
                 area_density = 0.2";
    let (moduli, density) = measured(&body(woven).expect("a woven cloth").scene, 9.0);
    let pull = [DVec3::Y, DVec3::X].map(|way| moduli.young(way));
    assert!(is_near(pull[0], 300.0) && is_near(pull[1], 200.0) && is_near(density, 0.2));
}

#[test]
fn a_number_beside_a_material_replaces_that_of_the_material() {
    let lines = "kind = 'block'\nsize = [2, 2, 2]\nmaterial = 'gelatine-3%'";
    let scene = body(lines).expect("gelatine").scene;
    let (moduli, density) = measured(&scene, 1.0);
    assert!(is_near(moduli.young(DVec3::X), 3.0 * 2010.0) && is_near(density, 998.0));
    let tau = scene.springs[0].damping / scene.springs[0].stiffness;
    assert!(is_near(tau, 0.60 / 2010.0));
    let other = format!("{lines}\nyoung = 7000\nrelaxation_time = 0");
    let scene = body(&other).expect("other gelatine").scene;
    assert!(is_near(measured(&scene, 1.0).0.young(DVec3::X), 7000.0));
    assert!(scene.springs.iter().all(|spring| spring.damping == 0.0));
}

#[test]
fn a_cloth_and_a_rope_bend_by_their_keys_or_by_their_modulus() {
    // Of a bend inside: B/a² of a cloth, B/a³ of a rope.
    let stiffnesses = |lines: &str| {
        let lines = format!("spacing = 0.1\ndensity = 800\nrelaxation_time = 0.01\n{lines}");
        let scene = body(&lines).expect("a body").scene;
        assert!(scene.bends.iter().all(|bend| is_near(bend.damping, 0.01 * bend.stiffness)));
        let all: Vec<f64> = scene.bends.iter().map(|bend| bend.stiffness).collect();
        let largest = all.iter().fold(0.0, |most: f64, &next| most.max(next));
        (all.len(), largest, all.last().copied().unwrap_or(0.0))
    };
    let cloth = "kind = 'cloth'\nsize = [4, 5]\nyoung = 5e4\nthickness = 0.002\n";
    // Lines along rows and columns, and cells; the last bend is a twist: 2 B/a².
    let plate = 5e4 * 8e-9 / (12.0 * (1.0 - 1.0 / 9.0));
    let count = 2 * 5 + 4 * 3 + 3 * 4;
    for (key, bending) in [("", plate), ("bending = 0.003", 0.003)] {
        let found = stiffnesses(&format!("{cloth}{key}"));
        assert!(found.0 == count && is_near(found.2, 2.0 * bending / 0.01), "{found:?}");
    }
    assert_eq!(stiffnesses(&format!("{cloth}bending = 0")).0, 0);
    let woven = "kind = 'cloth'\nsize = [4, 5]\nyoung_warp = 300\nyoung_weft = 200\nshear = 20\n\
                 thickness = 1\n";
    assert_eq!(stiffnesses(woven).0, 0);
    let three = "bending_warp = 0.003\nbending_weft = 0.001\nbending_bias = 0.002";
    let found = stiffnesses(&format!("{woven}{three}"));
    assert!(is_near(found.1, 0.4) && is_near(found.2, 0.4), "{found:?}");
    let rope = "kind = 'rope'\nsize = [5]\nyoung = 5e4\ndiameter = 0.02\n";
    let rod = 5e4 * PI / 64.0 * 1.6e-7;
    for (key, bending) in [("", rod), ("bending = 0.003", 0.003)] {
        let found = stiffnesses(&format!("{rope}{key}"));
        assert!(found.0 == 3 && is_near(found.1, bending / 0.001), "{found:?}");
    }
}

#[test]
fn every_material_makes_a_body_that_runs() {
    for material in MATERIALS {
        let kinds: &[&str] = match material.numbers {
            Numbers::Uniform { .. } => &[
                "kind = 'block'\nsize = [3, 3, 3]",
                "kind = 'cloth'\nsize = [3, 3]\nthickness = 1e-3",
                "kind = 'rope'\nsize = [3]\ndiameter = 1e-3",
            ],
            Numbers::Fabric { .. } => &["kind = 'cloth'\nsize = [3, 3]"],
        };
        for kind in kinds {
            let lines = format!("{kind}\nspacing = 0.01\nmaterial = '{}'", material.name);
            let loaded = body(&lines).expect(material.name);
            let simulation = Simulation::<f32>::new(&loaded.scene, loaded.settings);
            let stable = simulation.expect("a valid scene").stable_substep();
            assert!(0.0 < stable && stable.is_finite(), "{}: {stable}", material.name);
        }
        assert!(!material.source.is_empty() && !material.remarks.is_empty());
        assert_eq!(named(material.name), Some(&material), "two materials of one name");
    }
}

/// The row of a material on the page.
fn row(material: &Named) -> String {
    let numbers = match material.numbers {
        Numbers::Uniform { young, poisson, density, relaxation_time } => format!(
            "E {young:e} Pa, Poisson's ratio {poisson}, {density} kg/m³{}",
            match relaxation_time {
                0.0 => String::new(),
                time => format!(", relaxation time {time:.2e} s"),
            }
        ),
        Numbers::Fabric { young_warp, young_weft, shear, area_density, bending } => {
            let [warp, weft, bias] = bending.map(|stiffness| 1e6 * stiffness);
            format!(
                "warp {young_warp:.1} N/m, weft {young_weft:.1} N/m, shear {shear:.1} N/m, \
                 {area_density} kg/m², bending {warp:.1}, {weft:.1} and on the bias {bias:.1} µN m"
            )
        }
    };
    format!("| `{}` | {numbers} | {} | {} |\n", material.name, material.source, material.remarks)
}

/// The energy of a deformed square metre by the form of the forces of ARCSim's `physics.cpp`, J:
/// e12 is half of the angle of shear.
fn arcsim_stretching(e11: f64, e22: f64, angle: f64) -> f64 {
    let [c11, c12, c22, c33] = ARCSIM_DENIM_STRETCHING;
    let e12 = angle / 2.0;
    0.5 * (c11 * e11 * e11 + c22 * e22 * e22) + c12 * e11 * e22 + c33 * e12 * e12
}

/// The bending stiffness of ARCSim's hinges, k l² θ²/(8 (A1 + A2)) each, in equilateral triangles
/// with edges along the axis of a cylinder, N m.
fn arcsim_bending(along_axis: f64) -> f64 {
    let (curvature, length) = (1e-3, 0.01f64);
    let height = length * 0.75f64.sqrt();
    let hinge = |angle_deg: f64, stiffness: f64| {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let fold = curvature * height * (cos * cos - sin * sin / 3.0);
        stiffness * length * length * fold * fold / (8.0 * length * height)
    };
    // The other two directions do not fold, whatever their stiffness.
    let cell = hinge(0.0, along_axis) + hinge(60.0, 1.0) + hinge(120.0, 1.0);
    // Two triangles, of length times height together, have one edge of each direction.
    cell / (length * height) / (curvature * curvature / 2.0)
}

#[test]
fn denim_is_that_of_the_tables_of_arcsim() {
    let Some(Named {
        numbers: Numbers::Fabric { young_warp, young_weft, shear, bending, .. }, ..
    }) = named("cotton-denim")
    else {
        panic!("a fabric")
    };
    // Along 2, the warp, with sides that are free: the least energy over e11 is half the modulus.
    let [c11, c12, c22, _] = ARCSIM_DENIM_STRETCHING;
    assert!(is_near(*young_warp, 2.0 * arcsim_stretching(-c12 / c11, 1.0, 0.0)));
    assert!(is_near(*young_weft, 2.0 * arcsim_stretching(1.0, -c12 / c22, 0.0)));
    assert!(is_near(*shear, 2.0 * arcsim_stretching(0.0, 0.0, 1.0)));
    // Edges along 1 fold the threads along 2.
    let [along_1, along_45, along_2] = ARCSIM_DENIM_BENDING;
    for (found, hinges) in bending.iter().zip([along_1, along_2, along_45]) {
        assert!((found / arcsim_bending(hinges) - 1.0).abs() < 1e-9, "{bending:?}");
    }
    // Denims of 0.38 to 0.42 kg/m² had 14 to 22 µN m by Kawabata's method (Journal of Textiles
    // 2016, 4614168, table 5): the mean of warp and weft is among them.
    let mean = 1e6 * 0.5 * (bending[0] + bending[1]);
    assert!((14.0..22.0).contains(&mean), "{mean}");
}

/// The speed of waves along a thin rod of a material, m/s: a free rope of one metre rings along
/// itself for an eighth of a period or so.
fn speed_along_a_rod(name: &str) -> f64 {
    const SPRINGS: usize = 20;
    let rope = format!(
        "kind = 'rope'\nsize = [{}]\nspacing = 0.05\ndiameter = 0.01\nmaterial = '{name}'",
        SPRINGS + 1
    );
    let mut scene = body(&rope).expect("a rope").scene;
    let half = 0.5 * PI / SPRINGS as f64;
    let shape = |row: usize| (2.0 * half * row as f64).cos();
    for (row, particle) in scene.particles.iter_mut().enumerate() {
        particle.velocity = DVec3::X * 1e-3 * shape(row);
    }
    let settings = Settings { step: 1e-6, substeps: 1, ..Settings::default() };
    let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
    let ringing = |simulation: &Simulation<f64>| -> f64 {
        let velocities = simulation.state().velocities;
        let rows = scene.particles.iter().zip(velocities).enumerate();
        rows.map(|(row, (particle, velocity))| particle.mass * velocity.to_f64().x * shape(row))
            .sum()
    };
    let start = ringing(&simulation);
    (0..60).for_each(|_| simulation.step().expect("a step"));
    let frequency = (ringing(&simulation) / start).acos() / simulation.time();
    // A chain of n springs with half masses at its ends: w = (2 c/a) sin(π/(2 n)).
    frequency * 0.05 / (2.0 * half.sin())
}

#[test]
fn waves_run_along_metal_rods_as_fast_as_measured() {
    // CRC Handbook of Chemistry and Physics, "Speed of sound in various media", table 1, v_ext:
    // rolled aluminium 5000 and duralumin 5150 m/s; electrolytic iron 5120 and Armco iron 5200.
    for (name, range) in [("aluminium", 5000.0..5150.0), ("steel", 5120.0..5200.0)] {
        let speed = speed_along_a_rod(name);
        assert!(range.contains(&speed), "{name}: {speed} m/s");
    }
}

#[test]
fn gelatine_that_keeps_its_volume_shears_as_measured() {
    // Shear moduli, kPa, with their standard deviations: abstract of the source.
    let measured = [
        ("gelatine-3%", 2.01, 0.26),
        ("gelatine-4%", 3.10, 0.34),
        ("gelatine-5%", 4.18, 0.84),
        ("gelatine-6%", 8.05, 1.00),
        ("gelatine-7%", 10.24, 1.80),
    ];
    let shear = |name: &str, poisson: &str| {
        let lines = format!("kind = 'block'\nsize = [2, 2, 2]\nmaterial = '{name}'\n{poisson}");
        let (moduli, _) = measured_of_a_cube(&lines);
        let lateral = moduli.poisson(DVec3::X, DVec3::Y);
        1e-3 * moduli.young(DVec3::X) / (2.0 * (1.0 + lateral))
    };
    for (name, modulus, deviation) in measured {
        let found = shear(name, "poisson = 0.45");
        assert!((found - modulus).abs() < deviation, "{name}: {found} kPa");
        // E is kept, so that springs alone are 2 (1 + 1/2)/(2 (1 + 1/4)) times as stiff in shear.
        assert!(is_near(shear(name, "") / modulus, 1.2), "{name}");
    }
}

#[test]
fn the_page_lists_every_material_with_its_source() {
    let rows: String = MATERIALS.iter().map(row).collect();
    let notes = body("kind = 'block'\nsize = [2, 2, 2]\nmaterial = 'steel'").expect("steel").notes;
    let note = "steel: Poisson's ratio is 1/4, that of springs, instead of 0.3; `poisson = 0.3` \
                costs more";
    assert_eq!(notes, [note]);
    assert!(PAGE.contains(&rows), "docs/explanation/materials.md should end in\n{rows}");
}

#[test]
fn the_scenes_of_the_page_are_complete() {
    let scenes: Vec<&str> = PAGE.split("```toml\n").skip(1).collect();
    // The files of which the pictures are made.
    let files = [
        include_str!("../../../../docs/explanation/materials/gelatine.toml"),
        include_str!("../../../../docs/explanation/materials/denim.toml"),
    ];
    assert_eq!(scenes.len(), files.len());
    for (scene, file) in scenes.into_iter().zip(files) {
        let text = scene.split("```").next().expect("an end");
        assert_eq!(text, file);
        let loaded = toml(text).expect("a scene");
        assert!(loaded.scene.springs.iter().all(|spring| 0.0 < spring.damping));
    }
    toml(include_str!("../../../../docs/explanation/materials/shells.toml")).expect("a scene");
}

/// Lines of a body, and the message.
const REFUSED: [(&str, &str); 32] = [
    (
        "kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'steal'",
        "s.toml:7:12: bodies[0].material is \"steal\"; it must be the name of a material; did you \
         mean `steel`?",
    ),
    ("kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'zzz'", "it must be one of gelatine-3%, gel"),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nyoung = -1\ndensity = 1",
        "young is -1; it must be positive",
    ),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nyoung = 1e4\nstiffness = 3",
        "bodies[0].young and bodies[0].stiffness exclude each other",
    ),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'steel'\nmass = 1",
        "bodies[0].material and bodies[0].mass exclude each other",
    ),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'steel'\nneighbours = 6",
        "bodies[0].material and bodies[0].neighbours exclude each other",
    ),
    ("kind = 'block'\nsize = [3, 3, 3]\nyoung = 1e4", "bodies[0] lacks the key `density`"),
    ("kind = 'block'\nsize = [3, 3, 3]\ndensity = 1e4", "bodies[0] lacks the key `young`"),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'steel'\npoisson = 0.5",
        "bodies[0].poisson is 0.5; it must be between 0 and 0.45 in a block: towards 0.5 the",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nmaterial = 'steel'\nthickness = 1\npoisson = 0.5",
        "bodies[0].poisson is 0.5; it must be 0.3333 (1/3) in a cloth",
    ),
    (
        "kind = 'block'\nsize = [3, 3, 1]\nmaterial = 'steel'",
        "bodies[0].size[2] is 1; it must be at least 2 in a body that has the key `material`",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nmaterial = 'steel'",
        "bodies[0] lacks the key `thickness`, positive and finite: a cloth with `material` n",
    ),
    ("kind = 'cloth'\nsize = [3, 3]\nyoung = 1\narea_density = 1", "lacks the key `thickness`"),
    (
        "kind = 'cloth'\nsize = [3, 3]\nyoung = 1\narea_density = 1\ndensity = 3",
        "bodies[0].area_density and bodies[0].density exclude each other",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nmaterial = 'cotton-denim'\nyoung = 1",
        "bodies[0].young and the moduli of a woven cloth",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nyoung_warp = 2\n\
         young_weft = 1\nshear = 3\narea_density = 1",
        "bodies[0].shear is 3; it must be at most 2, young_warp young_weft",
    ),
    ("kind = 'rope'\nsize = [3]\nmaterial = 'steel'", "bodies[0] lacks the key `diameter`"),
    (
        "kind = 'rope'\nsize = [3]\nmaterial = 'steel'\ndiameter = 1\nbending = -1",
        "bodies[0].bending is -1; it must be finite and not negative",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nbending = 1\nstiffness = 1",
        "bodies[0].bending and bodies[0].stiffness exclude each other",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nmaterial = 'cotton-denim'\nbending = 1\nbending_warp = 1",
        "bodies[0].bending and bodies[0].bending_warp exclude each other",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nyoung_warp = 3\nyoung_weft = 2\nshear = 1\n\
         area_density = 1\nbending_weft = 1",
        "bodies[0] lacks the key `bending_warp`",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nmaterial = 'cotton-denim'\nbending_warp = 3\n\
         bending_weft = 1\nbending_bias = 0.9",
        "bodies[0].bending_bias is 0.9; it must be at least 1, (bending_warp + bending_weft)/4",
    ),
    (
        "kind = 'cloth'\nsize = [3, 3]\nmaterial = 'cotton-denim'\nbending_warp = 1",
        "bodies[0].bending_warp is 1; it must be such that (bending_warp + bending_weft)/4 is",
    ),
    (
        "kind = 'rope'\nsize = [3]\ndiameter = 1\nmaterial = 'cotton-denim'",
        "bodies[0].material is \"cotton-denim\"; it must be that of a solid in a rope, a block or",
    ),
    ("kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'gelatine'", "did you mean `gelatine-"),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'steel'\nrelaxation_time = 1\n\
         damping_ratio = 1",
        "bodies[0].damping_ratio and bodies[0].relaxation_time exclude each other",
    ),
    (
        "kind = 'block'\nsize = [20, 20, 20]\nmaterial = 'steel'\ndamping_ratio = 0.1",
        "bodies[0].damping_ratio asks for the slowest motion of 8000 particles",
    ),
    (
        "kind = 'cloth'\nsize = [9, 9]\nmaterial = 'cotton-denim'\nbending = 0\n\
         damping_ratio = 0.1",
        "asks for the slowest motion, and nothing resists many of them; give `relaxation_time`",
    ),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nmaterial = 'steel'\nbending = 1",
        "bodies[0].bending does not apply to a block, only to rope, cloth, mesh",
    ),
    (
        "kind = 'rope'\nsize = [3]\nmaterial = 'steel'\nthickness = 1",
        "bodies[0].thickness does not apply to a rope, only to cloth",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmaterial = 'steel'\npoisson = 0.3",
        "bodies[0].poisson is 0.3; it must be 0.25 in a solid of a mesh, the only one that its",
    ),
    (
        "kind = 'block'\nsize = [3, 3, 3]\nyoung = 1e300\ndensity = 1e-300\nspacing = 1e-3",
        "which do not fit f64",
    ),
];

#[test]
fn what_makes_no_body_is_refused_in_one_line() {
    for (lines, expected) in REFUSED {
        let message = body(lines).expect_err(lines);
        assert!(message.contains(expected), "{message}\nshould say {expected}");
        assert!(message.lines().count() == 1 && message.len() < 250, "{message}");
    }
}

#[test]
fn a_damping_ratio_is_that_of_the_slowest_motion() {
    for (body_keys, ratio) in [
        ("kind = 'block'\nsize = [3, 7, 3]", 0.05),
        ("kind = 'cloth'\nsize = [5, 4]\nthickness = 0.01", 1.5),
    ] {
        let lines = format!(
            "{body_keys}\nspacing = 0.1\nyoung = 5e4\ndensity = 800\ndamping_ratio = {ratio}"
        );
        let scene = body(&lines).expect("a body").scene;
        let simulation =
            Simulation::<f64>::new(&scene, msd_core::Settings::default()).expect("valid");
        let [mode] = simulation.slowest_modes(1)[..] else { panic!("a mode") };
        let found = 0.5 * mode.damping / mode.stiffness.sqrt();
        // By the matrix: a straight bend is damped in all directions.
        assert!((found / ratio - 1.0).abs() < 1e-3, "{found}");
    }
}

#[test]
fn a_body_that_cannot_carry_its_own_weight_is_in_a_note_and_one_that_can_is_in_none() {
    // density * gravity * height = 1000 * 9.82 * 0.4 = 3928 Pa.
    let note = |kind: &str, young: f64, gravity: &str| {
        let text = format!(
            "version = 1\n[world]\ngravity = {gravity}\n[[bodies]]\n{kind}\nspacing = 0.08\n\
             density = 1000\nyoung = {young}\n"
        );
        let notes = toml(&text).expect("a valid scene").notes;
        notes.into_iter().find(|note| note.contains("cannot carry its own weight"))
    };
    let block = "kind = 'block'\nsize = [6, 6, 6]";
    let down = "[0, -9.82, 0]";
    let found = note(block, 2000.0, down).expect("a note");
    assert!(found.contains("3.928e3 Pa") && found.contains("196 %"), "{found}");
    assert!(note(block, 7855.0, down).expect("a note").contains("Pa, 50 % of its Young's"));
    assert_eq!(note(block, 7857.0, down), None);
    assert_eq!(note(block, 2000.0, "[0, 0, 0]"), None);
    // Gravity along another axis, of a block that is longer there.
    let long = "kind = 'block'\nsize = [2, 6, 2]";
    assert!(note(long, 2000.0, "[9.82, 0, 0]").is_some());
    assert_eq!(note(long, 2000.0, down), None);
    let cloth = "kind = 'cloth'\nsize = [6, 6]\nthickness = 0.001";
    assert_eq!(note(cloth, 2000.0, down), None);
}
