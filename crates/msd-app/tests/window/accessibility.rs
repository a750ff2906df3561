//! The window as a screen reader sees it, through AT-SPI, on a separate bus.
//!
//! Also needs dbus-daemon, at-spi2-core and Python with its bindings to AT-SPI.

use super::desk::{desk_with, if_there};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use tempfile::TempDir;

/// The interpreter with the bindings, independently of the path.
const PYTHON: &str = "/usr/bin/python3";
const WALK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/window/walk.py");

/// A message bus without other clients.
struct Bus {
    address: String,
    daemon: Child,
    folder: TempDir,
}

impl Drop for Bus {
    fn drop(&mut self) {
        self.daemon.kill().ok();
        self.daemon.wait().ok();
    }
}

impl Bus {
    /// Starts a bus, or returns what is missing.
    fn open() -> Result<Bus, String> {
        let bindings = "import gi; gi.require_version('Atspi', '2.0')";
        let found = Command::new(PYTHON).args(["-c", bindings]).stderr(Stdio::null()).status();
        if !found.is_ok_and(|status| status.success()) {
            return Err("python3-gi or gir1.2-atspi-2.0 is not installed".into());
        }
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let mut daemon = Command::new("dbus-daemon")
            .args(["--session", "--nofork", "--print-address=1"])
            // The accessibility bus, which this one starts, keeps its socket there.
            .env("XDG_RUNTIME_DIR", folder.path())
            .env_remove("DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("dbus-daemon did not start: {error}"))?;
        let mut address = String::new();
        if let Some(output) = daemon.stdout.take() {
            BufReader::new(output).read_line(&mut address).map_err(|error| error.to_string())?;
        }
        Ok(Bus { address: address.trim().to_owned(), daemon, folder })
    }

    /// Walks through all windows on the bus, presses Pause and sets the stiffness to 5000; returns
    /// the controls: role, name, and whether they are focusable.
    fn walk(&self) -> Vec<(String, String, bool)> {
        let walked = Command::new(PYTHON)
            .arg(WALK)
            .env("DBUS_SESSION_BUS_ADDRESS", &self.address)
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env_remove("AT_SPI_BUS_ADDRESS")
            .output()
            .expect("it was there before");
        let said = String::from_utf8_lossy(&walked.stderr);
        assert!(walked.status.success(), "{said}");
        serde_json::from_slice(&walked.stdout).expect("rows")
    }
}

#[test]
fn a_screen_reader_finds_every_control_by_name_and_uses_them() {
    let Some(bus) = if_there(Bus::open()) else { return };
    let environment = [("DBUS_SESSION_BUS_ADDRESS", &*bus.address)];
    let Some(desk) = desk_with("1280x800x24", "jelly", &environment) else { return };
    let rows = bus.walk();
    let is_there = |role: &str, name: &str| rows.iter().any(|row| row.0 == role && row.1 == name);
    assert!(is_there("slider", "Stiffness") && is_there("check box", "Surface"), "{rows:?}");
    assert!(is_there("combo box", "Method") && is_there("canvas", "View of the scene"), "{rows:?}");
    assert!(is_there("frame", "msd: jelly"), "{rows:?}");
    let nameless =
        |row: &&(String, String, bool)| row.2 && !row.1.chars().any(char::is_alphanumeric);
    assert_eq!(rows.iter().find(nameless), None, "every control has a name");
    desk.wait("the button is pressed", |now| now["paused"] == true);
    desk.wait("the slider is set", |now| now["stiffness"] == 5000.0);
}
