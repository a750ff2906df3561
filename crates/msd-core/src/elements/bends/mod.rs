//! Bends: stencils of particles that resist bending.
//!
//! [`Bend`] is the law of one. Those that are curved at rest have a law of their own, in
//! `curved.rs`, and are always evaluated one by one.

mod curved;

use super::stencils::{Group, Stencil, StencilLaw, StencilSums, Stencils};
use super::{Motion, Products, Projection, Resists};
use crate::columns::add_vector;
use crate::number::{Real, Vector};
use crate::pack::{self, Number, each};
use crate::scene::{Bend, Scene};
use alloc::vec::Vec;
use core::array::from_fn;
use curved::Curved;
use glam::DVec3;

/// The bends of a model.
pub type Bends<R> = Stencils<R, BendLaw<R>, 4>;

/// The law of a bend.
#[derive(Clone, Copy, Debug)]
pub struct BendLaw<R> {
    weights: [R; 4],
    /// The tangent at rest; 0 for one that is straight.
    rest: R,
    stiffness: R,
    damping: R,
}

/// A bend, and M of them at once.
type Row<R> = Stencil<BendLaw<R>, 4>;
type BendGroup<R, const M: usize> = Group<R, BendLaw<R>, 4, M>;
/// Vectors of some bends, by component.
type Triple<R, const M: usize> = [[R; M]; 3];

impl<R: Real> Bends<R> {
    /// The bends as rows of a scene, in the order in which they are evaluated.
    pub fn rows(&self) -> impl Iterator<Item = Bend> + '_ {
        self.all.iter().map(to_scene)
    }
}

fn to_scene<R: Real>(row: &Row<R>) -> Bend {
    Bend {
        particles: from_fn(|end| row.particle(end)),
        weights: row.law.weights.map(R::to_f64),
        rest: row.law.rest.to_f64(),
        stiffness: row.law.stiffness.to_f64(),
        damping: row.law.damping.to_f64(),
    }
}

impl<R: Real> BendLaw<R> {
    /// The weighted sum of the vectors that a function gives for its particles, 0 to 3.
    ///
    /// Of differences: positions far from the origin would leave their rounding.
    fn sum(&self, of: impl Fn(usize) -> R::Vec3) -> R::Vec3 {
        let first = of(0);
        let mut sum = R::Vec3::ZERO;
        for end in (1..4).filter(|&end| self.weights[end] != R::ZERO) {
            sum += (of(end) - first) * self.weights[end];
        }
        sum
    }

    /// The same law in double precision.
    fn to_f64(self) -> BendLaw<f64> {
        BendLaw {
            weights: self.weights.map(R::to_f64),
            rest: self.rest.to_f64(),
            stiffness: self.stiffness.to_f64(),
            damping: self.damping.to_f64(),
        }
    }

    /// Its current shape, by positions, if it is curved at rest.
    #[inline(always)]
    fn curved(&self, of: impl Fn(usize) -> R::Vec3) -> Option<Curved<R>> {
        (self.rest != R::ZERO).then(|| Curved::new(self.weights, self.rest, of))
    }

    /// The particles that take part, each with its weight.
    fn terms(self) -> impl Iterator<Item = (usize, R)> {
        let takes_part = move |&(end, _): &(usize, R)| self.takes_part(end);
        self.weights.into_iter().enumerate().filter(takes_part)
    }
}

impl<R: Real, const M: usize> BendGroup<R, M> {
    /// The weighted sums of a column.
    #[inline(always)]
    fn sums(&self, column: &[R]) -> Triple<R, M> {
        let mut all = [[R::ZERO; M]; 3];
        for (axis, sums) in all.iter_mut().enumerate() {
            let first = self.numbers(column, 0, axis);
            for end in (1..4).filter(|&end| self.law.weights[end] != R::ZERO) {
                let (other, weight) = (self.numbers(column, end, axis), self.law.weights[end]);
                for lane in 0..M {
                    sums[lane] += (other[lane] - first[lane]) * weight;
                }
            }
        }
        all
    }

