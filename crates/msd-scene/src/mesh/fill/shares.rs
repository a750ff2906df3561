//! The part of the volume of a solid that each of its springs stands for.
//!
//! A spring of length L that stands for a volume v of a solid of Young's modulus E is of the
//! stiffness k = 6 E v/L². Where the directions n of springs are spread evenly, the mean of
//! n_i n_j n_k n_l is (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk)/15, so that the elasticity
//! (1/V) Σ k L² n_i n_j n_k n_l is that of a solid whose Poisson's ratio is 1/4. A lattice of a
//! material has these stiffnesses: its springs along axes and diagonals of faces stand for 8/90 of
//! a cell each, those along diagonals of cells for 1/20.
//!
//! In a uniform strain ε a spring pulls by k L (n·ε·n) n. With A the area of the surface that a
//! particle stands for, outward and none inside, its springs balance the stress of the solid for
//! every ε if
//!
//! Σ v/L n_i n_j n_k + (A_i δ_jk + A_j δ_ki + A_k δ_ij)/15 = 0,
//!
//! n going away from it. This is the patch test. A lattice passes it. Of springs from there to an
//! unstructured surface, the volumes that come nearest to passing it are sought: least squares, one
//! spring after the other (Gauss and Seidel), none below a tenth of an even share. A particle
//! stands for half of each of its springs.

use glam::DVec3;

/// A symmetric tensor of third rank by its different parts: xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx,
/// zzy, xyz.
type Ten = [f64; 10];

/// The number of times that each of them stands in the tensor.
const TIMES: Ten = [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 6.0];
/// Rounds over all springs; three times as many change Young's modulus by less than a hundredth.
const ROUNDS: usize = 200;
/// The least volume of a spring, as a part of an even share: no particle loses its hold.
const LEAST: f64 = 0.1;

/// The shares of the volume that the springs of a solid stand for.
pub(crate) struct Shares {
    /// The volume of each spring, cubic metres; they add up to that of the solid.
    pub(crate) volumes: Vec<f64>,
    /// The root mean square of the forces that are left over in a uniform strain, as a part of
    /// those on the surface.
    pub(crate) unbalanced: f64,
}

/// Shares a volume among springs; those from `lattice.0` on, as many as it has volumes, begin with
/// those volumes. `areas` are those of the surface, by particle.
pub(crate) fn share(
    points: &[DVec3],
    springs: &[[usize; 2]],
    areas: &[DVec3],
    (lattice, volume): (&[f64], f64),
    first: usize,
) -> Shares {
    let even = (volume - lattice.iter().sum::<f64>()).max(0.1 * volume)
        / (springs.len() - lattice.len()).max(1) as f64;
    let of_lattice = |row: usize| row.checked_sub(first).and_then(|row| lattice.get(row).copied());
    let mut volumes: Vec<f64> =
        (0..springs.len()).map(|row| of_lattice(row).unwrap_or(even)).collect();
    let pulls: Vec<Ten> = springs.iter().map(|&[a, b]| pull(points[b] - points[a])).collect();
    let mut left: Vec<Ten> = areas.iter().map(|&area| pressed(area)).collect();
    let on_surface = size(&left);
    for ((&ends, pull), &volume) in springs.iter().zip(&pulls).zip(&volumes) {
        add(&mut left, ends, (pull, volume));
    }
    for _ in 0..ROUNDS {
        for ((&[a, b], pull), volume) in springs.iter().zip(&pulls).zip(&mut volumes) {
            let parts = || pull.iter().zip(TIMES);
            let apart = left[a].iter().zip(&left[b]).map(|(a, b)| a - b);
            let slope: f64 =
                parts().zip(apart).map(|((pull, times), off)| times * pull * off).sum();
            let square: f64 = parts().map(|(pull, times)| times * pull * pull).sum();
            let better = (*volume - slope / (2.0 * square)).max(LEAST * even);
            add(&mut left, [a, b], (pull, better - *volume));
            *volume = better;
        }
    }
    let scale = volume / volumes.iter().sum::<f64>();
    volumes.iter_mut().for_each(|volume| *volume *= scale);
    Shares { volumes, unbalanced: size(&left) / on_surface }
}

/// The volumes of particles: half of each of their springs.
pub(crate) fn of_particles(count: usize, springs: &[[usize; 2]], volumes: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for (ends, volume) in springs.iter().zip(volumes) {
        ends.iter().for_each(|&end| sums[end] += 0.5 * volume);
    }
    sums
}

/// The area that each vertex stands for, a third of that of its triangles, outward.
pub(crate) fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut areas = vec![DVec3::ZERO; points.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let third = (b - a).cross(c - a) / 6.0;
        corners.iter().for_each(|&corner| areas[corner as usize] += third);
    }
    areas
}

/// n_i n_j n_k/L of a spring.
fn pull(across: DVec3) -> Ten {
    let length = across.length();
    let DVec3 { x, y, z } = across / length;
    let cubes = [x * x * x, y * y * y, z * z * z];
    let [xx, yy, zz] = [x * x, y * y, z * z];
    let mixed = [xx * y, xx * z, yy * x, yy * z, zz * x, zz * y, x * y * z];
    let mut all = [0.0; 10];
    all[..3].copy_from_slice(&cubes);
    all[3..].copy_from_slice(&mixed);
    all.map(|part| part / length)
}

/// (A_i δ_jk + A_j δ_ki + A_k δ_ij)/15.
fn pressed(area: DVec3) -> Ten {
    let DVec3 { x, y, z } = area / 15.0;
    [3.0 * x, 3.0 * y, 3.0 * z, y, z, x, z, x, y, 0.0]
}

/// Adds a volume of a spring to the remainders at its ends.
fn add(left: &mut [Ten], [a, b]: [usize; 2], (pull, volume): (&Ten, f64)) {
    for part in 0..pull.len() {
        left[a][part] += volume * pull[part];
        left[b][part] -= volume * pull[part];
    }
}

fn size(left: &[Ten]) -> f64 {
    let squares = left.iter().flat_map(|ten| ten.iter().zip(TIMES));
    squares.map(|(part, times)| times * part * part).sum::<f64>().sqrt()
}
