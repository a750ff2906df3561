//! Materials of the springs between the particles of a set.

use msd_core::{Scene, Simulation};
use msd_scene::{Draft, Loaded, SceneFormat, parse};
use std::path::Path;

fn toml(text: &str) -> Result<Loaded, String> {
    let text = format!("version = 1\n{text}");
    parse(&text, SceneFormat::Toml, "m.toml").map_err(|error| error.to_string())
}

fn scene(text: &str) -> Scene {
    toml(text).unwrap().scene
}

/// The constants of springs, bends and volumes.
fn constants(scene: &Scene) -> Vec<[f64; 2]> {
    let springs = scene.springs.iter().map(|row| [row.stiffness, row.damping]);
    let bends = scene.bends.iter().map(|row| [row.stiffness, row.damping]);
    let volumes = scene.volumes.iter().map(|row| [row.modulus, row.damping]);
    springs.chain(bends).chain(volumes).collect()
}

fn are_near(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    // Two products and a quotient.
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
    a.len() == b.len() && a.as_flattened().iter().zip(b.as_flattened()).all(is_near)
}

/// A cloth that hangs from its top, whose upper half is four times as stiff: of each column the
/// spring above row r carries r + 1 particles and is longer by (r + 1) m g / k.
#[test]
fn a_stiffer_upper_half_of_a_cloth_hangs_as_its_springs_say() {
    let (mass, lower, upper, spacing) = (0.1, 400.0, 1600.0, 0.25);
    let loaded = toml(&format!(
        "[[bodies]]\nkind = 'cloth'\nsize = [7, 3]\nspacing = {spacing}\nneighbours = 4\n\
         mass = {mass}\nstiffness = {lower}\ndamping = 8\n\
         [[sets]]\nname = 'upper'\nbox = {{ position = [0, 1, 0], size = [9, 2.01, 9] }}\n\
         [[materials]]\nset = 'upper'\nstiffness = {upper}\n[[pins]]\nset = 'top'\n"
    ))
    .unwrap();
    let mut settings = loaded.settings;
    settings.substeps = 64;
    let mut run = Simulation::<f64>::new(&loaded.scene, settings).unwrap();
    // The slowest motion has w = 6.3/s or more and a damping ratio of 0.06: its part is e⁻²³.
    (0..3600).for_each(|_| run.step().unwrap());
    // Row 3 is in the middle of the box's lower side: rows 3 to 6 are in the set.
    let stiffness = |row: usize| if row < 3 { lower } else { upper };
    for column in 0..3 {
        let mut height = run.position(6 * 3 + column).y;
        for row in (0..6).rev() {
            height -= spacing + (row + 1) as f64 * mass * 9.82 / stiffness(row);
            let off = run.position(row * 3 + column).y - height;
            assert!(off.abs() < 1e-9, "row {row}: {off}");
        }
    }
}

const BODIES: [&str; 5] = [
    "kind = 'rope'\nsize = [4]",
    "kind = 'cloth'\nsize = [3, 4]",
    "kind = 'block'\nsize = [2, 3, 3]",
    "kind = 'mesh'\nfile = 'teapot.obj'\nbending = 0.3",
    "kind = 'mesh'\nfile = 'bunny.obj'",
];

/// Of all springs of a body: as the keys of the body itself.
#[test]
fn a_material_of_all_is_that_of_the_body() {
    for body in BODIES {
        let keys = "stiffness = 650\ndamping = 0.7\n";
        let body = format!("[[bodies]]\n{body}\n");
        let own = scene(&format!("{body}{keys}"));
        let of_set = scene(&format!("{body}[[materials]]\nset = 'all'\n{keys}"));
        assert!(are_near(&constants(&of_set), &constants(&own)), "{body}");
        // One of two keys leaves the other.
        let stiffness = "stiffness = 650\n";
        let own = scene(&format!("{body}{stiffness}"));
        let of_set = scene(&format!("{body}[[materials]]\nset = 'all'\n{stiffness}"));
        assert!(are_near(&constants(&of_set), &constants(&own)), "{body}");
    }
}

