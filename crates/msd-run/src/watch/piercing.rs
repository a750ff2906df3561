//! Piercings: solids that go through surfaces, between particles that they push aside.

use crate::{Runner, on};
use msd_core::glam::DVec3;
use msd_core::obstacles::Placed;
use msd_core::{Body, Lead, Model, Real, Shape, Solid, Vector};
use serde::Serialize;
use std::collections::BTreeSet;
use std::ops::Range;

/// Least depth of a piercing in a solid, in thicknesses: half of one is the middle. Triangles that
/// cut an edge of a solid off are less deep.
const DEEP: f64 = 0.375;
/// The longest way from one place of a triangle that is looked at to the next, in thicknesses.
const STRIDE: f64 = 0.1;
/// The most places of a triangle in a step.
const MOST_PLACES: f64 = 256.0;
/// The most steps between two looks.
const MOST_STEPS: u64 = 8;
/// Number of times that a triangle is divided in four.
const DIVISIONS: u32 = 4;

/// The first triangle seen to be pierced.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pierced {
    /// The solid, by its number.
    pub solid: usize,
    /// The body whose surface it went through, by its number.
    pub body: usize,
    /// When, simulated seconds.
    pub time: f64,
}

/// Watches a run for solids that go through the surfaces of bodies.
#[derive(Clone, Debug, Default)]
pub struct Piercing {
    /// Positions of the particles at the last look, metres, with its time, seconds, and its step.
    before: Vec<DVec3>,
    since: (f64, u64),
    first: Option<Pierced>,
}

impl Piercing {
    /// Looks at a run, best after each step: between two looks particles move in straight lines.
    /// After a run went back, the watch starts anew.
    pub fn look(&mut self, runner: &Runner) {
        let (time, steps) = (runner.time(), runner.steps());
        if steps < self.since.1 {
            *self = Piercing::default();
        }
        if self.first.is_some() {
            self.since.1 = steps;
            return;
        }
        on!(runner, simulation => {
            let model = simulation.model();
            let has_any = model.bodies().iter().any(|body| !body.surface.triangles.is_empty());
            if has_any && model.solids().iter().any(is_pointed) {
                let now: Vec<_> = simulation.positions().map(Vector::to_f64).collect();
                if self.before.len() == now.len() && steps - self.since.1 <= MOST_STEPS {
                    self.first = self.find(model, &now, time);
                }
                (self.before, self.since) = (now, (time, steps));
            }
        });
    }

    /// The first piercing; `None` if nothing was pierced.
    pub fn first(&self) -> Option<Pierced> {
        self.first
    }

    fn find<R: Real>(&self, model: &Model<R>, now: &[DVec3], time: f64) -> Option<Pierced> {
        let bodies: Vec<_> = model.bodies().iter().map(|body| self.bounds(body, now)).collect();
        let mut ways = Vec::new();
        for (number, solid) in model.solids().iter().enumerate() {
            if !is_pointed(solid) {
                continue;
            }
            let approach = Approach::new(solid, self.since.0, time);
            for (at, (body, bounds)) in model.bodies().iter().zip(&bodies).enumerate() {
                let Some(bounds) = bounds.as_ref().filter(|bounds| approach.comes_near(bounds))
                else {
                    continue;
                };
                let Range { start, end } = bounds.particles;
                let both = self.before[start..end].iter().zip(&now[start..end]);
                ways.clear();
                ways.extend(both.map(|(&from, &to)| approach.way(from, to)));
                let anchors = anchors(model, number);
                let is_pierced = body.surface.particles().any(|particles| {
                    let corners = particles.map(|particle| particle as usize);
                    let is_anchored = corners.iter().any(|corner| anchors.contains(corner));
                    !is_anchored && approach.pierces(corners.map(|corner| ways[corner - start]))
                });
                if is_pierced {
                    return Some(Pierced { solid: number, body: at, time });
                }
            }
        }
        None
    }

    /// The bounds of the surface of a body since the last look; `None` without a surface. A program
    /// may have made the surface of particles of other bodies.
    fn bounds(&self, body: &Body, now: &[DVec3]) -> Option<Bounds> {
        let corners = || body.surface.corners.iter().map(|corner| corner.particle as usize);
        let particles = corners().min()?..corners().max()? + 1;
        let both = [&self.before, now].map(|places| &places[particles.clone()]);
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = both
            .into_iter()
            .flatten()
            .fold(empty, |(low, high), place| (low.min(*place), high.max(*place)));
        Some(Bounds { particles, low, high })
    }
}

