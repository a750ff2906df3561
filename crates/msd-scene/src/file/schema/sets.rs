//! Rows that choose particles of bodies: named sets, pins, masses, materials and links.

use super::KeyFrameRow;
use crate::file::keys::{Domain, Form, LENGTH, Live, Scale, Written, rows};
use serde::de::{Deserializer, Error, Unexpected, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A body or a solid, by its number or its name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum BodyKey {
    /// Counted from 0.
    Number(u64),
    /// The name that it has, or its kind where it has none.
    Name(String),
}

impl Default for BodyKey {
    fn default() -> Self {
        BodyKey::Number(0)
    }
}

impl Written for BodyKey {
    const FORM: Form = Form::Either(&[u64::FORM, Form::Text]);
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
        f.write_str("a whole number, not negative, or a name")
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

const BODY: Domain = Domain::Words("a body");
const SET: Domain = Domain::Words("the name of a set");

rows! {
    /// A named set: the particles of a body that are in a box or in a sphere at the start.
    SetRow {
        /// Name.
        name: String { domain: Domain::Words("text that no other set has") },
        /// Body: its number from 0, or its name.
        body: Option<BodyKey> = "0" { domain: BODY },
        /// A box along the axes.
        cuboid as "box": Option<BoxRow> = "one of the two",
        /// A sphere.
        sphere: Option<SphereRow> = "one of the two",
    }

    /// A box along the axes.
    BoxRow: Copy {
        /// Centre.
        position: [f64; 3] { unit: "m", domain: Domain::Place },
        /// The three sides.
        size: [f64; 3] { unit: "m", domain: LENGTH },
    }

    /// All points within a radius.
    SphereRow: Copy {
        /// Centre.
        position: [f64; 3] { unit: "m", domain: Domain::Place },
        /// Radius.
        radius: f64 { unit: "m", domain: LENGTH },
    }

    /// One or several particles held by hand.
    PinRow {
        /// Body: its number from 0, or its name.
        body: Option<BodyKey> = "0, or that of the set" { domain: BODY },
        /// The particle, counted from 0 in the body.
        particle: Option<i64> = "one of these four" { domain: Domain::Words("a particle") },
        /// `[row, column, stack]` of a particle of a lattice, counted from 0; row 0 is the lowest.
        at: Option<[u64; 3]> = "one of these four" { domain: Domain::Words("inside the lattice") },
        /// Every n-th particle of the top row of a lattice, starting with its first.
        every: Option<u64> = "one of these four" { domain: Domain::Count(u64::MAX, "at least 1") },
        /// The particles of a set.
        set: Option<String> = "one of these four" { domain: SET },
        /// Velocity of the pin.
        velocity: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m/s", domain: Domain::Vector },
        /// Later positions of the centre of the box around the particles, and rotations about
        /// it, in order of time; instead of `velocity`.
        key_frames: Option<Vec<KeyFrameRow>> = "none" { domain: Domain::Filled },
        /// Solid to move and turn with, instead of `velocity`: its number from 0, or its name.
        follow: Option<BodyKey> = "none" { domain: Domain::Words("a solid") },
        /// End of the pin: the particles are free from the end of the step that reaches it.
        until: Option<f64> = "never" { unit: "s", domain: Domain::Positive },
    }

    /// A mass on each of some particles, besides their own.
    MassRow {
        /// Body: its number from 0, or its name.
        body: Option<BodyKey> = "0, or that of the set" { domain: BODY },
        /// The particle, counted from 0 in the body.
        particle: Option<i64> = "one of these three" { domain: Domain::Words("a particle") },
        /// `[row, column, stack]` of a particle of a lattice, counted from 0; row 0 is the lowest.
        at: Option<[u64; 3]> = "one of these three" { domain: Domain::Words("inside the lattice") },
        /// The particles of a set.
        set: Option<String> = "one of these three" { domain: SET },
        /// Mass added to each.
        mass: f64 { unit: "kg", domain: Domain::Mass },
    }

    /// The material of the springs of a body that join two particles of a set.
    MaterialRow {
        /// Body: its number from 0, or its name.
        body: Option<BodyKey> = "0, or that of the set" { domain: BODY },
        /// The set; at least one spring joins two of its particles.
        set: String { domain: SET },
        /// Stiffness of each spring; bending springs of a mesh have their fraction of it.
        stiffness: Option<f64> = "that of the body"
            { unit: "N/m", domain: Domain::NotNegative, scale: Scale::SPRING },
        /// Damping of each spring.
        damping: Option<f64> = "that of the body"
            { unit: "N s/m", domain: Domain::NotNegative, scale: Scale::SPRING },
        /// Young's modulus; not of a woven cloth.
        young: Option<f64> = "that of the body" { unit: "Pa", domain: Domain::Positive },
        /// Viscosity divided by modulus.
        relaxation_time: Option<f64> = "that of the body"
            { unit: "s", domain: Domain::NotNegative },
    }

    /// Springs between two bodies, between particles of one, or to a solid: each particle of `from`
    /// is joined to the nearest of `to`.
    LinkRow {
        /// Particles to join.
        from: EndRow,
        /// Particles to join them to.
        to: EndRow,
        /// Largest distance to join.
        within: Option<f64> = "any" { unit: "m", domain: Domain::Positive },
        /// Length at which the spring exerts no force.
        rest_length: Option<f64> = "the distance of its ends"
            { unit: "m", domain: Domain::NotNegative },
        /// Factor on the rest lengths.
        rest_scale: Option<f64> = "1" { domain: Domain::Positive, live: Live::RestScale },
        /// Stiffness of each spring.
        stiffness: Option<f64> = "1000"
            { unit: "N/m", domain: Domain::NotNegative, live: Live::Stiffness },
        /// Damping of each spring.
        damping: Option<f64> = "0"
            { unit: "N s/m", domain: Domain::NotNegative, live: Live::Damping },
    }

    /// The particles at one end of links.
    EndRow {
        /// Body: its number from 0, or its name.
        body: Option<BodyKey> = "0, or that of the set" { domain: BODY },
        /// The particle, counted from 0 in the body.
        particle: Option<i64> = "one of these four" { domain: Domain::Words("a particle") },
        /// `[row, column, stack]` of a particle of a lattice, counted from 0; row 0 is the lowest.
        at: Option<[u64; 3]> = "one of these four" { domain: Domain::Words("inside the lattice") },
        /// Solid, only in `to`: its number from 0, or its name. msd joins each particle of `from`
        /// to the nearest point of its surface, which moves with the solid.
        solid: Option<BodyKey> = "one of these four" { domain: Domain::Words("a solid") },
        /// The particles of a set.
        set: Option<String> = "one of these four" { domain: SET },
    }
}
