//! The spectrum: the fastest motions of a system about a state, found without a large matrix.
//!
//! Near a state a system is M x'' + D x' + K x = 0. A few orthonormal vectors are made of products
//! with M^(−1/2) (h²/4 K + h/2 D) M^(−1/2) (Lanczos, 1950). Between them stiffness and damping are
//! small matrices. The fastest motions of the small system are those of the large one, from below:
//! within 0.3 % after 30 vectors, however large a lattice.

use super::dense::{MOST, Matrix};
use crate::elements::{Derivatives, Motion, Products};
use crate::number::Real;
use crate::system::Model;
use alloc::vec::Vec;
use core::mem;
use fearless_simd::Level;
use glam::DVec3;

/// The product with the damping in [`Basis::products`].
const DAMPING: usize = 1;

/// The remainder of a vector without its part in the basis, as a share of it, above which the
/// rounding of a single pass does not matter.
const CANCELLED: f64 = 0.05;

/// The operating point of a prediction: a model about a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OperatingPoint<'a, R: Real> {
    pub(crate) model: &'a Model<R>,
    pub(crate) motion: Motion<'a, R>,
}

impl<R: Real> OperatingPoint<'_, R> {
    fn differentiate(&self, derivatives: &mut Derivatives) {
        let moment = self.model.moment(Level::baseline(), self.motion);
        let kinds = self.model.kinds();
        kinds.for_each(|kind| kind.differentiate(&moment, derivatives));
    }

    /// The derivatives of all kinds of elements.
    pub(super) fn derivatives(&self) -> Derivatives {
        let mut derivatives = Derivatives::default();
        self.differentiate(&mut derivatives);
        derivatives
    }
}

/// A basis of motions, and stiffness and damping between them. Its columns are allocated once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Basis {
    derivatives: Derivatives,
    /// Square roots of the reciprocal masses.
    roots: Vec<f64>,
    vectors: Vec<Vec<DVec3>>,
    /// The last vector times M^(−1/2): the displacement that the elements see.
    displacements: Vec<DVec3>,
    /// Products of the last vector with stiffness and damping.
    products: [Vec<DVec3>; 2],
    next: Vec<DVec3>,
    /// A combination of the vectors.
    motion: Vec<DVec3>,
    /// Stiffness between the vectors, per second squared; its size is their number.
    pub(crate) stiffness: Matrix,
    /// Damping between the vectors, per second.
    pub(crate) damping: Matrix,
}

impl Basis {
    /// Begins anew about the state that it is prepared for with a rough vector, weighted by
    /// particle. A fast motion of a few particles must not be lost among those of all.
    pub(crate) fn begin<R: Real>(&mut self, point: &OperatingPoint<'_, R>, weights: &[f64]) {
        (self.stiffness.size, self.damping.size) = (0, 0);
        self.products.iter_mut().for_each(Vec::clear);
        self.push_rough(point, weights);
    }

    /// Takes the derivatives and the masses of a state.
    pub(super) fn prepare<R: Real>(&mut self, point: &OperatingPoint<'_, R>) {
        point.differentiate(&mut self.derivatives);
        self.roots.clear();
        self.roots.extend(point.model.inverse_masses.iter().map(|w| Real::sqrt(w.to_f64())));
    }

    /// The derivatives of the state that it is prepared for.
    pub(super) fn derivatives(&self) -> &Derivatives {
        &self.derivatives
    }

    /// Square roots of the reciprocal masses.
    pub(super) fn roots(&self) -> &[f64] {
        &self.roots
    }

