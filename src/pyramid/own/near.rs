//! The raster's own samples under the triangles of a tile.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::ROUNDING;
use super::store::{OwnSample, OwnStore, Rectangle};
use crate::pyramid::Body;
use crate::pyramid::body::{Angle, Vector, minus};
use crate::pyramid::error::PyramidError;
use crate::pyramid::facet::Facet;
use crate::pyramid::lines::Vertex;
use crate::pyramid::quantize::{SPAN, snap};

/// What is added to an error at a sample of the raster's own for rounding, in metres on level ground: its place is rounded as well, and
/// whoever verifies adds a bound of their own.
pub(in crate::pyramid) const DOUBT: f64 = 4e-8;

/// Samples that are kept from one round of mending to the next: 12 MiB of them.
const MOST_KEPT: usize = 1 << 17;

/// The first windows of a tile that is measured more than once.
#[derive(Default)]
pub(in crate::pyramid) struct OwnWindows {
    by_corner: HashMap<(i64, i64), Rc<OwnWindow>>,
    samples: usize,
}

impl OwnWindows {
    /// That with a corner, which is read unless it is kept.
    pub(in crate::pyramid) fn window(
        &mut self,
        corner: (i64, i64),
        read: impl FnOnce() -> Result<OwnWindow, PyramidError>,
    ) -> Result<Rc<OwnWindow>, PyramidError> {
        if let Some(window) = self.by_corner.get(&corner) {
            return Ok(window.clone());
        }
        let window = Rc::new(read()?);
        if self.samples + window.samples.len() <= MOST_KEPT {
            self.samples += window.samples.len();
            self.by_corner.insert(corner, window.clone());
        }
        Ok(window)
    }
}

/// The samples in a window of a tile.
pub(in crate::pyramid) struct OwnWindow {
    body: Body,
    centre: Vector,
    /// Cells along the tile's side.
    cells: i64,
    /// The window's first row of cells.
    top: i64,
    /// By rows of cells, from the west.
    samples: Vec<Placed>,
    /// Where each row begins, and where the last ends.
    rows: Vec<usize>,
}

/// A sample; columns and rows count from the tile's corner.
pub(in crate::pyramid) struct Placed {
    sample: OwnSample,
    /// The place on the ellipsoid, from the tile's centre, and the normal there.
    place: OnceCell<(Vector, Vector)>,
}

impl Placed {
    /// Its column and row.
    pub(in crate::pyramid) fn at(&self) -> (f64, f64) {
        (self.sample.column, self.sample.row)
    }

    pub(in crate::pyramid) fn height(&self) -> f64 {
        self.sample.height
    }

    /// Longitude and latitude, in degrees.
    pub(in crate::pyramid) fn degrees(&self) -> (f64, f64) {
        (self.sample.lon, self.sample.lat)
    }
}

impl OwnWindow {
    /// The samples of a window, whose first cell of a tile and whose size are given. One on the tile's border is of the outermost cells.
    pub(in crate::pyramid) fn read(
        own: &OwnStore,
        (body, centre): (Body, Vector),
        (origin, cells): ((i64, i64), i64),
        (left, top): (i64, i64),
        (width, height): (usize, usize),
    ) -> Result<OwnWindow, PyramidError> {
        let ends = |origin: i64, first: i64, count: usize| {
            ((origin + first) as f64 - ROUNDING, (origin + first + count as i64) as f64 + ROUNDING)
        };
        let columns = ends(origin.0, left, width);
        let mut found = Vec::new();
        own.read(Rectangle { columns, rows: ends(origin.1, top, height) }, &mut found)?;
        let cell = |at: f64| (at.floor() as i64).clamp(0, cells);
        let mut samples: Vec<Placed> = Vec::with_capacity(found.len());
        for mut sample in found {
            sample.column -= origin.0 as f64;
            sample.row -= origin.1 as f64;
            let is_in = |at: f64, first: i64, count: usize| (first..first + count as i64).contains(&cell(at));
            let is_of_tile = |at: f64| (-ROUNDING..=cells as f64 + ROUNDING).contains(&at);
            let (column, row) = (sample.column, sample.row);
            if is_of_tile(column) && is_of_tile(row) && is_in(column, left, width) && is_in(row, top, height) {
                samples.push(Placed { sample, place: OnceCell::new() });
            }
        }
        let key = |placed: &Placed| (cell(placed.sample.row), placed.sample.column);
        samples.sort_by(|a, b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)));
        let row = |r: usize| samples.partition_point(|placed| key(placed).0 < top + r as i64);
        let rows = (0..=height).map(row).collect();
        Ok(OwnWindow { body, centre, cells, top, samples, rows })
    }

    /// Calls `look` with the samples that a triangle may have.
    pub(in crate::pyramid) fn each_near(&self, facet: &Facet, mut look: impl FnMut(&Placed)) {
        let [_, (first, last)] = facet.bounds();
        let count = self.rows.len() as i64 - 1;
        let local = |row: f64| ((row.floor() as i64).saturating_sub(self.top)).clamp(-1, count);
        for r in local(first).max(0)..(local(last) + 1).min(count) {
            let row = (self.top + r) as f64;
            let of_row = &self.samples[self.rows[r as usize]..self.rows[r as usize + 1]];
            // Those at the border may be just beyond it.
            let Some((low, high)) = facet.columns_between(row - ROUNDING, row + 1.0 + ROUNDING) else { continue };
            let start = of_row.partition_point(|placed| placed.sample.column < low);
            of_row[start..].iter().take_while(|placed| placed.sample.column <= high).for_each(&mut look);
        }
    }

    /// The place of a sample on the ellipsoid, from the tile's centre, and the normal there.
    pub(in crate::pyramid) fn place(&self, placed: &Placed) -> (Vector, Vector) {
        *placed.place.get_or_init(|| {
            let (lon, lat) = (Angle::of(placed.sample.lon), Angle::of(placed.sample.lat));
            (minus(self.body.point(lon, lat, 0.0), self.centre), Body::normal(lon, lat))
        })
    }

    /// The vertex that stands for a sample: at the nearest place of the lattice.
    pub(in crate::pyramid) fn vertex(&self, placed: &Placed) -> Vertex {
        let (column, row) = placed.at();
        let nearest = |at: f64| ((at * SPAN as f64 / self.cells as f64).round() as i64).clamp(0, SPAN);
        let snap = snap(self.cells);
        let sample = |at: f64| ((at / snap as f64).round() as i64 * snap).clamp(0, self.cells);
        let place = Some((nearest(column), SPAN - nearest(row)));
        Vertex { column: sample(column), row: sample(row), height: placed.sample.height, place }
    }
}
