//! Which tiles are tried before a run, and what their heights are like.

use rayon::prelude::*;

use crate::base::control::Stage;
use crate::base::tiling::{TileGrid, TileId, spread};
use crate::job::Error;
use crate::job::passes::{Job, Pool, TileMaker};

/// One of so many tiles is among the few, and two where there are eight.
const ONE_OF: usize = 8;
const LEAST: usize = 2;
/// No more tiles than this are among the few, or the many.
const MOST: [usize; 2] = [256, 1024];

/// Tiles with ground, spread evenly over a raster.
#[derive(Debug)]
pub(super) struct Sample {
    /// One of eight, the more of them the rougher the ground.
    pub(super) few: Vec<TileId>,
    /// All, where there are not too many.
    pub(super) many: Vec<TileId>,
    /// What counts of the few, and of the many, are to be multiplied by for the whole raster.
    pub(super) times: [f64; 2],
    /// From the least height to the greatest of a tile, at the most.
    pub(super) span: f64,
    /// What heights are multiples of: 1, where all are whole numbers.
    pub(super) step: Option<f64>,
}

impl Sample {
    /// Loads up to 1024 tiles.
    pub(super) fn look(job: &Job<'_>, makers: &Pool<TileMaker>) -> Result<Sample, Error> {
        let grid = job.grid;
        let all = evenly(grid, grid.len().min(MOST[1]));
        let looked = for_each(job, makers, &all, |maker, job, id| maker.look(job, &grid.place_of(id)))?;
        let grounded = all.iter().zip(&looked).filter_map(|(id, looked)| Some((*id, looked.span?)));
        let grounded: Vec<(TileId, f64)> = grounded.collect();
        let wanted = (grid.len() / ONE_OF).clamp(LEAST.min(grid.len() / 4).max(1), MOST[0]);
        let few = by_relief(&grounded, wanted);
        let many: Vec<TileId> = grounded.iter().map(|(id, _)| *id).collect();
        let cells = |tiles: &[TileId]| -> f64 {
            let of_tile = |&id: &TileId| (grid.window(id).width as f64 - 1.0) * (grid.window(id).height as f64 - 1.0);
            tiles.iter().map(of_tile).sum()
        };
        // Tiles without ground were looked at, and have nothing.
        let whole = (job.field.width() as f64 - 1.0) * (job.field.height() as f64 - 1.0) / cells(&all);
        let times = [whole * (cells(&many) / cells(&few).max(1.0)), whole];
        let of_tiles = looked.iter().filter_map(|looked| looked.span).fold(0.0, f64::max);
        // Samples beside a line with heights are eased halfway to it, at the least.
        let of_lines = job.params.breaklines.as_ref().and_then(|lines| lines.height_range());
        let span = of_lines.map_or(of_tiles, |[low, high]| 2.0 * of_tiles + (high - low));
        let step = looked.iter().all(|looked| looked.are_whole).then_some(1.0);
        Ok(Sample { few, many, times, span, step })
    }
}

/// Does something with each of some tiles, in parallel; what comes of it is in their order.
pub(super) fn for_each<T: Send>(
    job: &Job<'_>,
    makers: &Pool<TileMaker>,
    tiles: &[TileId],
    work: impl Fn(&mut TileMaker, &Job<'_>, TileId) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let Job { control, grid, .. } = *job;
    let samples = tiles.iter().map(|&id| grid.window(id).len() as u64).sum();
    control.progress.begin(Stage::Survey, tiles.len() as u64, samples);
    let all = tiles.par_iter().map(|&id| {
        control.cancel.check()?;
        let done = makers.with(|maker| work(maker, job, id))?;
        control.progress.step(Stage::Survey, grid.window(id).len() as u64);
        Ok(done)
    });
    let all: Result<Vec<T>, Error> = all.collect();
    control.progress.end(Stage::Survey);
    all
}

/// So many tiles, at even shares of the relief of all: where it is large most triangles are.
fn by_relief(tiles: &[(TileId, f64)], wanted: usize) -> Vec<TileId> {
    let mut sorted = tiles.to_vec();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    let relief: f64 = sorted.iter().map(|(_, span)| span).sum();
    if relief == 0.0 {
        return spread(tiles.len(), wanted).map(|i| tiles[i].0).collect();
    }
    let mut found = Vec::new();
    let mut sum = 0.0;
    for (id, span) in sorted {
        sum += span;
        if sum > relief * ((2 * found.len() + 1) as f64 / (2 * wanted) as f64) {
            found.push(id);
        }
    }
    found
}

/// No more tiles than so many, spread evenly over a raster.
fn evenly(grid: TileGrid, most: usize) -> Vec<TileId> {
    let rows = (most * grid.rows() / grid.columns()).isqrt().clamp(1, grid.rows().min(most));
    let columns = (most / rows).clamp(1, grid.columns());
    spread(grid.rows(), rows)
        .flat_map(|row| spread(grid.columns(), columns).map(move |column| TileId { column, row }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rough_tiles_are_tried() {
        let tile = |column, span| (TileId { column, row: 0 }, span);
        let tiles = [tile(0, 0.0), tile(1, 1.0), tile(2, 40.0), tile(3, 2.0), tile(4, 60.0), tile(5, 0.0)];
        let columns = |wanted| by_relief(&tiles, wanted).iter().map(|id| id.column).collect::<Vec<_>>();
        assert_eq!([columns(1), columns(2)], [vec![4], vec![2, 4]]);
        let flat = [tile(0, 0.0), tile(1, 0.0), tile(2, 0.0)];
        assert_eq!(by_relief(&flat, 1), [flat[1].0]);
    }

    #[test]
    fn tiles_are_spread() {
        let of = |width, height, most| evenly(TileGrid::new(width, height, 10), most).len();
        assert_eq!(
            [of(101, 101, 1), of(101, 101, 100), of(101, 101, 12), of(1001, 11, 12), of(11, 1001, 12)],
            [1, 100, 12, 12, 12]
        );
    }
}
