//! Refusals of files from outside, scenes and meshes: one line with place, key, value and domain.

use msd_scene::mesh::{
    self,
    Format::{self, Gltf, Obj, Ply, Stl},
};
use msd_scene::{Loaded, Precision, SceneFormat, json_schema, load, load_state, open, parse};
use std::path::Path;

const NO_FACES: &str = "no faces found; points and lines alone make no body";

fn toml(text: &str) -> Result<Loaded, String> {
    parse(text, SceneFormat::Toml, "s.toml").map_err(|error| error.to_string())
}

/// Checks a refusal; ` ... ` in the expected message stands for any text.
fn check(message: &str, told: &str) {
    let one_line = message.lines().count() == 1 && !message.contains(char::is_control);
    assert!(one_line && message.len() < 250, "{message:?}");
    let mut rest = message;
    for part in told.split(" ... ") {
        let Some(at) = rest.find(part) else { panic!("{message}\n{told}") };
        rest = &rest[at + part.len()..];
    }
}

/// A scene of one body with these lines.
fn body(lines: &str) -> String {
    format!("version = 1\n[[bodies]]\n{lines}\n")
}

/// A body of two particles with these springs.
fn pair(springs: &str) -> String {
    body(&format!(
        "kind = 'explicit'\nparticles = [{{ position = [0, 0, 0] }}, \
         {{ position = [1, 0, 0] }}]\nsprings = [{springs}]"
    ))
}

const ROPE: &str = "kind = 'rope'\nsize = [3]\n";

/// The message about a spacing of the sixth line.
const TOO_FINE: &str =
    "s.toml:6:11: bodies[0].spacing: bunny.obj: ... at most 2097152 fit: make the spacing larger";

