//! Keys such as `bodies[0].stiffness`: the values of a scene that they name, and their replacement.

use super::{Node, Value};
use crate::error::plain;

/// A key of a scene, from its top: `bodies[0].stiffness`, or `bodies.0.stiffness`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// As it is written, rows in brackets.
    text: String,
    steps: Vec<Step>,
}

/// A step of a path through a scene: into a table, or to a row of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::file) enum Step {
    Key(String),
    Row(usize),
}

/// The form of a key, for messages.
pub const WRITTEN: &str = "a key of a scene such as \"solver.substeps\" or \"bodies[0].stiffness\"";

impl Key {
    /// Reads a key; none if it is not written as one.
    pub fn parse(text: &str) -> Option<Self> {
        let mut steps = Vec::new();
        for part in text.split('.') {
            if let (false, Some(row)) = (steps.is_empty(), row_number(part)) {
                steps.push(Step::Row(row));
                continue;
            }
            let (name, rows) = part.split_at(part.find('[').unwrap_or(part.len()));
            let word = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
            let is_name = name.chars().all(word) && row_number(name).is_none();
            if name.is_empty() || !is_name {
                return None;
            }
            steps.push(Step::Key(name.into()));
            let mut rest = rows;
            while !rest.is_empty() {
                let (row, after) = rest.strip_prefix('[')?.split_once(']')?;
                steps.push(Step::Row(row_number(row)?));
                rest = after;
            }
        }
        let mut text = String::new();
        for step in &steps {
            match step {
                Step::Key(name) if text.is_empty() => text.push_str(name),
                Step::Key(name) => text.extend([".", name]),
                Step::Row(row) => text.push_str(&format!("[{row}]")),
            }
        }
        Some(Key { text, steps })
    }

    /// The key from the top, rows in brackets.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether a key from the top, as a message names it, is of this value, of a part of it, or of
    /// a table that contains it.
    pub fn concerns(&self, key: &str) -> bool {
        let inside = |key: &str, of: &str| {
            let rest = key.strip_prefix(of);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        inside(key, &self.text) || inside(&self.text, key)
    }

    /// Whether one of two keys names a value inside that of the other.
    pub fn overlaps(&self, other: &Key) -> bool {
        self.steps.iter().zip(&other.steps).all(|(a, b)| a == b)
    }

    /// The name in its table.
    pub(super) fn name(&self) -> &str {
        let mut names = self.steps.iter().filter_map(|step| match step {
            Step::Key(name) => Some(name.as_str()),
            Step::Row(_) => None,
        });
        names.next_back().unwrap_or_default()
    }

    /// The number of the first row on the way.
    pub(super) fn row(&self) -> Option<usize> {
        self.steps.iter().find_map(|step| match step {
            Step::Key(_) => None,
            Step::Row(row) => Some(*row),
        })
    }

    /// The key of this name in the same table.
    pub(in crate::file) fn beside(&self, name: &str) -> Key {
        let mut key = self.clone();
        key.steps.pop();
        key.steps.push(Step::Key(name.into()));
        key
    }

    /// Whether it names the value of another key, or a table that contains that; a key without the
    /// number of a row is of all rows.
    pub(in crate::file) fn covers(&self, other: &Key) -> bool {
        let mut own = self.steps.iter().peekable();
        for step in &other.steps {
            match (own.peek(), step) {
                (None, _) => return true,
                (Some(Step::Key(_)), Step::Row(_)) => {}
                (Some(is), _) if *is != step => return false,
                _ => _ = own.next(),
            }
        }
        own.peek().is_none()
    }

    /// Puts a value in its place in a scene; tables on the way are made if there are none. Nothing
    /// leaves the key out.
    ///
    /// # Errors
    /// The reason, in words.
    pub fn set(&self, root: &mut Node, value: Value) -> Result<(), String> {
        let (mut node, mut path) = (root, String::new());
        for (at, step) in self.steps.iter().enumerate() {
            let is_left_out = at + 1 == self.steps.len() && matches!(value, Value::Nothing);
            let here = if path.is_empty() { "the scene".to_string() } else { path.clone() };
            match (step, &mut node.value) {
                (Step::Key(name), Value::Table(rows)) if is_left_out => {
                    rows.retain(|row| row.0 != *name);
                    return Ok(());
                }
                (Step::Key(name), Value::Table(rows)) => {
                    path.push_str(if path.is_empty() { "" } else { "." });
                    path.push_str(name);
                    let found = rows.iter().position(|row| row.0 == *name);
                    let place = found.unwrap_or_else(|| {
                        let empty = Node { value: Value::Table(Vec::new()), offset: None };
                        rows.push((name.clone(), None, empty));
                        rows.len() - 1
                    });
                    node = &mut rows[place].2;
                }
                (Step::Row(row), Value::List(rows)) => {
                    path.push_str(&format!("[{row}]"));
                    let count = rows.len();
                    let missing = || match count {
                        0 => format!("{here} of the scene is empty"),
                        1 => format!("{here} of the scene has one row, {here}[0]"),
                        _ => format!("{here} of the scene has {count} rows, 0 to {}", count - 1),
                    };
                    node = rows.get_mut(*row).ok_or_else(missing)?;
                }
                (Step::Row(_), Value::Table(rows)) if rows.is_empty() => {
                    return Err(format!("the scene has no {here}"));
                }
                (Step::Row(_), _) => return Err(format!("{here} of the scene is not a list")),
                (Step::Key(_), Value::List(_)) => {
                    return Err(format!("{here} of the scene is a list: write {here}[0]"));
                }
                (Step::Key(_), _) => return Err(format!("{here} of the scene is not a table")),
            }
        }
        *node = Node { value, offset: None };
        Ok(())
    }
}

/// A row by its number, from 0.
fn row_number(text: &str) -> Option<usize> {
    let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| digits)
}