    /// The products of a vector with M^(−1/2) K M^(−1/2) and M^(−1/2) D M^(−1/2).
    pub(super) fn products_of<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        vector: &[DVec3],
    ) -> &[Vec<DVec3>; 2] {
        self.multiply(point, vector);
        &self.products
    }

    /// Adds a rough vector, weighted by particle.
    pub(crate) fn push_rough<R: Real>(&mut self, point: &OperatingPoint<'_, R>, weights: &[f64]) {
        self.next.clear();
        let rough = Rough(1 + self.stiffness.size as u64).zip(weights);
        self.next.extend(rough.map(|(x, &weight)| x * weight));
        self.push(point);
    }

    /// Adds `count` vectors, of products with `mixture`: factors of the stiffness, the damping and
    /// the square of the damping.
    pub(crate) fn grow<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        mixture: [f64; 3],
        count: usize,
    ) {
        let [k, d, dd] = mixture;
        for _ in 0..count {
            self.next.clear();
            let [stiff, damp] = &self.products;
            let mixed = |(&stiff, &damp): (&DVec3, &DVec3)| stiff * k + damp * d;
            self.next.extend(stiff.iter().zip(damp).map(mixed));
            if dd != 0.0 {
                let damp = mem::take(&mut self.products[DAMPING]);
                self.multiply(point, &damp);
                let rows = self.next.iter_mut().zip(&self.products[DAMPING]);
                rows.for_each(|(sum, &twice)| *sum += twice * dd);
            }
            if self.push(point).is_none() {
                return;
            }
        }
    }

    /// A mixture between the vectors: factors of the stiffness, the damping and its square.
    pub(crate) fn mixture(&self, [k, d, dd]: [f64; 3]) -> Matrix {
        let none = Matrix::zero(self.stiffness.size);
        let squared = if dd == 0.0 { none } else { self.damping.times(&self.damping) };
        let damped = self.damping.scaled_plus(d, &squared.scaled_plus(dd, &none));
        self.stiffness.scaled_plus(k, &damped)
    }

    /// Adds the part of K x + D v that the basis lacks, x and v given in the basis; its length is 0
    /// where there is none.
    pub(crate) fn push_residual<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        x: &[f64],
        v: &[f64],
    ) -> f64 {
        let mut sum = mem::take(&mut self.next);
        let mut motion = mem::take(&mut self.motion);
        for (product, coordinates) in [x, v].into_iter().enumerate() {
            self.combine(coordinates, &mut motion);
            self.multiply(point, &motion);
            if product == 0 {
                sum.clone_from(&self.products[0]);
            } else {
                let rows = sum.iter_mut().zip(&self.products[DAMPING]);
                rows.for_each(|(sum, &value)| *sum += value);
            }
        }
        (self.next, self.motion) = (sum, motion);
        self.push(point).unwrap_or(0.0)
    }

    /// Overwrites `motion` with a combination of the vectors.
    fn combine(&self, coordinates: &[f64], motion: &mut Vec<DVec3>) {
        motion.clear();
        motion.resize(self.roots.len(), DVec3::ZERO);
        for (vector, &coordinate) in self.vectors.iter().zip(coordinates) {
            let rows = motion.iter_mut().zip(vector);
            rows.for_each(|(sum, &value)| *sum += value * coordinate);
        }
    }

    /// The displacements of the particles in a combination of the vectors.
    pub(crate) fn displacements(&self, coordinates: &[f64]) -> Vec<DVec3> {
        let mut motion = Vec::new();
        self.combine(coordinates, &mut motion);
        motion.iter_mut().zip(&self.roots).for_each(|(value, &root)| *value *= root);
        motion
    }

    /// Adds the part of `next` that the basis lacks and returns its length; `None` if there is
    /// nothing left but rounding, or no room.
    fn push<R: Real>(&mut self, point: &OperatingPoint<'_, R>) -> Option<f64> {
        let used = self.stiffness.size;
        let whole = norm(&self.next);
        let mut length = whole;
        // Twice is enough (Kahan, in Parlett, 1980), and once where little cancels.
        for again in [false, true] {
            if again && CANCELLED * whole < length {
                break;
            }
            for vector in &self.vectors[..used] {
                let along = dot(vector, &self.next);
                let rows = self.next.iter_mut().zip(vector);
                rows.for_each(|(value, &vector)| *value -= vector * along);
            }
            length = norm(&self.next);
        }
        let fresh = 1e-10 * whole < length && length.is_finite();
        if !fresh || used == MOST {
            return None;
        }
        if self.vectors.len() == used {
            self.vectors.push(Vec::new());
        }
        let mut vector = mem::take(&mut self.vectors[used]);
        vector.clear();
        vector.extend(self.next.iter().map(|&value| value / length));
        self.multiply(point, &vector);
        self.vectors[used] = vector;
        for (matrix, product) in
            [&mut self.stiffness, &mut self.damping].into_iter().zip(&self.products)
        {
            matrix.size = used + 1;
            let still = product.iter().all(|&value| value == DVec3::ZERO);
            for (row, vector) in self.vectors[..=used].iter().enumerate() {
                let value = if still { 0.0 } else { dot(vector, product) };
                (matrix.rows[row][used], matrix.rows[used][row]) = (value, value);
            }
        }
        Some(length)
    }

    /// Sets the products with M^(−1/2) K M^(−1/2) and M^(−1/2) D M^(−1/2), those of all elements.
    fn multiply<R: Real>(&mut self, point: &OperatingPoint<'_, R>, x: &[DVec3]) {
        let OperatingPoint { model, motion } = point;
        let Basis { derivatives, roots, displacements, products: [stiff, damp], .. } = self;
        displacements.clear();
        displacements.extend(x.iter().zip(&*roots).map(|(&x, &root)| x * root));
        for product in [&mut *stiff, &mut *damp] {
            product.clear();
            product.resize(x.len(), DVec3::ZERO);
        }
        let mut products = Products { stiffness: stiff, damping: damp };
        for kind in model.kinds() {
            kind.add_products((motion, derivatives), displacements, &mut products);
        }
        for product in [stiff, damp] {
            product.iter_mut().zip(&*roots).for_each(|(product, &root)| *product *= root);
        }
    }
}

/// Rough vectors without symmetry: bits of a linear congruential generator (Knuth, 1981).
pub(crate) struct Rough(pub(crate) u64);

impl Iterator for Rough {
    type Item = DVec3;

    fn next(&mut self) -> Option<DVec3> {
        let mut number = || {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        Some(DVec3::new(number(), number(), number()))
    }
}

pub(super) fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

pub(super) fn norm(a: &[DVec3]) -> f64 {
    Real::sqrt(dot(a, a))
}