/// Lines after those of a rope of three particles, and the message.
const LINES: [(&str, &str); 85] = [
    (
        "rotation = [0, 1, 0]",
        "rotation is a list; it must be a table with the keys axis, angle_deg",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1e12",
        "s.toml:5:1: world.solids[0] pushes particle 0 of rope out of the world, to a coord",
    ),
    ("[[world.planes]]\noffset = 1e9", "world.planes[0] pushes particle 0 of rope out of the wor"),
    ("size = [4]", "s.toml:5:1: the key `size` stands here twice"),
    ("mass = -1", "s.toml:5:8: bodies[0].mass is -1; it must be positive and finite"),
    ("mass = 0", "bodies[0].mass is 0; it must be positive and finite"),
    ("mass = nan", "bodies[0].mass is NaN; it must be positive and finite"),
    ("mass = inf", "bodies[0].mass is inf; it must be positive and finite"),
    (
        "mass = 1e-40",
        "s.toml:5:8: bodies[0].mass is 1e-40; it must be positive and finite, from 3e-39",
    ),
    ("[solver]\nnewton = 2000", "s.toml:6:10: solver.newton is 2000; it must be from 1 to 1000"),
    ("[solver]\nstep = 1e7", "solver.step is 10000000; it must be positive and at most 1e6"),
    (
        "[solver]\nstep = 1e-22",
        "solver.step is 1e-22; it must be positive and at most 1e6; a substep",
    ),
    ("[solver]\nsteps_per_second = 1e-7", "solver.steps_per_second is 1e-7; it must be finite and"),
    ("[solver]\nsteps_per_second = 1e-300", "solver.steps_per_second is 1e-300; it must be finite"),
    (
        "[[world.planes]]\nfriction = 1e39",
        "friction is 1e39; it must be finite and not negative, at",
    ),
    ("mass = 'heavy'", "bodies[0].mass is \"heavy\"; it must be a number"),
    (
        "stiffness = -5",
        "s.toml:5:13: bodies[0].stiffness is -5; it must be finite and not negative",
    ),
    ("damping = nan", "bodies[0].damping is NaN; it must be finite and not negative"),
    ("spacing = 0", "bodies[0].spacing is 0; it must be positive and finite"),
    ("position = [0, 2e6, 0]", "bodies[0].position[1] is 2000000; it must be finite and inside"),
    ("position = [0, 0]", "bodies[0].position is a list of 2; it must be a list of three"),
    ("position = [0, 0, 0, 0]", "bodies[0].position is a list of 4; it must be a list of three"),
    ("velocity = [0, inf, 0]", "bodies[0].velocity[1] is inf; it must be finite"),
    ("rotation = { axis = [0, 0, 0], angle_deg = 1 }", "bodies[0].rotation.axis is zero"),
    ("spin = { speed = 1 }", "bodies[0].spin needs one of the keys `axis` and `random_axis_seed`"),
    ("spin = 5", "bodies[0].spin is 5; it must be a list of three numbers, or a table"),
    ("neighbours = 8", "bodies[0].neighbours is 8; it must be 2 for a rope"),
    ("file = 'a.obj'", "bodies[0].file does not apply to a rope, only to mesh"),
    ("[[pins]]\nparticle = 3", "pins[0].particle is 3; it must be from 0 to 2"),
    (
        "[[pins]]\nbody = 1\nparticle = 0",
        "pins[0].body is 1; it must be from 0 to 0: there is 1 body",
    ),
    ("[[pins]]\nevery = 0", "pins[0].every is 0; it must be at least 1"),
    ("[[pins]]\nat = [0, 3, 0]", "pins[0].at[1] is 3; it must be from 0 to 2"),
    ("[[pins]]\nbody = 0", "pins[0] needs exactly one of the keys"),
    ("[solver]\nstep = 0", "solver.step is 0; it must be positive and at most 1e6; a substep"),
    (
        "[solver]\nstep = 'automatic'",
        "solver.step is \"automatic\"; it must be a number of seconds, or \"auto\"",
    ),
    (
        "[solver]\nstep = 'auto'\nsubsteps = 12",
        "solver.step = \"auto\" and a number of solver.substeps exclude each other",
    ),
    ("[solver]\nsteps_per_second = inf", "solver.steps_per_second is inf"),
    (
        "[solver]\nsubsteps = 0",
        "solver.substeps is 0; it must be from 1 to 4294967295, or \"auto\"",
    ),
    ("[solver]\nsubsteps = 1e3", "solver.substeps is 1000.0; it must be a whole number, without a"),
    (
        "[solver]\nsubsteps = 'many'",
        "solver.substeps is \"many\"; it must be a whole number from 1 to 4294967295, or \"auto\"",
    ),
    (
        "[solver]\nintegrator = 'rk5'",
        "solver.integrator is \"rk5\"; it must be one of explicit-euler",
    ),
    ("[solver]\nprecision = 'f16'", "solver.precision is \"f16\"; it must be one of f32, f64"),
    ("[world]\ngravity = [0, nan, 0]", "world.gravity[1] is NaN; it must be finite"),
    ("[world]\ndrag = -1", "world.drag is -1; it must be finite and not negative"),
    ("[solver]\nsubsteps = 99999999999", "is 99999999999; it must be from 1 to 4294967295"),
    (
        "stiffness = 1e300",
        "stiffness is 1e300; it must be at most 3.4e38 to fit f32; precision = \"f64\"",
    ),
    ("spacing = 1e-30", "bodies[0].spacing is 1e-30; it must be so large that f32 tells"),
    ("position = [1e6, 0, 0]\nspacing = 0.01", "bodies[0].spacing is 0.01; it must be so large"),
    (
        "[[pins]]\nparticle = 2\n[[pins]]\nat = [0, 2, 0]",
        "pins[1] and pins[0] hold the same particle, number 2 of the scene",
    ),
    ("[world.air]\ndensity = -1", "world.air.density is -1; it must be finite and not negative"),
    ("[world.air]\nlift = 1.3", "world.air.lift is 1.3; it must be at most world.air.drag, 1.2"),
    ("[world.air.gust]\nlength = 0", "world.air.gust.length is 0; it must be positive and"),
    ("[world]\nextent = 0", "world.extent is 0; it must be positive"),
    ("[[world.planes]]\nnormal = [0, 0, 0]", "world.planes[0].normal is zero"),
    (
        "[[world.planes]]\nrestitution = 1.5",
        "world.planes[0].restitution is 1.5; it must be from 0 to 1",
    ),
    ("[[world.planes]]\nfriction = -0.1", "world.planes[0].friction is -0.1"),
    ("[[world.planes]]\nfriction = 1\ntangential_loss = 0", "exclude each other"),
    ("[[world.planes]]\nsticky = true\nfriction = 1", "world.planes[0].sticky says it all"),
    ("[[world.solids]]\nkind = 'ball'", "sphere"),
    ("[[world.solids]]\nkind = 'sphere'", "world.solids[0] lacks the key `radius`"),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 0",
        "world.solids[0].radius is 0; it must be positive and at most 1e12",
    ),
    (
        "[[world.solids]]\nkind = 'box'\nsize = [1, 0, 1]",
        "world.solids[0].size[1] is 0; it must be positive",
    ),
    (
        "[[world.solids]]\nkind = 'box'\nsize = [1, 1, 1]\ntube = 1",
        "world.solids[0].tube does not apply to a box, only to torus",
    ),
    (
        "[[world.solids]]\nkind = 'torus'\nradius = 1\ntube = 1",
        "world.solids[0].tube is 1; it must be smaller than the radius, 1",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nspin = { speed = 1 }",
        "needs one of the keys",
    ),
    ("[[world.solids]]\nkind = 'mesh'", "world.solids[0] lacks the key `file`: a mesh needs it"),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\ncell = 1",
        "world.solids[0].cell does not apply to a sphere, only to mesh",
    ),
    (
        "[[world.solids]]\nkind = 'mesh'\nfile = 'teapot.obj'",
        "world.solids[0].file: teapot.obj: is not closed, so it has no inside: ",
    ),
    (
        "[[world.solids]]\nkind = 'mesh'\nfile = 'bunny.obj'\ncell = 1e-3",
        "world.solids[0].cell: bunny.obj: the number of points of its grid of distances would be ",
    ),
    (
        "[[world.solids]]\nkind = 'mesh'\nfile = 'bunny.obj'\ncell = 5",
        "world.solids[0].cell: bunny.obj: with a cell of 5 no point of the grid is inside",
    ),
    (
        "[[world.solids]]\nkind = 'mesh'\nfile = 'bunny.obj'\ncell = 0",
        "world.solids[0].cell is 0; it must be positive and at most 1e12",
    ),
    ("[[world.solids]]\nkind = 'mesh'\nfile = \"a\\nb.obj\"", "a name without control characters"),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nkey_frames = [{ time = 0 }]",
        "world.solids[0].key_frames[0].time is 0; it must be positive and finite",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nkey_frames = [{ time = 2 }, { time = 1 }]",
        "world.solids[0].key_frames[1].time is 1; it must be later than 2",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nspin = [1, 0, 0]\n\
         key_frames = [{ time = 1 }]",
        "world.solids[0].spin and key_frames exclude each other",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nkey_frames = [{ time = 1, position = \
         [1e9, 0, 0] }]",
        "world.solids[0].key_frames[0].position[0] is 1000000000; it must be finite and inside",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nkey_frames = [{ time = 1, rotation = \
         { axis = [0, 0, 0], angle_deg = 1 } }]",
        "world.solids[0].key_frames[0].rotation.axis is zero",
    ),
    (
        "[[world.solids]]\nkind = 'sphere'\nradius = 1\nkey_frames = []",
        "key_frames must not be empty",
    ),
    ("stiffness = nan", "s.toml:5:13: bodies[0].stiffness is NaN; it must be finite and not"),
    ("stiffness = inf", "s.toml:5:13: bodies[0].stiffness is inf; it must be finite and not"),
    ("damping = -1", "s.toml:5:11: bodies[0].damping is -1; it must be finite and not negative"),
    ("spacing = -inf", "s.toml:5:11: bodies[0].spacing is -inf; it must be positive and finite"),
    ("stifness = 5", "s.toml:5:1: unknown key `stifness` in bodies[0]; did you mean `stiffness`?"),
    ("spin = { axs = [1, 0, 0], speed = 1 }", "unknown key `axs` in bodies[0].spin"),
    ("spin = { axis = [1, 0, 0] }", "bodies[0].spin lacks the key `speed`"),
];

