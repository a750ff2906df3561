//! Rows of how bodies touch.

use serde::{Deserialize, Serialize};

/// How the particles of a body touch each other and those of other bodies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TouchRow {
    /// Distance that its surface keeps on each side, or a rope without one on all, metres. It meets
    /// those of other bodies by impulses, without a stiffness. Default a tenth of the spacing; none
    /// where a body has a key of particles with a radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Radius of each particle, metres, instead of a thickness. Default 0.45 of the spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Stiffness of each particle, newtons per metre. Default an eighth of that of its springs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping of each particle, newton seconds per metre. Default by the relaxation time of the
    /// springs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Coulomb's factor. Default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Whether its surface touches by its triangles, not by its particles alone. Default false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangles: Option<bool>,
    /// Whether the body touches itself. Default true, but of a closed surface with a thickness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub itself: Option<bool>,
    /// Whether obstacles meet its particles with their radius too, not as points. Default false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstacles: Option<bool>,
    /// The names of bodies that it passes through.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ignore: Vec<String>,
    /// How it touches other bodies, where not as both say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<WithRow>,
}

/// How the particles of a body touch those of another.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithRow {
    /// The name of the other body.
    pub body: String,
    /// Stiffness of a pair of particles, newtons per metre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping of a pair, newton seconds per metre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Coulomb's factor of a pair.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}
