//! What do any bytes do to `msd_fuzz::scenes`? Run by libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| msd_fuzz::scenes::check(bytes));
