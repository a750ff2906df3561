//! Contact at rest on obstacles that are no planes.
//!
//! What slides on a bent surface leaves it in a drift along a straight line: by v² h²/(2 R) outside
//! of a ball of radius R. There no kick is followed by the law, and the half of one that comes next
//! would add m a² h²/8 to the energy of every such hop. So a particle that lies drifts along the
//! chord that ends on the surface, as long as the kick presses it down by more than that takes: it
//! leaves where the pull no longer makes up v²/R. (RATTLE ends its drifts on the constraint:
//! Andersen, 1983.)

use super::super::law::{Contacts, rounding};
use super::corner::{BENDS, Holder, holder, settle_in_corner};
use super::{Drift, Kick, Kicked};
use crate::columns::{LANES, RECORD, set_vector};
use crate::number::{Real, Vector};
use crate::obstacles::solid::{Sampled, lane_of, lanes};
use crate::obstacles::{ContactLaw, Obstacles};
use crate::pack::dot;

/// The particles of a record, of these radii, on an obstacle, a bit for each, and the normals
/// there; the bits say which may be.
#[inline(always)]
pub(crate) fn on_curved<R: Real>(
    obstacle: &impl Sampled<R>,
    (x, radii, which): (&[R; RECORD], &[R; LANES], u32),
    time: f64,
) -> (u32, [R; RECORD]) {
    let gaps = obstacle.gaps((x, which), time);
    let mut bits = [0; LANES];
    for lane in 0..LANES {
        let gap = (gaps[lane] - radii[lane]).abs();
        let terms = obstacle.terms_at(lane_of(x, lane), time);
        bits[lane] = u32::from(gap <= rounding(terms, radii[lane])) << lane;
    }
    let on = which & bits.iter().fold(0, |all, bit| all | bit);
    let normals = if on == 0 { [R::ZERO; RECORD] } else { obstacle.normals((x, on), time) };
    (on, normals)
}

/// Holds the particles of a record that lie on an obstacle which is no plane; the bits say which
/// may. The obstacle is given where it is and where it will be after a drift.
#[inline(always)]
pub(crate) fn settle_on_curved<R: Real>(
    (obstacles, index, obstacle, moved): (&Obstacles<R>, usize, &impl Sampled<R>, &impl Sampled<R>),
    kicked: &mut Kicked<'_, R>,
    (record, x, which): (usize, &[R; RECORD], u32),
    contacts: &mut Contacts,
) {
    let (at, kick) = (record * RECORD, kicked.kick);
    let radii = kicked.places.radii.of_record(record);
    let which = which & kicked.places.moving_of(record);
    let (on, normals) = on_curved(obstacle, (x, &radii, which), kick.time);
    let on = alone_on(obstacles, index, (on, x, &radii), (kicked, record), contacts);
    if on == 0 {
        return;
    }
    let law = kick.law(obstacle.single().law());
    let of = |column: &[R]| -> [R; RECORD] { *column[at..].first_chunk().expect("a record") };
    let (v, a) = (of(kicked.velocities), of(kicked.accelerations));
    let surface = obstacle.velocities((x, on), kick.time);
    let mut bends = [R::ZERO; LANES];
    let mut rest = Rest::new(&kick, &law, (&normals, &v, &a, &surface), &bends);
    if kick.drift == Drift::Ahead {
        for _ in 0..BENDS {
            let drifting = (x, &rest.velocities, on & rest.lie);
            if !bend(moved, drifting, (&kick, &radii), &mut bends) {
                break;
            }
            rest = Rest::new(&kick, &law, (&normals, &v, &a, &surface), &bends);
        }
    }
    for lane in lanes(on & rest.lie) {
        let [v, after, surface] =
            [&v, &rest.velocities, &surface].map(|column| lane_of(column, lane));
        set_vector(kicked.velocities, at + lane, R::Vec3::from_components(after));
        let mass = kicked.masses[record * LANES + lane];
        let impulse = core::array::from_fn(|axis| after[axis] - v[axis]);
        *contacts += Contacts {
            driven: (dot(impulse, surface) * mass).to_f64(),
            ..Contacts::one((rest.taken[lane] * mass).to_f64())
        };
    }
}

