//! The sides of tiles and of their parts: polylines over all samples of the finest grid on a line, the fewest links within a
//! tolerance. A side is a function of its line, its ends and the level, so that all who share it have the same.

use std::collections::HashMap;
use std::rc::Rc;

use super::error::PyramidError;
use super::own::{Along, OnLine, OnSide, refine};
use super::quantize::{SPAN, coordinate};
use super::rim;
use super::samples::{Block, Patch, Samples};
use crate::base::control::CancelToken;
use crate::base::exact::MAX_TOLERANCE;
use crate::kernel::seam::MinLink;

/// A vertex of a tile: its sample of the finest grid, counted from the tile's north-west corner, and the height there. One that stands for
/// a sample of the raster itself has a place of its own, and a sample near it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Vertex {
    pub(super) column: i64,
    pub(super) row: i64,
    pub(super) height: f64,
    /// Its coordinates in the format, where they are not those of the sample.
    pub(super) place: Option<(i64, i64)>,
}

impl Vertex {
    pub(super) fn of_sample(column: i64, row: i64, height: f64) -> Vertex {
        Vertex { column, row, height, place: None }
    }

    /// Its coordinates in the format: from the west, and from the south.
    pub(super) fn coordinates(&self, tile_cells: i64) -> (i64, i64) {
        let of_sample = || (coordinate(self.column, tile_cells), coordinate(tile_cells - self.row, tile_cells));
        self.place.unwrap_or_else(of_sample)
    }
}

/// A line of samples between two places, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Line {
    /// The first sample, on the grid.
    pub(super) column: i64,
    pub(super) row: i64,
    /// Cells.
    pub(super) length: i64,
    /// Whether it runs down a meridian; else along a parallel.
    pub(super) down: bool,
}

/// Samples outside of the raster that are so near to one inside, in parts of the line, bind nothing: there the surface comes
/// down to the height outside.
const COLLAR: i64 = 32;

/// Cells from samples inside to those outside that bind.
pub(super) fn collar(cells: i64) -> usize {
    (cells / COLLAR).clamp(1, MOST_COLLAR) as usize
}

/// However long a line is, no more are free.
const MOST_COLLAR: i64 = 64;

/// Which samples outside of the raster are within a distance of one inside, along a line.
pub(super) fn near_inside(inside: impl Iterator<Item = bool> + Clone, reach: usize) -> Vec<bool> {
    let inside: Vec<bool> = inside.collect();
    let mut near = vec![false; inside.len()];
    let mut sweep = |order: &mut dyn Iterator<Item = usize>| {
        let mut since = usize::MAX;
        for i in order {
            since = if inside[i] { 0 } else { since.saturating_add(1) };
            near[i] |= since <= reach;
        }
    };
    sweep(&mut (0..inside.len()));
    sweep(&mut (0..inside.len()).rev());
    near
}

/// Which samples of a line that the raster gives no height are near others inside, and so are bound to nothing.
pub(super) fn free_on_line(inside: &[bool]) -> Vec<bool> {
    let near = near_inside(inside.iter().copied(), collar(inside.len() as i64 - 1));
    near.iter().zip(inside).map(|(near, inside)| *near && !inside).collect()
}

/// A side.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Side {
    /// Its vertices along the line, from 0 to its length. All are at multiples of the snap.
    pub(super) vertices: Vec<OnSide>,
    /// The same with what the raster's own samples ask for, if they count.
    pub(super) refined: Option<Vec<OnSide>>,
}

/// Finds sides, one after the other.
#[derive(Default)]
pub(super) struct Sides {
    min_link: MinLink,
    block: Block,
    beside: Block,
    /// Those of the tile that is being made: two of its parts share each inside.
    found: HashMap<Line, Rc<Side>>,
}

impl Sides {
    /// Some that share what has been read.
    pub(super) fn beside(block: &Block) -> Sides {
        Sides { block: block.beside(), beside: block.beside(), ..Sides::default() }
    }

    /// Begins another tile.
    pub(super) fn begin(&mut self) {
        self.found.clear();
    }

    /// A side of the tile, which is found unless it has been.
    pub(super) fn side(
        &mut self,
        line: Line,
        find: impl FnOnce(&mut Sides) -> Result<Side, PyramidError>,
    ) -> Result<Rc<Side>, PyramidError> {
        if let Some(side) = self.found.get(&line) {
            return Ok(side.clone());
        }
        let side = Rc::new(find(self)?);
        self.found.insert(line, side.clone());
        Ok(side)
    }

