//! A number that records what a law does with it, and writes that down as a function in WGSL.

use msd_core::laws::Number;
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Write;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// How sums, products, quotients and roots are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Spelling {
    /// As operators. A compiler may fuse and approximate them, so that bits differ.
    Plain,
    /// Sums and products as `fma` with a uniform that the compiler does not know, so that it can
    /// neither fuse two operations nor reorder them. Quotients and roots by routines that round
    /// correctly.
    Exact,
    /// Each result is reinterpreted as an integer and back, so that no float optimisation spans two
    /// operations. For compilers that take `fma` apart.
    Hidden,
}

/// A number of a law that is being recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Symbol(u32);

/// An answer of a law that is being recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Truth(u32);

impl Truth {
    /// The answer that a number is at most itself. Another one and it are the other one; it serves
    /// no other purpose. A NaN is not at most itself, and ends a run on a device as well.
    const ALWAYS: Truth = Truth(u32::MAX);
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Operation {
    Add,
    Sub,
    Mul,
    Div,
    Neg,
    Sqrt,
    Abs,
    IsLess,
    IsAtMost,
    And,
    Or,
    Select,
}

impl Operation {
    /// The number of its operands.
    fn arity(self) -> usize {
        match self {
            Operation::Neg | Operation::Sqrt | Operation::Abs => 1,
            Operation::Select => 3,
            _ => 2,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Node {
    Input(String),
    /// The bits of a constant.
    Constant(u32),
    Operation(Operation, [u32; 3]),
}

/// The operations so far. Equal ones are recorded once.
#[derive(Default)]
struct Tape {
    nodes: Vec<Node>,
    known: HashMap<Node, u32>,
}

thread_local!(static TAPE: RefCell<Tape> = RefCell::default());

fn record(node: Node) -> u32 {
    TAPE.with_borrow_mut(|Tape { nodes, known }| {
        *known.entry(node.clone()).or_insert_with(|| {
            nodes.push(node);
            nodes.len() as u32 - 1
        })
    })
}

fn operate(operation: Operation, operands: [u32; 3]) -> u32 {
    record(Node::Operation(operation, operands))
}

macro_rules! impl_operator {
    ($operator:ident, $function:ident, $kind:ident, $by:expr) => {
        impl $operator for $kind {
            type Output = $kind;
            fn $function(self, other: $kind) -> $kind {
                $kind(operate($by, [self.0, other.0, 0]))
            }
        }
    };
}

impl_operator!(Add, add, Symbol, Operation::Add);
impl_operator!(Sub, sub, Symbol, Operation::Sub);
impl_operator!(Mul, mul, Symbol, Operation::Mul);
impl_operator!(Div, div, Symbol, Operation::Div);
impl_operator!(BitOr, bitor, Truth, Operation::Or);

impl BitAnd for Truth {
    type Output = Truth;
    fn bitand(self, other: Truth) -> Truth {
        match [self, other] {
            [Truth::ALWAYS, answer] | [answer, Truth::ALWAYS] => answer,
            [a, b] => Truth(operate(Operation::And, [a.0, b.0, 0])),
        }
    }
}

impl Neg for Symbol {
    type Output = Symbol;
    fn neg(self) -> Symbol {
        Symbol(operate(Operation::Neg, [self.0, 0, 0]))
    }
}

impl Number for Symbol {
    type Scalar = f32;
    type Mask = Truth;

    fn splat(self, value: f32) -> Symbol {
        Symbol(record(Node::Constant(value.to_bits())))
    }
    fn sqrt(self) -> Symbol {
        Symbol(operate(Operation::Sqrt, [self.0, 0, 0]))
    }
    fn abs(self) -> Symbol {
        Symbol(operate(Operation::Abs, [self.0, 0, 0]))
    }
    fn is_less(self, other: Symbol) -> Truth {
        Truth(operate(Operation::IsLess, [self.0, other.0, 0]))
    }
    fn is_at_most(self, other: Symbol) -> Truth {
        if self == other {
            return Truth::ALWAYS;
        }
        Truth(operate(Operation::IsAtMost, [self.0, other.0, 0]))
    }
    fn select(mask: Truth, yes: Symbol, no: Symbol) -> Symbol {
        Symbol(operate(Operation::Select, [mask.0, yes.0, no.0]))
    }
}

/// A parameter of a function in WGSL.
#[derive(Clone, Copy, Debug)]
pub enum Parameter {
    /// An `f32`.
    Number(&'static str),
    /// A `vec3<f32>`.
    Vector(&'static str),
}

impl Parameter {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Parameter::Number(name) | Parameter::Vector(name) => name,
        }
    }

    /// The number of its numbers.
    pub fn size(&self) -> usize {
        match self {
            Parameter::Number(_) => 1,
            Parameter::Vector(_) => 3,
        }
    }
}

/// Writes a law as a function in WGSL. It is given a symbol for each number of its parameters in
/// turn, and returns vectors; the function returns one `vec3<f32>` or an array of them.
pub fn function(
    name: &str,
    parameters: &[Parameter],
    spelling: Spelling,
    law: impl FnOnce(&[Symbol]) -> Vec<[Symbol; 3]>,
) -> String {
    TAPE.take();
    let mut inputs = Vec::new();
    let mut list = Vec::new();
    let mut input = |name: String| inputs.push(Symbol(record(Node::Input(name))));
    for parameter in parameters {
        match parameter {
            Parameter::Number(name) => {
                list.push(format!("{name}: f32"));
                input((*name).to_owned());
            }
            Parameter::Vector(name) => {
                list.push(format!("{name}: vec3<f32>"));
                ["x", "y", "z"].into_iter().for_each(|axis| input(format!("{name}.{axis}")));
            }
        }
    }
    let outputs = law(&inputs);
    let writer = Writer::new(TAPE.take().nodes, spelling);
    let result = match outputs.len() {
        1 => "vec3<f32>".to_owned(),
        count => format!("array<vec3<f32>, {count}>"),
    };
    let mut text = format!("fn {name}({}) -> {result} {{\n", list.join(", "));
    writer.write_operations(&mut text, &outputs);
    let vectors: Vec<String> = outputs.iter().map(|vector| writer.vector(vector)).collect();
    let value = match &vectors[..] {
        [vector] => vector.clone(),
        vectors => format!("{result}({})", vectors.join(", ")),
    };
    writeln!(text, "    return {value};\n}}").expect("a string takes any text");
    text
}

/// Writes recorded operations.
struct Writer {
    nodes: Vec<Node>,
    spelling: Spelling,
    /// Of each sum, the number of sums that it is nested in at most.
    depths: Vec<usize>,
}

impl Writer {
    fn new(nodes: Vec<Node>, spelling: Spelling) -> Self {
        let mut depths = vec![0; nodes.len()];
        for (at, node) in nodes.iter().enumerate() {
            let Node::Operation(operation, [a, b, _]) = node else { continue };
            let below = |term: &u32| match &nodes[*term as usize] {
                Node::Operation(Operation::Add | Operation::Sub | Operation::Neg, _) => {
                    depths[*term as usize] + 1
                }
                _ => 0,
            };
            depths[at] = match operation {
                Operation::Add | Operation::Sub => below(a).max(below(b)),
                Operation::Neg => depths[*a as usize],
                _ => 0,
            };
        }
        Writer { nodes, spelling, depths }
    }

    /// Writes the operations that the outputs need.
    fn write_operations(&self, text: &mut String, outputs: &[[Symbol; 3]]) {
        let mut needed = vec![false; self.nodes.len()];
        let mut open: Vec<u32> = outputs.iter().flatten().map(|symbol| symbol.0).collect();
        while let Some(at) = open.pop() {
            if std::mem::replace(&mut needed[at as usize], true) {
                continue;
            }
            if let Node::Operation(operation, operands) = &self.nodes[at as usize] {
                open.extend(&operands[..operation.arity()]);
            }
        }
        for (at, node) in self.nodes.iter().enumerate().filter(|(at, _)| needed[*at]) {
            if let Node::Operation(operation, operands) = node {
                let value = self.operation(at, *operation, *operands);
                writeln!(text, "    let t{at} = {value};").expect("a string takes any text");
            }
        }
    }

    fn vector(&self, [x, y, z]: &[Symbol; 3]) -> String {
        format!("vec3<f32>({}, {}, {})", self.term(x.0), self.term(y.0), self.term(z.0))
    }

    fn term(&self, at: u32) -> String {
        match &self.nodes[at as usize] {
            Node::Input(name) => name.clone(),
            Node::Operation(..) => format!("t{at}"),
            // A compiler that knows that it adds 0 or multiplies by 1 does not do it.
            Node::Constant(0) if self.spelling != Spelling::Plain => "exact.nothing".to_owned(),
            Node::Constant(ONE) if self.spelling != Spelling::Plain => "exact.one".to_owned(),
            Node::Constant(bits) => format!("{:e}f", f32::from_bits(*bits)),
        }
    }

    fn operation(&self, at: usize, operation: Operation, operands: [u32; 3]) -> String {
        use Spelling::{Exact, Hidden, Plain};
        let [a, b, c] = operands.map(|at| self.term(at));
        // Nested sums have units of their own: a compiler that takes `fma` apart would find a
        // common factor and add in another order.
        let unit = ["x", "y", "z", "w"][self.depths[at] % 4];
        let is_inverse = self.nodes[operands[0] as usize] == Node::Constant(ONE);
        match (operation, self.spelling) {
            (Operation::Add, Plain) => format!("{a} + {b}"),
            (Operation::Sub, Plain) => format!("{a} - {b}"),
            (Operation::Mul, Plain) => format!("{a} * {b}"),
            (Operation::Div, Plain) => format!("{a} / {b}"),
            (Operation::Sqrt, Plain) => format!("sqrt({a})"),
            (Operation::Add, Hidden) => format!("hidden({a} + {b})"),
            (Operation::Sub, Hidden) => format!("hidden({a} - {b})"),
            (Operation::Mul, Hidden) => format!("hidden({a} * {b})"),
            (Operation::Add, Exact) => format!("fma({a}, exact.unit.{unit}, {b})"),
            (Operation::Sub, Exact) => format!("fma({a}, exact.unit.{unit}, -{b})"),
            (Operation::Mul, Exact) => format!("fma({a}, {b}, exact.minus_zero)"),
            (Operation::Div, _) if is_inverse => format!("inverse({b})"),
            (Operation::Div, _) => format!("quotient({a}, {b})"),
            (Operation::Sqrt, _) => format!("root({a})"),
            (Operation::Neg, _) => format!("-{a}"),
            (Operation::Abs, _) => format!("abs({a})"),
            (Operation::IsLess, _) => format!("{a} < {b}"),
            (Operation::IsAtMost, _) => format!("{a} <= {b}"),
            (Operation::And, _) => format!("{a} && {b}"),
            (Operation::Or, _) => format!("{a} || {b}"),
            (Operation::Select, _) => format!("select({c}, {b}, {a})"),
        }
    }
}

/// The bits of one.
const ONE: u32 = 1f32.to_bits();

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_is_written_with_each_operation_once_and_without_those_that_nothing_needs() {
        let text = function(
            "law",
            &[Parameter::Vector("a"), Parameter::Number("b")],
            Spelling::Plain,
            |s| {
                let square = s[0] * s[0];
                let again = s[0] * s[0];
                let _unused = s[1] / s[3];
                vec![[square + again, s[2], s[3].sqrt()]]
            },
        );
        assert_eq!(
            text,
            "fn law(a: vec3<f32>, b: f32) -> vec3<f32> {\n    let t4 = a.x * a.x;\n    \
             let t6 = t4 + t4;\n    let t7 = sqrt(b);\n    return vec3<f32>(t6, a.z, t7);\n}\n"
        );
    }

    #[test]
    fn nested_sums_have_units_of_their_own() {
        let text = function("sum", &[Parameter::Vector("a")], Spelling::Exact, |s| {
            vec![[s[0] + s[1] + s[2], s[0], s[0]]]
        });
        assert!(text.contains("fma(a.x, exact.unit.x, a.y)"), "{text}");
        assert!(text.contains("exact.unit.y, a.z)"), "{text}");
    }
}