/// Which of the particles of a record that lie on an obstacle lie on no other; those of which it is
/// the first of several are held by all.
#[inline(always)]
fn alone_on<R: Real>(
    obstacles: &Obstacles<R>,
    index: usize,
    (on, x, radii): (u32, &[R; RECORD], &[R; LANES]),
    (kicked, record): (&mut Kicked<'_, R>, usize),
    contacts: &mut Contacts,
) -> u32 {
    if obstacles.count() == 1 {
        return on;
    }
    let time = kicked.kick.time;
    lanes(on).fold(on, |alone, lane| {
        let place = (R::Vec3::from_components(lane_of(x, lane)), radii[lane]);
        let holder = holder(obstacles, index, place, time);
        if holder == Holder::First {
            settle_in_corner(obstacles, kicked, (record, lane), contacts);
        }
        if holder == Holder::Alone { alone } else { alone & !(1 << lane) }
    })
}

/// Turns the velocities of particles that lie, so that they do so after a drift: lowers their
/// speeds along the normals by the gaps that the drift would leave. Whether there were any.
#[inline(always)]
fn bend<R: Real>(
    moved: &impl Sampled<R>,
    (x, velocities, lie): (&[R; RECORD], &[R; RECORD], u32),
    (kick, radii): (&Kick<R>, &[R; LANES]),
    bends: &mut [R; LANES],
) -> bool {
    let moving = (0..LANES)
        .filter(|&lane| lane_of(velocities, lane) != [R::ZERO; 3])
        .fold(0, |bits, lane| bits | 1 << lane);
    let which = lie & moving;
    if which == 0 {
        return false;
    }
    let mut ends = *x;
    for (end, &v) in ends.iter_mut().zip(velocities) {
        *end += v * kick.substep;
    }
    let gaps = moved.gaps((&ends, which), kick.time + kick.substep.to_f64());
    let mut is_any = false;
    for lane in lanes(which) {
        let gap = gaps[lane] - radii[lane];
        let noise = rounding(moved.terms_at(lane_of(&ends, lane), kick.time), radii[lane]);
        if noise * R::HALF < gap.abs() {
            bends[lane] -= gap / kick.substep;
            is_any = true;
        }
    }
    is_any
}

/// The particles of a record after the law, if they are on the surface.
struct Rest<R> {
    /// Whether they lie, a bit for each.
    lie: u32,
    velocities: [R; RECORD],
    /// Energy dissipated per mass, joules per kilogram.
    taken: [R; LANES],
}

impl<R: Real> Rest<R> {
    /// Holds particles on a surface, each with the speed along its normal that keeps it there.
    #[inline(always)]
    fn new(
        kick: &Kick<R>,
        law: &ContactLaw<R>,
        (normals, v, a, surface): (&[R; RECORD], &[R; RECORD], &[R; RECORD], &[R; RECORD]),
        bends: &[R; LANES],
    ) -> Self {
        let (mut lie, mut taken) = ([0; LANES], [R::ZERO; LANES]);
        let mut velocities = [R::ZERO; RECORD];
        for lane in 0..LANES {
            let [normal, v, surface] = [normals, v, surface].map(|column| lane_of(column, lane));
            let seen = core::array::from_fn(|axis| v[axis] - surface[axis]);
            let settled = kick.settle(law, normal, (seen, lane_of(a, lane)), bends[lane]);
            (lie[lane], taken[lane]) = (u32::from(settled.lies) << lane, settled.taken);
            for axis in 0..3 {
                velocities[axis * LANES + lane] =
                    settled.velocity[axis] + normal[axis] * bends[lane] + surface[axis];
            }
        }
        Rest { lie: lie.iter().fold(0, |bits, bit| bits | bit), velocities, taken }
    }
}
