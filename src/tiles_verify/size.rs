//! How much memory judging a set takes, by the sizes of its files.
//!
//! A vertex takes eight bytes of a file, normals included, and a triangle six. A tile's triangles are at most two for each vertex, and those on
//! its border, which have two bytes more, at most two more than its triangles.

use std::collections::BTreeSet;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::facets::BYTES_PER_TRIANGLE;
use super::own;
use crate::pyramid::{Judging, TileKey};

/// The most triangles that a tile is read with: two for each vertex.
const MOST_TRIANGLES: u64 = 2 * 65_536;

/// What a tile has of them and of their numbers on the border; a file of more is wrong, or has extensions that are passed over.
const MOST_BYTES: u64 = 88 + 65_536 * (8 + 2 * 2) + MOST_TRIANGLES * 6;

/// What a border vertex takes as long as all tiles are judged.
const BYTES_ON_BORDER: u64 = 24;

/// What a tile takes as long: its address, three times, and what was found.
const BYTES_PER_TILE: u64 = 500;

/// What a window of samples takes while a tile is compared.
const WINDOW: u64 = 2 << 20;

/// What judging these tiles takes. A file that cannot be read is found when it is judged.
pub(super) fn judging(folder: &Path, tiles: &BTreeSet<TileKey>, gzip: bool) -> Judging {
    let sizes = tiles.iter().map(|key| size(&folder.join(format!("{key}.terrain")), gzip).unwrap_or(0));
    let (mut border, mut triangles, mut largest) = (0, 0, 0);
    for size in sizes {
        border += size / (8 + 6 + 2);
        triangles = triangles.max(size / (8 / 2 + 6)).min(MOST_TRIANGLES);
        largest = largest.max(size);
    }
    let tile = triangles * BYTES_PER_TRIANGLE + 2 * largest;
    Judging {
        in_common: border * BYTES_ON_BORDER + tiles.len() as u64 * BYTES_PER_TILE,
        each: tile + WINDOW.max(own::BYTES_OF_WINDOW),
    }
}

/// The bytes of a tile, up to those that one can have. What is compressed says at its end, in 32 bits, how long it was.
fn size(path: &Path, gzip: bool) -> std::io::Result<u64> {
    let file = File::open(path)?;
    let bytes = file.metadata()?.len();
    if !gzip || bytes < 4 {
        return Ok(bytes.min(MOST_BYTES));
    }
    let mut plain = [0; 4];
    file.read_exact_at(&mut plain, bytes - 4)?;
    Ok(bytes.max(u32::from_le_bytes(plain).into()).min(MOST_BYTES))
}
