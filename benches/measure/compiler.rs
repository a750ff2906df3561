//! Name and version of the compiler.

use std::process::Command;

/// The compiler in words: that of the toolchain of the workspace.
pub fn name() -> String {
    let told = Command::new("rustc").arg("--version").output();
    let told = told.map(|told| String::from_utf8_lossy(&told.stdout).trim().to_owned());
    told.unwrap_or_else(|_| "an unknown compiler".into())
}
