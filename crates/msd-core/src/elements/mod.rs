//! Elements: the forces on particles, one type for each kind.
//!
//! Springs are an element, and so are the fields, grabs and pushes; a caller may add their own. An
//! element adds its forces at a motion and returns the power that it dissipates, knows its energy,
//! and multiplies a direction by its stiffness and its damping, as the implicit methods and the
//! prediction of the stable step require. A new one is one file with this trait.

pub mod fields;
pub mod grabs;
pub mod springs;
mod bundles;
pub mod bends;
pub mod volumes;
pub mod touches;

use crate::columns::slots::Slots;
use crate::columns::{self, Aligned, LANES, RECORD};
use crate::number::{Real, Vector, of_type};
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt::Debug;
use glam::DVec3;
use springs::{SpringWork, Springs};
use touches::near::Near;

/// A source of force on particles.
///
/// ```
/// use msd_core::elements::{Element, Motion, Vectors};
/// use msd_core::{Real, Vector};
///
/// /// A spring of 3 N/m from the origin to each particle.
/// #[derive(Debug)]
/// struct Bowl;
///
/// impl<R: Real> Element<R> for Bowl {
///     fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
///         for particle in 0..motion.particle_count() {
///             forces.add(particle, motion.position(particle) * R::of(-3.0));
///         }
///         0.0
///     }
///     fn energy(&self, motion: &Motion<'_, R>) -> f64 {
///         let squares = motion.positions().map(|x| x.to_f64().length_squared());
///         squares.map(|square| 1.5 * square).sum()
///     }
/// }
/// ```
pub trait Element<R: Real>: Debug + Send + Sync {
    /// Adds forces at a motion, newtons, and returns the power that they dissipate, watts.
    ///
    /// What [`Element::energy`] accounts for is not dissipated. A force without an energy
    /// dissipates −f·v, which is negative where it drives the motion. The same motion must give the
    /// same bits.
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64;

    /// The energy stored at a motion, joules. Default 0.
    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        let _ = motion;
        0.0
    }

    /// Adds the products of stiffness, −∂f/∂x, and damping, −∂f/∂v, with a direction, one vector
    /// for each particle in the order of the scene. Default: differences of the forces, at the cost
    /// of four evaluations.
    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        add_differences(self, motion, direction, products);
    }

    /// Adds the diagonal blocks of stiffness and damping. Default: none. They precondition the
    /// solves of the implicit methods and decide where a prediction of the stable step looks first;
    /// they change no result beyond that.
    fn add_blocks(&self, motion: &Motion<'_, R>, blocks: &mut Blocks<'_>) {
        let _ = (motion, blocks);
    }
}

/// Positions and velocities at which forces are evaluated, and the time.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a, R> {
    pub(crate) slots: &'a Slots,
    pub(crate) positions: &'a [R],
    pub(crate) velocities: &'a [R],
    pub(crate) time: f64,
}

impl<'a, R: Real> Motion<'a, R> {
    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        self.slots.particle_count()
    }

    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The position of a particle, metres.
    ///
    /// # Panics
    /// If there is no such particle.
    #[inline]
    pub fn position(&self, particle: usize) -> R::Vec3 {
        columns::vector(self.positions, self.slots.at(particle))
    }

    /// The velocity of a particle, metres per second.
    ///
    /// # Panics
    /// If there is no such particle.
    #[inline]
    pub fn velocity(&self, particle: usize) -> R::Vec3 {
        columns::vector(self.velocities, self.slots.at(particle))
    }

    /// The positions of all particles in the order of the scene, metres.
    pub fn positions(&self) -> impl Iterator<Item = R::Vec3> + 'a {
        let positions = self.positions;
        self.slots.places().map(move |at| columns::vector(positions, at))
    }

    /// The velocities of all particles in the order of the scene, metres per second.
    pub fn velocities(&self) -> impl Iterator<Item = R::Vec3> + 'a {
        let velocities = self.velocities;
        self.slots.places().map(move |at| columns::vector(velocities, at))
    }
}

/// A vector for each particle, mutable.
#[derive(Debug)]
pub struct Vectors<'a, R> {
    pub(crate) slots: &'a Slots,
    pub(crate) numbers: &'a mut [R],
}

impl<R: Real> Vectors<'_, R> {
    /// The vector of a particle.
    ///
    /// # Panics
    /// If there is no such particle.
    #[inline]
    pub fn get(&self, particle: usize) -> R::Vec3 {
        columns::vector(self.numbers, self.slots.at(particle))
    }

    /// Adds to the vector of a particle.
    ///
    /// # Panics
    /// If there is no such particle.
    #[inline]
    pub fn add(&mut self, particle: usize, vector: R::Vec3) {
        let at = self.slots.at(particle);
        let sum = columns::vector::<R>(self.numbers, at) + vector;
        columns::set_vector(self.numbers, at, sum);
    }
}

/// Products of stiffness and damping with a direction: a vector for each particle, in scene order.
#[derive(Debug)]
pub struct Products<'a> {
    /// Products with the stiffness.
    pub stiffness: &'a mut [DVec3],
    /// Products with the damping.
    pub damping: &'a mut [DVec3],
}

impl Products<'_> {
    /// Adds products with stiffness and damping for one particle.
    pub fn add(&mut self, particle: usize, [stiffness, damping]: [DVec3; 2]) {
        self.stiffness[particle] += stiffness;
        self.damping[particle] += damping;
    }

    /// Adds products to the second of two particles, and their opposites to the first.
    pub fn add_between(&mut self, [a, b]: [usize; 2], [stiffness, damping]: [DVec3; 2]) {
        self.add(a, [-stiffness, -damping]);
        self.add(b, [stiffness, damping]);
    }
}

