//! Domains of the numbers of a scene file.
//!
//! [`DOMAINS`] is what is checked, what a message says, and what `docs/scenes.md` says of each key.

use crate::error::{FileError, plain};
use crate::file::schema::VERSION;
use crate::file::tree::Source;
use crate::precision::Precision;
use crate::shown::tame;
use glam::DVec3;
use std::fmt::{Arguments, Display};

/// What values a key may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// Positive.
    Positive,
    /// A mass: positive, and its reciprocal finite.
    Mass,
    /// The length of a step, seconds: its square must not vanish, however many substeps.
    Step,
    /// Steps per second.
    Rate,
    /// Not negative.
    NotNegative,
    /// Not negative, in single precision whatever that of the file.
    Factor,
    /// From 0 to 1.
    Fraction,
    /// Degrees above the horizon.
    Elevation,
    /// Any number.
    Finite,
    /// Positive and at most so much.
    UpTo(f64, &'static str),
    /// Whole and from 1 to so much.
    Count(u64, &'static str),
    /// Three numbers.
    Vector,
    /// Three numbers inside the world.
    Place,
    /// Three numbers that have a direction.
    Direction,
}

/// The largest number of Newton iterations.
pub const MOST_NEWTON: u32 = 1000;
/// A length that the world may have.
pub(crate) const LENGTH: Domain = Domain::UpTo(1e12, "positive and at most 1e12");
/// The longest step, seconds.
const LONGEST_STEP: f64 = 1e6;

/// The domain of every key that holds numbers of one kind, by its tables.
pub const DOMAINS: [(&str, Domain); 91] = [
    ("solver.step", Domain::Step),
    ("solver.steps_per_second", Domain::Rate),
    ("solver.substeps", Domain::Count(u32::MAX as u64, "from 1 to 4294967295, or \"auto\"")),
    ("solver.tolerance", Domain::UpTo(1.0, "positive and at most 1")),
    ("solver.newton", Domain::Count(MOST_NEWTON as u64, "from 1 to 1000")),
    ("world.gravity", Domain::Vector),
    ("world.force", Domain::Vector),
    ("world.drag", Domain::NotNegative),
    ("world.air.density", Domain::NotNegative),
    ("world.air.velocity", Domain::Vector),
    ("world.air.drag", Domain::NotNegative),
    ("world.air.lift", Domain::NotNegative),
    ("world.air.gust.strength", Domain::NotNegative),
    ("world.air.gust.length", LENGTH),
    ("world.air.gust.time", LENGTH),
    ("world.extent", LENGTH),
    ("world.planes.normal", Domain::Direction),
    ("world.planes.offset", Domain::Finite),
    ("world.planes.restitution", Domain::Fraction),
    ("world.planes.friction", Domain::Factor),
    ("world.planes.tangential_loss", Domain::Fraction),
    ("world.solids.radius", LENGTH),
    ("world.solids.length", LENGTH),
    ("world.solids.tube", LENGTH),
    ("world.solids.cell", LENGTH),
    ("world.solids.key_frames.time", Domain::Positive),
    ("world.solids.restitution", Domain::Fraction),
    ("world.solids.friction", Domain::Factor),
    ("world.solids.tangential_loss", Domain::Fraction),
    ("camera.yaw_deg", Domain::Finite),
    ("camera.pitch_deg", Domain::Elevation),
    ("camera.target", Domain::Place),
    ("camera.distance", LENGTH),
    ("bodies.spacing", Domain::Positive),
    ("bodies.length", Domain::Positive),
    ("bodies.bending", Domain::NotNegative),
    ("bodies.mass", Domain::Mass),
    ("bodies.stiffness", Domain::NotNegative),
    ("bodies.damping", Domain::NotNegative),
    ("bodies.young", Domain::Positive),
    ("bodies.poisson", Domain::Finite),
    ("bodies.density", Domain::Positive),
    ("bodies.relaxation_time", Domain::NotNegative),
    ("bodies.damping_ratio", Domain::NotNegative),
    ("bodies.thickness", Domain::Positive),
    ("bodies.area_density", Domain::Positive),
    ("bodies.young_warp", Domain::Positive),
    ("bodies.young_weft", Domain::Positive),
    ("bodies.shear", Domain::Positive),
    ("bodies.bending_warp", Domain::NotNegative),
    ("bodies.bending_weft", Domain::NotNegative),
    ("bodies.bending_bias", Domain::NotNegative),
    ("bodies.diameter", Domain::Positive),
    ("bodies.touch.thickness", LENGTH),
    ("bodies.touch.radius", LENGTH),
    ("bodies.touch.friction", Domain::Factor),
    ("bodies.touch.restitution", Domain::Fraction),
    ("bodies.touch.with.friction", Domain::Factor),
    ("bodies.touch.with.restitution", Domain::Fraction),
    ("bodies.look.roughness", Domain::Fraction),
    ("bodies.look.translucency", Domain::Fraction),
    ("bodies.look.pattern_size", LENGTH),
    ("bodies.position", Domain::Place),
    ("bodies.velocity", Domain::Vector),
    ("bodies.rotation.axis", Domain::Direction),
    ("bodies.rotation.angle_deg", Domain::Finite),
    ("bodies.spin.axis", Domain::Direction),
    ("bodies.spin.speed", Domain::Finite),
    ("bodies.particles.position", Domain::Place),
    ("bodies.particles.velocity", Domain::Vector),
    ("bodies.particles.mass", Domain::Mass),
    ("bodies.springs.rest_length", Domain::NotNegative),
    ("bodies.springs.stiffness", Domain::NotNegative),
    ("bodies.springs.damping", Domain::NotNegative),
    ("sets.box.position", Domain::Place),
    ("sets.sphere.position", Domain::Place),
    ("sets.sphere.radius", LENGTH),
    ("masses.mass", Domain::Mass),
    ("materials.stiffness", Domain::NotNegative),
    ("materials.damping", Domain::NotNegative),
    ("materials.young", Domain::Positive),
    ("materials.relaxation_time", Domain::NotNegative),
    ("links.within", Domain::Positive),
    ("links.rest_length", Domain::NotNegative),
    ("links.stiffness", Domain::NotNegative),
    ("links.damping", Domain::NotNegative),
    ("pins.every", Domain::Count(u64::MAX, "at least 1")),
    ("pins.velocity", Domain::Vector),
    // Of each of a list of numbers.
    ("sets.box.size", LENGTH),
    ("bodies.size", Domain::Count(u64::MAX, "at least 1")),
    ("version", Domain::Count(VERSION as u64, "1")),
];

impl Domain {
    /// The domain of a key, by its tables without the numbers of their rows.
    pub fn of(key: &str) -> Self {
        let row = DOMAINS.iter().find(|row| row.0 == key);
        debug_assert!(row.is_some(), "{key} has no domain");
        row.map_or(Domain::Finite, |row| row.1)
    }

    /// The domain in words.
    pub fn words(self) -> &'static str {
        match self {
            Domain::Positive => "positive and finite",
            Domain::Mass => "positive and finite, from 3e-39 in f32 and from 6e-309 in f64",
            Domain::Step => {
                "positive and at most 1e6; a substep from 4e-23 in f32 and from 3e-162 in f64"
            }
            Domain::Rate => {
                "finite and from 1e-6; a substep from 4e-23 s in f32 and from 3e-162 s in f64"
            }
            Domain::NotNegative => "finite and not negative",
            Domain::Factor => "finite and not negative, at most 3.4e38",
            Domain::Fraction => "from 0 to 1",
            Domain::Elevation => "from -89 to 89",
            Domain::Finite => "finite",
            Domain::UpTo(_, words) | Domain::Count(_, words) => words,
            Domain::Vector => "three finite numbers",
            Domain::Place => "inside the world",
            Domain::Direction => "three finite numbers, not all zero; any length",
        }
    }

    /// Whether a number lies in it, in a precision; of a vector, whether each component may.
    pub(crate) fn holds(self, value: f64, precision: Precision) -> bool {
        let is_single = precision == Precision::F32;
        match self {
            Domain::Positive => 0.0 < value && value.is_finite(),
            // Smaller ones have no finite reciprocal.
            Domain::Mass => value.is_finite() && if is_single { 3e-39 } else { 6e-309 } <= value,
            Domain::Step => {
                value <= LONGEST_STEP && if is_single { 4e-23 } else { 3e-162 } <= value
            }
            Domain::Rate => value.is_finite() && Domain::Step.holds(1.0 / value, precision),
            Domain::NotNegative => 0.0 <= value && value.is_finite(),
            Domain::Factor => 0.0 <= value && (value as f32).is_finite(),
            Domain::Fraction => (0.0..=1.0).contains(&value),
            Domain::Elevation => (-89.0..=89.0).contains(&value),
            Domain::UpTo(most, _) => 0.0 < value && value <= most,
            Domain::Count(most, _) => 1.0 <= value && value <= most as f64,
            Domain::Finite | Domain::Vector | Domain::Place | Domain::Direction => {
                value.is_finite()
            }
        }
    }
}

