//! Air on surfaces: drag and lift of triangles, and gusts.
//!
//! A triangle of area A and unit normal n, whose corners move at the mean velocity v through air of
//! density ρ and velocity w, has the relative velocity u = v − w and feels
//!
//! F = −½ ρ A |u| ((C_d − C_l) u + C_l (u·n) n),
//!
//! a third at each corner. With α the angle between sheet and wind, its drag coefficient is
//! C_d sin²α + (C_d − C_l) cos²α and its lift coefficient C_l sin α cos α: those of a flat plate
//! (Hoerner, 1965). C_d is the drag face-on, C_d − C_l that edge-on. Forces on triangles from their
//! own relative velocity follow Wejchert and Haumann, 1991, the coefficients of drag and lift
//! Keckeisen, Kimmerle, Thomaszewski and Wacker, 2004. There is no wake: no triangle shelters
//! another.
//!
//! A side of a triangle takes the share (1 + s)/2 of that force, with s the cosine between u and
//! the normal of that side. It takes all where it faces the wind, none in the lee. A sheet has two
//! sides, which add up to the force above; a triangle of a closed surface has the outer one.
//!
//! F·u ≤ 0 as 0 ≤ C_l ≤ C_d: still air only dissipates. The damping matrix, with û = u/|u| and
//! s = û·n, is
//!
//! D = ½ ρ A |u| ((C_d − C_l) (1 + û ûᵀ) + C_l (1 + s²) n nᵀ).
//!
//! It is −∂F/∂v but for the change of the lift with the speed along the sheet, which is not
//! symmetric, and of the share of a side. Both vanish face-on and edge-on. The derivative by
//! positions, which is not symmetric either, is left out: solves take it as constant.
//!
//! Gusts are eight plane waves of equal amplitude, with wave vectors, polarisations and phases from
//! the seed. Each moves the air across its wave vector, so that the air is incompressible. Wave
//! lengths are from 0.5 to 2 times the length of a gust, periods from 0.5 to 2 times its time, in
//! the frame of the mean wind (Taylor, 1938).

use super::{Blocks, Element, Force, Motion, Products, Torn, Vectors};
use crate::columns::slots::Slots;
use crate::number::{Real, Vector};
use crate::scene::{Air, Body, Gust, Scene};
use alloc::vec::Vec;
use core::f64::consts::TAU;
use glam::DVec3;

/// The air and the triangles that it acts on.
#[derive(Clone, Debug)]
pub struct AirLoads {
    air: Air,
    /// `None` without gusts.
    waves: Option<Waves>,
    triangles: Vec<Triangle>,
}

/// A triangle that the air acts on.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [u32; 3],
    /// Whether both sides are in the air.
    two_sided: bool,
}

/// A triangle in the air at a motion.
struct Flow<R: Real> {
    /// The normal, its length twice the area, m².
    normal: R::Vec3,
    /// Twice the area, m².
    doubled: R,
    /// The mean velocity of the corners, and that relative to the air, m/s.
    velocity: R::Vec3,
    relative: R::Vec3,
    /// The relative speed, m/s.
    speed: R,
    /// The share of the force that acts on the sides in the air.
    share: R,
}

impl AirLoads {
    /// The air on the surfaces of bodies.
    pub fn new(air: &Air, bodies: &[Body]) -> Self {
        let waves = (air.gust.strength != 0.0).then(|| Waves::new(&air.gust, air.velocity));
        let mut loads = AirLoads { air: *air, waves, triangles: Vec::new() };
        bodies.iter().for_each(|body| loads.add(body));
        loads
    }

    /// The air.
    pub fn air(&self) -> &Air {
        &self.air
    }

    /// Adds the surface of a body.
    pub(crate) fn add(&mut self, body: &Body) {
        let two_sided = body.surface.two_sided;
        let found = body.surface.particles().map(|corners| Triangle { corners, two_sided });
        self.triangles.extend(found);
    }

    /// The velocity of the air at a point and a time, metres per second.
    pub fn velocity_at(&self, point: DVec3, time: f64) -> DVec3 {
        let phases = self.waves.as_ref().map(|waves| waves.phases(time));
        self.wind(phases.as_ref(), point)
    }

    fn wind(&self, phases: Option<&Phases>, point: DVec3) -> DVec3 {
        let gust = |(waves, phases): (&Waves, &Phases)| waves.velocity(phases, point);
        self.air.velocity + self.waves.as_ref().zip(phases).map_or(DVec3::ZERO, gust)
    }

