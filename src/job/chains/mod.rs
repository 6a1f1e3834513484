//! The chains of breaklines over a whole raster: found before the first tile, from the samples along the lines.
//!
//! Each tile with a line is loaded once, or twice where samples may be missing: first it is found out what of the lines lies on the
//! ground, as that decides where lines end and meet. A chain depends on the samples of its own tile, and one around it; where it ends is
//! decided by the segments that touch the tile. So rows of tiles are worked on one after the other, a *band* of some rows at a time,
//! and what is found is put away ([`ChainStore`]).

mod store;

use std::ops::Range;

use rayon::prelude::*;

use super::Error;
use super::passes::Job;
use crate::base::external::Scratch;
use crate::base::lattice::STEPS;
use crate::base::tiling::TileGrid;
use crate::base::{Tile, Window};
use crate::field::{Field, LoadScratch};
use crate::kernel::breaklines::{
    Breaklines, Chains, Pieces, Place, Segment, Stretch, Surroundings, Thinning, Untenable, surroundings, thin, tile_of,
};

pub(super) use store::ChainStore;

/// So many tiles make a band, at the least: enough for the threads of a machine, and few enough for its memory.
const TILES_OF_BAND: usize = 16;

/// Rows of tiles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Band {
    /// The rows of the grid.
    rows: Range<usize>,
    /// The rows of the lattice: what lies on the line to the next band is that one's.
    places: Range<i64>,
}

impl Band {
    /// All bands of a grid, from the top.
    fn of(grid: &TileGrid) -> Vec<Band> {
        let rows = TILES_OF_BAND.div_ceil(grid.columns()).max(1);
        let start = |row: usize| match row == grid.rows() {
            true => i64::MAX,
            false => grid.window(grid.tile(row * grid.columns())).row as i64 * i64::from(STEPS),
        };
        let bands = (0..grid.rows()).step_by(rows).map(|first| first..(first + rows).min(grid.rows()));
        bands.map(|rows| Band { places: start(rows.start)..start(rows.end), rows }).collect()
    }

    /// Whether it has a tile.
    fn has(&self, tile: usize, grid: &TileGrid) -> bool {
        self.rows.contains(&(tile / grid.columns()))
    }
}

/// How many segments each band of a grid has. They are known by strips of `rows` rows of the lattice; a strip that several bands share
/// counts in each.
pub(super) fn in_bands(grid: &TileGrid, rows: i64, segments: &[u64]) -> Vec<u64> {
    let in_band = |band: &Band| {
        let [first, last] = [band.places.start, band.places.end.min(rows * segments.len() as i64) - 1];
        segments[(first / rows) as usize..=(last / rows) as usize].iter().sum::<u64>()
    };
    Band::of(grid).iter().map(in_band).collect()
}

/// Finds the chains of a job's lines on the threads of the current rayon pool; `None` where it has none.
///
/// Memory: a tile's samples for each busy thread; some 260 bytes for each segment of the lines in a band, and 64 for those in the bands
/// above and below it.
pub(super) fn find(job: &Job<'_>) -> Result<Option<ChainStore>, Error> {
    let Some(lines) = &job.params.breaklines else { return Ok(None) };
    let bands = Band::of(&job.grid);
    let scratch = Scratch::new(Some(&job.params.temp_dir), job.control.cancel.clone());
    let mut store = ChainStore::new(job.grid, bands.clone(), lines, scratch);
    let mut above = OnGround::default();
    let mut here = on_ground(job, &*lines.in_rows(&bands[0].places)?, &bands[0])?;
    for (number, band) in bands.iter().enumerate() {
        let below = bands.get(number + 1).map(|next| on_ground(job, &*lines.in_rows(&next.places)?, next));
        let below = below.transpose()?.unwrap_or_default();
        let touching = here.with_touching(&above, &below, &band.places);
        let made = in_band(job, &*lines.in_rows(&band.places)?, band, &touching)?;
        store.put(number, &made, lines, &here.off_ground)?;
        above = std::mem::replace(&mut here, below);
    }
    Ok(Some(store))
}

