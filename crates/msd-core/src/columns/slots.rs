//! The slot of each particle: where its numbers are in the columns.
//!
//! Particles are kept in blocks, one after the other, as springs are evaluated block by block. The
//! particles of a block whose numbering has an order, as in a lattice, are cut into sixteen
//! segments of equal length, one for each lane. A spring to the particle d further on then goes
//! from a record to the record d further on, in the same lane. Those of another block follow each
//! other in an order of its own, sixteen to a record.

use super::{LANES, RECORD};
use alloc::vec::Vec;
use core::ops::Range;

/// Particles that are kept together.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// The particles, in the order of the scene.
    pub(crate) particles: Range<usize>,
    /// The record in front of the first; it belongs to no particle.
    pub(crate) blank: usize,
    /// Records of particles.
    pub(crate) len: usize,
    /// The slot of each particle, counted from the first record; `None` for segments.
    pub(crate) order: Option<Vec<u32>>,
}

impl Block {
    /// The place of a particle, counted from the start of its block, in the columns of vectors.
    #[inline]
    fn at(&self, particle: usize) -> usize {
        let (record, lane) = match &self.order {
            None => (particle % self.len, particle / self.len),
            Some(order) => {
                let slot = order[particle] as usize;
                (slot / LANES, slot % LANES)
            }
        };
        (self.blank + 1 + record) * RECORD + lane
    }

    /// Visits its particles with their places, record by record: in the order of memory.
    #[inline]
    fn visit(&self, mut visit: impl FnMut(usize, usize)) {
        let Range { start, end } = self.particles;
        let first = (self.blank + 1) * RECORD;
        let Some(order) = &self.order else {
            for record in 0..self.len {
                let lanes = (start + record..end).step_by(self.len).enumerate();
                lanes.for_each(|(lane, particle)| visit(particle, first + record * RECORD + lane));
            }
            return;
        };
        for (particle, &slot) in (start..end).zip(order) {
            let slot = slot as usize;
            visit(particle, first + slot / LANES * RECORD + slot % LANES);
        }
    }

    /// The places of its particles, in the order of the scene.
    fn places(&self) -> impl Iterator<Item = usize> + '_ {
        let (count, len, first) = (self.particles.len(), self.len, (self.blank + 1) * RECORD);
        let segments = if self.order.is_some() { 0 } else { count.div_ceil(len.max(1)) };
        let in_segments = (0..segments).flat_map(move |lane| {
            let last = len.min(count - lane * len);
            (0..last).map(move |record| first + record * RECORD + lane)
        });
        let in_order = self.order.iter().flatten().map(move |&slot| {
            let slot = slot as usize;
            first + slot / LANES * RECORD + slot % LANES
        });
        in_segments.chain(in_order)
    }
}

/// The slots of all particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slots {
    blocks: Vec<Block>,
}

impl Slots {
    /// Takes blocks that follow each other without a gap, in particles and in records.
    pub(crate) fn new(blocks: Vec<Block>) -> Self {
        Slots { blocks }
    }

    /// The number of particles.
    pub fn particle_count(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.particles.end)
    }

    /// The number of records of a column.
    pub fn record_count(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.blank + 1 + block.len)
    }

    /// Where the x of a particle is in a column of vectors; y is [`LANES`] further on, z twice
    /// that.
    ///
    /// # Panics
    /// If there is no such particle.
    #[inline]
    pub fn at(&self, particle: usize) -> usize {
        let block = match &self.blocks[..] {
            [block] => block,
            blocks => &blocks[blocks.partition_point(|block| block.particles.end <= particle)],
        };
        block.at(particle - block.particles.start)
    }

    /// Overwrites `to` with a value of each particle, by its place.
    #[inline]
    pub(crate) fn collect<T: Clone + Default>(&self, to: &mut Vec<T>, at: impl Fn(usize) -> T) {
        to.resize(self.particle_count(), T::default());
        self.blocks
            .iter()
            .for_each(|block| block.visit(|particle, place| to[particle] = at(place)));
    }

    /// The places of all particles, in the order of the scene.
    pub fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.blocks.iter().flat_map(Block::places)
    }
}
