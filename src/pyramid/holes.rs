//! Holes: triangles of a tile over voids, left out once the tile keeps its promise.
//!
//! A triangle has the samples that the normal at their places meets it at, and the samples that its corners stand for. It is *whole*
//! if none of them is in a void, and left out if one is, and whole triangles have every other. So what is left has all samples but
//! those of voids. Places of vertices are rounded to the lattice of the format: a sample that is less than a step of it beyond the edge of a whole
//! triangle counts as its own, provided that its plane is within the error there.
//!
//! Vertices of no triangle go, except those on the border of the tile: lists of border vertices are the same in both tiles that share it.

use super::error::PyramidError;
use super::facet::{DOUBT, Facet};
use super::grid::Grid;
use super::measure::{Meter, Places, WINDOW, clipped};
use super::quantize::SPAN;
use super::samples::{Block, Patch};
use super::surface::Surface;

/// What is known of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Whole,
    /// It has samples of voids, and so far none that no whole triangle has.
    Open,
    /// It has both.
    Kept,
}

/// A tile that holes are cut in.
struct Cutter<'a, 'b> {
    meter: &'a Meter<'b>,
    surface: &'a Surface,
    facets: Vec<Facet>,
    /// Columns and rows between which samples may be in each, a step of the lattice farther.
    bounds: Vec<[(f64, f64); 2]>,
    max_error: f64,
    /// A step of the lattice, in metres along a meridian, where it is largest.
    slack: f64,
}

/// Leaves out the triangles of a tile, within its error, that are over voids. One that has nothing else stays as it is.
pub(super) fn cut(
    meter: &Meter<'_>,
    max_error: f64,
    surface: &mut Surface,
    block: &mut Block,
) -> Result<(), PyramidError> {
    let states = Cutter::new(meter, surface, max_error).states(block)?;
    if states.contains(&State::Open) && states.iter().any(|state| *state != State::Open) {
        surface.keep(|triangle| states[triangle] != State::Open);
    }
    Ok(())
}

impl<'a, 'b> Cutter<'a, 'b> {
    fn new(meter: &'a Meter<'b>, surface: &'a Surface, max_error: f64) -> Cutter<'a, 'b> {
        let grid = meter.samples.grid;
        let columns = surface.columns(grid);
        let facet = |&t: &[u32; 3]| Facet::new(surface, t, meter.body, columns);
        let facets: Vec<Facet> = surface.triangles.iter().map(facet).collect();
        let step = grid.cells(surface.tile.level) as f64 / SPAN as f64;
        let wider = |(low, high): (f64, f64)| (low - step, high + step);
        let bounds = facets.iter().map(|facet| facet.bounds().map(wider)).collect();
        let slack = (step * grid.cell()).to_radians() * meter.body.semi_major;
        Cutter { meter, surface, facets, bounds, max_error, slack }
    }

    fn states(&self, block: &mut Block) -> Result<Vec<State>, PyramidError> {
        let mut states = vec![State::Whole; self.facets.len()];
        for (state, triangle) in states.iter_mut().zip(&self.surface.triangles) {
            for &vertex in triangle {
                if self.stands_in_void(vertex, block)? {
                    *state = State::Open;
                }
            }
        }
        self.each_window(block, |window, block| {
            if block.is_void.contains(&true) {
                for &facet in window.near.iter().filter(|&&i| states[i] == State::Whole).collect::<Vec<_>>() {
                    if window.samples(facet).any(|at| block.is_void[window.number(at)] && window.has(facet, at)) {
                        states[facet] = State::Open;
                    }
                }
            }
        })?;
        self.each_window(block, |window, block| {
            let mut is_done = block.is_void.clone();
            for &facet in &window.near {
                if states[facet] != State::Open {
                    continue;
                }
                for at in window.samples(facet) {
                    if !std::mem::replace(&mut is_done[window.number(at)], true) {
                        window.settle(at, block, &mut states);
                    }
                }
            }
        })?;
        Ok(states)
    }

    fn stands_in_void(&self, vertex: u32, block: &mut Block) -> Result<bool, PyramidError> {
        let (column, row) = self.surface.tile.origin(self.grid());
        let sample = self.surface.vertices[vertex as usize].sample;
        let patch = Patch { column: column + sample.0, row: row + sample.1, width: 1, height: 1, step: 1 };
        self.meter.samples.read(patch, block)?;
        Ok(block.is_void[0])
    }