/// The chains of a band, on whose ground these segments lie, or touch it.
fn in_band(job: &Job<'_>, lines: &Breaklines, band: &Band, ground: &OnGround) -> Result<Chains, Error> {
    let (field, grid) = (job.field, job.grid);
    let size = (field.width(), field.height());
    let OnGround { segments, at_voids, .. } = ground;
    let pieces = Pieces::new(lines, segments, at_voids, job.params.points.as_deref(), &grid, size);
    let by_tile: Vec<(usize, &[Stretch])> = pieces.by_tile().filter(|(tile, _)| band.has(*tile, &grid)).collect();
    let tolerance = job.params.tolerance.kept();
    let made = by_tile.into_par_iter().map_init(Loading::default, |loading, (tile, pieces)| {
        let window = loading.load(field, &grid, tile)?;
        let mut points = Vec::new();
        job.params.points.iter().for_each(|set| set.within(window, &mut points));
        let (tile, cancel) = (&loading.tile, &job.control.cancel);
        let task = Thinning { tile, window, size, tolerance, lines, points: &points, cancel };
        Ok((window, thin(&task, pieces)?))
    });
    Ok(Chains::new(made.collect::<Result<Vec<_>, Error>>()?))
}

impl From<Untenable> for Error {
    fn from(untenable: Untenable) -> Error {
        match untenable {
            Untenable::Height { column, row } => Error::LineHeight { column, row },
            Untenable::Cancelled => Error::Cancelled(crate::base::control::Cancelled),
        }
    }
}

/// The samples of one tile after the other.
#[derive(Default)]
struct Loading {
    tile: Tile,
    scratch: LoadScratch,
}

impl Loading {
    fn load(&mut self, field: &Field, grid: &TileGrid, tile: usize) -> Result<Window, Error> {
        let window = grid.place(tile).window;
        field.load_with(window, &mut self.tile, &mut self.scratch)?;
        Ok(window)
    }
}

/// What of the lines of a band lies on the ground.
#[derive(Default)]
struct OnGround {
    /// In order.
    segments: Vec<Segment>,
    /// Ends of segments at cells that are not whole, in order.
    at_voids: Vec<Place>,
    /// For each set, how many segments do not lie on the ground.
    off_ground: Vec<u64>,
}

impl OnGround {
    /// The same with what touches the band in those above and below it.
    fn with_touching(&self, above: &OnGround, below: &OnGround, places: &Range<i64>) -> OnGround {
        let touches = |segment: &&Segment| segment[1].y == places.start || segment[0].y == places.end;
        let all = [above, self, below].into_iter().enumerate();
        let segments = all.flat_map(|(i, ground)| ground.segments.iter().filter(move |s| i == 1 || touches(s)));
        let segments: Vec<Segment> = segments.copied().collect();
        let mut at_voids = [above, self, below].map(|ground| ground.at_voids.as_slice()).concat();
        at_voids.retain(|place| (places.start..=places.end).contains(&place.y));
        at_voids.sort_unstable();
        at_voids.dedup();
        OnGround { segments, at_voids, off_ground: Vec::new() }
    }
}

fn on_ground(job: &Job<'_>, lines: &Breaklines, band: &Band) -> Result<OnGround, Error> {
    let (field, grid) = (job.field, job.grid);
    let size = (field.width(), field.height());
    let all = lines.segments_in(band.places.clone());
    let mut found = OnGround { off_ground: vec![0; lines.set_count()], ..OnGround::default() };
    if !field.may_have_gaps() {
        let is_inside = |segment: &&Segment| lines.cells_beside(**segment).next().is_some();
        found.segments = all.iter().filter(is_inside).copied().collect();
    } else {
        let mut by_tile: Vec<(usize, Segment)> =
            all.iter().map(|&segment| (tile_of(segment, &grid, size), segment)).collect();
        by_tile.sort_unstable();
        let tiles: Vec<&[(usize, Segment)]> = by_tile.chunk_by(|a, b| a.0 == b.0).collect();
        let around = tiles.into_par_iter().map_init(Loading::default, |loading, of_tile| {
            job.control.cancel.check()?;
            let window = loading.load(field, &grid, of_tile[0].0)?;
            let segments: Vec<Segment> = of_tile.iter().map(|(_, segment)| *segment).collect();
            let around = surroundings(lines, &loading.tile, window, size, &segments);
            Ok(segments.into_iter().zip(around).collect::<Vec<_>>())
        });
        let around = around.collect::<Result<Vec<_>, Error>>()?.concat();
        for (segment, Surroundings { ends_at_void, .. }) in around.into_iter().filter(|(_, around)| around.is_ground) {
            found.segments.push(segment);
            let at_voids = segment.into_iter().zip(ends_at_void).filter(|(_, is_at_void)| *is_at_void);
            found.at_voids.extend(at_voids.map(|(place, _)| place));
        }
        found.segments.sort_unstable();
        found.at_voids.sort_unstable();
        found.at_voids.dedup();
    }
    for segment in all.iter().filter(|segment| found.segments.binary_search(segment).is_err()) {
        let bits = lines.counting(lines.sets_of(*segment));
        (0..).zip(&mut found.off_ground).for_each(|(set, count)| *count += u64::from(bits >> set & 1));
    }
    Ok(found)
}
