//! Keys of a scene file, one row each: the source of reading, checks, refinement and documentation.
//!
//! The rows of [`schema`](super::schema) are written once, by `rows!`, which makes of each the
//! field that serde reads and the row of a [`KeyTable`]. From the tables come the domain of a
//! number, the kinds that use a key, the exponents of a finer scene, the tables of
//! `docs/reference/scenes.md`
//! and the JSON Schema.

mod domain;

pub use domain::Domain;
pub(crate) use domain::LENGTH;

/// A table of a scene file.
#[derive(Clone, Copy, Debug)]
pub struct KeyTable {
    pub(crate) text: &'static str,
    /// The keys, in the order of the reference page.
    pub keys: &'static [KeyRow],
}

/// A key of a table.
#[derive(Clone, Copy, Debug)]
pub struct KeyRow {
    /// The name that a user writes.
    pub name: &'static str,
    pub(crate) text: &'static str,
    /// The unit of its numbers, empty where they have none.
    pub unit: &'static str,
    /// The form in which its value is written.
    pub form: Form,
    /// The values that it may have.
    pub domain: Domain,
    /// The default, in Markdown; `None` where the key must be given.
    pub default: Option<&'static str>,
    /// The kinds of its table that use it; empty where all do.
    pub kinds: &'static [&'static str],
    /// The kinds of its table that must have it.
    pub needed: &'static [&'static str],
    /// The scaling of its value with a finer spacing.
    pub scale: Scale,
    /// The way in which its value, or a value inside it, reaches a run that goes on.
    pub live: Live,
    /// The keys of its table that say the same in another way: a scene has it or them.
    pub instead_of: &'static [&'static str],
}

/// The way in which a value reaches a run that goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Live {
    /// Not at all: the scene has to start again.
    Restart,
    /// Gravity is set.
    Gravity,
    /// The wind blows otherwise.
    Wind,
    /// Drag is set.
    Drag,
    /// The law of contact of planes is set; without planes there is nothing to set.
    Plane,
    /// Masses of a body are set.
    Mass,
    /// Stiffnesses of a body are set.
    Stiffness,
    /// Dampings of a body are set.
    Damping,
    /// A body is made of another modulus.
    Young,
    /// A sheet is made of another thickness.
    Thickness,
    /// A body is made of another density.
    Density,
    /// The dampings of a body of a material are set.
    RelaxationTime,
    /// A body is made of another material.
    Material,
    /// A body looks otherwise.
    Look,
    /// The collision settings of bodies are made anew.
    Touch,
    /// Parts of the model are switched off.
    Off,
    /// Rest lengths are set.
    RestScale,
    /// It is stepped otherwise: [`Solver::with`](super::schema::Solver::with).
    Solver,
}

/// The form in which a value is written.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// True or false.
    Flag,
    /// A text.
    Text,
    /// A number.
    Number,
    /// A whole number from 0 to so much.
    Whole(u64),
    /// One of some names.
    Choice(fn() -> &'static [&'static str]),
    /// A list of so many, or of any number.
    List(&'static Form, Option<usize>),
    /// A table of keys.
    Table(&'static KeyTable),
    /// One of several forms.
    Either(&'static [Form]),
}

/// The change of a value where a spacing is divided into n parts: by n to the power of `parts` plus
/// `dimensions` times the directions in which the body extends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// The exponent of a body without extent.
    pub parts: i32,
    /// Power that each dimension adds.
    pub dimensions: i32,
}

impl Scale {
    /// The value stays.
    pub const STAYS: Scale = Scale { parts: 0, dimensions: 0 };
    /// A length along the spacing.
    pub const LENGTH: Scale = Scale { parts: -1, dimensions: 0 };
    /// The share of a particle in a quantity of its body.
    pub const SHARE: Scale = Scale { parts: 0, dimensions: -1 };
    /// The stiffness or damping of a spring of a body whose moduli stay.
    pub const SPRING: Scale = Scale { parts: 2, dimensions: -1 };

    /// The factor for so many parts and dimensions; exact for a power of two.
    pub fn factor(self, parts: u64, dimensions: u32) -> f64 {
        let exponent = self.parts + self.dimensions * dimensions as i32;
        let power = parts.pow(exponent.unsigned_abs()) as f64;
        if exponent < 0 { 1.0 / power } else { power }
    }
}

/// A type of values of keys.
pub trait Written {
    /// The form in which they are written.
    const FORM: Form;
}

impl Written for bool {
    const FORM: Form = Form::Flag;
}

impl Written for String {
    const FORM: Form = Form::Text;
}

impl Written for f64 {
    const FORM: Form = Form::Number;
}

impl Written for u32 {
    const FORM: Form = Form::Whole(u32::MAX as u64);
}

impl Written for u64 {
    const FORM: Form = Form::Whole(u64::MAX);
}

// A negative one is read, to be refused by its domain.
impl Written for i64 {
    const FORM: Form = Form::Whole(i64::MAX as u64);
}

impl<T: Written> Written for Option<T> {
    const FORM: Form = T::FORM;
}

impl<T: Written> Written for Vec<T> {
    const FORM: Form = Form::List(&T::FORM, None);
}

impl<T: Written, const N: usize> Written for [T; N] {
    const FORM: Form = Form::List(&T::FORM, Some(N));
}

impl Form {
    /// The table that it is, or a list of, or may be.
    pub fn table(self) -> Option<&'static KeyTable> {
        match self {
            Form::Table(table) => Some(table),
            Form::List(of, _) => of.table(),
            Form::Either(forms) => forms.iter().find_map(|form| form.table()),
            _ => None,
        }
    }
}

