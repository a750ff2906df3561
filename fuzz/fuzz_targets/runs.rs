//! Fuzz target of `msd_fuzz::runs`, run by libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| msd_fuzz::runs::check(bytes));
