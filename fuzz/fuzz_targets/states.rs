//! What do any bytes do to `msd_fuzz::states`? Run by libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| msd_fuzz::states::check(bytes));
