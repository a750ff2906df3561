//! The laws of the core, written as functions in WGSL.

use super::symbol::Parameter::{self, Number, Vector};
use super::symbol::{Spelling, Symbol, Truth, answers, function};
use msd_core::laws::{self, Arrived, Law, Meeting, PlaneLaw};

/// A law with the name and parameters of its function.
pub struct Written {
    /// The name of the function in WGSL.
    pub name: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    law: fn(&[Symbol]) -> Vec<[Symbol; 3]>,
}

impl Written {
    /// The function in WGSL.
    pub fn text(&self, spelling: Spelling) -> String {
        function(self.name, self.parameters, spelling, self.law)
    }
}

/// Reads numbers and vectors in turn.
struct Inputs<'a>(&'a [Symbol]);

impl Inputs<'_> {
    fn number(&mut self) -> Symbol {
        let (first, rest) = self.0.split_first().expect("a parameter");
        self.0 = rest;
        *first
    }

    fn vector(&mut self) -> [Symbol; 3] {
        [(); 3].map(|()| self.number())
    }

    fn plane(&mut self) -> PlaneLaw<Symbol> {
        let (normal, offset) = (self.vector(), self.number());
        let [restitution, friction, loss] = self.vector();
        PlaneLaw { normal, offset, restitution, friction, loss }
    }
}

/// Normal, offset, and restitution, friction and loss of a plane.
const N: Parameter = Vector("n");
const OFFSET: Parameter = Number("offset");
const LAW: Parameter = Vector("law");

const FIELD: Written = Written {
    name: "field",
    parameters: &[Vector("gravity"), Vector("force"), Number("mass"), Number("drag"), Vector("v")],
    law: |symbols| {
        let mut at = Inputs(symbols);
        let (gravity, force) = (at.vector(), at.vector());
        let numbers = [at.number(), at.number()];
        vec![laws::field([gravity, force], numbers, at.vector())]
    },
};

/// The pull on the end there. Springs that are absent have two equal ends, which pull nothing.
const PULL: Written = Written {
    name: "pull",
    parameters: &[Vector("x"), Vector("v"), Vector("p"), Vector("u"), Vector("law")],
    law: |symbols| {
        let mut at = Inputs(symbols);
        let [here, there] = [(); 2].map(|()| [at.vector(), at.vector()]);
        let [rest, stiffness, damping] = at.vector();
        let law = Law { rest, stiffness, damping };
        vec![laws::pull::<_, true>(here, there, law, Truth::ALWAYS).0]
    },
};

const GRAB: Written = Written {
    name: "grab",
    parameters: &[Vector("x"), Vector("v"), Vector("goal"), Vector("law")],
    law: |symbols| {
        let mut at = Inputs(symbols);
        let here = [at.vector(), at.vector()];
        vec![laws::grab(here, at.vector(), at.vector())]
    },
};

/// A vector after so many seconds at a rate.
const AFTER: Written = Written {
    name: "after",
    parameters: &[Vector("a"), Vector("rate"), Number("h")],
    law: |s| vec![[s[0] + s[3] * s[6], s[1] + s[4] * s[6], s[2] + s[5] * s[6]]],
};

const ADD: Written = Written {
    name: "add",
    parameters: &[Vector("a"), Vector("b")],
    law: |s| vec![[s[0] + s[3], s[1] + s[4], s[2] + s[5]]],
};

const SUBTRACT: Written = Written {
    name: "subtract",
    parameters: &[Vector("a"), Vector("b")],
    law: |s| vec![[s[0] - s[3], s[1] - s[4], s[2] - s[5]]],
};

const SCALED: Written = Written {
    name: "scaled",
    parameters: &[Vector("a"), Number("b")],
    law: |s| vec![[s[0] * s[3], s[1] * s[3], s[2] * s[3]]],
};

const DIVIDED: Written = Written {
    name: "divided",
    parameters: &[Vector("a"), Number("b")],
    law: |s| vec![[s[0] / s[3], s[1] / s[3], s[2] / s[3]]],
};

const TIMES: Written = Written {
    name: "times",
    parameters: &[Number("a"), Number("b")],
    law: |s| vec![[s[0] * s[1]; 3]],
};

