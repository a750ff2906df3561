//! One plain loop over springs: the oracle of the fast one.

use super::Springs;
use super::law::pull;
use crate::number::{Real, Vector};
use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

/// Adds the pull of every spring to `forces`, newtons, and returns the power that their dampers
/// take away, watts. All columns are in the order of the scene.
///
/// A particle sums the springs to lower numbers, the lowest first, on what is in `forces`; then, on
/// their own, those to higher numbers, the highest first; then the extras of the layout. In a large
/// block, whose parts threads may evaluate at once, the springs from an earlier part have sums of
/// their own, and so have those from the end of a segment: these are added when all parts are done.
pub fn add_forces<R: Real>(
    springs: &Springs<R>,
    [positions, velocities]: [&[R::Vec3]; 2],
    forces: &mut [R::Vec3],
) -> f64 {
    let motion = |end: u32| {
        let end = end as usize;
        [positions[end], velocities[end]]
    };
    let sorted = |spring: u32| {
        let [a, b] = springs.ends()[spring as usize];
        [a.min(b), a.max(b)]
    };
    let pull = |spring: u32, [i, j]: [u32; 2]| {
        let is_cut = springs.is_cut(spring as usize);
        let pull = pull(motion(i), motion(j), springs.law(spring as usize));
        pull.filter(|_| !is_cut)
    };
    let extras: Vec<u32> = springs.extras().collect();
    let mut higher: Vec<Vec<(u32, u32)>> = vec![Vec::new(); forces.len()];
    for spring in 0..springs.ends().len() as u32 {
        let [i, j] = sorted(spring);
        if !extras.contains(&spring) {
            higher[i as usize].push((j, spring));
        }
    }
    let late_sums = springs.late_sums();
    let mut later: BTreeMap<(usize, u32), R::Vec3> = BTreeMap::new();
    let mut carried = vec![R::Vec3::ZERO; forces.len()];
    let mut power = 0.0;
    for (i, mut higher) in higher.into_iter().enumerate() {
        higher.sort_by_key(|&(j, spring)| (u32::MAX - j, spring));
        let (mut ahead, mut burnt) = (R::Vec3::ZERO, R::ZERO);
        for (j, spring) in higher {
            let Some((there, burns)) = pull(spring, [i as u32, j]) else { continue };
            let (is_carried, keeper) = late_sums(spring);
            *(if is_carried { &mut carried[i] } else { &mut ahead }) -= there;
            match keeper {
                Some(piece) => *later.entry((piece, j)).or_default() += there,
                None => forces[j as usize] += there,
            }
            burnt += burns;
        }
        forces[i] += ahead;
        power += burnt.to_f64();
    }
    for ((_, j), sum) in later {
        forces[j as usize] += sum;
    }
    for (force, carried) in forces.iter_mut().zip(carried) {
        *force += carried;
    }
    for spring in extras {
        let [i, j] = sorted(spring);
        let Some((there, burns)) = pull(spring, [i, j]) else { continue };
        forces[i as usize] -= there;
        forces[j as usize] += there;
        power += burns.to_f64();
    }
    power
}
