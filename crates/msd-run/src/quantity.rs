//! Printed numbers and quantities: in words, on the command line and in the panels.
//!
//! Files and `--json` keep all digits; these are for reading.

use msd_core::Energy;
use serde::Serialize;

/// SI prefixes from the largest on.
const PREFIXES: [(f64, &str); 8] = [
    (1e12, "T"),
    (1e9, "G"),
    (1e6, "M"),
    (1e3, "k"),
    (1.0, ""),
    (1e-3, "m"),
    (1e-6, "µ"),
    (1e-9, "n"),
];
/// The units that take the prefixes above one: a time in kiloseconds would not read well.
const LARGE: [&str; 3] = ["J", "N/m", "Pa"];

/// A quantity in an SI unit, to four digits: `1.389 ms`.
pub fn quantity(value: f64, unit: &str) -> String {
    scaled(value, unit, 4)
}

/// A quantity that is only known roughly, as an error or a cost, to two digits: `1.4 ms`.
pub fn estimate(value: f64, unit: &str) -> String {
    scaled(value, unit, 2)
}

/// So many things: `1 spring`, `12 springs`.
pub fn counted(count: u64, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// Reads a quantity in an SI unit: a number, with a prefix and the unit or without.
pub fn read(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    let text = text.strip_suffix(unit).unwrap_or(text).trim_end();
    let ends = |&&(_, prefix): &&(f64, &str)| !prefix.is_empty() && text.ends_with(prefix);
    let &(scale, prefix) = PREFIXES.iter().find(ends).unwrap_or(&(1.0, ""));
    let number: f64 = text.strip_suffix(prefix)?.trim_end().parse().ok()?;
    Some(number * scale)
}

/// A number to four digits: `0.1`, `1e-10`, `1835`, `5.271e6`.
pub fn number(value: f64) -> String {
    rounded(value, 4)
}

fn scaled(value: f64, unit: &str, digits: usize) -> String {
    let fits = |&&(scale, _): &&(f64, &str)| {
        scale <= value.abs() && value.is_finite() && (scale <= 1.0 || LARGE.contains(&unit))
    };
    match PREFIXES.iter().find(fits) {
        Some((scale, prefix)) => format!("{} {prefix}{unit}", rounded(value / scale, digits)),
        None => format!("{} {unit}", rounded(value, digits)),
    }
}

/// At least so many digits, without zeros at the end; an exponent where a decimal would be long.
pub fn rounded(value: f64, digits: usize) -> String {
    // As written with an exponent: 9.99996 rounds to 10, which has two digits before the point.
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if value == 0.0 {
        "0".into()
    } else if !(-4..6).contains(&exponent) {
        format!("{}e{exponent}", trimmed(mantissa))
    } else {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        trimmed(&format!("{value:.decimals$}"))
    }
}

/// Energy with its total, joules; a part of `msd run --json`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyReport {
    /// Of motion.
    pub kinetic: f64,
    /// In springs, bends and volumes.
    pub elastic: f64,
    /// In uniform fields; zero at the origin.
    pub gravitational: f64,
    /// Dissipated since the start; NaN after steps of a graphics device, which does not measure it.
    pub dissipated: f64,
    /// Supplied since the start by moving solids and pins, wind and user-defined elements; NaN
    /// after steps of a graphics device with moving pins.
    pub supplied: f64,
    /// [`Energy::total`].
    pub total: f64,
}

impl From<Energy> for EnergyReport {
    fn from(energy: Energy) -> Self {
        let Energy { kinetic, elastic, gravitational, dissipated, supplied, .. } = energy;
        let total = energy.total();
        EnergyReport { kinetic, elastic, gravitational, dissipated, supplied, total }
    }
}

impl EnergyReport {
    /// Returns whether all of it was measured: a graphics device measures no dissipated energy.
    pub fn is_measured(&self) -> bool {
        !self.dissipated.is_nan()
    }

    /// All of it in a line of a summary.
    pub fn summary(&self) -> String {
        let EnergyReport { kinetic, elastic, gravitational, dissipated, supplied, total } = *self;
        let [kinetic, elastic, gravitational, dissipated, total] =
            [kinetic, elastic, gravitational, dissipated, total].map(number);
        let supplied = match supplied {
            0.0 => String::new(),
            work => format!(", supplied by what drives it {}", number(work)),
        };
        if !self.is_measured() {
            return format!(
                "energy, J: kinetic {kinetic}, elastic {elastic}, gravitational {gravitational}; \
                 dissipated and total not measured on a GPU"
            );
        }
        format!(
            "energy, J: kinetic {kinetic}, elastic {elastic}, gravitational {gravitational}, \
             dissipated {dissipated}{supplied}, total {total}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        for (value, text) in [
            (0.0, "0"),
            (1.0000000000000002e-10, "1e-10"),
            (3.27e-9, "3.27e-9"),
            (0.1, "0.1"),
            (0.000_123_456, "0.0001235"),
            (5.271, "5.271"),
            (9.99996, "10"),
            (-12.345_67, "-12.35"),
            (123_456.7, "123457"),
            (1_234_567.0, "1.235e6"),
            (1e10, "1e10"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn a_quantity_has_the_prefix_that_reads_best() {
        for (value, unit, text) in [
            (0.0, "m", "0 m"),
            (5.271, "m", "5.271 m"),
            (0.05, "s", "50 ms"),
            (1.0 / 720.0, "s", "1.389 ms"),
            (1500.0, "s", "1500 s"),
            (400.0, "m", "400 m"),
            (2.5e-7, "m", "250 nm"),
            (1e-12, "m", "1e-12 m"),
            (98_200.0, "J", "98.2 kJ"),
            (-3.5e-3, "J", "-3.5 mJ"),
            (1e6, "N/m", "1 MN/m"),
            (12_500.0, "Pa", "12.5 kPa"),
            (f64::INFINITY, "J", "inf J"),
        ] {
            assert_eq!(quantity(value, unit), text);
            // Products of prefixes round.
            let again = read(text, unit).unwrap_or(f64::NAN);
            assert!(again == value || (again - value).abs() <= 1e-3 * value.abs(), "{text}");
        }
        for (text, value) in [("3000", 3e3), (" 3k", 3e3), ("2.5 MN/m ", 2.5e6), ("1e3N/m", 1e3)] {
            assert_eq!(read(text, "N/m"), Some(value), "{text}");
        }
        for text in ["", "k", "N/m", "3 kk", "3 m/N", "stiff"] {
            assert_eq!(read(text, "N/m"), None, "{text}");
        }
        assert_eq!(estimate(1.26e-3, "m"), "1.3 mm");
        assert_eq!(estimate(0.123, "m"), "123 mm");
    }
}
