//! Edges from one place of a line to places farther and farther along it: which of them may be used for sure.
//!
//! Over a straight stretch of even ground an edge is asked for to every place, and each answer takes as long as the stretch. What
//! is kept here answers at once, for edges that stay in a narrow corridor around the line: its directions from the first place and
//! its slopes are intervals that every place makes narrower. It never says yes where the exact tests say no: lengths, directions and
//! slopes are reckoned in doubles, and their intervals are narrower by far more than rounding takes. It may be silent where they say
//! yes. So it decides how long the answer takes, and nothing else.
//!
//! Why the corridor is enough: while a point goes along the line from the first place to the last, its projection goes along the edge,
//! so every point of the edge is within [`CORRIDOR`] of one of the line, which is less than 0.71 cells from a place.

use super::FINE;
use super::links::Along;
use super::obstacles::{Obstacles, touches};
use crate::base::Cell;
use crate::base::lattice::{Point, STEPS, distance2, dot, orient};
use crate::base::mesh::Vertex;

/// The most that places may be off an edge here, in cells; less where the line itself may not be so far off.
const CORRIDOR: f64 = 0.5;

/// Cells around that of a place in which everything lies that an edge comes near, if it is off the line by so much.
const CELLS: i32 = 2;

/// Steps around a place in which the samples are between which an edge passes there: the edge may be 1.21 cells off, and a sample one more.
const SAMPLES: i32 = 9;

/// How far along an edge the surface near a place counts, in steps: 0.75 cells.
const ALONG: f64 = 3.0;

/// Further segments of the line itself that may lie in those cells, before a place and after it.
const OWN: u32 = 24;

/// What doubles may lose of a height, as a part of the largest number that is reckoned with.
const LOSS: f64 = 1e-10;

/// What the ground is like around the places of a line, each found where it is asked for first.
pub(super) struct Around<'a> {
    along: &'a Along<'a>,
    obstacles: &'a Obstacles,
    /// The slope of a plane that heights are told from, across and down, in steps.
    gradient: (f64, f64),
    /// What is lost in doubles of heights above that plane.
    loss: f64,
    places: Vec<Option<Place>>,
}

/// Around a place: the least and the largest height of samples above the plane, if nothing is in the way of an edge.
type Place = Option<(f64, f64)>;

impl Along<'_> {
    /// How many steps places may be off an edge here; below 0 where they must lie on it. Less than the line lets them by more than doubles
    /// lose.
    fn corridor(&self) -> f64 {
        let steps = f64::from(STEPS);
        (self.shift as f64 / FINE as f64).min(CORRIDOR) * steps - 1e-6
    }
}

