//! The numbers of a simulation: `f32` or `f64` behind one sealed trait, and the instructions that
//! compute with sixteen of them at a time.

use core::any::Any;
use core::fmt::{Debug, Display};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use fearless_simd::{Level, Simd, SimdFloatElement};
use glam::{DVec3, Vec3, Vec3A};

/// Particles in a record, whose numbers are computed with at a time.
pub const LANES: usize = 16;
/// Numbers in a record of vectors.
pub const RECORD: usize = 3 * LANES;
/// Numbers of a vector among points: x, y, z and nothing.
pub(crate) const QUAD: usize = 4;
/// Numbers of a particle among points: position, nothing, velocity, nothing.
pub(crate) const POINT: usize = 2 * QUAD;
/// A record of positions and one of velocities.
pub(crate) const GATHERED: usize = 2 * RECORD;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The scalar of a simulation: [`f32`] or [`f64`].
///
/// Every operation is a single IEEE 754 operation, correctly rounded, so that the same scene gives
/// the same bits on every machine. There is no fused multiply-add here on purpose.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + Display
    + Default
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Transpose
{
    /// The three-dimensional vector of this scalar.
    type Vec3: Vector<Scalar = Self>;
    /// The bytes of this scalar.
    type Bytes: IntoIterator<Item = u8>;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// One half.
    const HALF: Self;
    /// The name a user writes: `f32` or `f64`.
    const NAME: &'static str;
    /// The largest finite number.
    const LARGEST: Self;
    /// The distance from one to the next number above it.
    const EPSILON: Self;
    /// The square of the shortest length that still has a direction, m².
    ///
    /// Below it the reciprocal of the square overflows or the direction is rounding noise.
    const SHORTEST_SQUARED: Self;
    /// A motion d·v so slow that dampers take no notice of it, m²/s: its square, which their power
    /// is made of, would be subnormal.
    ///
    /// Many processors take a hundred cycles for a subnormal number, and where a motion spreads
    /// into a body at rest, damper by damper, whole shells of particles would have them.
    const FAINTEST: Self;

    /// Rounds a double to this scalar.
    fn of(value: f64) -> Self;
    /// Widens to a double, exactly.
    fn to_f64(self) -> f64;
    /// The square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The bits, lowest byte first on every machine.
    fn to_le_bytes(self) -> Self::Bytes;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self {
        if self < other { other } else { self }
    }
}

/// The vector of a [`Real`]: glam's `Vec3A` or `DVec3`.
///
/// `Vec3A` rather than `Vec3`: four aligned floats load, add and store at once, which is worth 1.3
/// times the speed of a step. Only sums, products and roots are used of it, all of them exact IEEE
/// operations per component; glam's own `cross` and `mul_add` may fuse.
pub trait Vector:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Self::Scalar, Output = Self>
    + AddAssign
    + SubAssign
{
    /// The scalar of the components.
    type Scalar;
    /// The zero vector.
    const ZERO: Self;
    /// The scalar product.
    fn dot(self, other: Self) -> Self::Scalar;
    /// The vector product.
    fn cross(self, other: Self) -> Self;
    /// The components.
    fn components(self) -> [Self::Scalar; 3];
    /// The vector of three components.
    fn from_components(components: [Self::Scalar; 3]) -> Self;
    /// Rounds each component of a double vector.
    fn of(value: DVec3) -> Self;
    /// Widens each component, exactly.
    fn to_f64(self) -> DVec3;
    /// Widens or rounds each component to single precision, for drawing.
    fn to_f32(self) -> Vec3;
    /// The largest absolute component, or NaN if a component is not finite.
    fn extent(self) -> Self::Scalar;
}

macro_rules! impl_real {
    (
        $scalar:ident, $vector:ident, $shortest:expr, $faintest:expr, $sqrt:ident, $as_f32:expr
    ) => {
        impl Real for $scalar {
            type Vec3 = $vector;
            type Bytes = [u8; size_of::<$scalar>()];
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const NAME: &'static str = stringify!($scalar);
            const LARGEST: Self = $scalar::MAX;
            const EPSILON: Self = $scalar::EPSILON;
            const SHORTEST_SQUARED: Self = $shortest;
            const FAINTEST: Self = $faintest;

            #[inline]
            fn of(value: f64) -> Self {
                value as $scalar
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                #[cfg(feature = "std")]
                return $scalar::sqrt(self);
                #[cfg(not(feature = "std"))]
                return libm::$sqrt(self);
            }
            #[inline]
            fn abs(self) -> Self {
                $scalar::abs(self)
            }
            #[inline]
            fn to_le_bytes(self) -> Self::Bytes {
                $scalar::to_le_bytes(self)
            }
        }

        impl Vector for $vector {
            type Scalar = $scalar;
            const ZERO: Self = $vector::ZERO;

            #[inline]
            fn dot(self, other: Self) -> $scalar {
                // Products first, all at once, then the sum in a fixed order.
                let product = self * other;
                product.x + product.y + product.z
            }
            #[inline]
            fn cross(self, other: Self) -> Self {
                $vector::new(
                    self.y * other.z - self.z * other.y,
                    self.z * other.x - self.x * other.z,
                    self.x * other.y - self.y * other.x,
                )
            }
            #[inline]
            fn components(self) -> [$scalar; 3] {
                self.to_array()
            }
            #[inline]
            fn from_components([x, y, z]: [$scalar; 3]) -> Self {
                $vector::new(x, y, z)
            }
            #[inline]
            fn of(value: DVec3) -> Self {
                $vector::new(value.x as $scalar, value.y as $scalar, value.z as $scalar)
            }
            #[inline]
            fn to_f64(self) -> DVec3 {
                DVec3::new(f64::from(self.x), f64::from(self.y), f64::from(self.z))
            }
            #[inline]
            fn to_f32(self) -> Vec3 {
                $as_f32(self)
            }
            #[inline]
            fn extent(self) -> $scalar {
                // `max` of the standard library drops a NaN; a sum keeps it. Multiplied before they
                // are added: a sum of large components would overflow and pass for a NaN.
                let largest = self.x.abs().max(self.y.abs()).max(self.z.abs());
                let nothing = self * 0.0;
                largest + (nothing.x + nothing.y + nothing.z)
            }
        }
    };
}