/// Lines of a body, and the message.
const BODIES: [(&str, &str); 39] = [
    ("kind = 'blok'", "bodies[0].kind is \"blok\"; it must be one of rope, cloth, block"),
    ("kind = 'blok'", "did you mean `block`?"),
    ("kind = 3", "bodies[0].kind is 3; it must be one of rope"),
    ("kind = 'rope'\nsize = [0]", "bodies[0].size[0] is 0; it must be at least 1"),
    ("kind = 'rope'\nsize = [-3]", "bodies[0].size[0] is -3; it must be a whole number"),
    ("kind = 'rope'\nsize = [1.5]", "bodies[0].size[0] is 1.5; it must be a whole number"),
    ("kind = 'rope'\nsize = [1, 2]", "bodies[0].size is a list of 2; it must be one number"),
    ("kind = 'cloth'\nsize = [1, 2, 3]", "it must be two numbers: [rows, columns]"),
    (
        "kind = 'rope'\nsize = [99999999999999999999]",
        "bodies[0].size[0] is 1e20; it must be a whole number from 0 to 18446744073709551615",
    ),
    ("kind = 'explicit'\nparticles = []", "bodies[0].particles is empty"),
    (
        "kind = 'explicit'\nspacing = 1",
        "bodies[0].spacing does not apply to an explicit body, only to rope, cl",
    ),
    ("size = [3]", "bodies[0] lacks the key `kind`"),
    ("kind = 'rope'", "bodies[0] lacks the key `size`"),
    ("kind = 'mesh'", "bodies[0] lacks the key `file`"),
    ("kind = 'explicit'", "bodies[0] lacks the key `particles`: an explicit body needs it"),
    ("size = [nan]\nkind = 'rope'", "bodies[0].size[0] is NaN; it must be a whole number"),
    (
        "kind = 'explicit'\nparticles = [{ position = [0, 0, 0], weight = 1 }]",
        "unknown key `weight` in bodies[0].particles[0]; the keys are position, velocity, mass",
    ),
    (
        "kind = 'explicit'\nparticles = [{ position = [0, 0, 0] }]\nsprings = [{ ends = [0, 7] }]",
        "bodies[0].springs[0].ends[1] is 7; it must be from 0 to 0: there is 1 particle",
    ),
    // Lattices that are refused before they are built; of the last two each fits alone.
    (
        "kind = 'block'\nsize = [1000, 1000, 100]",
        "s.toml:4:8: bodies[0].size asks for 100000000 particles ... 4.0 GB fit",
    ),
    ("kind = 'block'\nsize = [250, 250, 250]", "].size asks for ... 4.0 GB fit"),
    ("kind = 'rope'\nsize = [100000000]", "].size asks for ... 4.0 GB fit"),
    (
        "kind = 'block'\nsize = [18446744073709551615, 18446744073709551615, 18446744073709551615]",
        "].size asks for ... 4.0 GB fit",
    ),
    (
        "kind = 'block'\nsize = [99, 100, 200]\n[[bodies]]\nkind = 'block'\nsize = [99, 99, 200]",
        "].size asks for ... 4.0 GB fit",
    ),
    // Counts are not written out digit by digit.
    ("kind = 'block'\nsize = [9223372036854775807, 9e18, 9]", "size[1] is 9e18"),
    (
        "kind = 'block'\nsize = [9223372036854775807, 9223372036854775807, 9223372036854775807]",
        "more than 1e38 particles",
    ),
    // Meshes whose lattice would be too fine.
    ("kind = 'mesh'\nfile = 'bunny.obj'\nlength = 2\nspacing = 0.009", TOO_FINE),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmass = 1\nmaterial = 'steel'",
        "bodies[0].material and bodies[0].mass exclude each other",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmaterial = 'steel'\nfilling = 'shell'",
        "bodies[0] lacks the key `thickness`, positive and finite: a shell of a mesh with",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nspacing = 2\nyoung = 1e5\ndensity = 1000",
        "bodies[0].spacing: spacing of the mesh body is 2; it must be at most the longest side of",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nyoung = 1e5",
        "bodies[0] lacks the key `density`, positive and finite: a mesh with `young` needs it",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmaterial = 'steel'\nthickness = 1e-3",
        "bodies[0].thickness does not apply to a solid, which this mesh becomes; `filling",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmaterial = 'steel'\nbending = 1",
        "bodies[0].material and bodies[0].bending exclude each other",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmaterial = 'steel'\nthickness = 1e-3\n\
         filling = 'shell'\npoisson = 0.2",
        "bodies[0].poisson is 0.2; it must be 0.3333 (1/3) in a shell, the only one that its",
    ),
    (
        "kind = 'mesh'\nfile = 'bunny.obj'\nmaterial = 'cotton-denim'\nfilling = 'shell'",
        "bodies[0].material is \"cotton-denim\"; it must be that of a solid in a rope, a",
    ),
    ("kind = 'mesh'\nfile = 'bunny.obj'\nlength = 2\nspacing = 0.0001", TOO_FINE),
    ("kind = 'mesh'\nfile = 'bunny.obj'\nlength = 2\nspacing = 1e-300", TOO_FINE),
    // A scene that is only text reaches for no file.
    ("kind = 'mesh'\nfile = '/etc/passwd.obj'", "only a scene that is loaded from a file"),
    // The content of a file cannot move the cursor of a terminal.
    ("kind = \"a\\u001b[2Jb\\n\"", "bodies[0].kind is \"a\\u{1b}[2Jb\\n\"; it must be"),
    (
        "kind = \"mesh\"\nfile = \"a\\u001b.obj\"",
        "bodies[0].file is a\\u{1b}.obj; it must be a name",
    ),
];

