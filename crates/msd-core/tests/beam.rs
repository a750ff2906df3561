//! The error of a coarse lattice: a clamped beam against that of Timoshenko (1921).
//!
//! `cargo test --release --test beam -- --nocapture` prints the table of `docs/materials.md`.

use msd_core::glam::DVec3;
use msd_core::{Elasticity, Material, Part, Substance, shape};

const YOUNG: f64 = 1e5;
const DENSITY: f64 = 1000.0;
/// Edge of the square section, metres; the beam is 10 times as long.
const THICKNESS: f64 = 0.1;
const LENGTH: f64 = 10.0 * THICKNESS;
/// Young's modulus of alike springs of 1 N/m and 1 m along an axis: C11 − 2 C12²/(C11 + C12) with
/// C11 = 13/3 and C12 = 7/3.
const ALIKE: f64 = 13.0 / 3.0 - 2.0 * 49.0 / 9.0 / (20.0 / 3.0);
const CELLS: [usize; 4] = [1, 2, 4, 6];

/// A part that is clamped at its left end, for small displacements.
struct Beam {
    part: Part,
    clamped: Vec<bool>,
    /// The direction of each spring times the root of its stiffness.
    ways: Vec<DVec3>,
    /// The diagonal of the stiffness matrix.
    diagonal: Vec<DVec3>,
}

impl Beam {
    fn new(part: Part) -> Self {
        let clamped = part.particles.iter().map(|row| row.position.x < 1e-9 - 0.5 * LENGTH);
        let clamped: Vec<bool> = clamped.collect();
        let way = |spring: &msd_core::Spring| {
            let [a, b] = spring.ends.map(|end| part.particles[end].position);
            (b - a).normalize() * spring.stiffness.sqrt()
        };
        let ways: Vec<DVec3> = part.springs.iter().map(way).collect();
        let mut diagonal = vec![DVec3::ZERO; part.particles.len()];
        for (spring, way) in part.springs.iter().zip(&ways) {
            spring.ends.iter().for_each(|&end| diagonal[end] += way * way);
        }
        Beam { part, clamped, ways, diagonal }
    }

    /// A beam of a solid, or of alike springs, so many cells thick.
    fn of(cells: usize, alike: bool) -> Self {
        let (size, spacing) = ([cells + 1, 10 * cells + 1, cells + 1], THICKNESS / cells as f64);
        let solid = Substance {
            elasticity: Elasticity::Solid {
                young: YOUNG,
                poisson: msd_core::substance::SOLID_POISSON,
            },
            density: DENSITY,
            relaxation_time: 0.0,
        };
        let material = Material { stiffness: YOUNG * spacing / ALIKE, ..Material::default() };
        let part = match alike {
            true => shape::block(size, spacing, material),
            false => shape::body(size, spacing, &solid),
        };
        Beam::new(part.expect("a beam"))
    }

    /// The forces that hold a displacement.
    fn product(&self, displacement: &[DVec3]) -> Vec<DVec3> {
        let mut forces = vec![DVec3::ZERO; displacement.len()];
        for (spring, &way) in self.part.springs.iter().zip(&self.ways) {
            let [a, b] = spring.ends;
            let force = way * way.dot(displacement[b] - displacement[a]);
            forces[a] -= force;
            forces[b] += force;
        }
        self.hold(&mut forces);
        forces
    }

    fn hold(&self, vectors: &mut [DVec3]) {
        let held = vectors.iter_mut().zip(&self.clamped).filter(|(_, clamped)| **clamped);
        held.for_each(|(vector, _)| *vector = DVec3::ZERO);
    }

    /// The displacement under forces, by conjugate gradients, to 1e-10.
    fn solve(&self, forces: &[DVec3]) -> Vec<DVec3> {
        let mut residual = forces.to_vec();
        self.hold(&mut residual);
        let mut solution = vec![DVec3::ZERO; forces.len()];
        let scaled = |residual: &[DVec3]| -> Vec<DVec3> {
            residual.iter().zip(&self.diagonal).map(|(r, d)| r / d).collect()
        };
        let mut direction = scaled(&residual);
        let mut square = dot(&residual, &direction);
        let enough = 1e-20 * square;
        while enough < square {
            let product = self.product(&direction);
            let step = square / dot(&direction, &product);
            for row in 0..solution.len() {
                solution[row] += direction[row] * step;
                residual[row] -= product[row] * step;
            }
            let next = scaled(&residual);
            let last = std::mem::replace(&mut square, dot(&residual, &next));
            for (direction, next) in direction.iter_mut().zip(next) {
                *direction = next + *direction * (square / last);
            }
        }
        solution
    }

