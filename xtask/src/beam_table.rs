//! The error of a coarse lattice: a clamped beam against that of Timoshenko (1921).

use msd_core::glam::DVec3;
use msd_core::{Elasticity, Error, Material, Part, Particle, Spring, Substance, shape};
use msd_report::pen::{Axis, Drawn, Pen, Point, Type};
use msd_report::{drawing, ink};
use plotters::prelude::{DrawingBackend, RGBColor};
use serde::Serialize;

/// Young's modulus, pascals.
pub const YOUNG: f64 = 1e5;
/// Density, kilograms per cubic metre.
pub const DENSITY: f64 = 1000.0;
/// Edge of the square section, metres; the beam is 10 times as long.
pub const THICKNESS: f64 = 0.1;
/// Length, metres.
pub const LENGTH: f64 = 10.0 * THICKNESS;
/// Young's modulus of alike springs of 1 N/m and 1 m along an axis: C11 − 2 C12²/(C11 + C12) with
/// C11 = 13/3 and C12 = 7/3.
const ALIKE: f64 = 13.0 / 3.0 - 2.0 * 49.0 / 9.0 / (20.0 / 3.0);
/// Cells across the beams of the table.
const CELLS: [usize; 4] = [1, 2, 4, 6];

/// Errors of beams of so many cells across, per cent of those of theory; the keys of `--json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BeamRow {
    /// Cells across.
    pub cells: usize,
    /// Deflection of the tip under a load at the end.
    pub deflection: f64,
    /// The first frequency.
    pub frequency: f64,
    /// Deflection with springs that are all alike and count in full, of the same Young's modulus
    /// along the beam.
    pub alike: f64,
    /// The centre line under the load, of a deflection of 1 in theory: parts of the length, and of
    /// that deflection.
    #[serde(skip)]
    pub line: Vec<Point>,
    /// The same with springs that are all alike.
    #[serde(skip)]
    pub alike_line: Vec<Point>,
}

/// Computes the table: a second, optimised.
///
/// # Errors
/// Of none of these beams.
pub fn beam_table() -> Result<Vec<BeamRow>, Error> {
    let (deflection, frequency) = (timoshenko_deflection(), timoshenko_frequency());
    let percent = |value: f64, exact: f64| 100.0 * (value / exact - 1.0);
    let row = |&cells: &usize| {
        let (beam, alike) = (Beam::new(cells)?, Beam::alike(cells)?);
        let (tip, motion) = beam.deflection();
        let (alike_tip, alike_motion) = alike.deflection();
        Ok(BeamRow {
            cells,
            deflection: percent(tip, deflection),
            alike: percent(alike_tip, deflection),
            line: beam.line(&motion, deflection),
            alike_line: alike.line(&alike_motion, deflection),
            frequency: percent(beam.frequency(motion), frequency),
        })
    };
    CELLS.iter().map(row).collect()
}

/// The rows as a table of Markdown.
pub fn text(rows: &[BeamRow]) -> String {
    let mut table =
        "| cells across | deflection | first frequency | deflection, identical springs |\n\
                     |---|---|---|---|\n"
            .to_string();
    for BeamRow { cells, deflection, frequency, alike, .. } in rows {
        table += &format!("| {cells} | {deflection:+.1} % | {frequency:+.1} % | {alike:+.0} % |\n");
    }
    table
}

/// The centre lines of the beams under their load, as a drawing.
pub fn svg(rows: &[BeamRow]) -> String {
    drawing(HEIGHT, "A clamped beam under a load at its end, by cells across", |surface| {
        // Text refuses nothing.
        let drawn = draw(rows, surface);
        debug_assert!(drawn.is_ok());
    })
}

/// Height of the figure, pixels.
const HEIGHT: f64 = 560.0;
/// Places of the clamp and of the tip of the beam of theory, pixels.
const CLAMP: Point = (60.0, 60.0);
const TIP: Point = (560.0, 510.0);

fn draw<DB: DrawingBackend>(rows: &[BeamRow], surface: DB) -> Drawn<DB> {
    let pen = Pen::new(surface, ink::PAPER.light)?;
    let title = Type { bold: true, ..Type::new(16.0, ink::TEXT.light) };
    pen.words(
        "A clamped beam, 10 thicknesses long, under a load at its end",
        (CLAMP.0, 22.0),
        title,
    )?;
    let wall = [(CLAMP.0, CLAMP.1 - 14.0), (CLAMP.0, CLAMP.1 + 60.0)];
    pen.line(&wall, ink::GUIDE.light, 3.0)?;
    let [x, y] = [(CLAMP.0, TIP.0), (CLAMP.1, TIP.1)].map(|pixels| Axis {
        values: (0.0, 1.0),
        pixels,
        log: false,
    });
    let place = |line: &[Point]| -> Vec<Point> {
        line.iter().map(|point| (x.at(point.0), y.at(point.1))).collect()
    };
    let curve = |line: &[Point], said: &str, (colour, width): (RGBColor, f64)| {
        let points = place(line);
        pen.line(&points, colour, width)?;
        let Some(end) = points.last() else { return Ok(()) };
        pen.words(said, (end.0 + 10.0, end.1), Type::new(12.5, colour))
    };
    curve(&timoshenko_line(), "theory (Timoshenko)", (ink::TEXT.light, 2.4))?;
    let [shares, alike] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0)];
    for row in rows {
        let cells = if row.cells == 1 { "cell" } else { "cells" };
        curve(&row.line, &format!("{} {cells} across", row.cells), (shares, 1.6))?;
    }
    // The others lie too close to be labelled apart.
    if let Some(row) = rows.last() {
        let said = format!("{} cells, alike springs", row.cells);
        curve(&row.alike_line, &said, (alike, 1.6))?;
    }
    pen.finish()
}

