//! Values that keys of a scene are given in place of those in its file.

use super::key::{Key, WRITTEN, shown};
use super::{Node, Source, Value, read_toml_value};
use crate::error::{FileError, Place, one_line};
use crate::shown::tame;
use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Keys of a scene with the values that were set, in the order in which they were set.
pub type SetKeys = serde_json::Map<String, serde_json::Value>;

/// The keys that assignments set, for a report.
pub fn set_keys(assignments: &[Assignment]) -> SetKeys {
    let value = |set: &Assignment| serde_json::to_value(set.value()).unwrap_or_default();
    assignments.iter().map(|set| (set.key().into(), value(set))).collect()
}

/// A key of a scene and the value that it is given, as the command line writes it:
/// `world.gravity=[0,-1.62,0]`. Nothing as the value leaves the key out.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    key: Key,
    value: Value,
}

impl Assignment {
    /// A value of a key such as `bodies[0].mass`.
    ///
    /// # Panics
    /// If the key is not written as one, or the value is not one of a scene file.
    pub fn new(key: &str, value: impl Serialize) -> Self {
        let text = serde_json::to_string(&value).expect("a value that JSON has");
        Assignment::from_json(key, &text).expect("a key and its value")
    }

    fn from_json(key: &str, value: &str) -> Option<Self> {
        let node: Node = serde_json::from_str(value).ok()?;
        Some(Assignment { key: Key::parse(key)?, value: node.value })
    }

    /// Reads `KEY=VALUE`, the value as TOML has it. A word that is not a value there and does not
    /// begin like one is a text, so that a shell needs no quotes within quotes:
    /// `solver.integrator=rk4`.
    ///
    /// # Errors
    /// The expected form, in words. The key and the domain of the value are checked when the scene
    /// is understood.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("must be KEY=VALUE, such as world.gravity=[0,-1.62,0]")?;
        let key = Key::parse(key.trim()).ok_or_else(|| format!("must begin with {WRITTEN}"))?;
        let value = value.trim();
        let read = read_toml_value(value);
        let is_word = !value.is_empty()
            && !value.starts_with(['[', '{', '"', '\''])
            && !value.chars().any(char::is_control);
        let value = match read {
            Err(_) if is_word => Value::Text(value.into()),
            read => read.map_err(|reason| {
                format!("must have a value as in a scene file: {}", one_line(reason))
            })?,
        };
        Ok(Assignment { key, value })
    }

    /// The key from the top, as a message names it.
    pub fn key(&self) -> &str {
        self.key.text()
    }

    /// The value.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// The name of the key in its table.
    pub fn name(&self) -> &str {
        self.key.name()
    }

    /// The number of the first row on the way to the key; none of a key of all rows.
    pub fn row(&self) -> Option<usize> {
        self.key.row()
    }

    /// Whether it is void once another key is set.
    pub(in crate::file) fn is_void_by(&self, key: &Key) -> bool {
        key.covers(&self.key)
    }

    /// Puts the value in its place.
    pub(crate) fn apply(&self, source: &mut Source<'_>) -> Result<(), FileError> {
        let set = self.key.set(&mut source.root, self.value.clone());
        set.map_err(|reason| FileError::Malformed { place: self.place(), reason })
    }

    /// The place of the value where it is of this key, as a message names it.
    pub(crate) fn place_of(&self, key: &str) -> Option<Place> {
        self.key.concerns(key).then(|| self.place())
    }

    fn place(&self) -> Place {
        Place { file: format!("--set {}", self.key()), position: None }
    }
}

impl fmt::Display for Assignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}", self.key(), tame(&shown(&self.value)))
    }
}

impl Serialize for Assignment {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let value = serde_json::to_string(&self.value).map_err(serde::ser::Error::custom)?;
        serializer.serialize_str(&format!("{}={value}", self.key()))
    }
}

impl<'de> Deserialize<'de> for Assignment {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let (key, value) = text.split_once('=').unwrap_or_default();
        Assignment::from_json(key, value).ok_or_else(|| Error::custom("not a key and a value"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_that_of_a_scene_file_and_a_word_needs_no_quotes() {
        let read = |text| Assignment::parse(text).expect(text).to_string();
        assert_eq!(read("world.gravity=[0,-1.62,0]"), "world.gravity = [0, -1.62, 0]");
        assert_eq!(read("bodies.0.mass = 1e-3"), "bodies[0].mass = 0.001");
        assert_eq!(read("solver.integrator=rk4"), "solver.integrator = \"rk4\"");
        assert_eq!(read("bodies.0.material=gelatine-5%"), "bodies[0].material = \"gelatine-5%\"");
        assert_eq!(read("title='a = b'"), "title = \"a = b\"");
        assert_eq!(read("pins=[{particle=3}]"), "pins = [{particle: 3}]");
        assert_eq!(read("a=true"), "a = true");
    }

    #[test]
    fn what_is_no_assignment_is_told_what_it_must_be() {
        let told = |text| Assignment::parse(text).expect_err(text);
        assert_eq!(told("world"), "must be KEY=VALUE, such as world.gravity=[0,-1.62,0]");
        assert!(told("=3").starts_with("must begin with a key of a scene"), "{}", told("=3"));
        for text in ["a=", "a=[1,", "a={b", "a=\"c", "a=1\nb=2]", "a=[1]\nb=2"] {
            let told = told(text);
            assert!(told.starts_with("must have a value as in a scene file: "), "{told}");
            assert!(!told.contains('\n'), "{told}");
        }
    }
}
