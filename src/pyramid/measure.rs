//! How far the surface of a tile, as decoded, is from the samples of the finest grid, along the normal of the ellipsoid.
//!
//! **Which triangle a sample is judged by.** The normal at a sample's place meets a triangle of the surface where it passes
//! its three edges on the inner side: the sign of ((A − S) × (B − S)) · N for each edge AB, S the place on the ellipsoid and
//! N the normal. Two triangles that share an edge compute it with opposite signs, bit for bit, so that no sample falls between
//! them; one that is within 10⁻⁷ m of an edge is judged by both. Edges are chords, and those along a tile's border lie beside the parallel that it is: a sample between chord and
//! border is judged by the plane of the triangle at that chord.
//!
//! **Why none is left out.** [`Surface::is_closed`] makes sure that every edge of a tile is one of two triangles, once in each direction, or lies
//! on the border, and that triangles cover the tile's square as often as once. Brought to the ellipsoid along the normals, they are
//! a continuous image of the square. So a place that is not on the image of an edge is met by triangles that face up and by such that do not, and the former are more by
//! the number of times that the image of the border goes around it: by one inside of the chords, by none beyond them. Inside, then,
//! there is a triangle that faces up; where samples may be in a triangle is known ([`super::facet`]), and all of these are looked at.
//!
//! **How exactly.** Points in space are near 6.4·10⁶ m, where doubles are 10⁻⁹ m apart; they are taken relative to the tile's
//! centre, after sums of three products and a square root each. So every coordinate of A − S is off by less than 4·10⁻⁹ m,
//! and the height n·(A − S) ÷ n·N by less than 10⁻⁸ m × |n| ÷ n·N, which is the secant of the triangle's slope.
//! That is added to each error before it is compared with the tolerance: what passes keeps it.
//!
//! **How fast.** Of most samples it is enough to know that no triangle which may have them is off by more than the tolerance, or
//! by more than the largest error found so far. A few operations tell, with a margin for their rounding; the others, few, are judged
//! as above. So what is reported is the same as if all were.

use rustc_hash::FxHashMap;

use super::Body;
use super::body::{Angle, Vector, minus};
use super::error::{BoundBy, PyramidError};
use super::facet::{self, Facet, Row};
use super::grid::Grid;
use super::lines::Vertex;
use super::outline::SQUARE;
use super::own::{self, OwnWindow, OwnWindows, Placed};
use super::quantize::snap;
use super::rough::Rough;
use super::samples::{Block, Patch, Samples};
use super::surface::{Corner, Surface, SurfaceVertex};
use crate::base::control::CancelToken;

/// Samples that are read at a time, across and down.
pub(super) const WINDOW: i64 = 256;

/// Cells of a tile for each of its triangles from which on outlines of blocks are looked at before samples are.
const SPARSE: usize = 2048;

/// What a triangle takes while its tile is measured: its facet, where samples are looked for, its corners, what was known of it and what
/// is found, lists of triangles that are near; itself and half a vertex in its part, and in the surface. What is known afterwards takes no
/// more than the facet does.
pub(super) const BYTES_PER_TRIANGLE: u64 = {
    let lists = size_of::<[(f64, f64); 2]>() + size_of::<[Corner; 3]>() + size_of::<Option<Errors>>() + 5 * 8 + 2;
    let meshes = 2 * size_of::<[u32; 3]>() + 4 + (size_of::<Vertex>() + size_of::<SurfaceVertex>()) / 2;
    (size_of::<Facet>() + lists + meshes) as u64
};

/// What a tile's errors are like.
#[derive(Debug, Clone, Default)]
pub(super) struct Measured {
    /// Samples of the raster.
    pub(super) samples: u64,
    /// The largest error; where none fails, exactly.
    pub(super) max_error: f64,
    /// The farthest sample of every triangle that has one beyond the tolerance, as near to it as vertices can stand, and the
    /// part that the triangle is of.
    pub(super) failing: Vec<(u32, Vertex)>,
    /// The largest error of those, and where a vertex can stand for its sample.
    pub(super) worst: Option<(f64, Vertex)>,
    /// Of the samples of the raster itself among those.
    pub(super) own: Option<OwnFailure>,
}

/// Samples of the raster itself that are beyond the tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OwnFailure {
    /// Triangles whose farthest sample is one.
    pub(super) count: usize,
    /// The largest error.
    pub(super) error: f64,
    /// Its longitude and latitude, in degrees.
    pub(super) at: (f64, f64),
}

/// What is known of the triangles of a tile that has been measured, until it is mended and measured again.
#[derive(Default)]
pub(super) struct Known {
    samples: u64,
    triangles: FxHashMap<[Corner; 3], Errors>,
    own: OwnWindows,
}