/// A symmetric matrix, as its entries xx, xy, xz, yy, yz and zz.
pub type Block = [f64; 6];

/// The diagonal blocks of stiffness and damping, one for each particle, in scene order.
#[derive(Debug)]
pub struct Blocks<'a> {
    /// Stiffness, newtons per metre.
    pub stiffness: &'a mut [Block],
    /// Damping, newton seconds per metre.
    pub damping: &'a mut [Block],
}

/// Adds products found by central differences of the forces.
fn add_differences<R: Real, E: Element<R> + ?Sized>(
    element: &E,
    motion: &Motion<'_, R>,
    direction: &[DVec3],
    products: &mut Products<'_>,
) {
    let longest = direction.iter().map(|d| d.abs().max_element()).fold(0.0, f64::max);
    if longest == 0.0 {
        return;
    }
    let size =
        |column: &[R], least: f64| column.iter().map(|x| x.abs().to_f64()).fold(least, f64::max);
    // The error of a central difference, ε/δ + δ², is least about the cube root of ε.
    let epsilon = if R::EPSILON.to_f64() < 1e-10 { 1e-5 } else { 4e-3 };
    let mut changed = motion.positions.to_vec();
    let mut difference = |column: &[R], is_position: bool, to: &mut [DVec3]| {
        // Particles at rest give no speed to compare with: take a metre per second.
        let reach = epsilon * size(column, if is_position { 1e-3 } else { 1.0 }) / longest;
        let mut sides = [1.0, -1.0].map(|side| {
            changed.copy_from_slice(column);
            for (at, d) in motion.slots.places().zip(direction) {
                let x: R::Vec3 = columns::vector(column, at);
                columns::set_vector(&mut changed, at, x + R::Vec3::of(*d * (side * reach)));
            }
            let motion = if is_position {
                Motion { positions: &changed, ..*motion }
            } else {
                Motion { velocities: &changed, ..*motion }
            };
            let mut forces = vec![R::ZERO; column.len()];
            let mut sums = Vectors { slots: motion.slots, numbers: &mut forces };
            element.add_forces(&motion, &mut sums);
            forces
        });
        let [ahead, back] = &mut sides;
        for (at, to) in motion.slots.places().zip(to) {
            let apart =
                columns::vector::<R>(ahead, at).to_f64() - columns::vector::<R>(back, at).to_f64();
            *to -= apart / (2.0 * reach);
        }
    };
    difference(motion.positions, true, products.stiffness);
    difference(motion.velocities, false, products.damping);
}

/// Scratch of an evaluation of all forces.
#[derive(Clone, Debug)]
pub(crate) struct ForceWork<R: Real> {
    pub(crate) springs: SpringWork<R>,
    /// The pairs that may touch.
    pub(crate) near: Near<R>,
    /// The power that user-defined elements dissipated at the last evaluation, watts.
    pub(crate) own_power: f64,
}

impl<R: Real> ForceWork<R> {
    pub(crate) fn new(springs: &Springs<R>, slots: &Slots) -> Self {
        ForceWork {
            springs: SpringWork::new(springs, slots),
            near: Near::default(),
            own_power: 0.0,
        }
    }
}

/// The ends of springs that were cut, in order.
#[derive(Clone, Debug)]
pub(crate) struct Torn(Vec<[u32; 2]>);

impl Torn {
    pub(crate) fn new(springs: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut torn: Vec<[u32; 2]> = springs.map(sorted).collect();
        torn.sort_unstable();
        Torn(torn)
    }

    /// Whether one of the springs went from one of some particles to another of them.
    pub(crate) fn crosses(&self, particles: &[u32]) -> bool {
        let is_torn = |a: u32, b: u32| self.0.binary_search(&sorted([a, b])).is_ok();
        let mut rows = particles.iter().enumerate();
        rows.any(|(row, &a)| particles[..row].iter().any(|&b| is_torn(a, b)))
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// A user-defined element, for either precision.
#[derive(Clone, Debug)]
pub(crate) struct Own {
    single: Arc<dyn Element<f32>>,
    double: Arc<dyn Element<f64>>,
}

impl Own {
    pub(crate) fn new<E: Element<f32> + Element<f64> + 'static>(element: E) -> Self {
        let element = Arc::new(element);
        Own { single: element.clone(), double: element }
    }

    /// The element for one precision.
    pub(crate) fn of<R: Real>(&self) -> &dyn Element<R> {
        &**of_type::<Arc<dyn Element<R>>>(&self.single, &self.double)
    }
}

/// A column of vectors with a zero for every particle.
pub(crate) fn column<R: Real>(slots: &Slots, place: usize) -> Aligned<R> {
    Aligned::new(slots.record_count() * RECORD, place)
}

/// Overwrites a column of vectors with those of particles in scene order.
pub(crate) fn spread<R: Real>(slots: &Slots, vectors: &[R::Vec3], column: &mut [R]) {
    for (at, &vector) in slots.places().zip(vectors) {
        columns::set_vector(column, at, vector);
    }
}

/// The vectors of a column in scene order.
pub(crate) fn collected<R: Real>(slots: &Slots, column: &[R]) -> Vec<R::Vec3> {
    slots.places().map(|at| columns::vector(column, at)).collect()
}

const _: () = assert!(LANES == 16, "a mask of springs has sixteen bits");
