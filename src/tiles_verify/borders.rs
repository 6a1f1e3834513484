//! Where tiles meet: within a level they share every vertex, between levels gaps are bounded.
//!
//! A gap is the difference of two borders' heights over a place of the line that they share. Both are chords in space, and lie
//! beside the line where that is a parallel: heights are those of their points at the place's longitude. Between vertices of
//! either the difference is almost linear, so it is looked for at the vertices of both.

use std::collections::BTreeMap;

use super::decode::{Decoded, LAST};
use super::ellipsoid::{Ellipsoid, Point, across, less, times};
use super::findings::{Findings, Kind};
use super::tile::Tile;
use crate::pyramid::{Grid, Level, Patch, PyramidError, SampleBlock, Samples, TileKey};

/// A vertex of a border: its coordinate along the side, its height, and its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stop {
    along: u16,
    height: f64,
    normal: Option<[u8; 2]>,
}

/// West, south, east, north.
pub(super) struct Sides([Vec<Stop>; 4]);

impl Sides {
    pub(super) fn of(decoded: &Decoded) -> Sides {
        Sides(std::array::from_fn(|side| {
            let stop = |&i: &u32| Stop {
                along: decoded.vertices[i as usize][usize::from(side % 2 == 0)],
                height: decoded.height(i as usize),
                normal: decoded.normals.as_ref().map(|normals| normals[i as usize]),
            };
            let mut stops: Vec<Stop> = decoded.sides[side].iter().map(stop).collect();
            stops.sort_by_key(|stop| stop.along);
            stops
        }))
    }
}

/// To the west, south, east, north.
const TOWARDS: [(i32, i32); 4] = [(-1, 0), (0, -1), (1, 0), (0, 1)];

/// The largest gap between the tiles of two levels that meet.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Gap {
    /// The coarser level.
    pub coarser: u32,
    /// The finer level.
    pub finer: u32,
    /// The largest gap, in metres, where the raster has heights.
    pub largest: f64,
    /// What it may be.
    pub allowed: f64,
    /// The largest where the raster has none.
    pub outside: f64,
}

/// All borders.
pub(super) struct Borders<'a> {
    pub(super) grid: Grid,
    pub(super) ellipsoid: &'a Ellipsoid,
    pub(super) samples: &'a Samples,
    pub(super) levels: &'a [Level],
    pub(super) sides: BTreeMap<TileKey, Sides>,
    /// The coarsest step of heights, level by level.
    pub(super) steps: Vec<f64>,
    /// Whether the raster's own samples bind borders, too.
    pub(super) own_samples: bool,
}

impl Borders<'_> {
    /// Finds tiles of a level that do not share their border vertices.
    pub(super) fn judge_levels(&self, findings: &mut Findings) {
        for (&key, sides) in &self.sides {
            for side in [2, 3] {
                let (east, north) = TOWARDS[side];
                let Some((other, theirs)) = key.neighbour(east, north).and_then(|k| self.sides.get_key_value(&k))
                else {
                    continue;
                };
                if sides.0[side] != theirs.0[side - 2] {
                    findings
                        .add(Kind::Borders, || format!("tiles {key} and {other} do not have the same border vertices"));
                }
            }
        }
    }

    /// Finds the largest gaps of each pair of levels.
    pub(super) fn judge_gaps(&self, findings: &mut Findings) -> Result<Vec<Gap>, PyramidError> {
        let mut gaps: BTreeMap<(u32, u32), (f64, f64)> = BTreeMap::new();
        let mut block = SampleBlock::default();
        for &key in self.sides.keys() {
            for coarser in 0..key.level {
                for side in 0..4 {
                    let Some(found) = self.gap(key, coarser, side, &mut block)? else { continue };
                    let largest = gaps.entry((coarser, key.level)).or_default();
                    *largest = (largest.0.max(found.0), largest.1.max(found.1));
                }
            }
        }
        let gap = |((coarser, finer), (largest, outside)): ((u32, u32), (f64, f64))| {
            let of = |level: u32| self.levels[level as usize].max_error;
            let steps = 0.5 * (self.steps[coarser as usize] + self.steps[finer as usize]);
            let hidden = 5.0 * self.ellipsoid.client_error(coarser);
            // Between samples of the grid the raster's own bind one border where they may not bind the other.
            let bound = if self.own_samples { hidden } else { of(coarser).max(of(finer)) + steps };
            let allowed = bound.min(hidden);
            if largest > allowed {
                findings.add(Kind::Gaps, || {
                    format!(
                        "between tiles of levels {coarser} and {finer} is a gap of {largest} m, allowed are {allowed}"
                    )
                });
            }
            Gap { coarser, finer, largest, allowed, outside }
        };
        Ok(gaps.into_iter().map(gap).collect())
    }

    /// The largest gap between a side of a tile and the tile of a coarser level beyond it, inside of the raster and outside;
    /// none where there is no such tile.
    fn gap(
        &self,
        key: TileKey,
        coarser: u32,
        side: usize,
        block: &mut SampleBlock,
    ) -> Result<Option<(f64, f64)>, PyramidError> {
        let up = key.level - coarser;
        let (east, north) = TOWARDS[side];
        let Some(beyond) = key.neighbour(east, north) else { return Ok(None) };
        let ancestor = |k: TileKey| TileKey { level: coarser, x: k.x >> up, y: k.y >> up };
        let other = ancestor(beyond);
        // Inside of one tile of the coarser level no two meet.
        if other == ancestor(key) {
            return Ok(None);
        }
        let Some(theirs) = self.sides.get(&other) else { return Ok(None) };
        let ours = &self.sides[&key];
        let is_meridian = side.is_multiple_of(2);
        let (ours, theirs) = (&ours.0[side], &theirs.0[(side + 2) % 4]);
        let line = Line { borders: self, is_meridian, finer: key, side, coarser: other };
        let mut found = (0.0f64, 0.0f64);
        let (first, last) = (line.along_finer(0), line.along_finer(LAST));
        let places =
            ours.iter().map(|s| line.along_finer(s.along)).chain(theirs.iter().map(|s| line.along_coarser(s.along)));
        for at in places.filter(|at| (first..=last).contains(at)) {
            let gap = match (line.height(ours, at, true), line.height(theirs, at, false)) {
                (Some(a), Some(b)) => (a - b).abs(),
                _ => f64::INFINITY,
            };
            match line.is_inside(at, block)? {
                true => found.0 = found.0.max(gap),
                false => found.1 = found.1.max(gap),
            }
        }
        Ok(Some(found))
    }
}

