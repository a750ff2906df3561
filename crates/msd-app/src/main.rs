//! The msd program.
fn main() {}
