//! The moduli of a network of springs and volumes, as if it were a uniform material.

use crate::number::Real;
use crate::scene::Volume;
use crate::stability::Matrix;
use glam::DVec3;

/// A strain or a stress as a vector of six, in the notation of Mandel: xx, yy, zz, and √2 times yz,
/// zx and xy, so that a product of tensors is a product of vectors.
type Six = [f64; 6];

/// A stiffness below this fraction of the largest counts as zero: it is rounding.
const NONE: f64 = 1e-12;

/// The elasticity of a network of springs and volumes that is strained uniformly.
///
/// C_ijkl = (1/V) (Σ k L² n_i n_j n_k n_l + Σ Λ V0 δ_ij δ_kl) over springs of stiffness k, length L
/// and direction n and over volumes of modulus Λ and size V0, in a volume V. For a sheet it is per
/// area and for a rope per length: their moduli are then in newtons per metre and in newtons. Exact
/// for a uniform lattice; of any other an upper bound, as particles that were free to move from a
/// uniform strain would take some of the stress away (Voigt, 1889).
#[derive(Clone, Copy, Debug)]
pub struct Moduli {
    /// The strain for a stress; strains that no spring resists are left out.
    compliance: [Six; 6],
    /// The strains that no spring resists, as a projection.
    free: [Six; 6],
}

impl Moduli {
    /// The moduli of springs, each a stiffness in newtons per metre and a vector from end to end,
    /// and of volumes that fill a volume, an area or a length.
    pub fn of<'v>(
        springs: impl Iterator<Item = (f64, DVec3)>,
        volumes: impl IntoIterator<Item = &'v Volume>,
        filled: f64,
    ) -> Self {
        let mut stiffness = Matrix::zero(6);
        let held: f64 = volumes.into_iter().map(|row| row.modulus * row.rest_volume).sum();
        for row in stiffness.rows.iter_mut().take(3) {
            row.iter_mut().take(3).for_each(|sum| *sum += held / filled);
        }
        for (k, across) in springs {
            let six = squared(across);
            // Of springs without a length nothing is known.
            let squared_length = across.dot(across);
            if squared_length == 0.0 {
                continue;
            }
            for (row, a) in stiffness.rows.iter_mut().zip(six) {
                for (sum, b) in row.iter_mut().zip(six) {
                    *sum += k / filled * (a * b / squared_length);
                }
            }
        }
        let (values, vectors) = stiffness.eigen();
        let (mut compliance, mut free) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
        for (&value, vector) in values.iter().zip(&vectors.rows).take(6) {
            let is_free = value <= NONE * values[0];
            let (sums, factor) =
                if is_free { (&mut free, 1.0) } else { (&mut compliance, 1.0 / value) };
            for (row, a) in sums.iter_mut().zip(vector) {
                row.iter_mut().zip(vector).for_each(|(sum, b)| *sum += factor * a * b);
            }
        }
        Moduli { compliance, free }
    }

    /// Young's modulus along a direction of length 1; 0 where nothing resists a pull.
    pub fn young(&self, direction: DVec3) -> f64 {
        let stretch = dot(squared(direction), self.strain(direction));
        if self.gives_way(direction) { 0.0 } else { 1.0 / stretch }
    }

    /// Poisson's ratio for a pull along one direction: by how much a transverse one, both of length
    /// 1, narrows; 0 where nothing resists the pull.
    pub fn poisson(&self, direction: DVec3, transverse: DVec3) -> f64 {
        let strain = self.strain(direction);
        let [along, across] = [direction, transverse].map(|way| dot(squared(way), strain));
        if self.gives_way(direction) { 0.0 } else { -across / along }
    }

    /// The strain for a pull of 1 along a direction.
    fn strain(&self, direction: DVec3) -> Six {
        let pull = squared(direction);
        self.compliance.map(|row| dot(row, pull))
    }

    /// Whether a pull along a direction has a part that no spring resists.
    fn gives_way(&self, direction: DVec3) -> bool {
        let pull = squared(direction);
        // Far above rounding, and below any lattice that is askew to the direction.
        1e-9 < dot(pull, self.free.map(|row| dot(row, pull)))
    }
}

/// The tensor product of a vector with itself.
fn squared(vector: DVec3) -> Six {
    let DVec3 { x, y, z } = vector;
    let root = Real::sqrt(2.0);
    [x * x, y * y, z * z, root * y * z, root * z * x, root * x * y]
}

fn dot(a: Six, b: Six) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
