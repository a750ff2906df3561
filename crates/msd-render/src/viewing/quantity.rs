//! Quantities of particles and springs that colours stand for, with their scales.

use msd_core::{Real, Snapshot};

/// A quantity of particles or springs that colours stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The strain of each spring.
    Strain,
    /// The force of each spring and its damper, newtons; positive where it pulls its ends together.
    Force,
    /// The elastic energy of each spring, joules.
    Energy,
    /// The speed of each particle, metres per second.
    Speed,
    /// The error of each particle, metres, as given to [`crate::Renderer::set_errors`].
    Error,
}

/// Strain on the default scale, from one end of it to rest.
const STRAIN: f32 = 0.2;
/// The sizes at which a scale may end by default; smaller values count as zero, on a scale of 1.
const SIZES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 5] =
        [Quantity::Strain, Quantity::Force, Quantity::Energy, Quantity::Speed, Quantity::Error];

    /// Its name, one word.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Strain => "strain",
            Quantity::Force => "force",
            Quantity::Energy => "energy",
            Quantity::Speed => "speed",
            Quantity::Error => "error",
        }
    }

    /// The unit in which scales show it.
    fn unit(self) -> &'static str {
        match self {
            Quantity::Strain => "%",
            Quantity::Force => "N",
            Quantity::Energy => "J",
            Quantity::Speed => "m/s",
            Quantity::Error => "m",
        }
    }

    /// Returns whether it is one of springs, which are drawn then; else it is one of particles.
    pub fn is_of_springs(self) -> bool {
        matches!(self, Quantity::Strain | Quantity::Force | Quantity::Energy)
    }

    /// Returns whether it has two directions, such as pull and push.
    pub fn is_signed(self) -> bool {
        matches!(self, Quantity::Strain | Quantity::Force)
    }

    /// Its value at a spring of the snapshot; nothing of a quantity of particles.
    pub(crate) fn of_spring<R: Real>(
        self,
        snapshot: &Snapshot<'_, R>,
        spring: usize,
    ) -> Option<f64> {
        match self {
            Quantity::Strain => Some(snapshot.strain(spring)),
            Quantity::Force => Some(snapshot.tension(spring)),
            Quantity::Energy => Some(snapshot.elastic_energy(spring)),
            Quantity::Speed | Quantity::Error => None,
        }
    }

    /// The largest size of it in a snapshot that is finite; 0 of an error, which no snapshot has.
    pub fn largest<R: Real>(self, snapshot: &Snapshot<'_, R>) -> f64 {
        let sizes = |size: f64, value: f64| match value.abs() {
            value if value.is_finite() => size.max(value),
            _ => size,
        };
        let count = snapshot.particle_count();
        if self == Quantity::Speed {
            return (0..count).map(|particle| snapshot.speed(particle)).fold(0.0, sizes);
        }
        let is_there = |&spring: &usize| {
            let ends = snapshot.ends[spring];
            !snapshot.is_cut(spring) && ends.iter().all(|&end| (end as usize) < count)
        };
        let springs = (0..snapshot.ends.len()).filter(is_there);
        springs.filter_map(|spring| self.of_spring(snapshot, spring)).fold(0.0, sizes)
    }

    /// The end of the scale by default, where its largest size is known: that, rounded up to 1, 2
    /// or 5 times a power of ten; 20 % of a strain, whatever there is.
    pub fn full_scale(self, largest: f64) -> f32 {
        if self == Quantity::Strain {
            return STRAIN;
        }
        if !SIZES.contains(&largest) {
            return 1.0;
        }
        let power = 10f64.powf(largest.log10().floor());
        let ends = [1.0, 2.0, 5.0, 10.0].map(|part| part * power);
        ends.into_iter().find(|end| largest <= *end).unwrap_or(largest) as f32
    }
}

/// A quantity and the range of its colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The quantity that it measures.
    pub quantity: Quantity,
    /// The value at the end of the scale, in the unit of the quantity (of a strain, 1); positive.
    pub full: f32,
}

impl Scale {
    /// The quantity and its unit, in words: the title of a legend.
    pub fn title(self) -> String {
        format!("{}, {}", self.quantity.name(), self.quantity.unit())
    }

    /// The value so far along the scale, from 0 to 1.
    pub fn value(self, share: f32) -> f32 {
        if self.quantity.is_signed() { self.full * (2.0 * share - 1.0) } else { self.full * share }
    }

    /// The places of a legend that have numbers, from 0 to 1, and these.
    pub fn ticks(self) -> [(f32, String); 3] {
        let factor = if self.quantity == Quantity::Strain { 100.0 } else { 1.0 };
        [0.0, 0.5, 1.0].map(|share| (share, number(factor * self.value(share))))
    }
}

/// A number as a person reads it, in three digits at most.
fn number(value: f32) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    let size = value.abs();
    let short = format!("{value:.2e}");
    // Rounded to three digits, without zeros at its end.
    let rounded: f32 = short.parse().unwrap_or(value);
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact_enough() {
        assert_eq!([0.0, -0.0, 20.0, -20.0, 2.5].map(number), ["0", "0", "20", "-20", "2.5"]);
        assert_eq!([0.0025, 5e-4, 1e-6, 2e7].map(number), ["0.0025", "5e-4", "1e-6", "2e7"]);
        assert_eq!([f32::NAN, 1.0 / 3.0, 99_999.0].map(number), ["-", "0.333", "100000"]);
    }

    #[test]
    fn a_scale_ends_at_1_2_or_5_times_a_power_of_ten() {
        let full = |largest| Quantity::Speed.full_scale(largest);
        assert_eq!([1.0, 1.1, 2.0, 4.9, 5.1, 1234.0].map(full), [1.0, 2.0, 2.0, 5.0, 10.0, 2000.0]);
        for power in -29..29 {
            for part in [1.0, 1.5, 3.0, 7.0] {
                let largest = part * 10f64.powi(power);
                let end = f64::from(full(largest));
                // 2.5 is from 2 to 5; the rest is the rounding to single precision.
                assert!(largest * (1.0 - 1e-6) <= end && end <= 2.5 * largest, "{largest} {end}");
            }
        }
        for nothing in [0.0, 1e-300, f64::NAN, f64::INFINITY] {
            assert_eq!(full(nothing), 1.0);
        }
        assert_eq!(Quantity::Strain.full_scale(3.0), 0.2);
    }

    #[test]
    fn a_legend_names_the_unit_and_has_numbers_at_both_ends_and_between() {
        let told = |quantity, full| {
            let scale = Scale { quantity, full };
            (scale.title(), scale.ticks().map(|(_, number)| number))
        };
        let expected = |title: &str, ticks: [&str; 3]| (title.to_owned(), ticks.map(str::to_owned));
        assert_eq!(told(Quantity::Strain, 0.2), expected("strain, %", ["-20", "0", "20"]));
        assert_eq!(told(Quantity::Force, 500.0), expected("force, N", ["-500", "0", "500"]));
        assert_eq!(told(Quantity::Energy, 0.05), expected("energy, J", ["0", "0.025", "0.05"]));
        assert_eq!(told(Quantity::Speed, 5.0), expected("speed, m/s", ["0", "2.5", "5"]));
        assert_eq!(told(Quantity::Error, 2e-6), expected("error, m", ["0", "1e-6", "2e-6"]));
    }
}