    /// The part of a load at the free end that each particle takes, by area.
    fn shares(&self) -> Vec<f64> {
        let half = 0.5 * THICKNESS - 1e-9;
        let share = |row: &msd_core::Particle| {
            let at = row.position;
            let end = if 0.5 * LENGTH - 1e-9 < at.x { 1.0 } else { 0.0 };
            [at.y, at.z]
                .iter()
                .fold(end, |share, x| if half < x.abs() { 0.5 * share } else { share })
        };
        let shares: Vec<f64> = self.part.particles.iter().map(share).collect();
        let total: f64 = shares.iter().sum();
        shares.iter().map(|share| share / total).collect()
    }

    /// The deflection of the free end under a load of 1 N, metres.
    fn deflection(&self) -> (f64, Vec<DVec3>) {
        let load: Vec<DVec3> = self.shares().iter().map(|share| DVec3::Y * *share).collect();
        let displacement = self.solve(&load);
        (dot(&load, &displacement), displacement)
    }

    /// The lowest frequency, radians per second, by inverse iteration from a displacement.
    fn frequency(&self, mut motion: Vec<DVec3>) -> f64 {
        let mut last = 0.0;
        loop {
            let inertia = self.inertia(&motion);
            let next = self.solve(&inertia);
            // Rayleigh's quotient of the next motion, whose force is this inertia.
            let square = dot(&next, &inertia) / dot(&next, &self.inertia(&next));
            if (square - last).abs() < 1e-8 * square {
                return square.sqrt();
            }
            (last, motion) = (square, next);
            let size = dot(&motion, &motion).sqrt();
            motion.iter_mut().for_each(|x| *x /= size);
        }
    }

    fn inertia(&self, motion: &[DVec3]) -> Vec<DVec3> {
        motion.iter().zip(&self.part.particles).map(|(x, row)| *x * row.mass).collect()
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Bending stiffness, shear stiffness with the factor 5/6 of a rectangle, mass and rotary inertia
/// per length of the section.
fn section() -> [f64; 4] {
    let area = THICKNESS * THICKNESS;
    let moment = area * area / 12.0;
    let shear = 5.0 / 6.0 * 0.4 * YOUNG * area;
    [YOUNG * moment, shear, DENSITY * area, DENSITY * moment]
}

/// The deflection under 1 N at the end: P L³/(3 E I) + P L/(κ G A).
fn timoshenko_deflection() -> f64 {
    let [bending, shear, ..] = section();
    LENGTH.powi(3) / (3.0 * bending) + LENGTH / shear
}

/// What is left at the free end of a beam that vibrates with the frequency w: zero at its modes.
///
/// Deflection y and turn θ begin with 0, moment M and force Q with what makes both end with 0:
/// y' = θ + Q/(κGA), θ' = M/(EI), M' = −Q − ρI w² θ, Q' = −ρA w² y.
fn left_over(w: f64) -> f64 {
    let [bending, shear, mass, inertia] = section();
    let end = |mut state: [f64; 4]| {
        let slope = |[y, turn, moment, force]: [f64; 4]| {
            let turning = -force - inertia * w * w * turn;
            [turn + force / shear, moment / bending, turning, -mass * w * w * y]
        };
        let ahead = |state: [f64; 4], slope: [f64; 4], h: f64| {
            [0, 1, 2, 3].map(|row| state[row] + h * slope[row])
        };
        let steps = 1000;
        let h = LENGTH / f64::from(steps);
        for _ in 0..steps {
            let first = slope(state);
            let second = slope(ahead(state, first, 0.5 * h));
            let third = slope(ahead(state, second, 0.5 * h));
            let fourth = slope(ahead(state, third, h));
            state = [0, 1, 2, 3].map(|row| {
                let middle = second[row] + third[row];
                state[row] + h / 6.0 * (first[row] + 2.0 * middle + fourth[row])
            });
        }
        [state[2], state[3]]
    };
    let [a, b] = [end([0.0, 0.0, 1.0, 0.0]), end([0.0, 0.0, 0.0, 1.0])];
    a[0] * b[1] - a[1] * b[0]
}

/// The lowest frequency of the beam of Timoshenko, radians per second, by halving.
fn timoshenko_frequency() -> f64 {
    let [bending, _, mass, _] = section();
    // Of a slender beam of Euler and Bernoulli: shear and rotary inertia take a few per cent.
    let slender = 3.516 * (bending / (mass * LENGTH.powi(4))).sqrt();
    let (mut low, mut high) = (0.8 * slender, 1.01 * slender);
    assert!(left_over(low) * left_over(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let is_before = 0.0 < left_over(low) * left_over(middle);
        *(if is_before { &mut low } else { &mut high }) = middle;
    }
    low
}

/// The errors of deflection, frequency and the deflection of alike springs, per cent, by cells.
fn errors() -> Vec<[f64; 3]> {
    let (deflection, frequency) = (timoshenko_deflection(), timoshenko_frequency());
    let row = |&cells: &usize| {
        let beam = Beam::of(cells, false);
        let (tip, motion) = beam.deflection();
        let alike = Beam::of(cells, true).deflection().0;
        let percent = |value: f64, exact: f64| 100.0 * (value / exact - 1.0);
        let fast = percent(beam.frequency(motion), frequency);
        [percent(tip, deflection), fast, percent(alike, deflection)]
    };
    CELLS.iter().map(row).collect()
}

#[test]
fn a_coarse_beam_is_too_stiff_by_the_table_of_the_documentation() {
    let errors = errors();
    let mut table = "| cells across | deflection | first frequency | deflection, alike springs |\n\
                     |---|---|---|---|\n"
        .to_string();
    for (cells, [tip, fast, alike]) in CELLS.iter().zip(&errors) {
        table += &format!("| {cells} | {tip:+.1} % | {fast:+.1} % | {alike:+.0} % |\n");
    }
    println!("{table}");
    // Computed by another program, of other authors.
    let expected =
        [[-54.0, 46.0, -82.0], [-23.0, 14.0, -63.0], [-7.4, 4.0, -42.0], [-3.7, 2.0, -31.0]];
    for (found, expected) in errors.iter().zip(expected) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 0.5, "{found} %, not {expected} %");
        }
    }
    let page = include_str!("../../../docs/materials.md").replace('−', "-");
    assert!(page.contains(&table), "docs/materials.md lacks this table");
}

