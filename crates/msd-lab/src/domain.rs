//! Does a number of a scene file lie in its domain? If not, which key holds it?

use crate::error::{LabError, plain};
use crate::node::Source;
use crate::runner::Precision;
use glam::DVec3;
use std::fmt::{Arguments, Display};

impl Source<'_> {
    /// The error of a value outside its domain.
    pub(crate) fn out_of_domain(
        &self,
        key: Arguments<'_>,
        value: impl Display,
        expected: impl Into<String>,
    ) -> LabError {
        let (key, value) = (key.to_string(), value.to_string());
        LabError::OutOfDomain { place: self.place_of(&key), key, value, expected: expected.into() }
    }

    /// The error of keys that do not fit together.
    pub(crate) fn refuse(&self, key: Arguments<'_>, reason: impl Display) -> LabError {
        let key = key.to_string();
        LabError::Malformed { place: self.place_of(&key), reason: format!("{key} {reason}") }
    }

    /// The error of a key that is not there.
    pub(crate) fn missing(&self, table: Arguments<'_>, key: &str) -> LabError {
        let table = table.to_string();
        LabError::MissingKey { place: self.place_of(&table), key: key.into(), table }
    }

    /// Returns a number that must be positive and finite.
    pub(crate) fn positive(&self, key: Arguments<'_>, value: f64) -> Result<f64, LabError> {
        if 0.0 < value && value.is_finite() {
            return self.fitting(key, value);
        }
        Err(self.out_of_domain(key, plain(value), "positive and finite"))
    }

    /// Returns a number that must be finite and not negative.
    pub(crate) fn not_negative(&self, key: Arguments<'_>, value: f64) -> Result<f64, LabError> {
        if 0.0 <= value && value.is_finite() {
            return self.fitting(key, value);
        }
        Err(self.out_of_domain(key, plain(value), "finite and not negative"))
    }

    /// Returns a number that must lie from 0 to 1.
    pub(crate) fn fraction(&self, key: Arguments<'_>, value: f64) -> Result<f64, LabError> {
        if (0.0..=1.0).contains(&value) {
            return Ok(value);
        }
        Err(self.out_of_domain(key, plain(value), "from 0 to 1"))
    }

    /// Returns a number that must be finite.
    pub(crate) fn finite(&self, key: Arguments<'_>, value: f64) -> Result<f64, LabError> {
        if value.is_finite() {
            return self.fitting(key, value);
        }
        Err(self.out_of_domain(key, plain(value), "finite"))
    }

    /// Returns a number that must be finite in the precision of the scene too.
    fn fitting(&self, key: Arguments<'_>, value: f64) -> Result<f64, LabError> {
        if self.precision.get() == Precision::F64 || (value as f32).is_finite() {
            return Ok(value);
        }
        let expected = "at most 3.4e38 to fit f32; precision = \"f64\" would hold it";
        Err(self.out_of_domain(key, plain(value), expected))
    }

    /// Returns a vector of finite numbers.
    pub(crate) fn vector(&self, key: Arguments<'_>, value: [f64; 3]) -> Result<DVec3, LabError> {
        for (row, component) in value.into_iter().enumerate() {
            self.finite(format_args!("{key}[{row}]"), component)?;
        }
        Ok(DVec3::from_array(value))
    }

    /// Returns a position, which must lie inside the world.
    pub(crate) fn position(
        &self,
        key: Arguments<'_>,
        value: [f64; 3],
        extent: f64,
    ) -> Result<DVec3, LabError> {
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
    pub(crate) fn direction(&self, key: Arguments<'_>, value: [f64; 3]) -> Result<DVec3, LabError> {
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
        index: u64,
        (what, count): (&str, usize),
    ) -> Result<usize, LabError> {
        let found = usize::try_from(index).ok().filter(|&index| index < count);
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
