//! Substances of bodies, in the numbers of an engineer, and the springs of a lattice that behave
//! like them.
//!
//! A lattice of spacing a is cut into cells between neighbouring particles: cubes, squares or
//! lengths. A spring inside the body belongs to all cells around it, one in a face of the body to
//! half as many, one along an edge to a quarter. Each counts for the cells that it belongs to, and
//! so do the masses of particles. A network of springs of stiffness k, length L and direction n in
//! a volume V has the elasticity C_ijkl = (1/V) Σ k L² n_i n_j n_k n_l, which gives the formulas
//! below.

use crate::error::Error;
use crate::number::Real;
use crate::scene::check::{check, check_not_negative};
use crate::scene::lattice::{FAMILIES, Lattice};
use crate::scene::{Bend, Volume};
use alloc::vec::Vec;

/// Poisson's ratio of an isotropic solid of central springs alone: C12 = C44 leaves no other.
pub const SOLID_POISSON: f64 = 0.25;
/// Poisson's ratio of an isotropic sheet of central springs.
pub const SHEET_POISSON: f64 = 1.0 / 3.0;

/// The largest Poisson's ratio of a solid: towards 1/2 the stable step goes to 0.
pub const MOST_POISSON: f64 = 0.45;

/// The substance of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Substance {
    /// Its resistance to strain.
    pub elasticity: Elasticity,
    /// Density: of a solid kg/m³, of a sheet kg/m², of a rope kg/m; positive.
    pub density: f64,
    /// Viscosity over modulus (Kelvin and Voigt), seconds; not negative. Default 0.
    pub relaxation_time: f64,
}

/// Resistance of a substance to strain, by the dimensions of its lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Elasticity {
    /// An isotropic solid.
    Solid {
        /// Young's modulus, pascals; positive.
        young: f64,
        /// Poisson's ratio, 0 to [`MOST_POISSON`]. At [`SOLID_POISSON`] springs do alone; for any
        /// other the cells resist a change of volume too, and a step costs more.
        poisson: f64,
    },
    /// A sheet: pull per width and strain along its threads, and shear between them.
    Sheet {
        /// Modulus along the rows, newtons per metre; positive.
        warp: f64,
        /// Modulus along the columns, newtons per metre; positive.
        weft: f64,
        /// Shear modulus, newtons per metre; positive and at most warp weft / |warp − weft|.
        shear: f64,
        /// Its resistance to bending.
        bending: Bending,
    },
    /// A rope.
    Rope {
        /// Young's modulus times the area of the section, newtons; positive.
        stretch: f64,
        /// Bending stiffness, newton square metres; not negative.
        bending: f64,
    },
}

/// Stiffness of a sheet against being bent to a cylinder, per width, newton metres; by where the
/// line goes that is bent. Not negative.
///
/// With u and v along the rows and the columns, it stores
/// (warp κ_uu² + weft κ_vv² + (4 bias − warp − weft) κ_uv²)/2 per area. Where all three are alike
/// that is the energy of a uniform plate, whose Poisson's ratio only its free edges feel: there it
/// is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bending {
    /// Along the rows.
    pub warp: f64,
    /// Along the columns.
    pub weft: f64,
    /// At 45 degrees to both; at least (warp + weft)/4.
    pub bias: f64,
}

impl Bending {
    /// The same in all directions.
    pub fn uniform(stiffness: f64) -> Self {
        Bending { warp: stiffness, weft: stiffness, bias: stiffness }
    }
}

impl Elasticity {
    /// An isotropic sheet, whose Poisson's ratio is [`SHEET_POISSON`], and which bends as a plate:
    /// by E t³/(12 (1 − ν²)).
    pub fn sheet(young: f64, thickness: f64) -> Self {
        let modulus = young * thickness;
        let shear = modulus / (2.0 * (1.0 + SHEET_POISSON));
        let plate = 12.0 * (1.0 - SHEET_POISSON * SHEET_POISSON);
        let bending = Bending::uniform(modulus * thickness * thickness / plate);
        Elasticity::Sheet { warp: modulus, weft: modulus, shear, bending }
    }

