//! Errors of files and of their content; every message is one line for each refusal.

use crate::mesh::MeshError;
use crate::shown::tame;
use std::fmt;

/// A place in an input: a file, and where in it if that is known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file, as the user named it.
    pub file: String,
    /// Line and column, counted from 1.
    pub position: Option<(u32, u32)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.position {
            Some((line, column)) => write!(f, "{}:{line}:{column}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

/// Everything that scene, state and output files can get wrong.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileError {
    /// A file that could not be read.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why, in the words of the operating system.
        reason: String,
    },
    /// A file that could not be written; nothing of it exists.
    #[error("{file}: cannot be written: {reason}")]
    Unwritable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// A name that is neither a built-in scene nor a file.
    #[error("no scene `{name}`: {hint}")]
    UnknownScene {
        /// The name that the user wrote.
        name: String,
        /// The nearest names, or all names.
        hint: String,
    },
    /// Text that does not follow its format, or rows that do not fit together.
    #[error("{place}: {reason}")]
    Malformed {
        /// Where.
        place: Place,
        /// The fault.
        reason: String,
    },
    /// A value outside its domain.
    #[error("{place}: {key} is {value}; it must be {expected}")]
    OutOfDomain {
        /// Where.
        place: Place,
        /// The key, from the top: `bodies[2].stiffness`.
        key: String,
        /// The value.
        value: String,
        /// The domain, in words.
        expected: String,
    },
    /// A key that the schema does not know.
    #[error("{place}: unknown key `{key}` in {table}; {hint}")]
    UnknownKey {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// The table it stands in: `bodies[0]`, or `the scene` at the top.
        table: String,
        /// The nearest valid key, or all of them.
        hint: String,
    },
    /// A key without which a table makes no sense.
    #[error("{place}: {table} lacks the key `{key}`")]
    MissingKey {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// The table it should stand in.
        table: String,
    },
    /// More than fits.
    #[error(
        "{place}: {key} asks for {counts}, about {} GB; at most {limit:.1} GB fit{hint}",
        gigabytes_shown(*gigabytes)
    )]
    TooLarge {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// Counts of the scene up to here.
        counts: String,
        /// Memory it would take, billions of bytes.
        gigabytes: f64,
        /// Memory it may take, billions of bytes.
        limit: f64,
        /// Advice, after a semicolon; may be empty.
        hint: &'static str,
    },
    /// A file of another format than this msd reads.
    #[error("{file}: is a {what} of format {found}; this msd reads format {known}")]
    Format {
        /// The file.
        file: String,
        /// The kind of file: a saved run, a recording.
        what: &'static str,
        /// The format that the file says it has.
        found: u32,
        /// The format that can be read.
        known: u32,
    },
    /// A row of a state file that cannot be used.
    #[error(
        "{file}: {}{quantity} is {value}; it must be {expected}",
        row.map(|row| format!("row {row}: ")).unwrap_or_default()
    )]
    StateRow {
        /// The file.
        file: String,
        /// The row, counted from 1 after the header; none for the header.
        row: Option<usize>,
        /// The column.
        quantity: String,
        /// The value found.
        value: String,
        /// The value expected.
        expected: String,
    },
    /// A mesh that could not be read or made into a body.
    #[error(transparent)]
    Mesh(Box<MeshError>),
    /// A mesh that a scene file names and that could not be read or made into a body.
    #[error("{place}: {key}: {source}")]
    SceneMesh {
        /// Where.
        place: Place,
        /// The key that led to it.
        key: String,
        /// The fault.
        source: Box<MeshError>,
    },
    /// Several things that are wrong with one file, in its order.
    #[error("{}", .0.iter().map(FileError::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<FileError>),
    /// A scene that msd-core refuses.
    #[error("{file}: {source}")]
    Core {
        /// The scene.
        file: String,
        /// The error of msd-core.
        source: Box<msd_core::Error>,
    },
}

impl FileError {
    /// The refusals that this is of, in the order of their file.
    pub fn each(&self) -> &[FileError] {
        match self {
            FileError::Several(errors) => errors,
            one => std::slice::from_ref(one),
        }
    }

    /// Where in a file it is, of the text of a scene.
    pub fn place(&self) -> Option<&Place> {
        match self {
            FileError::Malformed { place, .. }
            | FileError::OutOfDomain { place, .. }
            | FileError::UnknownKey { place, .. }
            | FileError::MissingKey { place, .. }
            | FileError::TooLarge { place, .. }
            | FileError::SceneMesh { place, .. } => Some(place),
            _ => None,
        }
    }

    /// The error of a value at the place that `place` knows of its key from the top:
    /// `bodies[2].stiffness`.
    ///
    /// # Errors
    /// The same error where there is no such place, or it is not of a value.
    pub fn placed(self, place: &impl Fn(&str) -> Option<Place>) -> Result<Self, Self> {
        if let FileError::Several(errors) = self {
            let each = |error: Self| error.placed(place).unwrap_or_else(|error| error);
            return Ok(FileError::Several(errors.into_iter().map(each).collect()));
        }
        let found = match &self {
            FileError::OutOfDomain { key, .. } | FileError::SceneMesh { key, .. } => place(key),
            FileError::UnknownKey { key, table, .. } if table == "the scene" => place(key),
            FileError::UnknownKey { key, table, .. } => place(&format!("{table}.{key}")),
            _ => None,
        };
        match (found, self) {
            (Some(place), FileError::OutOfDomain { key, value, expected, .. }) => {
                Ok(FileError::OutOfDomain { place, key, value, expected })
            }
            (Some(place), FileError::UnknownKey { key, table, hint, .. }) => {
                Ok(FileError::UnknownKey { place, key, table, hint })
            }
            (Some(place), FileError::SceneMesh { key, source, .. }) => {
                Ok(FileError::SceneMesh { place, key, source })
            }
            (_, error) => Err(error),
        }
    }
}

impl From<MeshError> for FileError {
    fn from(error: MeshError) -> Self {
        FileError::Mesh(Box::new(error))
    }
}

/// A size in gigabytes, with an exponent where nobody would count the digits.
fn gigabytes_shown(gigabytes: f64) -> String {
    if gigabytes < 1e6 { format!("{gigabytes:.1}") } else { format!("{gigabytes:.0e}") }
}

/// Flattens a message of a library into one line.
pub fn one_line(message: impl fmt::Display) -> String {
    let message = message.to_string();
    let lines = message.lines().map(str::trim).filter(|line| !line.is_empty());
    tame(&lines.collect::<Vec<_>>().join("; "))
}

/// A number as a person would write it: with an exponent where it is very large or small.
pub fn plain(number: f64) -> String {
    let size = number.abs();
    let long = size.is_finite() && size != 0.0 && !(1e-6..=1e15).contains(&size);
    if long { format!("{number:e}") } else { number.to_string() }
}

/// The name nearest to the written one, if one is near enough to be meant.
pub fn nearest<'n>(written: &str, names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let written = written.to_lowercase();
    let scored = names.into_iter().map(|name| (likeness(&written, &name.to_lowercase()), name));
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (0.75 <= best.0).then_some(best.1)
}

fn likeness(written: &str, name: &str) -> f64 {
    // A part of a name or a single slip is meant even where most letters differ.
    let part = 2 < written.len() && name.contains(written);
    let slip = 2 < written.len() && strsim::osa_distance(written, name) <= 1;
    if part || slip { 1.0 } else { strsim::jaro_winkler(written, name) }
}
