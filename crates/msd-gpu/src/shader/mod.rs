//! The programs of a step in WGSL: laws that [`symbol`] writes down, and the loops around them.

pub mod symbol;
mod laws;

pub use laws::{LAWS, Written};

use msd_core::Integrator;
use symbol::Spelling;

/// The routines of roots and quotients that a device needs to round correctly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Roots {
    /// Those of the device.
    Native,
    /// Newton steps by `fma`.
    Fused,
    /// Integers.
    Whole,
}

impl Roots {
    /// All of them, the fastest first.
    pub const ALL: [Roots; 3] = [Roots::Native, Roots::Fused, Roots::Whole];

    /// The end of the names of its routines.
    fn suffix(self) -> &'static str {
        match self {
            Roots::Native => "native",
            Roots::Fused => "fused",
            Roots::Whole => "whole",
        }
    }
}

/// How a device is made to compute the bits of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Manner {
    /// The form of sums and products.
    pub spelling: Spelling,
    /// The routines of roots and quotients.
    pub roots: Roots,
}

/// The most planes of a scene.
pub const MOST_PLANES: usize = 16;
/// The threads of a workgroup, each with a particle.
pub const THREADS: usize = 64;

/// The routines of all roots and quotients.
pub fn routines() -> &'static str {
    include_str!("exact.wgsl")
}

/// The laws as functions.
pub fn laws(manner: Manner) -> String {
    let end = manner.roots.suffix();
    let chosen = format!(
        "fn root(q: f32) -> f32 {{\n    return root_{end}(q);\n}}\n\
         fn inverse(x: f32) -> f32 {{\n    return inverse_{end}(x);\n}}\n\
         fn quotient(a: f32, b: f32) -> f32 {{\n    return quotient_{end}(a, b);\n}}\n"
    );
    let laws = LAWS.iter().map(|law| law.text(manner.spelling));
    [routines().to_owned(), chosen].into_iter().chain(laws).collect()
}

/// A method as a device steps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Explicit Euler.
    Explicit,
    /// Symplectic Euler.
    Symplectic,
    /// Velocity Verlet.
    Verlet,
    /// RK4.
    Rk4,
}

impl Kind {
    /// The method of an integrator, if a device can step it.
    pub fn of(integrator: Integrator) -> Option<Self> {
        Some(match integrator {
            Integrator::ExplicitEuler => Kind::Explicit,
            Integrator::SymplecticEuler => Kind::Symplectic,
            Integrator::VelocityVerlet => Kind::Verlet,
            Integrator::Rk4 => Kind::Rk4,
            _ => return None,
        })
    }

    /// The vectors that it keeps of each particle beside its state.
    pub fn columns(self) -> usize {
        match self {
            Kind::Explicit | Kind::Symplectic => 1,
            Kind::Verlet => 3,
            Kind::Rk4 => 4,
        }
    }

    /// The part of a substep by which its velocities are ahead of the displacement.
    pub fn lag(self) -> f32 {
        match self {
            Kind::Explicit => 1.0,
            Kind::Symplectic => 0.0,
            Kind::Verlet | Kind::Rk4 => 0.5,
        }
    }

    /// Whether it holds particles on planes after each kick.
    fn holds(self) -> bool {
        matches!(self, Kind::Verlet | Kind::Rk4)
    }

    /// The names of its programs of each particle, beside `begin_step`.
    pub fn programs(self) -> &'static [&'static str] {
        match self {
            Kind::Explicit | Kind::Symplectic => &["advance"],
            Kind::Verlet => &["first_part", "last_part", "both_parts"],
            Kind::Rk4 => &["stage_1", "stage_2", "stage_3", "stage_4", "find_resting"],
        }
    }
}

/// A choice of programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Choice {
    /// The method.
    pub kind: Kind,
    /// Whether planes give speed back.
    pub bounces: bool,
    /// Whether there are bends.
    pub bends: bool,
    /// Whether there are several instances.
    pub are_several: bool,
}

impl Choice {
    /// Every choice.
    pub fn all() -> impl Iterator<Item = Self> {
        let kinds = [Kind::Explicit, Kind::Symplectic, Kind::Verlet, Kind::Rk4].into_iter();
        kinds.flat_map(|kind| {
            (0..8).map(move |bits| {
                let [bounces, bends, are_several] = [1, 2, 4].map(|bit| bits & bit != 0);
                Choice { kind, bounces, bends, are_several }
            })
        })
    }
}

/// The names of the programs of each particle.
pub fn names(kind: Kind) -> impl Iterator<Item = &'static str> {
    ["begin_step"].into_iter().chain(kind.programs().iter().copied())
}

/// The entry `run_NAME` of a program: a thread for each particle, with what it starts from.
fn entry(name: &str) -> String {
    format!(
        "@compute @workgroup_size({THREADS})\n\
         fn run_{name}(@builtin(workgroup_id) group: vec3<u32>,\n    \
         @builtin(local_invocation_index) lane: u32) {{\n    \
         let at = place(group, lane);\n    \
         if at.is_there {{\n        \
         {name}(at, state[2u * at.i], state[2u * at.i + 1u]);\n    }}\n}}\n"
    )
}

/// The programs of a method.
pub fn programs(choice: Choice, manner: Manner) -> String {
    let Choice { kind, bounces, bends, are_several } = choice;
    let (inside, meet) = match (kind.holds(), bounces) {
        (false, false) => ("z", "meet"),
        (false, true) => ("z", "meet_bouncing"),
        (true, false) => ("y", "meet_holding"),
        (true, true) => ("y", "meet_holding_bouncing"),
    };
    let bent = if bends { "f = with_bends(at, f);" } else { "" };
    let step = include_str!("step.wgsl")
        .replace("BENDS", bent)
        .replace("MOST_PLANES", &format!("{MOST_PLANES}"))
        .replace("INSIDE", inside)
        .replace("MEET", meet);
    let method = match kind {
        Kind::Explicit => include_str!("euler.wgsl").replace("VELOCITY", "vm.xyz"),
        Kind::Symplectic => include_str!("euler.wgsl").replace("VELOCITY", "v"),
        Kind::Verlet => include_str!("verlet.wgsl").to_owned(),
        Kind::Rk4 => include_str!("rk4.wgsl").to_owned(),
    };
    // A constant, so that a compiler loads parameters once for all threads.
    let me = if are_several { "me]" } else { "0u]" };
    let entries: String = names(kind).map(entry).collect();
    let bends = if bends { include_str!("bends.wgsl") } else { "" };
    [laws(manner), [&step, bends, &method].concat().replace("ME]", me), entries].concat()
}
