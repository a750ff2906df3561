//! Scenes as written: rows of particles, springs, planes, pins and bodies, and the world.
//!
//! Rows are in `f64` whatever the precision of the run: precision is a setting, not a scene.

pub(crate) mod check;
mod air;
pub mod surface;
pub mod look;
pub mod lattice;
pub mod part;
pub mod substance;
pub mod shape;
pub mod distances;
pub mod solid;
pub mod shell;
mod origin;

pub use air::{Air, Gust};
pub use check::{MAX_PARTICLES, MAX_SPRINGS};
pub use distances::{DistanceGrid, MOST_POINTS};
pub use lattice::{Lattice, Neighbours};
pub use look::{Look, PALETTE, Pattern};
pub use part::{Material, Part};
pub use shell::{Between, Shell, any_meet, between, do_meet, law_between};
pub use solid::{KeyFrame, Shape, Solid};
pub use substance::{Bending, Elasticity, Substance};
pub use surface::{Corner, Surface};

use crate::number::Real;
use alloc::{collections::BTreeSet, string::String, vec::Vec};
use core::ops::Range;
use glam::DVec3;

/// A point with mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Particle {
    /// Position, metres.
    pub position: DVec3,
    /// Velocity, metres per second.
    pub velocity: DVec3,
    /// Mass, kilograms; positive and finite.
    pub mass: f64,
}

/// A spring and a damper in parallel between two particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spring {
    /// The two particles it joins; they must differ.
    pub ends: [usize; 2],
    /// Length without force, metres; not negative.
    pub rest_length: f64,
    /// Stiffness k, newtons per metre; not negative.
    pub stiffness: f64,
    /// Damping b along the spring, newton seconds per metre; not negative.
    pub damping: f64,
}

/// A resistance against bending: of three particles in a line, of four at the corners of a cell, or
/// of two triangles that share an edge.
///
/// It stores k s²/2, s = Σ w x being a weighted sum of their positions that is zero where they are
/// in a line, or in a plane. The force on a particle is −w (k s + b ŝ ŝ·s'), with ŝ the direction
/// of s: without damping it is linear. It keeps linear and angular momentum. Over the square of the
/// spacing s is a curvature, as long as the spacing does not change.
///
/// A bend that is curved at rest stores k |s − t m|² cos² φ0/2: with e = x1 − x0, f = w2 (x2 − x0)
/// − w3 (x3 − x0) and m = e × f/|e|, triangles that keep their shape have s = L sin φ n and m = L
/// cos φ n, φ being half of the angle between them and n their normal. At rest it is φ0, and t =
/// tan φ0. So it stores k L² sin²(φ − φ0)/2, which does not jump where the triangles are folded
/// onto each other and through. It is largest at half a turn from rest. Its damper acts against
/// changes of φ, of which there are none where it turns as a whole.
///
/// Source of the quadratic energy: Bergou, Wardetzky, Harmon, Zorin and Grinspun, 2006.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bend {
    /// The particles.
    pub particles: [usize; 4],
    /// The weight of each; they add up to 0. A particle of weight 0 takes no part in a bend that is
    /// straight at rest.
    pub weights: [f64; 4],
    /// Tangent t of half the angle between the triangles at rest, no unit, of the sign of s·n; 0
    /// for one that is straight at rest. Others need four different particles.
    pub rest: f64,
    /// Stiffness k, newtons per metre; not negative.
    pub stiffness: f64,
    /// Damping b, newton seconds per metre; not negative.
    pub damping: f64,
}

/// Two triangles of a smaller angle, radians, count as in a plane.
const STRAIGHT: f64 = 1e-9;
/// The largest tangent of half an angle at rest: of triangles that are folded onto each other.
const STEEPEST: f64 = 1e6;

impl Bend {
    /// A bend of three particles, one after the other at equal distances a: s = x0 − 2 x1 + x2 is
    /// a² times the curvature of the line through them.
    pub fn line([a, b, c]: [usize; 3], stiffness: f64, damping: f64) -> Self {
        let (particles, weights) = ([a, b, c, c], [1.0, -2.0, 1.0, 0.0]);
        Bend { particles, weights, rest: 0.0, stiffness, damping }
    }

    /// A bend of the corners of a square cell of side a, of which the second and the third lie
    /// opposite each other: s = x0 − x1 − x2 + x3 is a² times the twist of the surface.
    pub fn twist(particles: [usize; 4], stiffness: f64, damping: f64) -> Self {
        Bend { particles, weights: [1.0, -1.0, -1.0, 1.0], rest: 0.0, stiffness, damping }
    }

