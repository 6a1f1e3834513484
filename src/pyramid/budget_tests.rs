//! What tiles take of memory, as it is counted, and how they wait for it.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::Body;
use super::budget::Memory;
use super::error::PyramidError;
use super::grid::{Grid, Level, TileKey};
use super::measure::BYTES_PER_TRIANGLE;
use super::quantize::{Relief, Steps};
use super::samples::Samples;
use super::source::Area;
use super::store::{self, BLOCK, CACHE_BYTES};
use super::tile::{LevelTask, TileMaker};
use crate::base::control::{CancelToken, Control};
use crate::testing::heap::peak_of;

const BODY: Body = Body { semi_major: 1_737_400.0, semi_minor: 1_737_400.0 };
const TILE: TileKey = TileKey { level: 10, x: 1200, y: 600 };

/// A height of no pattern, up to 1 km.
fn noise(column: i64, row: i64) -> f64 {
    let mut bits =
        (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (row as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    bits = (bits ^ bits >> 31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (bits >> 40) as f64 * 1e3 / (1u64 << 24) as f64
}

/// With this grid nearly every sample of a tile becomes a vertex, so its mesh is as large as one can be.
#[test]
fn a_thread_takes_what_is_reckoned() {
    let grid = Grid { exponent: 16 };
    let (column, row) = TILE.origin(grid);
    let area = Area { column: column - 1, row: row - 1, width: 67, height: 67 };
    let fill = |_: &mut (), (column, row): (i64, i64), heights: &mut [f64]| {
        for (i, height) in heights.iter_mut().enumerate() {
            let (column, row) = (column + (i % BLOCK) as i64, row + (i / BLOCK) as i64);
            let is_in = |at: i64, first: i64| (first..first + 67).contains(&at);
            if is_in(column, area.column) && is_in(row, area.row) {
                *height = noise(column, row);
            }
        }
        Ok(true)
    };
    let folder = crate::fuzzing::temp_dir();
    let file = store::temporary(&folder).expect("a file");
    let samples = Samples::make(grid, area, 0.0, (file, &folder), || Ok(()), fill, &Control::default());
    let samples = samples.expect("samples");
    let level = Level { level: TILE.level, max_error: 200.0, client_error: 200.0, parts: 1 };
    let reliefs = [(TILE, Relief::of(0.0).with(Relief::of(1e3)))].into_iter().collect();
    let (steps, cancel, memory) = (Steps::of(&reliefs, None), CancelToken::default(), Memory::of_threads(1));
    let (samples, steps, cancel, memory) = (&samples, &steps, &cancel, &memory);
    let task =
        LevelTask { body: &BODY, samples, level, cut_finer: 1, steps, max_stray: 1.5, cuts: false, memory, cancel };
    let mut maker = TileMaker::default();
    let (made, counted) = peak_of(|| task.make(TILE, &mut maker));
    let triangles = made.expect("a tile").0.triangles.len() as u64;
    assert!(triangles > 3000, "{triangles}");
    let reckoned = triangles * BYTES_PER_TRIANGLE;
    // Beside it, blocks that have been read, what small parts are made in, and a window of samples.
    let beside = CACHE_BYTES + (1 << 20);
    assert!(counted <= reckoned + beside, "{reckoned} bytes reckoned, {counted} counted");
    assert!(counted >= reckoned, "{reckoned} bytes reckoned, {counted} counted");
}

#[test]
fn large_tiles_wait_for_each_other() {
    let memory = Memory::of_threads(1);
    let (inside, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let one = || {
        let mut room = memory.room();
        room.hold(TILE, 100_000).expect("room");
        most.fetch_max(inside.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
        room.hold(TILE, 120_000).expect("room");
        std::thread::sleep(std::time::Duration::from_millis(5));
        inside.fetch_sub(1, Ordering::SeqCst);
    };
    // An ordinary one waits for none.
    let mut large = memory.room();
    large.hold(TILE, 100_000).expect("room");
    memory.room().hold(TILE, 1000).expect("room");
    drop(large);
    std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(one))));
    assert_eq!((inside.into_inner(), most.into_inner()), (0, 1));
    assert!(matches!(memory.room().hold(TILE, 131_073), Err(PyramidError::Vertices { found: 65_539, .. })));
}