impl<'a> Around<'a> {
    pub(super) fn new(along: &'a Along<'a>, obstacles: &'a Obstacles) -> Around<'a> {
        let gradient = gradient(along);
        let tile = along.task.tile;
        let steps = |samples: usize| samples as f64 * f64::from(STEPS);
        let of_plane = gradient.0.abs() * steps(tile.width()) + gradient.1.abs() * steps(tile.height());
        let largest = along.vertices.iter().map(|v| v.height.abs()).fold(of_plane, f64::max);
        Around { along, obstacles, gradient, loss: LOSS * largest, places: vec![None; along.vertices.len()] }
    }

    fn at(&mut self, place: usize) -> Place {
        if let Some(found) = self.places[place] {
            return found;
        }
        let at = self.along.vertices[place].at;
        let is_free = !self.along.task.tile.is_weighted() && self.is_free(place, at);
        let found = is_free.then(|| self.heights(at));
        self.places[place] = Some(found);
        found
    }

    /// Whether no void and no other line is near, nor this line itself but for the segments just before and after.
    fn is_free(&self, place: usize, at: Point) -> bool {
        let (tile, validity) = (self.along.task.tile, self.along.task.tile.validity());
        let range = |at: i32, samples: usize| {
            let cell = at.div_euclid(STEPS);
            (cell - CELLS).max(-1)..=(cell + CELLS).min(samples as i32 - 1)
        };
        let is_near = |number: u32| number.abs_diff(place as u32) <= OWN;
        range(at.y, tile.height()).all(|row| {
            range(at.x, tile.width()).all(|column| {
                (validity.is_whole() || validity.cell(column, row) == Cell::Whole)
                    && self.obstacles.is_own((column, row), self.along.number, is_near)
            })
        })
    }

    /// The least and the largest height above the plane of samples between which an edge may pass.
    fn heights(&self, at: Point) -> (f64, f64) {
        let tile = self.along.task.tile;
        let range = |at: i32, samples: usize| {
            let (first, last) = ((at - SAMPLES).div_euclid(STEPS), (at + SAMPLES).div_euclid(STEPS) + 1);
            first.max(0) as usize..=(last.max(0) as usize).min(samples - 1)
        };
        let mut found = (f64::INFINITY, f64::NEG_INFINITY);
        for row in range(at.y, tile.height()) {
            for column in range(at.x, tile.width()) {
                let sample = Vertex { at: Point::of_sample(column as i32, row as i32), height: tile.at(column, row) };
                let height = self.above(sample);
                found = (found.0.min(height), found.1.max(height));
            }
        }
        found
    }

    /// A height above the plane.
    fn above(&self, Vertex { at, height }: Vertex) -> f64 {
        height - self.gradient.0 * f64::from(at.x) - self.gradient.1 * f64::from(at.y)
    }
}

/// The mean slope of the ground along a line, in steps.
fn gradient(along: &Along<'_>) -> (f64, f64) {
    /// Places that are asked.
    const ASKED: usize = 64;
    let tile = along.task.tile;
    let (mut across, mut down, mut count) = (0.0, 0.0, 0.0);
    for vertex in along.vertices.iter().step_by(along.vertices.len().div_ceil(ASKED)) {
        let cell = |at: i32, samples: usize| (at.div_euclid(STEPS) as usize).min(samples - 2);
        let (column, row) = (cell(vertex.at.x, tile.width()), cell(vertex.at.y, tile.height()));
        across += tile.at(column + 1, row) - tile.at(column, row);
        down += tile.at(column, row + 1) - tile.at(column, row);
        count += f64::from(STEPS);
    }
    (across / count, down / count)
}

/// What is known of edges from a place to all up to another.
pub(super) struct Reach {
    from: usize,
    /// The last place that is looked at.
    looked_at: Option<usize>,
    cone: Option<Cone>,
    /// Heights above the plane for each step along an edge: the least and the most that keep to the surface.
    slopes: (f64, f64),
    /// Something is in the way, or the line has turned back.
    is_over: bool,
}

impl Reach {
    pub(super) fn new(from: usize) -> Reach {
        let slopes = (f64::NEG_INFINITY, f64::INFINITY);
        Reach { from, looked_at: None, cone: None, slopes, is_over: false }
    }

    /// Whether the edge from the place to this one may be used for sure. No place is asked for that is before one that was.
    pub(super) fn is_sure(&mut self, to: usize, around: &mut Around<'_>) -> bool {
        if self.cone.is_none() {
            let ends = [self.from, to].map(|place| around.along.vertices[place].at);
            self.cone = Some(Cone::new(ends, around.along.corridor()));
        }
        while !self.is_over && self.looked_at.is_none_or(|last| last < to) {
            let next = self.looked_at.map_or(self.from, |last| last + 1);
            self.is_over = !self.look_at(next, around);
            self.looked_at = Some(next);
        }
        !self.is_over && self.passes(to, around) && is_clear([self.from, to], around.along)
    }

    /// Takes the next place. Returns whether any edge can still be used for sure.
    fn look_at(&mut self, place: usize, around: &mut Around<'_>) -> bool {
        let Some((low, high)) = around.at(place) else { return false };
        let vertices = around.along.vertices;
        let (from, at) = (vertices[self.from], vertices[place].at);
        if self.cone.as_mut().is_some_and(|cone| !cone.take(at)) {
            return false;
        }
        // Where along the edge the surface near the place counts, whichever edge it is.
        let (far, off) = (distance2(from.at, at) as f64, CORRIDOR * f64::from(STEPS));
        let stretch = ((far - off * off).max(0.0).sqrt() - ALONG, far.sqrt() + ALONG);
        let (nearest, farthest) = (stretch.0.max(0.0), stretch.1);
        let (start, tolerance) = (around.above(from), around.along.task.tolerance - around.loss);
        let (most, least) = (low + tolerance - start, high - tolerance - start);
        self.slopes.0 = self.slopes.0.max(least / if least <= 0.0 { farthest } else { nearest });
        self.slopes.1 = self.slopes.1.min(most / if most >= 0.0 { farthest } else { nearest });
        tolerance > 0.0 && self.slopes.0 <= self.slopes.1
    }