/// Springs between two particles, and the message.
const SPRINGS: [(&str, &str); 6] = [
    (
        "{ ends = [0, 0] }",
        "bodies[0].springs[0].ends joins particle 0 to itself; its ends must differ",
    ),
    ("{ ends = [0, 2] }", "bodies[0].springs[0].ends[1] is 2; it must be from 0 to 1"),
    ("{ ends = [0, 1, 2] }", "ends is a list of 3; it must be a list of two whole numbers"),
    ("{ ends = [0, -1] }", "bodies[0].springs[0].ends[1] is -1; it must be a whole number"),
    (
        "{ ends = [1, 1] }",
        "bodies[0].springs[0].ends joins particle 1 to itself; its ends must differ",
    ),
    ("{ ends = [0, 1], rest_length = -1 }", "springs[0].rest_length is -1"),
];

/// Whole scenes, and the message.
const SCENES: [(&str, &str); 16] = [
    ("version = 2\nbodies = []", "version is 2; it must be 1"),
    ("version = 1\nbodies = []", "bodies is empty; a scene needs at least one body"),
    ("version = 1\nbodies = 3", "bodies is 3; it must be a list"),
    ("version = 1\n[[bodies]\n", "s.toml:2:"),
    ("", "the scene lacks the key `version`"),
    ("[[bodies]]\nkind = 'rope'\nsize = [3]", "the scene lacks the key `version`"),
    ("version = 1", "bodies is empty; a scene needs at least one body"),
    ("version = 1\nversion = 1", "s.toml:2:"),
    ("version = 1\n[[bodies]]\nkind = 'ro", "s.toml:3:"),
    ("version = 1\nqqq = 1", "world, camera, bodies, sets, pins, masses, materials, links"),
    ("version = 1\n\"\\u0007\" = 1", "unknown key `\\u{7}` in the scene"),
    ("version = 1\nbodys = []", "unknown key `bodys` in the scene; did you mean `bodies`?"),
    ("version = 1\n[world]\ngravitation = 1", "in world; did you mean `gravity`?"),
    ("version = 1\n[solver]\nsubstep = 1", "in solver; did you mean `substeps`?"),
    ("version = 1\n[[world.planes]]\nfrction = 1", "in world.planes[0]; did you mean `friction`?"),
    ("version = 1\n[[pins]]\npartcle = 1", "in pins[0]; did you mean `particle`?"),
];

