//! The machine and the date of a measurement.

/// The machine in words: processor, operating system, architecture.
pub fn name() -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let model = model.map_or("unknown processor", |(_, name)| name.trim());
    format!("{model}, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}

/// Today as year-month-day in universal time.
pub fn date() -> String {
    #[cfg(not(target_arch = "wasm32"))]
    let now = chrono::Utc::now();
    // A browser has a clock that the standard library does not know.
    #[cfg(target_arch = "wasm32")]
    let now = {
        let since = web_time::UNIX_EPOCH.elapsed().unwrap_or_default();
        chrono::DateTime::UNIX_EPOCH + since
    };
    now.format("%Y-%m-%d").to_string()
}
