//! The fewest edges of a chain between two places that must be ends of edges.
//!
//! Edges run between places of the line. Of those that may be used the fewest are found layer by layer, as the vertices of sides are
//! (`seam/min_link`); but what makes an edge unusable does not end with longer ones, so how far is looked ahead is bounded.

use std::ops::Range;

use super::obstacles::{Obstacles, for_each_cell};
use super::reach::{Around, Reach};
use super::wall::{keeps_to_heights, keeps_to_samples, keeps_to_surface, vertex};
use super::{FINE, Place, SetBits, Stretch};
use crate::base::control::{CancelToken, Cancelled};
use crate::base::exact;
use crate::base::lattice::{Point, STEPS, distance2, dot, orient};
use crate::base::mesh::Vertex;
use crate::base::{Cell, Tile, Window};

/// After this number of places in a row that cannot be joined to one, none beyond them is tried.
const PATIENCE: usize = 16;

/// From so many places on it is worth while to look for a short answer.
const FAR: usize = 24;

/// What the chains of a tile are made from.
#[derive(Debug, Clone, Copy)]
pub struct Thinning<'a> {
    /// The samples.
    pub tile: &'a Tile,
    /// Where they are in the raster.
    pub window: Window,
    /// The raster's samples across and down.
    pub size: (usize, usize),
    /// The distance allowed between the surface and the wall.
    pub tolerance: f64,
    /// What edges are held to beside that: how far places of the line may be from their edge, and heights of the line's own.
    pub lines: &'a super::Breaklines,
    /// Samples of the window that become vertices.
    pub points: &'a [(usize, usize)],
    /// Asked now and then.
    pub cancel: &'a CancelToken,
}

/// Why a tile has no chains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Untenable {
    /// At a place between samples the surface has a height that no double is within the tolerance of.
    Height {
        /// Column, with fractions.
        column: f64,
        /// Row, with fractions.
        row: f64,
    },
    /// The caller asked to stop.
    Cancelled,
}

impl From<Cancelled> for Untenable {
    fn from(_: Cancelled) -> Untenable {
        Untenable::Cancelled
    }
}

/// An edge of a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainEdge {
    /// Its ends.
    pub edge: [Vertex; 2],
    /// The sets of lines that it is of.
    pub sets: SetBits,
    /// Where it is on the mesh's border by a line's doing: whether the mesh is to the left of the way from its first end to its second.
    pub inside: Option<bool>,
}

/// The edges of the chains of all pieces that a tile has ([`super::Pieces`]), as vertices of the tile. They touch each other at ends of pieces
/// alone, and pieces of other lines nowhere else.
///
/// # Errors
/// [`Untenable`].
pub fn thin(task: &Thinning<'_>, stretches: &[Stretch]) -> Result<Vec<ChainEdge>, Untenable> {
    let pieces: Vec<Vec<Point>> =
        stretches.iter().map(|stretch| stretch.places.iter().map(|&p| task.local(p)).collect()).collect();
    let mut obstacles = task.obstacles(&pieces);
    let mut edges = Vec::new();
    for (number, stretch) in (0..).zip(stretches) {
        task.cancel.check()?;
        let vertices =
            stretch.places.iter().map(|&place| task.vertex(place)).collect::<Result<Vec<Vertex>, Untenable>>()?;
        let sets = stretch.sets;
        let along = task.along(&vertices, number, sets);
        let chain = along.fewest(&obstacles);
        for ends in chain.windows(2) {
            let edge = [vertices[ends[0]], vertices[ends[1]]];
            obstacles.add(edge.map(|v| v.at), None);
            // Along the border an edge is as straight as its places.
            let first = [stretch.places[ends[0]], stretch.places[ends[0] + 1]];
            edges.push(ChainEdge { edge, sets, inside: task.lines.has_inside_to_left(first) });
        }
    }
    Ok(edges)
}

