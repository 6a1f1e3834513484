//! The codec, for the fuzzers.

use super::{Chunk, codec};

pub(crate) fn encode(chunk: &Chunk) -> Vec<u8> {
    let mut bytes = Vec::new();
    codec::encode(chunk, &mut bytes);
    bytes
}

pub(crate) fn decode(bytes: &[u8], chunk: &mut Chunk) -> Result<(), (String, String)> {
    codec::decode(bytes, chunk)
}