impl KeyRow {
    /// The columns that a row leaves out.
    pub(crate) const PLAIN: KeyRow = KeyRow {
        name: "",
        text: "",
        unit: "",
        form: Form::Flag,
        domain: Domain::Any,
        default: None,
        kinds: &[],
        needed: &[],
        scale: Scale::STAYS,
        live: Live::Restart,
        instead_of: &[],
    };

    /// Its meaning, in Markdown.
    pub fn what(&self) -> &'static str {
        self.text.trim_start()
    }

    /// Whether a table must have it, whatever its kind.
    pub fn is_required(&self) -> bool {
        let is_of_all = self.kinds.is_empty() && self.needed.is_empty();
        self.default.is_none() || is_of_all && self.default == Some("required")
    }

    /// Whether a kind of its table may have it.
    pub fn is_of(&self, kind: &str) -> bool {
        self.kinds.is_empty() || self.kinds.contains(&kind)
    }
}

impl KeyTable {
    /// Its description, in Markdown.
    pub fn what(&self) -> &'static str {
        self.text.trim_start()
    }

    /// The key at a path from this table without numbers of rows, such as `bodies.mass`.
    pub fn find(&self, path: &str) -> Option<&'static KeyRow> {
        let (keys, name) = match path.rsplit_once('.') {
            Some((above, name)) => (self.find(above)?.form.table()?.keys, name),
            None => (self.keys, path),
        };
        keys.iter().find(|key| key.name == name)
    }

    /// The way in which a value at such a path reaches a run that goes on.
    pub fn live(&self, path: &str) -> Live {
        let own = self.find(path).map_or(Live::Restart, |key| key.live);
        match path.rsplit_once('.') {
            Some((above, _)) if own == Live::Restart => self.live(above),
            _ => own,
        }
    }

    /// All keys with their paths, those of a table before those inside.
    pub fn paths(&self) -> Vec<(String, &'static KeyRow)> {
        let mut paths: Vec<_> = self.keys.iter().map(|key| (key.name.to_owned(), key)).collect();
        let tables = self.keys.iter().filter_map(|key| Some((key.name, key.form.table()?)));
        paths.extend(tables.flat_map(|(name, table)| {
            table.paths().into_iter().map(move |(path, key)| (format!("{name}.{path}"), key))
        }));
        paths
    }
}

/// A key such as `bodies[2].mass` without the numbers of rows: `bodies.mass`.
pub(crate) fn without_rows(key: &str) -> String {
    let mut inside = false;
    let mut kept = |letter: &char| {
        inside = *letter == '[' || inside && *letter != ']';
        !inside && *letter != ']'
    };
    key.chars().filter(|letter| kept(letter)).collect()
}

/// Returns whether a value equals that of an omitted key.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Makes the types of rows, with the table of each.
///
/// A key is its documentation, name, type, default and columns of [`KeyRow`]. One without a default
/// must be given.
macro_rules! rows {
    ($(
        $(#[doc = $about:literal])+
        $row:ident $(: $marker:ident)? {$(
            $(#[doc = $what:literal])+
            $key:ident $(as $written:literal)?: $type:ty $(= $default:literal)?
            $({ $($column:ident: $value:expr),+ })?,
        )+}
    )+) => {$(
        $(#[doc = $about])+
        #[derive($($marker,)? Clone, Debug, Default, PartialEq)]
        #[derive(serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $row {$(
            $(#[doc = $what])+
            $(
                #[doc = ""]
                #[doc = concat!("Default: ", $default, ".")]
                #[serde(default, skip_serializing_if = "crate::file::keys::is_default")]
            )?
            $(#[serde(rename = $written)])?
            pub $key: $type,
        )+}

        impl $row {
            /// Its keys.
            pub const TABLE: &'static crate::file::keys::KeyTable = &crate::file::keys::KeyTable {
                text: concat!($($about),+),
                keys: &[$(crate::file::keys::KeyRow {
                    name: [$($written,)? stringify!($key)][0],
                    text: concat!($($what),+),
                    form: <$type as crate::file::keys::Written>::FORM,
                    default: [$(Some($default),)? None][0],
                    $($($column: $value,)+)?
                    ..crate::file::keys::KeyRow::PLAIN
                }),+],
            };
        }

        impl crate::file::keys::Written for $row {
            const FORM: crate::file::keys::Form = crate::file::keys::Form::Table($row::TABLE);
        }
    )+};
}

pub(crate) use rows;