    /// A rope of round section: E A against a pull and E π d⁴/64 against bending.
    pub fn rope(young: f64, diameter: f64) -> Self {
        let stretch = young * round_section(diameter);
        Elasticity::Rope { stretch, bending: stretch * (diameter * diameter) / 16.0 }
    }

    /// The number of dimensions of its lattice.
    fn dimensions(self) -> usize {
        match self {
            Elasticity::Solid { .. } => 3,
            Elasticity::Sheet { .. } => 2,
            Elasticity::Rope { .. } => 1,
        }
    }
}

/// The area of a round section, square metres.
pub fn round_section(diameter: f64) -> f64 {
    0.25 * core::f64::consts::PI * (diameter * diameter)
}

/// The springs and the mass of a cell inside a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Stiffness of springs along rows, columns and stacks, newtons per metre.
    axes: [f64; 3],
    /// Stiffness of the diagonals of faces, newtons per metre.
    faces: f64,
    /// Stiffness of space diagonals, newtons per metre.
    space: f64,
    /// Stiffness of bends in a line along rows, columns and stacks, newtons per metre.
    lines: [f64; 3],
    /// Stiffness of the twist of a cell, newtons per metre.
    twist: f64,
    /// Its resistance to a change of volume beyond that of its springs, pascals.
    modulus: f64,
    /// Its volume, cubic metres.
    volume: f64,
    /// Mass, kilograms.
    mass: f64,
    /// Damping over stiffness, seconds.
    relaxation_time: f64,
}

impl Cell {
    /// The cell of a lattice of `size` = (rows, columns, stacks) particles `spacing` metres apart.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a number outside its domain, or a size with more or fewer
    /// dimensions than the substance.
    pub(crate) fn new(
        substance: &Substance,
        size: [usize; 3],
        spacing: f64,
    ) -> Result<Self, Error> {
        let at = ("substance", 0);
        let dimensions = size.iter().filter(|&&length| 1 < length).count();
        let expected = match substance.elasticity {
            Elasticity::Solid { .. } => "3, each of at least 2 particles, for a solid",
            Elasticity::Sheet { .. } => "2, each of at least 2 particles, for a sheet",
            Elasticity::Rope { .. } => "1, of at least 2 particles, for a rope",
        };
        let fits = dimensions == substance.elasticity.dimensions();
        check(fits, "number of dimensions", at, dimensions as f64, expected)?;
        check_positive("density", substance.density)?;
        check_not_negative::<f64>("relaxation time", at, substance.relaxation_time)?;
        let (axes, faces, space) = stiffnesses(substance.elasticity, spacing)?;
        let (lines, twist) = bends(substance.elasticity, spacing)?;
        let mass = (0..dimensions).fold(substance.density, |mass, _| mass * spacing);
        let (modulus, volume) = (volume_modulus(substance.elasticity), spacing * spacing * spacing);
        let relaxation_time = substance.relaxation_time;
        Ok(Cell { axes, faces, space, lines, twist, modulus, volume, mass, relaxation_time })
    }

