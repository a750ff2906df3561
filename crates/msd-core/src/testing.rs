//! Consistency checks of elements and obstacles, user-defined or built in.
//!
//! Each check compares two quantities that must agree, by differences in double precision, and
//! reports where they do not.
//!
//! ```
//! use msd_core::elements::{Element, Motion, Vectors};
//! use msd_core::{Real, State, Vector, glam::DVec3, testing};
//!
//! #[derive(Debug)]
//! struct Bowl;
//!
//! impl<R: Real> Element<R> for Bowl {
//!     fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
//!         for particle in 0..motion.particle_count() {
//!             forces.add(particle, motion.position(particle) * R::of(-3.0));
//!         }
//!         0.0
//!     }
//!     fn energy(&self, motion: &Motion<'_, R>) -> f64 {
//!         motion.positions().map(|x| 1.5 * x.to_f64().length_squared()).sum()
//!     }
//! }
//!
//! let positions = vec![DVec3::X, DVec3::new(0.3, -2.0, 1.0)];
//! let state = State { velocities: vec![DVec3::ZERO; 2], positions };
//! testing::check_gradient(&Bowl, &state).unwrap();
//! testing::check_products(&Bowl, &state).unwrap();
//! ```

use crate::columns::LANES;
use crate::columns::slots::{Block, Slots};
use crate::elements::{Element, Motion, Products, Vectors, collected, column};
use crate::number::Real;
use crate::obstacles::Obstacle;
use crate::system::{Columns, State};
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// Length of a difference as a fraction of the size of its argument: its error, about δ² + ε/δ, is
/// least about here.
const REACH: f64 = 1e-5;
/// Tolerance of a comparison of differences: some hundred times their error.
const CLOSE: f64 = 1e-7;

/// A state in columns.
struct Bench {
    slots: Slots,
    columns: Columns<f64>,
}

impl Bench {
    fn new(state: &State<f64>) -> Self {
        let count = state.positions.len();
        let len = count.div_ceil(LANES);
        let slots = Slots::new(vec![Block { particles: 0..count, blank: 0, len, order: None }]);
        let columns = Columns::of(&slots, state, 0);
        Bench { slots, columns }
    }

    fn motion(&self) -> Motion<'_, f64> {
        self.columns.motion(&self.slots, 0.0)
    }

    fn forces(&self, element: &dyn Element<f64>) -> Vec<DVec3> {
        let mut numbers = column::<f64>(&self.slots, 0);
        let mut forces = Vectors { slots: &self.slots, numbers: &mut numbers };
        element.add_forces(&self.motion(), &mut forces);
        collected(&self.slots, &numbers)
    }
}

/// The forces of an element at a state, newtons.
///
/// # Panics
/// If the columns of the state differ in length.
pub fn forces(element: &dyn Element<f64>, state: &State<f64>) -> Vec<DVec3> {
    Bench::new(state).forces(element)
}

/// The products of stiffness and damping of an element with a direction at a state, N/m and N s/m
/// times the direction.
///
/// # Panics
/// If the columns differ in length.
pub fn products(
    element: &dyn Element<f64>,
    state: &State<f64>,
    direction: &[DVec3],
) -> [Vec<DVec3>; 2] {
    let count = state.positions.len();
    let (mut stiffness, mut damping) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]);
    let mut sums = Products { stiffness: &mut stiffness, damping: &mut damping };
    element.add_products(&Bench::new(state).motion(), direction, &mut sums);
    [stiffness, damping]
}

/// A state moved along a direction.
fn moved(state: &State<f64>, direction: &[DVec3], [x, v]: [f64; 2]) -> State<f64> {
    let add = |column: &[DVec3], by: f64| {
        column.iter().zip(direction).map(|(value, d)| *value + *d * by).collect()
    };
    State { positions: add(&state.positions, x), velocities: add(&state.velocities, v) }
}

fn largest(vectors: &[DVec3]) -> f64 {
    vectors.iter().map(|vector| vector.abs().max_element()).fold(0.0, f64::max)
}

/// Rough unit vectors, the same in every run.
fn directions(count: usize) -> Vec<DVec3> {
    let rough = |number: usize| {
        let angle = 1.0 + number as f64 * 0.618_033_988_749_895;
        let part = |factor: f64| angle * factor - Real::abs(angle * factor) as i64 as f64 - 0.5;
        DVec3::new(part(1.0), part(1.7), part(2.9))
    };
    (0..count).map(rough).collect()
}

fn size(state: &State<f64>) -> f64 {
    f64::max(largest(&state.positions), 1e-3)
}

fn compare(what: &str, found: f64, expected: f64, scale: f64) -> Result<(), String> {
    let allowed = CLOSE * f64::max(scale, Real::abs(expected));
    if Real::abs(found - expected) <= allowed {
        return Ok(());
    }
    Err(format!("{what}: {found:e}, expected {expected:e} within {allowed:e}"))
}

