//! Canonical subsets of the samples: squares that a plane, or two triangles at samples, is within the tolerance of.

use super::plane::{self, Plane, Region};
use super::{Corners, sliding};
use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::kernel::quantum::Quantum;
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::feasible::Tester;

/// Which squares are canonical subsets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Squares {
    /// The nodes of a quadtree (the paper's section 5). The maximal valid ones are the least cover.
    #[default]
    Nested,
    /// Squares of any size at any place; a cover is chosen greedily.
    Sliding,
}

/// Samples that belong together: a square of them, cut off at the tile's last column and row. The surface over it is two
/// triangles whose corners are at the samples at its corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Column and row of the first sample.
    pub first: (usize, usize),
    /// Of the last.
    pub last: (usize, usize),
    /// The surface's heights at the corners: upper left, upper right, lower right, lower left.
    pub heights: [f64; 4],
    /// Whether the two triangles share the diagonal from the upper left to the lower right; else the other one.
    pub falling: bool,
}

impl Square {
    pub(super) fn region(&self) -> Region {
        Region { first: self.first, last: self.last }
    }

    /// Whether it is more than one sample.
    pub(super) fn is_wide(&self) -> bool {
        self.first != self.last
    }

    /// Upper left, upper right, lower right, lower left.
    pub(super) fn corners(&self) -> [Vertex; 4] {
        let places = self.region().corners();
        [0, 1, 2, 3].map(|i| vertex(places[i], self.heights[i]))
    }
}

/// A vertex at a sample.
pub(super) fn vertex((column, row): (usize, usize), height: f64) -> Vertex {
    Vertex { at: Point::of_sample(column as i32, row as i32), height }
}

/// What was met while squares were looked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Squares that four of their samples exclude, exactly.
    pub certified: usize,
    /// Squares that were refused without such a proof: two triangles of samples do not fit, or rounding of heights decided.
    pub undecided: usize,
    /// Subsets of more than one sample that are one sample wide or tall.
    pub thin: usize,
    /// Subsets of one sample.
    pub single: usize,
}

/// Subsets whose squares share no sample and hold all of them.
#[derive(Debug, Clone, Default)]
pub struct Partition {
    /// The squares.
    pub squares: Vec<Square>,
    /// What was met on the way.
    pub counts: Counts,
}

impl Partition {
    /// The size of the simplicial partition as the paper's Table 1 has it (SP-A with [`Corners::Free`], SP-B with
    /// [`Corners::Samples`]): two triangles for every square, and one for a subset that is one sample wide, which any
    /// triangle with an edge along it covers.
    pub fn triangles(&self) -> usize {
        2 * self.squares.len() - self.counts.thin - self.counts.single
    }
}

/// Divides a tile into canonical subsets. With [`Squares::Sliding`] squares may overlap: a sample belongs to the one
/// chosen first.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// If the tile has missing samples.
pub fn partition(
    tile: &Tile,
    tolerance: f64,
    squares: Squares,
    corners: Corners,
    cancel: &CancelToken,
) -> Result<Partition, Cancelled> {
    assert!(tile.validity().is_whole(), "a partition of samples that are all there");
    let mut finder = Finder::new(tile, tolerance, corners);
    let found = match squares {
        Squares::Nested => finder.nested(Sides::Apart, |_| true, cancel)?,
        Squares::Sliding => sliding::cover(&mut finder, |_| true, cancel)?,
    };
    Ok(finder.counted(found))
}

/// Whether neighbours share samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// No sample is in two squares.
    Apart,
    /// The samples on a side are in the squares on both sides of it.
    Shared,
}

/// Says which regions are valid.
pub(super) struct Finder<'a> {
    pub(super) tile: &'a Tile,
    tester: Tester<'a>,
    pub(super) corners: Corners,
    quantum: Option<Quantum>,
    pub(super) counts: Counts,
}