/// Where a particle was at the start of a substep, by its velocity less that of `lag` seconds.
const START: Written = Written {
    name: "start",
    parameters: &[Vector("x"), Vector("v"), Vector("f"), Number("w"), Number("lag"), Number("h")],
    law: |s| {
        let [w, lag, h] = [s[9], s[10], s[11]];
        vec![[0, 1, 2].map(|axis| s[axis] - (s[3 + axis] - s[6 + axis] * w * lag) * h)]
    },
};

/// Whether a point is near a plane, and inside for a method that holds points there, and for
/// another.
const AT_PLANE: Written = Written {
    name: "at_plane",
    parameters: &[N, OFFSET, LAW, Vector("x")],
    law: |symbols| {
        let mut at = Inputs(symbols);
        let (plane, x) = (at.plane(), at.vector());
        let [near, inside] = plane.is_near_and_inside(x, true);
        let [_, anywhere] = plane.is_near_and_inside(x, false);
        vec![answers([near, inside, anywhere], plane.offset)]
    },
};

/// Velocity after a kick, and whether the particle lies.
fn settle(symbols: &[Symbol], loses: bool) -> Vec<[Symbol; 3]> {
    let mut at = Inputs(symbols);
    let plane = at.plane();
    let (motion, lengths) = ([at.vector(), at.vector()], [at.number(), at.number()]);
    let (velocity, lies) = plane.settle(motion, lengths, loses);
    vec![velocity, answers([lies; 3], plane.offset)]
}

const SETTLE_PARAMETERS: &[Parameter] =
    &[N, OFFSET, LAW, Vector("v"), Vector("a"), Number("length"), Number("substep")];
const SETTLE: Written =
    Written { name: "settle", parameters: SETTLE_PARAMETERS, law: |s| settle(s, false) };
const SETTLE_LOSING: Written =
    Written { name: "settle_losing", parameters: SETTLE_PARAMETERS, law: |s| settle(s, true) };

/// Position and velocity after a plane, and whether the particle was inside and is kept.
fn meet(symbols: &[Symbol], how: Meeting) -> Vec<[Symbol; 3]> {
    let mut at = Inputs(symbols);
    let plane = at.plane();
    let [position, velocity, start, force] = [(); 4].map(|()| at.vector());
    let [w, stiffness, h, lag] = [(); 4].map(|()| at.number());
    let arrived = Arrived {
        position,
        velocity,
        start,
        pull: force.map(|force| force * w),
        stiffness: stiffness * w,
    };
    let met = plane.meet(&arrived, [h, lag], how);
    vec![met.position, met.velocity, answers([met.inside, met.keeps, met.keeps], h)]
}

#[rustfmt::skip]
const MEET_PARAMETERS: &[Parameter] = &[
    N, OFFSET, LAW, Vector("x"), Vector("v"), Vector("began"), Vector("f"),
    Number("w"), Number("stiffness"), Number("h"), Number("lag"),
];
const MEET: Written = Written {
    name: "meet",
    parameters: MEET_PARAMETERS,
    law: |s| meet(s, Meeting { holds: false, bounces: false }),
};
const MEET_BOUNCING: Written = Written {
    name: "meet_bouncing",
    parameters: MEET_PARAMETERS,
    law: |s| meet(s, Meeting { holds: false, bounces: true }),
};
const MEET_HOLDING: Written = Written {
    name: "meet_holding",
    parameters: MEET_PARAMETERS,
    law: |s| meet(s, Meeting { holds: true, bounces: false }),
};
const MEET_HOLDING_BOUNCING: Written = Written {
    name: "meet_holding_bouncing",
    parameters: MEET_PARAMETERS,
    law: |s| meet(s, Meeting { holds: true, bounces: true }),
};

/// All laws.
pub const LAWS: [Written; 17] = [
    FIELD,
    PULL,
    GRAB,
    AFTER,
    ADD,
    SUBTRACT,
    SCALED,
    DIVIDED,
    TIMES,
    START,
    AT_PLANE,
    SETTLE,
    SETTLE_LOSING,
    MEET,
    MEET_BOUNCING,
    MEET_HOLDING,
    MEET_HOLDING_BOUNCING,
];