    /// First edges.
    #[inline(always)]
    fn edges(&self, column: &[R]) -> Triple<R, M> {
        let mut edges = [[R::ZERO; M]; 3];
        for (axis, edges) in edges.iter_mut().enumerate() {
            let (first, second) = (self.numbers(column, 0, axis), self.numbers(column, 1, axis));
            for lane in 0..M {
                edges[lane] = second[lane] - first[lane];
            }
        }
        edges
    }

    /// Subtracts pulls, each times the weights, from the sums.
    #[inline(always)]
    fn subtract_pulls(&self, pulls: &Triple<R, M>, sums: &mut [R]) {
        for (axis, pulls) in pulls.iter().enumerate() {
            for end in (0..4).filter(|&end| self.law.weights[end] != R::ZERO) {
                let weight = self.law.weights[end];
                self.subtract((end, axis), |lane| pulls[lane] * weight, sums);
            }
        }
    }

    /// Subtracts the parts of the particles of one that is curved.
    #[inline(always)]
    fn subtract_parts(&self, parts: [R::Vec3; 4], sums: &mut [R]) {
        for (end, part) in parts.map(R::Vec3::components).into_iter().enumerate() {
            (0..3).for_each(|axis| self.subtract((end, axis), |_| part[axis], sums));
        }
    }

    /// Gᵀ k d + p b (p·v) of one that is curved; returns the power of its damper.
    #[inline(always)]
    fn pull_curved(&self, curved: &Curved<R>, v: &[R], forces: &mut [R]) -> R {
        let elastic = curved.parts(curved.off * self.law.stiffness);
        if self.law.damping == R::ZERO {
            self.subtract_parts(elastic, forces);
            return R::ZERO;
        }
        let along = curved.gradient();
        let rate = dot_parts::<R>(&along, self.first(v));
        let drag = rate * self.law.damping;
        self.subtract_parts(from_fn(|end| elastic[end] + along[end] * drag), forces);
        rate * drag
    }

    /// The products of τ (τ k + b ŝ ŝᵀ) with sums, bent by `bent`; see [`is_straight`].
    #[inline(always)]
    fn products(
        &self,
        (tau, is_damped): (R, bool),
        [bent, edges]: [&Triple<R, M>; 2],
        of: &Triple<R, M>,
    ) -> Triple<R, M> {
        let [stiffnesses, dampings] = &self.constants;
        let mut pulls = *of;
        for pulls in &mut pulls {
            for lane in 0..M {
                pulls[lane] *= tau * tau * stiffnesses[lane];
            }
        }
        if !is_damped {
            return pulls;
        }
        let (squares, lengths, alongs) = (dots(bent, bent), dots(edges, edges), dots(bent, of));
        for lane in 0..M {
            let damping = tau * dampings[lane];
            let straight = is_straight::<R>(squares[lane], lengths[lane]);
            let along = damping * alongs[lane] * (R::ONE / squares[lane]);
            for axis in 0..3 {
                let (all, one) = (of[axis][lane] * damping, bent[axis][lane] * along);
                pulls[axis][lane] += if straight { all } else { one };
            }
        }
        pulls
    }
}

impl<R: Real> StencilLaw<R, 4> for BendLaw<R> {
    const RESISTS: Resists = Resists::Bending;

    fn rows(scene: &Scene) -> Vec<Row<R>> {
        let law = |bend: &Bend| BendLaw {
            weights: bend.weights.map(R::of),
            rest: R::of(bend.rest),
            stiffness: R::of(bend.stiffness),
            damping: R::of(bend.damping),
        };
        scene.bends.iter().map(|bend| Stencil::new(bend.particles, law(bend))).collect()
    }

    fn write(row: &Row<R>, scene: &mut Scene) {
        scene.bends.push(to_scene(row));
    }

    fn constants(&mut self) -> [&mut R; 2] {
        [&mut self.stiffness, &mut self.damping]
    }

    fn is_alike(&self, other: &Self) -> bool {
        self.weights == other.weights && self.rest == R::ZERO && other.rest == R::ZERO
    }

    fn takes_part(&self, end: usize) -> bool {
        self.weights[end] != R::ZERO || self.rest != R::ZERO
    }

