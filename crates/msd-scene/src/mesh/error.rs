//! Errors of meshes and their messages.

/// A place in a file: a line, counted from 1, or a vertex, face or facet, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// The kind of row.
    pub item: &'static str,
    /// Its number.
    pub row: usize,
}

impl core::fmt::Display for Row {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} {}", self.item, self.row)
    }
}

/// Everything that mesh import refuses; each message is one line.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A file that could not be read at all.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why, in the words of the operating system.
        reason: String,
    },
    /// A file name whose ending names no mesh format.
    #[error(
        "{file}: unknown mesh format '{extension}'; it must be one of obj, stl, ply, gltf, glb"
    )]
    UnknownFormat {
        /// The file.
        file: String,
        /// Its ending, without the dot.
        extension: String,
    },
    /// A file that does not follow its format.
    #[error("{file}: {}{reason}", row.map(|row| format!("{row}: ")).unwrap_or_default())]
    Malformed {
        /// The file.
        file: String,
        /// Where, if that is known.
        row: Option<Row>,
        /// The fault.
        reason: String,
    },
    /// A value outside its domain.
    #[error("{file}: {row}: {quantity} is {value}; it must be {expected}")]
    OutOfDomain {
        /// The file.
        file: String,
        /// Where.
        row: Row,
        /// The quantity of the value.
        quantity: &'static str,
        /// The value.
        value: String,
        /// The domain, in words.
        expected: String,
    },
    /// A file shorter than its own header says.
    #[error("{file}: the header announces {needed} bytes of {what}, but only {present} follow")]
    Truncated {
        /// The file.
        file: String,
        /// The missing part.
        what: String,
        /// The fewest bytes it could take.
        needed: u128,
        /// The bytes that are there.
        present: usize,
    },
    /// More rows than fit.
    #[error("{file}: {what} would be {count}; at most {limit} fit")]
    TooLarge {
        /// The file.
        file: String,
        /// The kind of row.
        what: &'static str,
        /// Their number.
        count: u128,
        /// The most that fit.
        limit: u128,
    },
    /// An interior lattice with more points than fit.
    #[error(
        "{file}: a spacing of {spacing:e} puts {} lattice points into the box around the mesh; at \
         most {limit} fit: make the spacing larger",
        if *count < 1_000_000_000 { count.to_string() } else { format!("{:.0e}", *count as f64) }
    )]
    TooFine {
        /// The file.
        file: String,
        /// The spacing asked for, metres.
        spacing: f64,
        /// The number of points, saturated.
        count: u128,
        /// The most that fit.
        limit: u128,
    },
    /// A mesh without a single usable face.
    #[error("{file}: {}", match faces {
        0 => "no faces found; points and lines alone make no body".into(),
        faces => format!("no face with an area is left of {faces} read"),
    })]
    Empty {
        /// The file.
        file: String,
        /// Triangles in the file, polygons cut up.
        faces: usize,
    },
    /// A solid asked of a mesh that has no clear inside.
    #[error(
        "{file}: over {:.1} % of its surface it is undecided what is inside; at most 10 % may be: \
         close its holes, or ask for a shell", 100.0 * undecided
    )]
    Undecided {
        /// The file.
        file: String,
        /// The share of its area, from 0 to 1.
        undecided: f64,
    },
    /// An obstacle asked of a mesh that has no inside.
    #[error(
        "{file}: is not closed, so it has no inside: {open} open edges, {crowded} edges with more \
         than two faces"
    )]
    Open {
        /// The file.
        file: String,
        /// Edges with a single face.
        open: usize,
        /// Edges with more than two faces.
        crowded: usize,
    },
    /// A grid of distances too coarse for its mesh.
    #[error("{file}: with a cell of {cell} no point of the grid is inside: make it smaller")]
    TooCoarse {
        /// The file.
        file: String,
        /// The edge of a cell asked for, metres.
        cell: f64,
    },
    /// An option outside its domain.
    #[error("{quantity} of the mesh body is {value}; it must be {expected}")]
    Option {
        /// The quantity of the option.
        quantity: &'static str,
        /// The value given.
        value: f64,
        /// The domain, in words.
        expected: &'static str,
    },
}

/// Flattens a message, which may quote a file, into one short line that moves no cursor.
pub(crate) fn one_line(message: &str) -> String {
    const LONGEST: usize = 200;
    let words: Vec<&str> = message.split_whitespace().collect();
    let line = words.join(" ").replace(char::is_control, "\u{fffd}");
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

/// An error about a whole file.
pub(crate) fn malformed(file: &str, reason: impl AsRef<str>) -> MeshError {
    MeshError::Malformed { file: file.into(), row: None, reason: one_line(reason.as_ref()) }
}

/// An error about one row of a file.
pub(crate) fn malformed_row(file: &str, row: Row, reason: impl AsRef<str>) -> MeshError {
    MeshError::Malformed { file: file.into(), row: Some(row), reason: one_line(reason.as_ref()) }
}
