//! The rim of a tile: which of its vertices it owns, and which are its neighbours'.

use std::ops::Range;

use super::chained::OnSide;
use super::runs::Runs;
use super::{MinLink, Sides, ground};
use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::{Domain, Vertex, loop_edges};
use crate::base::tiling::TilePlace;
use crate::kernel::breaklines::TileChains;

/// The rim of a tile: its corners and the vertices of its four sides, as the domain of an engine, and where samples are
/// missing the loops around its ground.
///
/// Vertices that the tile owns come first: the corners (north-west, then north-east, south-west, south-east), then the
/// sides (north, west, east, south), each from the lower coordinate to the higher. Vertices owned by a neighbour follow,
/// then those of loops inside the tile.
#[derive(Debug, Clone, Default)]
pub struct Rim {
    /// What is to be triangulated: the loops, and the points inside.
    pub domain: Domain,
    /// How many of which kind the tile owns.
    pub owned: RimCounts,
    /// Vertices that the tile owns but has no ground at, so that only neighbours use them: their places among those it
    /// owns, ascending. The domain goes without them.
    pub idle: Vec<(u32, Vertex)>,
    /// The others, in the domain's order.
    pub foreign: Vec<Foreign>,
}

/// How many vertices of its rim a tile owns, by kind. A tile owns its north and west side and the corner between; the
/// last column owns its east side too, the last row its south side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RimCounts {
    /// Which corners, as bits: 1 is north-west, 2 north-east, 4 south-west, 8 south-east.
    pub corners: u32,
    /// Vertices between the corners of the north side.
    pub north: u32,
    /// Of the west side.
    pub west: u32,
    /// Of the east side, in the last column.
    pub east: u32,
    /// Of the south side, in the last row.
    pub south: u32,
}

impl RimCounts {
    /// All of them.
    pub fn total(&self) -> u32 {
        self.before_west() + self.west + self.east + self.south
    }

    /// The place of the first vertex of the north side: all corners come before it.
    pub fn before_north(&self) -> u32 {
        self.corners.count_ones()
    }

    /// The place of the first vertex of the west side.
    pub fn before_west(&self) -> u32 {
        self.before_north() + self.north
    }

    /// The place of a corner, by its bit.
    pub fn corner(&self, bit: u32) -> u32 {
        (self.corners & (bit - 1)).count_ones()
    }
}

/// A rim vertex that a neighbour owns. Ordinals count the vertices of a side from its lower coordinate, corners apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// The corner at the end of the north side.
    NorthEast,
    /// The corner at the end of the west side.
    SouthWest,
    /// The corner opposite the tile's own.
    SouthEast,
    /// On the east side: the west side of the next tile.
    East(u32),
    /// On the south side: the north side of the tile below.
    South(u32),
    /// At a place of a tile this number of columns and rows further, in that tile's lattice.
    At {
        /// Columns of tiles to the right, -1 for the left.
        across: i32,
        /// Rows of tiles down.
        down: u32,
        /// Where.
        at: Point,
    },
}

impl Rim {
    /// Computes the rim of `tile`, each side from its own samples alone. `place` says whether the tile lies at the
    /// raster's right and lower rim.
    ///
    /// Every vertex keeps the height of its sample; every link is within `tolerance` at the samples it passes, where the
    /// tile has weights within [`Tile::limit`], and where it has channels its weighted error is within
    /// [`ChannelError::limit`].
    ///
    /// `points` are samples that must be vertices, as column and row of the tile, each once, by rows, then by columns.
    /// Those on a side become vertices of the side, so neighbours agree where both are given the points of their
    /// windows; corners are vertices anyway; the others become the domain's points, or vertices of its loops. All lie on
    /// the ground.
    ///
    /// [`ChannelError::limit`]: crate::base::channels::ChannelError::limit
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If a point is outside the tile.
    pub fn new(
        tile: &Tile,
        tolerance: f64,
        points: &[(usize, usize)],
        place: &TilePlace,
        min_link: &mut MinLink,
        cancel: &CancelToken,
    ) -> Result<Rim, Cancelled> {
        Rim::with_sides(tile, tolerance, Sides::FINAL, points, &TileChains::default(), place, min_link, cancel)
    }