impl Source<'_> {
    /// Returns a number that must lie in the domain of its key.
    pub(crate) fn number(&self, key: Arguments<'_>, value: f64) -> Result<f64, FileError> {
        self.number_in(Domain::of(&without_rows(&key.to_string())), key, value)
    }

    /// Returns a number that must lie in a domain, looked up once for many rows.
    pub(crate) fn number_in(
        &self,
        domain: Domain,
        key: Arguments<'_>,
        value: f64,
    ) -> Result<f64, FileError> {
        if domain.holds(value, self.precision.get()) {
            return self.fitting(key, value);
        }
        Err(self.out_of_domain(key, plain(value), domain.words()))
    }

    /// Returns a whole number that must lie in the domain of its key.
    pub(crate) fn count(&self, key: Arguments<'_>, value: u64) -> Result<u64, FileError> {
        let domain = Domain::of(&without_rows(&key.to_string()));
        match domain {
            Domain::Count(most, _) if (1..=most).contains(&value) => Ok(value),
            _ => Err(self.out_of_domain(key, value, domain.words())),
        }
    }

    /// The error of a value outside its domain.
    pub fn out_of_domain(
        &self,
        key: Arguments<'_>,
        value: impl Display,
        expected: impl Into<String>,
    ) -> FileError {
        let (key, value) = (key.to_string(), value.to_string());
        let (value, expected) = (tame(&value), tame(&expected.into()));
        FileError::OutOfDomain { place: self.place_of(&key), key, value, expected }
    }

    /// The error of keys that do not fit together.
    pub(crate) fn refuse(&self, key: Arguments<'_>, reason: impl Display) -> FileError {
        let key = key.to_string();
        let reason = tame(&format!("{key} {reason}"));
        FileError::Malformed { place: self.place_of(&key), reason }
    }

    /// The error of a key that is not there.
    pub fn missing(&self, table: Arguments<'_>, key: &str) -> FileError {
        let table = table.to_string();
        FileError::MissingKey { place: self.place_of(&table), key: key.into(), table }
    }

    /// Returns a number that must be finite in the precision of the scene too.
    fn fitting(&self, key: Arguments<'_>, value: f64) -> Result<f64, FileError> {
        if self.precision.get() == Precision::F64 || (value as f32).is_finite() {
            return Ok(value);
        }
        let expected = "at most 3.4e38 to fit f32; precision = \"f64\" would hold it";
        Err(self.out_of_domain(key, plain(value), expected))
    }

    /// Returns a vector of finite numbers.
    pub(crate) fn vector(&self, key: Arguments<'_>, value: [f64; 3]) -> Result<DVec3, FileError> {
        for (row, component) in value.into_iter().enumerate() {
            self.number_in(Domain::Finite, format_args!("{key}[{row}]"), component)?;
        }
        Ok(DVec3::from_array(value))
    }

    /// Returns a position, which must lie inside the world.
    pub(crate) fn position(
        &self,
        key: Arguments<'_>,
        value: [f64; 3],
        extent: f64,
    ) -> Result<DVec3, FileError> {
        for (row, component) in value.into_iter().enumerate() {
            // False for a NaN too.
            let inside = component.abs() <= extent;
            if !inside {
                let expected = format!("finite and inside the world, at most {extent} away");
                return Err(self.out_of_domain(
                    format_args!("{key}[{row}]"),
                    plain(component),
                    expected,
                ));
            }
        }
        Ok(DVec3::from_array(value))
    }

    /// Returns a vector that has a direction, as one of length one.
    pub(crate) fn direction(
        &self,
        key: Arguments<'_>,
        value: [f64; 3],
    ) -> Result<DVec3, FileError> {
        let vector = self.vector(key, value)?;
        let largest = vector.abs().max_element();
        if largest == 0.0 {
            return Err(self.out_of_domain(key, "zero", "a vector that has a direction"));
        }
        // Divided by its largest component first: the square of a huge vector would not fit.
        let scaled = vector / largest;
        Ok(scaled / scaled.dot(scaled).sqrt())
    }

    /// Returns an index, which must name one of `count` things.
    pub(crate) fn index(
        &self,
        key: Arguments<'_>,
        index: impl TryInto<usize> + Copy + Display,
        (what, count): (&str, usize),
    ) -> Result<usize, FileError> {
        let found = index.try_into().ok().filter(|&index| index < count);
        found.ok_or_else(|| {
            let expected = match count {
                0 => format!("left out: there is no {what}"),
                1 => format!("from 0 to 0: there is 1 {what}"),
                _ if what == "body" => format!("from 0 to {}: there are {count} bodies", count - 1),
                _ => format!("from 0 to {}: there are {count} {what}s", count - 1),
            };
            self.out_of_domain(key, index, expected)
        })
    }
}

/// A key such as `bodies[2].mass` without the numbers of rows: `bodies.mass`.
pub(crate) fn without_rows(key: &str) -> String {
    let mut inside = false;
    let mut kept = |letter: &char| {
        inside = *letter == '[' || inside && *letter != ']';
        !inside && *letter != ']'
    };
    key.chars().filter(|letter| kept(letter)).collect()
}
