//! The seal of what a link holds: the number of its format, and a checksum, in base 64.

use super::error::LinkError;
use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD as BASE64;
use std::ops::RangeInclusive;

/// Bytes of the checksum, the first of a BLAKE3 hash.
const CHECK: usize = 4;

/// The text of a content in a format.
pub(super) fn seal(format: u8, content: &[u8]) -> String {
    let mut bytes = [&[format], content].concat();
    let check = blake3::hash(&bytes);
    bytes.extend(&check.as_bytes()[..CHECK]);
    BASE64.encode(bytes)
}

/// The format and the content of a text that was sealed in one of some formats.
pub(super) fn unseal(expected: RangeInclusive<u8>, text: &str) -> Result<(u8, Vec<u8>), LinkError> {
    let bytes = BASE64.decode(text).map_err(|_| LinkError::Damaged)?;
    let (bytes, check) = bytes.split_last_chunk::<CHECK>().ok_or(LinkError::Damaged)?;
    // A format to come may check otherwise: it is asked for first.
    let (&format, content) = bytes.split_first().ok_or(LinkError::Damaged)?;
    if !expected.contains(&format) {
        return Err(LinkError::Format(format));
    }
    if blake3::hash(bytes).as_bytes()[..CHECK] != *check {
        return Err(LinkError::Damaged);
    }
    Ok((format, content.to_vec()))
}