    /// The triangles that feel the air at a motion: those with an area and a relative velocity.
    fn flows<'a, R: Real>(
        &'a self,
        motion: &'a Motion<'_, R>,
    ) -> impl Iterator<Item = ([usize; 3], Flow<R>)> + 'a {
        let phases = self.waves.as_ref().map(|waves| waves.phases(motion.time()));
        let mean = R::Vec3::of(self.air.velocity);
        let third = R::of(1.0 / 3.0);
        self.triangles.iter().filter_map(move |triangle| {
            let corners = triangle.corners.map(|corner| corner as usize);
            let [a, b, c] = corners.map(|corner| motion.position(corner));
            let normal = (b - a).cross(c - a);
            let [va, vb, vc] = corners.map(|corner| motion.velocity(corner));
            let velocity = (va + vb + vc) * third;
            let wind = match &phases {
                Some(_) => {
                    let centre = (a + b + c) * third;
                    R::Vec3::of(self.wind(phases.as_ref(), centre.to_f64()))
                }
                None => mean,
            };
            let relative = velocity - wind;
            let (doubled, speed) = (normal.dot(normal).sqrt(), relative.dot(relative).sqrt());
            // Neither has a direction otherwise; a NaN goes on, for the guard to see.
            if doubled == R::ZERO || speed == R::ZERO {
                return None;
            }
            let share = if triangle.two_sided {
                R::ONE
            } else {
                R::HALF + R::HALF * (relative.dot(normal) / doubled / speed)
            };
            Some((corners, Flow { normal, doubled, velocity, relative, speed, share }))
        })
    }
}

impl<R: Real> Force<R> for Option<AirLoads> {
    fn element(&self) -> Option<&dyn Element<R>> {
        let acting = self.as_ref().filter(|air| !air.triangles.is_empty());
        acting.map(|air| air as &dyn Element<R>)
    }

    fn count(&self) -> usize {
        self.as_ref().map_or(0, |air| air.triangles.len())
    }

    fn add(&mut self, scene: &Scene, _: &Slots) {
        self.iter_mut().for_each(|air| scene.bodies.iter().for_each(|body| air.add(body)));
    }

    fn write(&self, scene: &mut Scene) {
        scene.world.air = self.as_ref().map(|air| air.air);
    }

    fn tear(&mut self, torn: &Torn) {
        self.iter_mut().for_each(|air| {
            air.triangles.retain(|triangle| !torn.crosses(&triangle.corners));
        });
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool) {
        self.iter_mut().for_each(|air| {
            air.triangles.retain(|triangle| !triangle.corners.into_iter().any(is_removed));
        });
    }
}

impl<R: Real> Element<R> for AirLoads {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        // Of a corner, for twice the area.
        let factor = self.air.density / 12.0;
        let along = R::of(factor * (self.air.drag - self.air.lift));
        let across = R::of(factor * self.air.lift);
        let mut power = 0.0;
        for (corners, flow) in self.flows(motion) {
            let Flow { normal, doubled, velocity, relative, speed, share } = flow;
            let slope = across * (relative.dot(normal) / doubled);
            let force = (relative * (along * doubled) + normal * slope) * -(share * speed);
            corners.into_iter().for_each(|corner| forces.add(corner, force));
            power -= 3.0 * force.dot(velocity).to_f64();
        }
        power
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        for (corners, flow) in self.flows(motion) {
            let [a, b, c] = corners.map(|corner| direction[corner]);
            let change = self.damping(&flow, a + b + c);
            corners.into_iter().for_each(|corner| products.damping[corner] += change);
        }
    }

    fn add_blocks(&self, motion: &Motion<'_, R>, blocks: &mut Blocks<'_>) {
        for (corners, flow) in self.flows(motion) {
            let [x, y, z] = DVec3::AXES.map(|axis| self.damping(&flow, axis));
            let block = [x.x, x.y, x.z, y.y, y.z, z.z];
            for corner in corners {
                let sums = blocks.damping[corner].iter_mut();
                sums.zip(block).for_each(|(sum, number)| *sum += number);
            }
        }
    }
}

impl AirLoads {
    /// The part of D that joins two corners, a ninth of it, times a direction, N.
    fn damping<R: Real>(&self, flow: &Flow<R>, direction: DVec3) -> DVec3 {
        let (doubled, speed) = (flow.doubled.to_f64(), flow.speed.to_f64());
        let normal = flow.normal.to_f64() * (1.0 / doubled);
        let way = flow.relative.to_f64() * (1.0 / speed);
        let slope = way.dot(normal);
        let factor = self.air.density / 36.0 * doubled * speed * flow.share.to_f64();
        let along = (direction + way * way.dot(direction)) * (self.air.drag - self.air.lift);
        let across = normal * (self.air.lift * (1.0 + slope * slope) * normal.dot(direction));
        (along + across) * factor
    }
}