    /// The bends of a sheet or a rope: of every line of three particles, half as stiff in an edge,
    /// and of every cell.
    pub(crate) fn bends(&self, lattice: &Lattice) -> Vec<Bend> {
        let size = lattice.size();
        let mut bends = Vec::new();
        let at = |place: [usize; 3], steps: &[usize]| {
            let mut place = place;
            steps.iter().for_each(|&axis| place[axis] += 1);
            (0..3).all(|axis| place[axis] < size[axis]).then(|| lattice.particle(place))
        };
        let mut add = |bend: Bend| {
            let damping = bend.stiffness * self.relaxation_time;
            if 0.0 < bend.stiffness {
                bends.push(Bend { damping, ..bend });
            }
        };
        for axis in (0..3).filter(|&axis| 1 < size[axis]) {
            let mut step = [0; 3];
            step[axis] = 1;
            for particle in 0..lattice.particle_count() {
                let place = lattice.place(particle);
                let stiffness = self.lines[axis] * share(size, place, step);
                let ends = [at(place, &[axis]), at(place, &[axis, axis])];
                if let [Some(middle), Some(end)] = ends {
                    add(Bend::line([particle, middle, end], stiffness, 0.0));
                }
            }
        }
        for [u, v] in [[0, 1], [0, 2], [1, 2]] {
            for particle in 0..lattice.particle_count() {
                let place = lattice.place(particle);
                let corners = [at(place, &[u]), at(place, &[v]), at(place, &[u, v])];
                if let [Some(a), Some(b), Some(far)] = corners {
                    add(Bend::twist([particle, a, b, far], self.twist, 0.0));
                }
            }
        }
        bends
    }

    /// The volumes of the cells of a solid, unless springs do alone.
    pub(crate) fn volumes(&self, lattice: &Lattice) -> Vec<Volume> {
        let size = lattice.size();
        if self.modulus == 0.0 {
            return Vec::new();
        }
        let places = (0..lattice.particle_count()).map(|particle| lattice.place(particle));
        let inside = places.filter(|place| (0..3).all(|axis| place[axis] + 1 < size[axis]));
        // Columns go along x, rows along y and stacks along z.
        let corner = |[row, column, stack]: [usize; 3], corner: usize| {
            lattice.particle([
                row + (corner >> 1 & 1),
                column + (corner & 1),
                stack + (corner >> 2),
            ])
        };
        let volume = |place: [usize; 3]| Volume {
            particles: core::array::from_fn(|number| corner(place, number)),
            rest_volume: self.volume,
            modulus: self.modulus,
            damping: self.modulus * self.relaxation_time,
        };
        inside.map(volume).collect()
    }

    /// Mass of the particle at a place, kilograms: half for each face of the body that it lies in.
    pub(crate) fn mass_at(&self, lattice: &Lattice, place: [usize; 3]) -> f64 {
        self.mass * share(lattice.size(), place, [0; 3])
    }

    /// Stiffness, newtons per metre, and damping, newton seconds per metre, of a spring: half for
    /// each face of the body that it lies in.
    pub(crate) fn spring(&self, lattice: &Lattice, spring: usize) -> [f64; 2] {
        let step = FAMILIES[lattice.family_of(spring)];
        let place = lattice.place(lattice.spring(spring)[0]);
        let along = step.iter().filter(|&&length| length != 0).count();
        let inside = match along {
            1 => self.axes[step.iter().position(|&length| length != 0).unwrap_or(0)],
            2 => self.faces,
            _ => self.space,
        };
        let stiffness = inside * share(lattice.size(), place, step);
        [stiffness, stiffness * self.relaxation_time]
    }
}

/// The share of the cells around something inside the body that are around the row that starts at
/// `place` and goes on by `step`.
fn share(size: [usize; 3], place: [usize; 3], step: [isize; 3]) -> f64 {
    let is_in_face = |axis: usize| {
        let ends = place[axis] == 0 || place[axis] == size[axis] - 1;
        step[axis] == 0 && 1 < size[axis] && ends
    };
    (0..3).filter(|&axis| is_in_face(axis)).fold(1.0, |share, _| 0.5 * share)
}

