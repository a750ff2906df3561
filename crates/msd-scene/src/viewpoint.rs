//! Viewpoints, from where a scene is looked at.

use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// The viewpoint that the author of a scene gives; missing parts follow from the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Viewpoint {
    /// Azimuth about the vertical, degrees; at 0 the camera is on the +z side.
    pub yaw_deg: Option<f64>,
    /// Elevation above the horizon, degrees; from −89 to 89.
    pub pitch_deg: Option<f64>,
    /// Point in the middle of the picture, metres.
    pub target: Option<[f64; 3]>,
    /// Distance from there, metres; positive.
    pub distance: Option<f64>,
}

/// A side from which pictures of a scene are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// A side: azimuth and elevation, degrees.
    Side([f64; 2]),
    /// A turn about the scene by so many degrees per second; one in a film by default.
    Orbit(Option<f64>),
}

impl FromStr for Sight {
    type Err = String;

    /// Reads `front`, `back`, `left`, `right`, `top`, `orbit` or `orbit:DEGREES`.
    fn from_str(text: &str) -> Result<Self, String> {
        let rate = |text: &str| text.parse().ok().filter(|rate: &f64| rate.is_finite());
        Ok(match (text, text.strip_prefix("orbit:").map(rate)) {
            ("front", _) => Sight::Side([0.0, 0.0]),
            ("back", _) => Sight::Side([180.0, 0.0]),
            ("right", _) => Sight::Side([90.0, 0.0]),
            ("left", _) => Sight::Side([-90.0, 0.0]),
            // Steeper there would be no up.
            ("top", _) => Sight::Side([0.0, 88.0]),
            ("orbit", _) => Sight::Orbit(None),
            (_, Some(Some(rate))) => Sight::Orbit(Some(rate)),
            _ => {
                return Err("must be front, back, left, right, top, orbit or orbit:DEGREES, \
                            degrees per second"
                    .into());
            }
        })
    }
}