    /// Whether the edge passes all places near enough, and keeps to the surface at all of them.
    fn passes(&self, to: usize, around: &Around<'_>) -> bool {
        let [from, to] = [self.from, to].map(|place| around.along.vertices[place]);
        let slope = (around.above(to) - around.above(from)) / (distance2(from.at, to.at) as f64).sqrt();
        self.cone.as_ref().is_some_and(|cone| cone.has(to.at)) && (self.slopes.0..=self.slopes.1).contains(&slope)
    }
}

/// Whether an edge between two places touches none of the segments just before and after them.
fn is_clear([from, to]: [usize; 2], along: &Along<'_>) -> bool {
    let vertices = along.vertices;
    let edge = [vertices[from].at, vertices[to].at];
    let others = (from.saturating_sub(OWN as usize)..from).chain(to..(to + OWN as usize + 1).min(vertices.len() - 1));
    others.into_iter().all(|i| !touches(edge, [vertices[i].at, vertices[i + 1].at]))
}

/// In which directions an edge passes all places that have been taken so near as it must.
struct Cone {
    from: Point,
    /// A place of the line: others that count are within half a right angle of its direction, so that turns tell the order of directions.
    ahead: Point,
    /// How many steps places may be off; below 0 where they must lie on the ray to the place ahead.
    shift: f64,
    /// Whether all do.
    is_ray: bool,
    /// The outermost directions: from the one, all others are turned towards the other. `None` while every direction will do.
    sides: Option<[Direction; 2]>,
    /// The square of the distance of the place that is farthest away.
    farthest: i64,
}

type Direction = (f64, f64);

impl Cone {
    fn new([from, ahead]: [Point; 2], shift: f64) -> Cone {
        Cone { from, ahead, shift, is_ray: true, sides: None, farthest: 0 }
    }

    /// Takes another place. Returns whether there may be edges that pass all places.
    fn take(&mut self, at: Point) -> bool {
        let (from, ahead) = (self.from, self.ahead);
        let (far2, turned, along) = (distance2(from, at), orient(from, ahead, at), dot(from, ahead, at));
        self.farthest = self.farthest.max(far2);
        self.is_ray &= turned == 0 && (along > 0 || far2 == 0);
        if self.shift < 0.0 || self.is_ray && turned.abs() >= along {
            return self.is_ray;
        }
        let before2 = far2 as f64 - self.shift * self.shift;
        if before2 <= 0.0 {
            // Near, whatever the direction.
            return true;
        }
        if turned.abs() >= along {
            return false;
        }
        // Along the tangents to the circle around the place.
        let (x, y, before) = (f64::from(at.x - from.x), f64::from(at.y - from.y), before2.sqrt());
        let tangent = |beside: f64| (x * before - y * beside, y * before + x * beside);
        let (right, left) = (tangent(-self.shift), tangent(self.shift));
        let [right, left] = match self.sides {
            None => [right, left],
            Some([old_right, old_left]) => [
                if turn(old_right, right) > 0.0 { right } else { old_right },
                if turn(old_left, left) < 0.0 { left } else { old_left },
            ],
        };
        self.sides = Some([right, left]);
        self.is_ray || turn(right, left) > 0.0 || inner(right, left) < 0.0
    }

    /// Whether an edge to one of the places that have been taken passes all of them near enough, and ends before none.
    fn has(&self, to: Point) -> bool {
        let direction = (f64::from(to.x - self.from.x), f64::from(to.y - self.from.y));
        let is_between = |[right, left]: [Direction; 2]| turn(right, direction) > 0.0 && turn(direction, left) > 0.0;
        let is_within = self.shift >= 0.0 && self.sides.is_some_and(is_between);
        distance2(self.from, to) >= self.farthest && (self.is_ray || is_within)
    }
}

fn inner(a: Direction, b: Direction) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

/// Above 0 where the second direction is turned from the first towards y.
fn turn(a: Direction, b: Direction) -> f64 {
    a.0 * b.1 - a.1 * b.0
}
