//! The quick measure against one that leaves nothing out.

use super::Body;
use super::body::{Angle, minus};
use super::budget::Memory;
use super::facet::{DOUBT, Facet};
use super::grid::{Grid, Level, TileKey};
use super::measure::{Known, Meter};
use super::quantize::{Relief, Steps};
use super::samples::{Block, Patch, Samples};
use super::source::Area;
use super::store::BLOCK;
use super::surface::Surface;
use super::tile::{LevelTask, TileMaker};
use crate::base::control::{CancelToken, Control};

const EARTH: Body = Body { semi_major: 6_378_137.0, semi_minor: 6_356_752.314_245_179 };

/// Rough ground around the whole body, with gaps.
fn samples(grid: Grid) -> Samples {
    let area = Area { column: 0, row: 0, width: grid.columns() as usize, height: grid.rows() as usize + 1 };
    let fill = |_: &mut (), (column, row): (i64, i64), heights: &mut [f64]| {
        for (i, height) in heights.iter_mut().enumerate() {
            let (c, r) = (column + (i % BLOCK) as i64, row + (i / BLOCK) as i64);
            let (x, y) = (c as f64, r as f64);
            let is_known = r <= grid.rows() && (c / 9 + r / 7) % 11 != 3;
            if is_known {
                *height = 4e5 * libm::sin(x / 5.0) * libm::cos(y / 7.0) + 2e4 * ((x * 1.3 + y * 2.1) % 5.0);
            }
        }
        Ok(true)
    };
    let folder = crate::fuzzing::temp_dir();
    let file = crate::pyramid::store::temporary(&folder).expect("a file");
    Samples::make(grid, area, 0.0, (file, &folder), || Ok(()), fill, &Control::default()).expect("samples")
}

/// Every sample against every triangle: the worst errors, and the largest of all.
fn naive(samples: &Samples, surface: &Surface) -> (Vec<f64>, f64) {
    let grid = samples.grid;
    let cells = grid.cells(surface.tile.level);
    let (column, row) = surface.tile.origin(grid);
    let facet = |&t: &[u32; 3]| Facet::new(surface, t, &EARTH, surface.columns(grid));
    let facets: Vec<Facet> = surface.triangles.iter().map(facet).collect();
    let side = cells as usize + 1;
    let mut block = Block::default();
    samples.read(Patch { column, row, width: side, height: side, step: 1 }, &mut block).expect("samples");
    let mut worst = vec![0.0f64; facets.len()];
    for i in (0..side * side).filter(|&i| block.inside[i]) {
        let (c, r) = ((i % side) as i64, (i / side) as i64);
        let (lon, lat) = (Angle::of(grid.longitude(column + c)), Angle::of(grid.latitude(row + r)));
        let (place, normal) = (minus(EARTH.point(lon, lat, 0.0), surface.centre), Body::normal(lon, lat));
        let numbers =
            |is: &dyn Fn(&Facet) -> bool| (0..facets.len()).filter(|&f| is(&facets[f])).collect::<Vec<usize>>();
        let mut judges = numbers(&|facet| facet.has(place, normal));
        if judges.is_empty() {
            judges = numbers(&|facet| facet.is_passed(place, normal, (c as f64, r as f64)));
        }
        assert!(!judges.is_empty(), "{c}, {r} of {}", surface.tile);
        judges.iter().for_each(|&f| worst[f] = worst[f].max(facets[f].error(place, normal, block.heights[i], DOUBT)));
    }
    let largest = worst.iter().copied().fold(0.0, f64::max);
    (worst, largest)
}

#[test]
fn nothing_is_left_out() {
    let grid = Grid { exponent: 7 };
    let samples = samples(grid);
    let cancel = CancelToken::default();
    let memory = Memory::of_threads(1);
    let max_error = 300_000.0;
    for (level, x, y) in [(1, 0, 0), (1, 3, 1), (2, 5, 3), (2, 2, 1), (3, 9, 5), (3, 3, 0), (3, 15, 7)] {
        let tile = TileKey { level, x, y };
        let level = Level { level, max_error, client_error: max_error, parts: 16 >> level };
        let reliefs = [(tile, Relief::of(-4.1e5).with(Relief::of(5.1e5)))].into_iter().collect();
        let steps = Steps::of(&reliefs, None);
        let (samples, steps, cancel, memory) = (&samples, &steps, &cancel, &memory);
        let task = LevelTask {
            body: &EARTH,
            samples,
            level,
            cut_finer: 1,
            steps,
            max_stray: 1.5,
            cuts: false,
            memory,
            cancel,
        };
        let (surface, measured) = task.make(tile, &mut TileMaker::default()).expect("a tile");
        let (worst, largest) = naive(samples, &surface);
        assert!(largest > 0.0 && largest <= max_error, "{tile}: {largest} of {max_error}");
        assert_eq!(measured.max_error, largest, "{tile}");
        let meter = Meter { body: &EARTH, samples, cancel };
        let mut block = Block::default();
        for share in [0.1, 0.5, 0.9] {
            let mut known = Known::default();
            let found = meter.measure(&surface, share * largest, &mut known, &mut block).expect("errors");
            let expected: Vec<usize> = (0..worst.len()).filter(|&f| worst[f] > share * largest).collect();
            assert_eq!(found.failing.len(), expected.len(), "{tile} at {share}");
            let again = meter.measure(&surface, share * largest, &mut known, &mut block).expect("errors");
            assert_eq!((found.samples, found.failing), (again.samples, again.failing));
            // What was within this tolerance is within a larger one, and the largest error is found all the same.
            let all = meter.measure(&surface, largest, &mut known, &mut block).expect("errors");
            assert_eq!((all.max_error, all.failing.len()), (largest, 0), "{tile} after {share}");
        }
    }
}
