//! Numbers made of bytes: mostly plain ones, some over 24 decades, some NaN or infinite.

use arbitrary::{Result, Unstructured};
use msd_core::glam::DVec3;

/// Numbers that a careless or hostile user may write.
const ODD: [f64; 16] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    3.4028234663852886e38,
    3.5e38,
    1e-45,
    1e-39,
    1e6,
    1e12,
    1.0,
    -1.0,
];

/// Any number: a fourth are over 24 decades, a fourth odd or of any bits.
pub(crate) fn any(u: &mut Unstructured) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? % 8 {
        0..=3 => f64::from(u.arbitrary::<i16>()?) / 1024.0,
        4 | 5 => decade(u)? * if u.arbitrary()? { 1.0 } else { -1.0 },
        6 => ODD[usize::from(u.arbitrary::<u8>()?) % ODD.len()],
        _ => f64::from_bits(u.arbitrary()?),
    })
}

/// A number that is mostly positive: 1, one from 1e-12 to 1e12, or any.
pub(crate) fn positive(u: &mut Unstructured) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? % 16 {
        0..=5 => 1.0,
        6..=14 => decade(u)?,
        _ => any(u)?,
    })
}

/// A positive number from 1e-12 to 1e13.
pub(crate) fn decade(u: &mut Unstructured) -> Result<f64> {
    let exponent = i32::from(u.arbitrary::<u8>()? % 25) - 12;
    let mantissa = 1.0 + f64::from(u.arbitrary::<u8>()?) / 32.0;
    Ok(mantissa * 10f64.powi(exponent))
}

/// A vector of any numbers.
pub(crate) fn vector(u: &mut Unstructured) -> Result<DVec3> {
    Ok(DVec3::new(any(u)?, any(u)?, any(u)?))
}

/// An index that is mostly below `count`.
pub(crate) fn index(u: &mut Unstructured, count: usize) -> Result<usize> {
    let byte = u.arbitrary::<u8>()?;
    Ok(match byte {
        255 => usize::MAX,
        240..255 => usize::from(byte - 240),
        _ => usize::from(byte) % count.max(1),
    })
}