impl Thinning<'_> {
    /// The points of the tile, and the segments of all pieces.
    fn obstacles(&self, pieces: &[Vec<Point>]) -> Obstacles {
        let mut obstacles = Obstacles::default();
        for &(column, row) in self.points {
            let at = Point::of_sample(column as i32, row as i32);
            obstacles.add([at, at], None);
        }
        for (number, piece) in (0..).zip(pieces) {
            for (i, ends) in (0..).zip(piece.windows(2)) {
                obstacles.add([ends[0], ends[1]], Some((number, i)));
            }
        }
        obstacles
    }

    /// A piece of a line of these sets.
    fn along<'a>(&'a self, vertices: &'a [Vertex], number: u32, sets: SetBits) -> Along<'a> {
        let places: Vec<Point> = vertices.iter().map(|vertex| vertex.at).collect();
        Along {
            task: self,
            vertices,
            number,
            is_on_side: self.is_on_side(&places),
            shift: self.lines.shift_of(sets),
            has_heights: self.lines.has_own(sets),
        }
    }

    fn local(&self, place: Place) -> Point {
        let local = |at: i64, first: usize| (at - first as i64 * i64::from(STEPS)) as i32;
        Point { x: local(place.x, self.window.column), y: local(place.y, self.window.row) }
    }

    fn vertex(&self, place: Place) -> Result<Vertex, Untenable> {
        let at = self.local(place);
        if let Some(height) = self.lines.height_at(place) {
            return Ok(Vertex { at, height });
        }
        let part = |local: i32, first: usize| first as f64 + f64::from(local) / f64::from(STEPS);
        let height = || Untenable::Height { column: part(at.x, self.window.column), row: part(at.y, self.window.row) };
        vertex(self.tile, at, self.tolerance).ok_or_else(height)
    }

    /// Whether all of these places are on one side of the tile.
    fn is_on_side(&self, places: &[Point]) -> bool {
        let far = |samples: usize| (samples as i32 - 1) * STEPS;
        let (right, bottom) = (far(self.tile.width()), far(self.tile.height()));
        let on: [&dyn Fn(&Point) -> bool; 4] = [&|p| p.x == 0, &|p| p.x == right, &|p| p.y == 0, &|p| p.y == bottom];
        on.into_iter().any(|on| places.iter().all(on))
    }

    /// Whether all cells of the raster that an edge touches have four heights.
    fn is_far_from_voids(&self, edge: [Point; 2]) -> bool {
        let validity = self.tile.validity();
        let is_in = |local: i32, first: usize, samples: usize| {
            let at = i64::from(local) + first as i64;
            at >= 0 && at < samples as i64 - 1
        };
        validity.is_whole()
            || for_each_cell(edge, |(column, row)| {
                let is_there =
                    is_in(column, self.window.column, self.size.0) && is_in(row, self.window.row, self.size.1);
                !is_there || validity.cell(column, row) == Cell::Whole
            })
    }
}

/// A piece of a line, as vertices.
pub(super) struct Along<'a> {
    pub(super) task: &'a Thinning<'a>,
    pub(super) vertices: &'a [Vertex],
    pub(super) number: u32,
    is_on_side: bool,
    /// How far places may be from their edge, in parts of a cell.
    pub(super) shift: i64,
    /// Whether the line has heights of its own at all of its places.
    has_heights: bool,
}

/// No place.
const NONE: usize = usize::MAX;