/// The particles that are pinned inside a solid and follow it.
fn anchors<R: Real>(model: &Model<R>, solid: usize) -> BTreeSet<usize> {
    let shape = &model.solids()[solid].shape;
    let followers = model.guides().filter(|guide| guide.lead == Lead::Solid(solid));
    let held = followers.flat_map(|guide| &guide.held);
    held.filter(|(_, place)| shape.gap(*place) < 0.0).map(|&(particle, _)| particle).collect()
}

/// Returns whether a solid can go through a surface: a half space is everywhere.
fn is_pointed(solid: &Solid) -> bool {
    solid.shape != Shape::HalfSpace
}

/// From one side to the other, metres. A mesh may have ears: the gaps of a shape four cells thick
/// are known well enough.
fn thickness(shape: &Shape) -> f64 {
    let cells = if matches!(shape, Shape::Mesh(_)) { 4.0 } else { 1.0 };
    cells * shape.thickness()
}

/// The range of the particles of a surface, and the box around their ways, metres.
struct Bounds {
    particles: Range<usize>,
    low: DVec3,
    high: DVec3,
}

/// The way of a particle between two times, as seen from a solid, metres.
#[derive(Clone, Copy)]
struct Travel {
    from: DVec3,
    to: DVec3,
    length: f64,
    /// From the surface of the solid at the end.
    gap: f64,
}

/// A solid at two times.
struct Approach<'s> {
    shape: &'s Shape,
    placed: [Placed<'s>; 2],
    thickness: f64,
    reach: f64,
}

impl<'s> Approach<'s> {
    fn new(solid: &'s Solid, from: f64, to: f64) -> Self {
        let placed = [from, to].map(|time| Placed::new(solid, time));
        let shape = &solid.shape;
        Approach { shape, placed, thickness: thickness(shape), reach: shape.reach() }
    }

    /// The way of a particle as seen from the solid.
    fn way(&self, from: DVec3, to: DVec3) -> Travel {
        let [first, last] = &self.placed;
        let [from, to] = [(first, from), (last, to)]
            .map(|(placed, place)| placed.axes.transpose() * (place - placed.middle));
        let gap = self.shape.gap(to);
        Travel { from, to, length: from.distance(to), gap }
    }

    /// Returns whether the box of a surface comes as near as the solid reaches.
    fn comes_near(&self, bounds: &Bounds) -> bool {
        let [first, last] = &self.placed;
        let nearest = last.middle.max(bounds.low).min(bounds.high);
        nearest.distance(last.middle) <= self.reach + first.middle.distance(last.middle)
    }

    /// Whether a triangle is pierced on the way.
    fn pierces(&self, corners: [Travel; 3]) -> bool {
        let [a, b, c] = corners;
        let longest = a.length.max(b.length).max(c.length);
        // No point of it is farther from a corner than the longer side there.
        let side = a.to.distance(b.to).max(a.to.distance(c.to));
        if longest + side <= a.gap + DEEP * self.thickness {
            return false;
        }
        let places = (longest / (STRIDE * self.thickness)).ceil().clamp(1.0, MOST_PLACES);
        (1..=places as u32).any(|place| {
            let part = f64::from(place) / places;
            let there = [a, b, c].map(|way| way.from.lerp(way.to, part));
            self.is_deep(there, DIVISIONS)
        })
    }

    /// Whether a triangle has points deep in the solid.
    fn is_deep(&self, corners: [DVec3; 3], divisions: u32) -> bool {
        let (middle, radius) = ball(corners);
        let beyond = self.shape.gap(middle) + DEEP * self.thickness;
        if beyond < 0.0 || radius <= beyond || divisions == 0 {
            return beyond < 0.0;
        }
        let [a, b, c] = corners;
        let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
        parts.into_iter().any(|part| self.is_deep(part, divisions - 1))
    }
}

/// A ball around a triangle: its middle, and its radius.
fn ball(corners: [DVec3; 3]) -> (DVec3, f64) {
    let middle = corners.iter().sum::<DVec3>() / 3.0;
    (middle, corners.map(|corner| corner.distance(middle)).into_iter().fold(0.0, f64::max))
}