/// What is known of the errors of a triangle.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    /// The largest that was found.
    found: f64,
    /// None is larger.
    bound: f64,
}

/// Measures a tile at all samples of the raster.
pub(super) struct Meter<'a> {
    pub(super) body: &'a Body,
    pub(super) samples: &'a Samples,
    pub(super) cancel: &'a CancelToken,
}

impl Meter<'_> {
    /// Measures a tile; triangles that were within the tolerance the last time are not measured anew.
    pub(super) fn measure(
        &self,
        surface: &Surface,
        tolerance: f64,
        known: &mut Known,
        block: &mut Block,
    ) -> Result<Measured, PyramidError> {
        if !surface.is_closed() {
            let (tile, bound_by) = (surface.tile, BoundBy::default());
            return Err(PyramidError::Unreachable { tile, max_error: tolerance, bound_by, worst: None });
        }
        let grid = self.samples.grid;
        let columns = surface.columns(grid);
        let facets: Vec<Facet> =
            surface.triangles.iter().map(|&t| Facet::new(surface, t, self.body, columns)).collect();
        let keys: Vec<[Corner; 3]> = surface.triangles.iter().map(|&t| surface.corners(t)).collect();
        let is_first = known.triangles.is_empty();
        let mut triangles = std::mem::take(&mut known.triangles);
        let before: Vec<Option<Errors>> = keys.iter().map(|key| triangles.remove(key)).collect();
        drop(triangles);
        let worst: Vec<f64> = before.iter().map(|errors| errors.map_or(0.0, |errors| errors.found)).collect();
        let most = worst.iter().copied().fold(0.0, f64::max);
        let mut tally = Tally { tolerance, largest: most, worst, beyond: FxHashMap::default() };
        let is_new: Vec<bool> = before.iter().map(Option::is_none).collect();
        let samples = self.pass(surface, &facets, &is_new, &mut tally, (block, &mut known.own))?;
        if is_first {
            known.samples = samples;
        }
        let bounds: Vec<f64> = (0..facets.len()).map(|i| before[i].map_or(tally.limit(i), |e| e.bound)).collect();
        let failing: Vec<usize> = (0..facets.len()).filter(|&i| tally.worst[i] > tolerance).collect();
        if failing.is_empty() {
            // Those of which it is not known whether they have the largest error.
            let is_open: Vec<bool> = bounds.iter().map(|&bound| bound > tally.largest).collect();
            if is_open.contains(&true) {
                self.pass(surface, &facets, &is_open, &mut tally, (block, &mut known.own))?;
            }
        }
        drop(facets);
        // Where none fails, nobody goes on from here.
        let keys = if failing.is_empty() { Vec::new() } else { keys };
        known.triangles = keys
            .into_iter()
            .zip(bounds)
            .zip(&tally.worst)
            .filter(|(_, worst)| **worst <= tolerance)
            .map(|((key, bound), &found)| (key, Errors { found, bound }))
            .collect();
        let of_own = failing.iter().filter_map(|i| tally.beyond[i].own.map(|at| (tally.worst[*i], at)));
        let own = largest(of_own.clone());
        let worst = largest(failing.iter().map(|i| (tally.worst[*i], tally.beyond[i].vertex)));
        let own = own.map(|(error, at)| OwnFailure { count: of_own.count(), error, at });
        let failing = failing.into_iter().map(|i| (surface.owners[i], tally.beyond[&i].vertex)).collect();
        Ok(Measured { samples: known.samples, max_error: tally.largest, failing, worst, own })
    }

    /// Looks at all samples of some facets; counts the samples of the windows that it reads.
    fn pass(
        &self,
        surface: &Surface,
        facets: &[Facet],
        is_wanted: &[bool],
        tally: &mut Tally,
        (block, own_windows): (&mut Block, &mut OwnWindows),
    ) -> Result<u64, PyramidError> {
        let grid = self.samples.grid;
        let cells = grid.cells(surface.tile.level);
        let origin = surface.tile.origin(grid);
        let bounds: Vec<[(f64, f64); 2]> = facets.iter().map(Facet::bounds).collect();
        let wanted: Vec<usize> = (0..facets.len()).filter(|&i| is_wanted[i]).collect();
        let mut samples = 0;
        let is_sparse = (cells * cells) as usize / facets.len().max(1) >= SPARSE;
        for ((left, top), (width, height)) in self.samples.windows(origin, cells, WINDOW) {
            self.cancel.check()?;
            let patch = Patch { column: origin.0 + left, row: origin.1 + top, width, height, step: 1 };
            let meets = |(low, high): (f64, f64), first: i64, count: usize| {
                // The raster's own samples may be up to a cell farther.
                high >= first as f64 && low <= (first + count as i64) as f64
            };
            let is_near = |i: &usize| meets(bounds[*i][0], left, width) && meets(bounds[*i][1], top, height);
            let looked_at: Vec<usize> = wanted.iter().copied().filter(is_near).collect();
            if looked_at.is_empty() || !self.samples.has_any(patch) {
                continue;
            }
            let rough = is_sparse.then(|| Rough::of(self.body, self.samples, patch)).transpose()?.flatten();
            let is_open = |&facet: &usize| {
                rough.as_ref().is_none_or(|rough| rough.has_any(&facets[facet], (left, top), tally.limit(facet)))
            };
            let is_read = looked_at.iter().any(is_open);
            samples += rough.as_ref().map_or(0, |rough| rough.samples);
            if !is_read && self.samples.own.is_none() {
                continue;
            }
            let near: Vec<usize> = (0..facets.len()).filter(is_near).collect();
            let window = Window { at: (left, top), size: (width, height), snap: snap(cells), facets, near: &near };
            if is_read {
                self.samples.read(patch, block)?;
                if rough.is_none() {
                    samples += block.inside.iter().filter(|&&inside| inside).count() as u64;
                }
                let places = Places::new(self.body, grid, patch, surface.centre);
                for &facet in &looked_at {
                    window.measure(facet, bounds[facet][1], &places, (block, rough.as_ref()), tally);
                }
            }
            if let Some(own) = &self.samples.own {
                let of = (*self.body, surface.centre);
                let read = || OwnWindow::read(own, of, (origin, cells), (left, top), (width, height));
                let own = own_windows.window((left, top), read)?;
                for &facet in &looked_at {
                    own.each_near(&facets[facet], |sample| window.judge_own(facet, &own, sample, tally));
                }
            }
        }
        Ok(samples)
    }
}

