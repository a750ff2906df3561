//! Derivatives of the forces of touches, for the implicit methods and for the spectrum.

use crate::columns::{add_vector, vector};
use crate::elements::Products;
use crate::number::{Real, Vector};
use alloc::vec::Vec;
use glam::DVec3;

/// The derivative of the force of a touch of N particles.
///
/// With u = Σ wᵢ uᵢ the motion of the side that is pushed along the normal as seen from the other,
/// a small displacement u changes its force by k n (n·u) − k δ/L (u − n (n·u)), and a small
/// velocity by c n (n·u) + g (u − n (n·u)), with g that of the friction as it is. Where the two
/// part so fast that they do not push, by neither.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touching<const N: usize> {
    pub(super) particles: [usize; N],
    /// Where the numbers of each are in a column of vectors.
    pub(super) at: [usize; N],
    pub(super) weights: [f64; N],
    pub(super) normal: DVec3,
    /// A direction across the normal in which the point of contact slides along, so that it turns
    /// nothing: of length one, or zero where there is none.
    pub(super) slide: DVec3,
    pub(super) along: f64,
    pub(super) across: f64,
    pub(super) damping: f64,
    pub(super) grip: f64,
}

impl<const N: usize> Touching<N> {
    /// The products of stiffness and damping with the motion of one side as seen from the other.
    fn both_products(&self, motion: DVec3) -> [DVec3; 2] {
        let along = self.normal * self.normal.dot(motion);
        let across = motion - along;
        let turning = across - self.slide * self.slide.dot(across);
        [along * self.along + turning * self.across, along * self.damping + across * self.grip]
    }

    /// The product of τ (τ k + b) with that motion, without what buckles: the push across the
    /// normal.
    fn product(&self, tau: f64, motion: DVec3) -> DVec3 {
        let along = self.normal * self.normal.dot(motion);
        along * (tau * (tau * self.along + self.damping)) + (motion - along) * (tau * self.grip)
    }

    fn add_column_product<R: Real>(&self, tau: R, direction: &[R], products: &mut [R]) {
        let mut motion = R::Vec3::ZERO;
        for (at, weight) in self.at.into_iter().zip(self.weights) {
            motion += vector::<R>(direction, at) * R::of(weight);
        }
        let product = R::Vec3::of(self.product(tau.to_f64(), motion.to_f64()));
        for (at, weight) in self.at.into_iter().zip(self.weights) {
            add_vector::<R>(products, at, product * R::of(weight));
        }
    }

    fn add_blocks<R: Real>(&self, tau: R, [upper, lower]: &mut [&mut [R]; 2]) {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|d| self.product(tau.to_f64(), d));
        for (at, weight) in self.at.into_iter().zip(self.weights) {
            for (column, numbers) in [(&mut **upper, x), (&mut **lower, DVec3::new(y.y, y.z, z.z))]
            {
                add_vector::<R>(column, at, R::Vec3::of(numbers * (weight * weight)));
            }
        }
    }

    fn add_products(&self, displacements: &[DVec3], products: &mut Products<'_>) {
        let rows = self.particles.into_iter().zip(self.weights);
        let motion = rows.clone().map(|(particle, weight)| displacements[particle] * weight).sum();
        let both = self.both_products(motion);
        rows.for_each(|(particle, weight)| products.add(particle, both.map(|by| by * weight)));
    }

    fn add_row_sums(&self, sums: &mut [[f64; 2]]) {
        let largest = [self.along.max(-self.across), self.damping.max(self.grip)];
        // Those of the other side move against it: all weights count.
        let all: f64 = self.weights.iter().map(|weight| weight.abs()).sum();
        for (particle, weight) in self.particles.into_iter().zip(self.weights) {
            let sums = sums[particle].iter_mut().zip(largest);
            sums.for_each(|(sum, value)| *sum += value * all * weight.abs());
        }
    }
}

/// The derivatives of all that touches.
#[derive(Clone, Debug, Default)]
pub(crate) struct TouchTangents {
    pub(super) pairs: Vec<Touching<2>>,
    pub(super) faces: Vec<Touching<4>>,
}

impl TouchTangents {
    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        self.faces.clear();
    }

    /// Adds the products of τ (τ k + b) with a direction in columns, without what buckles.
    pub(crate) fn add_column_products<R: Real>(&self, tau: R, direction: &[R], products: &mut [R]) {
        let (pairs, faces) = (self.pairs.iter(), self.faces.iter());
        pairs.for_each(|touching| touching.add_column_product(tau, direction, products));
        faces.for_each(|touching| touching.add_column_product(tau, direction, products));
    }

    /// Adds the diagonal blocks of those products to those of particles.
    pub(crate) fn add_blocks<R: Real>(&self, tau: R, blocks: &mut [&mut [R]; 2]) {
        self.pairs.iter().for_each(|touching| touching.add_blocks(tau, blocks));
        self.faces.iter().for_each(|touching| touching.add_blocks(tau, blocks));
    }

    /// Adds the products of stiffness and damping with a displacement of each particle.
    pub(crate) fn add_products(&self, displacements: &[DVec3], products: &mut Products<'_>) {
        self.pairs.iter().for_each(|touching| touching.add_products(displacements, products));
        self.faces.iter().for_each(|touching| touching.add_products(displacements, products));
    }

    /// Adds the largest row sums of stiffness and damping of each particle.
    pub(crate) fn add_row_sums(&self, sums: &mut [[f64; 2]]) {
        self.pairs.iter().for_each(|touching| touching.add_row_sums(sums));
        self.faces.iter().for_each(|touching| touching.add_row_sums(sums));
    }
}