    /// The fast twin of [`pull`], for bends side by side.
    #[inline(always)]
    fn pull<const M: usize>(group: &BendGroup<R, M>, to: &mut StencilSums<'_, R>) -> [R; M] {
        let StencilSums { positions: x, ways: v, is_damped, sums: forces } = to;
        if let Some(curved) = group.law.curved(group.first(x)) {
            return [group.pull_curved(&curved, v, forces); M];
        }
        let sums = group.sums(x);
        let ([mut factors, dampings], mut powers) = (group.constants, [R::ZERO; M]);
        if *is_damped {
            let rates = group.sums(v);
            let (squares, alongs) = (dots(&sums, &sums), dots(&sums, &rates));
            for lane in 0..M {
                let drag = alongs[lane] * dampings[lane] * (R::ONE / squares[lane]);
                // A select: without a direction the quotient is NaN.
                let drag = if R::SHORTEST_SQUARED <= squares[lane] { drag } else { R::ZERO };
                factors[lane] += drag;
                powers[lane] = alongs[lane] * drag;
            }
        }
        let mut pulls = sums;
        pulls.iter_mut().for_each(|pulls| multiply(pulls, &factors));
        group.subtract_pulls(&pulls, forces);
        powers
    }

    #[inline(always)]
    fn multiply<const M: usize>(group: &BendGroup<R, M>, tau: R, to: &mut StencilSums<'_, R>) {
        let StencilSums { positions: x, ways: direction, is_damped, sums: products } = to;
        // The sum is the opposite of a force.
        if let Some(curved) = group.law.curved(group.first(x)) {
            let pull = curved.change(group.first(direction)) * (tau * tau * group.law.stiffness);
            group.subtract_parts(curved.parts(-pull), products);
            if group.law.damping != R::ZERO {
                let along = curved.gradient();
                let rate = dot_parts::<R>(&along, group.first(direction));
                let drag = rate * (tau * group.law.damping);
                group.subtract_parts(along.map(|part| part * -drag), products);
            }
            return;
        }
        let none = [[R::ZERO; M]; 3];
        let [bent, edges] = if *is_damped { [group.sums(x), group.edges(x)] } else { [none; 2] };
        let of = group.sums(direction);
        let mut pulls = group.products((tau, *is_damped), [&bent, &edges], &of);
        pulls.iter_mut().flatten().for_each(|pull| *pull = -*pull);
        group.subtract_pulls(&pulls, products);
    }

    fn add_blocks(
        single: &BendGroup<R, 1>,
        (tau, positions): (R, &[R]),
        blocks: &mut [&mut [R]; 2],
    ) {
        let (zero, one, law) = (R::ZERO, R::ONE, &single.law);
        let units = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        if let Some(curved) = law.curved(single.first(positions)) {
            let along = curved.gradient();
            for (end, part) in along.map(R::Vec3::components).into_iter().enumerate() {
                // The columns of G for this particle.
                let columns = units.map(R::Vec3::from_components).map(|unit| {
                    curved.change(|other| if other == end { unit } else { R::Vec3::ZERO })
                });
                let number = |(a, b): (usize, usize)| {
                    let elastic = columns[a].dot(columns[b]) * (tau * tau * law.stiffness);
                    elastic + part[a] * part[b] * (tau * law.damping)
                };
                let rows = [[(0, 0), (0, 1), (0, 2)], [(1, 1), (1, 2), (2, 2)]];
                single.add_block(end, rows.map(|row| row.map(number)), blocks);
            }
            return;
        }
        let about = [&single.sums(positions), &single.edges(positions)];
        let how = (tau, law.damping != zero);
        let [x, y, z] = units.map(|unit| {
            single.products(how, about, &unit.map(|number| [number])).map(|[number]| number)
        });
        for (end, &weight) in law.weights.iter().enumerate() {
            let block = [x, [y[1], y[2], z[2]]].map(|row| row.map(|x| x * (weight * weight)));
            single.add_block(end, block, blocks);
        }
    }

