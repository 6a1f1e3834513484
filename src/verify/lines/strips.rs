//! Edges along lines, looked for strip by strip from the first row to the last.
//!
//! A strip is a few rows of cells over the whole width. Its segments tell which stretches are whole in it: these are followed there.
//! Parts of others wait ([`Parts`]), with the edges that begin at their places. An edge is judged in every strip that it comes through:
//! its ends where they are, and in each strip the rows and columns that it crosses there. It is handed on where it ends.

use std::ops::Range;

use super::edges::{Edge, EdgeRecord};
use super::finder::Finder;
use super::follow::Stretch;
use super::heights::Samples;
use super::joined::{End, Parts};
use super::parts::{Graph, Part};
use super::required::Segment;
use super::wall::Wall;
use super::words::{first_of, spot};
use super::{RequiredLines, Spot};
use crate::base::Band;
use crate::base::control::CancelToken;
use crate::base::external::Sorted;
use crate::verify::VerifyError;

/// Segments in a strip, but for those of a few rows.
const SEGMENTS: usize = if cfg!(test) { 16 } else { 1 << 17 };

/// What passes over the strips.
///
/// Memory: some 200 bytes for each segment in a strip, and 60 for each edge that comes out of one.
pub(super) struct Strips<'s, 'a> {
    raster: &'a Band,
    lines: &'a RequiredLines,
    cancel: &'a CancelToken,
    coming: std::iter::Peekable<Sorted<'s, 4>>,
    parts: Parts<'s>,
    finder: Finder<'a>,
    /// Segments on the ground of strips before that end on the next one's first line.
    above: Vec<Segment>,
    /// Ends of parts at places of that line, with these.
    open: Vec<(u64, End)>,
    /// Edges that end farther down, with the parts that they begin at.
    waiting: Vec<(u32, Edge)>,
}

impl<'s, 'a> Strips<'s, 'a> {
    /// With edges in the order of their first places.
    pub(super) fn new(
        (raster, lines): (&'a Band, &'a RequiredLines),
        edges: Sorted<'s, 4>,
        (parts, finder): (Parts<'s>, Finder<'a>),
        cancel: &'a CancelToken,
    ) -> Strips<'s, 'a> {
        let (above, open, waiting) = (Vec::new(), Vec::new(), Vec::new());
        Strips { raster, lines, cancel, coming: edges.peekable(), parts, finder, above, open, waiting }
    }