    /// A bend of two triangles that share the edge from the first particle to the second, at rest
    /// at these four positions. The other corners are the third and the fourth. Of a sheet of the
    /// bending stiffness B, newton metres, without damping.
    ///
    /// With l the length of the edge, h2 and h3 the heights above it and θ the angle between the
    /// triangles, 0 where they are in a plane, L is 2 h, h = 2 h2 h3/(h2 + h3), and φ is θ/2. A
    /// small change of θ stores B l² (θ − θ0)²/(2 A), where A is the area of both: equilateral
    /// triangles bend as a plate, others do not, see `docs/explanation/materials.md`.
    ///
    /// `None` where a triangle has no area.
    pub fn hinge(particles: [usize; 4], at: [DVec3; 4], bending: f64) -> Option<Self> {
        let [edge, c, d] = [1, 2, 3].map(|end| at[end] - at[0]);
        let square = edge.dot(edge);
        let feet = [c, d].map(|side| side.dot(edge) / square);
        let [c, d] = [c - edge * feet[0], d - edge * feet[1]];
        let heights = [c, d].map(|side| Real::sqrt(side.dot(side)));
        if !heights.into_iter().all(|height| 0.0 < height * square && height.is_finite()) {
            return None;
        }
        let [low, high] = heights;
        let weights = [2.0 * high / (low + high), 2.0 * low / (low + high)];
        let second = -(weights[0] * feet[0] + weights[1] * feet[1]);
        let weights = [-(weights[0] + weights[1]) - second, second, weights[0], weights[1]];
        // Where they are in a plane, c and d are opposite.
        let (sum, other) = (c * weights[2] + d * weights[3], c * weights[2] - d * weights[3]);
        let [sine, cosine] =
            [sum, other].map(|arm| Real::sqrt(arm.dot(arm)) / (2.0 * weights[2] * low));
        let sign = edge.cross(other).dot(sum).signum();
        let is_straight = 2.0 * sine < STRAIGHT;
        let rest = if is_straight { 0.0 } else { sign * Real::min(sine / cosine, STEEPEST) };
        // A sharp edge is not a plate.
        let softer = Real::min(2.0 * cosine * cosine, 1.0);
        let area = 0.5 * Real::sqrt(square) * (low + high);
        let reach = weights[2] * low;
        let stiffness = softer * bending * square / (area * reach * reach);
        Some(Bend { particles, weights, rest, stiffness, damping: 0.0 })
    }
}

/// A resistance against a change of volume: of a cell of eight particles.
///
/// With V the volume of the cell, whose faces may be warped (that of the trilinear map of a cube),
/// V0 that at rest and e = V/V0 − 1, it stores Λ V0 e²/2. Where Λ is negative it takes away energy
/// from that of springs, less where a cell is far from its rest: Λ V0 e²/(2 + 4/3 e + 2 e²). The
/// force on a particle is −(Λ e + c e') ∂V/∂x. It keeps linear and angular momentum.
///
/// Source: Kot and Nagahashi, 2015, who add an energy of the volume to springs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Volume {
    /// The particles at the corners, those along x first, then along y and z.
    pub particles: [usize; 8],
    /// Volume without force, cubic metres; positive.
    pub rest_volume: f64,
    /// Modulus Λ, pascals.
    pub modulus: f64,
    /// Damping c, pascal seconds; of the sign of the modulus.
    pub damping: f64,
}

/// Friction of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Friction {
    /// Coulomb's law: a tangential impulse of at most this factor times the normal impulse.
    Coulomb(f64),
    /// The source report's law: each contact substep takes away this fraction (0 to 1) of the
    /// tangential velocity. It depends on the substep and does not converge; kept for comparison.
    TangentialLoss(f64),
}

/// A half space that particles cannot enter: n·x ≥ offset.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Plane {
    /// Direction out of the solid; any length but zero, it is normalised.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along the normal, metres.
    pub offset: f64,
    /// Fraction of the normal speed that a bounce returns, 0 to 1.
    pub restitution: f64,
    /// Friction along the plane.
    pub friction: Friction,
}

/// A pinned particle: it keeps its velocity whatever force acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pin {
    /// The particle.
    pub particle: usize,
    /// Velocity it is moved with, metres per second; zero holds it still.
    pub velocity: DVec3,
}

/// Pinned particles that move together until a time: with a solid, steadily or through key frames.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Guide {
    /// Each particle, with its place from the middle of its leader, in the axes of that, metres.
    pub held: Vec<(usize, DVec3)>,
    /// The motion that leads them.
    pub lead: Lead,
    /// When they are free, seconds, at the end of a step; `None` for never.
    pub until: Option<f64>,
}

impl Guide {
    /// The key frames of the motion that leads it, in a scene with these solids.
    pub fn keys<'a>(&'a self, solids: &'a [Solid]) -> &'a [KeyFrame] {
        match &self.lead {
            Lead::Solid(solid) => &solids[*solid].keys,
            Lead::Path { keys, .. } => keys,
        }
    }
}

