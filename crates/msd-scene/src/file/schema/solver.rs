//! The solver section of a scene.

use super::Edits;
use crate::file::keys::{Domain, Form, Live, Written, rows};
use crate::file::tree::Assignment;
use crate::precision::Precision;
use msd_core::{Integrator, Settings};
use serde::de::{Deserializer, Error, IntoDeserializer, Unexpected, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use serde_json::Map;
use std::fmt;
use std::marker::PhantomData;

/// The largest number of Newton iterations.
pub const MOST_NEWTON: u32 = 1000;

rows! {
    /// How a scene is stepped.
    SolverRow: Copy {
        /// Method.
        integrator: Option<Integrator> = "`velocity-verlet`" { live: Live::Solver },
        /// Length of a step; `"auto"` is another name for automatic substeps.
        step: OrAuto<f64> = "1/60" { unit: "s", domain: Domain::Step, live: Live::Solver },
        /// Steps per second, instead of `step`.
        steps_per_second: Option<f64> = "60" { unit: "Hz", domain: Domain::Rate },
        /// Substeps per step; one lasts `step / substeps`. `dormand-prince` does not use them.
        substeps: Option<OrAuto<u64>> = "`\"auto\"`"
            { domain: Domain::Count(u32::MAX as u64, "from 1 to 4294967295, or \"auto\""),
              live: Live::Solver },
        /// Local error that `dormand-prince` allows per substep, as a fraction of the size of the
        /// scene.
        tolerance: Option<f64> = "1e-6"
            { domain: Domain::UpTo(1.0, "positive and at most 1"), live: Live::Solver },
        /// Newton iterations of `backward-euler` and `implicit-midpoint` per substep.
        newton: Option<u64> = "1"
            { domain: Domain::Count(MOST_NEWTON as u64, "from 1 to 1000"), live: Live::Solver },
        /// Precision of all numbers.
        precision: Option<Precision> = "`f32`; `f64` where f32 is [too coarse]\
            (../measured/extremes.md#single-precision-far-from-the-origin) so far from the origin"
            { live: Live::Solver },
    }
}

/// How a run is stepped: all that a solver section can say.
#[derive(Clone, Copy, Debug)]
pub struct Solver {
    /// Method, step, substeps and what else the method has.
    pub settings: Settings,
    /// Precision of all numbers.
    pub precision: Precision,
    /// Whether substeps are chosen from the predicted limit of stability.
    pub automatic: bool,
}

impl Solver {
    /// The solver with the keys of a row set.
    pub fn with(self, row: &SolverRow) -> Solver {
        let Solver { settings: now, precision, automatic } = self;
        let count = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
        let (substeps, automatic) = match row.substeps {
            None => (now.substeps, automatic),
            Some(OrAuto::Auto) => (now.substeps, true),
            Some(OrAuto::Given(substeps)) => (count(substeps), false),
        };
        let step = match (row.step, row.steps_per_second) {
            (OrAuto::Given(step), _) => step,
            (OrAuto::Auto, Some(rate)) => 1.0 / rate,
            (OrAuto::Auto, None) => now.step,
        };
        let settings = Settings {
            integrator: row.integrator.unwrap_or(now.integrator),
            step,
            substeps,
            tolerance: row.tolerance.unwrap_or(now.tolerance),
            newton: row.newton.map_or(now.newton, count),
        };
        Solver { settings, precision: row.precision.unwrap_or(precision), automatic }
    }

    /// All of it, as keys.
    pub fn row(self) -> SolverRow {
        let Settings { integrator, step, substeps, tolerance, newton } = self.settings;
        let given = OrAuto::Given(substeps.into());
        SolverRow {
            integrator: Some(integrator),
            step: OrAuto::Given(step),
            steps_per_second: None,
            substeps: Some(if self.automatic { OrAuto::Auto } else { given }),
            tolerance: Some(tolerance),
            newton: Some(newton.into()),
            precision: Some(self.precision),
        }
    }
}

/// Automatic substeps follow from the state: two solvers that have them are the same.
impl PartialEq for Solver {
    fn eq(&self, other: &Solver) -> bool {
        self.row() == other.row()
    }
}

impl SolverRow {
    /// The method alone.
    pub fn integrator(integrator: Integrator) -> Self {
        SolverRow { integrator: Some(integrator), ..SolverRow::default() }
    }

    /// So many substeps per step alone.
    pub fn substeps(substeps: u32) -> Self {
        let substeps = Some(OrAuto::Given(substeps.into()));
        SolverRow { substeps, ..SolverRow::default() }
    }

    /// Automatic substeps alone.
    pub fn automatic() -> Self {
        SolverRow { substeps: Some(OrAuto::Auto), ..SolverRow::default() }
    }

    /// The tolerance of an adaptive method alone, as a fraction of the size of the scene.
    pub fn tolerance(tolerance: f64) -> Self {
        SolverRow { tolerance: Some(tolerance), ..SolverRow::default() }
    }

    /// The Newton iterations of an implicit method alone.
    pub fn newton(newton: u32) -> Self {
        SolverRow { newton: Some(newton.into()), ..SolverRow::default() }
    }

    /// The precision alone.
    pub fn precision(precision: Precision) -> Self {
        SolverRow { precision: Some(precision), ..SolverRow::default() }
    }

    /// The row of a command line, where a step without substeps has one, and substeps without a
    /// step divide a frame of 1/60 s.
    pub fn with_frame(self) -> Self {
        match (self.step, self.substeps) {
            (OrAuto::Given(_), None) => Self { substeps: Some(OrAuto::Given(1)), ..self },
            (OrAuto::Auto, Some(_)) => {
                Self { step: OrAuto::Given(Settings::default().step), ..self }
            }
            _ => self,
        }
    }

    /// Refuses keys that a method would not read: they would have no effect silently.
    ///
    /// # Errors
    /// A sentence with the key after `prefix`, and the methods that read it.
    pub fn check_read(&self, integrator: Integrator, prefix: &str) -> Result<(), String> {
        type Reads = fn(Integrator) -> bool;
        let keys: [(&str, bool, Reads); 2] = [
            ("tolerance", self.tolerance.is_some(), Integrator::is_adaptive),
            ("newton", self.newton.is_some(), Integrator::is_implicit),
        ];
        for (key, _, reads) in keys.into_iter().filter(|(_, given, _)| *given) {
            if reads(integrator) {
                continue;
            }
            let readers = Integrator::ALL.into_iter().filter(|&method| reads(method));
            let readers: Vec<&str> = readers.map(Integrator::name).collect();
            let verb = if readers.len() == 1 { "does" } else { "do" };
            let readers = readers.join(" and ");
            return Err(format!("{integrator} does not use {prefix}{key}; only {readers} {verb}"));
        }
        Ok(())
    }

    /// The keys that say something else than those of another row.
    pub fn but_for(self, other: &SolverRow) -> SolverRow {
        fn unless<T: PartialEq>(own: Option<T>, other: &Option<T>) -> Option<T> {
            if own == *other { None } else { own }
        }
        SolverRow {
            integrator: unless(self.integrator, &other.integrator),
            step: if self.step == other.step { OrAuto::Auto } else { self.step },
            steps_per_second: unless(self.steps_per_second, &other.steps_per_second),
            substeps: unless(self.substeps, &other.substeps),
            tolerance: unless(self.tolerance, &other.tolerance),
            newton: unless(self.newton, &other.newton),
            precision: unless(self.precision, &other.precision),
        }
    }

    /// The keys that it sets, with their values, in the order of the reference page.
    pub fn entries(&self) -> Map<String, serde_json::Value> {
        let row = serde_json::to_value(self).ok();
        row.and_then(|row| row.as_object().cloned()).unwrap_or_default()
    }

    /// The same as assignments.
    pub fn assignments(&self) -> impl Iterator<Item = Assignment> {
        self.entries()
            .into_iter()
            .map(|(key, value)| Assignment::new(&format!("{SECTION}{key}"), value))
    }
}

/// The table that the keys stand in.
const SECTION: &str = "solver.";

impl Edits {
    /// What was set of the solver.
    ///
    /// # Errors
    /// A line on a value that is not one of its key.
    pub fn solver(&self) -> Result<SolverRow, String> {
        let mut keys = Map::new();
        for edit in self.iter() {
            if let Some(name) = edit.key().strip_prefix(SECTION) {
                let value =
                    serde_json::to_value(edit.value()).map_err(|error| error.to_string())?;
                keys.insert(name.into(), value);
            }
        }
        Assignment::new("solver", keys).read()
    }
}

/// A value, or `"auto"` where msd chooses it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum OrAuto<T> {
    /// Chosen from the predicted limit of stability, and again as the run goes on.
    #[default]
    Auto,
    /// This value.
    Given(T),
}