    /// The same with sides that later passes change. Beside a side that leaves its samples as far as may be triangles have nothing
    /// left, and slivers follow, so these are held to a share of the tolerance. Beside a short link that is in the way of what samples
    /// ask for, that is inside of a tile of another grid. Where ground is on one side of a line between tiles only, nobody changes
    /// the side: it has all of the tolerance, and short links of two cells.
    ///
    /// `chains` are edges that the mesh must have. Those along a side are edges of it, ends on a side are vertices of it, between
    /// samples, too. The others become the domain's edges.
    ///
    /// # Errors
    /// As [`Rim::new`].
    ///
    /// # Panics
    /// As [`Rim::new`].
    #[allow(clippy::too_many_arguments)]
    pub fn with_sides(
        tile: &Tile,
        tolerance: f64,
        sides: Sides,
        points: &[(usize, usize)],
        chains: &TileChains,
        place: &TilePlace,
        min_link: &mut MinLink,
        cancel: &CancelToken,
    ) -> Result<Rim, Cancelled> {
        let mut rim = Rim::over(&mut Runs::new(tile, tolerance, sides, min_link, cancel), points, chains, place)?;
        rim.take_edges(tile, chains);
        Ok(rim)
    }

    /// Computes the rim that `tile` has at any tolerance: where [`Rim::new`] takes the fewest links, it has nested vertices
    /// ([`levels`](super::levels)), those that `keeps` wants. All others are there whatever is wanted.
    ///
    /// Runs are split until they are within `tolerance`, [`Tile::limit`] where the tile has weights; levels are errors,
    /// times weights. `points` and the rest are as for [`Rim::new`].
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If a point is outside the tile.
    pub fn nested(
        tile: &Tile,
        tolerance: f64,
        points: &[(usize, usize)],
        place: &TilePlace,
        keeps: impl Fn(LateVertex) -> bool,
        cancel: &CancelToken,
    ) -> Result<NestedRim, Cancelled> {
        let mut runs = Runs::nested(tile, tolerance, &keeps, cancel);
        let rim = Rim::over(&mut runs, points, &TileChains::default(), place)?;
        let by_sample = runs.into_late();
        let find = |vertex: &Vertex| {
            let (column, row) = vertex.at.sample()?;
            let sample = (row * tile.width() + column) as u32;
            by_sample.binary_search_by_key(&sample, |(sample, _)| *sample).ok().map(|i| by_sample[i].1)
        };
        let late = (0..).zip(&rim.domain.vertices).filter_map(|(i, v)| find(v).map(|late| (i, late))).collect();
        let late_idle = rim.idle.iter().filter_map(|(_, v)| find(v)).collect();
        Ok(NestedRim { rim, late, late_idle })
    }

    fn over(
        runs: &mut Runs<'_>,
        points: &[(usize, usize)],
        chains: &TileChains,
        place: &TilePlace,
    ) -> Result<Rim, Cancelled> {
        let tile = runs.tile;
        let (right, bottom) = (tile.width() - 1, tile.height() - 1);
        let forced = Forced::new(points, chains, right, bottom);
        if !tile.validity.is_whole() {
            return ground::rim(runs, &forced, chains, place);
        }
        let mut side = |len: usize, forced: &[usize], side: Side, place: &dyn Fn(usize) -> (usize, usize)| {
            let hold = runs.on_side(len);
            let on_side = OnSide::new(chains, side, tile.far_corner());
            let between = runs.between(len, &on_side.force(forced), hold, place)?;
            Ok::<Vec<Vertex>, Cancelled>(on_side.merge(between.into_iter().map(|i| vertex(tile, place(i)))))
        };
        let north = side(tile.width(), &forced.north, Side::North, &|i| (i, 0))?;
        let south = side(tile.width(), &forced.south, Side::South, &|i| (i, bottom))?;
        let west = side(tile.height(), &forced.west, Side::West, &|i| (0, i))?;
        let east = side(tile.height(), &forced.east, Side::East, &|i| (right, i))?;
        Ok(Rim::assemble(tile, [north, west, east, south], place, &forced.inside))
    }

    /// How many vertices of the domain stand on the sides of the tile: they come first.
    pub fn on_sides(&self) -> usize {
        self.owned.total() as usize - self.idle.len() + self.foreign.len()
    }

