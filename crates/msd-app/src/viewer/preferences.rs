//! Preferences: settings of the window that persist between sessions.

use glam::Vec3;
use msd_render::Camera;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of scenes with a stored camera.
const MOST_CAMERAS: usize = 100;

/// Smallest and largest scale of the panels.
const SCALES: (f32, f32) = (0.5, 3.0);

/// Settings of the window that persist between sessions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Whether the panels are light. Default false.
    pub light: bool,
    /// Whether the panels are shown. Default true.
    pub panels: bool,
    /// Size of text and widgets, relative to that of the display. Default 1.
    pub scale: f32,
    /// Width and height of the window, points.
    pub size: Option<[f32; 2]>,
    /// Name or path of the last scene.
    pub scene: Option<String>,
    /// Last camera of each scene.
    pub cameras: BTreeMap<String, Outlook>,
    /// Whether the user has finished or skipped the tour.
    pub is_guided: bool,
    /// Names of the lessons with a right answer.
    pub lessons: BTreeSet<String>,
}

impl Default for Preferences {
    fn default() -> Self {
        Preferences {
            light: false,
            panels: true,
            scale: 1.0,
            size: None,
            scene: None,
            cameras: BTreeMap::new(),
            is_guided: false,
            lessons: BTreeSet::new(),
        }
    }
}

impl Preferences {
    /// Reads preferences from JSON; numbers outside their domain are clamped.
    ///
    /// # Errors
    /// The text does not contain preferences.
    pub fn parse(text: &str) -> Result<Self, serde_json::Error> {
        let read: Preferences = serde_json::from_str(text)?;
        let scale = if read.scale.is_finite() { read.scale } else { 1.0 };
        let is_size = |size: &[f32; 2]| size.iter().all(|side| (100.0..=1e5).contains(side));
        Ok(Preferences {
            scale: scale.clamp(SCALES.0, SCALES.1),
            size: read.size.filter(is_size),
            ..read
        })
    }

    /// Returns the same as JSON.
    pub(crate) fn to_text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Stores the camera of a scene.
    pub(crate) fn keep_outlook(&mut self, scene: &str, outlook: Outlook) {
        if MOST_CAMERAS <= self.cameras.len() && !self.cameras.contains_key(scene) {
            self.cameras.clear();
        }
        self.cameras.insert(scene.to_owned(), outlook);
    }
}

/// A stored camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outlook {
    /// Target, metres.
    pub target: [f32; 3],
    /// Offset of the target from the centre of the scene, metres. Default 0.
    #[serde(default)]
    pub beside: [f32; 3],
    /// Distance from the target, metres.
    pub distance: f32,
    /// Angle about the y axis, radians.
    pub yaw: f32,
    /// Angle above the horizon, radians.
    pub pitch: f32,
}

impl Outlook {
    /// Stores a camera; `beside` is the offset of its target from the centre of the scene, metres.
    pub fn of(camera: &Camera, beside: Vec3) -> Self {
        let Camera { target, distance, yaw, pitch, .. } = *camera;
        Outlook { target: target.to_array(), beside: beside.to_array(), distance, yaw, pitch }
    }

    /// Returns the camera; the renderer replaces numbers outside their domain by their defaults.
    pub fn camera(&self) -> Camera {
        let Outlook { target, distance, yaw, pitch, .. } = *self;
        Camera { target: target.into(), distance, yaw, pitch, ..Camera::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_what_is_missing_has_its_default() {
        let mut written =
            Preferences { light: true, size: Some([800.0, 600.0]), ..Default::default() };
        let camera = Camera { yaw: 1.25, ..Camera::default() };
        written.keep_outlook("cube", Outlook::of(&camera, Vec3::X));
        let read = Preferences::parse(&written.to_text()).expect("preferences");
        assert_eq!(read, written);
        assert_eq!(read.cameras["cube"].camera().yaw, 1.25);
        assert_eq!(Preferences::parse("{}").expect("preferences"), Preferences::default());
    }

    #[test]
    fn damaged_text_is_refused_and_wild_numbers_are_tamed() {
        for text in ["", "{", "3", r#"{"light": 3}"#, r#"{"size": [1]}"#] {
            assert!(Preferences::parse(text).is_err(), "{text}");
        }
        let read = Preferences::parse(r#"{"scale": 1e9, "size": [0, -5], "unknown": 1}"#);
        let read = read.expect("preferences");
        assert_eq!((read.scale, read.size), (SCALES.1, None));
    }
}
