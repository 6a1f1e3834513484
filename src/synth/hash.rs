//! Randomness by place: a hash of a key and an integer lattice point, the same on every machine.

/// The bits at lattice point (x, y) of the stream `key`.
///
/// Two rounds of multiply and xor-shift over a linear mix of the coordinates (constants of Stafford's variant 13 of
/// the MurmurHash3 finaliser and the golden ratio): enough that neither pictures nor spectra show the lattice.
#[inline(always)]
pub(super) fn hash(key: u64, x: i64, y: i64) -> u64 {
    let mixed = key
        ^ (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F).rotate_left(31);
    finish(mixed)
}

/// The key of a named stream of a seed.
pub(super) fn key(seed: u64, stream: u64) -> u64 {
    finish(finish(seed.wrapping_add(0x9E37_79B9_7F4A_7C15)) ^ stream.wrapping_mul(0xD6E8_FEB8_6659_FD93))
}

#[inline(always)]
fn finish(mut h: u64) -> u64 {
    h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^ (h >> 31)
}

/// The upper half of a hash as a number in [−1, 1).
#[inline(always)]
pub(super) fn high(h: u64) -> f64 {
    f64::from((h >> 32) as u32 as i32) / 2_147_483_648.0
}

/// The lower half of a hash as a number in [−1, 1).
#[inline(always)]
pub(super) fn low(h: u64) -> f64 {
    f64::from(h as u32 as i32) / 2_147_483_648.0
}
