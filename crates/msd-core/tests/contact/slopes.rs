//! Particles on one plane, sliding and held, and on ramps that meet a floor.

use crate::common::Random;
use crate::table::{G, H, Measures, is_double, run, start};
use crate::walls::{Kind, add_walls, particle, still, unmoved};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Real, Scene, Vector};
use std::f64::consts::TAU;

/// A slope: its normal, of any length as a user may write it, the angle of its tilt and down it.
struct Slope {
    kind: Kind,
    normal: DVec3,
    angle: f64,
    down: DVec3,
    foot: DVec3,
}

impl Slope {
    fn of(kind: Kind, normal: DVec3, foot: DVec3) -> Slope {
        let unit = normal.normalize();
        let down = (unit * unit.y - DVec3::Y).normalize();
        Slope { kind, normal, angle: unit.y.acos(), down, foot }
    }

    /// A particle at rest on it, under so much of the critical friction.
    fn scene(&self, part: f64) -> Scene {
        let mut scene = particle(self.foot, DVec3::ZERO);
        let friction = part * self.angle.tan();
        add_walls(&mut scene, self.kind, (self.foot, &[self.normal]), friction);
        scene
    }

    /// Size that is rounded, metres: the place, and the margin within which implicit methods put a
    /// particle on a solid, 64 roundings of its size, where a plane has 16.
    fn reach(&self) -> f64 {
        self.foot.length() + 4.0 * self.kind.reach()
    }

    fn name(&self, part: f64) -> String {
        let Slope { kind, normal, foot, .. } = self;
        format!("{kind:?}, normal {normal:.3}, {part:.3} of the critical friction, at {foot:.3}")
    }
}

/// Sixty slopes of 5 to 75 degrees, planes, half spaces and slabs; users wrote the first two.
fn slopes() -> Vec<Slope> {
    let mut random = Random(41);
    let written = [DVec3::new(3.0, 7.0, -2.0), DVec3::new(-1.0, 2.0, 0.0)];
    let mut slopes = Vec::from(written.map(|normal| Slope::of(Kind::Planes, normal, DVec3::ZERO)));
    for number in 2..60 {
        let (sine, cosine) = (5.0 + 70.0 * random.unit()).to_radians().sin_cos();
        let around = random.unit() * TAU;
        let unit = DVec3::new(sine * around.cos(), cosine, sine * around.sin());
        let away = [0.0, 1.0, 20.0][number % 3];
        let foot = (random.vector() - 0.5) * away;
        let kind = [Kind::Planes, Kind::HalfSpaces, Kind::Slabs][number / 3 % 3];
        slopes.push(Slope::of(kind, unit * (0.1 + 10.0 * random.unit()), foot));
    }
    slopes
}

/// Length that rounding adds to a way of a second, metres: a rounding of place and speed in each
/// substep. The speed and its rounding are at most those of a slide without friction.
fn rounded<R: Real>(seconds: f64, reach: f64) -> f64 {
    seconds / H * R::EPSILON.to_f64() * (G * seconds * seconds + reach)
}

/// From rest the way is g (sin α − μ cos α) t² / 2 down the slope.
pub fn slopes_slide<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, seconds) = (Measures::default(), 1.0);
    for slope in slopes() {
        // At 0.8 and 0.96 of the critical friction Dormand-Prince once stalled: the longest substep
        // that follows the slide left but rounding of the step.
        for part in [0.3, 0.6, 0.8, 0.9, 0.96] {
            let name = slope.name(part);
            let mut simulation = start::<R>(&slope.scene(part), integrator);
            let before = simulation.position(0).to_f64();
            let ended = run(&mut simulation, seconds, |_| {});
            ended.unwrap_or_else(|error| measures.fail(&error, &name));
            let (sine, cosine) = slope.angle.sin_cos();
            let rate = G * (sine - part * slope.angle.tan() * cosine);
            let way = slope.down * (0.5 * rate * seconds * seconds);
            let off = (simulation.position(0).to_f64() - before - way).length();
            // Methods of order one are half a substep early or late. Those of a higher order are
            // right under a constant force: 1e-6 is the tolerance of a solver.
            let late = if integrator.order() == 1 { 0.51 * rate * H * seconds } else { 0.0 };
            let solved = if is_double::<R>() { 1e-6 * way.length() } else { 0.0 };
            let bound = late + solved + rounded::<R>(seconds, slope.reach());
            measures.see("off its place, m", (off, bound), &name);
        }
    }
    measures
}

