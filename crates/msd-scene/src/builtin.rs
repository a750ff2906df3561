//! The scenes and meshes that the crate carries.

use crate::mesh::{self, Mesh, MeshError};

/// A built-in scene: its name and a description in one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    /// The name a user writes.
    pub name: &'static str,
    /// A description in one line.
    pub title: &'static str,
    /// The scene file, TOML.
    pub text: &'static str,
}

impl Builtin {
    /// The built-in scene or lesson of a name.
    pub fn find(name: &str) -> Option<&'static Builtin> {
        BUILTINS.iter().chain(&LESSONS).find(|builtin| builtin.name == name)
    }
}

macro_rules! builtin {
    ($name:literal, $title:literal) => {
        Builtin {
            name: $name,
            title: $title,
            text: include_str!(concat!("../scenes/", $name, ".toml")),
        }
    };
}

/// The built-in scenes, the default first.
pub const BUILTINS: [Builtin; 24] = [
    builtin!("cube", "a cube of firm jelly, turned and dropped"),
    builtin!("jelly", "a cube of jelly, spun and dropped"),
    builtin!("bunny", "a soft bunny hops, squashes as it lands and stands up again"),
    builtin!("cloth", "a cloth hung up by three points of its top row"),
    builtin!("drape", "a cloth falls on a ball"),
    builtin!("pile", "a dozen soft bodies fall into a box and come to rest on each other"),
    builtin!("trampoline", "three cubes of jelly bounce on a trampoline"),
    builtin!("twist", "a spinning weight twists a strip of cloth, which turns it back"),
    builtin!("funnel", "a weight pulls a cloth through a ring"),
    builtin!("knot", "a rope with a loose knot, which a weight pulls tight"),
    builtin!("curtain", "a ball comes through a curtain of two halves"),
    builtin!("gripper", "two soft fingers lift a soft cube and set it down"),
    builtin!("flag", "a flag flies in a gusty wind"),
    builtin!("stairs", "a block of foam tumbles down the stairs"),
    builtin!("dice", "a die thrown hard against two walls"),
    builtin!("foam", "a cube of foam rubber thrown at a sticky wall"),
    builtin!("mattress", "a mattress tumbling over the floor"),
    builtin!("snake", "a snake of 400 m standing on its tail, until it falls"),
    builtin!("spinner", "a block that spins fast on a slippery floor between walls"),
    builtin!("waffle", "a waffle on edge, sliding, under heavy gravity"),
    builtin!("teapot", "a teapot of thin rubber, dropped"),
    builtin!("chain", "a wave runs along five particles in a row and dies out"),
    builtin!("square", "a square with diagonals falls on the floor and keeps its shape"),
    builtin!("square4", "the same square without diagonals collapses"),
];

/// The built-in lessons: scenes with a question, in the order in which they build on each other.
pub const LESSONS: [Builtin; 8] = [
    builtin!("lesson-hooke", "Hooke's law and frequency"),
    builtin!("lesson-step", "What a time step is"),
    builtin!("lesson-euler", "Why explicit Euler gains energy"),
    builtin!("lesson-order", "The order of a method"),
    builtin!("lesson-stiffness", "Stiffness and the stable step"),
    builtin!("lesson-damping", "The damping ratio"),
    builtin!("lesson-resolution", "Resolution and convergence"),
    builtin!("lesson-friction", "Friction and the critical slope"),
];

/// The meshes that the crate carries, by the file name that a scene may give.
const MESHES: [(&str, &[u8]); 2] = [
    ("bunny.obj", include_bytes!("../meshes/bunny.obj")),
    ("teapot.obj", include_bytes!("../meshes/teapot.obj")),
];

/// The mesh that the crate carries by this file name.
pub(crate) fn carried(file: &str) -> Option<Result<Mesh, MeshError>> {
    let (name, bytes) = MESHES.into_iter().find(|mesh| mesh.0 == file)?;
    Some(mesh::parse(bytes, mesh::Format::Obj, name))
}
