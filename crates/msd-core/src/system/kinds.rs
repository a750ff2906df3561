//! The kinds of elements of a model, in lists.
//!
//! A list of `dyn Force` brings with it all that its kinds do in a run, for each set of
//! instructions. A generic function that makes one would compile all of that again in every crate
//! that calls it. The two tables below are not generic, so it is compiled here, once.

use super::Model;
use crate::columns::slots::Slots;
use crate::elements::Force;
use crate::number::{Real, of_type};

/// All kinds but springs, and the places of the particles.
type BesideSprings<'a, R> = ([&'a mut dyn Force<R>; 7], &'a Slots);

/// The functions that make the lists.
pub(super) struct Kinds<R: Real> {
    /// The kinds that only join particles to each other, in the order of their sums: none of them
    /// pushes a body as a whole.
    pub(super) inner: fn(&Model<R>) -> [&dyn Force<R>; 3],
    /// The kinds that act on each particle alone. Fields start all sums of forces.
    pub(super) single: fn(&Model<R>) -> [&dyn Force<R>; 3],
    /// The kinds that may do anything, known by their elements alone.
    pub(super) other: fn(&Model<R>) -> [&dyn Force<R>; 2],
    /// All kinds but springs, which put the particles in order.
    pub(super) beside_springs: fn(&mut Model<R>) -> BesideSprings<'_, R>,
}

// Functions, not statics: a program compiles each static of its own crate, used or not, so the unit
// tests would compile all of this again. Never inlined, or each caller would.
#[inline(never)]
fn single() -> &'static Kinds<f32> {
    const { &Kinds::new() }
}

#[inline(never)]
fn double() -> &'static Kinds<f64> {
    const { &Kinds::new() }
}

impl<R: Real> Kinds<R> {
    const fn new() -> Self {
        Kinds {
            inner: |model| [&model.springs, &model.bends, &model.volumes],
            single: |model| [&model.fields, &model.grabs, &model.pushes],
            other: |model| [&model.air, &model.own],
            beside_springs: |model| {
                let Model { slots, bends, volumes, fields, grabs, pushes, air, own, .. } = model;
                ([bends, volumes, fields, grabs, pushes, air, own], slots)
            },
        }
    }

    /// The functions for a precision.
    pub(super) fn of_precision() -> &'static Self {
        of_type(single(), double())
    }
}
