//! Buffer views that are compressed by meshoptimizer's codecs.

use super::document::Packed;

/// The most bytes of a decompressed view, which is held as a whole.
const LIMIT: u64 = 256 << 20;

/// A compressed view, checked against the file and the extension's rules.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packing {
    /// Where its data begins in the file.
    pub(super) start: u64,
    /// How long its data is.
    pub(super) length: u64,
    mode: Mode,
    /// Bytes of an element.
    stride: usize,
    count: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Attributes,
    /// With the filter `EXPONENTIAL`.
    Exponents,
    Triangles,
    Indices,
}

/// What is expected, and what is found.
pub(super) type Unfit = (String, String);

impl Packing {
    /// A view of `bytes` that is compressed so, its data at `start` of the file.
    pub(super) fn new(packed: &Packed, start: u64, bytes: u64) -> Result<Packing, Unfit> {
        let unfit = |expected: &str, found: String| Err((expected.to_string(), found));
        let Packed { byte_length: length, byte_stride: stride, count, .. } = *packed;
        let mode = match (packed.mode.as_str(), packed.filter.as_deref().unwrap_or("NONE")) {
            ("ATTRIBUTES", "NONE") => Mode::Attributes,
            ("ATTRIBUTES", "EXPONENTIAL") => Mode::Exponents,
            ("TRIANGLES", "NONE") => Mode::Triangles,
            ("INDICES", "NONE") => Mode::Indices,
            ("ATTRIBUTES", filter) => {
                return unfit(
                    "a view compressed without a filter, or with EXPONENTIAL",
                    format!("the filter {filter}"),
                );
            }
            (mode, _) => return unfit("the mode ATTRIBUTES, TRIANGLES or INDICES, and no filter", mode.to_string()),
        };
        let is_vertices = matches!(mode, Mode::Attributes | Mode::Exponents);
        let is_stride = match is_vertices {
            true => stride.is_multiple_of(4) && (4..=256).contains(&stride),
            false => stride == 2 || stride == 4,
        };
        if !is_stride {
            return unfit("a byteStride that goes with the mode", stride.to_string());
        }
        if mode == Mode::Triangles && !count.is_multiple_of(3) {
            return unfit("three corners for each triangle", format!("{count} corners"));
        }
        let unpacked = count.checked_mul(stride).filter(|unpacked| *unpacked == bytes);
        if unpacked.is_none() {
            return unfit(&format!("elements of {bytes} bytes in all"), format!("{count} of {stride} bytes"));
        }
        // Vertices take two bits for every word of 256 of them; triangles and indices take a byte.
        let most = match mode {
            Mode::Attributes | Mode::Exponents => length.saturating_mul(1024),
            Mode::Triangles => length.saturating_mul(3 * stride),
            Mode::Indices => length.saturating_mul(stride),
        };
        if bytes > most.min(LIMIT) {
            let expected = format!("a view of at most {} bytes from {length} compressed ones", most.min(LIMIT));
            return unfit(&expected, bytes.to_string());
        }
        Ok(Packing { start, length, mode, stride: stride as usize, count: count as usize })
    }

    pub(super) fn unpacked_bytes(&self) -> usize {
        self.stride * self.count
    }

    /// What it decompresses to, in words.
    pub(super) fn content(&self) -> String {
        let what = match self.mode {
            Mode::Attributes | Mode::Exponents => "vertices",
            Mode::Triangles => "corners of triangles",
            Mode::Indices => "indices",
        };
        format!("{} {what} of {} bytes", self.count, self.stride)
    }

    /// The content of `packed`; `None` if that is nothing of the kind.
    pub(super) fn unpack(&self, packed: &[u8]) -> Option<Vec<u8>> {
        match (self.mode, self.stride) {
            (Mode::Attributes, _) => vertices(packed, self.stride, self.count, false),
            (Mode::Exponents, _) => vertices(packed, self.stride, self.count, true),
            (Mode::Triangles, 2) => Some(shorts(meshopt::decode_index_buffer(packed, self.count).ok()?)),
            (Mode::Triangles, _) => Some(words(meshopt::decode_index_buffer(packed, self.count).ok()?)),
            (Mode::Indices, 2) => Some(shorts(meshopt::decode_index_sequence(packed, self.count).ok()?)),
            (Mode::Indices, _) => Some(words(meshopt::decode_index_sequence(packed, self.count).ok()?)),
        }
    }
}

fn shorts(indices: Vec<u16>) -> Vec<u8> {
    indices.into_iter().flat_map(u16::to_le_bytes).collect()
}

fn words(indices: Vec<u32>) -> Vec<u8> {
    indices.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// A vertex of N words: `Default` is not for long arrays.
#[derive(Clone)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Words([0; N])
    }
}

/// Vertices of `stride` bytes, a multiple of 4 up to 256.
fn vertices(packed: &[u8], stride: usize, count: usize, exponents: bool) -> Option<Vec<u8>> {
    fn decode<const N: usize>(packed: &[u8], count: usize, exponents: bool) -> Option<Vec<u8>> {
        let found: Vec<Words<N>> = meshopt::decode_vertex_buffer(packed, count).ok()?;
        let mut bytes = Vec::with_capacity(4 * N * count);
        for Words(mut words) in found {
            if exponents {
                words.iter_mut().for_each(|word| *word = exponential(*word));
            }
            words.iter().for_each(|word| bytes.extend_from_slice(&word.to_ne_bytes()));
        }
        Some(bytes)
    }
    macro_rules! of_words {
        ($($words:literal)*) => {
            match stride / 4 {
                $($words => decode::<$words>(packed, count, exponents),)*
                _ => None,
            }
        };
    }
    of_words!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40
        41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

/// 2^E·M of an exponent of 8 bits and a mantissa of 24, both signed, as the bits of a single.
fn exponential(word: u32) -> u32 {
    let mut one = [[word]];
    meshopt::decode_filter_exp(&mut one);
    one[0][0]
}
