//! Values that were set of keys of a scene since it was opened.

use super::{SceneFile, find};
use crate::file::decode::decode;
use crate::file::keys::{Live, without_rows};
use crate::file::tree::key::Key;
use crate::file::tree::{Assignment, Node, Source};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

impl Assignment {
    /// How it reaches a run that goes on.
    pub fn live(&self) -> Live {
        SceneFile::TABLE.live(&without_rows(self.key()))
    }

    /// The value as one of a type.
    ///
    /// # Errors
    /// A line on a value of another type.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, String> {
        let node = Node { value: self.value().clone(), offset: None };
        decode(&Source::of(node, self.key())).map_err(|error| error.to_string())
    }
}

/// Values of keys in place of those of a scene, each key once, the last one set at the end. A key
/// without the number of a row is of all rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Edits(Vec<Assignment>);

impl Edits {
    /// Sets a key; what was set of it before, inside it or instead of it is void.
    pub fn set(&mut self, edit: Assignment) {
        self.forget(edit.key());
        if let (Some(key), Some(row)) = (Key::parse(edit.key()), find(&without_rows(edit.key()))) {
            row.instead_of.iter().for_each(|name| self.void(&key.beside(name)));
        }
        self.0.push(edit);
    }

    /// Forgets what was set of a key and inside it: the scene has its own value again.
    pub fn forget(&mut self, key: &str) {
        if let Some(key) = Key::parse(key) {
            self.void(&key);
        }
    }

    fn void(&mut self, key: &Key) {
        self.0.retain(|edit| !edit.is_void_by(key));
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Whether nothing was set.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All of them, the oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Assignment> {
        self.0.iter()
    }

    /// What was set of a key itself.
    pub fn of(&self, key: &str) -> Option<&Assignment> {
        self.iter().find(|edit| edit.key() == key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_replaces_what_it_covers_and_what_says_otherwise() {
        let mut edits = Edits::default();
        let keys = ["bodies[0].mass", "bodies[1].young", "bodies[1].thickness", "bodies.mass"];
        keys.iter().for_each(|key| edits.set(Assignment::new(key, 1.0)));
        let keys =
            |edits: &Edits| edits.iter().map(|edit| edit.key().to_owned()).collect::<Vec<_>>();
        assert_eq!(keys(&edits), ["bodies[1].young", "bodies[1].thickness", "bodies.mass"]);
        edits.set(Assignment::new("bodies[1].material", "steel"));
        edits.set(Assignment::new("bodies[0].mass", 2.0));
        let left = ["bodies[1].thickness", "bodies.mass", "bodies[1].material", "bodies[0].mass"];
        assert_eq!(keys(&edits), left);
        edits.forget("bodies[1]");
        assert_eq!(keys(&edits), ["bodies.mass", "bodies[0].mass"]);
    }
}
