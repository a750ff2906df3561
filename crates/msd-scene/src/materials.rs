//! Materials by name: their measured numbers, and the sources of these.
//!
//! Every number has its source, except where the field `remarks` says otherwise; a number without a
//! source is not here. Moduli are those of small strains, at room temperature.

/// A material that a scene may name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named {
    /// The name a user writes.
    pub name: &'static str,
    /// Its numbers.
    pub numbers: Numbers,
    /// Who measured or set them, and where they are published.
    pub source: &'static str,
    /// The measured quantity, its range, and any additions.
    pub remarks: &'static str,
}

/// The numbers of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers {
    /// A uniform material, of which blocks, sheets and ropes are made.
    Uniform {
        /// Young's modulus, pascals.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
        /// Density, kilograms per cubic metre.
        density: f64,
        /// Viscosity over modulus, seconds.
        relaxation_time: f64,
    },
    /// A fabric.
    Fabric {
        /// Modulus along the warp, newtons per metre.
        young_warp: f64,
        /// Modulus along the weft, newtons per metre.
        young_weft: f64,
        /// Shear modulus, newtons per metre.
        shear: f64,
        /// Mass per area, kilograms per square metre.
        area_density: f64,
        /// Bending stiffness of the warp, of the weft and at 45° to both, newton metres.
        bending: [f64; 3],
    },
}

/// A gel of gelatine in water by its shear modulus: it keeps its volume, so that E = 3 G.
const fn gelatine(
    name: &'static str,
    (shear, relaxation_time): (f64, f64),
    remarks: &'static str,
) -> Named {
    let (young, poisson, density) = (3.0 * shear, 0.5, 998.0);
    Named {
        name,
        numbers: Numbers::Uniform { young, poisson, density, relaxation_time },
        source: "Nguyen and others, Ultrasound Med. Biol. 40 (2014) 168, abstract: phantoms \
                 without oil",
        remarks,
    }
}

/// The material of a body, as an engineer would say it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Made {
    /// The name of its material, if it has one.
    pub material: Option<&'static str>,
    /// Young's modulus, pascals; none of a woven sheet, which has several moduli.
    pub young: Option<f64>,
    /// Poisson's ratio that its springs and volumes give; none of a rope and of a woven sheet.
    pub poisson: Option<f64>,
    /// Density, kilograms per cubic metre; of a woven sheet per square metre.
    pub density: f64,
    /// Viscosity over modulus, seconds.
    pub relaxation_time: f64,
    /// Thickness of a uniform sheet, metres.
    pub thickness: Option<f64>,
}

const fn uniform(young: f64, poisson: f64, density: f64) -> Numbers {
    Numbers::Uniform { young, poisson, density, relaxation_time: 0.0 }
}

/// The first row of the table "stretching" of ARCSim's `materials/11oz-black-denim.json`, of the
/// smallest strains: C11, C12, C22 and C33, newtons per metre.
pub const ARCSIM_DENIM_STRETCHING: [f64; 4] = [205.352005, 10.234077, 1013.88629, 53.387184];

/// The first column of the table "bending" of the same file, of the smallest curvatures: hinges
/// along 1, at 45° and along 2, newton metres. Rows are directions there and columns curvatures.
pub const ARCSIM_DENIM_BENDING: [f64; 3] = [64.196457e-6, 73.384567e-6, 96.951576e-6];

/// The denim of ARCSim, its stiffer direction, 2, taken for the warp.
const fn denim() -> Numbers {
    let [c11, c12, c22, c33] = ARCSIM_DENIM_STRETCHING;
    let [across_2, across_45, across_1] = ARCSIM_DENIM_BENDING;
    Numbers::Fabric {
        // Moduli with free sides.
        young_warp: c22 - c12 * c12 / c11,
        young_weft: c11 - c12 * c12 / c22,
        // Its forces are those of an energy C33 e12² per area, e12 being half of the angle.
        shear: c33 / 2.0,
        area_density: 0.324,
        // A quarter of that of hinges: see docs/explanation/materials.md. A hinge bends the threads
        // that cross it.
        bending: [across_2 / 4.0, across_1 / 4.0, across_45 / 4.0],
    }
}

/// The materials, soft ones first.
pub const MATERIALS: [Named; 10] = [
    gelatine(
        "gelatine-3%",
        (2010.0, 0.60 / 2010.0),
        "shear modulus by shear waves, 2.01 ± 0.26 kPa, as E = 3 G; viscosity 0.60 ± 0.11 Pa s; \
         density of water",
    ),
    gelatine(
        "gelatine-4%",
        (3100.0, 0.0),
        "shear modulus by shear waves, 3.10 ± 0.34 kPa, as E = 3 G; density of water",
    ),
    gelatine(
        "gelatine-5%",
        (4180.0, 0.0),
        "shear modulus by shear waves, 4.18 ± 0.84 kPa, as E = 3 G; density of water",
    ),
    gelatine(
        "gelatine-6%",
        (8050.0, 0.0),
        "shear modulus by shear waves, 8.05 ± 1.00 kPa, as E = 3 G; density of water",
    ),
    gelatine(
        "gelatine-7%",
        (10_240.0, 0.0),
        "shear modulus by shear waves, 10.24 ± 1.80 kPa, as E = 3 G; density of water",
    ),
    Named {
        name: "sylgard-184",
        numbers: uniform(1.32e6, 0.5, 1030.0),
        source: "Johnston and others, J. Micromech. Microeng. 24 (2014) 035017; density: data \
                 sheet of Dow",
        remarks: "tension, cured at 25 °C; 1.32 to 2.97 MPa for curing at 25 to 200 °C; taken for \
                  incompressible",
    },
    Named {
        name: "natural-rubber",
        numbers: uniform(3.0 * 0.5e6, 0.5, 950.0),
        source: "MatWeb, data sheet of vulcanized natural rubber",
        remarks: "shear modulus of 0.5 MPa, as E = 3 G; unfilled: compounds are stiffer and denser",
    },
    Named {
        name: "cotton-denim",
        numbers: denim(),
        source: "Wang, O'Brien and Ramamoorthi, ACM Trans. Graph. 30 (2011) 71: 11 oz black denim, \
                 99 % cotton",
        remarks: "fitted by ARCSim to samples pulled by weights: the first row of its stretching \
                  table (smallest strains) and the first column of its bending table (smallest \
                  curvatures); the stiffer direction is the warp",
    },
    Named {
        name: "aluminium",
        numbers: uniform(70e9, 0.3, 2700.0),
        source: "EN 1999-1-1:2007, 3.2.5",
        remarks: "values to be used in design, for all alloys of that standard",
    },
    Named {
        name: "steel",
        numbers: uniform(210e9, 0.3, 7850.0),
        source: "EN 1993-1-1:2005, 3.2.6; density: EN 1991-1-1:2002, table A.4",
        remarks: "values to be used in design, for structural steels; density 7850 of 7850 to 8000",
    },
];

/// The material of a name.
pub fn named(name: &str) -> Option<&'static Named> {
    MATERIALS.iter().find(|material| material.name == name)
}
