//! Elements: the forces on particles, one type for each kind.
//!
//! Springs are an element, and so are the fields, grabs and pushes; a caller may add their own. An
//! [`Element`] adds its forces at a motion, returns the power that it dissipates, and knows its
//! energy. It also multiplies a direction by its stiffness and its damping, as the implicit methods
//! and the prediction of the stable step require.
//!
//! From the inside a kind of element is a `Force`: the methods that all stages of a run call. The
//! kinds of a [`Model`](crate::Model) are listed there once, and callers go through that list.

pub mod fields;
pub mod grabs;
pub mod springs;
mod stencils;
pub mod bends;
pub mod volumes;
pub mod air;

use crate::columns::slots::Slots;
use crate::columns::{self, Aligned, LANES, RECORD};
use crate::number::{Real, Vector, of_type};
use crate::scene::Scene;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt::Debug;
use core::ops::Range;
use fearless_simd::Level;
use glam::DVec3;
use springs::law::Tangent;
use springs::matrix::SpringMatrix;
use springs::project::Batches;
use springs::{SpringWork, Springs};

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
    /// Energy that [`Element::energy`] accounts for is not dissipated. A force without an energy
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

/// A kind of element as the stages of a run see it.
///
/// Few kinds need all of this. The [`Element`] of a kind does whatever the kind does not do itself.
/// A kind that has nothing to do in a stage has no method for it.
pub(crate) trait Force<R: Real>: Debug {
    /// The kind as an element; `None` where that would do nothing, or cannot.
    fn element(&self) -> Option<&dyn Element<R>>;

    /// The number of its rows.
    fn count(&self) -> usize;

    /// Whether its forces may depend on velocity.
    fn is_damped(&self) -> bool {
        0 < self.count()
    }

    /// Adds its forces in columns, newtons, and returns the power that they dissipate, watts.
    fn add_forces(&self, moment: &Moment<'_, R>, _: &mut ForceWork<R>, forces: &mut [R]) -> f64 {
        let motion = &moment.motion;
        let mut forces = Vectors { slots: motion.slots, numbers: forces };
        self.element().map_or(0.0, |element| element.add_forces(motion, &mut forces))
    }

    /// The elastic energy, joules, and the sums of the magnitudes of pulls and of stiffnesses, by
    /// which rounding changes it.
    fn energy_and_pulls(&self, _: &Moment<'_, R>) -> [f64; 3] {
        [0.0; 3]
    }

