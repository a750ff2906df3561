//! Results measured so far, looked up by the table of targets.

use super::race::Speed;

/// A speed, and the work on which it was measured.
struct Entry {
    work: String,
    /// Precision or method: which of several races on a work.
    class: String,
    speed: Speed,
}

/// All results.
#[derive(Default)]
pub struct Results(Vec<Entry>);

impl Results {
    /// Records a race.
    pub fn add(&mut self, work: &str, class: &str, speeds: &[Speed]) {
        let entry =
            |speed: &Speed| Entry { work: work.into(), class: class.into(), speed: speed.clone() };
        self.0.extend(speeds.iter().map(entry));
    }

    /// Best speed of one that took part in a race, updates per second.
    pub fn best(&self, work: &str, class: &str, name: &str) -> Option<f64> {
        let is =
            |entry: &&Entry| entry.work == work && entry.class == class && entry.speed.name == name;
        self.0.iter().find(is).map(|entry| entry.speed.best)
    }
}

/// The speed of one name in a race.
pub fn of<'a>(speeds: &'a [Speed], name: &str) -> Option<&'a Speed> {
    speeds.iter().find(|speed| speed.name == name)
}

/// Best and median in giga-updates per second.
pub fn in_words(speed: Option<&Speed>) -> String {
    let words = |speed: &Speed| format!("{:.2} ({:.2})", 1e-9 * speed.best, 1e-9 * speed.median);
    speed.map_or("-".into(), words)
}
