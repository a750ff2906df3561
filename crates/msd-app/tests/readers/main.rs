//! Files of `msd export` and `msd run --out`, read back by other programs: numpy, Arrow, VTK,
//! Blender and the glTF validator, which `scripts/readers.sh` installs.

#[path = "../common/mod.rs"]
mod common;

use common::{done, folder, msd, outcome, text};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A cloth, a block, a rope, and a link from the rope to the cloth.
const SCENE: &str = "
version = 1
[[bodies]]
kind = 'cloth'
name = 'sheet'
size = [4, 3]
spacing = 0.5
stiffness = 500
damping = 2
position = [0, 2, 0]
[[bodies]]
kind = 'block'
name = 'block'
size = [3, 3, 3]
spacing = 0.25
stiffness = 500
damping = 2
position = [4, 1, 0]
[[bodies]]
kind = 'rope'
name = 'rope'
size = [4]
spacing = 0.5
stiffness = 500
damping = 2
position = [-3, 2, 0]
[[links]]
from = { body = 'rope', set = 'last' }
to = { body = 'sheet', set = 'first' }
stiffness = 500
damping = 2
[[pins]]
body = 'sheet'
set = 'first'
";

/// Returns the folder of the programs, if they are installed.
fn readers() -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/readers");
    let named = std::env::var_os("MSD_READERS").map(PathBuf::from);
    let readers = named.unwrap_or(target);
    if readers.join("installed.txt").exists() {
        return Some(readers);
    }
    assert!(
        std::env::var_os("MSD_REQUIRE_READERS").is_none(),
        "no readers in {}: scripts/readers.sh installs them",
        readers.display()
    );
    eprintln!("SKIPPED: no readers in {} (scripts/readers.sh installs them)", readers.display());
    None
}

fn succeed(mut command: Command) -> String {
    let output = command.output().expect("an installed program starts");
    let said = [text(&output.stdout), text(&output.stderr)].concat();
    assert!(output.status.success(), "{said}");
    said
}

#[test]
fn other_programs_read_what_is_written() {
    let Some(readers) = readers() else { return };
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("scene.toml"), SCENE).expect("a scene");
    for state in ["state.csv", "state.npz", "state.obj", "state.ply", "state.vtu"] {
        done(msd(path, &["run", "scene.toml", "--duration", "0.5", "--out", state]));
    }
    for to in ["run.npz", "run.pvd", "run.glb", "pc2-cache.pc2", "mdd-cache.mdd"] {
        done(msd(path, &["export", "scene.toml", "--duration", "0.5", "--to", to]));
    }
    if cfg!(feature = "parquet") {
        done(msd(path, &["export", "scene.toml", "--duration", "0.5", "--to", "run.parquet"]));
    }
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers");
    let mut node = Command::new("node");
    node.arg(scripts.join("validate.mjs")).arg(fs::canonicalize(&readers).expect("a folder"));
    node.arg(path.join("run.glb"));
    let info = succeed(node);
    assert!(
        info.contains("\"animationCount\":1") && info.contains("\"hasMorphTargets\":true"),
        "{info}"
    );
    let mut python = Command::new(readers.join("python/bin/python"));
    python.arg(scripts.join("read.py")).arg(path);
    let said = succeed(python);
    let mut formats = vec!["npz", "vtu, pvd", "obj, ply", "pc2, mdd", "glb"];
    if cfg!(feature = "parquet") {
        formats.push("parquet");
    }
    for format in formats {
        assert!(said.lines().any(|line| line == format), "{format}: {said}");
    }
}

#[test]
fn a_mesh_of_the_users_own_keeps_its_texture_and_is_valid() {
    let Some(readers) = readers() else { return };
    let folder = folder();
    done(msd(folder.path(), &["export", "teapot", "--duration", "0.1", "--to", "t.glb"]));
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers");
    let mut node = Command::new("node");
    node.arg(scripts.join("validate.mjs")).arg(fs::canonicalize(&readers).expect("a folder"));
    let output = outcome({
        node.arg(folder.path().join("t.glb"));
        node
    });
    assert!(output.status.success(), "{}", text(&output.stderr));
}
