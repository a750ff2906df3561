//! Preferences: what the window remembers from one start to the next.

use glam::Vec3;
use msd_render::Camera;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The most scenes whose camera is remembered.
const MOST_CAMERAS: usize = 100;

/// The smallest and the largest scale of the panels.
const SCALES: (f32, f32) = (0.5, 3.0);

/// What the window remembers from one start to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Whether the panels are light. Default false.
    pub light: bool,
    /// Whether the panels are shown. Default true.
    pub panels: bool,
    /// Size of text and widgets as a multiple of what the display asks for. Default 1.
    pub scale: f32,
    /// Width and height of the window, points.
    pub size: Option<[f32; 2]>,
    /// What the last scene can be opened by.
    pub scene: Option<String>,
    /// How each scene was looked at last.
    pub cameras: BTreeMap<String, Outlook>,
    /// Whether the guide was offered: it was finished or skipped.
    pub is_guided: bool,
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
        }
    }
}

impl Preferences {
    /// Reads preferences from JSON; numbers out of their domain become those nearest to them.
    ///
    /// # Errors
    /// Text that is no preferences.
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

    /// The same as JSON.
    pub fn to_text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Remembers how a scene was looked at.
    pub fn keep_outlook(&mut self, scene: &str, outlook: Outlook) {
        if MOST_CAMERAS <= self.cameras.len() && !self.cameras.contains_key(scene) {
            self.cameras.clear();
        }
        self.cameras.insert(scene.to_owned(), outlook);
    }
}

/// A camera as it is remembered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outlook {
    /// The point looked at, metres.
    pub target: [f32; 3],
    /// How far that is beside the middle of everything, metres. Default 0.
    #[serde(default)]
    pub beside: [f32; 3],
    /// Distance from it, metres.
    pub distance: f32,
    /// Angle about the y axis, radians.
    pub yaw: f32,
    /// Angle above the horizon, radians.
    pub pitch: f32,
}

impl Outlook {
    /// A camera, and how far its target is beside the middle of everything, metres.
    pub fn of(camera: &Camera, beside: Vec3) -> Self {
        let Camera { target, distance, yaw, pitch, .. } = *camera;
        Outlook { target: target.to_array(), beside: beside.to_array(), distance, yaw, pitch }
    }

    /// The camera; the renderer takes numbers out of their domain as their default.
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