    /// Takes the derivatives about a motion that the next two ask for many times.
    fn differentiate(&self, _: &Moment<'_, R>, _: &mut Derivatives) {}

    /// Adds the products of its stiffness and damping with a displacement of each particle.
    fn add_products(
        &self,
        (motion, _): (&Motion<'_, R>, &Derivatives),
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        if let Some(element) = self.element() {
            element.add_products(motion, direction, products);
        }
    }

    /// Adds the stiffness and the damping that each particle meets at most about a motion: row sums
    /// of magnitudes of its matrices.
    fn add_row_sums(&self, _: &Motion<'_, R>, _: &Derivatives, _: &mut [[f64; 2]]) {}

    /// Adds τ (τ k + b) where that is a factor for each particle alone, three times each.
    fn add_diagonals(&self, _: &Stage<'_, R>, _: &mut [R]) {}

    /// Takes its matrix about a stage, τ (τ K + D), and adds the blocks of its diagonal.
    fn linearise(&self, _: &Stage<'_, R>, _: &mut MatrixSums<'_, R>) {}

    /// Adds the products of that matrix with a direction.
    fn multiply(&self, _: &Stage<'_, R>, _: &mut ColumnProducts<'_, R>) {}

    /// Moves the particles of each of its rows, in order or backwards, as XPBD does.
    fn project(&self, _: &mut Projection<'_, R>) {}

    /// The count of multipliers that its rows keep from one sweep of XPBD to the next.
    fn multiplier_count(&self, _: &Batches<R>) -> usize {
        0
    }

    /// Hands out pairs of particles by which those hang together that its rows join.
    fn each_pair(&self, _: &mut dyn FnMut([u32; 2])) {}

    /// Takes over its rows of a scene, beside those that it has, and puts all in order anew.
    fn add(&mut self, _: &Scene, _: &Slots) {}

    /// Adds its current rows to a scene.
    fn write(&self, _: &mut Scene) {}

    /// Removes the rows across springs that were cut.
    fn tear(&mut self, _: &Torn) {}

    /// Removes the rows of particles that were removed.
    fn remove(&mut self, _: &dyn Fn(u32) -> bool) {}

    /// Changes stiffness and damping of the rows of some bodies.
    fn change(&mut self, _: &Rows, _: &dyn Fn(Resists, [R; 2]) -> [R; 2]) {}
}

/// The particles and the springs of some bodies.
pub(crate) type Rows = (Range<usize>, Range<usize>);

/// The deformation that a row resists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Resists {
    /// Of length or volume.
    Stretching,
    /// Of curvature.
    Bending,
}

/// A motion about which forces are asked for, and the other inputs of their laws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment<'a, R> {
    pub(crate) level: Level,
    pub(crate) motion: Motion<'a, R>,
}

/// A stage of an implicit method: the motion about which its matrix is taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<'a, R> {
    pub(crate) moment: Moment<'a, R>,
    /// Length, seconds.
    pub(crate) tau: R,
}

/// A substep of XPBD: the columns that its projections move.
pub(crate) struct Projection<'a, R: Real> {
    pub(crate) level: Level,
    /// Length, seconds.
    pub(crate) h: R,
    pub(crate) batches: &'a mut Batches<R>,
    /// Reciprocal masses, in columns as all of the following.
    pub(crate) inverse_masses: &'a [R],
    /// Positions at the start, metres.
    pub(crate) positions: &'a [R],
    /// The displacements as projected so far, metres.
    pub(crate) ways: &'a mut [R],
    /// Multipliers that the rows of each kind have applied so far in the substep, N s²: of no
    /// meaning the first time.
    pub(crate) multipliers: &'a mut [R],
    /// The first multiplier of the kind that is projected.
    pub(crate) first: usize,
    /// Whether rows are projected backwards, the second time.
    pub(crate) is_back: bool,
    /// Whether springs are the only kind that has rows.
    pub(crate) has_springs_alone: bool,
}

/// Scratch of an evaluation of all forces.
#[derive(Clone, Debug)]
pub(crate) struct ForceWork<R: Real> {
    pub(crate) springs: SpringWork<R>,
    /// The power that user-defined elements dissipated at the last evaluation, watts.
    pub(crate) own_power: f64,
}

impl<R: Real> ForceWork<R> {
    pub(crate) fn new(springs: &Springs<R>, slots: &Slots) -> Self {
        ForceWork { springs: SpringWork::new(springs, slots), own_power: 0.0 }
    }
}

/// The outputs of a linearisation.
pub(crate) struct MatrixSums<'a, R: Real> {
    pub(crate) springs: &'a mut SpringMatrix<R>,
    /// The blocks of particles: xx, xy and xz in one column, yy, yz and zz in another.
    pub(crate) blocks: [&'a mut [R]; 2],
}

/// Products of a matrix with a direction, in columns.
pub(crate) struct ColumnProducts<'a, R: Real> {
    pub(crate) springs: &'a mut SpringMatrix<R>,
    pub(crate) direction: &'a [R],
    pub(crate) products: &'a mut [R],
}

/// Derivatives about a motion, of the kinds that keep them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Derivatives {
    /// Of the springs that are not cut.
    springs: Vec<Tangent<f64>>,
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
    fn of<R: Real>(&self) -> &dyn Element<R> {
        &**of_type::<Arc<dyn Element<R>>>(&self.single, &self.double)
    }
}

/// The user-defined elements of a model, each with its handle: one element as which they all act.
#[derive(Clone, Debug, Default)]
pub(crate) struct Owns(pub(crate) Vec<(usize, Own)>);

impl Owns {
    fn each<R: Real>(&self) -> impl Iterator<Item = &dyn Element<R>> {
        self.0.iter().map(|(_, own)| own.of::<R>())
    }
}

impl<R: Real> Element<R> for Owns {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        self.each::<R>().map(|own| own.add_forces(motion, forces)).sum()
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        self.each::<R>().map(|own| own.energy(motion)).sum()
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        self.each::<R>().for_each(|own| own.add_products(motion, direction, products));
    }

    fn add_blocks(&self, motion: &Motion<'_, R>, blocks: &mut Blocks<'_>) {
        self.each::<R>().for_each(|own| own.add_blocks(motion, blocks));
    }
}

impl<R: Real> Force<R> for Owns {
    fn element(&self) -> Option<&dyn Element<R>> {
        (!self.0.is_empty()).then_some(self)
    }

    fn count(&self) -> usize {
        self.0.len()
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
    let mut vectors = Vec::new();
    slots.collect(&mut vectors, |at| columns::vector::<R>(column, at));
    vectors
}

const _: () = assert!(LANES == 16, "a mask of springs has sixteen bits");
