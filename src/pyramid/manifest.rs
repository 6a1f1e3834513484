//! What stands beside the tiles: `layer.json` for clients, `terrabite.json` for whoever judges them.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::grid::{Grid, Level, TileKey};
use super::voids::VoidAs;

/// The file that clients read.
pub const LAYER: &str = "layer.json";
/// The file that says what was promised.
pub const PROMISE: &str = "terrabite.json";
/// What the latter's `schema` is.
pub(super) const SCHEMA: u32 = 1;

/// Tiles from one column and row to another, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Range {
    /// The first column.
    pub start_x: u32,
    /// The first row, from the south.
    pub start_y: u32,
    /// The last column.
    pub end_x: u32,
    /// The last row.
    pub end_y: u32,
}

/// What `layer.json` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// The version of TileJSON that it follows.
    pub tilejson: String,
    /// The raster's name.
    pub name: String,
    /// The version of the tiles.
    pub version: String,
    /// `quantized-mesh-1.0`.
    pub format: String,
    /// `tms`: rows count from the south.
    pub scheme: String,
    /// Addresses of tiles.
    pub tiles: Vec<String>,
    /// `EPSG:4326`: two tiles at level 0.
    pub projection: String,
    /// West, south, east and north of the tiles of the finest level, in degrees.
    pub bounds: [f64; 4],
    /// Extensions that tiles have.
    pub extensions: Vec<String>,
    /// 0.
    pub minzoom: u32,
    /// The finest level.
    pub maxzoom: u32,
    /// Which tiles there are, level by level.
    pub available: Vec<Vec<Range>>,
}

/// What was promised, and of what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Promise {
    /// The version of this form: 1.
    pub schema: u32,
    /// What has made the tiles.
    pub generator: String,
    /// The finest grid has 2 to the power of this cells from pole to pole.
    pub grid_exponent: u32,
    /// The half axes of the ellipsoid, in metres.
    pub semi_major: f64,
    /// See [`Promise::semi_major`].
    pub semi_minor: f64,
    /// The vertical CRS that heights were brought from; empty where they were taken as ellipsoidal.
    pub vertical_crs: String,
    /// The vertical CRS that was asked for, if not that of the raster.
    pub vertical_crs_given: Option<String>,
    /// The height outside of the raster, and where it has none.
    pub outside: f64,
    /// What tiles have where the raster has voids.
    #[serde(default, skip_serializing_if = "VoidAs::is_outside")]
    pub void_as: VoidAs,
    /// What was asked for at the finest level.
    pub max_error: f64,
    /// No level's error is above this times the client's.
    pub error_factor: f64,
    /// Whether files are compressed.
    pub gzip: bool,
    /// How the raster was looked at, by name: band, window, marks of missing samples, cutline.
    #[serde(default)]
    pub view: BTreeMap<String, String>,
    /// Whether every tile's least and greatest height are 4,095.875 m apart or more.
    #[serde(default)]
    pub fine_heights: bool,
    /// Whether the errors of levels hold at the raster's own samples, too.
    #[serde(default)]
    pub own_samples: bool,
    /// Between samples of the grid, edges are within this times the level's error of the heights around. Without it nothing is promised
    /// there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_stray: Option<f64>,
    /// The levels.
    pub levels: Vec<Level>,
}

/// Tiles of one level as rectangles that hold them and no others: runs of rows, joined where the next row has the same.
pub(super) fn ranges(tiles: &BTreeSet<(u32, u32)>) -> Vec<Range> {
    let mut done = Vec::new();
    let mut open: Vec<Range> = Vec::new();
    let rows: BTreeSet<u32> = tiles.iter().map(|t| t.1).collect();
    for row in rows {
        let mut runs: Vec<(u32, u32)> = Vec::new();
        for x in tiles.iter().filter(|t| t.1 == row).map(|t| t.0) {
            match runs.last_mut() {
                Some(run) if run.1 + 1 == x => run.1 = x,
                _ => runs.push((x, x)),
            }
        }
        let mut next = Vec::with_capacity(runs.len());
        for (start_x, end_x) in runs {
            let above = |r: &Range| (r.start_x, r.end_x, r.end_y + 1) == (start_x, end_x, row);
            let start_y = open.iter().find(|r| above(r)).map_or(row, |r| r.start_y);
            next.push(Range { start_x, start_y, end_x, end_y: row });
        }
        let goes_on =
            |r: &Range| next.iter().any(|n| (n.start_x, n.end_x, n.start_y) == (r.start_x, r.end_x, r.start_y));
        done.extend(open.iter().filter(|r| !goes_on(r)));
        open = next;
    }
    done.extend(open);
    done.sort_by_key(|r| (r.start_y, r.start_x));
    done
}

impl Layer {
    /// Of tiles, level by level.
    pub(super) fn of(name: &str, grid: Grid, levels: &[Vec<TileKey>]) -> Layer {
        let finest = levels.last().map_or(&[][..], Vec::as_slice);
        let side = finest.first().map_or(0.0, |tile| grid.cells(tile.level) as f64 * grid.cell());
        let corners = finest.iter().map(|tile| (f64::from(tile.x) * side - 180.0, f64::from(tile.y) * side - 90.0));
        let bounds = corners.fold([180.0f64, 90.0, -180.0, -90.0], |b, (west, south)| {
            [b[0].min(west), b[1].min(south), b[2].max(west + side), b[3].max(south + side)]
        });
        Layer {
            tilejson: "2.1.0".to_string(),
            name: name.to_string(),
            version: "1.0.0".to_string(),
            format: "quantized-mesh-1.0".to_string(),
            scheme: "tms".to_string(),
            tiles: vec!["{z}/{x}/{y}.terrain?v={version}".to_string()],
            projection: "EPSG:4326".to_string(),
            bounds,
            extensions: vec!["octvertexnormals".to_string()],
            minzoom: 0,
            maxzoom: levels.len().saturating_sub(1) as u32,
            available: levels.iter().map(|tiles| ranges(&tiles.iter().map(|t| (t.x, t.y)).collect())).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ranges_hold_what_is_there_and_nothing_else(tiles in prop::collection::btree_set((0u32..6, 0u32..6), 0..30)) {
            let mut found = BTreeSet::new();
            for r in ranges(&tiles) {
                for tile in (r.start_y..=r.end_y).flat_map(|y| (r.start_x..=r.end_x).map(move |x| (x, y))) {
                    prop_assert!(found.insert(tile), "{:?} twice", tile);
                }
            }
            prop_assert_eq!(found, tiles);
        }
    }

    #[test]
    fn a_rectangle_is_one_range() {
        let tiles = (2..5).flat_map(|x| (7..9).map(move |y| (x, y))).collect();
        assert_eq!(ranges(&tiles), [Range { start_x: 2, start_y: 7, end_x: 4, end_y: 8 }]);
    }
}
