//! Resting contact on obstacles other than planes.
//!
//! A particle that slides on a bent surface leaves it in a drift along a straight line: by v²
//! h²/(2 R) outside of a ball of radius R. Off the surface no kick is followed by the law, and the
//! next half kick would add m a² h²/8 to the energy of every such hop. So a particle that lies
//! drifts along the chord that ends on the surface, as long as the kick presses it down by more
//! than that takes. It leaves where the pull no longer makes up v²/R. (RATTLE ends its drifts on
//! the constraint: Andersen, 1983.)

use super::super::law::{Contacts, rounding};
use super::corner::BENDS;
use super::{Drift, Kick, Kicked};
use crate::columns::{LANES, RECORD, set_vector};
use crate::number::{Real, Vector};
use crate::obstacles::ContactLaw;
use crate::obstacles::solid::{Sampled, lane_of, lanes};
use crate::pack::{dot, each};

/// Holds the particles of a record that lie on a single obstacle which is not a plane, a bit for
/// each. The obstacle is given where it is and where it will be after a drift.
#[inline(always)]
pub(crate) fn settle_on_curved<R: Real, O: Sampled<R> + ?Sized>(
    (obstacle, moved): (&O, &O),
    kicked: &mut Kicked<'_, R>,
    (record, on): (usize, u32),
    contacts: &mut Contacts,
) {
    let (at, kick) = (record * RECORD, kicked.kick);
    let (x, radii) = (&kicked.places.records()[record], kicked.places.radii.of_record(record));
    let normals = obstacle.normals((x, on), kick.time);
    let law = kick.law(obstacle.law());
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
        let impulse = each(|axis| after[axis] - v[axis]);
        *contacts += Contacts {
            driven: (dot(impulse, surface) * mass).to_f64(),
            ..Contacts::one((rest.taken[lane] * mass).to_f64())
        };
    }
}

/// Turns the velocities of particles that lie, so that they do so after a drift. It lowers their
/// speeds along the normals by the gaps that the drift would leave. Returns whether there were any.
#[inline(always)]
fn bend<R: Real>(
    moved: &(impl Sampled<R> + ?Sized),
    (x, velocities, lie): (&[R; RECORD], &[R; RECORD], u32),
    (kick, radii): (&Kick<R>, &[R; LANES]),
    bends: &mut [R; LANES],
) -> bool {
    let mut moving = [0; LANES];
    for (lane, moving) in moving.iter_mut().enumerate() {
        let [x, y, z] = lane_of(velocities, lane).map(|number| number != R::ZERO);
        *moving = u32::from(x | y | z) << lane;
    }
    let which = lie & moving.iter().fold(0, |all, bit| all | bit);
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
        let end = R::Vec3::from_components(lane_of(&ends, lane));
        let noise = rounding(moved.terms(end, kick.time), radii[lane]);
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
            let seen = each(|axis| v[axis] - surface[axis]);
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