/// A body of a material accepts a material of a set by the same keys, in bends and volumes too.
#[test]
fn a_modulus_of_all_is_that_of_the_body() {
    for body in [
        "kind = 'rope'\nsize = [6]\nspacing = 0.1\ndiameter = 0.02\ndensity = 900",
        "kind = 'cloth'\nsize = [4, 5]\nspacing = 0.1\nthickness = 0.002\ndensity = 900",
        "kind = 'block'\nsize = [3, 3, 3]\nspacing = 0.1\npoisson = 0.4\ndensity = 900",
        "kind = 'block'\nsize = [3, 3, 3]\nspacing = 0.1\npoisson = 0.1\ndensity = 900",
        "kind = 'mesh'\nfile = 'bunny.obj'\ndensity = 900",
    ] {
        let body = format!("[[bodies]]\n{body}\n");
        let own = scene(&format!("{body}young = 3e5\nrelaxation_time = 0.002\n"));
        let row = "[[materials]]\nset = 'all'\nyoung = 3e5\n";
        let of_set = scene(&format!("{body}young = 1e5\nrelaxation_time = 0.002\n{row}"));
        assert!(are_near(&constants(&of_set), &constants(&own)), "{body}");
        let row = format!("{row}relaxation_time = 0.002\n");
        let of_set = scene(&format!("{body}young = 1e5\n{row}"));
        assert!(are_near(&constants(&of_set), &constants(&own)), "{body}");
    }
    // A half of a block: 1 of its 2 cells, and the springs of the cell.
    let block = "[[bodies]]\nkind = 'block'\nsize = [3, 2, 2]\nspacing = 0.1\npoisson = 0.4\n\
                 young = 1e5\ndensity = 900\n[[sets]]\nname = 'low'\n\
                 box = { position = [0, -0.05, 0], size = [1, 0.1, 1] }\n";
    let plain = constants(&scene(block));
    let half = constants(&scene(&format!("{block}[[materials]]\nset = 'low'\nyoung = 2e5\n")));
    let changed = plain.iter().zip(&half).filter(|(was, now)| was != now).count();
    // Of eight corners, 28 pairs are joined.
    assert_eq!((changed, plain.len()), (28 + 1, 2 * 28 - 6 + 2));
}

/// A body of a number and one of a name; others, links between them, and other springs stay.
#[test]
fn other_springs_keep_theirs() {
    let scene = scene(
        "[[bodies]]\nkind = 'rope'\nsize = [3]\nname = 'a'\n\
         [[bodies]]\nkind = 'rope'\nsize = [4]\nname = 'b'\nposition = [0, 1, 0]\n\
         [[sets]]\nname = 'part'\nbody = 'b'\nsphere = { position = [1, 1, 0], radius = 0.6 }\n\
         [[materials]]\nset = 'part'\nstiffness = 7\n\
         [[links]]\nfrom = { set = 'part' }\nto = { body = 'a', set = 'all' }\n",
    );
    // Particles 2 and 3 of the second rope, at 0.5 and 1.5 m, are in the sphere.
    let stiffnesses: Vec<f64> = scene.springs.iter().map(|spring| spring.stiffness).collect();
    assert_eq!(stiffnesses, [1000.0, 1000.0, 1000.0, 1000.0, 7.0, 1000.0, 1000.0]);
}

/// A chain of half the spacing has springs of twice the stiffness in the same part of it, and a
/// material the same modulus; a side has no such part.
#[test]
fn at_half_the_spacing_materials_stay_where_they_were() {
    let finer = |text: &str| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.toml"), format!("version = 1\n{text}")).unwrap();
        let draft = Draft::open(Path::new("m.toml"), folder.path()).unwrap();
        let source = draft.source().unwrap();
        let coarse = draft.load(&source).map_err(|error| error.to_string())?;
        let finer = draft.finer(&source, &coarse.scene, 1).map_err(|error| error.to_string())?;
        Ok(finer.loaded.scene.springs)
    };
    let part = "[[sets]]\nname = 'part'\nbox = { position = [1, 0, 0], size = [2, 1, 1] }\n\
                [[materials]]\nset = 'part'\n";
    let rope = "[[bodies]]\nkind = 'rope'\nsize = [5]\n";
    let springs: Result<_, String> = finer(&format!("{rope}{part}stiffness = 300\ndamping = 2\n"));
    let constants = springs.unwrap().into_iter().map(|spring| [spring.stiffness, spring.damping]);
    let (plain, own) = ([2000.0, 0.0], [600.0, 4.0]);
    assert_eq!(constants.collect::<Vec<_>>(), [plain, plain, plain, plain, own, own, own, own]);
    let made = format!("{rope}diameter = 0.01\nyoung = 1e6\ndensity = 900\n{part}young = 3e6\n");
    let springs = finer(&made).unwrap();
    assert!((springs[7].stiffness / springs[0].stiffness - 3.0).abs() < 1e-14);
    let side =
        "[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\n[[materials]]\nset = 'left'\nstiffness = 1\n";
    let message = finer(side).unwrap_err();
    assert!(message.contains("materials[0].set is `left`"), "{message}");
}

