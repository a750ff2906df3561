//! The laws of the core, as functions in WGSL and on the processor.

use super::symbol::Parameter::{self, Number, Vector};
use super::symbol::{Spelling, Symbol, function};
use msd_core::laws::{self, Arrived, Law, PlaneLaw, PlaneMeeting};

/// A number of a law: one that computes, or one that is written down.
pub trait Value: laws::Number<Scalar = f32> {}
impl<N: laws::Number<Scalar = f32>> Value for N {}

/// A law with the name and parameters of its function. It gives vectors for the numbers of its
/// parameters in turn.
pub struct Written {
    /// The name of the function in WGSL.
    pub name: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    write: fn(&[Symbol]) -> Vec<[Symbol; 3]>,
    /// The law on the processor.
    pub compute: fn(&[f32]) -> Vec<[f32; 3]>,
}

impl Written {
    /// The function in WGSL.
    pub fn text(&self, spelling: Spelling) -> String {
        function(self.name, self.parameters, spelling, self.write)
    }

    /// The number of numbers that it takes.
    pub fn inputs(&self) -> usize {
        self.parameters.iter().map(Parameter::size).sum()
    }

    /// The number of numbers that it gives.
    pub fn outputs(&self) -> usize {
        3 * (self.compute)(&vec![1.0; self.inputs()]).len()
    }

    /// The place of the first number of a parameter.
    pub fn place(&self, name: &str) -> Option<usize> {
        let at = self.parameters.iter().position(|parameter| parameter.name() == name)?;
        Some(self.parameters[..at].iter().map(Parameter::size).sum())
    }
}

/// Reads numbers and vectors in turn.
struct Inputs<'a, N>(&'a [N]);

impl<N: Value> Inputs<'_, N> {
    fn number(&mut self) -> N {
        let (first, rest) = self.0.split_first().expect("a parameter");
        self.0 = rest;
        *first
    }

    fn vector(&mut self) -> [N; 3] {
        [(); 3].map(|()| self.number())
    }

    fn plane(&mut self) -> PlaneLaw<N> {
        let (normal, offset) = (self.vector(), self.number());
        let [restitution, friction, loss] = self.vector();
        PlaneLaw { normal, offset, restitution, friction, loss }
    }
}

/// A vector of three numbers that are 1 where answers are true, 0 elsewhere.
fn answers<N: Value>(answers: [N::Mask; 3], like: N) -> [N; 3] {
    answers.map(|answer| N::select(answer, like.one(), like.zero()))
}

/// Normal, offset, and restitution, friction and loss of a plane.
const N: Parameter = Vector("n");
const OFFSET: Parameter = Number("offset");
const LAW: Parameter = Vector("law");

fn field<N: Value>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let (gravity, force) = (at.vector(), at.vector());
    let of_particle = [at.number(), at.number()];
    vec![laws::field([gravity, force], of_particle, at.vector())]
}

/// The pull on the end there. Springs that are absent have two equal ends, which pull nothing.
fn pull<N: Value>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let [here, there] = [(); 2].map(|()| [at.vector(), at.vector()]);
    let [rest, stiffness, damping] = at.vector();
    let is_there = rest.is_at_most(rest);
    vec![laws::pull::<_, true>(here, there, Law { rest, stiffness, damping }, is_there).0]
}

fn grab<N: Value>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let here = [at.vector(), at.vector()];
    vec![laws::grab(here, at.vector(), at.vector())]
}

fn bend<N: Value>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let ends = [(); 2].map(|()| [(); 4].map(|()| at.vector()));
    let weights = [(); 4].map(|()| at.number());
    vec![laws::bend(ends, weights, [at.number(), at.number()])]
}

/// A vector after so many seconds at a rate.
fn after<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    vec![[0, 1, 2].map(|axis| s[axis] + s[3 + axis] * s[6])]
}

fn add<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    vec![[0, 1, 2].map(|axis| s[axis] + s[3 + axis])]
}

fn subtract<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    vec![[0, 1, 2].map(|axis| s[axis] - s[3 + axis])]
}

fn scaled<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    vec![[0, 1, 2].map(|axis| s[axis] * s[3])]
}

fn divided<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    vec![[0, 1, 2].map(|axis| s[axis] / s[3])]
}

fn times<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    vec![[s[0] * s[1]; 3]]
}

/// Where a particle was at the start of a substep, by its velocity less that of `lag` seconds.
fn start<N: Value>(s: &[N]) -> Vec<[N; 3]> {
    let [w, lag, h] = [s[9], s[10], s[11]];
    vec![[0, 1, 2].map(|axis| s[axis] - (s[3 + axis] - s[6 + axis] * w * lag) * h)]
}