/// Whole scenes in JSON, and the message.
const JSON: [(&str, &str); 5] = [
    ("{\"version\": 1,\n \"bodies\": [", "s.json:2:"),
    ("{\"version\": 1, \"bodies\": [{\"kind\"", "s.json:1:"),
    ("{\"version\": 1, \"version\": 1}", "the key `version` stands here twice"),
    ("[]", "the scene is a list"),
    ("{\"version\": null}", "version is null"),
];

/// Meshes, and the beginning of the message.
const MESHES: [(Format, &str, &str); 28] = [
    (
        Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n",
        "line 5: the number of corners is 2; it must be at least 3",
    ),
    (Obj, "v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: the number of corners is 2; it must be at least 3"),
    (
        Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        "line 4: a vertex index is 4; it must be from 1 to 3, or from -3 to -1",
    ),
    (
        Obj,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        "line 4: a vertex index is 9; it must be from 1 to 3, or from -3 to -1",
    ),
    (Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "line 4: a "),
    (Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4: a "),
    (Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", "line 4: a "),
    (Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "line 4: a "),
    (Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/2 3/1\n", "line 5: a texture index is 2"),
    (Obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \u{1b}[2J\n", "line 4: a "),
    (
        Obj,
        "v 0 NaN 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "line 1: y is NaN; it must be finite and within ±1e9",
    ),
    (
        Obj,
        "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n",
        "line 3: y is NaN; it must be finite and within ±1e9",
    ),
    (Obj, "v 0 zero 0\n", "line 1: 'zero' is not a number"),
    (Obj, "v 0 \u{1b}[2J 0\n", "line 1: "),
    (Obj, "v 0 1\n", "line 1: the number of coordinates is 2; it must be at least 3"),
    (Obj, "v 1 1 1 0\n", "line 1: x is inf"),
    (Obj, "hello world\n", "no faces found"),
    (Obj, "# nothing\n", "no faces found"),
    (Obj, "", "no faces found"),
    (Obj, "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no face with an area is left of 1 read"),
    (
        Ply,
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 2\nproperty list uchar int vertex_index\n\
         end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n",
        "face 1: the number of corners is 2; it must be at least 3",
    ),
    (Ply, "ply\nformat ascii 1.0\n", "line "),
    (Ply, "ply\nformat ascii 1.0\nelement \u{1b}[2J 1\nend_header\n", ""),
    (
        Stl,
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
        "the text ends without 'endsolid'; the file is cut short",
    ),
    (Stl, "solid a\nfacet normal 0 0 1\nendsolid a\n", "facet 0: "),
    (
        Gltf,
        r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4294967295,
        "min":[0,0,0],"max":[1,1,1]}],"bufferViews":[{"buffer":0,"byteLength":3}],
        "buffers":[{"uri":"data:;base64,AAAA","byteLength":3}]}"#,
        "accessor 0: it reaches beyond its buffer view",
    ),
    // Its nodes run in a circle.
    (
        Gltf,
        r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],
        "nodes":[{"children":[1]},{"children":[0]}]}"#,
        "node 0 has more than one parent",
    ),
    // A parsed text touches no other file.
    (
        Gltf,
        r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":3}]}"#,
        "buffer 'a.bin' lies in another file; read it by path, or as .glb",
    ),
];