/// The first of the largest.
fn largest<T>(errors: impl Iterator<Item = (f64, T)>) -> Option<(f64, T)> {
    errors.reduce(|a, b| if b.0 > a.0 { b } else { a })
}

/// What has been found so far.
struct Tally {
    tolerance: f64,
    /// The largest error of all facets.
    largest: f64,
    /// The largest error of every facet.
    worst: Vec<f64>,
    /// The worst sample of every facet that has one beyond the tolerance.
    beyond: FxHashMap<usize, Beyond>,
}

struct Beyond {
    /// Where a vertex can stand for it.
    vertex: Vertex,
    /// Where it is, in degrees, if it is one of the raster itself.
    own: Option<(f64, f64)>,
}

impl Tally {
    /// From which error on a facet's samples count: up to there they are neither its worst, nor beyond the tolerance, nor the worst of all.
    fn limit(&self, facet: usize) -> f64 {
        self.worst[facet].max(self.tolerance.min(self.largest))
    }

    /// Takes the worst sample of a facet so far.
    fn take(&mut self, facet: usize, error: f64, sample: impl FnOnce() -> Beyond) {
        self.worst[facet] = error;
        self.largest = self.largest.max(error);
        if error > self.tolerance {
            self.beyond.insert(facet, sample());
        }
    }
}

/// Where the samples of a window are.
pub(super) struct Places<'a> {
    body: &'a Body,
    centre: Vector,
    lons: Vec<Angle>,
    lats: Vec<Angle>,
    cos: Vec<f64>,
    sin: Vec<f64>,
    pub(super) rows: Vec<Row>,
}

impl Places<'_> {
    pub(super) fn new(body: &Body, grid: Grid, patch: Patch, centre: Vector) -> Places<'_> {
        let Patch { column, row, width, height, .. } = patch;
        let lons: Vec<Angle> = (0..width).map(|c| Angle::of(grid.longitude(column + c as i64))).collect();
        let lats: Vec<Angle> = (0..height).map(|r| Angle::of(grid.latitude(row + r as i64))).collect();
        let (cos, sin) = lons.iter().map(|lon| (lon.cos, lon.sin)).unzip();
        let greenwich = Angle { sin: 0.0, cos: 1.0 };
        let row = |&lat: &Angle| {
            let [from_axis, _, from_equator] = body.point(greenwich, lat, 0.0);
            Row { sin: lat.sin, cos: lat.cos, from_axis, from_equator }
        };
        let rows = lats.iter().map(row).collect();
        Places { body, centre, lons, lats, cos, sin, rows }
    }

    /// Cosine and sine of the longitude of a column.
    pub(super) fn meridian(&self, column: usize) -> (f64, f64) {
        (self.cos[column], self.sin[column])
    }

    /// The place on the ellipsoid, from the tile's centre, and the normal there.
    pub(super) fn at(&self, column: usize, row: usize) -> (Vector, Vector) {
        let (lon, lat) = (self.lons[column], self.lats[row]);
        (minus(self.body.point(lon, lat, 0.0), self.centre), Body::normal(lon, lat))
    }
}

