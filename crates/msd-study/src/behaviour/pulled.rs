//! Moduli of a solid that is pulled at its surface.
//!
//! A uniform stress σ acts on a closed surface with the force σ A on a triangle of area A, which
//! its corners share. With K the stiffness of the springs, the particles are displaced by u = K⁻¹
//! f. The mean strain in a volume V is (1/V) Σ sym(u ⊗ A). So f_aᵀ u_b / V are the compliances of a
//! body of any form. These moduli are never stiffer than the body, and those of a uniform strain
//! are never softer (Reuss, 1929; Voigt, 1889).

use msd_core::Scene;
use msd_core::glam::{DMat3, DVec3};

/// The part of the load that a solve may leave.
const RESIDUAL: f64 = 1e-6;
/// The most steps of a solve: a body that takes more has parts that hardly hang together.
const MOST_STEPS: usize = 3000;

/// A strain or a stress in the notation of Mandel: xx, yy, zz, and √2 times yz, zx and xy.
type Six = [f64; 6];

/// The compliance of a body, per pascal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pulled([Six; 6]);

impl Pulled {
    /// That of the springs of a scene at rest, of which triangles enclose a volume, cubic metres;
    /// `None` where a solve does not converge.
    pub(super) fn of(scene: &Scene, triangles: &[[usize; 3]], volume: f64) -> Option<Self> {
        let network = Network::new(scene);
        let place = |at: usize| scene.particles[at].position;
        let mut areas = vec![DVec3::ZERO; scene.particles.len()];
        for &corners in triangles {
            let [a, b, c] = corners.map(place);
            let third = (b - a).cross(c - a) / 6.0;
            corners.into_iter().for_each(|at| areas[at] += third);
        }
        let load = |number: usize| -> Vec<DVec3> {
            let stress = unit_stress(number);
            areas.iter().map(|&area| stress * area).collect()
        };
        let loads: Vec<Vec<DVec3>> = (0..6).map(load).collect();
        let mut compliance = [[0.0; 6]; 6];
        for (column, pull) in loads.iter().enumerate() {
            let moved = network.solve(pull)?;
            for (row, other) in loads.iter().enumerate() {
                compliance[row][column] = dot(other, &moved) / volume;
            }
        }
        Some(Pulled(compliance))
    }

    /// Young's modulus along a direction of length 1, pascals.
    pub(super) fn young(&self, DVec3 { x, y, z }: DVec3) -> f64 {
        let root = 2f64.sqrt();
        let pull = [x * x, y * y, z * z, root * y * z, root * z * x, root * x * y];
        let inner = |row: &Six| row.iter().zip(pull).map(|(a, b)| a * b).sum::<f64>();
        1.0 / self.0.iter().zip(pull).map(|(row, b)| inner(row) * b).sum::<f64>()
    }
}

/// A stress of 1 Pa in one of the six.
fn unit_stress(number: usize) -> DMat3 {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    if number < 3 {
        return outer(axes[number], axes[number]);
    }
    let [a, b] = [axes[(number + 1) % 3], axes[(number + 2) % 3]];
    (outer(a, b) + outer(b, a)) * 0.5f64.sqrt()
}

/// The springs as a stiffness: ends, directions and stiffnesses, with its diagonal.
struct Network {
    rows: Vec<([usize; 2], DVec3, f64)>,
    diagonal: Vec<f64>,
}

impl Network {
    fn new(scene: &Scene) -> Self {
        let mut diagonal = vec![0.0; scene.particles.len()];
        let mut rows = Vec::with_capacity(scene.springs.len());
        for spring in &scene.springs {
            let [a, b] = spring.ends.map(|end| scene.particles[end].position);
            let Some(direction) = (b - a).try_normalize() else { continue };
            rows.push((spring.ends, direction, spring.stiffness));
            spring.ends.iter().for_each(|&end| diagonal[end] += spring.stiffness);
        }
        Network { rows, diagonal }
    }

    fn multiply(&self, ways: &[DVec3], products: &mut [DVec3]) {
        products.fill(DVec3::ZERO);
        for &([a, b], direction, stiffness) in &self.rows {
            let pull = direction * (stiffness * direction.dot(ways[b] - ways[a]));
            products[a] -= pull;
            products[b] += pull;
        }
    }

    /// u of K u = f by conjugate gradients with the diagonal: f has neither a sum nor a torque, so
    /// that the motions of the whole, which nothing resists, stay out of it.
    fn solve(&self, load: &[DVec3]) -> Option<Vec<DVec3>> {
        let eased = |rest: &[DVec3]| -> Vec<DVec3> {
            let ease = |(&rest, &k): (&DVec3, &f64)| if 0.0 < k { rest / k } else { DVec3::ZERO };
            rest.iter().zip(&self.diagonal).map(ease).collect()
        };
        let mut moved = vec![DVec3::ZERO; load.len()];
        let (mut rest, mut products) = (load.to_vec(), moved.clone());
        let mut next = eased(&rest);
        let mut way = next.clone();
        let start = dot(&rest, &next);
        let mut square = start;
        for _ in 0..MOST_STEPS {
            if square <= RESIDUAL * RESIDUAL * start {
                return Some(moved);
            }
            self.multiply(&way, &mut products);
            let step = square / dot(&way, &products);
            for (at, &way) in way.iter().enumerate() {
                moved[at] += way * step;
                rest[at] -= products[at] * step;
            }
            next = eased(&rest);
            let before = core::mem::replace(&mut square, dot(&rest, &next));
            way.iter_mut()
                .zip(&next)
                .for_each(|(way, &next)| *way = next + *way * (square / before));
        }
        None
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Elasticity, Substance, shape};

    #[test]
    fn a_block_is_as_stiff_as_its_material_but_for_how_triangles_share_a_load() {
        // Triangles share the load of a square by its diagonal, not in quarters: at the edges that
        // is not a uniform stress. It never makes a body stiffer, and falls with the number of
        // cells.
        let elasticity = Elasticity::Solid { young: 1e4, poisson: 0.25 };
        let substance = Substance { elasticity, density: 1000.0, relaxation_time: 0.0 };
        let off = |count: usize| {
            let part = shape::body([count; 3], 0.1, &substance).expect("a block");
            let scene = Scene::of("block", part);
            let surface = scene.bodies[0].surface.particles();
            let triangles: Vec<_> = surface.map(|all| all.map(|at| at as usize)).collect();
            let volume = (0.1 * (count - 1) as f64).powi(3);
            let pulled = Pulled::of(&scene, &triangles, volume).expect("it hangs together");
            let ways = [DVec3::X, DVec3::Z, DVec3::new(1.0, 1.0, -1.0).normalize()];
            let moduli = ways.map(|way| pulled.young(way) / 1e4);
            // 1e-6 of the residual.
            assert!(moduli.iter().all(|part| *part < 1.0 + 1e-5), "{moduli:?}");
            1.0 - moduli.into_iter().fold(1.0, f64::min)
        };
        let [coarse, fine] = [4, 8].map(off);
        assert!(coarse < 0.1 && fine < 0.6 * coarse, "{coarse} to {fine}");
    }
}