/// How the choice of msd is written.
const AUTO: &str = "auto";

impl<T: Written> Written for OrAuto<T> {
    const FORM: Form = Form::Either(&[T::FORM, Form::Choice(|| &[AUTO])]);
}

impl<T: Serialize> Serialize for OrAuto<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            OrAuto::Auto => serializer.serialize_str(AUTO),
            OrAuto::Given(value) => value.serialize(serializer),
        }
    }
}

impl<'de, T: Deserialize<'de> + Written> Deserialize<'de> for OrAuto<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AutoVisitor(PhantomData))
    }
}

struct AutoVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Written> AutoVisitor<T> {
    fn given<E: Error>(
        self,
        value: impl Deserializer<'de, Error = E>,
        written: Unexpected<'_>,
    ) -> Result<OrAuto<T>, E> {
        T::deserialize(value).map(OrAuto::Given).map_err(|_| E::invalid_value(written, &self))
    }
}

impl<'de, T: Deserialize<'de> + Written> Visitor<'de> for AutoVisitor<T> {
    type Value = OrAuto<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match T::FORM {
            Form::Whole(_) => "a whole number from 1 to 4294967295, or \"auto\"",
            _ => "a number of seconds, or \"auto\"",
        })
    }

    fn visit_unit<E: Error>(self) -> Result<OrAuto<T>, E> {
        Ok(OrAuto::Auto)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<OrAuto<T>, E> {
        self.given(value.into_deserializer(), Unexpected::Float(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<OrAuto<T>, E> {
        self.given(value.into_deserializer(), Unexpected::Unsigned(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<OrAuto<T>, E> {
        self.given(value.into_deserializer(), Unexpected::Signed(value))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<OrAuto<T>, E> {
        match text == AUTO {
            true => Ok(OrAuto::Auto),
            false => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }
}