impl<'a> Finder<'a> {
    pub(super) fn new(tile: &'a Tile, tolerance: f64, corners: Corners) -> Finder<'a> {
        let tester = Tester::new(tile, tolerance, Feasibility::Weak);
        Finder { tile, tester, corners, quantum: Quantum::of(tolerance), counts: Counts::default() }
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.tester.tolerance()
    }

    pub(super) fn counted(&self, squares: Vec<Square>) -> Partition {
        let single = squares.iter().filter(|s| !s.is_wide()).count();
        let thin = squares.iter().filter(|s| s.region().is_thin()).count() - single;
        Partition { squares, counts: Counts { thin, single, ..self.counts } }
    }

    /// The largest valid nodes of a quadtree over the tile, whose sides are powers of two: of these the ones that are
    /// wanted. Cost: O(n log n) expected for n samples, and close to O(n), as large nodes are mostly refused by few
    /// samples.
    pub(super) fn nested(
        &mut self,
        sides: Sides,
        wanted: impl Fn(&Square) -> bool,
        cancel: &CancelToken,
    ) -> Result<Vec<Square>, Cancelled> {
        let lines = self.tile.width().max(self.tile.height());
        let side = if sides == Sides::Apart { lines } else { lines - 1 }.next_power_of_two();
        let (mut found, mut pending) = (Vec::new(), vec![((0, 0), side)]);
        while let Some((first, side)) = pending.pop() {
            cancel.check()?;
            let reach = if sides == Sides::Apart { side - 1 } else { side };
            let last = ((first.0 + reach).min(self.tile.width() - 1), (first.1 + reach).min(self.tile.height() - 1));
            let region = Region { first, last };
            if sides == Sides::Shared && region.is_thin() {
                // Beyond the last line of cells.
                continue;
            }
            if let Some(square) = self.square(region) {
                found.extend(Some(square).filter(&wanted));
            } else if side == 1 {
                found.push(self.at_samples(region));
            } else {
                let half = side / 2;
                let children = [(half, half), (0, half), (half, 0), (0, 0)].map(|(x, y)| (first.0 + x, first.1 + y));
                let is_inside = |&(x, y): &(usize, usize)| x < self.tile.width() && y < self.tile.height();
                pending.extend(children.into_iter().filter(is_inside).map(|first| (first, half)));
            }
        }
        Ok(found)
    }

    /// The square over a region, if it is valid.
    pub(super) fn square(&mut self, region: Region) -> Option<Square> {
        if region.first == region.last {
            return Some(self.at_samples(region));
        }
        if self.corners == Corners::Samples {
            return self.tested(self.at_samples(region));
        }
        match plane::least(self.tile, self.tolerance(), region) {
            Err(_) => {
                self.counts.certified += 1;
                None
            }
            Ok(plane) => self.on_plane(region, &plane),
        }
    }

    /// The square on a plane, its heights rounded, if it passes the exact test. A plane that rounding of heights spoils
    /// may still be that of the samples at the corners.
    fn on_plane(&mut self, region: Region, plane: &Plane) -> Option<Square> {
        let heights = region.corners().map(|place| self.quantum.and_then(|quantum| quantum.round(plane.at(place))));
        let rounded = match heights {
            [Some(a), Some(b), Some(c), Some(d)] => {
                self.tested(Square { heights: [a, b, c, d], ..self.at_samples(region) })
            }
            _ => None,
        };
        let square = rounded.or_else(|| self.tested(self.at_samples(region)));
        self.counts.undecided += usize::from(square.is_none());
        square
    }

    /// With the heights of samples.
    fn at_samples(&self, region: Region) -> Square {
        let heights = region.corners().map(|(column, row)| self.tile.at(column, row));
        Square { first: region.first, last: region.last, heights, falling: true }
    }

    /// The square if its samples are within their limits of it, exactly, with either diagonal. Where samples are
    /// missing nothing is tested: no mesh is made of such a square as it is.
    fn tested(&self, square: Square) -> Option<Square> {
        if !self.tile.validity().is_whole() {
            return Some(square);
        }
        let region = square.region();
        if region.is_thin() {
            return self.holds_line(&square).then_some(square);
        }
        let corners = square.corners();
        let fits = |corner: [usize; 3]| self.tester.weakly_feasible(corner.map(|i| corners[i]));
        if fits([0, 1, 2]) && fits([0, 2, 3]) {
            return Some(square);
        }
        (fits([0, 1, 3]) && fits([1, 2, 3])).then_some(Square { falling: false, ..square })
    }

    /// Whether the samples of a region one sample wide are within their limits of the line between its ends, exactly.
    fn holds_line(&self, square: &Square) -> bool {
        let Region { first, last } = square.region();
        let length = (last.0 - first.0).max(last.1 - first.1);
        let [from, to] = [square.heights[0], square.heights[2]];
        (0..=length).all(|i| {
            let place = if last.0 > first.0 { (first.0 + i, first.1) } else { (first.0, first.1 + i) };
            let terms =
                [((length - i) as i64, from), (i as i64, to), (-(length as i64), self.tile.at(place.0, place.1))];
            crate::base::exact::within(&terms, length as i64, self.tile.limit(place.0, place.1, self.tolerance()))
        })
    }
}
