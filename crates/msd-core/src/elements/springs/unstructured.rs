//! Unstructured blocks, those without segments: springs by particle, and the order of the
//! particles.

use alloc::vec;
use alloc::vec::Vec;
use core::cmp::Reverse;

/// Other end and number of each spring of a particle.
pub(super) struct Lists {
    starts: Vec<u32>,
    rows: Vec<[u32; 2]>,
}

impl Lists {
    /// Takes over rows, each with the number of its particle.
    pub(super) fn new(count: usize, rows: impl Iterator<Item = (usize, [u32; 2])> + Clone) -> Self {
        let mut starts = vec![0u32; count + 1];
        rows.clone().for_each(|(particle, _)| starts[particle + 1] += 1);
        (0..count).for_each(|particle| starts[particle + 1] += starts[particle]);
        let (mut next, mut lists) = (starts.clone(), vec![[0; 2]; starts[count] as usize]);
        for (particle, row) in rows {
            lists[next[particle] as usize] = row;
            next[particle] += 1;
        }
        Lists { starts, rows: lists }
    }

    pub(super) fn of(&self, particle: u32) -> &[[u32; 2]] {
        let particle = particle as usize;
        &self.rows[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }
}

/// The place of each particle in an order.
pub(super) fn slots_of(order: &[u32]) -> Vec<u32> {
    let mut slots = vec![0; order.len()];
    for (slot, &particle) in order.iter().enumerate() {
        slots[particle as usize] = slot as u32;
    }
    slots
}

/// Particles in the order in which a walk along springs finds them, nearest first, backwards
/// (Cuthill and McKee, 1969; George, 1971), so that joined particles are near each other. Within
/// windows of that order, particles that own the most springs come first, so that the rows of a
/// record are full.
pub(super) fn near_order(lists: &Lists, owned: &Lists) -> Vec<u32> {
    let count = lists.starts.len() - 1;
    let springs = |&particle: &u32| lists.of(particle).len();
    let mut starts: Vec<u32> = (0..count as u32).collect();
    starts.sort_by_key(springs);
    let mut order = Vec::with_capacity(count);
    let mut found = vec![false; count];
    for start in starts {
        let mut next = order.len();
        if !core::mem::replace(&mut found[start as usize], true) {
            order.push(start);
        }
        while let Some(&particle) = order.get(next) {
            next += 1;
            let first = order.len();
            for &[other, _] in lists.of(particle) {
                if !core::mem::replace(&mut found[other as usize], true) {
                    order.push(other);
                }
            }
            order[first..].sort_by_key(springs);
        }
    }
    order.reverse();
    for window in order.chunks_mut(WINDOW) {
        window.sort_by_key(|&particle| Reverse(owned.of(particle).len()));
    }
    order
}

/// Particles that are sorted by their number of springs: few enough to stay near each other.
const WINDOW: usize = 512;