    /// A bend is a constraint |s| = 0 of compliance 1/k, of one that is curved |d| = 0.
    #[inline(always)]
    fn project<const M: usize>(
        group: &BendGroup<R, M>,
        applied: &mut Triple<R, M>,
        projection: &mut Projection<'_, R>,
    ) {
        let Projection { h, inverse_masses, positions, ways, .. } = projection;
        let (h, law) = (*h, &group.law);
        let shape = {
            let (start, way) = (group.first(positions), group.first(ways));
            law.curved(|end| start(end) + way(end))
        };
        if let Some(curved) = shape {
            project_curved((group, &curved), applied, h, (inverse_masses, ways));
            return;
        }
        let (moved, mut bent) = (group.sums(ways), group.sums(positions));
        for (bent, moved) in bent.iter_mut().zip(&moved) {
            (0..M).for_each(|lane| bent[lane] += moved[lane]);
        }
        let (squares, alongs) = (dots(&bent, &bent), dots(&bent, &moved));
        let mut yielding = [R::ZERO; M];
        for (end, weight) in law.terms() {
            let inverse_masses = group.numbers(inverse_masses, end, 0);
            (0..M).for_each(|lane| yielding[lane] += weight * weight * inverse_masses[lane]);
        }
        let mut pulls = [[R::ZERO; M]; 3];
        for lane in 0..M {
            let (stiff, damp) = (group.constants[0][lane] * h * h, group.constants[1][lane] * h);
            let factor = R::ONE / (R::ONE + (stiff + damp) * yielding[lane]);
            let drag = damp * alongs[lane] * (R::ONE / squares[lane]);
            let is_bent = R::SHORTEST_SQUARED <= squares[lane];
            for axis in 0..3 {
                let pull = (bent[axis][lane] * (stiff + drag) - applied[axis][lane]) * factor;
                pulls[axis][lane] = if is_bent { pull } else { R::ZERO };
                applied[axis][lane] += pulls[axis][lane];
            }
        }
        for (end, weight) in law.terms() {
            let inverse_masses = group.numbers(inverse_masses, end, 0);
            for (axis, pulls) in pulls.iter().enumerate() {
                let moves = |lane: usize| pulls[lane] * (weight * inverse_masses[lane]);
                group.subtract((end, axis), moves, ways);
            }
        }
    }

    fn energy_and_pulls(row: &Row<R>, motion: &Motion<'_, R>) -> [f64; 3] {
        let (law, position) =
            (row.law.to_f64(), |end: usize| motion.position(row.particle(end)).to_f64());
        let bent = law.curved(position).map_or_else(|| law.sum(position), |curved| curved.off);
        let weight: f64 = law.weights.iter().map(|weight| weight.abs()).sum();
        let (stiffness, square) = (law.stiffness, bent.dot(bent));
        let pull = stiffness * weight * Real::sqrt(square);
        [0.5 * stiffness * square, pull, stiffness * weight * weight]
    }

    fn add_row_sums(row: &Row<R>, motion: &Motion<'_, R>, sums: &mut [[f64; 2]]) {
        let law = row.law.to_f64();
        let mut add = |end: usize, [stiffness, damping]: [f64; 2]| {
            let sum = &mut sums[row.particle(end)];
            *sum = [sum[0] + stiffness, sum[1] + damping];
        };
        if let Some(curved) = law.curved(|end| motion.position(row.particle(end)).to_f64()) {
            let (bounds, along) = (curved.bounds(), curved.gradient());
            let lengths = along.map(|part| Real::sqrt(part.dot(part)));
            let all: f64 = bounds.iter().map(|bound| bound[0]).sum();
            let total: f64 = lengths.iter().sum();
            let pull = law.stiffness * Real::sqrt(curved.off.dot(curved.off));
            for (end, [own, turning]) in bounds.into_iter().enumerate() {
                let damped = law.damping * lengths[end] * total;
                add(end, [law.stiffness * own * all + pull * turning, damped]);
            }
            return;
        }
        let all: f64 = law.weights.iter().map(|weight| weight.abs()).sum();
        for (end, weight) in law.terms() {
            add(end, [law.stiffness, law.damping].map(|value| value * (weight.abs() * all)));
        }
    }

