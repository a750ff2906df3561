//! Rows of looks and of the camera.

use serde::{Deserialize, Serialize};

/// What a body seems to be made of: the rest of its look where that is not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// Dull and even.
    Clay,
    /// Smooth with soft highlights.
    Plastic,
    /// Glossy, and light passes through thin parts.
    Jelly,
    /// Dull threads.
    Cloth,
    /// Mirrors in its own colour.
    Metal,
    /// Grained.
    Wood,
}

/// The name of a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PatternName {
    /// One colour.
    None,
    /// A chequerboard.
    Checks,
    /// Stripes.
    Stripes,
    /// Threads over and under each other.
    Weave,
    /// Wavy lines as in wood.
    Grain,
}

/// How a body looks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookRow {
    /// What it seems to be made of. Default by the kind of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish: Option<Finish>,
    /// Colour, `"#rrggbb"`. Default by the place of the body among the others; of wood brown, of
    /// metal grey.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour: Option<String>,
    /// Colour of the other side of a sheet, `"#rrggbb"`. Default a lighter shade.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub back: Option<String>,
    /// From 0, which mirrors, to 1, which is dull. Default that of the finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
    /// The share of light that passes thin parts, 0 to 1. Default that of the finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translucency: Option<f64>,
    /// What is repeated along the surface. Default that of the finish.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<PatternName>,
    /// Size of the pattern, metres. Default a part of the body that suits the pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern_size: Option<f64>,
}

/// From where a scene is looked at, unless the user says otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraRow {
    /// Azimuth about the vertical, degrees; at 0 the camera is on the +z side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_deg: Option<f64>,
    /// Elevation above the horizon, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pitch_deg: Option<f64>,
    /// What is in the middle of the picture, metres. Default the middle of the bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Distance from there, metres. Default as near as all bodies are in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
}
