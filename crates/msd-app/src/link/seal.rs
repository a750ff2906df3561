//! Framing of the content of a link: format number and checksum, in base 64.

use super::error::LinkError;
use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD as BASE64;
use std::ops::RangeInclusive;

/// Bytes of the checksum, the first of a BLAKE3 hash.
const CHECK: usize = 4;

/// Encodes content with its format number and a checksum.
pub(super) fn seal(format: u8, content: &[u8]) -> String {
    let mut bytes = [&[format], content].concat();
    let check = blake3::hash(&bytes);
    bytes.extend(&check.as_bytes()[..CHECK]);
    BASE64.encode(bytes)
}

/// Decodes a text of one of the expected formats into its format and its content.
pub(super) fn unseal(expected: RangeInclusive<u8>, text: &str) -> Result<(u8, Vec<u8>), LinkError> {
    let bytes = BASE64.decode(text).map_err(|_| LinkError::Damaged)?;
    let (bytes, check) = bytes.split_last_chunk::<CHECK>().ok_or(LinkError::Damaged)?;
    // The format comes first: a future one may use another checksum.
    let (&format, content) = bytes.split_first().ok_or(LinkError::Damaged)?;
    if !expected.contains(&format) {
        return Err(LinkError::Format(format));
    }
    if blake3::hash(bytes).as_bytes()[..CHECK] != *check {
        return Err(LinkError::Damaged);
    }
    Ok((format, content.to_vec()))
}
