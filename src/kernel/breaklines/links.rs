//! The fewest edges of a chain between two places that must be ends of edges.
//!
//! Edges run between places of the line. Of those that may be used the fewest are found layer by layer, as the vertices of sides are
//! (`seam/min_link`); but what makes an edge unusable does not end with longer ones, so how far is looked ahead is bounded.

use std::ops::Range;

use super::obstacles::{Obstacles, for_each_cell};
use super::wall::{keeps_to_heights, keeps_to_samples, keeps_to_surface, vertex};
use super::{FINE, Place, SetBits, Stretch};
use crate::base::control::{CancelToken, Cancelled};
use crate::base::exact;
use crate::base::lattice::{Point, STEPS, distance2, dot, orient};
use crate::base::mesh::Vertex;
use crate::base::{Cell, Tile, Window};

/// After this number of places in a row that cannot be joined to one, none beyond them is tried.
const PATIENCE: usize = 16;

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

/// An edge of a chain, and the sets of lines that it is of.
pub type ChainEdge = ([Vertex; 2], SetBits);

/// The edges of the chains of all pieces that a tile has ([`super::Pieces`]), as vertices of the tile. They touch each other at ends of pieces
/// alone, and pieces of other lines nowhere else.
///
/// # Errors
/// [`Untenable`].
pub fn thin(task: &Thinning<'_>, stretches: &[Stretch]) -> Result<Vec<ChainEdge>, Untenable> {
    let mut obstacles = Obstacles::default();
    for &(column, row) in task.points {
        let at = Point::of_sample(column as i32, row as i32);
        obstacles.add([at, at], None);
    }
    let pieces: Vec<Vec<Point>> =
        stretches.iter().map(|stretch| stretch.places.iter().map(|&p| task.local(p)).collect()).collect();
    for (number, piece) in (0..).zip(&pieces) {
        for (i, ends) in (0..).zip(piece.windows(2)) {
            obstacles.add([ends[0], ends[1]], Some((number, i)));
        }
    }
    let mut edges = Vec::new();
    for ((number, piece), stretch) in (0..).zip(&pieces).zip(stretches) {
        task.cancel.check()?;
        let places = piece.iter().zip(&stretch.places);
        let vertices =
            places.map(|(&at, &place)| task.vertex(at, place)).collect::<Result<Vec<Vertex>, Untenable>>()?;
        let sets = stretch.sets;
        let along = Along {
            task,
            vertices: &vertices,
            number,
            is_on_side: task.is_on_side(piece),
            shift: task.lines.shift_of(sets),
            has_heights: task.lines.has_own(sets),
        };
        let chain = along.fewest(&obstacles);
        for ends in chain.windows(2) {
            let edge = [vertices[ends[0]], vertices[ends[1]]];
            obstacles.add(edge.map(|v| v.at), None);
            edges.push((edge, sets));
        }
    }
    Ok(edges)
}

impl Thinning<'_> {
    fn local(&self, place: Place) -> Point {
        let local = |at: i64, first: usize| (at - first as i64 * i64::from(STEPS)) as i32;
        Point { x: local(place.x, self.window.column), y: local(place.y, self.window.row) }
    }

    fn vertex(&self, at: Point, place: Place) -> Result<Vertex, Untenable> {
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
struct Along<'a> {
    task: &'a Thinning<'a>,
    vertices: &'a [Vertex],
    number: u32,
    is_on_side: bool,
    /// How far places may be from their edge, in parts of a cell.
    shift: i64,
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
        while before[last] == NONE {
            let mut next = Vec::new();
            // The farthest first: it reaches what the others need not try.
            for &from in layer.iter().rev() {
                let (mut to, mut refused) = (from + 1, 0);
                while to <= last && refused < PATIENCE {
                    let is_reached = before[to] != NONE;
                    let may_join = is_reached || to == from + 1 || self.may_join(from, to, obstacles);
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

    /// Whether two places that are not next to each other can be joined by an edge.
    fn may_join(&self, from: usize, to: usize, obstacles: &Obstacles) -> bool {
        let (p, q) = (self.vertices[from], self.vertices[to]);
        let edge = [p.at, q.at];
        // An edge along a side would lie on others.
        (self.is_on_side || !self.task.is_on_side(&edge))
            && self.vertices[from + 1..to].iter().all(|v| is_near(v.at, edge, self.shift))
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
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_an_edge_is_exact() {
        let at = |x, y| Point { x, y };
        let cell = FINE;
        // Beside it, before it and behind it.
        for (place, cells) in [(at(8, 4), 1.0), (at(-4, 0), 1.0), (at(20, 3), 1.25)] {
            let shift = (cells * cell as f64) as i64;
            let edge = [at(0, 0), at(16, 0)];
            assert!(is_near(place, edge, shift) && !is_near(place, edge, shift - 1));
        }
        assert!(is_near(at(2, 2), [at(0, 0), at(9, 9)], 0));
    }
}
