//! Numbers that are read at a glance: two or three digits and a unit.

/// A number with three significant digits: `0.0123`, `16.7`, `1.20×10⁻⁷`.
pub fn number(value: f64) -> String {
    if value.is_nan() {
        return "–".into();
    }
    if value.is_infinite() {
        return if value < 0.0 { "−∞" } else { "∞" }.into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let written = format!("{:.2e}", value.abs());
    let (digits, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if value < 0.0 { "−" } else { "" };
    if (-4..6).contains(&exponent) {
        // No more than three digits count: 179,179 is 179 000.
        let round = 10f64.powi((exponent - 2).max(0));
        let rounded = (value.abs() / round).round() * round;
        let shown = if 2 < exponent { rounded } else { value.abs() };
        let digits = format!("{:.*}", (2 - exponent).max(0) as usize, shown);
        format!("{sign}{}", grouped(&digits))
    } else {
        format!("{sign}{digits}×{}", power(exponent))
    }
}

/// A whole number with a blank before its last three digits where there are more than four.
pub fn grouped(number: &str) -> String {
    let digits = number.trim_start_matches('−');
    if digits.len() < 5 || !digits.bytes().all(|letter| letter.is_ascii_digit()) {
        return number.into();
    }
    let (thousands, rest) = number.split_at(number.len() - 3);
    format!("{thousands}\u{a0}{rest}")
}

/// A change with its sign, so many decimals, and a unit: `+0.12 %`; no sign where there is none.
pub fn change(value: f64, decimals: usize, unit: &str) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let said = format!("{value:+.decimals$}");
    let is_zero = said[1..].bytes().all(|letter| matches!(letter, b'0' | b'.'));
    let said = if is_zero { &said[1..] } else { &said };
    format!("{}{unit}", said.replace('-', "−"))
}

/// A power of ten: `10⁻⁷`.
pub fn power(exponent: i32) -> String {
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// A quantity with the prefix that leaves up to three digits before the point: `1.23 mm`.
pub fn quantity(value: f64, unit: &str) -> String {
    const PREFIXES: [(f64, &str); 8] = [
        (1e6, "M"),
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "µ"),
        (1e-9, "n"),
        (1e-12, "p"),
        (1e-15, "f"),
    ];
    if value == 0.0 || !value.is_finite() {
        return format!("{} {unit}", number(value));
    }
    // A value that rounds up to 1000 belongs to the next prefix.
    let fits = |(scale, _): &&(f64, &str)| 0.9995 * scale <= value.abs();
    match PREFIXES.iter().find(fits) {
        Some((scale, prefix)) if value.abs() < 1e9 => {
            format!("{} {prefix}{unit}", number(value / scale))
        }
        _ => format!("{} {unit}", number(value)),
    }
}

/// A fraction in percent while that is a number to read, else as a power of ten.
pub fn percent(fraction: f64) -> String {
    if fraction == 0.0 || (1e-6..1e4).contains(&fraction.abs()) {
        format!("{} %", number(100.0 * fraction))
    } else {
        number(fraction)
    }
}

/// A round value on an axis: so many times that power of ten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick(pub i32, pub i32);

impl Tick {
    /// The value.
    pub fn value(self) -> f64 {
        f64::from(self.0) * 10f64.powi(self.1)
    }

    /// The value in percent, and as a power of ten further down: `20 %`, `10⁻⁶`.
    pub fn percent(self) -> String {
        let Tick(times, exponent) = self;
        match exponent {
            -5..=1 => {
                let decimals = (-2 - exponent).max(0) as usize;
                format!("{:.decimals$} %", 100.0 * self.value())
            }
            _ if times == 1 => power(exponent),
            _ => format!("{times}×{}", power(exponent)),
        }
    }

    /// The value with its unit: `10 mm`, `200 nm`.
    pub fn with_unit(self, unit: &str) -> String {
        let Tick(times, exponent) = self;
        let prefix = match exponent.div_euclid(3) {
            -5 => "f",
            -4 => "p",
            -3 => "n",
            -2 => "µ",
            -1 => "m",
            0 => "",
            1 => "k",
            _ if times == 1 => return format!("{} {unit}", power(exponent)),
            _ => return format!("{times}×{} {unit}", power(exponent)),
        };
        format!("{} {prefix}{unit}", times * 10i32.pow(exponent.rem_euclid(3) as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits_and_their_unit() {
        assert_eq!(number(16.666), "16.7");
        assert_eq!(number(0.012_34), "0.0123");
        assert_eq!(number(999.96), "1000");
        assert_eq!(number(1488.0), "1490");
        assert_eq!(number(179_179.0), "179\u{a0}000");
        assert_eq!(number(-1.2e-7), "−1.20×10⁻⁷");
        assert_eq!(change(-0.0121, 2, " %"), "−0.01 %");
        assert_eq!(change(-0.0001, 2, " %"), "0.00 %");
        assert_eq!(change(0.25, 1, ""), "+0.2");
        assert_eq!(quantity(1.234e-3, "m"), "1.23 mm");
        assert_eq!(quantity(0.9999e-3, "m"), "1.00 mm");
        assert_eq!(quantity(0.0, "m"), "0 m");
        assert_eq!(quantity(2.5e-18, "m"), "2.50×10⁻¹⁸ m");
        assert_eq!(percent(0.001), "0.100 %");
    }

    #[test]
    fn ticks_are_round_and_name_their_unit() {
        assert_eq!(Tick(1, -3).percent(), "0.1 %");
        assert_eq!(Tick(2, 0).percent(), "200 %");
        assert_eq!(Tick(5, -7).percent(), "5×10⁻⁷");
        assert_eq!(Tick(1, -7).with_unit("m"), "100 nm");
        assert_eq!(Tick(5, 1).with_unit("s"), "50 s");
    }
}