/// Whether a point is near a plane, and inside for a method that holds points there, and for
/// another.
fn at_plane<N: Value>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let (plane, x) = (at.plane(), at.vector());
    let [near, inside] = plane.is_near_and_inside(x, true);
    let [_, anywhere] = plane.is_near_and_inside(x, false);
    vec![answers([near, inside, anywhere], plane.offset)]
}

/// Velocity after a kick, and whether the particle lies.
fn settle<N: Value, const LOSES: bool>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let plane = at.plane();
    let (motion, lengths) = ([at.vector(), at.vector()], [at.number(), at.number()]);
    let (velocity, lies) = plane.settle(motion, lengths, LOSES);
    vec![velocity, answers([lies; 3], plane.offset)]
}

/// Position and velocity after a plane, and whether the particle was inside and is kept.
fn meet<N: Value, const HOLDS: bool, const BOUNCES: bool>(numbers: &[N]) -> Vec<[N; 3]> {
    let mut at = Inputs(numbers);
    let plane = at.plane();
    let [position, velocity, start, force] = [(); 4].map(|()| at.vector());
    let [w, stiffness, h, lag] = [(); 4].map(|()| at.number());
    let pull = force.map(|force| force * w);
    let arrived = Arrived { position, velocity, start, pull, stiffness: stiffness * w };
    let met = plane.meet(&arrived, [h, lag], PlaneMeeting { holds: HOLDS, bounces: BOUNCES });
    vec![met.position, met.velocity, answers([met.inside, met.keeps, met.keeps], h)]
}

const FIELD: &[Parameter] =
    &[Vector("gravity"), Vector("force"), Number("mass"), Number("drag"), Vector("v")];
const PULL: &[Parameter] =
    &[Vector("x"), Vector("v"), Vector("p"), Vector("u"), Vector("material")];
const GRAB: &[Parameter] = &[Vector("x"), Vector("v"), Vector("goal"), Vector("material")];
#[rustfmt::skip]
const BEND: &[Parameter] = &[
    Vector("x"), Vector("p"), Vector("b"), Vector("c"),
    Vector("v"), Vector("u"), Vector("bv"), Vector("cv"),
    Number("w0"), Number("w1"), Number("w2"), Number("w3"), Number("k"), Number("damping"),
];
const AFTER: &[Parameter] = &[Vector("a"), Vector("rate"), Number("h")];
const TWO: &[Parameter] = &[Vector("a"), Vector("b")];
const WITH_NUMBER: &[Parameter] = &[Vector("a"), Number("w")];
#[rustfmt::skip]
const START: &[Parameter] =
    &[Vector("x"), Vector("v"), Vector("f"), Number("w"), Number("lag"), Number("h")];
#[rustfmt::skip]
const SETTLE: &[Parameter] =
    &[N, OFFSET, LAW, Vector("v"), Vector("a"), Number("length"), Number("substep")];
#[rustfmt::skip]
const MEET: &[Parameter] = &[
    N, OFFSET, LAW, Vector("x"), Vector("v"), Vector("began"), Vector("f"),
    Number("w"), Number("stiffness"), Number("h"), Number("lag"),
];

/// A law by its name, its parameters, and itself for symbols and for numbers.
macro_rules! law {
    ($name:literal, $parameters:expr, $law:expr) => {
        Written { name: $name, parameters: $parameters, write: $law, compute: $law }
    };
}

/// All laws.
pub const LAWS: [Written; 18] = [
    law!("field", FIELD, field),
    law!("pull", PULL, pull),
    law!("bend", BEND, bend),
    law!("grab", GRAB, grab),
    law!("after", AFTER, after),
    law!("add", TWO, add),
    law!("subtract", TWO, subtract),
    law!("scaled", WITH_NUMBER, scaled),
    law!("divided", WITH_NUMBER, divided),
    law!("times", &[Number("w"), Number("h")], times),
    law!("start", START, start),
    law!("at_plane", &[N, OFFSET, LAW, Vector("x")], at_plane),
    law!("settle", SETTLE, settle::<_, false>),
    law!("settle_losing", SETTLE, settle::<_, true>),
    law!("meet", MEET, meet::<_, false, false>),
    law!("meet_bouncing", MEET, meet::<_, false, true>),
    law!("meet_holding", MEET, meet::<_, true, false>),
    law!("meet_holding_bouncing", MEET, meet::<_, true, true>),
];
