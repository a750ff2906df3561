//! Checks of values against the domains of their keys, and the words of refusals.

use crate::error::{FileError, plain};
use crate::file::keys::{Domain, KeyRow, without_rows};
use crate::file::schema::find;
use crate::file::tree::{Source, Value};
use crate::precision::Precision;
use crate::shown::tame;
use glam::DVec3;
use std::fmt::{Arguments, Display};

/// The domain of a key, by its tables with or without the numbers of their rows.
pub(crate) fn domain_of(key: &str) -> Domain {
    let row = find(&without_rows(key));
    debug_assert!(row.is_some(), "{key} is in no table");
    row.map_or(Domain::Finite, |row| row.domain)
}

impl Source<'_> {
    /// Returns a number that must lie in the domain of its key.
    pub(crate) fn number(&self, key: Arguments<'_>, value: f64) -> Result<f64, FileError> {
        self.number_in(domain_of(&key.to_string()), key, value)
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
        let domain = domain_of(&key.to_string());
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

impl Source<'_> {
    /// Refuses keys of the table at `path` that its `kind` does not use, and those that it lacks.
    ///
    /// # Errors
    /// The first of them, in the order of the file.
    pub(crate) fn check_kind(&self, path: &str) -> Result<(), FileError> {
        let node = self.walk(path).last().flatten();
        let Some(Value::Table(written)) = node.map(|node| &node.value) else { return Ok(()) };
        let value = |name| written.iter().find(|row| row.0 == name).map(|row| &row.2.value);
        let Some(Value::Text(kind)) = value("kind") else { return Ok(()) };
        let table = find(&without_rows(path)).and_then(|row| row.form.table());
        let keys = table.map_or(&[][..], |table| table.keys);
        let noun = match kind.starts_with('e') {
            true => format!("an {kind} body"),
            false => format!("a {kind}"),
        };
        for (name, _, node) in written {
            let Some(row) = keys.iter().find(|row| row.name == *name) else { continue };
            // As if they were left out.
            let is_empty = matches!(&node.value, Value::List(rows) if rows.is_empty());
            if !row.is_of(kind) && !is_empty && !matches!(node.value, Value::Nothing) {
                let reason = format!("does not apply to {noun}, only to {}", row.kinds.join(", "));
                return Err(self.refuse(format_args!("{path}.{name}"), reason));
            }
        }
        let lacks = |row: &&KeyRow| matches!(value(row.name), None | Some(Value::Nothing));
        match keys.iter().filter(|row| row.needed.contains(&kind.as_str())).find(lacks) {
            Some(row) => {
                let reason = format!("lacks the key `{}`: {noun} needs it", row.name);
                Err(self.refuse(format_args!("{path}"), reason))
            }
            None => Ok(()),
        }
    }
}