    /// Finds a side.
    pub(super) fn find(
        &mut self,
        samples: &Samples,
        along: Along,
        tolerance: f64,
        snap: i64,
        cancel: &CancelToken,
    ) -> Result<Side, PyramidError> {
        let Line { column, row, length, down } = along.line;
        let level = |height: f64| {
            let vertices = [0, length].map(|at| along.sample(at, height, 0)).to_vec();
            Side { vertices, refined: None }
        };
        let (width, height) = if down { (0, length) } else { (length, 0) };
        if !samples.may_have(column, row, width, height) {
            return Ok(level(samples.outside));
        }
        let patch = Patch { column, row, width: width as usize + 1, height: height as usize + 1, step: 1 };
        samples.read(patch, &mut self.block)?;
        let Block { heights, inside, is_void, .. } = &self.block;
        if !inside.contains(&true) && heights.iter().all(|height| *height == heights[0]) {
            return Ok(level(heights[0]));
        }
        let mut flat = along.fall.along_side(down);
        flat.iter_mut().zip(heights).for_each(|(flat, height)| *flat = height - *flat);
        let mut limits = vec![tolerance; inside.len()];
        let path = if inside.contains(&false) {
            let mut free = free_on_line(inside);
            if is_void.contains(&true) {
                let near = near_void(samples, along.line, &mut self.beside, cancel)?;
                free.iter_mut().zip(near.iter().zip(is_void)).for_each(|(free, (near, void))| *free |= *near && *void);
            }
            let limit = |&free: &bool| if free { MAX_TOLERANCE } else { tolerance };
            limits = free.iter().map(limit).collect();
            let is_far = |i: usize| !inside[i] && !free[i];
            // Far outside the line is level, and so it is in a void: one link, however long.
            let turns: Vec<usize> =
                (1..free.len()).filter(|&i| is_far(i - 1) != is_far(i)).map(|i| i - usize::from(!is_far(i))).collect();
            self.min_link.path(&flat, limits.as_slice(), &turns, cancel)?
        } else {
            self.min_link.path(&flat, tolerance, &[], cancel)?
        };
        let mut side: Vec<OnSide> = Vec::with_capacity(path.len());
        for at in path {
            let snapped = (at as i64 + snap / 2) / snap * snap;
            if side.last().is_none_or(|last| last.at < snapped) {
                // A vertex that can stand beyond the raster only has the height of the sample that it is for.
                let keeps = inside[at] && !inside[snapped as usize];
                let height = heights[if keeps { at } else { snapped as usize }];
                side.push(along.sample(snapped, height, along.away(inside, snapped)));
            }
        }
        if snap == 1 {
            side = continued(along, side, inside, tolerance);
        }
        let on_line = OnLine { heights, inside, limits: &limits };
        let refined = samples.own.as_ref().map(|own| refine((own, samples.grid), along, &side, &on_line, tolerance));
        Ok(Side { vertices: side, refined: refined.transpose()? })
    }
}

/// A side whose links fall to the height outside a cell beyond the raster, where they would begin so steeply at its last sample that
/// rounding the place of its vertex would cost too much. Its ends stay. So does a link that passes samples of the raster farther on: it is within the tolerance
/// there as it is.
fn continued(along: Along, mut side: Vec<OnSide>, inside: &[bool], tolerance: f64) -> Vec<OnSide> {
    /// The share of the tolerance that a step of the lattice may cost.
    const SHARE: f64 = 0.125;
    let step = along.tile_cells as f64 / SPAN as f64;
    let passes_raster = |a: i64, b: i64| inside[a.min(b) as usize + 1..a.max(b) as usize].contains(&true);
    let mut further = Vec::new();
    for at in 0..side.len() {
        let OnSide { at: from, height, .. } = side[at];
        // How its place is to be rounded, if otherwise than it is.
        let mut way = None;
        for towards in [1, -1] {
            let other = at.wrapping_add_signed(towards as isize);
            let Some(&next) = side.get(other) else { continue };
            let steepness = (next.height - height).abs() / (next.at - from).abs() as f64;
            if !inside[from as usize] || inside[(from + towards) as usize] || steepness * step <= SHARE * tolerance {
                continue;
            }
            let beyond = side.get(other.wrapping_add_signed(towards as isize)).filter(|_| next.at == from + towards);
            if passes_raster(from, next.at) || beyond.is_some_and(|beyond| passes_raster(next.at, beyond.at)) {
                continue;
            }
            if next.at != from + towards {
                further.push(along.sample(from + towards, height, 0));
            } else if (1..side.len() - 1).contains(&other) {
                side[other].height = height;
            } else {
                // What falls to an end that stays falls beyond the sample.
                if rim::counts(along.tile_cells) {
                    way = Some(towards);
                }
                continue;
            }
            way = way.or(Some(0));
        }
        if let Some(way) = way.filter(|_| (1..side.len() - 1).contains(&at)) {
            side[at] = along.sample(from, height, way);
        }
    }
    side.extend(further);
    side.sort_by_key(|vertex| vertex.at);
    // Two may have come to one place, from both of its sides.
    side.dedup_by_key(|vertex| vertex.at);
    side
}

/// Samples along a line whose surroundings are looked at together.
const RUN: i64 = 256;

