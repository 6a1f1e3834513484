//! The triangles of a tile in space, and how far a height is from them along a normal of the ellipsoid.

use super::decode::LAST;
use super::ellipsoid::{Point, across, less, times};
use super::tile::Tile;

/// What an error may be off by, in metres, on level ground; steeper triangles have it more often.
const ROUNDING: f64 = 2e-8;

/// What a triangle takes while its tile is judged: itself, half a vertex of a file and in space, and its places in lists, which grow by doubling.
pub(super) const BYTES_PER_TRIANGLE: u64 = (size_of::<Facet>() + 12 + (6 + 2 + 24) / 2 + 2 * 4 * 4) as u64;

/// Triangles of a tile. Places in it are columns and rows of the finest grid, from its north-western corner.
pub(super) struct Facets {
    cells: f64,
    /// How far beyond the edge of a hole a place may be and count as on the triangle there, in metres: a step of the lattice. `None` without holes.
    beside: Option<f64>,
    all: Vec<Facet>,
}

impl Facets {
    /// The triangles that `keeps` says yes to, by their corners.
    pub(super) fn of(tile: &Tile<'_>, keeps: impl Fn([Point; 3]) -> bool) -> Facets {
        let cells = tile.grid.cells(tile.key.level) as f64;
        let kept = tile.decoded.triangles.iter().filter(|t| keeps(t.map(|i| tile.points[i as usize])));
        let beside = tile.has_holes.then(|| tile.side().to_radians() * tile.ellipsoid.a / f64::from(LAST));
        Facets { cells, beside, all: kept.map(|&t| Facet::new(tile, t, cells)).collect() }
    }

    /// Columns and rows between which a triangle is met.
    pub(super) fn bounds(&self, triangle: usize) -> [(f64, f64); 2] {
        self.all[triangle].bounds
    }

    /// Whether a normal meets a triangle, or passes no edge farther outside than counts as on it beside a hole.
    pub(super) fn is_met(&self, triangle: usize, (foot, normal): (Point, Point)) -> bool {
        self.all[triangle].meet_beside(foot, normal, self.beside.unwrap_or(0.0)).is_some()
    }

    /// Ready for places in a window, by its first column and row and how many it has.
    pub(super) fn over(&self, first: (i64, i64), size: (i64, i64)) -> Window<'_> {
        Window { facets: self, buckets: Buckets::new(&self.all, first, size) }
    }
}

/// Triangles, looked for in a window.
pub(super) struct Window<'a> {
    facets: &'a Facets,
    buckets: Buckets,
}

impl Window<'_> {
    /// How far a height is from the triangles that the normal at a place of the window meets, along it: the largest error. `None` where
    /// it meets none.
    pub(super) fn error_met(
        &self,
        (column, row): (f64, f64),
        (foot, normal): (Point, Point),
        height: f64,
    ) -> Option<f64> {
        let near = self.buckets.at(column, row).iter();
        let met = near.filter_map(|&facet| self.facets.all[facet as usize].meet(foot, normal, true));
        met.map(|found| error(found, height)).reduce(f64::max)
    }

    /// The same of the surface, which goes on beyond the chords of its border, and a little beyond the rim of a hole. Infinite where there is
    /// none.
    pub(super) fn error(&self, (column, row): (f64, f64), (foot, normal): (Point, Point), height: f64) -> f64 {
        if let Some(largest) = self.error_met((column, row), (foot, normal), height) {
            return largest;
        }
        let Facets { cells, beside, all } = self.facets;
        let near = self.buckets.at(column, row);
        let error = |found| error(found, height);
        if let Some(metres) = *beside {
            let near = near.iter().filter_map(|&facet| all[facet as usize].meet_beside(foot, normal, metres));
            if let Some(least) = near.map(error).reduce(f64::min) {
                return least;
            }
        }
        // Beyond the chord of a border: the triangle at that border goes on.
        let at = [column, cells - row, cells - column, row];
        let side = (0..4).min_by(|&a, &b| at[a].total_cmp(&at[b])).unwrap_or(0);
        let along = if side % 2 == 0 { row } else { column };
        let at_border = all.iter().find(|facet| facet.reaches(side, along, *cells));
        at_border.and_then(|facet| facet.meet(foot, normal, false)).map_or(f64::INFINITY, error)
    }
}

/// How far a height is from where a triangle is met, with what rounding may add.
fn error((found, doubt): (f64, f64), height: f64) -> f64 {
    (found - height).abs() + doubt
}

/// A triangle, ready to be met by normals.
struct Facet {
    first: Point,
    one: Point,
    other: Point,
    plane: Point,
    /// How far shares may be below 0.
    slack: f64,
    /// Columns and rows between which it is met.
    bounds: [(f64, f64); 2],
    places: [[f64; 2]; 3],
}

