//! Holes of a tile over voids of the raster: whether they are as large as they have to be, and where they may be. That every sample which
//! is in no void has a triangle is judged with its distance ([`super::tile`]).

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use super::decode::LAST;
use super::facets::Facets;
use super::findings::{Findings, Kind};
use super::tile::Tile;
use crate::pyramid::{Patch, PyramidError, SampleBlock, Samples};

/// Samples that are read at a time, across and down.
const WINDOW: i64 = 256;

impl Tile<'_> {
    /// Judges the holes: no triangle is over a void alone, unless the tile has nothing else, and no hole is without a void.
    pub(super) fn judge_holes(
        &self,
        samples: &Samples,
        block: &mut SampleBlock,
        findings: &mut Findings,
    ) -> Result<(), PyramidError> {
        let key = self.key;
        let mut stands_in_void = Vec::with_capacity(self.decoded.vertices.len());
        for &[u, v, _] in &self.decoded.vertices {
            let (column, row) = (self.sample(u), self.sample(LAST - v));
            stands_in_void
                .push(self.is_any([(column, column), (row, row)], samples, block, |block, _, _| block.is_void[0])?);
        }
        let facets = Facets::of(self, false);
        for (number, triangle) in self.decoded.triangles.iter().enumerate() {
            if !triangle.iter().all(|&i| stands_in_void[i as usize]) {
                continue;
            }
            let bounds = facets.bounds(number).map(|(low, high)| (low.ceil() as i64, high.floor() as i64));
            let is_ground = |block: &SampleBlock, i: usize, (column, row): (i64, i64)| {
                !block.is_void[i] && facets.is_met(number, self.foot(column, row))
            };
            if !self.is_any(bounds, samples, block, is_ground)? && self.has_ground(samples, block)? {
                findings.add(Kind::Shape, || {
                    format!("tile {key}: triangle {triangle:?} is over a void, where a hole is promised")
                });
            }
        }
        for bounds in self.holes() {
            if !self.has_void(bounds, samples, block)? {
                let (lon, lat) = self.degrees(bounds[0].0, bounds[1].0);
                findings.add(Kind::Shape, || {
                    format!("tile {key}: at {lon}°, {lat}° is a hole where the raster has no void")
                });
            }
        }
        Ok(())
    }

    /// The column, or the row from the north, of the sample that a coordinate stands for.
    pub(super) fn sample(&self, coordinate: u16) -> i64 {
        let (cells, apart) = (self.grid.cells(self.key.level), self.samples_apart());
        (f64::from(coordinate) / f64::from(LAST) * (cells / apart) as f64).round() as i64 * apart
    }

    /// How far samples that vertices stand for are from each other, in cells: more than one where there are more samples than coordinates.
    pub(super) fn samples_apart(&self) -> i64 {
        (self.grid.cells(self.key.level) / 16384).max(1)
    }

    fn degrees(&self, column: i64, row: i64) -> (f64, f64) {
        let origin = self.key.origin(self.grid);
        (self.grid.longitude(origin.0 + column), self.grid.latitude(origin.1 + row))
    }

    fn foot(&self, column: i64, row: i64) -> (super::ellipsoid::Point, super::ellipsoid::Point) {
        let (lon, lat) = self.degrees(column, row);
        self.ellipsoid.foot(lon, lat)
    }

    /// Whether something is so of any sample between columns and rows of the tile, both included.
    fn is_any(
        &self,
        bounds: [(i64, i64); 2],
        samples: &Samples,
        block: &mut SampleBlock,
        is_so: impl Fn(&SampleBlock, usize, (i64, i64)) -> bool,
    ) -> Result<bool, PyramidError> {
        let cells = self.grid.cells(self.key.level);
        let origin = self.key.origin(self.grid);
        let [(west, east), (north, south)] = bounds.map(|(low, high)| (low.max(0), high.min(cells)));
        for top in (north..=south).step_by(WINDOW as usize) {
            for left in (west..=east).step_by(WINDOW as usize) {
                let size = |first: i64, last: i64| WINDOW.min(last + 1 - first) as usize;
                let (width, height) = (size(left, east), size(top, south));
                samples.read(Patch { column: origin.0 + left, row: origin.1 + top, width, height, step: 1 }, block)?;
                let at = |i: usize| (left + (i % width) as i64, top + (i / width) as i64);
                if (0..width * height).any(|i| is_so(block, i, at(i))) {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Whether any sample between columns and rows of the tile is in a void. Only samples of the raster are.
    fn has_void(
        &self,
        bounds: [(i64, i64); 2],
        samples: &Samples,
        block: &mut SampleBlock,
    ) -> Result<bool, PyramidError> {
        let origin = self.key.origin(self.grid);
        for ((left, top), (width, height)) in samples.windows(origin, self.grid.cells(self.key.level), WINDOW) {
            let clip = |(low, high): (i64, i64), first: i64, count: usize| {
                (low.max(first), high.min(first + count as i64 - 1))
            };
            let window = [clip(bounds[0], left, width), clip(bounds[1], top, height)];
            if self.is_any(window, samples, block, |block, i, _| block.is_void[i])? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether any sample of it is in no void.
    fn has_ground(&self, samples: &Samples, block: &mut SampleBlock) -> Result<bool, PyramidError> {
        let cells = self.grid.cells(self.key.level);
        Ok(!samples.has_all(self.key.origin(self.grid), cells)
            || self.is_any([(0, cells), (0, cells)], samples, block, |block, i, _| !block.is_void[i])?)
    }

    /// Columns and rows between which each hole lies: a hole is around edges that have a triangle on one side only, as far as they meet.
    fn holes(&self) -> Vec<[(i64, i64); 2]> {
        let edges: FxHashSet<(u32, u32)> =
            self.decoded.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        let vertices = &self.decoded.vertices;
        let on_side = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|i| vertices[i as usize]);
            (0..2).any(|k| a[k] == b[k] && (a[k] == 0 || a[k] == LAST))
        };
        let at_pole = |a: u32, b: u32| self.is_on_pole(a) || self.is_on_pole(b);
        let is_rim = |&&(a, b): &&(u32, u32)| !edges.contains(&(b, a)) && !on_side(a, b) && !at_pole(a, b);
        let mut rim: Vec<(u32, u32)> = edges.iter().filter(is_rim).copied().collect();
        rim.sort_unstable();
        let mut leaders: Vec<u32> = (0..vertices.len() as u32).collect();
        let leader = |leaders: &mut Vec<u32>, mut i: u32| {
            while leaders[i as usize] != i {
                leaders[i as usize] = leaders[leaders[i as usize] as usize];
                i = leaders[i as usize];
            }
            i
        };
        for &(a, b) in &rim {
            let (a, b) = (leader(&mut leaders, a), leader(&mut leaders, b));
            leaders[a as usize] = b;
        }
        let cells = self.grid.cells(self.key.level) as f64;
        let mut bounds: BTreeMap<u32, [(f64, f64); 2]> = BTreeMap::new();
        for i in rim.iter().flat_map(|&(a, b)| [a, b]) {
            let [u, v, _] = vertices[i as usize];
            let at = [u, LAST - v].map(|coordinate| f64::from(coordinate) / f64::from(LAST) * cells);
            let around = bounds.entry(leader(&mut leaders, i)).or_insert(at.map(|at| (at, at)));
            (0..2).for_each(|k| around[k] = (around[k].0.min(at[k]), around[k].1.max(at[k])));
        }
        let step = cells / f64::from(LAST);
        let outwards = |(low, high): (f64, f64)| ((low - step).floor() as i64, (high + step).ceil() as i64);
        bounds.into_values().map(|around| around.map(outwards)).collect()
    }
}