/// Checks that without motion the force of an element is minus the gradient of its energy: f·d =
/// −dE along d.
///
/// # Errors
/// Both numbers, where they differ.
///
/// # Panics
/// If the columns of the state differ in length.
pub fn check_gradient(element: &dyn Element<f64>, state: &State<f64>) -> Result<(), String> {
    let still = State { velocities: vec![DVec3::ZERO; state.positions.len()], ..state.clone() };
    let direction = directions(still.positions.len());
    let reach = REACH * size(&still);
    let energy = |side: f64| {
        element.energy(&Bench::new(&moved(&still, &direction, [side * reach, 0.0])).motion())
    };
    let forces = forces(element, &still);
    let work: f64 = forces.iter().zip(&direction).map(|(f, d)| f.dot(*d)).sum();
    let fall = (energy(-1.0) - energy(1.0)) / (2.0 * reach);
    let rounding = f64::EPSILON * Real::abs(energy(0.0)) / (reach * CLOSE);
    compare("work of the forces", work, fall, largest(&forces) + rounding)
}

/// Checks that the products of an element are the derivatives of its forces, except for the term of
/// a turning damper, which they leave out. The motion of the state is ignored.
///
/// # Errors
/// The product and the derivative of the first particle where they differ.
///
/// # Panics
/// If the columns of the state differ in length.
pub fn check_products(element: &dyn Element<f64>, state: &State<f64>) -> Result<(), String> {
    let count = state.positions.len();
    let state = State { velocities: vec![DVec3::ZERO; count], ..state.clone() };
    let direction = directions(count);
    let [stiffness, damping] = products(element, &state, &direction);
    let reach = REACH * size(&state);
    for (what, products, by) in
        [("stiffness", &stiffness, [reach, 0.0]), ("damping", &damping, [0.0, reach])]
    {
        let side = |side: f64| forces(element, &moved(&state, &direction, by.map(|by| by * side)));
        let (ahead, back) = (side(1.0), side(-1.0));
        let rounding = f64::EPSILON * largest(&ahead) / (reach * CLOSE);
        let scale = largest(products) + rounding;
        for particle in 0..count {
            let slope = (back[particle] - ahead[particle]) / (2.0 * reach);
            for axis in 0..3 {
                let what = format!("product with {what} of particle {particle}, axis {axis}");
                compare(&what, products[particle][axis], slope[axis], scale)?;
            }
        }
    }
    Ok(())
}

/// Checks that forces and torques of an element each add up to zero: for elements that only join
/// particles to each other.
///
/// # Errors
/// The sum that is left.
///
/// # Panics
/// If the columns of the state differ in length.
pub fn check_reaction(element: &dyn Element<f64>, state: &State<f64>) -> Result<(), String> {
    let forces = forces(element, state);
    let force: DVec3 = forces.iter().sum();
    let torque: DVec3 = state.positions.iter().zip(&forces).map(|(x, f)| x.cross(*f)).sum();
    let scale = largest(&forces) * forces.len() as f64;
    compare("sum of the forces", force.length(), 0.0, scale)?;
    compare("sum of the torques", torque.length(), 0.0, scale * size(state))
}

/// Checks that an element without a preferred direction is invariant under rotation.
///
/// # Errors
/// The force on the first particle where they differ.
///
/// # Panics
/// If the columns of the state differ in length.
pub fn check_rotation(element: &dyn Element<f64>, state: &State<f64>) -> Result<(), String> {
    // A third of a turn about a diagonal, and a reflection of nothing: exact in any precision.
    let turn = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let turned = |column: &[DVec3]| column.iter().map(|x| turn * *x).collect();
    let there =
        State { positions: turned(&state.positions), velocities: turned(&state.velocities) };
    let (here, there) = (forces(element, state), forces(element, &there));
    let scale = largest(&here);
    for (particle, (here, there)) in here.iter().zip(&there).enumerate() {
        let apart = (turn * *here - *there).length();
        compare(&format!("turned force on particle {particle}"), apart, 0.0, scale)?;
    }
    Ok(())
}

/// Checks that the normal of an obstacle is the gradient of its gap, that both have length one near
/// the surface, and that the gap closes as fast as the surface moves.
///
/// # Errors
/// The first number that differs, and where.
pub fn check_obstacle(
    obstacle: &dyn Obstacle<f64>,
    points: &[DVec3],
    time: f64,
) -> Result<(), String> {
    for &point in points {
        let (normal, velocity) = (obstacle.normal(point, time), obstacle.velocity(point, time));
        let at = format!("at {point}");
        compare(&format!("length of the normal {at}"), normal.length(), 1.0, 1.0)?;
        let reach = REACH * f64::max(point.abs().max_element(), 1e-3);
        for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
            let gap = |side: f64| obstacle.gap(point + unit * (side * reach), time);
            let slope = (gap(1.0) - gap(-1.0)) / (2.0 * reach);
            compare(&format!("normal along axis {axis} {at}"), normal[axis], slope, 1.0)?;
        }
        let gap = |side: f64| obstacle.gap(point, time + side * REACH);
        let opens = (gap(1.0) - gap(-1.0)) / (2.0 * REACH);
        let speed = velocity.length();
        compare(&format!("speed of the surface {at}"), -velocity.dot(normal), opens, 1.0 + speed)?;
    }
    Ok(())
}