#[test]
fn sets_may_share_springs_to_which_they_give_the_same() {
    let rows = |first: &str, second: &str| {
        toml(&format!(
            "[[bodies]]\nkind = 'cloth'\nsize = [3, 4]\n[[materials]]\nset = 'left'\n{first}\n\
             [[materials]]\nset = 'edges'\n{second}\n"
        ))
    };
    let alike = rows("stiffness = 5", "stiffness = 5").unwrap().scene;
    // Of 29 springs 15 have an end at one of the two particles inside.
    assert_eq!(alike.springs.iter().filter(|spring| spring.stiffness == 5.0).count(), 29 - 15);
    for second in ["stiffness = 6", "damping = 1", "stiffness = 5\ndamping = 1"] {
        let message = rows("stiffness = 5", second).unwrap_err();
        let told = "materials[1] and materials[0] have the spring of particles 0 and 4 of the \
                    scene, and not the same values for it";
        assert!(message.contains(told), "{message}");
    }
    // A particle that they share joins nothing.
    let corner = "[[bodies]]\nkind = 'cloth'\nsize = [3, 4]\n[[materials]]\nset = 'left'\n\
                  stiffness = 5\n[[materials]]\nset = 'top'\nstiffness = 6\n";
    assert!(toml(corner).is_ok());
}

#[test]
fn what_is_no_material_of_a_set_is_refused() {
    let cloth = "[[bodies]]\nkind = 'cloth'\nsize = [3, 4]\n";
    let block = "[[bodies]]\nkind = 'block'\nsize = [3, 3, 3]\nspacing = 0.1\n\
                 material = 'gelatine-5%'\n";
    let woven = "[[bodies]]\nkind = 'cloth'\nsize = [3, 4]\nspacing = 0.1\n\
                 young_warp = 100\nyoung_weft = 100\nshear = 10\narea_density = 0.2\n";
    let thick = "[[bodies]]\nkind = 'rope'\nsize = [3]\nspacing = 0.001\nyoung = 1\n\
                 diameter = 1\ndensity = 1\n";
    for (body, row, told) in [
        (cloth, "set = 'all'", "materials[0] needs one of the keys `stiffness` and `damping`"),
        (cloth, "stiffness = 1", "materials[0] lacks the key `set`"),
        (cloth, "set = 'all'\nstiffness = -1", "materials[0].stiffness is -1; it must be finite"),
        (cloth, "set = 'all'\ndamping = nan", "materials[0].damping is NaN; it must be finite"),
        (cloth, "set = 'all'\nstiffness = 1e39", "materials[0].stiffness is 1e39; it must be at"),
        (cloth, "set = 'all'\nstifness = 1", "did you mean `stiffness`?"),
        (cloth, "set = 'al'\nstiffness = 1", "materials[0].set is \"al\"; it must be a set of"),
        (cloth, "body = 1\nset = 'all'\nstiffness = 1", "materials[0].body is 1; it must be from"),
        (
            cloth,
            "set = 'corners'\nstiffness = 1",
            "materials[0].set is \"corners\"; it must be a set between whose particles there are \
             springs",
        ),
        (
            cloth,
            "set = 'all'\nyoung = 1e5",
            "materials[0].young does not apply to body 0, `cloth`, which is given by its springs: \
             it has `stiffness` and `damping`",
        ),
        (
            block,
            "set = 'all'\nstiffness = 1",
            "materials[0].stiffness does not apply to body 0, `block`, which is made of a \
             material: it has `young` and `relaxation_time`",
        ),
        (block, "set = 'all'", "materials[0] needs one of the keys `young` and `relaxation_time`"),
        (block, "set = 'all'\nyoung = 0", "materials[0].young is 0; it must be positive"),
        (thick, "set = 'all'\nyoung = 1e36", "materials[0] makes a spring of 7.85398163397448"),
        (
            woven,
            "set = 'all'\nyoung = 1e5",
            "materials[0].young does not apply to body 0, `cloth`, which is woven",
        ),
    ] {
        let message = toml(&format!("{body}[[materials]]\n{row}\n")).map(|_| ()).expect_err(row);
        assert!(message.contains(told) && message.lines().count() == 1, "{row}: {message}");
    }
    let lone = "[[bodies]]\nkind = 'rope'\nsize = [1]\n[[materials]]\nset = 'all'\nstiffness = 1\n";
    assert!(toml(lone).unwrap_err().contains("between whose particles there are springs"));
    assert!(toml(&format!("{woven}[[materials]]\nset = 'all'\nrelaxation_time = 0.1\n")).is_ok());
}
