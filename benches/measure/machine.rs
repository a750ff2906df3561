//! Machine, compiler and date of a measurement, in one sentence.

use super::compiler;
use msd::study::machine;
use std::hint::black_box;
use std::time::Instant;

/// A sentence on the machine, the compiler and the date.
pub fn in_words() -> String {
    let cores = std::thread::available_parallelism().map_or(1, |count| count.get());
    let clock = clock();
    let (date, name, compiler) = (machine::date(), machine::name(), compiler::name());
    format!("Measured on {date}: {name}, {cores} cores, about {clock:.1} GHz; {compiler}.\n")
}

/// The clock in gigahertz, by a chain of multiplications and additions, each of which takes 3 + 1
/// cycles and waits for the one before. The frequency that the system reports is often not the one
/// that a virtual processor runs at.
fn clock() -> f64 {
    const LINKS: u32 = 1_000_000;
    let mut fastest = f64::INFINITY;
    for _ in 0..100 {
        let (start, mut number) = (Instant::now(), black_box(1u64));
        for link in 0..LINKS {
            number = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(link);
        }
        black_box(number);
        fastest = fastest.min(start.elapsed().as_secs_f64());
    }
    1e-9 * 4.0 * f64::from(LINKS) / fastest
}
