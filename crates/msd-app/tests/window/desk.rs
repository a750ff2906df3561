//! A virtual display with the window on it, a synthetic mouse and keyboard.

use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A software renderer on a busy machine renders a few frames per second.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A virtual display with the window on it.
pub struct Desk {
    pub display: String,
    pub status: PathBuf,
    pub xvfb: Child,
    /// Working directory of the program.
    pub folder: TempDir,
    window: Option<Child>,
    /// Argument of `msd view`; empty for `msd` alone.
    pub scene: &'static str,
    environment: Vec<(&'static str, String)>,
}

impl Drop for Desk {
    fn drop(&mut self) {
        for child in self.window.iter_mut().chain([&mut self.xvfb]) {
            child.kill().ok();
            child.wait().ok();
        }
    }
}

fn is_installed(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

impl Desk {
    /// Opens a scene in the window on a screen of this size, or returns why that failed.
    fn open(
        screen: &str,
        scene: &'static str,
        environment: &[(&'static str, &str)],
    ) -> Result<Desk, String> {
        for program in ["Xvfb", "xdotool"] {
            if !is_installed(program) {
                return Err(format!("{program} is not installed"));
            }
        }
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        // Xvfb picks a free display itself and writes its number.
        let mut xvfb = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", screen, "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("Xvfb did not start: {error}"))?;
        let mut number = String::new();
        if let Some(output) = xvfb.stdout.take() {
            BufReader::new(output).read_line(&mut number).map_err(|error| error.to_string())?;
        }
        let status = folder.path().join("status.jsonl");
        let display = format!(":{}", number.trim());
        let owned = |&(name, value): &(&'static str, &str)| (name, value.to_owned());
        let environment = environment.iter().map(owned).collect();
        let mut desk = Desk { display, status, xvfb, folder, window: None, scene, environment };
        desk.start()?;
        Ok(desk)
    }

    pub fn start(&mut self) -> Result<(), String> {
        let window = Command::new(env!("CARGO_BIN_EXE_msd"))
            .args(["view", self.scene].into_iter().filter(|_| !self.scene.is_empty()))
            .current_dir(&self.folder)
            .env("DISPLAY", &self.display)
            // A leftover of another session: this display no longer exists.
            .env("WAYLAND_DISPLAY", "wayland-gone")
            .env_remove("WAYLAND_SOCKET")
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env("MSD_STATUS", &self.status)
            .env("MSD_PREFERENCES", self.folder.path().join("preferences.json"))
            .envs(self.environment.iter().cloned())
            .stderr(Stdio::piped())
            .spawn()
            .expect("msd starts");
        let window = self.window.insert(window);
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Ok(Some(_)) = window.try_wait() {
                let mut text = String::new();
                window.stderr.take().map(|mut pipe| pipe.read_to_string(&mut text));
                // Two lines explain what the machine lacks; any other exit fails the test.
                assert!(text.contains("no graphics adapter"), "the window closed: {text}");
                return Err(text);
            }
            if self.status.metadata().is_ok_and(|data| 0 < data.len()) {
                self.xdotool("search --sync --onlyvisible --name ^msd windowfocus --sync");
                return Ok(());
            }
            sleep(Duration::from_millis(50));
        }
        panic!("no frame was drawn")
    }

    /// Closes the window with its shortcut, and opens another scene, or the default of `msd`.
    pub fn open_next(&mut self, scene: &'static str) {
        self.xdotool("key ctrl+q");
        assert_eq!(self.end().0, Some(0));
        std::fs::remove_file(&self.status).expect("the report of before");
        self.scene = scene;
        self.start().expect("another window");
    }

    /// Waits for the window to end; returns its exit code and its messages.
    pub fn end(&mut self) -> (Option<i32>, String) {
        let Some(mut window) = self.window.take() else { panic!("the window is gone") };
        let start = Instant::now();
        let status = loop {
            match window.try_wait().expect("it is our child") {
                Some(status) => break status,
                None => assert!(start.elapsed() < PATIENCE, "it does not end"),
            }
            sleep(Duration::from_millis(20));
        };
        let mut told = String::new();
        window.stderr.take().map(|mut pipe| pipe.read_to_string(&mut told));
        (status.code(), told)
    }

    /// Presses a key that may close the window.
    pub fn key(&self, name: &str) {
        let mut command = Command::new("xdotool");
        command.args(["key", name]).env("DISPLAY", &self.display);
        assert!(command.status().expect("xdotool is installed").success());
    }

    /// Moves the real pointer or presses a real key of the display.
    pub fn xdotool(&self, arguments: &str) {
        let mut command = Command::new("xdotool");
        command.args(arguments.split_whitespace()).env("DISPLAY", &self.display);
        let status = command.status().expect("xdotool is installed");
        assert!(status.success(), "xdotool {arguments} failed");
        // Two events in one frame would merge: a press and a jump would be a drag.
        self.settle();
    }

    /// Waits for the next frame or, while paused, until no frame follows.
    pub fn settle(&self) {
        let before = self.last()["frame"].as_u64();
        let start = Instant::now();
        while self.last()["frame"].as_u64() == before && start.elapsed().as_millis() < 700 {
            sleep(Duration::from_millis(10));
        }
        sleep(Duration::from_millis(20));
    }

    /// Returns the last complete line of the report.
    pub fn last(&self) -> Value {
        let read = || -> std::io::Result<String> {
            let mut file = File::open(&self.status)?;
            let length = file.metadata()?.len();
            file.seek(SeekFrom::Start(length.saturating_sub(16_000)))?;
            let mut text = String::new();
            file.read_to_string(&mut text)?;
            Ok(text)
        };
        let text = read().unwrap_or_default();
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let line = whole.lines().next_back().unwrap_or_default();
        serde_json::from_str(line).unwrap_or(Value::Null)
    }

    /// Returns the report of a frame.
    pub fn frame(&self, number: u64) -> Value {
        let text = std::fs::read_to_string(&self.status).expect("the report");
        let mut reports = text.lines().filter_map(|line| serde_json::from_str(line).ok());
        reports.find(|report: &Value| report["frame"] == number).expect("the frame")
    }

    /// Returns the wait channel and the system call of each thread of the window, by name. They
    /// show whether a hanging window sleeps or waits for a lock.
    fn threads(&self) -> String {
        let Some(window) = &self.window else { return "gone".into() };
        let folder = format!("/proc/{}/task", window.id());
        let tasks = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let told = tasks.map(|task| {
            let read = |file| std::fs::read_to_string(task.path().join(file)).unwrap_or_default();
            let number = read("syscall").split(' ').next().unwrap_or_default().trim().to_owned();
            format!("{} {} {number}", read("comm").trim(), read("wchan"))
        });
        told.collect::<Vec<_>>().join(", ")
    }

    /// Waits until the report satisfies a condition.
    pub fn wait(&self, what: &str, condition: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let last = self.last();
            // A partially read line may lack keys.
            if !last.is_null() && condition(&last) {
                return last;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "never: {what}; last report: {last}; its threads: {}",
                self.threads()
            );
            sleep(Duration::from_millis(20));
        }
    }

    /// Clicks in the middle of a landmark.
    pub fn click(&self, landmark: &str) {
        let there = self.wait(landmark, |now| !now["landmarks"][landmark].is_null());
        let [left, top, width, height]: [f64; 4] = numbers(&there["landmarks"][landmark]);
        self.move_to([left + 0.5 * width, top + 0.5 * height]);
        self.xdotool("click 1");
    }

    pub fn move_to(&self, [x, y]: [f64; 2]) {
        self.xdotool(&format!("mousemove {x:.0} {y:.0}"));
    }

    pub fn drag(&self, button: u32, from: [f64; 2], to: [f64; 2]) {
        self.move_to(from);
        self.xdotool(&format!("mousedown {button}"));
        for part in 1..=4 {
            let share = f64::from(part) / 4.0;
            self.move_to([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share));
        }
        self.xdotool(&format!("mouseup {button}"));
    }
}

pub fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|index| value[index].as_f64().unwrap_or(f64::NAN))
}

pub fn distance<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Opens a desk with `jelly` in the window, if the machine allows it.
pub fn desk(screen: &str) -> Option<Desk> {
    desk_with(screen, "jelly", &[])
}

/// Opens a desk with a scene in the window, with environment variables.
pub fn desk_with(
    screen: &str,
    scene: &'static str,
    environment: &[(&'static str, &str)],
) -> Option<Desk> {
    if_there(Desk::open(screen, scene, environment))
}

/// Returns what a test needs, or `None` if this machine lacks it and is allowed to.
pub fn if_there<T>(found: Result<T, String>) -> Option<T> {
    match found {
        Ok(found) => Some(found),
        Err(reason) if std::env::var_os("MSD_REQUIRE_WINDOW").is_none() => {
            eprintln!("SKIPPED: no window can be tested here: {reason}");
            None
        }
        Err(reason) => panic!("no window can be tested here: {reason}"),
    }
}
