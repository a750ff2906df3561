//! Trees of values that remember where they were written, the same for TOML and JSON.

pub(in crate::file) mod text;
pub mod key;
mod assignment;

pub use assignment::{Assignment, SetKeys, set_keys};

use crate::error::{FileError, Place, one_line};
use crate::file::tree::text::SceneFormat;
use crate::precision::Precision;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt;
use toml::de::{DeTable, DeValue};

/// A value and the byte at which it was written, if that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// The byte.
    pub offset: Option<usize>,
}

/// A value as written.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A null of JSON.
    Nothing,
    /// Any value that its key may have, in place of one that was refused.
    Any,
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i128),
    /// Any other number.
    Number(f64),
    /// A text.
    Text(String),
    /// Values in a row.
    List(Vec<Node>),
    /// Keys with the byte at which they were written, and their values.
    Table(Vec<(String, Option<usize>, Node)>),
}

/// A scene file as text and as a tree.
#[derive(Clone)]
pub struct Source<'t> {
    /// The user's name of the file.
    pub name: &'t str,
    pub(in crate::file) text: &'t str,
    /// The tree.
    pub root: Node,
    /// The precision that the scene asks for, once that is known: its numbers must fit.
    pub precision: Cell<Precision>,
    /// The height above the ground from which its bodies drop, metres; `None` where they start at
    /// places of their own.
    pub drop: Option<f64>,
}

impl<'t> Source<'t> {
    /// Reads a text.
    ///
    /// # Errors
    /// [`FileError::Malformed`] where the text does not follow the format;
    /// [`FileError::Unreadable`] where reading it would take too much memory.
    pub fn parse(text: &'t str, format: SceneFormat, name: &'t str) -> Result<Self, FileError> {
        check_memory(text, format, name)?;
        let root = match format {
            SceneFormat::Toml => read_toml(text, name)?,
            SceneFormat::Json => read_json(text, name)?,
        };
        Ok(Source { name, text, root, precision: Cell::new(Precision::F64), drop: None })
    }

    /// A scene that was not read from a text.
    pub(in crate::file) fn of(root: Node, name: &'t str) -> Self {
        Source { name, text: "", root, precision: Cell::new(Precision::F64), drop: None }
    }

    /// The place of a byte.
    pub fn place(&self, offset: Option<usize>) -> Place {
        place(self.name, self.text, offset)
    }

    /// The place of the value at a path such as `bodies[2].stiffness`, or of the nearest value
    /// around it that was written.
    pub fn place_of(&self, path: &str) -> Place {
        let offset = self.walk(path).filter_map(|node| node?.offset).last();
        self.place(offset)
    }

    /// Whether a value was written at a path.
    pub fn holds(&self, path: &str) -> bool {
        self.walk(path).all(|node| node.is_some())
    }

    /// The values along a path, then `None` if it goes on.
    pub(in crate::file) fn walk(&self, path: &str) -> impl Iterator<Item = Option<&Node>> {
        let mut node = Some(&self.root);
        let steps = path.split(['.', '[', ']']).filter(|step| !step.is_empty());
        steps.map(move |step| {
            node = match &node?.value {
                Value::Table(rows) => rows.iter().find(|row| row.0 == step).map(|row| &row.2),
                Value::List(rows) => step.parse().ok().and_then(|row: usize| rows.get(row)),
                _ => None,
            };
            node
        })
    }
}

/// The most memory that reading a text may take, bytes, by the estimate below.
const MOST_MEMORY: u64 = 1_500_000_000;

/// Refuses a text that has so many values that reading them would fill a small machine.
fn check_memory(text: &str, format: SceneFormat, name: &str) -> Result<(), FileError> {
    let bytes = match format {
        SceneFormat::Toml => toml_memory(text),
        SceneFormat::Json => json_memory(text),
    };
    if bytes <= MOST_MEMORY {
        return Ok(());
    }
    let gigabytes = |bytes: u64| bytes as f64 * 1e-9;
    let reason = format!(
        "it has so many values that reading them would take about {:.1} GB; at most {} GB may be \
         taken",
        gigabytes(bytes),
        gigabytes(MOST_MEMORY)
    );
    Err(FileError::Unreadable { file: name.into(), reason })
}

/// Memory to read a TOML text, bytes, by measurements of texts of one kind of row. A value and its
/// tokens take about 160, a list 300, a line 50, and a table, whose keys stand in a tree with room
/// for eleven, 1500; a dot in a key is a table.
fn toml_memory(text: &str) -> u64 {
    let (mut bytes, mut dots) = (0, 0);
    for byte in text.bytes() {
        bytes += match byte {
            b',' => 160,
            b'[' => 300,
            b'{' => 1500,
            b'\n' => 50,
            b'=' => 60 + 1400 * dots,
            _ => 0,
        };
        match byte {
            b'.' => dots += 1,
            b',' | b'[' | b'{' | b'\n' | b'=' => dots = 0,
            _ => {}
        }
    }
    bytes
}

/// Memory to read a JSON text, bytes, likewise: a value takes about 100, a list 260, a table 500
/// and a key of it 200.
fn json_memory(text: &str) -> u64 {
    let cost = |byte| match byte {
        b',' => 100,
        b'[' => 260,
        b'{' => 500,
        b':' => 200,
        _ => 0,
    };
    text.bytes().map(cost).sum()
}

