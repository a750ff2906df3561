//! The values that a grid gives a key: a list as it stands, or a range that is counted out.

use msd_scene::key::{Key, WRITTEN, shown};
use msd_scene::tree::{Node, Source, Value};
use msd_scene::{FileError, Place, plain};

/// The most values of one key, and cells of a grid.
pub(crate) const MAX_CELLS: usize = 100_000;

/// A key of a scene and the values it takes.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) key: Key,
    /// The byte of the sweep file at which the key was written, if that is known.
    pub(crate) offset: Option<usize>,
    /// Each value, and where it was written.
    pub(crate) values: Vec<(Value, Place)>,
}

const RANGE_KEYS: [&str; 5] = ["from", "to", "count", "scale", "whole"];
const EXPECTED: &str =
    "a list of values, or a range such as { from = 1, to = 100, count = 3, scale = \"log\" }";

/// A value of the grid on its way to an axis: its key in the sweep file, its place, and itself.
pub(crate) struct Entry<'n> {
    pub(crate) key: String,
    pub(crate) offset: Option<usize>,
    pub(crate) value: &'n Value,
}

impl Entry<'_> {
    fn place(&self, source: &Source<'_>) -> Place {
        source.place(self.offset)
    }

    fn refuse(&self, source: &Source<'_>, value: String, expected: impl Into<String>) -> FileError {
        let (place, key) = (self.place(source), format!("grid key {}", self.key));
        FileError::OutOfDomain { place, key, value, expected: expected.into() }
    }

    /// Adds the axes of this entry: one, or one for each key of a table.
    ///
    /// # Errors
    /// An unknown key, a value that is not a list or range, an empty list, a value given twice.
    pub(crate) fn add_to(
        &self,
        axes: &mut Vec<Axis>,
        source: &Source<'_>,
    ) -> Result<(), FileError> {
        match self.value {
            Value::Table(rows) if !rows.iter().any(|row| RANGE_KEYS.contains(&&*row.0)) => {
                for (name, offset, node) in rows {
                    let key = format!("{}.{name}", self.key);
                    Entry { key, offset: *offset, value: &node.value }.add_to(axes, source)?;
                }
                Ok(())
            }
            _ => {
                axes.push(self.axis(source)?);
                Ok(())
            }
        }
    }

    fn axis(&self, source: &Source<'_>) -> Result<Axis, FileError> {
        let Some(key) = Key::parse(&self.key) else {
            let reason = format!("grid key \"{}\" is not {}", self.key, WRITTEN);
            return Err(FileError::Malformed { place: self.place(source), reason });
        };
        let values = match self.value {
            Value::List(rows) if rows.is_empty() => {
                return Err(self.refuse(source, "an empty list".into(), EXPECTED));
            }
            Value::List(rows) => {
                let value = |row: &Node| (row.value.clone(), source.place(row.offset));
                rows.iter().map(value).collect()
            }
            Value::Table(rows) => {
                let place = self.place(source);
                let values = self.range(rows, source)?;
                values.into_iter().map(|value| (value, place.clone())).collect::<Vec<_>>()
            }
            other => return Err(self.refuse(source, shown(other), EXPECTED)),
        };
        if MAX_CELLS < values.len() {
            let value = format!("a list of {} values", values.len());
            return Err(self.refuse(source, value, format!("at most {MAX_CELLS} values")));
        }
        let mut seen = std::collections::BTreeSet::new();
        for (value, place) in &values {
            if !seen.insert(canonical(value)) {
                let is_number =
                    |row: &(Value, _)| matches!(row.0, Value::Whole(_) | Value::Number(_));
                // One vector was meant, not three numbers in turn.
                let vector = values.len() == 3 && values.iter().all(is_number);
                let hint = if vector { "; a list of vectors is [[x, y, z], ...]" } else { "" };
                let (key, value) = (&self.key, shown(value));
                let reason = format!("grid key {key} has the value {value} twice{hint}");
                return Err(FileError::Malformed { place: place.clone(), reason });
            }
        }
        Ok(Axis { key, offset: self.offset, values })
    }

    /// Counts out a range.
    fn range(
        &self,
        rows: &[(String, Option<usize>, Node)],
        source: &Source<'_>,
    ) -> Result<Vec<Value>, FileError> {
        for (name, offset, _) in rows {
            if !RANGE_KEYS.contains(&name.as_str()) {
                return Err(FileError::UnknownKey {
                    place: source.place(*offset),
                    key: name.clone(),
                    table: format!("the range of grid key {}", self.key),
                    hint: format!("the keys are {}", RANGE_KEYS.join(", ")),
                });
            }
        }
        let part = |name: &str| {
            let found = rows.iter().find(|row| row.0 == name);
            let (key, offset) = (format!("{}.{name}", self.key), found.and_then(|row| row.1));
            let value = found.map_or(&Value::Nothing, |row| &row.2.value);
            Entry { key, offset: offset.or(self.offset), value }
        };
        let log = match part("scale").value {
            Value::Nothing => false,
            Value::Text(scale) if scale == "linear" => false,
            Value::Text(scale) if scale == "log" => true,
            other => {
                let expected = "\"linear\" or \"log\"";
                return Err(part("scale").refuse(source, shown(other), expected));
            }
        };
        let end = |name| part(name).end(log, source);
        let (from, to) = (end("from")?, end("to")?);
        let count = match part("count").value {
            Value::Whole(count) if (2..=MAX_CELLS as i128).contains(count) => *count as usize,
            other => {
                let expected = format!("a whole number from 2 to {MAX_CELLS}");
                return Err(part("count").refuse(source, shown(other), expected));
            }
        };
        let whole = match part("whole").value {
            Value::Nothing => false,
            Value::Flag(flag) => *flag,
            other => return Err(part("whole").refuse(source, shown(other), "true or false")),
        };
        let is_whole = |name| matches!(part(name).value, Value::Whole(_));
        Ok(count_out((from, to, count), log, whole, is_whole("from") && is_whole("to")))
    }

    /// An end of a range.
    fn end(&self, log: bool, source: &Source<'_>) -> Result<f64, FileError> {
        let number = match self.value {
            Value::Whole(number) => *number as f64,
            Value::Number(number) => *number,
            other => return Err(self.refuse(source, shown(other), "a number")),
        };
        match number {
            _ if !number.is_finite() => Err(self.refuse(source, plain(number), "finite")),
            _ if log && number <= 0.0 => {
                Err(self.refuse(source, plain(number), "positive where scale is \"log\""))
            }
            _ => Ok(number),
        }
    }
}