#[test]
fn a_clamped_beam_that_is_pulled_stretches_and_narrows_as_hooke_says() {
    let area = THICKNESS * THICKNESS;
    let strain = 1.0 / (YOUNG * area);
    let mut lost = Vec::new();
    for cells in [2, 4, 8] {
        let beam = Beam::of(cells, false);
        let load: Vec<DVec3> = beam.shares().iter().map(|share| DVec3::X * *share).collect();
        let moved = beam.solve(&load);
        let at = |place: DVec3| {
            let near = |row: &msd_core::Particle| row.position.distance(place) < 1e-9;
            moved[beam.part.particles.iter().position(near).expect("a particle there")]
        };
        // Far from both ends the strain is uniform, and of that the lattice is exact. What the
        // clamp adds decays at least by exp(−4) per thickness (Saint-Venant): to 1e-5 over 2.5.
        let [left, right] = [-0.25, 0.25].map(|part| at(DVec3::X * (part * LENGTH)).x);
        assert!(((right - left) / (0.5 * LENGTH * strain) - 1.0).abs() < 1e-4, "{cells}");
        let [low, high] = [-0.5, 0.5].map(|part| at(DVec3::Y * (part * THICKNESS)).y);
        assert!(((low - high) / (0.25 * THICKNESS * strain) - 1.0).abs() < 1e-4, "{cells}");
        // The clamp holds the first of the beam from narrowing: there E is at most 6/5 of what it
        // is, over about half a thickness.
        let elongation = dot(&load, &moved);
        let least = 1.0 - (1.0 - 5.0 / 6.0) * THICKNESS / LENGTH;
        let part = elongation / (LENGTH * strain);
        println!("{cells} cells: {part:.6} of F L/(E A)");
        assert!(least < part && part < 1.0, "{part}");
        lost.push(part);
    }
    // The edge of the clamp is a corner of the stress, so that the order is above 1, but not 2.
    let order = ((lost[0] - lost[1]) / (lost[1] - lost[2])).log2();
    println!("order {order:.2}");
    assert!(1.0 < order, "{order}");
}