impl Along<'_> {
    /// The ends of edges: the first place, the last, and as few between them as are found.
    fn fewest(&self, obstacles: &Obstacles) -> Vec<usize> {
        let last = self.vertices.len() - 1;
        let mut before = vec![NONE; last + 1];
        let mut layer = vec![0];
        let mut around = Around::new(self, obstacles);
        // Heights of lines are not what is known at once.
        let keeps_to_raster = !self.has_heights && !self.task.lines.have_heights();
        // All places up to this one are reached.
        let mut reached = 0;
        while before[last] == NONE {
            let mut next = Vec::new();
            // The farthest first: it reaches what the others need not try.
            for &from in layer.iter().rev() {
                while reached < last && before[reached + 1] != NONE {
                    reached += 1;
                }
                let (mut to, mut refused) = (from.max(reached) + 1, 0);
                let mut reach = Reach::new(from);
                while to <= last && refused < PATIENCE {
                    let is_reached = before[to] != NONE;
                    let mut may_join = || {
                        let is_sure = keeps_to_raster && to - from >= FAR && reach.is_sure(to, &mut around);
                        self.may_join(from, to, is_sure, obstacles)
                    };
                    let may_join = is_reached || to == from + 1 || may_join();
                    if may_join && !is_reached {
                        before[to] = from;
                        next.push(to);
                    }
                    refused = if may_join { 0 } else { refused + 1 };
                    to += 1;
                }
            }
            next.sort_unstable();
            layer = next;
        }
        let mut chain: Vec<usize> =
            std::iter::successors(Some(last), |&i| Some(before[i]).filter(|&b| b != NONE)).collect();
        chain.reverse();
        chain
    }

    /// Whether two places that are not next to each other can be joined by an edge; `is_sure` where all is known that takes long to find out.
    fn may_join(&self, from: usize, to: usize, is_sure: bool, obstacles: &Obstacles) -> bool {
        let edge = [self.vertices[from].at, self.vertices[to].at];
        // An edge along a side would lie on others.
        (self.is_on_side || !self.task.is_on_side(&edge)) && (is_sure || self.is_free(from, to, obstacles))
    }

    /// Whether an edge between two places is near to those between them, off voids and other lines, and keeps to the surface.
    fn is_free(&self, from: usize, to: usize, obstacles: &Obstacles) -> bool {
        let (p, q) = (self.vertices[from], self.vertices[to]);
        let edge = [p.at, q.at];
        self.vertices[from + 1..to].iter().all(|v| is_near(v.at, edge, self.shift))
            && self.task.is_far_from_voids(edge)
            && self.keeps_to_wall(from, to)
            && obstacles.let_pass(edge, self.number, Range { start: from as u32, end: to as u32 })
    }

    /// Whether the edge between two places is within the tolerance of the line's own heights, or else of the raster's surface. Samples
    /// on it must be able to keep to it, which they may not be beside lines with other heights.
    fn keeps_to_wall(&self, from: usize, to: usize) -> bool {
        let &Thinning { tile, window, tolerance, lines, .. } = self.task;
        let (p, q) = (self.vertices[from], self.vertices[to]);
        let is_kept = match self.has_heights {
            true => keeps_to_heights(tolerance, p, q, &self.vertices[from + 1..to]),
            false => keeps_to_surface(tile, tolerance, p, q),
        };
        let stands = |(column, row): (usize, usize)| {
            let at = ((window.column + column) as i64, (window.row + row) as i64);
            let height = tile.at(column, row);
            let eased = lines.beside.at(at, height, tolerance);
            eased.map_or((height, tolerance), |eased| (eased.height, exact::limit(eased.weight, tolerance)))
        };
        is_kept && (!lines.have_heights() || keeps_to_samples(p, q, stands))
    }
}

/// Whether a place is at most so many parts of a cell from an edge, exactly.
fn is_near(place: Point, [a, b]: [Point; 2], shift: i64) -> bool {
    let (along, length2) = (dot(a, b, place), distance2(a, b));
    // Square of the distance: a fraction.
    let (over, under) = if along <= 0 {
        (i128::from(distance2(a, place)), 1)
    } else if along >= length2 {
        (i128::from(distance2(b, place)), 1)
    } else {
        (i128::from(orient(a, b, place)).pow(2), i128::from(length2))
    };
    let in_steps = i128::from(shift) * i128::from(STEPS);
    over * i128::from(FINE).pow(2) <= in_steps.pow(2) * under
}

#[cfg(test)]
mod tests;
