//! A triangle of a tile in space: at which places of the tile normals may meet it, at which they surely do, and how high.
//!
//! **Where.** Longitude and latitude of a point of a triangle are almost those of its corners, weighted as the point is. If H bounds the second
//! derivatives along straight lines, and L is the longest side, they are off by no more than H L² ÷ 6: by Taylor's formula at the point X, ½ H Σ wᵢ |Aᵢ − X|²,
//! the first order cancels, which is ½ H Σ wᵢ wⱼ |Aᵢ − Aⱼ|² over the three sides ([`super::ellipsoid::Ellipsoid::bends`]). So a normal that meets the triangle stands at most this *reach* beside the flat
//! triangle on the grid. And one farther inside than that meets it: the image of the border goes once around its place.
//! Longitudes are between those of the corners, as half planes of meridians bound what is convex; a pole has any longitude.

use super::ellipsoid::{Point, across, less, times};
use super::tile::Tile;

/// What an error may be off by, in metres, on level ground; steeper triangles have it more often.
const ROUNDING: f64 = 2e-8;

/// A shift of this many metres at an edge is rounding.
const SHIFT: f64 = 1e-7;

/// The same of columns and rows, in cells.
const CELL_ROUNDING: f64 = 1e-6;

/// An edge on the grid: across a row, places on its inner side are those before or behind `slope` · row + `start`.
#[derive(Debug, Clone, Copy)]
struct Edge {
    slope: f64,
    start: f64,
    /// How far beside it is not known which side a normal is on, in columns; along a row in rows.
    doubt: f64,
    inner: Inner,
}

/// On which side of an edge the triangle is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Inner {
    East,
    West,
    /// The edge runs along the row `start`.
    North,
    South,
}

/// Columns of a row, ends included: those where a triangle may be met, and those where it surely is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spans {
    pub(super) outer: (f64, f64),
    pub(super) inner: (f64, f64),
}

/// A triangle, ready to be met by normals.
pub(super) struct Facet {
    first: Point,
    one: Point,
    other: Point,
    /// Across it, `size` long.
    plane: Point,
    size: f64,
    /// How far shares may be below 0.
    slack: f64,
    /// Columns and rows between which it is met.
    pub(super) bounds: [(f64, f64); 2],
    edges: [Edge; 3],
}

/// The plane of a triangle: normals of this direction, of length 1, and how far it is from the centre of the ellipsoid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub(super) direction: Point,
    pub(super) offset: f64,
}

impl Facet {
    /// `places` are columns and rows of its corners.
    pub(super) fn new(tile: &Tile<'_>, triangle: [u32; 3], places: [[f64; 2]; 3]) -> Facet {
        let points = triangle.map(|i| tile.points[i as usize]);
        let (one, other) = (less(points[1], points[0]), less(points[2], points[0]));
        let plane = across(one, other);
        let longest = [one, other, less(other, one)].iter().map(|e| times(*e, *e).sqrt()).fold(0.0, f64::max);
        let size = times(plane, plane).sqrt();
        let reach = reach(tile, points, longest);
        let beside = tile.beside_hole_in_cells(points);
        let ends = |k: usize, is_in: &dyn Fn(usize) -> bool| {
            let of = (0..3).filter(|&i| is_in(i)).map(|i| places[i][k]);
            of.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
        };
        let is_at_pole = triangle.map(|i| tile.is_on_pole(i));
        let columns = match is_at_pole {
            [true, true, true] => ends(0, &|_| true),
            _ => ends(0, &|i| !is_at_pole[i]),
        };
        let wider = |(low, high): (f64, f64), by: f64| (low - by, high + by);
        let bounds = [wider(columns, CELL_ROUNDING + beside[0]), wider(ends(1, &|_| true), reach[1] + beside[1])];
        let edge = |i: usize| Edge::new(places[i], places[(i + 1) % 3], reach);
        let slack = (SHIFT * longest / size).min(0.01);
        Facet { first: points[0], one, other, plane, size, slack, bounds, edges: [edge(0), edge(1), edge(2)] }
    }

    /// The height at which a normal meets it, and what rounding may add: foot + height · normal = first + p · one + q · other, by
    /// Cramer's rule. Without `inside` its whole plane counts.
    pub(super) fn meet(&self, (foot, normal): (Point, Point), inside: bool) -> Option<(f64, f64)> {
        let facing = times(self.plane, normal);
        if facing <= 0.0 {
            return None;
        }
        let from = less(foot, self.first);
        if inside {
            let turned = across(normal, from);
            let p = times(turned, self.other) / facing;
            let q = -times(turned, self.one) / facing;
            if p < -self.slack || q < -self.slack || p + q > 1.0 + self.slack {
                return None;
            }
        }
        Some((-times(self.plane, from) / facing, ROUNDING * self.size / facing))
    }

