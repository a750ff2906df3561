//! Rows of the air that acts on surfaces.

use serde::{Deserialize, Serialize};

/// The air that acts on surfaces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirRow {
    /// Density, kilograms per cubic metre. Default 1.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Velocity of the mean wind, metres per second. Default zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Drag coefficient of a sheet face-on. Default 1.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drag: Option<f64>,
    /// Lift coefficient. Default 0.98 times that of the drag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lift: Option<f64>,
    /// Gusts beside the mean wind. Default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gust: Option<GustRow>,
}

/// Gusts: a random velocity of the air, smooth in space and time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GustRow {
    /// Root mean square of the velocity, metres per second. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strength: Option<f64>,
    /// Length of a gust, metres. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Time in which gusts change, seconds. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// The seed. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u32>,
}