/// The motion that leads pinned particles.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Lead {
    /// That of a solid, by its number.
    Solid(usize),
    /// One of their own, which starts along the axes of the world.
    Path {
        /// When it starts, seconds: 0 unless a run starts later on its way.
        since: f64,
        /// Their middle at the start, metres.
        position: DVec3,
        /// Velocity, metres per second; zero with key frames.
        velocity: DVec3,
        /// Key frames that they move through, as a solid does.
        keys: Vec<KeyFrame>,
    },
}

/// A named run of particles and springs.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its particles.
    pub particles: Range<usize>,
    /// Its springs.
    pub springs: Range<usize>,
    /// Its surface; empty for a rope.
    pub surface: Surface,
    /// Its appearance.
    pub look: Look,
}

/// The world: gravity, a uniform force, drag, air and a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct World {
    /// Gravitational acceleration, metres per second squared. Default (0, −9.82, 0).
    pub gravity: DVec3,
    /// A uniform force on every particle, newtons. Default zero.
    pub force: DVec3,
    /// Air drag, newton seconds per metre: a force −drag · v on every particle. Default 0.
    pub drag: f64,
    /// The air that acts on surfaces. Default none.
    pub air: Option<Air>,
    /// Bound of every coordinate, metres; a particle beyond it has diverged. Default 1e6.
    pub extent: f64,
}

impl Default for World {
    fn default() -> Self {
        let gravity = DVec3::new(0.0, -9.82, 0.0);
        Self { gravity, force: DVec3::ZERO, drag: 0.0, air: None, extent: 1e6 }
    }
}

/// Everything a simulation starts from.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Scene {
    /// Gravity, the uniform force, drag, air and the bound of the world.
    pub world: World,
    /// The particles, in the order of the state file.
    pub particles: Vec<Particle>,
    /// The springs.
    pub springs: Vec<Spring>,
    /// The bends, which resist bending.
    pub bends: Vec<Bend>,
    /// The volumes, which resist a change of volume.
    pub volumes: Vec<Volume>,
    /// The planes.
    pub planes: Vec<Plane>,
    /// The solids.
    pub solids: Vec<Solid>,
    /// Surfaces, ropes and points that do not cross each other.
    pub shells: Vec<Shell>,
    /// The pins.
    pub pins: Vec<Pin>,
    /// Guides of pinned particles. They are not written with the rows: they are a part of a
    /// [`Progress`](crate::Progress).
    #[cfg_attr(feature = "serde", serde(skip))]
    pub guides: Vec<Guide>,
    /// Named parts; a particle need not belong to one.
    pub bodies: Vec<Body>,
}

impl Scene {
    /// The particles that guides hold.
    pub fn guided(&self) -> BTreeSet<usize> {
        self.guides.iter().flat_map(|guide| &guide.held).map(|&(particle, _)| particle).collect()
    }

    /// Size of the largest body, metres, see [`Model::size`](crate::Model::size).
    pub(crate) fn size(&self) -> f64 {
        let diagonal = |particles: &[Particle]| {
            let mut positions = particles.iter().map(|particle| particle.position);
            let first = positions.next().unwrap_or_default();
            let grow = |(low, high): (DVec3, DVec3), x: DVec3| (low.min(x), high.max(x));
            let (low, high) = positions.fold((first, first), grow);
            let across = high - low;
            Real::sqrt(across.dot(across))
        };
        let bodies = self.bodies.iter().map(|body| &self.particles[body.particles.clone()]);
        let largest = bodies.map(diagonal).fold(0.0, f64::max);
        let whole = || diagonal(&self.particles);
        let longest = || self.springs.iter().map(|spring| spring.rest_length).fold(0.0, f64::max);
        let positive = |size: &f64| 0.0 < *size;
        let found = Some(largest).filter(positive).or_else(|| Some(whole()).filter(positive));
        found.or_else(|| Some(longest()).filter(positive)).unwrap_or(1.0)
    }

    /// The scene for a run that starts at time 0 and continues another one from a time, seconds:
    /// solids and guided pins are as far on their ways. The particles stay.
    pub fn from_time(mut self, now: f64) -> Self {
        let earlier = |since: &mut f64, keys: &mut [KeyFrame]| {
            *since -= now;
            keys.iter_mut().for_each(|key| key.time -= now);
        };
        self.solids.iter_mut().for_each(|solid| earlier(&mut solid.since, &mut solid.keys));
        self.guides.retain(|guide| guide.until.is_none_or(|until| now < until));
        for guide in &mut self.guides {
            guide.until = guide.until.map(|until| until - now);
            if let Lead::Path { since, keys, .. } = &mut guide.lead {
                earlier(since, keys);
            }
        }
        self
    }
}