    fn add_products(
        row: &Row<R>,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        let law = row.law.to_f64();
        let position = |end: usize| motion.position(row.particle(end)).to_f64();
        let way = |end: usize| direction[row.particle(end)];
        if let Some(curved) = law.curved(position) {
            let (elastic, along) = (curved.product(law.stiffness, way), curved.gradient());
            let drag = dot_parts::<f64>(&along, way) * law.damping;
            for (end, elastic) in elastic.into_iter().enumerate() {
                products.add(row.particle(end), [elastic, along[end] * drag]);
            }
            return;
        }
        let (of, bent, edge) = (law.sum(way), law.sum(position), position(1) - position(0));
        let square = bent.dot(bent);
        let along = match is_straight::<f64>(square, edge.dot(edge)) {
            true => of,
            false => bent * (bent.dot(of) / square),
        };
        for (end, weight) in row.law.terms() {
            let [k, b] = [row.law.stiffness, row.law.damping].map(|x| (x * weight).to_f64());
            products.add(row.particle(end), [of * k, along * b]);
        }
    }
}

/// The pull of a bend that is straight at rest, newtons. The force on each of its particles is the
/// opposite of it times the weight of the particle. Particles of weight 0 take no part.
///
/// With s the weighted sum of the positions, s' that of the velocities and ŝ the direction of s:
/// k s + b ŝ (ŝ·s'). Against all of s' a damper would brake a bent body that turns.
pub fn pull<N: Number>(
    [positions, velocities]: [[[N; 3]; 4]; 2],
    weights: [N; 4],
    [stiffness, damping]: [N; 2],
) -> [N; 3] {
    let (zero, one) = (stiffness.zero(), stiffness.one());
    let sum = |of: [[N; 3]; 4]| {
        each(|axis| {
            (1..4).fold(zero, |sum, end| {
                let more = sum + (of[end][axis] - of[0][axis]) * weights[end];
                N::select(weights[end].abs().is_at_most(zero), sum, more)
            })
        })
    };
    let (bent, rate) = (sum(positions), sum(velocities));
    let square = pack::dot(bent, bent);
    let drag = pack::dot(bent, rate) * damping * (one / square);
    let has_direction = square.splat(N::Scalar::SHORTEST_SQUARED).is_at_most(square);
    let factor = stiffness + N::select(has_direction, drag, zero);
    bent.map(|number| number * factor)
}

/// Moves the particles of a curved bend: first to reduce its deviation from rest, then against the
/// change of its angle.
fn project_curved<R: Real, const M: usize>(
    (group, curved): (&BendGroup<R, M>, &Curved<R>),
    [elastic, damped, _]: &mut Triple<R, M>,
    h: R,
    (inverse_masses, ways): (&[R], &mut [R]),
) {
    let mass = |end: usize| inverse_masses[group.at[end] as usize];
    let push = |ways: &mut [R], parts: [R::Vec3; 4], [stiff, by]: [R; 2], sum: &mut R| {
        let square = |end: usize| parts[end].dot(parts[end]) * mass(end);
        let squares = (0..4).map(square).fold(R::ZERO, |sum, add| sum + add);
        let pull = (stiff * by - *sum) * (R::ONE / (R::ONE + stiff * squares));
        *sum += pull;
        for (end, part) in parts.into_iter().enumerate() {
            add_vector::<R>(ways, group.at[end] as usize, part * -(pull * mass(end)));
        }
    };
    let square = curved.off.dot(curved.off);
    if R::SHORTEST_SQUARED <= square {
        let (length, stiff) = (square.sqrt(), group.law.stiffness * h * h);
        push(ways, curved.parts(curved.off * (R::ONE / length)), [stiff, length], &mut elastic[0]);
    }
    if group.law.damping != R::ZERO {
        let along = curved.gradient();
        let moved = dot_parts::<R>(&along, group.first(ways));
        push(ways, along, [group.law.damping * h, moved], &mut damped[0]);
    }
}

/// Returns whether a bend is all but straight, by the squares of its sum and of an edge. Its
/// direction is not known yet, as any motion would give it one. Its damping is then taken to act in
/// all.
#[inline(always)]
fn is_straight<R: Real>(square: R, edge: R) -> bool {
    let bent = edge * R::of(1e-6) < square && R::SHORTEST_SQUARED <= square;
    !bent
}