    /// Puts corners, sides (north, west, east, south) and the points inside together.
    fn assemble(
        tile: &Tile,
        [north, west, east, south]: [Vec<Vertex>; 4],
        place: &TilePlace,
        inside: &[(usize, usize)],
    ) -> Rim {
        let mine = |_| unreachable!("every tile owns its first corner, its north and its west side");
        let corner = |corner: Corner, name| {
            let owned = corner.name(place).is_none();
            Feature { vertices: vec![vertex(tile, corner.place(tile))], owned, name }
        };
        // In the order in which a tile numbers what it owns.
        let features: [Feature; 8] = [
            corner(Corner::NorthWest, mine),
            corner(Corner::NorthEast, |_| Foreign::NorthEast),
            corner(Corner::SouthWest, |_| Foreign::SouthWest),
            corner(Corner::SouthEast, |_| Foreign::SouthEast),
            Feature { vertices: north, owned: true, name: mine },
            Feature { vertices: west, owned: true, name: mine },
            Feature { vertices: east, owned: place.last_column, name: Foreign::East },
            Feature { vertices: south, owned: place.last_row, name: Foreign::South },
        ];
        let (mut vertices, mut foreign) = (Vec::new(), Vec::new());
        let mut numbers: [Range<u32>; 8] = Default::default();
        for round_of_owned in [true, false] {
            for (number, feature) in numbers.iter_mut().zip(&features).filter(|(_, f)| f.owned == round_of_owned) {
                *number = vertices.len() as u32..(vertices.len() + feature.vertices.len()) as u32;
                vertices.extend_from_slice(&feature.vertices);
                if !feature.owned {
                    foreign.extend((0..feature.vertices.len() as u32).map(feature.name));
                }
            }
        }
        let owned = |i: usize| if features[i].owned { features[i].vertices.len() as u32 } else { 0 };
        let owned = RimCounts {
            corners: Corner::ALL.into_iter().filter(|c| c.name(place).is_none()).map(Corner::bit).sum(),
            north: owned(4),
            west: owned(5),
            east: owned(6),
            south: owned(7),
        };
        // North side eastwards, east side down, south side back, west side up: the ground stays to the left.
        let [nw, ne, sw, se, north, west, east, south] = numbers;
        let there = nw.chain(north).chain(ne).chain(east);
        let walk = there.chain(se).chain(south.rev()).chain(sw).chain(west.rev()).collect();
        let points = inside.iter().map(|&place| vertex(tile, place)).collect();
        let domain = Domain { vertices, loops: vec![walk], points, ..Domain::default() };
        Rim { domain, owned, idle: Vec::new(), foreign }
    }

    /// Gives the domain the edges of chains, and those ends of them that no loop has. An edge along a side of the tile is one of a
    /// loop, or it has no ground in this tile.
    fn take_edges(&mut self, tile: &Tile, chains: &TileChains) {
        if chains.vertices().is_empty() {
            return;
        }
        let (far, domain) = (tile.far_corner(), &mut self.domain);
        let is_along_side =
            |[p, q]: [Point; 2]| p.x == q.x && (p.x == 0 || p.x == far.x) || p.y == q.y && (p.y == 0 || p.y == far.y);
        let is_on_side = |p: Point| is_along_side([p, p]);
        let mut there: Vec<(i32, i32)> = domain.vertices.iter().map(|v| (v.at.y, v.at.x)).collect();
        there.sort_unstable();
        // One on a side is a vertex of it, if there is ground.
        let is_new = |v: &&Vertex| !is_on_side(v.at) && there.binary_search(&(v.at.y, v.at.x)).is_err();
        domain.vertices.extend(chains.vertices().iter().filter(is_new));
        let loops = loop_edges(domain);
        let edges = chains.numbered(domain.vertices.iter().copied());
        domain.edges = edges
            .into_iter()
            .filter(|&(a, b)| {
                let is_of_loop = loops.binary_search(&(a, b)).is_ok() || loops.binary_search(&(b, a)).is_ok();
                is_of_loop || !is_along_side([a, b].map(|v| domain.vertices[v as usize].at))
            })
            .collect();
    }
}

/// A side of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The first row.
    North,
    /// The first column.
    West,
    /// The last column.
    East,
    /// The last row.
    South,
}

/// A vertex of a nested rim that is not there from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LateVertex {
    /// The side that it is on; none for one of the loops inside the tile.
    pub side: Option<Side>,
    /// Its place along the side, in samples from the lower coordinate; inside the tile row · width + column.
    pub at: usize,
    /// The error below which it is there, see [`Level`](super::Level).
    pub level: f64,
}