/// Scenes in TOML, and the message.
fn scenes() -> impl Iterator<Item = (String, &'static str)> {
    let rows = LINES.map(|(line, told)| (body(&format!("{ROPE}{line}")), told)).into_iter();
    let rows = rows.chain(BODIES.map(|(lines, told)| (body(lines), told)));
    let rows = rows.chain(SPRINGS.map(|(springs, told)| (pair(springs), told)));
    rows.chain(SCENES.map(|(text, told)| (text.to_string(), told)))
}

#[test]
fn the_json_schema_refuses_what_is_wrong_with_single_values() {
    let validator = jsonschema::validator_for(&json_schema()).expect("a schema");
    let values = scenes().filter_map(|(text, _)| toml::from_str::<serde_json::Value>(&text).ok());
    let (refused, accepted): (Vec<_>, Vec<_>) =
        values.partition(|value| !validator.is_valid(value));
    // The others depend on several values, on a mesh or on memory.
    assert!(80 <= refused.len() && accepted.len() < 60, "{}: {accepted:#?}", refused.len());
}

#[test]
fn what_is_wrong_with_a_scene_is_told_by_place_key_value_and_domain() {
    for (text, told) in scenes() {
        check(&toml(&text).expect_err(&text), told);
    }
    for (text, told) in JSON {
        check(&parse(text, SceneFormat::Json, "s.json").expect_err(text).to_string(), told);
    }
}

fn check_mesh(format: Format, bytes: &[u8], told: &str) {
    let message = mesh::parse(bytes, format, "bad").unwrap_err().to_string();
    assert!(message.starts_with(&format!("bad: {told}")), "{message}\n{told}");
    check(&message, "");
}

#[test]
fn what_is_wrong_with_a_mesh_is_told_by_row_value_and_domain() {
    for (format, text, told) in MESHES {
        check_mesh(format, text.as_bytes(), told);
    }
    let binary = |count: u32, facets: &[u8]| [&[0; 80], &count.to_le_bytes()[..], facets].concat();
    let mut facet = [0; 50];
    facet[12..16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    check_mesh(Stl, &binary(1, &facet), "vertex 0: x is inf; it must be finite and within ±1e9");
    check_mesh(Stl, &[b'x'; 90], "");
    // Headers that announce more rows than fit the memory.
    let told = "the header announces 214748364750 bytes of facets, but only 0 follow";
    check_mesh(Stl, &binary(u32::MAX, &[]), told);
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for element in ["vertex 4294967295\nproperty float x", "nothing 18446744073709551615"] {
            let ply = format!("ply\nformat {format} 1.0\nelement {element}\nend_header\n1 2 3\n");
            check_mesh(Ply, ply.as_bytes(), "the header announces");
        }
    }
}

