//! Keys such as `bodies[0].stiffness`: the values of a scene that they name, and their replacement.

use msd_scene::plain;
use msd_scene::tree::{Node, Value};

/// A key of a scene, from its top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    /// As it was written.
    pub(crate) text: String,
    steps: Vec<Step>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Row(usize),
}

/// How a key is written, for messages.
pub(crate) const WRITTEN: &str =
    "a key of a scene such as \"solver.substeps\" or \"bodies[0].stiffness\"";

impl Key {
    /// Reads a key; none if it is not written as one.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut steps = Vec::new();
        for part in text.split('.') {
            let (name, rows) = part.split_at(part.find('[').unwrap_or(part.len()));
            let word = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || !name.chars().all(word) {
                return None;
            }
            steps.push(Step::Key(name.into()));
            let mut rest = rows;
            while !rest.is_empty() {
                let (row, after) = rest.strip_prefix('[')?.split_once(']')?;
                let digits = !row.is_empty() && row.bytes().all(|byte| byte.is_ascii_digit());
                steps.push(Step::Row(row.parse().ok().filter(|_| digits)?));
                rest = after;
            }
        }
        Some(Key { text: text.into(), steps })
    }

    /// Whether one of two keys names a value inside that of the other.
    pub(crate) fn overlaps(&self, other: &Key) -> bool {
        self.steps.iter().zip(&other.steps).all(|(a, b)| a == b)
    }

    /// Puts a value in its place in a scene; tables on the way are made if there are none.
    ///
    /// # Errors
    /// What is in the way, in words.
    pub(crate) fn set(&self, root: &mut Node, value: Value) -> Result<(), String> {
        let (mut node, mut path) = (root, String::new());
        for step in &self.steps {
            let here = if path.is_empty() { "the scene".to_string() } else { path.clone() };
            match (step, &mut node.value) {
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
                (Step::Row(_), _) => return Err(format!("{here} of the scene is no list")),
                (Step::Key(_), Value::List(_)) => {
                    return Err(format!("{here} of the scene is a list: write {here}[0]"));
                }
                (Step::Key(_), _) => return Err(format!("{here} of the scene is no table")),
            }
        }
        *node = Node { value, offset: None };
        Ok(())
    }
}

/// A value as a person would write it.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::Nothing => "missing".into(),
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
    use msd_scene::SceneFormat;
    use msd_scene::tree::Source;

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
        for text in ["", ".", "a.", "a b", "a[", "a[]", "a[-1]", "a[+1]", "[0]", "a]0[", "a[0]b"] {
            assert!(Key::parse(text).is_none(), "{text}");
        }
    }

    #[test]
    fn a_value_is_replaced_or_put_where_none_was() {
        let scene = "[[bodies]]\nmass = 1\n[[bodies]]\nmass = 2";
        let replaced = set(scene, "bodies[1].mass", Value::Whole(3));
        assert_eq!(replaced.as_deref(), Ok("{bodies: [{mass: 1}, {mass: 3}]}"));
        let put = set("version = 1", "solver.substeps", Value::Whole(4));
        assert_eq!(put.as_deref(), Ok("{version: 1, solver: {substeps: 4}}"));
    }

    #[test]
    fn what_is_in_the_way_of_a_key_is_told() {
        let scene = "pins = []\ntitle = 'x'\n[[bodies]]\nmass = 1";
        let told = |key| set(scene, key, Value::Flag(true)).expect_err(key);
        assert_eq!(told("bodies[3].mass"), "bodies of the scene has one row, bodies[0]");
        assert_eq!(told("bodies.mass"), "bodies of the scene is a list: write bodies[0]");
        assert_eq!(told("title.mass"), "title of the scene is no table");
        assert_eq!(told("title[0]"), "title of the scene is no list");
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
