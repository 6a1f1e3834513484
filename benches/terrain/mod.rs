//! Tiles for the benchmarks. Heights come from integer hashes and the four basic operations alone, so that they, and
//! the counts expected of the engines, are the same on every machine.

#![allow(dead_code, unreachable_pub)] // each benchmark takes what it needs

use terrabite::base::{Heights, Tile};

/// A tile whose heights are a function of column and row, in single precision.
pub fn tile(width: usize, height: usize, at: impl Fn(usize, usize) -> f64) -> Tile {
    Tile::from_heights(width, height, Heights::F32(samples(width, height, at).map(|v| v as f32).collect()))
}

/// The same heights in double precision.
pub fn wide(tile: &Tile) -> Tile {
    let heights = samples(tile.width(), tile.height(), |column, row| tile.at(column, row)).collect();
    Tile::from_heights(tile.width(), tile.height(), Heights::F64(heights))
}

fn samples(width: usize, height: usize, at: impl Fn(usize, usize) -> f64) -> impl Iterator<Item = f64> {
    (0..width * height).map(move |i| at(i % width, i / width))
}

/// Mountains of 1000 m over 512 cells: octaves of value noise, each half as high and half as long as the one before.
pub fn fractal(column: usize, row: usize) -> f64 {
    let octave = |level: u32| {
        let length = (256 >> level) as f64;
        value_noise(column as f64 / length, row as f64 / length, level) * (500.0 / f64::from(1u32 << level))
    };
    (0..8).map(octave).sum()
}

/// Numbers in 0..1 on a lattice, blended smoothly between.
fn value_noise(x: f64, y: f64, seed: u32) -> f64 {
    let (column, row) = (x as u32, y as u32);
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (right, down) = (smooth(x - f64::from(column)), smooth(y - f64::from(row)));
    let corner = |c: u32, r: u32| unit(hash(column + c, row + r, seed));
    let top = corner(0, 0) + right * (corner(1, 0) - corner(0, 0));
    let bottom = corner(0, 1) + right * (corner(1, 1) - corner(0, 1));
    top + down * (bottom - top)
}

/// Uncorrelated heights in 0..1.
pub fn noise(column: usize, row: usize) -> f64 {
    unit(hash(column as u32, row as u32, 77))
}

/// A number in 0..1 from the upper 24 bits of a hash.
pub fn unit(hash: u32) -> f64 {
    f64::from(hash >> 8) / f64::from(1u32 << 24)
}

/// 32 bits from three numbers.
pub fn hash(a: u32, b: u32, c: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9e37_79b1) ^ b.wrapping_mul(0x85eb_ca77) ^ c.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}
