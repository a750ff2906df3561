//! Rows that choose particles of bodies: named sets, pins, masses, materials and links.

use serde::de::{Deserializer, Error, Unexpected, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A body, by its number or its name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum BodyKey {
    /// Counted from 0.
    Number(u64),
    /// The name that it has, or its kind where it has none.
    Name(String),
}

impl<'de> Deserialize<'de> for BodyKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BodyVisitor)
    }
}

struct BodyVisitor;

impl Visitor<'_> for BodyVisitor {
    type Value = BodyKey;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a whole number, not negative, or the name of a body")
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<BodyKey, E> {
        Ok(BodyKey::Number(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<BodyKey, E> {
        let unexpected = Unexpected::Signed(number);
        u64::try_from(number).map(BodyKey::Number).map_err(|_| E::invalid_value(unexpected, &self))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<BodyKey, E> {
        Ok(BodyKey::Name(text.into()))
    }
}

/// A named set: the particles of a body that are in a box or in a sphere at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetRow {
    /// What rows call it.
    pub name: String,
    /// The body. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyKey>,
    /// The box.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<BoxRow>,
    /// The sphere, instead of the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sphere: Option<SphereRow>,
}

/// A box along the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxRow {
    /// Where its middle is, metres.
    pub position: [f64; 3],
    /// Its three sides, metres.
    pub size: [f64; 3],
}

/// All points within a radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereRow {
    /// Where its middle is, metres.
    pub position: [f64; 3],
    /// The radius, metres.
    pub radius: f64,
}

/// One or several particles held by hand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinRow {
    /// The body. Default 0, or that of the set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyKey>,
    /// The particle, counted in the body: not negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particle: Option<i64>,
    /// Row, column and stack of a particle of a lattice, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[u64; 3]>,
    /// Every n-th particle of the top row of a lattice, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<u64>,
    /// The name of a set, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
    /// Velocity it is moved with, metres per second. Default zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
}

/// A mass on each of some particles, besides their own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassRow {
    /// The body. Default 0, or that of the set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyKey>,
    /// The particle, counted in the body: not negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particle: Option<i64>,
    /// Row, column and stack of a particle of a lattice, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[u64; 3]>,
    /// The name of a set, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
    /// The mass on each of them, kilograms.
    pub mass: f64,
}

/// The material of the springs of a body that join two particles of a set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialRow {
    /// The body. Default 0, or that of the set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyKey>,
    /// The name of the set.
    pub set: String,
    /// Stiffness of each spring, newtons per metre. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping of each spring, newton seconds per metre. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Bodies of a material: Young's modulus, pascals. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub young: Option<f64>,
    /// Bodies of a material: viscosity over modulus, seconds. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxation_time: Option<f64>,
}

/// Springs between two bodies, or between particles of one: each particle of `from` is joined to
/// the nearest of `to`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkRow {
    /// The particles that are joined.
    pub from: EndRow,
    /// Those that they are joined to.
    pub to: EndRow,
    /// The largest distance of two particles that are joined, metres. Default any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
    /// Length without force, metres. Default the distance at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_length: Option<f64>,
    /// Stiffness of each spring, newtons per metre. Default 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping of each spring, newton seconds per metre. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}

/// The particles at one end of links.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndRow {
    /// The body. Default 0, or that of the set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyKey>,
    /// The particle, counted in the body: not negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particle: Option<i64>,
    /// Row, column and stack of a particle of a lattice, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[u64; 3]>,
    /// The name of a set, instead of `particle`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
}