/// A window of a tile that is being measured.
struct Window<'a> {
    /// Its first sample in the tile.
    at: (i64, i64),
    size: (usize, usize),
    snap: i64,
    facets: &'a [Facet],
    /// Those that may have samples of the window.
    near: &'a [usize],
}

impl Window<'_> {
    /// Looks at all samples of a facet.
    fn measure(
        &self,
        number: usize,
        rows: (f64, f64),
        places: &Places,
        (block, rough): (&Block, Option<&Rough>),
        tally: &mut Tally,
    ) {
        let (left, top) = (self.at.0 as f64, self.at.1 as f64);
        let (width, height) = self.size;
        let facet = &self.facets[number];
        let sides = facet.sides_of();
        let mut open = (usize::MAX, 0..width);
        for r in clipped(rows.0 - top, rows.1 - top, height) {
            if let Some(rough) = rough.filter(|_| open.0 != r / SQUARE) {
                open = (r / SQUARE, rough.columns(facet, self.at, r, tally.limit(number)));
            }
            if open.1.is_empty() {
                continue;
            }
            let Some((low, high)) = sides.columns(top + r as f64, &places.rows[r]) else { continue };
            let columns = clipped(low - left, high - left, width);
            let columns = columns.start.max(open.1.start)..columns.end.min(open.1.end);
            if columns.is_empty() {
                continue;
            }
            let heights = &block.heights[r * width..][columns.clone()];
            let angles = (&places.cos[columns.clone()], &places.sin[columns.clone()]);
            let limit = tally.limit(number);
            let peek = |i: usize| self.error(number, (columns.start + i, r), places, block).unwrap_or(0.0);
            facet.each_suspicious(&places.rows[r], angles, heights, limit, peek, |i| {
                self.judge(number, (columns.start + i, r), places, block, tally);
                tally.limit(number)
            });
        }
    }

    /// The error at a sample, if it is one of the raster and of the facet.
    fn error(&self, number: usize, (c, r): (usize, usize), places: &Places, block: &Block) -> Option<f64> {
        let facet = &self.facets[number];
        let i = r * self.size.0 + c;
        let (place, normal) = places.at(c, r);
        let at = ((self.at.0 + c as i64) as f64, (self.at.1 + r as i64) as f64);
        let is_its = block.inside[i] && self.is_judged(facet, (place, normal), at);
        is_its.then(|| facet.error(place, normal, block.heights[i], facet::DOUBT))
    }

    /// Judges a sample, if it is one of the raster and of the facet.
    fn judge(&self, number: usize, (c, r): (usize, usize), places: &Places, block: &Block, tally: &mut Tally) {
        if let Some(error) = self.error(number, (c, r), places, block).filter(|e| *e > tally.worst[number]) {
            tally.take(number, error, || Beyond { vertex: self.vertex((c, r), block), own: None });
        }
    }

    /// Whether a sample is one of the facet, given its place, the normal there, and its column and row in the tile.
    fn is_judged(&self, facet: &Facet, (place, normal): (Vector, Vector), at: (f64, f64)) -> bool {
        let has = |facet: &Facet| facet.has(place, normal);
        has(facet) || facet.is_passed(place, normal, at) && !self.near.iter().any(|&other| has(&self.facets[other]))
    }

    /// Judges a sample of the raster itself, if it is of the facet.
    fn judge_own(&self, number: usize, own: &OwnWindow, sample: &Placed, tally: &mut Tally) {
        let facet = &self.facets[number];
        let (place, normal) = own.place(sample);
        let error = facet.error(place, normal, sample.height(), own::DOUBT);
        if error > tally.limit(number) && self.is_judged(facet, (place, normal), sample.at()) {
            tally.take(number, error, || Beyond { vertex: own.vertex(sample), own: Some(sample.degrees()) });
        }
    }

    /// Where a vertex can stand for a sample: windows begin at multiples of the snap. Where that is beyond the raster, it
    /// takes the height of the sample.
    fn vertex(&self, (c, r): (usize, usize), block: &Block) -> Vertex {
        let snap = self.snap as usize;
        let (to_c, to_r) = (c / snap * snap, r / snap * snap);
        let snapped = to_r * self.size.0 + to_c;
        let height = block.heights[if block.inside[snapped] { snapped } else { r * self.size.0 + c }];
        Vertex::of_sample(self.at.0 + to_c as i64, self.at.1 + to_r as i64, height)
    }
}

/// The whole numbers between two, from 0 to below `count`.
pub(super) fn clipped(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    let first = low.ceil().clamp(0.0, count as f64) as usize;
    let end = (high.floor() + 1.0).clamp(0.0, count as f64) as usize;
    first..end.max(first)
}
