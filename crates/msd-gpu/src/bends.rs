//! Bends as a device reads them: of each particle a list of its parts in bends.

use crate::shader::THREADS;
use msd_core::Model;

/// The bends of a model; see `bends.wgsl`. All is empty where there are none.
#[derive(Default, PartialEq)]
pub struct BendLists {
    /// For each slice where the list of each of its particles starts, and where the last ends,
    /// counted in parts.
    pub starts: Vec<u32>,
    /// Parts of particles: four times the number of a bend, and which of its particles it is. A
    /// particle adds its parts in this order.
    pub parts: Vec<u32>,
}

/// The starts of a slice.
pub const STARTS: usize = THREADS + 1;

impl BendLists {
    /// The lists of the bends of a model, and for each bend its particles, their weights, and its
    /// stiffness and damping, in bits.
    pub fn new(model: &Model<f32>) -> (Self, Vec<[u32; 4]>) {
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); model.particle_count()];
        let mut rows = Vec::new();
        for (number, bend) in model.bends().rows().enumerate() {
            let bits = |number: f64| (number as f32).to_bits();
            for (end, (&particle, &weight)) in bend.particles.iter().zip(&bend.weights).enumerate()
            {
                if weight != 0.0 {
                    lists[particle].push((4 * number + end) as u32);
                }
            }
            let law = [bend.stiffness, bend.damping, 0.0, 0.0];
            rows.extend([
                bend.particles.map(|particle| particle as u32),
                bend.weights.map(bits),
                law.map(bits),
            ]);
        }
        if rows.is_empty() {
            return Default::default();
        }
        let mut all = BendLists::default();
        for slice in lists.chunks(THREADS) {
            let empty = std::iter::repeat_n(&[][..], THREADS - slice.len());
            all.starts.push(all.parts.len() as u32);
            for list in slice.iter().map(Vec::as_slice).chain(empty) {
                all.parts.extend(list);
                all.starts.push(all.parts.len() as u32);
            }
        }
        (all, rows)
    }
}
