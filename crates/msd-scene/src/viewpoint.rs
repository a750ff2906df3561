//! Viewpoints, from where a scene is looked at.

use serde::{Deserialize, Serialize};

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
