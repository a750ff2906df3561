//! The plain loop over springs: the reference that the fast one equals to the bit.

use super::law::pull;
use super::{Springs, Sum};
use crate::columns::slots::Slots;
use crate::number::{Real, Vector};
use alloc::collections::BTreeMap;

/// Adds the pull of every spring to `forces`, newtons, and returns the power that their dampers
/// dissipate, watts. All columns are in the order of the scene.
///
/// Springs pull in the order of their rows, on sums that are added to the forces in the order of
/// [`Sum`]; then the extras of the layout.
pub fn add_forces<R: Real>(
    springs: &Springs<R>,
    slots: &Slots,
    [positions, velocities]: [&[R::Vec3]; 2],
    forces: &mut [R::Vec3],
) -> f64 {
    let motion = |end: u32| [positions, velocities].map(|column| column[end as usize].components());
    let extras = springs.extras().map(|spring| {
        let [a, b] = springs.ends()[spring as usize];
        (spring, [a.min(b), a.max(b)], [Sum::Forces; 2])
    });
    let mut power = 0.0;
    let mut add = |turns: &mut dyn Iterator<Item = (u32, [u32; 2], [Sum; 2])>| {
        let mut sums: BTreeMap<(Sum, u32), R::Vec3> = BTreeMap::new();
        for (spring, ends, [here, there]) in turns {
            let (law, is_there) = (springs.law(spring as usize), !springs.is_cut(spring as usize));
            let (pull, burns) = pull::<R, true>(motion(ends[0]), motion(ends[1]), law, is_there);
            let pull = R::Vec3::from_components(pull);
            for (sum, end, pull) in [(here, ends[0], -pull), (there, ends[1], pull)] {
                match sum {
                    Sum::Forces => forces[end as usize] += pull,
                    sum => *sums.entry((sum, end)).or_default() += pull,
                }
            }
            power += burns.to_f64();
        }
        sums.into_iter().for_each(|((_, end), sum)| forces[end as usize] += sum);
    };
    add(&mut springs.turns(slots));
    add(&mut { extras });
    power
}
