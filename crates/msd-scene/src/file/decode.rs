//! Rows from a tree of values, by serde, with errors that name the key from the top and the nearest
//! valid one.

use crate::error::{FileError, nearest, plain};
use crate::file::tree::key::Step;
use crate::file::tree::{Node, Source, Value};
use crate::shown::tame;
use serde::de::value::{MapDeserializer, SeqDeserializer, StrDeserializer};
use serde::de::{self, DeserializeOwned, DeserializeSeed, Expected, IntoDeserializer, Unexpected};
use serde::forward_to_deserialize_any;
use std::fmt::{self, Display};
use std::iter::repeat_n;

/// Reads rows from a source.
///
/// # Errors
/// An unknown or missing key, or a value of the wrong kind.
pub fn decode<T: DeserializeOwned>(source: &Source<'_>) -> Result<T, FileError> {
    T::deserialize(&source.root).map_err(|error| error.explain(source))
}

/// The first mistake in the rows of a source, mended in its tree so that the next can be found.
pub(crate) fn mend<T: DeserializeOwned>(source: &mut Source<'_>) -> Option<FileError> {
    let failure = T::deserialize(&source.root).err()?;
    let mut node = &mut source.root;
    for step in failure.path.iter().rev() {
        node = match (step, &mut node.value) {
            (Step::Key(key), Value::Table(rows)) => {
                &mut rows.iter_mut().find(|row| row.0 == *key)?.2
            }
            (Step::Row(row), Value::List(rows)) => rows.get_mut(*row)?,
            _ => return None,
        };
    }
    match (&failure.reason, &mut node.value) {
        (Reason::UnknownKey { key, .. }, Value::Table(rows)) => rows.retain(|row| row.0 != *key),
        (Reason::MissingKey(key), Value::Table(rows)) => {
            rows.push(((*key).into(), None, ANY));
        }
        (_, value) => *value = Value::Any,
    }
    Some(failure.explain(source))
}

/// The names that an enum is written by.
pub(crate) fn names_of<T: DeserializeOwned>() -> &'static [&'static str] {
    // The refusal of a name that no variant has lists those that there are.
    match T::deserialize(&Node { value: Value::Text(String::new()), offset: None }) {
        Err(Failure { reason: Reason::UnknownName { known, .. }, .. }) => known,
        _ => &[],
    }
}

/// The placeholder of a value that was refused.
const ANY: Node = Node { value: Value::Any, offset: None };

/// A fault, and the path to it, innermost step first.
#[derive(Debug)]
pub struct Failure {
    reason: Reason,
    path: Vec<Step>,
    offset: Option<usize>,
}

#[derive(Debug)]
enum Reason {
    UnknownKey { key: String, known: &'static [&'static str] },
    MissingKey(&'static str),
    UnknownName { name: String, known: &'static [&'static str] },
    Value { value: String, expected: String },
    Other(String),
}

impl Failure {
    fn new(reason: Reason) -> Self {
        Failure { reason, path: Vec::new(), offset: None }
    }

    fn inside(mut self, step: Step, offset: Option<usize>) -> Self {
        // The key of an unknown key is its own place, not a step on the way to it.
        self.path.push(step);
        self.offset = self.offset.or(offset);
        self
    }

    fn explain(self, source: &Source<'_>) -> FileError {
        let mut key = String::new();
        for step in self.path.iter().rev() {
            match step {
                Step::Key(name) if key.is_empty() => key.push_str(name),
                Step::Key(name) => key.extend([".", name]),
                Step::Row(row) => key.push_str(&format!("[{row}]")),
            }
        }
        let place = source.place(self.offset);
        let table = if key.is_empty() { "the scene".into() } else { tame(&key) };
        match self.reason {
            Reason::UnknownKey { key, known } => {
                let hint = suggestion(&key, known, ALL_KEYS);
                FileError::UnknownKey { place, key: tame(&key), table, hint }
            }
            Reason::MissingKey(key) => FileError::MissingKey { place, key: key.into(), table },
            Reason::UnknownName { name, known } => {
                let mut expected = format!("one of {}", known.join(", "));
                if let Some(near) = nearest(&name, known.iter().copied()) {
                    expected.push_str(&format!("; did you mean `{near}`?"));
                }
                let value = tame(&format!("\"{name}\""));
                FileError::OutOfDomain { place, key: table, value, expected }
            }
            Reason::Value { value, expected } => {
                FileError::OutOfDomain { place, key: table, value: tame(&value), expected }
            }
            Reason::Other(reason) => FileError::Malformed { place, reason: tame(&reason) },
        }
    }
}

