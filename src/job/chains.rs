//! The chains of breaklines over a whole raster: found before the first tile, from the samples along the lines.
//!
//! Each tile with a line is loaded once, or twice where samples may be missing: first it is found out what of the lines lies on the
//! ground, as that decides where lines end and meet. A chain depends on the samples of its own tile, and one around it.

use rayon::prelude::*;

use super::Error;
use super::passes::Job;
use crate::base::tiling::TileGrid;
use crate::base::{Tile, Window};
use crate::field::{Field, LoadScratch};
use crate::kernel::breaklines::{
    Breaklines, Chains, Pieces, Place, Segment, Surroundings, Thinning, Untenable, surroundings, thin, tile_of,
};

/// Finds the chains of a job's lines on the threads of the current rayon pool; `None` where it has none.
///
/// Memory: a tile's samples for each busy thread; some 250 bytes for each segment of the lines.
pub(super) fn find(job: &Job<'_>) -> Result<Option<Chains>, Error> {
    let Some(lines) = &job.params.breaklines else { return Ok(None) };
    let (field, grid) = (job.field, job.grid);
    let size = (field.width(), field.height());
    lines.check_heights(job.params.tolerance.kept())?;
    let OnGround { segments, at_voids } = on_ground(job, lines)?;
    let off_ground = lines.each_without(&segments);
    let pieces = Pieces::new(lines, &segments, &at_voids, job.params.points.as_deref(), &grid, size);
    let by_tile: Vec<_> = pieces.by_tile().collect();
    let tolerance = job.params.tolerance.kept();
    let made = by_tile.into_par_iter().map_init(Loading::default, |loading, (tile, pieces)| {
        let window = loading.load(field, &grid, tile)?;
        let mut points = Vec::new();
        job.params.points.iter().for_each(|set| set.within(window, &mut points));
        let (tile, cancel) = (&loading.tile, &job.control.cancel);
        let task = Thinning { tile, window, size, tolerance, lines, points: &points, cancel };
        Ok((window, thin(&task, pieces)?))
    });
    let tiles = made.collect::<Result<Vec<_>, Error>>()?;
    Ok(Some(Chains::new(tiles, off_ground).within_outlines(lines.inside().cloned())))
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

/// What of lines lies on the ground.
struct OnGround {
    segments: Vec<Segment>,
    /// Ends of segments at cells that are not whole, in order.
    at_voids: Vec<Place>,
}

fn on_ground(job: &Job<'_>, lines: &Breaklines) -> Result<OnGround, Error> {
    let (field, grid) = (job.field, job.grid);
    let size = (field.width(), field.height());
    if !field.may_have_gaps() {
        let is_inside = |segment: &&Segment| lines.cells_beside(**segment).next().is_some();
        return Ok(OnGround {
            segments: lines.segments().iter().filter(is_inside).copied().collect(),
            at_voids: Vec::new(),
        });
    }
    let mut by_tile: Vec<(usize, Segment)> =
        lines.segments().iter().map(|&segment| (tile_of(segment, &grid, size), segment)).collect();
    by_tile.sort_unstable();
    let tiles: Vec<&[(usize, Segment)]> = by_tile.chunk_by(|a, b| a.0 == b.0).collect();
    let found = tiles.into_par_iter().map_init(Loading::default, |loading, of_tile| {
        job.control.cancel.check()?;
        let window = loading.load(field, &grid, of_tile[0].0)?;
        let segments: Vec<Segment> = of_tile.iter().map(|(_, segment)| *segment).collect();
        let around = surroundings(lines, &loading.tile, window, size, &segments);
        Ok(segments.into_iter().zip(around).collect::<Vec<_>>())
    });
    let found = found.collect::<Result<Vec<_>, Error>>()?.concat();
    let ground = found.into_iter().filter(|(_, around)| around.is_ground);
    let (mut segments, mut at_voids) = (Vec::new(), Vec::new());
    for (segment, Surroundings { ends_at_void, .. }) in ground {
        segments.push(segment);
        at_voids.extend(segment.into_iter().zip(ends_at_void).filter(|(_, is_at_void)| *is_at_void).map(|(p, _)| p));
    }
    segments.sort_unstable();
    at_voids.sort_unstable();
    at_voids.dedup();
    Ok(OnGround { segments, at_voids })
}