/// A value as a person would write it.
pub fn shown(value: &Value) -> String {
    match value {
        Value::Nothing => "missing".into(),
        Value::Any => "any value".into(),
        Value::Flag(flag) => flag.to_string(),
        Value::Whole(number) => number.to_string(),
        Value::Number(number) => plain(*number),
        Value::Text(text) => format!("\"{text}\""),
        Value::List(rows) => {
            let rows: Vec<String> = rows.iter().map(|row| shown(&row.value)).collect();
            format!("[{}]", rows.join(", "))
        }
        Value::Table(rows) => {
            let row =
                |row: &(String, Option<usize>, Node)| format!("{}: {}", row.0, shown(&row.2.value));
            format!("{{{}}}", rows.iter().map(row).collect::<Vec<_>>().join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::tree::Source;
    use crate::file::tree::text::SceneFormat;

    fn set(scene: &str, key: &str, value: Value) -> Result<String, String> {
        let mut source = Source::parse(scene, SceneFormat::Toml, "scene").expect("TOML");
        Key::parse(key).expect("a key").set(&mut source.root, value)?;
        Ok(shown(&source.root.value))
    }

    #[test]
    fn a_key_is_words_and_row_numbers() {
        for text in ["solver.substeps", "bodies[0].spin.axis[2]", "title", "a[0][1]"] {
            assert!(Key::parse(text).is_some(), "{text}");
        }
        for text in
            ["", ".", "a.", "a b", "a[", "a[]", "a[-1]", "a[+1]", "[0]", "0.a", "a]0[", "a[0]b"]
        {
            assert!(Key::parse(text).is_none(), "{text}");
        }
    }

    #[test]
    fn a_row_is_a_number_after_a_dot_or_in_brackets() {
        let key = |text| Key::parse(text).expect("a key");
        assert_eq!(key("bodies.0.spin.1"), key("bodies[0].spin[1]"));
        assert_eq!(key("bodies.0.mass").text(), "bodies[0].mass");
    }

    #[test]
    fn a_value_is_replaced_or_put_where_none_was() {
        let scene = "[[bodies]]\nmass = 1\n[[bodies]]\nmass = 2";
        let replaced = set(scene, "bodies[1].mass", Value::Whole(3));
        assert_eq!(replaced.as_deref(), Ok("{bodies: [{mass: 1}, {mass: 3}]}"));
        let put = set("version = 1", "solver.substeps", Value::Whole(4));
        assert_eq!(put.as_deref(), Ok("{version: 1, solver: {substeps: 4}}"));
        let left_out = set(scene, "bodies[0].mass", Value::Nothing);
        assert_eq!(left_out.as_deref(), Ok("{bodies: [{}, {mass: 2}]}"));
    }

    #[test]
    fn what_is_in_the_way_of_a_key_is_told() {
        let scene = "pins = []\ntitle = 'x'\n[[bodies]]\nmass = 1";
        let told = |key| set(scene, key, Value::Flag(true)).expect_err(key);
        assert_eq!(told("bodies[3].mass"), "bodies of the scene has one row, bodies[0]");
        assert_eq!(told("bodies.mass"), "bodies of the scene is a list: write bodies[0]");
        assert_eq!(told("title.mass"), "title of the scene is not a table");
        assert_eq!(told("title[0]"), "title of the scene is not a list");
        assert_eq!(told("pins[0].every"), "pins of the scene is empty");
        assert_eq!(told("world.planes[0].friction"), "the scene has no world.planes");
    }

    #[test]
    fn keys_overlap_if_one_holds_the_other() {
        let key = |text| Key::parse(text).expect("a key");
        assert!(key("bodies[0]").overlaps(&key("bodies[0].mass")));
        assert!(!key("bodies[0].mass").overlaps(&key("bodies[1].mass")));
    }
}