/// The beginning of the list of all keys of a table.
pub(crate) const ALL_KEYS: &str = "the keys are";

/// The nearest of some names, or all of them.
fn suggestion(written: &str, known: &[&'static str], all: &str) -> String {
    match nearest(written, known.iter().copied()) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("{all} {}", known.join(", ")),
    }
}

impl std::error::Error for Failure {}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.reason)
    }
}

impl de::Error for Failure {
    fn custom<T: Display>(message: T) -> Self {
        Failure::new(Reason::Other(message.to_string()))
    }

    fn invalid_type(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let mut expected = in_words(&expected.to_string());
        let whole =
            matches!(unexpected, Unexpected::Float(n) if n.fract() == 0.0 && n.abs() < 1e15);
        if whole && expected.starts_with("a whole number") {
            expected = "a whole number, without a point or an exponent".into();
        }
        let is_negative = matches!(unexpected, Unexpected::Signed(n) if n < 0);
        if is_negative && expected.starts_with("a whole number from 0") {
            expected = "a whole number, not negative".into();
        }
        let value = shown(unexpected);
        Failure::new(Reason::Value { value, expected })
    }

    fn invalid_value(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(unexpected, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        let value = format!("a list of {length}");
        Failure::new(Reason::Value { value, expected: in_words(&expected.to_string()) })
    }

    fn unknown_variant(variant: &str, known: &'static [&'static str]) -> Self {
        Failure::new(Reason::UnknownName { name: variant.into(), known })
    }

    fn unknown_field(key: &str, known: &'static [&'static str]) -> Self {
        Failure::new(Reason::UnknownKey { key: key.into(), known })
    }

    fn missing_field(key: &'static str) -> Self {
        Failure::new(Reason::MissingKey(key))
    }
}

fn shown(value: Unexpected<'_>) -> String {
    match value {
        Unexpected::Bool(flag) => flag.to_string(),
        Unexpected::Unsigned(number) => number.to_string(),
        Unexpected::Signed(number) => number.to_string(),
        // With its point, where a whole number is expected.
        Unexpected::Float(number) => format!("{number:?}"),
        Unexpected::Str(text) => format!("\"{text}\""),
        Unexpected::Unit | Unexpected::Option => "null".into(),
        Unexpected::Seq => "a list".into(),
        Unexpected::Map => "a table".into(),
        other => other.to_string(),
    }
}

/// Puts an expectation of serde, which is for programmers, into words for a user.
fn in_words(expected: &str) -> String {
    let words = match expected {
        "u32" => "a whole number from 0 to 4294967295",
        "u64" | "usize" => "a whole number from 0 to 18446744073709551615",
        "i32" | "i64" => "a whole number",
        "f64" => "a number",
        "a boolean" => "true or false",
        "a string" => "text in quotes",
        "a sequence" => "a list",
        "an array of length 2" => "a list of two whole numbers",
        "an array of length 3" => "a list of three numbers",
        other if other.starts_with("struct ") => "a table",
        other if other.contains("enum") => "text in quotes",
        other => other,
    };
    words.into()
}

impl Node {
    fn shown(&self) -> String {
        match &self.value {
            Value::Nothing => "null".into(),
            Value::Any => "any value".into(),
            Value::Flag(flag) => flag.to_string(),
            Value::Whole(number) => number.to_string(),
            Value::Number(number) => plain(*number),
            Value::Text(text) => format!("\"{text}\""),
            Value::List(_) => "a list".into(),
            Value::Table(_) => "a table".into(),
        }
    }
}