/// The number of waves that gusts are made of.
const WAVES: usize = 8;

/// A number for each wave.
type Each = [f64; WAVES];

/// The phases of the waves at a time, turns.
type Phases = Each;

/// The waves of gusts: a velocity a sin(2π (k·x − f t + φ)) each.
#[derive(Clone, Copy, Debug)]
struct Waves {
    origin: DVec3,
    /// Components of the amplitudes a, m/s.
    amplitudes: [Each; 3],
    /// Components of the wave vectors k, turns per metre.
    vectors: [Each; 3],
    /// Frequencies f at a fixed point, turns per second.
    frequencies: Each,
    /// Phases φ at the origin at the start, turns.
    starts: Each,
}

impl Waves {
    fn new(gust: &Gust, drift: DVec3) -> Self {
        let mut rough = Noise(gust.seed.into());
        let mut waves = Waves {
            origin: gust.origin,
            amplitudes: [[0.0; WAVES]; 3],
            vectors: [[0.0; WAVES]; 3],
            frequencies: [0.0; WAVES],
            starts: [0.0; WAVES],
        };
        // The mean square of a sine is a half.
        let amplitude = gust.strength * Real::sqrt(2.0 / WAVES as f64);
        for wave in 0..WAVES {
            // From 0.5 to 2 turns, evenly.
            let turns = 0.5 + 1.5 * (wave as f64 + 0.5) / WAVES as f64;
            let way = rough.direction();
            let vector = way * (turns / gust.length);
            let across = loop {
                let other = rough.direction();
                let across = other - way * way.dot(other);
                let square = across.dot(across);
                if 0.01 < square {
                    break across * (1.0 / Real::sqrt(square));
                }
            };
            for axis in 0..3 {
                waves.vectors[axis][wave] = vector[axis];
                waves.amplitudes[axis][wave] = across[axis] * amplitude;
            }
            // The longer a wave, the slower.
            waves.frequencies[wave] = vector.dot(drift) + turns / gust.time;
            waves.starts[wave] = rough.number();
        }
        waves
    }

    fn phases(&self, time: f64) -> Phases {
        let mut phases = self.starts;
        for (phase, frequency) in phases.iter_mut().zip(self.frequencies) {
            *phase -= turned(frequency * time);
        }
        phases
    }

    fn velocity(&self, phases: &Phases, point: DVec3) -> DVec3 {
        let [x, y, z] = (point - self.origin).to_array();
        let [kx, ky, kz] = &self.vectors;
        let mut sines = [0.0; WAVES];
        for wave in 0..WAVES {
            let phase = kx[wave] * x + ky[wave] * y + kz[wave] * z + phases[wave];
            sines[wave] = sine(turned(phase));
        }
        let sum = |amplitudes: &Each| amplitudes.iter().zip(&sines).map(|(a, s)| a * s).sum();
        let [x, y, z] = &self.amplitudes;
        DVec3::new(sum(x), sum(y), sum(z))
    }
}

/// The part of a number of turns that is left of whole ones, from −1/2 to 1/2; 0 where no digits
/// are left of it.
#[inline(always)]
fn turned(turns: f64) -> f64 {
    // Adding and subtracting this rounds to a whole number.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let left = turns - ((turns + WHOLE) - WHOLE);
    if Real::abs(turns) < 1e12 { left } else { 0.0 }
}

/// sin(2π t) for t from −1/2 to 1/2, to 1e-9: its series up to the 13th power, from a quarter of a
/// turn folded back.
#[inline(always)]
fn sine(t: f64) -> f64 {
    let size = Real::abs(t);
    let folded = if size < 0.25 { size } else { 0.5 - size };
    let x = if t < 0.0 { -TAU * folded } else { TAU * folded };
    let y = x * x;
    let tail = y * (1.0 / 362_880.0 + y * (-1.0 / 39_916_800.0 + y * (1.0 / 6_227_020_800.0)));
    x + x * y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * (-1.0 / 5040.0 + tail)))
}

/// Random numbers, the same everywhere (SplitMix64: Steele, Lea and Flood, 2014).
struct Noise(u64);

impl Noise {
    /// A number from −1/2 to 1/2.
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// A direction of length 1: a point of a cube that lies in the ball in it.
    fn direction(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.number(), self.number(), self.number());
            let square = point.dot(point);
            if (0.01..=0.25).contains(&square) {
                return point * (1.0 / Real::sqrt(square));
            }
        }
    }
}