fn place(file: &str, text: &str, offset: Option<usize>) -> Place {
    let before = offset.and_then(|offset| text.get(..offset));
    let position = before.map(|before| {
        let line = before.matches('\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (short(line), short(before[start..].chars().count() + 1))
    });
    Place { file: file.into(), position }
}

/// A count of lines or columns; texts are far shorter than the limit.
fn short(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

fn read_toml(text: &str, name: &str) -> Result<Node, FileError> {
    let table = DeTable::parse(text).map_err(|error| {
        let place = place(name, text, error.span().map(|span| span.start));
        let key = error.span().and_then(|span| text.get(span));
        let reason = match (error.message(), key) {
            ("duplicate key", Some(key)) => format!("the key `{key}` stands here twice"),
            ("invalid mantissa, expected digits" | "invalid fraction, expected digits", _) => {
                "a number has digits on both sides of its point, such as 0.5 or 5.0".into()
            }
            (message, _) => message.into(),
        };
        FileError::Malformed { place, reason: one_line(reason) }
    })?;
    let offset = Some(table.span().start);
    Ok(Node { value: toml_table(table.into_inner()), offset })
}

/// A value as TOML has it, on its own.
///
/// # Errors
/// The error, in the words of the parser.
pub(super) fn read_toml_value(text: &str) -> Result<Value, String> {
    let value = DeValue::parse(text).map_err(|error| error.message().to_owned())?;
    Ok(without_place(toml_node(value)).value)
}

/// Forgets where a value was written, which is not a place of the file that it is put into.
fn without_place(node: Node) -> Node {
    let value = match node.value {
        Value::List(rows) => Value::List(rows.into_iter().map(without_place).collect()),
        Value::Table(rows) => {
            let row = |(key, _, node)| (key, None, without_place(node));
            Value::Table(rows.into_iter().map(row).collect())
        }
        other => other,
    };
    Node { value, offset: None }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Value::Nothing | Value::Any => serializer.serialize_unit(),
            Value::Flag(flag) => serializer.serialize_bool(*flag),
            // As JSON has it: numbers that no key of a scene may hold lose digits.
            Value::Whole(number) => match i64::try_from(*number) {
                Ok(number) => serializer.serialize_i64(number),
                Err(_) => serializer.serialize_f64(*number as f64),
            },
            Value::Number(number) => serializer.serialize_f64(*number),
            Value::Text(text) => serializer.serialize_str(text),
            Value::List(rows) => serializer.collect_seq(rows.iter().map(|row| &row.value)),
            Value::Table(rows) => {
                serializer.collect_map(rows.iter().map(|(key, _, node)| (key, &node.value)))
            }
        }
    }
}

fn toml_table(table: DeTable<'_>) -> Value {
    let row = |(key, value): (toml::Spanned<_>, toml::Spanned<DeValue<'_>>)| {
        let offset = Some(key.span().start);
        (String::from(key.into_inner()), offset, toml_node(value))
    };
    Value::Table(table.into_iter().map(row).collect())
}

fn toml_node(value: toml::Spanned<DeValue<'_>>) -> Node {
    let offset = Some(value.span().start);
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(digits) => match i128::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(number) => Value::Whole(number),
            // Too long for any key of the schema: the check of its domain refuses it as a number.
            Err(_) => Value::Number(digits.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(digits) => Value::Number(digits.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Flag(flag),
        DeValue::Datetime(date) => Value::Text(date.to_string()),
        DeValue::Array(rows) => Value::List(rows.into_iter().map(toml_node).collect()),
        DeValue::Table(table) => toml_table(table),
    };
    Node { value, offset }
}

fn read_json(text: &str, name: &str) -> Result<Node, FileError> {
    // Some editors put a byte order mark first, which is not part of JSON.
    serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|error| {
        let message = error.to_string();
        // serde_json repeats the position at the end of its message.
        let reason = message.split(" at line ").next().unwrap_or_default();
        let position = Some((short(error.line()), short(error.column())));
        let place = Place { file: name.into(), position };
        FileError::Malformed { place, reason: one_line(reason) }
    })
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = deserializer.deserialize_any(NodeVisitor)?;
        Ok(Node { value, offset: None })
    }
}

struct NodeVisitor;

impl<'de> Visitor<'de> for NodeVisitor {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Nothing)
    }

    fn visit_bool<E: Error>(self, flag: bool) -> Result<Value, E> {
        Ok(Value::Flag(flag))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Value, E> {
        Ok(Value::Whole(number.into()))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Value, E> {
        Ok(Value::Whole(number.into()))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Value, E> {
        Ok(Value::Number(number))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut rows = Vec::new();
        while let Some(row) = list.next_element()? {
            rows.push(row);
        }
        Ok(Value::List(rows))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Value, A::Error> {
        let mut rows: Vec<(String, Option<usize>, Node)> = Vec::new();
        let mut seen = BTreeSet::new();
        while let Some((key, node)) = table.next_entry::<String, Node>()? {
            // Taking the last one silently would hide a slip of the pen.
            if !seen.insert(key.clone()) {
                return Err(A::Error::custom(format_args!("the key `{key}` stands here twice")));
            }
            rows.push((key, None, node));
        }
        Ok(Value::Table(rows))
    }
}
