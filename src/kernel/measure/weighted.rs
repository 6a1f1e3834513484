//! The weighted error of heights and channels together, measured.

use super::Bound;
use crate::base::Tile;
use crate::base::lattice::Point;
use crate::base::mesh::TileMesh;
use crate::base::tiling::TilePlace;
use crate::kernel::triangulate::feasible::{Spans, Surfaces};

/// The largest weighted error ([`ChannelError::weighted`](crate::base::channels::ChannelError::weighted)) over a set of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WeightedStats {
    /// The error.
    pub max: f64,
    /// Column and row of a sample that has it: the first, in the order of measuring.
    pub worst: (u64, u64),
}

impl WeightedStats {
    /// The one with the larger error; of equal ones the first.
    pub fn larger(first: Option<WeightedStats>, second: Option<WeightedStats>) -> Option<WeightedStats> {
        match (first, second) {
            (Some(a), Some(b)) => Some(if b.max > a.max { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// The same, once it is within what is known of errors.
    ///
    /// # Panics
    /// If it is not: an engine is broken.
    pub(super) fn within(self, bound: Bound) -> WeightedStats {
        let (WeightedStats { max, worst }, tolerance) = (self, bound.tolerance());
        assert!(max <= tolerance, "weighted error {max} at sample {worst:?}, {tolerance} is allowed");
        self
    }
}

/// Measures the triangles that are wanted of a tile at this place, over all of their samples, each triangle again. `None` where
/// there are no channels.
///
/// # Panics
/// If a weighted error is larger than the tolerance: an engine is broken, and its mesh must not be written. If a vertex of such a
/// triangle does not lie on a sample.
pub fn measure_weighted(
    tile: &Tile,
    mesh: &TileMesh,
    tolerance: f64,
    place: &TilePlace,
    wanted: impl Fn([Point; 3]) -> bool,
) -> Option<WeightedStats> {
    let columns = |spans: &Spans, row: i32| spans.columns(row);
    let found = over(tile, mesh, place.origin(), (tile.width, tile.height), wanted, columns);
    found.map(|found| found.within(Bound::Within(tolerance)))
}

/// Measures over the samples in the first `owned` columns and rows; where samples are missing, those on edges more than once.
pub(super) fn over_owned(
    tile: &Tile,
    mesh: &TileMesh,
    origin: (u64, u64),
    owned: (usize, usize),
) -> Option<WeightedStats> {
    let (right_rim, lower_rim) = (tile.width as i32 - 1, tile.height as i32 - 1);
    let is_whole = tile.validity.is_whole();
    over(
        tile,
        mesh,
        origin,
        owned,
        |_| true,
        |spans, row| {
            if is_whole { spans.own_columns(row, right_rim, lower_rim) } else { spans.columns(row) }
        },
    )
}

/// Measures over the samples in the first columns and rows that `columns` has of a triangle's rows.
fn over(
    tile: &Tile,
    mesh: &TileMesh,
    origin: (u64, u64),
    (width, height): (usize, usize),
    wanted: impl Fn([Point; 3]) -> bool,
    columns: impl Fn(&Spans, i32) -> (i32, i32),
) -> Option<WeightedStats> {
    let error = tile.channel_error.as_ref()?;
    let mut stats = WeightedStats { max: 0.0, worst: origin };
    let mut surfaces = Surfaces::default();
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle);
        if !wanted([a.at, b.at, c.at]) {
            continue;
        }
        surfaces.set(tile, [a, b, c]);
        let spans = Spans::new(a.at, b.at, c.at);
        for row in spans.rows().take_while(|&row| (row as usize) < height) {
            let (first, last) = columns(&spans, row);
            for column in first..=last.min(width as i32 - 1) {
                let weighted = surfaces.weighted(tile, error, (column as usize, row as usize));
                // Not a number counts as the largest.
                if weighted.is_nan() || weighted > stats.max {
                    stats = WeightedStats { max: weighted, worst: (origin.0 + column as u64, origin.1 + row as u64) };
                }
            }
        }
    }
    Some(stats)
}

#[cfg(test)]
mod tests {
    use super::super::{Bare, measure};
    use crate::base::channels::{ChannelError, Range, Ranges};
    use crate::base::lattice::Point;
    use crate::base::mesh::{TileMesh, Vertex};
    use crate::base::tiling::TilePlace;
    use crate::base::{Heights, Tile, Window};

    fn tile() -> Tile {
        let range = Range { min: 0.0, max: 10.0 };
        let ranges = Ranges { heights: range, channels: vec![range; 2], unit: 10.0 };
        let (mut red, mut green) = (vec![0.0; 25], (0..25).map(|i| f64::from(i % 5)).collect::<Vec<_>>());
        (red[12], green[12]) = (4.0, 0.0);
        Tile::from_heights(5, 5, Heights::F32(vec![0.0; 25]))
            .with_channels(vec![red, green], ChannelError::new(0.5, &ranges))
    }

    fn two_triangles() -> TileMesh {
        let vertex = |c, r| Vertex { at: Point::of_sample(c, r), height: 0.0 };
        TileMesh {
            vertices: vec![vertex(0, 0), vertex(4, 0), vertex(4, 4), vertex(0, 4)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            relaxed: 0,
        }
    }

    #[test]
    fn heights_and_channels_make_one_error() {
        let (tile, alone) = (tile(), TilePlace::alone(tile().width(), tile().height()));
        let far = TilePlace { window: Window { column: 100, row: 200, ..alone.window }, ..alone };
        let errors = measure(&tile, &two_triangles(), 1.5, &far, Bare::Nothing);
        assert_eq!(errors.max, 0.0);
        let weighted = errors.extended.expect("channels");
        // Half of (4 + 2)/2.
        assert!((weighted.max - 1.5).abs() < 1e-12 && weighted.worst == (102, 202), "{weighted:?}");
    }

    #[test]
    #[should_panic(expected = "weighted error 1.5")]
    fn an_engine_that_forgets_the_channels_is_found_out() {
        let alone = TilePlace::alone(tile().width(), tile().height());
        measure(&tile(), &two_triangles(), 1.25, &alone, Bare::Nothing);
    }
}