/// A nested rim.
#[derive(Debug, Clone, Default)]
pub struct NestedRim {
    /// The rim.
    pub rim: Rim,
    /// Which vertices of its domain are not there from the start, ascending.
    pub late: Vec<(u32, LateVertex)>,
    /// Which of the idle ones are not.
    pub late_idle: Vec<LateVertex>,
}

/// A corner of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corner {
    NorthWest,
    NorthEast,
    SouthWest,
    SouthEast,
}

impl Corner {
    /// In the order in which a tile numbers those that it owns.
    pub(super) const ALL: [Corner; 4] = [Corner::NorthWest, Corner::NorthEast, Corner::SouthWest, Corner::SouthEast];

    /// In [`RimCounts::corners`].
    pub(super) fn bit(self) -> u32 {
        1 << self as u32
    }

    pub(super) fn place(self, tile: &Tile) -> (usize, usize) {
        let (right, bottom) = (tile.width() - 1, tile.height() - 1);
        match self {
            Corner::NorthWest => (0, 0),
            Corner::NorthEast => (right, 0),
            Corner::SouthWest => (0, bottom),
            Corner::SouthEast => (right, bottom),
        }
    }

    /// What it is called, unless the tile owns it.
    pub(super) fn name(self, place: &TilePlace) -> Option<Foreign> {
        match self {
            Corner::NorthWest => None,
            Corner::NorthEast => (!place.last_column).then_some(Foreign::NorthEast),
            Corner::SouthWest => (!place.last_row).then_some(Foreign::SouthWest),
            Corner::SouthEast => (!(place.last_column && place.last_row)).then_some(Foreign::SouthEast),
        }
    }
}

/// Points by where they lie in a tile; on a side, by their place along it. Those at corners are on two sides.
#[derive(Default)]
pub(super) struct Forced {
    pub(super) north: Vec<usize>,
    pub(super) south: Vec<usize>,
    pub(super) west: Vec<usize>,
    pub(super) east: Vec<usize>,
    pub(super) inside: Vec<(usize, usize)>,
    /// Samples that chains need as vertices where the ground ends there: at ends of edges inside the tile, or on either side of one.
    pub(super) of_chains: Vec<(usize, usize)>,
}

impl Forced {
    fn new(points: &[(usize, usize)], chains: &TileChains, right: usize, bottom: usize) -> Forced {
        let mut forced = Forced { of_chains: beside(chains), ..Forced::default() };
        for &(column, row) in points {
            assert!(column <= right && row <= bottom, "point {column}, {row} in a tile up to {right}, {bottom}");
            let mut on_side = false;
            for (is_there, side, along) in [
                (row == 0, &mut forced.north, column),
                (row == bottom, &mut forced.south, column),
                (column == 0, &mut forced.west, row),
                (column == right, &mut forced.east, row),
            ] {
                if is_there {
                    side.push(along);
                    on_side = true;
                }
            }
            // Ends of edges are vertices of their own.
            if !on_side && chains.at(Point::of_sample(column as i32, row as i32)).is_none() {
                forced.inside.push((column, row));
            }
        }
        forced
    }
}

/// The samples at ends of edges, and on either side of those between two of a row or a column.
fn beside(chains: &TileChains) -> Vec<(usize, usize)> {
    let around = |v: &Vertex| {
        let Point { x, y } = v.at;
        let low = (x.div_euclid(STEPS) as usize, y.div_euclid(STEPS) as usize);
        let high = ((x + STEPS - 1).div_euclid(STEPS) as usize, (y + STEPS - 1).div_euclid(STEPS) as usize);
        let is_in_cell = low.0 < high.0 && low.1 < high.1;
        [low, high].into_iter().filter(move |_| !is_in_cell)
    };
    chains.vertices().iter().flat_map(around).collect()
}

/// A corner or the inside of a side.
struct Feature {
    vertices: Vec<Vertex>,
    owned: bool,
    /// What a vertex is called where it is not owned, by its ordinal.
    name: fn(u32) -> Foreign,
}

/// Column and row of a sample, by its number in a tile.
pub(super) fn place_of(tile: &Tile, sample: u32) -> (usize, usize) {
    (sample as usize % tile.width(), sample as usize / tile.width())
}

pub(super) fn vertex(tile: &Tile, (column, row): (usize, usize)) -> Vertex {
    Vertex { at: Point::of_sample(column as i32, row as i32), height: tile.at(column, row) }
}

#[cfg(test)]
mod tests;