/// The values of a range. They are whole numbers where `whole` asks for it, or where the ends were
/// written as whole numbers and every value comes out as one.
fn count_out(
    (from, to, count): (f64, f64, usize),
    log: bool,
    whole: bool,
    ends_whole: bool,
) -> Vec<Value> {
    let value = |row: usize| {
        let part = row as f64 / (count - 1) as f64;
        match row {
            0 => from,
            _ if row == count - 1 => to,
            _ if log => tidy(libm::exp(libm::log(from) * (1.0 - part) + libm::log(to) * part)),
            _ => tidy(from * (1.0 - part) + to * part),
        }
    };
    let mut values: Vec<f64> = (0..count).map(value).collect();
    if whole {
        values.iter_mut().for_each(|value| *value = value.round());
        values.dedup();
    }
    // Beyond 2^53 not every whole number is one of these.
    let fits = values.iter().all(|value| value.fract() == 0.0 && value.abs() < 9e15);
    if fits && (whole || ends_whole) {
        return values.into_iter().map(|value| Value::Whole(value as i128)).collect();
    }
    values.into_iter().map(Value::Number).collect()
}

/// Rounds to twelve digits, so that 10 to the second is 100 and no less.
fn tidy(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

/// The same bytes for values that mean the same: 1 and 1.0, tables in any order of their keys.
pub(crate) fn canonical(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    add_canonical(value, &mut bytes);
    bytes
}

fn add_canonical(value: &Value, bytes: &mut Vec<u8>) {
    let mut add_text = |tag: u8, text: &[u8]| {
        bytes.push(tag);
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text);
    };
    match value {
        Value::Nothing | Value::Any => bytes.push(b'0'),
        Value::Flag(flag) => bytes.extend([b'f', u8::from(*flag)]),
        // A whole number beyond 2^53 keeps its value.
        Value::Whole(number) if (*number as f64) as i128 != *number => {
            add_text(b'w', &number.to_le_bytes());
        }
        Value::Whole(number) => add_text(b'n', &(*number as f64).to_bits().to_le_bytes()),
        Value::Number(number) => add_text(b'n', &number.to_bits().to_le_bytes()),
        Value::Text(text) => add_text(b't', text.as_bytes()),
        Value::List(rows) => {
            add_text(b'l', &(rows.len() as u64).to_le_bytes());
            rows.iter().for_each(|row| add_canonical(&row.value, bytes));
        }
        Value::Table(rows) => {
            add_text(b'm', &(rows.len() as u64).to_le_bytes());
            let mut rows: Vec<_> = rows.iter().map(|row| (&row.0, &row.2.value)).collect();
            rows.sort_by_key(|row| row.0);
            for (name, value) in rows {
                add_canonical(&Value::Text(name.clone()), bytes);
                add_canonical(value, bytes);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(range: (f64, f64, usize), log: bool, whole: bool, ends: bool) -> Vec<String> {
        count_out(range, log, whole, ends).iter().map(shown).collect()
    }

    #[test]
    fn a_range_meets_its_ends_and_has_tidy_values() {
        assert_eq!(counted((0.0, 1.0, 5), false, false, true), ["0", "0.25", "0.5", "0.75", "1"]);
        let decades = ["100", "1000", "10000", "100000", "1000000"];
        assert_eq!(counted((1e2, 1e6, 5), true, false, false), decades);
        assert_eq!(counted((2.0, 64.0, 6), true, false, true), ["2", "4", "8", "16", "32", "64"]);
    }

    #[test]
    fn whole_numbers_are_whole_where_that_was_meant() {
        let all_whole =
            |values: Vec<Value>| values.iter().all(|value| matches!(value, Value::Whole(_)));
        assert!(all_whole(count_out((2.0, 64.0, 6), true, false, true)));
        assert!(!all_whole(count_out((2.0, 64.0, 6), true, false, false)));
        assert!(!all_whole(count_out((1.0, 2.0, 3), false, false, true)));
        assert_eq!(counted((1.0, 10.0, 6), true, true, true), ["1", "2", "3", "4", "6", "10"]);
        assert_eq!(counted((1.0, 3.0, 9), false, true, true), ["1", "2", "3"]);
    }

    #[test]
    fn values_that_mean_the_same_have_the_same_bytes() {
        assert_eq!(canonical(&Value::Whole(4)), canonical(&Value::Number(4.0)));
        assert_ne!(canonical(&Value::Whole(4)), canonical(&Value::Text("4".into())));
        assert_ne!(canonical(&Value::Whole((1 << 53) + 1)), canonical(&Value::Whole(1 << 53)));
        let row = |name: &str, number| {
            (name.to_string(), None, Node { value: Value::Whole(number), offset: None })
        };
        let one = Value::Table(vec![row("a", 1), row("b", 2)]);
        let other = Value::Table(vec![row("b", 2), row("a", 1)]);
        assert_eq!(canonical(&one), canonical(&other));
    }
}