/// The centre line of theory: deflection under a load at the end, of 1 at the tip.
fn timoshenko_line() -> Vec<Point> {
    let [bending, shear, ..] = section();
    let at = |part: f64| {
        let x = part * LENGTH;
        let bent = (LENGTH * x * x / 2.0 - x * x * x / 6.0) / bending;
        (part, (bent + x / shear) / timoshenko_deflection())
    };
    (0..=60).map(|step| at(f64::from(step) / 60.0)).collect()
}

/// A part that is clamped at its left end, for small displacements.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Its particles and springs.
    pub part: Part,
    clamped: Vec<bool>,
    /// The direction of each spring times the root of its stiffness.
    ways: Vec<DVec3>,
    /// The diagonal of the stiffness matrix.
    diagonal: Vec<DVec3>,
}

impl Beam {
    /// A beam of a solid, so many cells across.
    ///
    /// # Errors
    /// No cell.
    pub fn new(cells: usize) -> Result<Self, Error> {
        let young = Elasticity::Solid { young: YOUNG, poisson: msd_core::substance::SOLID_POISSON };
        let solid = Substance { elasticity: young, density: DENSITY, relaxation_time: 0.0 };
        let (size, spacing) = lattice(cells);
        Ok(Beam::of(shape::body(size, spacing, &solid)?))
    }

    /// A beam of alike springs, of the same Young's modulus along it.
    fn alike(cells: usize) -> Result<Self, Error> {
        let (size, spacing) = lattice(cells);
        let material = Material { stiffness: YOUNG * spacing / ALIKE, ..Material::default() };
        Ok(Beam::of(shape::block(size, spacing, material)?))
    }

    fn of(part: Part) -> Self {
        let clamped = part.particles.iter().map(|row| row.position.x < 1e-9 - 0.5 * LENGTH);
        let clamped: Vec<bool> = clamped.collect();
        let way = |spring: &Spring| {
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
    pub fn solve(&self, forces: &[DVec3]) -> Vec<DVec3> {
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
    pub fn shares(&self) -> Vec<f64> {
        let half = 0.5 * THICKNESS - 1e-9;
        let share = |row: &Particle| {
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

    /// The deflection of the free end under a load of 1 N, metres, and the displacements.
    fn deflection(&self) -> (f64, Vec<DVec3>) {
        let load: Vec<DVec3> = self.shares().iter().map(|share| DVec3::Y * *share).collect();
        let displacement = self.solve(&load);
        (dot(&load, &displacement), displacement)
    }

    /// The mean displacement of each section, from the clamp on, over a deflection.
    fn line(&self, displacement: &[DVec3], deflection: f64) -> Vec<Point> {
        let mut sections: Vec<(f64, f64, f64)> = Vec::new();
        let rows = self.part.particles.iter().zip(displacement);
        let mut rows: Vec<(f64, f64)> =
            rows.map(|(row, moved)| (row.position.x, moved.y)).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (x, moved) in rows {
            match sections.last_mut() {
                Some(last) if x - last.0 < 1e-9 => {
                    (last.1, last.2) = (last.1 + moved, last.2 + 1.0)
                }
                _ => sections.push((x, moved, 1.0)),
            }
        }
        let point = |(x, sum, count): (f64, f64, f64)| (x / LENGTH + 0.5, sum / count / deflection);
        sections.into_iter().map(point).collect()
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

/// Particles along rows, columns and stacks of a beam so many cells across, and their spacing.
fn lattice(cells: usize) -> ([usize; 3], f64) {
    ([cells + 1, 10 * cells + 1, cells + 1], THICKNESS / cells.max(1) as f64)
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

/// The residual at the free end of a beam that vibrates with the frequency w: zero at its modes.
///
/// Deflection y and turn θ begin with 0. Moment M and force Q begin with the values that make both
/// end with 0: y' = θ + Q/(κGA), θ' = M/(EI), M' = −Q − ρI w² θ, Q' = −ρA w² y.
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
