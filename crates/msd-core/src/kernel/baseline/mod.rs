//! Which packs does every processor have that the build is for? Registers of 128 bits, mostly.

/// A pack of 128 bits, from functions that each target names in its own way.
///
/// They are those of a module `$of`: `splat`, `load`, `store`, `add`, `sub`, `mul`, `div` and
/// `sqrt`; `less(a, b)` and `not_less(a, b)`, which set all bits of a lane or none; `both` of two
/// masks; `choose(mask, a, b)`, `a` where the mask is set; `mask` from bits, and its `bits`;
/// `low(a, b)` and `high(a, b)`, which take the lanes of the lower and of the upper halves in turn.
#[allow(unused_macros, reason = "for targets that have such registers")]
macro_rules! pack {
    ($pack:ident, $scalar:ident, $count:tt, $of:ident, $register:ty, $mask:ty) => {
        #[derive(Clone, Copy)]
        pub(in crate::kernel) struct $pack($register);

        pack!(@operator $pack $of Add add);
        pack!(@operator $pack $of Sub sub);
        pack!(@operator $pack $of Mul mul);
        pack!(@operator $pack $of Div div);

        #[allow(unused_unsafe, reason = "some targets say that their functions are safe")]
        impl Pack<$scalar> for $pack {
            const COUNT: usize = $count;
            type Mask = $mask;

            #[inline(always)]
            unsafe fn splat(value: $scalar) -> Self {
                // SAFETY: the target of the build has the instructions; so everywhere below.
                Self(unsafe { $of::splat(value) })
            }
            #[inline(always)]
            unsafe fn load(from: *const $scalar) -> Self {
                // SAFETY: the caller's promise.
                Self(unsafe { $of::load(from.cast()) })
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $scalar) {
                // SAFETY: the caller's promise.
                unsafe { $of::store(to.cast(), self.0) };
            }
            #[inline(always)]
            unsafe fn mask(bits: u16) -> $mask {
                // SAFETY: see above.
                unsafe { $of::mask(bits) }
            }
            #[inline(always)]
            fn select(self, mask: $mask, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $of::choose(mask, self.0, other.0) })
            }
            #[inline(always)]
            fn add_where(self, mask: $mask, other: Self) -> Self {
                // To add minus zero changes nothing, not even the sign of a zero.
                // SAFETY: see above.
                Self(unsafe { $of::add(self.0, $of::choose(mask, other.0, $of::splat(-0.0))) })
            }
            #[inline(always)]
            fn less(self, other: Self, within: $mask) -> $mask {
                // SAFETY: see above.
                unsafe { $of::both(within, $of::less(self.0, other.0)) }
            }
            #[inline(always)]
            fn not_less(self, other: Self, within: $mask) -> $mask {
                // SAFETY: see above.
                unsafe { $of::both(within, $of::not_less(self.0, other.0)) }
            }
            #[inline(always)]
            fn bits(mask: $mask) -> u16 {
                // SAFETY: see above.
                unsafe { $of::bits(mask) }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $of::sqrt(self.0) })
            }
            #[inline(always)]
            unsafe fn gather(
                records: *const $scalar,
                at: *const u32,
                both: bool,
            ) -> [[Self; 3]; 2] {
                // SAFETY: the caller's promise.
                unsafe {
                    let first = Self::gather_halves(records, at);
                    let velocities = records.add(RECORD / 2);
                    [first, if both { Self::gather_halves(velocities, at) } else { first }]
                }
            }
        }

        impl $pack {
            /// Halves of records, by component.
            ///
            /// # Safety
            /// See [`Pack::gather`].
            #[inline(always)]
            unsafe fn gather_halves(records: *const $scalar, at: *const u32) -> [Self; 3] {
                // SAFETY: the caller's promise.
                unsafe { pack!(@gather $count $of records at) }
            }
        }
    };
    (@operator $pack:ident $of:ident $trait:ident $name:ident) => {
        #[allow(unused_unsafe, reason = "some targets say that their functions are safe")]
        impl core::ops::$trait for $pack {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: the target of the build has the instructions.
                Self(unsafe { $of::$name(self.0, other.0) })
            }
        }
    };
    (@gather 4 $of:ident $records:ident $at:ident) => {{
        let first = $of::load($records.add(*$at as usize).cast());
        let second = $of::load($records.add(*$at.add(1) as usize).cast());
        let third = $of::load($records.add(*$at.add(2) as usize).cast());
        let fourth = $of::load($records.add(*$at.add(3) as usize).cast());
        let (odd, even) = ($of::low(first, third), $of::low(second, fourth));
        let z = $of::low($of::high(first, third), $of::high(second, fourth));
        [Self($of::low(odd, even)), Self($of::high(odd, even)), Self(z)]
    }};
    (@gather 2 $of:ident $records:ident $at:ident) => {{
        let (first, second) = ($records.add(*$at as usize), $records.add(*$at.add(1) as usize));
        let (xy, other_xy) = ($of::load(first.cast()), $of::load(second.cast()));
        let z = $of::low($of::load(first.add(2).cast()), $of::load(second.add(2).cast()));
        [Self($of::low(xy, other_xy)), Self($of::high(xy, other_xy)), Self(z)]
    }};
}

#[cfg_attr(all(target_arch = "x86_64", target_feature = "sse2"), path = "sse2.rs")]
#[cfg_attr(all(target_arch = "aarch64", target_feature = "neon"), path = "neon.rs")]
#[cfg_attr(all(target_arch = "wasm32", target_feature = "simd128"), path = "simd128.rs")]
mod plain;

pub(super) use plain::{Double, Single};