/// Which samples of a line are near others, beside it as well, that are in no marked void.
fn near_void(
    samples: &Samples,
    line: Line,
    block: &mut Block,
    cancel: &CancelToken,
) -> Result<Vec<bool>, PyramidError> {
    let Line { column, row, length, down } = line;
    let reach = collar(length) as i64;
    let across = 2 * reach as usize + 1;
    let mut ground = Vec::with_capacity(length as usize + 1);
    for first in (0..=length).step_by(RUN as usize) {
        cancel.check()?;
        let run = RUN.min(length + 1 - first) as usize;
        let patch = match down {
            true => Patch { column: column - reach, row: row + first, width: across, height: run, step: 1 },
            false => Patch { column: column + first, row: row - reach, width: run, height: across, step: 1 },
        };
        samples.read(patch, block)?;
        let number = |along: usize, beside: usize| if down { along * across + beside } else { beside * run + along };
        ground.extend((0..run).map(|along| (0..across).any(|beside| !block.is_void[number(along, beside)])));
    }
    Ok(near_inside(ground.into_iter(), reach as usize))
}

#[cfg(test)]
mod tests {
    use super::super::{Body, Grid, fall::Fall};
    use super::*;

    /// A side of 8 cells of a tile with so many.
    fn along(tile_cells: i64) -> Along {
        let line = Line { column: 0, row: 0, length: 8, down: false };
        let body = Body { semi_major: 6e6, semi_minor: 6e6 };
        Along { line, first: 0, tile_cells, fall: Fall { body, grid: Grid { exponent: 7 }, top: 0, cells: 8 } }
    }

    #[test]
    fn sides_fall_a_cell_beyond_the_raster_where_that_is_steep() {
        let along = along(8);
        let inside = [false, false, false, true, true, true, false, false, false];
        let side = |height: f64| {
            let heights = [(0, 0.0), (3, height), (5, height), (6, 0.0), (8, 0.0)];
            heights.map(|(at, height)| along.sample(at, height, along.away(&inside, at))).to_vec()
        };
        let found = |height: f64| -> Vec<(i64, f64)> {
            let side = continued(along, side(height), &inside, 1.0);
            side.iter().map(|vertex| (vertex.at, vertex.height)).collect()
        };
        assert_eq!(found(1.0), [(0, 0.0), (3, 1.0), (5, 1.0), (6, 0.0), (8, 0.0)]);
        let steep = 5_000.0;
        assert_eq!(found(steep), [(0, 0.0), (2, steep), (3, steep), (5, steep), (6, steep), (8, 0.0)]);
    }

    /// Ground that goes on beyond a gap, at a slope that a step of the lattice costs more than its share on: were the link to begin a cell
    /// farther on, it would miss the sample that it passes.
    #[test]
    fn sides_keep_to_the_raster_beyond_a_gap() {
        let along = along(128);
        let inside = [true, true, true, true, false, false, true, true, true];
        let side = |heights: [(i64, f64); 4]| heights.map(|(at, height)| along.sample(at, height, 0)).to_vec();
        let over_gap = side([(0, 400.0), (3, 182.0), (7, 100.0), (8, 80.0)]);
        assert_eq!(continued(along, over_gap.clone(), &inside, 0.5), over_gap);
        // The same where the gap has a vertex.
        let in_gap = side([(0, 400.0), (3, 182.0), (4, 161.5), (7, 100.0)]);
        assert_eq!(continued(along, in_gap.clone(), &inside, 0.5), in_gap);
        // Nothing is passed here.
        let to_end_of_gap = side([(0, 400.0), (3, 182.0), (6, 100.0), (8, 80.0)]);
        let found: Vec<(i64, f64)> =
            continued(along, to_end_of_gap, &inside, 0.5).iter().map(|v| (v.at, v.height)).collect();
        assert_eq!(found, [(0, 400.0), (3, 182.0), (4, 182.0), (5, 100.0), (6, 100.0), (8, 80.0)]);
    }

    #[test]
    fn beside_an_end_that_stays_a_vertex_is_rounded_towards_it() {
        for (first, at, end, place) in [(96, 7, 8, 26368), (32, 1, 0, 8447)] {
            let along = Along { first, ..along(128) };
            let inside: Vec<bool> = (0..=8).map(|i| i == at).collect();
            let height = |i: i64| if i == at { 5_000.0 } else { 0.0 };
            let side = [0, at, 8].map(|i| along.sample(i, height(i), along.away(&inside, i))).to_vec();
            assert_eq!((side[1].lattice, (side[1].lattice - place).abs()), (coordinate(first + at, 128), 1));
            let found = continued(along, side, &inside, 1.0);
            let vertex = found.iter().find(|vertex| vertex.at == at).expect("it stays");
            assert_eq!(vertex.lattice, place);
            assert_eq!(found.iter().find(|vertex| vertex.at == 2 * at - end).expect("a cell on").height, 5_000.0);
        }
    }

    #[test]
    fn samples_near_those_inside() {
        let inside = [false, false, false, true, false, false, false, false, true];
        let near = near_inside(inside.into_iter(), 2);
        assert_eq!(near, [false, true, true, true, true, true, true, true, true]);
        assert_eq!(near_inside([false; 3].into_iter(), 2), [false; 3]);
    }
}