/// Stiffnesses inside a lattice of spacing a, newtons per metre: along its axes, of diagonals of
/// faces, of space diagonals.
///
/// Solid: C11 = (k1 + 2 k2 + 4/3 k3)/a, C12 = C44 = (k2 + 4/3 k3)/a, isotropic where
/// k1 = k2 + 8/3 k3. Of these, 16 : 8 : 3 is the nearest to isotropic at sixth order. Springs alone
/// bear shear, so that they are those of Young's modulus 5/2 μ; see [`volume_modulus`].
///
/// Sheet: C11 = k1 + k2, C22 = k1' + k2, C12 = C66 = k2, and the moduli that one measures, with
/// the sides free, are C11 − C12²/C22 and C22 − C12²/C11. Hence C22 = C11 weft/warp, and
/// C11² − warp C11 − shear² warp/weft = 0.
fn stiffnesses(elasticity: Elasticity, spacing: f64) -> Result<([f64; 3], f64, f64), Error> {
    match elasticity {
        Elasticity::Solid { young, poisson } => {
            check_positive("Young's modulus", young)?;
            let fits = (0.0..=MOST_POISSON).contains(&poisson);
            check(fits, "Poisson's ratio", ("substance", 0), poisson, "0 to 0.45")?;
            let stiffness = young * ((1.0 + SOLID_POISSON) / (1.0 + poisson)) * spacing;
            Ok(([8.0 / 15.0 * stiffness; 3], 4.0 / 15.0 * stiffness, 0.1 * stiffness))
        }
        Elasticity::Sheet { warp, weft, shear, .. } => {
            check_positive("warp", warp)?;
            check_positive("weft", weft)?;
            check_positive("shear", shear)?;
            let c11 = 0.5 * (warp + Real::sqrt(warp * warp + 4.0 * shear * shear * (warp / weft)));
            let c22 = c11 * (weft / warp);
            let fits = shear <= c11 && shear <= c22;
            let expected = "at most warp weft / |warp - weft|";
            check(fits, "shear", ("substance", 0), shear, expected)?;
            Ok(([c11 - shear, c22 - shear, c22 - shear], shear, 0.0))
        }
        Elasticity::Rope { stretch, .. } => {
            check_positive("stretch", stretch)?;
            Ok(([stretch / spacing; 3], 0.0, 0.0))
        }
    }
}

/// Resistance of the cells of a solid to a change of volume beyond that of their springs, pascals:
/// λ − μ, as springs have λ = μ.
fn volume_modulus(elasticity: Elasticity) -> f64 {
    match elasticity {
        Elasticity::Solid { young, poisson } if poisson != SOLID_POISSON => {
            young * (4.0 * poisson - 1.0) / (2.0 * (1.0 + poisson) * (1.0 - 2.0 * poisson))
        }
        _ => 0.0,
    }
}

/// Stiffnesses of bends in a lattice of spacing a, newtons per metre: in lines along its axes, and
/// of the twist of a cell.
///
/// The sum of a line is a² κ and stands for a length a, in a sheet for an area a²: B κ²/2 gives
/// B/a³ and B/a². The sum of a cell is a² κ_uv.
fn bends(elasticity: Elasticity, spacing: f64) -> Result<([f64; 3], f64), Error> {
    let at = ("substance", 0);
    match elasticity {
        Elasticity::Solid { .. } => Ok(([0.0; 3], 0.0)),
        Elasticity::Sheet { bending: Bending { warp, weft, bias }, .. } => {
            check_not_negative::<f64>("bending of the warp", at, warp)?;
            check_not_negative::<f64>("bending of the weft", at, weft)?;
            let expected = "finite and at least a quarter of the sum of the other two";
            let fits = bias.is_finite() && 0.25 * (warp + weft) <= bias;
            check(fits, "bending on the bias", at, bias, expected)?;
            let area = spacing * spacing;
            let twist = (4.0 * bias - warp - weft) / area;
            Ok(([warp / area, weft / area, weft / area], twist))
        }
        Elasticity::Rope { bending, .. } => {
            check_not_negative::<f64>("bending", at, bending)?;
            Ok(([bending / (spacing * spacing * spacing); 3], 0.0))
        }
    }
}

fn check_positive(quantity: &'static str, value: f64) -> Result<(), Error> {
    let usable = 0.0 < value && value.is_finite();
    check(usable, quantity, ("substance", 0), value, "positive and finite")
}