#[test]
fn what_looks_wrong_in_a_mesh_and_is_not_is_read() {
    // A negative index counts back.
    let mesh = mesh::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n", Obj, "back");
    assert_eq!(mesh.unwrap().triangles, [[0, 1, 2]]);
    // A polyline is not a face.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 5 5 5\nl 1 2 4\np 1\n";
    let mesh = mesh::parse(text.as_bytes(), Obj, "lines").unwrap();
    assert_eq!((mesh.triangles.len(), mesh.report.unused), (1, 1));
    assert!(toml(&body("kind = 'mesh'\nfile = 'bunny.obj'")).is_ok());
}

#[test]
fn what_a_mesh_file_gets_wrong_is_told_by_scene_file_key_and_path() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("s.toml");
    let told = |file: &str| {
        std::fs::write(&scene, body(&format!("kind = 'mesh'\nfile = '{file}'"))).expect("a file");
        load(&scene).expect_err(file).to_string()
    };
    let start =
        |path: &Path| format!("{}:4:8: bodies[0].file: {}: ", scene.display(), path.display());
    let none = folder.path().join("none.obj");
    assert!(told("none.obj").starts_with(&start(&none)), "{}", told("none.obj"));
    let message = told("/");
    assert!(message.starts_with(&start(Path::new("/"))), "{message}");
    assert!(message.contains("it is a folder"), "{message}");
    let text = folder.path().join("text.obj");
    std::fs::write(&text, "hello world\n").expect("a file");
    assert_eq!(told("text.obj"), format!("{}{NO_FACES}", start(&text)));
    assert_eq!(
        open(&text).expect_err("no mesh").to_string(),
        format!("{}: {NO_FACES}", text.display())
    );
    let flat = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(folder.path().join("flat.obj"), flat).expect("a file");
    let solid = body("kind = 'mesh'\nfile = 'flat.obj'\nfilling = 'solid'");
    std::fs::write(&scene, solid).expect("a file");
    let message = load(&scene).expect_err("nothing inside").to_string();
    assert!(message.contains("bodies[0].filling: ") && message.contains("undecided"), "{message}");
}

#[cfg(unix)]
#[test]
fn what_is_not_a_regular_file_is_refused_before_it_is_read() {
    let zero = Path::new("/dev/zero");
    let told = "/dev/zero: cannot be read: it is not a regular file";
    assert_eq!(load(zero).expect_err("a device").to_string(), told);
    let state = load_state(zero, Precision::F32, 3).expect_err("a device");
    assert_eq!(state.to_string(), told);
}

#[test]
fn a_table_of_a_hundred_thousand_keys_is_refused_at_once() {
    let keys: Vec<String> = (0..100_000).map(|key| format!("\"k{key}\": 0")).collect();
    let text = format!("{{{}}}", keys.join(","));
    assert!(parse(&text, SceneFormat::Json, "s.json").is_err());
}

#[test]
fn two_particles_on_one_place_are_meant_and_far_springs_need_precision() {
    let pair = |x: &str, precision: &str| {
        toml(&format!(
            "version = 1\n[solver]\nprecision = '{precision}'\n[[bodies]]\nkind = 'explicit'\n\
             position = [1e5, 0, 0]\nparticles = [{{ position = [0, 0, 0] }}, \
             {{ position = [{x}, 0, 0] }}]\nsprings = [{{ ends = [0, 1], rest_length = 1 }}]\n"
        ))
    };
    assert!(pair("0", "f32").is_ok());
    assert!(pair("1e-4", "f64").is_ok());
    let message = pair("1e-4", "f32").expect_err("too near");
    assert!(
        message.contains("bodies[0].springs[0] joins particles 0 and 1, which f32"),
        "{message}"
    );
}

#[test]
fn deep_nesting_is_refused_and_not_a_crash() {
    for text in [
        "[".repeat(100_000),
        format!("a = {}", "[".repeat(100_000)),
        format!("{}a = 1", "a.".repeat(100_000)),
    ] {
        assert!(toml(&text).is_err());
        assert!(parse(&text, SceneFormat::Json, "s.json").is_err());
    }
}