/// The sum of scalar products of the parts of particles with the vectors that a function gives for
/// them.
#[inline(always)]
fn dot_parts<R: Real>(parts: &[R::Vec3; 4], of: impl Fn(usize) -> R::Vec3) -> R {
    let [a, b, c, d] = from_fn(|end| parts[end].dot(of(end)));
    (a + b) + (c + d)
}

/// The scalar products of vectors in lanes.
#[inline(always)]
fn dots<R: Real, const M: usize>(a: &Triple<R, M>, b: &Triple<R, M>) -> [R; M] {
    let mut dots = [R::ZERO; M];
    for lane in 0..M {
        dots[lane] = a[0][lane] * b[0][lane] + a[1][lane] * b[1][lane] + a[2][lane] * b[2][lane];
    }
    dots
}

/// Multiplies numbers by others, lane by lane.
#[inline(always)]
fn multiply<R: Real, const M: usize>(numbers: &mut [R; M], by: &[R; M]) {
    for lane in 0..M {
        numbers[lane] *= by[lane];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::{LANES, RECORD};
    use crate::pack::lanes::{Law, check};

    /// Numbers from −1 to 1 of a fixed sequence (Knuth's generator of 64 bits); some are 0.
    fn numbers<R: Real>(seed: u64) -> impl FnMut() -> R {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            R::of(((state >> 40) % 4097) as f64 / 2048.0 - 1.0)
        }
    }

    /// A bundle of bends whose ends are in four records, and each of them by the law.
    fn twins_agree<R: Real>(seed: u64) {
        let mut number = numbers::<R>(seed);
        let [x, v] = [(); 2].map(|()| -> [R; 4 * RECORD] { from_fn(|_| number()) });
        let mut weights = [(); 4].map(|()| number());
        // Ropes have bends of three particles.
        weights[3] = if seed.is_multiple_of(2) { R::ZERO } else { weights[3] };
        let mut rows = Vec::new();
        for lane in 0..LANES as u32 {
            let law = BendLaw { weights, rest: R::ZERO, stiffness: number(), damping: number() };
            let at = from_fn(|end| (end * RECORD) as u32 + lane);
            rows.push(Stencil { particles: [0; 4], at, law });
        }
        let mut all = [R::ZERO; 4 * RECORD];
        let mut one = [R::ZERO; 4 * RECORD];
        let to = |sums| StencilSums { positions: &x, ways: &v, is_damped: true, sums };
        BendLaw::pull::<LANES>(&Group::new(&rows, rows[0].at), &mut to(&mut all));
        BendLaw::pull::<1>(&Group::new(&rows[..1], rows[0].at), &mut to(&mut one));
        for (lane, row) in rows.iter().enumerate() {
            let ends = [&x, &v].map(|column| {
                from_fn(|end| each(|axis| column[end * RECORD + axis * LANES + lane]))
            });
            let force = pull(ends, weights, [row.law.stiffness, row.law.damping]);
            for (end, weight) in weights.into_iter().enumerate() {
                for (axis, force) in force.into_iter().enumerate() {
                    let at = end * RECORD + axis * LANES + lane;
                    let takes_part = weight != R::ZERO;
                    let wanted = if takes_part { R::ZERO - force * weight } else { R::ZERO };
                    let alone = if lane == 0 { wanted } else { R::ZERO };
                    let bits = |number: R| number.to_f64().to_bits();
                    assert_eq!([all[at], one[at]].map(bits), [wanted, alone].map(bits));
                }
            }
        }
    }

    #[test]
    fn bends_side_by_side_have_the_bits_of_the_law() {
        for seed in 0..200 {
            twins_agree::<f32>(seed);
            twins_agree::<f64>(seed);
        }
    }

    struct Bending;

    impl Law<30, 3> for Bending {
        fn of<N: Number>(numbers: [N; 30]) -> [N; 3] {
            let vectors =
                |first: usize| from_fn(|end| each(|axis| numbers[first + 3 * end + axis]));
            let weights = from_fn(|end| numbers[24 + end]);
            pull([vectors(0), vectors(12)], weights, [numbers[28], numbers[29]])
        }
    }

    #[test]
    fn the_law_for_many_has_the_bits_of_each() {
        check::<Bending, 30, 3>();
    }
}
