//! What do any bytes do to `msd_fuzz::runs`? Run by libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| msd_fuzz::runs::check(bytes));
