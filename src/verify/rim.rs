//! The mesh's boundary where it need not be the ground's: quarter row by quarter row.

use std::iter::Peekable;

use super::VerifyError;
use super::bare::Bare;
use super::boundary::{EDGE_WORDS, EdgeWords};
use super::cells::CellRow;
use super::crossing::{Crossing, Side, Span};
use super::finding::{EdgePlace, Finding, MapPlace};
use super::grid::{Grid, STEPS};
use super::ground::Settled;
use super::lines::Inside;
use super::vertices::Vertex;
use crate::base::external::Sorted;

/// What the boundary of a mesh tells that may end within the ground.
#[derive(Debug, Default)]
pub(super) struct RimFindings {
    /// Edges of one face that lie on another one, or cross it.
    pub(super) crossed: Finding<EdgePlace>,
    /// Edges of one face with several faces, or less than none, to one side.
    pub(super) overlapping: Finding<EdgePlace>,
    /// Where faces leave the ground, in each quarter row anew.
    pub(super) beyond: Finding<MapPlace>,
    /// Where the core is not covered, in each quarter row anew.
    pub(super) bare_core: Finding<MapPlace>,
    /// Bare ground that borders on nothing but faces.
    pub(super) enclosed: Finding<MapPlace>,
    /// Twice the core's area, in lattice steps squared.
    pub(super) core_double_area: i128,
}

/// The record of an edge of one face, the face on the positive side of the way from the first end to the second: sorts by
/// its upper end. `None` where an end is not on the raster.
pub(super) fn record(grid: &Grid, from: (u64, Vertex), to: (u64, Vertex)) -> Option<EdgeWords> {
    let place = |v: Vertex| v.place.filter(|&p| grid.contains(p));
    let ((fx, fy), (tx, ty)) = (place(from.1)?, place(to.1)?);
    Some([fy.min(ty) as u64, 0, from.0, to.0, fx as u64, fy as u64, tx as u64, ty as u64])
}

/// An edge of one face that crosses a quarter row.
#[derive(Debug)]
struct Edge {
    words: EdgeWords,
    upper: (i64, i64),
    lower: (i64, i64),
    side: Side,
    /// Faces to its right less those to its left: 1 or −1.
    step: i64,
    is_crossed: bool,
    is_overlapping: bool,
}

impl Edge {
    fn new(words: EdgeWords) -> Edge {
        let (from, to) = ends(&words);
        // To somebody who walks down the rows the positive side lies to the left.
        let (upper, lower, step) = if from.1 < to.1 { (from, to, -1) } else { (to, from, 1) };
        let top = Crossing::at(upper.0);
        Edge { words, upper, lower, side: Side { top, bottom: top }, step, is_crossed: false, is_overlapping: false }
    }
}

fn ends(words: &EdgeWords) -> ((i64, i64), (i64, i64)) {
    ((words[4] as i64, words[5] as i64), (words[6] as i64, words[7] as i64))
}

fn place(grid: &Grid, words: &EdgeWords) -> EdgePlace {
    let (from, to) = ends(words);
    let end = |index, place| (index, Vertex { place: Some(place), z: 0.0 });
    let (a, b) = (end(words[2], from), end(words[3], to));
    if a.0 < b.0 { grid.edge(a, b) } else { grid.edge(b, a) }
}

/// Sweeps over the edges of one face: in every quarter row all of them cross it from the line above to the line below.
///
/// Memory use is 180 bytes for each edge of one face that crosses a quarter row, and as much for each piece of its ground.
pub(super) struct Rim<'s> {
    grid: Grid,
    coming: Peekable<Sorted<'s, EDGE_WORDS>>,
    /// Those that cross the latest quarter row, from left to right.
    edges: Vec<Edge>,
    bare: Bare,
    /// Where the mesh is to be, if that is not all of the ground. Then all that is inside is its core.
    inside: Option<&'s Inside>,
    /// Twice the area of the ground that is inside, in parts of lattice steps squared.
    double_area_in_parts: i128,
    found: RimFindings,
}

/// Sides of outlines are four steps high at the most, so where they cross lines is a whole number of these parts of a step.
const PARTS: i128 = 12;

impl<'s> Rim<'s> {
    pub(super) fn new(grid: Grid, edges: Sorted<'s, EDGE_WORDS>, inside: Option<&'s Inside>) -> Self {
        let (bare, edges, found) = (Bare::new(grid), (edges.peekable(), Vec::new()), RimFindings::default());
        Rim { grid, coming: edges.0, edges: edges.1, bare, inside, double_area_in_parts: 0, found }
    }

    /// What has been found, after the last row.
    pub(super) fn found(self) -> RimFindings {
        let cut = self.inside.map(|_| self.double_area_in_parts / PARTS);
        let core_double_area = cut.unwrap_or(self.found.core_double_area);
        RimFindings { enclosed: self.bare.enclosed(), core_double_area, ..self.found }
    }