impl_real!(f32, Vec3A, 1e-24, 1e-18, sqrtf, |v: Vec3A| Vec3::from(v));
impl_real!(f64, DVec3, 1e-200, 1e-153, sqrt, |v: DVec3| v.as_vec3());

/// The one of two values, of single and of double precision, that is of a type.
///
/// # Panics
/// If neither is.
#[inline]
pub(crate) fn of_type<'a, T: 'static>(single: &'a dyn Any, double: &'a dyn Any) -> &'a T {
    let found = single.downcast_ref().or_else(|| double.downcast_ref());
    found.expect("a number is f32 or f64")
}

/// Transposes between points, the numbers of a particle side by side, and the columns of a record.
pub trait Transpose: SimdFloatElement {
    /// Overwrites the first lanes of a record of positions and of one of velocities by those of
    /// as many particles.
    #[doc(hidden)]
    fn gather<S: Simd>(
        simd: S,
        points: &[[Self; POINT]],
        others: &[u32],
        columns: &mut [Self; GATHERED],
    );
    /// The vectors of a record, one by one.
    #[doc(hidden)]
    fn to_quads<S: Simd>(simd: S, columns: &[Self; RECORD]) -> [[Self; QUAD]; LANES];
    /// The record of vectors.
    #[doc(hidden)]
    fn to_columns<S: Simd>(simd: S, quads: &[[Self; QUAD]; LANES]) -> [Self; RECORD];
}

/// Instruction sets, from the one that every target has to the one that few have. All of them give
/// the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// The set that the target of the build always has: SSE2, NEON, simd128 of WebAssembly, or
    /// none.
    Plain,
    /// AVX2: 256 bits.
    Avx2,
    /// AVX-512 as of Ice Lake: 512 bits.
    Avx512,
}

impl Instructions {
    /// Every set, the plainest first.
    pub const ALL: [Instructions; 3] =
        [Instructions::Plain, Instructions::Avx2, Instructions::Avx512];

    /// The best set that this machine has.
    ///
    /// Without the standard library the processor cannot be asked: the set that the build was made
    /// for.
    pub fn best() -> Self {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            let level = best_level();
            if level.as_avx512().is_some() {
                return Instructions::Avx512;
            }
            if level.as_avx2().is_some() {
                return Instructions::Avx2;
            }
        }
        Instructions::Plain
    }

    /// The name a user reads.
    pub fn name(self) -> &'static str {
        match self {
            Instructions::Plain => "plain",
            Instructions::Avx2 => "avx2",
            Instructions::Avx512 => "avx512",
        }
    }

    /// Proof that this machine has these instructions, or the best of them that it has.
    pub(crate) fn level(self) -> Level {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            use fearless_simd::Simd;
            let best = best_level();
            let less = match self {
                Instructions::Plain => best.as_sse2().map(Simd::level),
                Instructions::Avx2 => best.as_avx2().map(Simd::level),
                Instructions::Avx512 => None,
            };
            less.unwrap_or(best)
        }
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        best_level()
    }
}

fn best_level() -> Level {
    Level::try_detect().unwrap_or(Level::baseline())
}

/// Evaluates an expression in code compiled for the instructions of a level: SSE2, AVX2 or AVX-512
/// of x86-64, elsewhere the target of the build. Functions that it calls must be
/// `#[inline(always)]`.
macro_rules! at_level {
    ($level:expr, $simd:ident => $body:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            use fearless_simd::Simd;
            if let Some($simd) = $level.as_avx512() {
                $simd.vectorize(
                    #[inline(always)]
                    || $body,
                )
            } else if let Some($simd) = $level.as_avx2() {
                $simd.vectorize(
                    #[inline(always)]
                    || $body,
                )
            } else {
                let $simd = $level.as_sse2().expect("every processor of x86-64 has SSE2");
                $simd.vectorize(
                    #[inline(always)]
                    || $body,
                )
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        fearless_simd::dispatch!($level, $simd => $body)
    }};
}
pub(crate) use at_level;