impl Facet {
    fn new(tile: &Tile<'_>, triangle: [u32; 3], cells: f64) -> Facet {
        let points = triangle.map(|i| tile.points[i as usize]);
        let scale = cells / f64::from(LAST);
        let places = triangle.map(|i| {
            let [u, v, _] = tile.decoded.vertices[i as usize];
            [f64::from(u) * scale, f64::from(LAST - v) * scale]
        });
        let mut reach = [if tile.has_holes { 1.0 + scale } else { 1.0 }; 2];
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let middle: Point = std::array::from_fn(|k| 0.5 * (points[i][k] + points[j][k]));
            let (lon, lat) = tile.ellipsoid.place(middle, 1);
            let straight = [0.5 * (places[i][0] + places[j][0]), 0.5 * (places[i][1] + places[j][1])];
            let (west, north) = tile.place(0.0, f64::from(LAST));
            let cell = tile.grid.cell();
            let columns = ((lon - west + 180.0).rem_euclid(360.0) - 180.0) / cell - straight[0];
            let rows = (north - lat) / cell - straight[1];
            reach = [reach[0].max(2.0 * columns.abs() + 1.0), reach[1].max(2.0 * rows.abs() + 1.0)];
        }
        let bounds = [0, 1].map(|k| {
            let (low, high) =
                places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
            (low - reach[k], high + reach[k])
        });
        let (one, other) = (less(points[1], points[0]), less(points[2], points[0]));
        let plane = across(one, other);
        let longest = [one, other, less(other, one)].iter().map(|e| times(*e, *e).sqrt()).fold(0.0, f64::max);
        // A shift of this many metres at an edge is rounding.
        let slack = (1e-7 * longest / times(plane, plane).sqrt()).min(0.01);
        Facet { first: points[0], one, other, plane, slack, bounds, places }
    }

    /// The height at which a normal meets it, and what rounding may add: foot + height · normal = first + p · one + q · other, by
    /// Cramer's rule. Without `inside` its whole plane counts.
    fn meet(&self, foot: Point, normal: Point, inside: bool) -> Option<(f64, f64)> {
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
        let size = times(self.plane, self.plane).sqrt();
        Some((-times(self.plane, from) / facing, ROUNDING * size / facing))
    }

    /// The same at a normal that passes no edge farther outside than some metres.
    fn meet_beside(&self, foot: Point, normal: Point, metres: f64) -> Option<(f64, f64)> {
        let met = self.meet(foot, normal, false)?;
        let (facing, from) = (times(self.plane, normal), less(foot, self.first));
        let turned = across(normal, from);
        let (p, q) = (times(turned, self.other) / facing, -times(turned, self.one) / facing);
        // A share is what a place is away from an edge, of the height above it.
        let is_near = |share: f64, edge: Point| share >= -metres * times(edge, edge).sqrt() / facing;
        let third = less(self.other, self.one);
        (is_near(p, self.other) && is_near(q, self.one) && is_near(1.0 - p - q, third)).then_some(met)
    }

    /// Whether it has an edge on a side (west, south, east, north) over this place along it.
    fn reaches(&self, side: usize, along: f64, cells: f64) -> bool {
        let (axis, at) = [(0, 0.0), (1, cells), (0, cells), (1, 0.0)][side];
        let on: Vec<f64> = self.places.iter().filter(|p| (p[axis] - at).abs() < 1e-6).map(|p| p[1 - axis]).collect();
        on.len() == 2 && (on[0].min(on[1]) - 1e-6..=on[0].max(on[1]) + 1e-6).contains(&along)
    }
}

/// Which triangles may be met where in a window: squares of it, each with a list.
struct Buckets {
    first: (i64, i64),
    size: i64,
    across: i64,
    lists: Vec<Vec<u32>>,
}

impl Buckets {
    fn new(facets: &[Facet], first: (i64, i64), (width, height): (i64, i64)) -> Buckets {
        let size = 8;
        let (across, down) = ((width + size - 1) / size, (height + size - 1) / size);
        let mut lists = vec![Vec::new(); (across * down) as usize];
        let range = |(low, high): (f64, f64), first: i64, count: i64| {
            let bucket = |at: f64| ((at - first as f64) / size as f64).floor().clamp(-1.0, count as f64) as i64;
            bucket(low).max(0)..(bucket(high) + 1).min(count)
        };
        for (number, facet) in facets.iter().enumerate() {
            for row in range(facet.bounds[1], first.1, down) {
                for column in range(facet.bounds[0], first.0, across) {
                    lists[(row * across + column) as usize].push(number as u32);
                }
            }
        }
        Buckets { first, size, across, lists }
    }

    fn at(&self, column: f64, row: f64) -> &[u32] {
        let bucket = |at: f64, first: i64| (at as i64 - first) / self.size;
        &self.lists[(bucket(row, self.first.1) * self.across + bucket(column, self.first.0)) as usize]
    }
}
