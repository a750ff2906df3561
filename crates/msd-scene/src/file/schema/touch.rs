//! Rows of how bodies meet.

use serde::{Deserialize, Serialize};

/// How a body meets itself and others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TouchRow {
    /// Distance that its surface keeps on each side, or a rope or a particle on all sides, metres.
    /// Default a tenth of the spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Coulomb's factor. Default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Coefficient of restitution. Default 0: a soft body bounces by its own springs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Whether the body meets itself. Default true, but false of a block or a solid mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub itself: Option<bool>,
    /// Whether it keeps its thickness from obstacles too; else they meet its particles as points.
    /// Default false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstacles: Option<bool>,
    /// The names of bodies that it passes through.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ignore: Vec<String>,
    /// How it meets single other bodies, in place of what follows from both.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<WithRow>,
    /// The older name of the thickness, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Of older files, newtons per metre: without effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Of older files, newton seconds per metre: without effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Of older files: without effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangles: Option<bool>,
}

/// How a body meets another.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithRow {
    /// The name of the other body.
    pub body: String,
    /// Coulomb's factor of the two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Coefficient of restitution of the two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Of older files, newtons per metre: without effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Of older files, newton seconds per metre: without effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}
