//! How does the system answer a small change of velocity? As the matrix of an implicit substep.
//!
//! For a stage of length τ the matrix is A = M − τ ∂f/∂v − τ² ∂f/∂x. It is never written down: it
//! is a coefficient along and one across for each spring, and one for each particle.

use crate::real::{Real, Vector};
use crate::system::{Grab, Model, Motion};
use alloc::vec;
use alloc::vec::Vec;
use glam::DVec3;

/// What a spring adds to the matrix: `across` w + `along` u (u·w) for a relative velocity w, with u
/// the unit vector from one end to the other.
#[derive(Clone, Copy, Debug)]
struct Link<R: Real> {
    direction: R::Vec3,
    /// Weight along the spring beyond that in every direction, kilograms.
    along: R,
    /// Weight in every direction, kilograms.
    across: R,
}

/// The matrix A = M − τ ∂f/∂v − τ² ∂f/∂x about a motion, kilograms.
///
/// A spring at length L and tension t = k (L − rest) + b u·(v_b − v_a) adds, between its ends,
/// (τ² k + τ b) u uᵀ + τ² max(0, t / L) (1 − u uᵀ): the exact derivative but for two things.
///
/// - A spring that pushes is unstable sideways, t < 0, and would make A indefinite; there it adds
///   nothing (Choi and Ko, 2002).
/// - The force of a damper also turns with the spring by b u (w − u (u·w))ᵀ / L, which is not
///   symmetric and is left out.
///
/// Only the matrix is approximate, never the force: what is left out changes a velocity by a term
/// of third order in τ, and Newton iterations remove it. Drag adds its factor times τ. A grab adds
/// τ² k + τ b, but nothing at its largest force, which is taken as constant.
#[derive(Clone, Debug, Default)]
pub struct Tangent<R: Real> {
    links: Vec<Link<R>>,
    /// Mass, drag and grabs of each particle, kilograms.
    diagonals: Vec<R>,
    /// Inverse of the 3x3 block of each particle, columns; zero where the particle is pinned.
    inverses: Vec<[R::Vec3; 3]>,
}

impl<R: Real> Tangent<R> {
    /// Makes room for the matrix of a model.
    pub fn new(model: &Model<R>) -> Self {
        Tangent {
            links: Vec::with_capacity(model.spring_count()),
            diagonals: Vec::with_capacity(model.particle_count()),
            inverses: vec![[R::Vec3::ZERO; 3]; model.particle_count()],
        }
    }

    /// Overwrites the matrix with that about a motion, for a stage of `tau` seconds.
    pub fn linearise(&mut self, model: &Model<R>, motion: Motion<'_, R>, tau: R) {
        self.set_diagonals(model, motion, tau);
        self.links.clear();
        let link = |spring| link(model, spring, motion, tau);
        self.links.extend((0..model.spring_count()).map(link));
        self.invert_blocks(model);
    }

    fn set_diagonals(&mut self, model: &Model<R>, motion: Motion<'_, R>, tau: R) {
        self.diagonals.clear();
        self.diagonals.extend(model.masses.iter().map(|&mass| mass + tau * model.drag));
        for grab in &model.grabs {
            let particle = grab.particle as usize;
            let here = (motion.positions[particle], motion.velocities[particle]);
            self.diagonals[particle] += grab_weight(grab, here, tau);
        }
    }

    fn invert_blocks(&mut self, model: &Model<R>) {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(R::Vec3::of);
        for (block, &diagonal) in self.inverses.iter_mut().zip(&self.diagonals) {
            *block = axes.map(|axis| axis * diagonal);
        }
        for (link, ends) in self.links.iter().zip(&model.ends) {
            let components = link.direction.components();
            let add: [R::Vec3; 3] = core::array::from_fn(|k| {
                link.direction * (link.along * components[k]) + axes[k] * link.across
            });
            for &end in ends {
                for (column, &add) in self.inverses[end as usize].iter_mut().zip(&add) {
                    *column += add;
                }
            }
        }
        for (block, &inverse_mass) in self.inverses.iter_mut().zip(&model.inverse_masses) {
            let pinned = inverse_mass == R::ZERO;
            *block = if pinned { [R::Vec3::ZERO; 3] } else { inverse_block::<R>(*block) };
        }
    }

    /// The inverse of the block of each particle, columns; zero where the particle is pinned.
    pub fn inverses(&self) -> &[[R::Vec3; 3]] {
        &self.inverses
    }

