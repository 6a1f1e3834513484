//! The triangles of a tile, and how far a height is from them along a normal of the ellipsoid.

use super::decode::LAST;
use super::ellipsoid::Point;
use super::facet::Facet;
use super::tile::Tile;

/// What a triangle takes while its tile is judged: itself, half a vertex of a file and in space, and its places in lists, which grow by doubling.
pub(super) const BYTES_PER_TRIANGLE: u64 = (size_of::<Facet>() + 12 + (6 + 2 + 24) / 2 + 2 * 4 * 4) as u64;

/// Triangles of a tile. Places in it are columns and rows of the finest grid, from its north-western corner.
pub(super) struct Facets {
    cells: f64,
    /// How far beyond the edge of a hole a place may be and count as on the triangle there, in metres: a step of the lattice. `None` without holes.
    beside: Option<f64>,
    /// Whether they are known to tile the square of the tile.
    pub(super) is_tiling: bool,
    pub(super) all: Vec<Facet>,
    /// Those with an edge on the western, southern, eastern and northern border, and between which places along it.
    on_border: [Vec<(f64, f64, u32)>; 4],
}

/// What a place on the border may be off it by, in cells.
const ON_BORDER: f64 = 1e-6;

impl Facets {
    /// All triangles of a tile, and whether they are known to tile its square.
    pub(super) fn of(tile: &Tile<'_>, is_tiling: bool) -> Facets {
        let cells = tile.grid.cells(tile.key.level) as f64;
        let scale = cells / f64::from(LAST);
        let mut facets =
            Facets { cells, beside: tile.beside_hole(), is_tiling, all: Vec::new(), on_border: Default::default() };
        facets.all.reserve_exact(tile.decoded.triangles.len());
        for (number, &triangle) in (0..).zip(&tile.decoded.triangles) {
            let places = triangle.map(|i| {
                let [u, v, _] = tile.decoded.vertices[i as usize];
                [f64::from(u) * scale, f64::from(LAST - v) * scale]
            });
            facets.all.push(Facet::new(tile, triangle, places));
            for (side, (axis, border)) in [(0, 0.0), (1, cells), (0, cells), (1, 0.0)].into_iter().enumerate() {
                let mut on = places.iter().filter(|p| (p[axis] - border).abs() < ON_BORDER).map(|p| p[1 - axis]);
                if let (Some(a), Some(b), None) = (on.next(), on.next(), on.next()) {
                    facets.on_border[side].push((a.min(b) - ON_BORDER, a.max(b) + ON_BORDER, number));
                }
            }
        }
        facets
    }

    /// Columns and rows between which a triangle is met.
    pub(super) fn bounds(&self, triangle: usize) -> [(f64, f64); 2] {
        self.all[triangle].bounds
    }

    /// Whether a normal meets a triangle, or passes no edge farther outside than counts as on it beside a hole.
    pub(super) fn is_met(&self, triangle: usize, place: (Point, Point)) -> bool {
        self.all[triangle].meet_beside(place, self.beside.unwrap_or(0.0)).is_some()
    }

    /// Ready for places in a window, by its first column and row and how many it has.
    pub(super) fn over(&self, first: (i64, i64), size: (i64, i64)) -> Window<'_> {
        Window { facets: self, buckets: Buckets::new(&self.all, first, size) }
    }

    /// How far a height is from the surface at a place where a normal meets no triangle of it: it goes on beyond the chords of its border. Infinite
    /// where there is none.
    fn error_beyond(&self, (column, row): (f64, f64), place: (Point, Point), height: f64) -> f64 {
        let at = [column, self.cells - row, self.cells - column, row];
        let side = (0..4).min_by(|&a, &b| at[a].total_cmp(&at[b])).unwrap_or(0);
        let along = if side % 2 == 0 { row } else { column };
        let at_border = self.on_border[side].iter().find(|(low, high, _)| (*low..=*high).contains(&along));
        let met = at_border.and_then(|(_, _, facet)| self.all[*facet as usize].meet(place, false));
        met.map_or(f64::INFINITY, |found| error(found, height))
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
    pub(super) fn error_met(&self, (column, row): (f64, f64), place: (Point, Point), height: f64) -> Option<f64> {
        let near = self.buckets.at(column, row).iter().map(|&facet| &self.facets.all[facet as usize]);
        let may_be_met = near.filter(|facet| facet.may_be_met(column, row));
        may_be_met.filter_map(|facet| facet.meet(place, true)).map(|found| error(found, height)).reduce(f64::max)
    }

    /// The same of the surface, which goes on where no triangle is met: a little beyond the rim of a hole, and beyond chords.
    pub(super) fn error(&self, at: (f64, f64), place: (Point, Point), height: f64) -> f64 {
        let Facets { beside, all, .. } = self.facets;
        let near = || self.buckets.at(at.0, at.1).iter().map(|&facet| &all[facet as usize]);
        let beside_hole = |metres: f64| {
            let met = near().filter_map(|facet| facet.meet_beside(place, metres));
            met.map(|found| error(found, height)).reduce(f64::min)
        };
        let met = self.error_met(at, place, height).or_else(|| beside.and_then(beside_hole));
        met.unwrap_or_else(|| self.facets.error_beyond(at, place, height))
    }
}

/// How far a height is from where a triangle is met, with what rounding may add.
pub(super) fn error((found, doubt): (f64, f64), height: f64) -> f64 {
    (found - height).abs() + doubt
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