/// A line that tiles of two levels share.
struct Line<'a> {
    borders: &'a Borders<'a>,
    is_meridian: bool,
    finer: TileKey,
    side: usize,
    coarser: TileKey,
}

impl Line<'_> {
    fn along(&self, key: TileKey, along: u16) -> f64 {
        let side = 180.0 / 2f64.powi(key.level as i32);
        let (first, from) = if self.is_meridian { (key.y, -90.0) } else { (key.x, -180.0) };
        from + side * (f64::from(first) + f64::from(along) / f64::from(LAST))
    }

    /// Latitude or longitude of a place along a side, in degrees.
    fn along_finer(&self, along: u16) -> f64 {
        self.along(self.finer, along)
    }

    fn along_coarser(&self, along: u16) -> f64 {
        self.along(self.coarser, along)
    }

    /// The other coordinate.
    fn fixed(&self) -> f64 {
        let side = 180.0 / 2f64.powi(self.finer.level as i32);
        let beyond = u32::from(self.side >= 2);
        match self.is_meridian {
            true => f64::from(self.finer.x + beyond) * side - 180.0,
            false => f64::from(self.finer.y + beyond) * side - 90.0,
        }
    }

    fn place(&self, at: f64) -> (f64, f64) {
        if self.is_meridian { (self.fixed(), at) } else { (at, self.fixed()) }
    }

    /// The height of a border over a place of the line.
    fn height(&self, stops: &[Stop], at: f64, is_finer: bool) -> Option<f64> {
        let key = if is_finer { self.finer } else { self.coarser };
        let places: Vec<f64> = stops.iter().map(|s| self.along(key, s.along)).collect();
        let after = places.iter().position(|place| *place >= at)?;
        if places[after] == at {
            return Some(stops[after].height);
        }
        let before = after.checked_sub(1)?;
        let point = |i: usize| -> Point {
            let (lon, lat) = self.place(places[i]);
            self.borders.ellipsoid.point(lon, lat, stops[i].height)
        };
        let (a, b) = (point(before), point(after));
        let (lon, lat) = self.place(at);
        let (foot, normal) = self.borders.ellipsoid.foot(lon, lat);
        let (sin, cos) = lon.to_radians().sin_cos();
        // Where the chord passes the meridian plane of the place, or its normal in that plane.
        let east = [-sin, cos, 0.0];
        let share = match self.is_meridian {
            true => {
                let aside = across(normal, east);
                times(less(foot, a), aside) / times(less(b, a), aside)
            }
            false => times(a, east) / (times(a, east) - times(b, east)),
        };
        if !share.is_finite() {
            return None;
        }
        let point: Point = std::array::from_fn(|i| a[i] + share * (b[i] - a[i]));
        Some(self.borders.ellipsoid.geodetic(point).2)
    }

    /// Whether the raster has heights on both sides of a place.
    fn is_inside(&self, at: f64, block: &mut SampleBlock) -> Result<bool, PyramidError> {
        let (lon, lat) = self.place(at);
        let cell = self.borders.grid.cell();
        let (column, row) = ((lon + 180.0) / cell, (90.0 - lat) / cell);
        // Vertices stand less than half a cell from their sample.
        let (width, height) = if self.is_meridian { (1, 3) } else { (3, 1) };
        let patch = Patch {
            column: column.round() as i64 - i64::from(!self.is_meridian),
            row: row.round() as i64 - i64::from(self.is_meridian),
            width,
            height,
            step: 1,
        };
        self.borders.samples.read(patch, block)?;
        Ok(!block.inside.contains(&false))
    }
}

/// The step of a tile's heights.
pub(super) fn step(tile: &Tile<'_>) -> f64 {
    (tile.decoded.maximum - tile.decoded.minimum) / f64::from(LAST)
}