    /// Overwrites `product` with A x.
    pub fn set_product(&self, ends: &[[u32; 2]], x: &[R::Vec3], product: &mut [R::Vec3]) {
        let rows = product.iter_mut().zip(x).zip(&self.diagonals);
        for ((product, &x), &diagonal) in rows {
            *product = x * diagonal;
        }
        let count = x.len();
        let product = &mut product[..count];
        for (link, &[a, b]) in self.links.iter().zip(ends) {
            let (a, b) = (a as usize, b as usize);
            let apart = x[b] - x[a];
            let pull =
                apart * link.across + link.direction * (link.along * link.direction.dot(apart));
            product[a] -= pull;
            product[b] += pull;
        }
    }
}

fn link<R: Real>(model: &Model<R>, spring: usize, motion: Motion<'_, R>, tau: R) -> Link<R> {
    let [a, b] = model.ends[spring].map(|end| end as usize);
    let across = motion.positions[b] - motion.positions[a];
    let squared = across.dot(across);
    if squared < R::SHORTEST_SQUARED {
        // Without direction, without force, as in `forces`.
        return Link { direction: R::Vec3::ZERO, along: R::ZERO, across: R::ZERO };
    }
    let length = squared.sqrt();
    let per_length = R::ONE / length;
    let direction = across * per_length;
    let rate = direction.dot(motion.velocities[b] - motion.velocities[a]);
    let (stiffness, damping) = (model.stiffnesses.get(spring), model.dampings.get(spring));
    let tension = stiffness * (length - model.rest_lengths[spring]) + damping * rate;
    let across = tau * tau * (tension * per_length).max(R::ZERO);
    Link { direction, along: tau * (tau * stiffness + damping) - across, across }
}

/// The inverse of a block by columns.
fn inverse_block<R: Real>(block: [R::Vec3; 3]) -> [R::Vec3; 3] {
    let [a, b, c] = block.map(Vector::to_f64);
    let block = [a.x, a.y, a.z, b.y, b.z, c.z];
    let (found, sound) = inverse::<R>(block);
    let [xx, xy, xz, yy, yz, zz] = if sound { found } else { steady_inverse::<R>(block) };
    let columns = [DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz)];
    columns.map(R::Vec3::of)
}

/// What a grab adds to the matrix for its particle at a motion, kilograms.
pub(crate) fn grab_weight<R: Real>(
    grab: &Grab<R>,
    (position, velocity): (R::Vec3, R::Vec3),
    tau: R,
) -> R {
    let pull = (grab.target - position) * grab.stiffness - velocity * grab.damping;
    if pull.dot(pull) <= grab.max_force * grab.max_force {
        tau * (tau * grab.stiffness + grab.damping)
    } else {
        R::ZERO
    }
}

/// The inverse of a symmetric positive matrix by cofactors, and whether it is sound: the numbers
/// xx, xy, xz, yy, yz and zz of both. Where it is not, there is [`steady_inverse`].
///
/// In double precision: a stiff spring and a light particle differ by more than 2^24.
#[inline(always)]
pub(crate) fn inverse<R: Real>(block: [f64; 6]) -> ([f64; 6], bool) {
    let scale = 1.0 / (block[0] + block[3] + block[5]);
    let (found, determinant) = cofactors(block.map(|number| number * scale));
    // About the smallest eigenvalue: the determinant over the sum of products of two.
    let minors = found[0] + found[3] + found[5];
    let rounding = rounding::<R>();
    let sound = (rounding * minors < determinant) & (rounding < minors);
    let factor = scale / determinant;
    (found.map(|cofactor| cofactor * factor), sound)
}

/// The inverse of a matrix that rounding left without one, or with one that is not positive, which
/// would end a solve before it begins: a mass was rounded away beside a stiff spring.
///
/// So much is added to the diagonal that rounding cannot matter: an inverse only steers the solve.
pub(crate) fn steady_inverse<R: Real>(block: [f64; 6]) -> [f64; 6] {
    let scale = 1.0 / (block[0] + block[3] + block[5]);
    let mut block = block.map(|number| number * scale);
    [0, 3, 5].into_iter().for_each(|number| block[number] += rounding::<R>());
    let (found, determinant) = cofactors(block);
    found.map(|cofactor| cofactor * (scale / determinant))
}

/// What rounding may leave of an eigenvalue, as a fraction of the trace.
fn rounding<R: Real>() -> f64 {
    8.0 * R::EPSILON.to_f64()
}

/// The cofactors of a symmetric matrix, and its determinant.
#[inline(always)]
fn cofactors([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> ([f64; 6], f64) {
    let (a, b, c) = (yy * zz - yz * yz, yz * xz - xy * zz, xy * yz - yy * xz);
    let (d, e, f) = (zz * xx - xz * xz, xz * xy - yz * xx, xx * yy - xy * xy);
    ([a, b, c, d, e, f], xx * a + xy * b + xz * c)
}