    /// The same at a normal that passes no edge farther outside than some metres.
    pub(super) fn meet_beside(&self, (foot, normal): (Point, Point), metres: f64) -> Option<(f64, f64)> {
        let met = self.meet((foot, normal), false)?;
        let (facing, from) = (times(self.plane, normal), less(foot, self.first));
        let turned = across(normal, from);
        let (p, q) = (times(turned, self.other) / facing, -times(turned, self.one) / facing);
        // A share is what a place is away from an edge, of the height above it.
        let is_near = |share: f64, edge: Point| share >= -metres * times(edge, edge).sqrt() / facing;
        let third = less(self.other, self.one);
        (is_near(p, self.other) && is_near(q, self.one) && is_near(1.0 - p - q, third)).then_some(met)
    }

    /// Its plane, if it has an area.
    pub(super) fn plane(&self) -> Option<Plane> {
        let direction = self.plane.map(|c| c / self.size);
        (self.size > 0.0).then(|| Plane { direction, offset: times(direction, self.first) })
    }

    /// The columns of a row where it is met. Those where it surely is may be none, and then end before they begin; so may all.
    pub(super) fn spans(&self, row: f64) -> Spans {
        let (mut outer, mut inner) = (self.bounds[0], (f64::NEG_INFINITY, f64::INFINITY));
        for edge in &self.edges {
            let at = edge.slope * row + edge.start;
            match edge.inner {
                Inner::East => (outer.0, inner.0) = (outer.0.max(at - edge.doubt), inner.0.max(at + edge.doubt)),
                Inner::West => (outer.1, inner.1) = (outer.1.min(at + edge.doubt), inner.1.min(at - edge.doubt)),
                Inner::North if row > edge.start - edge.doubt => inner.1 = f64::NEG_INFINITY,
                Inner::South if row < edge.start + edge.doubt => inner.1 = f64::NEG_INFINITY,
                Inner::North | Inner::South => {}
            }
        }
        Spans { outer, inner: (inner.0.max(outer.0), inner.1.min(outer.1)) }
    }

    /// Whether a normal at a place may meet it.
    pub(super) fn may_be_met(&self, column: f64, row: f64) -> bool {
        let (top, bottom) = self.bounds[1];
        let (west, east) = self.spans(row).outer;
        (top..=bottom).contains(&row) && (west..=east).contains(&column)
    }
}

impl Edge {
    /// The edge from a corner to the next, counter-clockwise from outside.
    fn new([column, row]: [f64; 2], [next_column, next_row]: [f64; 2], reach: [f64; 2]) -> Edge {
        let (columns, rows) = (next_column - column, next_row - row);
        if rows == 0.0 {
            let inner = if columns > 0.0 { Inner::North } else { Inner::South };
            return Edge { slope: 0.0, start: row, doubt: reach[1], inner };
        }
        let slope = columns / rows;
        let inner = if rows > 0.0 { Inner::East } else { Inner::West };
        Edge { slope, start: column - slope * row, doubt: reach[0] + slope.abs() * reach[1], inner }
    }
}

/// How far normals that meet a triangle may stand beside it on the grid, in columns and rows.
fn reach(tile: &Tile<'_>, points: [Point; 3], longest: f64) -> [f64; 2] {
    let cell = tile.grid.cell().to_radians();
    // No point of it is farther from all corners than that.
    let aside = longest / 3f64.sqrt();
    let from_axis = points.iter().map(|p| p[0] * p[0] + p[1] * p[1]).fold(f64::INFINITY, f64::min).sqrt() - aside;
    let from_centre = tile.ellipsoid.least_radius() + tile.decoded.minimum.min(0.0) - aside;
    let [columns, rows] = tile.ellipsoid.bends(from_axis, from_centre).map(|bend| bend * longest * longest / 6.0);
    // All of it is as near to each corner as its longest side is long.
    let rows = if from_centre > 0.0 { rows.min(longest / from_centre) } else { rows };
    let shift = 10.0 * SHIFT;
    // Farther than the whole tile is as good as anywhere.
    let most = 4.0 * tile.grid.cells(tile.key.level) as f64;
    let in_cells = |radians: f64| (radians / cell).min(most) + CELL_ROUNDING;
    [in_cells(columns + shift / from_axis.max(shift)), in_cells(rows + shift / from_centre.max(shift))]
}