/// Above the critical friction nothing moves.
pub fn slopes_hold<R: Real>(integrator: Integrator) -> Measures {
    let mut measures = Measures::default();
    for slope in slopes() {
        for part in [1.05, 1.2] {
            let name = slope.name(part);
            let mut simulation = start::<R>(&slope.scene(part), integrator);
            let before = simulation.position(0).to_f64();
            let (mut fastest, reach) = (0f64, slope.reach());
            let ended = run(&mut simulation, 1.0, |now| {
                fastest = fastest.max(now.velocity(0).to_f64().length());
            });
            ended.unwrap_or_else(|error| measures.fail(&error, &name));
            let moved = simulation.position(0).to_f64().distance(before);
            measures.see("speed, m/s", (fastest, still::<R>(reach)), &name);
            measures.see("moved, m", (moved, unmoved::<R>(reach)), &name);
        }
    }
    measures
}

/// A ramp of α down to the origin, with L of it above. At its foot the speed is v = √(2 g (sin α −
/// μ cos α) L); the floor takes v sin α with an impulse, whose friction takes μ v sin α more. On
/// the floor it goes on for ever, or stops after v'² / (2 μ g).
pub fn ramps_end<R: Real>(integrator: Integrator) -> Measures {
    let (mut measures, length, seconds) = (Measures::default(), 0.4, 2.0);
    for degrees in [20, 30, 40, 50, 60, 70] {
        for friction in [0.0, 0.2] {
            let name = format!("ramp of {degrees}°, friction {friction}");
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let mut scene = particle(DVec3::new(-cosine, sine, 0.0) * length, DVec3::ZERO);
            let normals = [DVec3::new(sine, cosine, 0.0), DVec3::Y];
            add_walls(&mut scene, Kind::Planes, (DVec3::ZERO, &normals), friction);
            let rate = G * (sine - friction * cosine);
            let arrives = (2.0 * rate * length).sqrt();
            let left = arrives * (cosine - friction * sine);
            let since = seconds - arrives / rate;
            let way = if friction == 0.0 {
                left * since
            } else {
                assert!(left / (friction * G) < since, "it has stopped");
                left * left / (2.0 * friction * G)
            };
            let mut simulation = start::<R>(&scene, integrator);
            let ended = run(&mut simulation, seconds, |_| {});
            ended.unwrap_or_else(|error| measures.fail(&error, &name));
            let (x, v) = (simulation.position(0).to_f64(), simulation.velocity(0).to_f64());
            // Methods with fixed substeps meet the floor up to a substep early or late. That is up
            // to g h in speed, as much again where the speed is half a substep off its place, and
            // two substeps of way. Dormand-Prince locates the time.
            let [late, slower] = match integrator {
                Integrator::DormandPrince => [0.0; 2],
                _ if integrator.order() == 1 => [2.0 * arrives * H, 2.0 * G * H],
                _ => [2.0 * arrives * H, G * H],
            };
            let grows = if friction == 0.0 { since } else { left / (friction * G) };
            let bound = 1e-6 * way + late + slower * grows + rounded::<R>(seconds, length);
            let off = x.distance(DVec3::X * way);
            measures.see("off its place, m", (off, bound), &name);
            let rounding = seconds / H * R::EPSILON.to_f64() * arrives;
            if friction == 0.0 {
                let off = v.distance(DVec3::X * left);
                measures.see("off its speed, m/s", (off, 1e-6 * left + slower + rounding), &name);
            } else {
                measures.see("speed, m/s", (v.length(), still::<R>(way)), &name);
            }
        }
    }
    measures
}