    /// Passes over all strips, and follows all stretches.
    pub(super) fn pass(mut self) -> Result<Finder<'a>, VerifyError> {
        let rows = self.raster.height() as i64;
        let mut row = 0;
        while row < rows {
            self.cancel.check()?;
            let strip = self.lines.strip(row..rows, SEGMENTS);
            row = strip.end;
            self.strip(strip)?;
        }
        let mut stretches = self.parts.stretches()?;
        while let Some((stretch, edges)) = stretches.next()? {
            self.cancel.check()?;
            self.finder.add(stretch, &edges);
        }
        Ok(self.finder)
    }

    fn strip(&mut self, rows: Range<i64>) -> Result<(), VerifyError> {
        let after = first_of(4 * rows.end);
        let mut own: Vec<Segment> = self.lines.segments(rows.clone())?.collect();
        let mut edges: Vec<Edge> = Vec::new();
        while let Some(record) = self.coming.next_if(|record| record.as_ref().map_or(true, |record| record[0] < after))
        {
            let record: EdgeRecord = record?;
            if edges.last().is_none_or(|last| last.record() != record) {
                edges.push(Edge::of_record(record, true));
            }
        }
        if own.is_empty() && self.above.is_empty() && self.waiting.is_empty() {
            return Ok(());
        }
        let of = |edge: &Edge| edge.ends.map(spot);
        let ends: Vec<[Spot; 2]> = edges.iter().chain(self.waiting.iter().map(|(_, edge)| edge)).map(of).collect();
        let all: Vec<[Spot; 2]> = own.iter().chain(&self.above).map(|segment| segment.0).collect();
        let samples = Samples::read(self.raster, &all, (&ends, &rows), self.cancel)?;
        drop((ends, all));
        let (lines, before) = (self.lines, own.len());
        own.retain(|(segment, _)| samples.has_cell(*segment, |cell| lines.asks(*segment, cell)));
        self.finder.off_ground += (before - own.len()) as u64;

        // The next strip's first line is among them.
        let levels = self.lines.levels(rows.start..rows.end + 1)?;
        let wall = Wall { samples: &samples, levels: &levels, tolerance: self.finder.tolerance };
        let is_of_use = |edge: &mut Edge, finder: &Finder<'_>| {
            wall.judge(edge, &rows) && (edge.is_on_surface || finder.any_heights)
        };
        edges.retain_mut(|edge| is_of_use(edge, &self.finder));
        self.waiting.retain_mut(|(_, edge)| is_of_use(edge, &self.finder));
        drop(samples);

        let graph = Graph::new(&own, &self.above, after);
        self.above = own.into_iter().filter(|([_, b], _)| b.1 == 4 * rows.end).collect();
        self.follow(&graph, &edges, &levels, after)?;
        for (part, edge) in &self.waiting {
            if edge.ends[1] < after {
                self.parts.add_edge(*part, edge)?;
            }
        }
        self.waiting.retain(|(_, edge)| edge.ends[1] >= after);
        Ok(())
    }

    /// Follows the stretches that are whole in a strip, and has parts of others wait.
    fn follow(&mut self, graph: &Graph, edges: &[Edge], levels: &[(u64, f64)], after: u64) -> Result<(), VerifyError> {
        let mut parts = Vec::new();
        graph.parts(|part| parts.push(part));
        // Ends of parts where the strip above ends, and which parts have a place.
        let mut joints = std::mem::take(&mut self.open);
        let mut at: Vec<(u64, u32)> = joints.iter().map(|&(place, end)| (place, end / 2)).collect();
        let level =
            |place: &u64| levels.binary_search_by_key(place, |level| level.0).map_or(f64::NAN, |found| levels[found].1);
        for Part { places, sets, goes_on, is_ring } in parts {
            let levels = if levels.is_empty() { Vec::new() } else { places.iter().map(level).collect() };
            if goes_on == [false; 2] {
                let beginning = |&place: &u64| {
                    let first = edges.partition_point(|edge| edge.ends[0] < place);
                    edges[first..].iter().take_while(move |edge| edge.ends[0] == place)
                };
                let beginning: Vec<Edge> = places.iter().flat_map(beginning).copied().collect();
                self.finder.add(Stretch { places, levels, sets, is_ring }, &beginning);
                continue;
            }
            let number = self.parts.add(&places, &levels, sets)?;
            for (end, place) in [places[0], places[places.len() - 1]].into_iter().enumerate() {
                if goes_on[end] {
                    let ends = if place < after { &mut joints } else { &mut self.open };
                    ends.push((place, 2 * number + end as u32));
                }
            }
            at.extend(places.into_iter().map(|place| (place, number)));
        }
        joints.sort_unstable();
        for of in joints.chunk_by(|a, b| a.0 == b.0) {
            if graph.goes_on(of[0].0) {
                assert_eq!(of.len(), 2, "parts of a stretch where it goes on");
                self.parts.join(of[0].1, of[1].1);
            }
        }
        at.sort_unstable();
        at.dedup();
        for edge in edges {
            let first = at.partition_point(|(place, _)| *place < edge.ends[0]);
            for &(_, part) in at[first..].iter().take_while(|(place, _)| *place == edge.ends[0]) {
                if edge.ends[1] < after {
                    self.parts.add_edge(part, edge)?;
                } else {
                    self.waiting.push((part, *edge));
                }
            }
        }
        Ok(())
    }
}
