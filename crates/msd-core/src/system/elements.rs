//! The elements of a model beside springs and touches, and those of them that may drive it.

use super::Model;
use crate::elements::air::AirLoads;
use crate::elements::{Element, Torn};
use crate::number::Real;
use crate::scene::Air;

impl<R: Real> Model<R> {
    /// All elements but springs and touches: fields, bends, volumes, grabs, pushes, the air and
    /// user-defined ones.
    pub fn elements_beside_springs(&self) -> impl Iterator<Item = &dyn Element<R>> + '_ {
        let Model { fields, bends, volumes, grabs, pushes, .. } = self;
        let built_in: [&dyn Element<R>; 5] = [fields, bends, volumes, grabs, pushes];
        built_in.into_iter().chain(self.drivers())
    }

    /// The elements that may drive the motion: the air and user-defined ones.
    pub(crate) fn drivers(&self) -> impl Iterator<Item = &dyn Element<R>> + '_ {
        let air = self.air.iter().filter(|air| air.acts()).map(|air| air as &dyn Element<R>);
        air.chain(self.own.iter().map(|(_, own)| own.of::<R>()))
    }

    /// Whether there are elements that may drive the motion.
    pub(crate) fn is_driven(&self) -> bool {
        self.drivers().next().is_some()
    }

    /// Removes the bends, the volumes and the triangles in the air across springs that were cut.
    pub(crate) fn tear(&mut self, springs: impl Iterator<Item = usize>) {
        let torn = Torn::new(springs.map(|spring| self.springs.ends()[spring]));
        self.bends.tear(&torn);
        self.volumes.tear(&torn);
        self.air.iter_mut().for_each(|air| air.tear(&torn));
    }

    /// Removes the triangles in the air across springs that were cut, as [`Model::tear`] does.
    pub(crate) fn tear_air(&mut self, springs: impl Iterator<Item = usize>) {
        let torn = Torn::new(springs.map(|spring| self.springs.ends()[spring]));
        self.air.iter_mut().for_each(|air| air.tear(&torn));
    }

    /// The air that acts on surfaces, if there is any.
    pub fn air(&self) -> Option<&Air> {
        self.air.as_ref().map(AirLoads::air)
    }
}
