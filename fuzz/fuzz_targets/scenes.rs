//! Fuzz target of `msd_fuzz::scenes`, run by libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| msd_fuzz::scenes::check(bytes));