impl<'de> de::Deserializer<'de> for &'de Node {
    type Error = Failure;

    fn deserialize_any<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        let result = match &self.value {
            Value::Nothing => visitor.visit_unit(),
            Value::Any => visitor.visit_u64(1),
            Value::Flag(flag) => visitor.visit_bool(*flag),
            Value::Whole(number) => match (u64::try_from(*number), i64::try_from(*number)) {
                (Ok(number), _) => visitor.visit_u64(number),
                (_, Ok(number)) => visitor.visit_i64(number),
                _ => visitor.visit_f64(*number as f64),
            },
            Value::Number(number) => visitor.visit_f64(*number),
            Value::Text(text) => visitor.visit_borrowed_str(text),
            Value::List(rows) => {
                let mut list = List { rows, next: 0 };
                let value = visitor.visit_seq(&mut list);
                value.and_then(|value| list.finish(value))
            }
            Value::Table(rows) => visitor.visit_map(Table { rows, next: 0 }),
        };
        result.map_err(|failure| Failure { offset: failure.offset.or(self.offset), ..failure })
    }

    fn deserialize_option<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.value {
            Value::Nothing | Value::Any => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_enum<V: de::Visitor<'de>>(
        self,
        _name: &'static str,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        let any = || known.first().copied().filter(|_| matches!(self.value, Value::Any));
        let text = match &self.value {
            Value::Text(text) => Some(text.as_str()),
            _ => any(),
        };
        let Some(text) = text else {
            let (value, expected) = (self.shown(), format!("one of {}", known.join(", ")));
            return Err(Failure::new(Reason::Value { value, expected }));
        };
        let variant: StrDeserializer<'_, Failure> = text.into_deserializer();
        visitor.visit_enum(variant)
    }

    fn deserialize_struct<V: de::Visitor<'de>>(
        self,
        _name: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Failure> {
        // A list would be taken for the values of its keys, in order.
        if matches!(self.value, Value::Table(_)) {
            return self.deserialize_any(visitor);
        }
        if matches!(self.value, Value::Any) {
            let rows = keys.iter().map(|key| (*key, &ANY));
            return visitor.visit_map(MapDeserializer::new(rows));
        }
        let expected = match keys.len() {
            ..=3 => format!("a table with the keys {}", keys.join(", ")),
            _ => "a table".into(),
        };
        Err(Failure::new(Reason::Value { value: self.shown(), expected }))
    }

    fn deserialize_tuple<V: de::Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Failure> {
        match self.value {
            Value::Any => visitor.visit_seq(SeqDeserializer::new(repeat_n(1_u64, length))),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_seq<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.value {
            Value::Any => visitor.visit_seq(SeqDeserializer::new(repeat_n(1_u64, 0))),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_string<V: de::Visitor<'de>>(self, visitor: V) -> Result<V::Value, Failure> {
        match self.value {
            Value::Any => visitor.visit_str(""),
            _ => self.deserialize_any(visitor),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str bytes byte_buf unit
        unit_struct newtype_struct tuple_struct map identifier ignored_any
    }
}

impl<'de> IntoDeserializer<'de, Failure> for &'de Node {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

struct List<'de> {
    rows: &'de [Node],
    next: usize,
}

impl List<'_> {
    /// A visitor of fixed length stops early: further elements are refused.
    fn finish<T>(&self, value: T) -> Result<T, Failure> {
        if self.next == self.rows.len() {
            return Ok(value);
        }
        let expected = match self.next {
            1 => "a list of one",
            // Only the ends of a spring are two.
            2 => "a list of two whole numbers",
            _ => "a list of three numbers",
        };
        Err(de::Error::invalid_length(self.rows.len(), &expected))
    }
}

impl<'de> de::SeqAccess<'de> for &mut List<'de> {
    type Error = Failure;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Failure> {
        let Some(node) = self.rows.get(self.next) else { return Ok(None) };
        let row = self.next;
        self.next += 1;
        let value = seed.deserialize(node);
        value.map(Some).map_err(|failure| failure.inside(Step::Row(row), node.offset))
    }
}

struct Table<'de> {
    rows: &'de [(String, Option<usize>, Node)],
    next: usize,
}

impl<'de> de::MapAccess<'de> for Table<'de> {
    type Error = Failure;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Failure> {
        let Some((key, offset, _)) = self.rows.get(self.next) else { return Ok(None) };
        let name: StrDeserializer<'_, Failure> = key.as_str().into_deserializer();
        let value = seed.deserialize(name);
        value.map(Some).map_err(|failure| Failure { offset: *offset, ..failure })
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Failure> {
        let (key, _, node) = &self.rows[self.next];
        self.next += 1;
        let value = seed.deserialize(node);
        value.map_err(|failure| failure.inside(Step::Key(key.clone()), node.offset))
    }
}
