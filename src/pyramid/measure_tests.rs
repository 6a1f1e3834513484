//! The quick measure against one that leaves nothing out.

use super::Body;
use super::body::{Angle, minus};
use super::budget::Memory;
use super::facet::{DOUBT, Facet};
use super::grid::{Grid, Level, TileKey};
use super::measure::{Known, Meter};
use super::quantize::{Relief, Steps};
use super::rough::Rough;
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
    samples_of(grid, area, |c, r| {
        let (x, y) = (c as f64, r as f64);
        let is_known = (c / 9 + r / 7) % 11 != 3;
        is_known.then(|| 4e5 * libm::sin(x / 5.0) * libm::cos(y / 7.0) + 2e4 * ((x * 1.3 + y * 2.1) % 5.0))
    })
}

fn samples_of(grid: Grid, area: Area, height_at: impl Fn(i64, i64) -> Option<f64> + Sync) -> Samples {
    let fill = |_: &mut (), (column, row): (i64, i64), heights: &mut [f64]| {
        for (i, height) in heights.iter_mut().enumerate() {
            let (c, r) = (column + (i % BLOCK) as i64, row + (i / BLOCK) as i64);
            let across = area.column..area.column + area.width as i64;
            if across.contains(&c) && (area.row..area.row + area.height as i64).contains(&r) {
                *height = height_at(c, r).unwrap_or(f64::NAN);
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

/// Gentle ground with spikes, of which few triangles are made: most of it is passed over square by square.
#[test]
fn nothing_is_left_out_of_squares() {
    let grid = Grid { exponent: 16 };
    let tile = TileKey { level: 8, x: 270, y: 150 };
    let (column, row) = tile.origin(grid);
    let area = Area { column: column - 70, row: row + 20, width: 400, height: 200 };
    let height_at = |c: i64, r: i64| {
        let (x, y) = (c as f64, r as f64);
        let spike = if (c * 7919 + r * 104_729) % 5003 == 0 { 9_000.0 } else { 0.0 };
        let is_known = (c / 9 + r / 7) % 11 != 3;
        is_known.then(|| 3_000.0 * libm::sin(x / 90.0) * libm::cos(y / 70.0) + spike)
    };
    let samples = &samples_of(grid, area, height_at);
    let (max_error, cancel, memory) = (15_000.0, &CancelToken::default(), &Memory::of_threads(1));
    let level = Level { level: tile.level, max_error, client_error: max_error, parts: 1 };
    let reliefs = [(tile, Relief::of(-3e3).with(Relief::of(1.3e4)))].into_iter().collect();
    let steps = &Steps::of(&reliefs, None);
    let (cut_finer, max_stray) = (1, f64::INFINITY);
    let task = LevelTask { body: &EARTH, samples, level, cut_finer, steps, max_stray, cuts: false, memory, cancel };
    let (surface, measured) = task.make(tile, &mut TileMaker::default()).expect("a tile");
    assert!(surface.triangles.len() <= 32, "{}", surface.triangles.len());
    let patch = Patch { column, row, width: 256, height: 256, step: 1 };
    let rough = Rough::of(&EARTH, samples, patch).expect("outlines").expect("known");
    let (worst, largest) = naive(samples, &surface);
    assert_eq!(measured.max_error, largest);
    let facets: Vec<Facet> =
        surface.triangles.iter().map(|&t| Facet::new(&surface, t, &EARTH, surface.columns(grid))).collect();
    let mut passed_over = 0;
    for share in [0.3, 0.7, 1.0] {
        for (facet, &worst) in facets.iter().zip(&worst) {
            let is_open = rough.has_any(facet, (0, 0), share * largest);
            assert!(is_open || worst <= share * largest, "{worst} of {largest} at {share}");
            let columns = (0..256).step_by(16).map(|row| rough.columns(facet, (0, 0), row, share * largest).len());
            passed_over += columns.filter(|&columns| columns < 256).count();
        }
    }
    assert!(passed_over > 0);
    let mut known = Known::default();
    let found =
        Meter { body: &EARTH, samples, cancel }.measure(&surface, 0.5 * largest, &mut known, &mut Block::default());
    let failing = found.expect("errors").failing.len();
    assert_eq!(failing, worst.iter().filter(|&&worst| worst > 0.5 * largest).count());
}