    fn grid(&self) -> Grid {
        self.meter.samples.grid
    }

    /// Calls `look` with every window of the raster's samples, read into the block.
    fn each_window(&self, block: &mut Block, mut look: impl FnMut(&Window<'_>, &Block)) -> Result<(), PyramidError> {
        let origin = self.surface.tile.origin(self.grid());
        let cells = self.grid().cells(self.surface.tile.level);
        for (first, (width, height)) in self.meter.samples.windows(origin, cells, WINDOW) {
            self.meter.cancel.check()?;
            let patch = Patch { column: origin.0 + first.0, row: origin.1 + first.1, width, height, step: 1 };
            self.meter.samples.read(patch, block)?;
            let places = Places::new(self.meter.body, self.grid(), patch, self.surface.centre);
            let meets = |(low, high): (f64, f64), first: i64, count: usize| {
                high >= first as f64 && low <= (first + count as i64 - 1) as f64
            };
            let is_near =
                |i: &usize| meets(self.bounds[*i][0], first.0, width) && meets(self.bounds[*i][1], first.1, height);
            let near = (0..self.facets.len()).filter(is_near).collect();
            look(&Window { cutter: self, first, size: (width, height), places, near }, block);
        }
        Ok(())
    }
}

/// Column and row of a sample in a window.
type At = (usize, usize);

struct Window<'a> {
    cutter: &'a Cutter<'a, 'a>,
    /// Its first sample in the tile.
    first: (i64, i64),
    size: (usize, usize),
    places: Places<'a>,
    /// The triangles that may have samples of it.
    near: Vec<usize>,
}

impl Window<'_> {
    fn number(&self, (column, row): At) -> usize {
        row * self.size.0 + column
    }

    /// Column and row in the tile.
    fn in_tile(&self, at: At) -> (f64, f64) {
        ((self.first.0 + at.0 as i64) as f64, (self.first.1 + at.1 as i64) as f64)
    }

    /// The samples that a triangle may have.
    fn samples(&self, facet: usize) -> impl Iterator<Item = At> {
        let facet = &self.cutter.facets[facet];
        let (left, top) = self.in_tile((0, 0));
        let rows = facet.bounds()[1];
        clipped(rows.0 - top, rows.1 - top, self.size.1).flat_map(move |r| {
            let columns = facet.columns(top + r as f64, &self.places.rows[r]);
            let columns = columns.map(|(low, high)| clipped(low - left, high - left, self.size.0));
            columns.unwrap_or(0..0).map(move |c| (c, r))
        })
    }

    /// The triangles whose surroundings a sample is in.
    fn around(&self, at: At) -> impl Iterator<Item = usize> {
        let (column, row) = self.in_tile(at);
        let is_in = move |(low, high): (f64, f64), at: f64| low <= at && at <= high;
        let near = self.near.iter().copied();
        near.filter(move |&i| is_in(self.cutter.bounds[i][0], column) && is_in(self.cutter.bounds[i][1], row))
    }

    /// Whether a triangle has a sample, or is the one at the chord that the sample lies beyond.
    fn has(&self, facet: usize, at: At) -> bool {
        let (place, normal) = self.places.at(at.0, at.1);
        let facets = &self.cutter.facets;
        facets[facet].has(place, normal)
            || facets[facet].is_passed(place, normal, self.in_tile(at))
                && !self.around(at).any(|other| facets[other].has(place, normal))
    }

    /// Keeps the triangles that have a sample, which is in no void, unless a whole one has it.
    fn settle(&self, at: At, block: &Block, states: &mut [State]) {
        let (place, normal) = self.places.at(at.0, at.1);
        let Cutter { facets, max_error, slack, .. } = self.cutter;
        let number = self.number(at);
        let takes = |facet: &Facet| {
            facet.has_within(place, normal, *slack)
                && (!block.inside[number] || facet.error(place, normal, block.heights[number], DOUBT) <= *max_error)
        };
        let having: Vec<usize> = self.around(at).filter(|&i| self.has(i, at)).collect();
        let is_whole = |i: usize| states[i] == State::Whole;
        if having.iter().any(|&i| is_whole(i)) || self.around(at).any(|i| is_whole(i) && takes(&facets[i])) {
            return;
        }
        having.into_iter().for_each(|i| states[i] = State::Kept);
    }
}
