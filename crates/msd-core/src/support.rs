//! What do planes leave of the acceleration of a particle that they hold?

use crate::real::{Real, Vector};
use crate::scene::Friction;
use crate::system::Model;

/// Planes that hold one particle at a time; three independent ones leave it nowhere to go.
pub(crate) const MOST_PLANES: usize = 4;
/// Sweeps over the planes of a corner. At right angles two are exact.
const MOST_SWEEPS: usize = 100;

/// What planes leave of an acceleration.
pub(crate) struct Support<R: Real> {
    pub(crate) slope: R::Vec3,
    /// Normal force on each plane per mass, metres per second squared.
    pub(crate) pressures: [R; MOST_PLANES],
    /// The least of them.
    pub(crate) least: R,
    /// What friction may take along the planes, metres per second squared.
    pub(crate) grip: R,
    /// Whether nothing slides.
    pub(crate) glued: bool,
}

/// Whether a plane only pushes, or pulls as well.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Law {
    OneSided,
    TwoSided,
}

/// Projects an acceleration out of planes (Gauss's principle of least constraint), by the method
/// of Gauss and Seidel on the pressures.
pub(crate) fn support<R: Real>(
    model: &Model<R>,
    planes: &[u32],
    pull: R::Vec3,
    law: Law,
) -> Support<R> {
    let mut slope = pull;
    let mut pressures = [R::ZERO; MOST_PLANES];
    let close = pull.extent() * R::EPSILON;
    for _ in 0..MOST_SWEEPS {
        let mut largest = R::ZERO;
        for (pressure, &plane) in pressures.iter_mut().zip(planes) {
            let normal = model.planes[plane as usize].normal;
            let into = -slope.dot(normal);
            let change = if law == Law::OneSided { into.max(-*pressure) } else { into };
            *pressure += change;
            slope += normal * change;
            largest = largest.max(change.abs());
        }
        if planes.len() < 2 || largest <= close {
            break;
        }
    }
    let (mut grip, mut glued, mut least) = (R::ZERO, false, pressures[0]);
    for (&pressure, &plane) in pressures.iter().zip(planes) {
        least = least.min(pressure);
        match model.planes[plane as usize].friction {
            Friction::Coulomb(factor) => grip += R::of(factor) * pressure,
            Friction::TangentialLoss(loss) => glued |= 0.0 < loss && R::ZERO < pressure,
        }
    }
    Support { slope, pressures, least, grip, glued }
}