    /// Sweeps over the next rows of cells.
    pub(super) fn follow(&mut self, settled: &Settled<'_>) -> Result<(), VerifyError> {
        let width = self.grid.width as usize;
        for (row, states) in (settled.first..).zip(settled.states.windows(2 * width).step_by(width)) {
            let y = STEPS * row;
            if row + 1 == self.grid.height {
                self.begin_edges(y)?;
                self.bare.finish(y);
                break;
            }
            let crosses = |column: usize| self.inside.is_some_and(|inside| inside.crosses((column as i64, row)));
            let cells = CellRow::new(&states[..width], &states[width..], crosses);
            self.found.core_double_area += i128::from(cells.core_double_area());
            for quarter in 0..STEPS {
                let ground = cells.ground(quarter);
                match self.inside {
                    None => self.sweep(y + quarter, &ground, &cells.core(quarter))?,
                    Some(inside) => {
                        let ground = inside.clip(y + quarter, &ground);
                        let width = |left: Crossing, right: Crossing| right.parts(PARTS) - left.parts(PARTS);
                        let areas = ground
                            .iter()
                            .map(|Span { left, right }| width(left.top, right.top) + width(left.bottom, right.bottom));
                        self.double_area_in_parts += areas.sum::<i128>();
                        self.sweep(y + quarter, &ground, &ground)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Sweeps over the quarter row below a line.
    fn sweep(&mut self, y: i64, ground: &[Span], core: &[Span]) -> Result<(), VerifyError> {
        self.begin_edges(y)?;
        for edge in &mut self.edges {
            edge.side.bottom = Crossing::of(edge.upper, edge.lower, y + 1);
        }
        self.edges.sort_by(|a, b| a.side.cmp(&b.side).then(a.step.cmp(&b.step)).then(a.words.cmp(&b.words)));
        let (mesh, in_order) = self.mesh();
        let within = self.stays_within(y, &mesh, ground);
        self.covers(y, &mesh, core);
        if in_order && within {
            self.bare.pass(y, ground, &mesh);
        } else {
            self.bare.pass_unknown();
        }
        Ok(())
    }

    /// Leaves the edges that end at a line, and takes those that begin at it.
    fn begin_edges(&mut self, y: i64) -> Result<(), VerifyError> {
        self.edges.retain(|edge| edge.lower.1 > y);
        self.edges.iter_mut().for_each(|edge| edge.side.top = edge.side.bottom);
        let mut along = Vec::new();
        while let Some(words) = self.coming.next_if(|e| e.as_ref().map_or(true, |e| e[0] as i64 <= y)) {
            let words = words?;
            let (from, to) = ends(&words);
            if from.1 == to.1 {
                along.push((from.0.min(to.0), from.0.max(to.0), words));
            } else {
                self.edges.push(Edge::new(words));
            }
        }
        // Of edges along the line no two have more than a point in common.
        along.sort_unstable();
        let mut end = i64::MIN;
        for (from, to, words) in along {
            if from < end {
                self.found.crossed.add(|| place(&self.grid, &words));
            }
            end = end.max(to);
        }
        Ok(())
    }

    /// The spans that faces cover, where that can be told, and whether the edges are in order: none on another or across
    /// it, a face to one side and none to the other.
    ///
    /// Edges come sorted by where they cross the line above, then by where they cross that below. If any two are the other
    /// way round below, two neighbours are.
    fn mesh(&mut self) -> (Vec<Span>, bool) {
        let (mut in_order, mut faces, mut spans) = (true, 0, Vec::new());
        for at in 0..self.edges.len() {
            let left = at.checked_sub(1).map(|before| self.edges[before].side);
            let here = self.edges[at].side;
            let crossed = left.is_some_and(|left| left == here || left.bottom > here.bottom);
            let edge = &mut self.edges[at];
            if let (1, Some(left)) = (faces, left) {
                spans.push(Span { left, right: here });
            }
            faces += edge.step;
            let overlapping = !(0..=1).contains(&faces);
            if crossed && !std::mem::replace(&mut edge.is_crossed, true) {
                self.found.crossed.add(|| place(&self.grid, &edge.words));
            }
            if overlapping && !std::mem::replace(&mut edge.is_overlapping, true) {
                self.found.overlapping.add(|| place(&self.grid, &edge.words));
            }
            in_order &= !crossed && !overlapping;
        }
        (spans, in_order && faces == 0)
    }

    /// Whether each span of the mesh is within one of the ground.
    fn stays_within(&mut self, y: i64, mesh: &[Span], ground: &[Span]) -> bool {
        let mut ground = ground.iter().peekable();
        let before = self.found.beyond.count;
        for span in mesh {
            while ground.next_if(|g| g.is_before(span)).is_some() {}
            let x = match ground.peek() {
                Some(g) if g.holds(span) => continue,
                Some(g) if g.left.is_left_of(&span.left) => g.right.top,
                _ => span.left.top,
            };
            self.found.beyond.add(|| self.grid.map((x.whole, y)));
        }
        self.found.beyond.count == before
    }

    /// Finds the spans of the core that are not within one of the mesh.
    fn covers(&mut self, y: i64, mesh: &[Span], core: &[Span]) {
        let mut mesh = mesh.iter().peekable();
        for span in core {
            while mesh.next_if(|m| m.is_before(span)).is_some() {}
            let x = match mesh.peek() {
                Some(m) if m.holds(span) => continue,
                Some(m) if m.left.is_left_of(&span.left) => m.right.top,
                _ => span.left.top,
            };
            self.found.bare_core.add(|| self.grid.map((x.whole, y)));
        }
    }
}
