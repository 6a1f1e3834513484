//! Triangles as they come: kept as they are while there are few, thinned on a grid once there are many.

use rustc_hash::FxHashMap;

use super::{Most, Scene, fewer};

const NONE: u32 = u32::MAX;

/// Gathers a [`Scene`] from the corners of triangles.
///
/// The first `whole` triangles are kept, corners at one place joined. When more come, or are expected, the vertices are put into the
/// squares of a grid over the extent, about four for each triangle of the copy; of the vertices in a square the first stands for all, and
/// triangles that have two corners in a square go. Where twice `whole` triangles are left all the same, squares become twice as large
/// each way. They become as large as it takes to leave no more than [`GIVEN`] triangles for each of the copy: the simplifier takes its
/// time for each. That is known before the first triangle where all vertices were told by then, else in the end.
///
/// Memory: for each triangle of `whole`, 16 bytes of the grid, 24 of triangles and at most 144 of vertices, usually 24; in the end
/// what meshoptimizer takes. With [`Most::OF_A_PAGE`] runs and verdicts took 30 MB more.
#[derive(Debug)]
pub(in crate::run) struct Gatherer {
    most: Most,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    find: Find,
    /// Where vertices are, while more triangles are expected than are kept and none has come.
    seen: Option<Seen>,
    extent: [f64; 4],
    left_out: u64,
}

/// Numbers beyond are shown nowhere: single precision holds those of a frame.
const FAR: f64 = 1e30;

/// As many triangles for each one of the copy are given to the simplifier, about, at most.
const GIVEN: f64 = 1.75;

/// How a corner becomes a vertex.
#[derive(Debug)]
enum Find {
    /// By its bits.
    Place(FxHashMap<[u64; 3], u32>),
    /// By its square: the vertex of each.
    Square(Grid, Vec<u32>),
}

/// A grid of squares over an extent.
#[derive(Debug, Clone, Copy)]
struct Grid {
    corner: (f64, f64),
    /// About so many squares.
    squares: f64,
    /// Squares in a unit of length.
    per_side: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// One of about so many squares.
    fn new([left, bottom, right, top]: [f64; 4], squares: f64) -> Grid {
        let (width, height) = (right - left, top - bottom);
        let even = width.sqrt() * height.sqrt() / squares.sqrt();
        let side = even.max(width.max(height) / squares);
        if !(side > 0.0 && side.is_finite()) {
            return Grid { corner: (left, bottom), squares, per_side: 1.0, columns: 1, rows: 1 };
        }
        let along = |length: f64| (length / side) as usize + 1;
        Grid { corner: (left, bottom), squares, per_side: 1.0 / side, columns: along(width), rows: along(height) }
    }

    /// The square of a place; places beyond the extent are in those at its rim.
    fn square(&self, [x, y, _]: [f64; 3]) -> usize {
        // What is below 0 becomes 0.
        let at = |from: f64, to: f64, count: usize| (((to - from) * self.per_side) as u32 as usize).min(count - 1);
        at(self.corner.1, y, self.rows) * self.columns + at(self.corner.0, x, self.columns)
    }

    /// The middle of a square.
    fn middle(&self, square: usize) -> [f64; 3] {
        let along = |from: f64, at: usize| from + (at as f64 + 0.5) / self.per_side;
        [along(self.corner.0, square % self.columns), along(self.corner.1, square / self.columns), 0.0]
    }

    /// A grid of squares no smaller than these, over the same extent: so large that a surface with vertices at these places has about
    /// `most` triangles at the most whose corners are in three squares.
    fn fitting<P: Iterator<Item = [f64; 3]>>(self, extent: [f64; 4], most: f64, places: impl Fn() -> P) -> Grid {
        let mut grid = self;
        loop {
            let mut seen = Seen::new(grid);
            places().for_each(|place| seen.add(place));
            // A surface has twice as many triangles as vertices.
            if grid.columns * grid.rows == 1 || 2.0 * seen.squares().count() as f64 <= most {
                return grid;
            }
            grid = Grid::new(extent, grid.squares / 1.5);
        }
    }
}

/// Which squares of a grid have something in them.
#[derive(Debug)]
struct Seen {
    grid: Grid,
    /// A bit for each square.
    words: Vec<u64>,
}

impl Seen {
    fn new(grid: Grid) -> Seen {
        Seen { grid, words: vec![0; (grid.columns * grid.rows).div_ceil(64)] }
    }

    fn add(&mut self, place: [f64; 3]) {
        let square = self.grid.square(place);
        self.words[square / 64] |= 1 << (square % 64);
    }

    /// Those that have.
    fn squares(&self) -> impl Iterator<Item = usize> {
        self.words.iter().enumerate().flat_map(|(at, word)| {
            let rest = |word: &u64| Some(word & (word - 1)).filter(|rest| *rest != 0);
            let words = std::iter::successors(Some(*word).filter(|word| *word != 0), rest);
            words.map(move |word| 64 * at + word.trailing_zeros() as usize)
        })
    }
}

impl Gatherer {
    /// Of a mesh between these least and largest x and y.
    pub(in crate::run) fn new(extent: [f64; 4], most: Most) -> Gatherer {
        Gatherer {
            most,
            vertices: Vec::new(),
            triangles: Vec::new(),
            find: Find::Place(FxHashMap::default()),
            seen: None,
            extent,
            left_out: 0,
        }
    }

    /// Before the first triangle and vertex: the mesh has so many triangles.
    pub(in crate::run) fn expect(&mut self, triangles: u64) {
        if triangles > self.most.whole as u64 {
            self.seen = Some(Seen::new(self.first_grid()));
        }
    }

    /// Before the first triangle: where a vertex is. Whoever tells any tells all.
    pub(in crate::run) fn vertex(&mut self, place: [f64; 3]) {
        self.seen.iter_mut().for_each(|seen| seen.add(place));
    }

    /// Begins with triangles, of which more are expected than are kept.
    fn begin(&mut self, seen: &Seen) {
        let places = || seen.squares().map(|square| seen.grid.middle(square));
        self.put_into(seen.grid.fitting(self.extent, self.given(), places));
        // Memory that is not filled is not taken.
        let triangles = self.given() as usize;
        self.triangles.reserve(triangles);
        self.vertices.reserve(triangles / 2);
    }

    /// As many triangles as the simplifier is given, about, at most.
    fn given(&self) -> f64 {
        GIVEN * self.most.copy as f64
    }

    fn first_grid(&self) -> Grid {
        Grid::new(self.extent, 4.0 * self.most.copy as f64)
    }

    /// Takes the next triangle.
    pub(in crate::run) fn triangle(&mut self, corners: [[f64; 3]; 3]) {
        if !corners.as_flattened().iter().all(|number| number.abs() < FAR) {
            self.left_out += 1;
            return;
        }
        if let Some(seen) = self.seen.take() {
            self.begin(&seen);
        }
        self.push(corners);
        if self.triangles.len() > self.limit() {
            self.thin();
        }
    }

    fn push(&mut self, corners: [[f64; 3]; 3]) {
        let Gatherer { vertices, find, .. } = self;
        let triangle = match find {
            Find::Place(numbers) => corners.map(|corner| {
                *numbers.entry(corner.map(f64::to_bits)).or_insert_with(|| {
                    vertices.push(corner);
                    (vertices.len() - 1) as u32
                })
            }),
            Find::Square(grid, of_square) => {
                let squares = corners.map(|corner| grid.square(corner));
                let [a, b, c] = squares;
                if a == b || b == c || c == a {
                    return;
                }
                let mut triangle = [0; 3];
                for (vertex, (square, corner)) in triangle.iter_mut().zip(squares.into_iter().zip(corners)) {
                    let number = &mut of_square[square];
                    if *number == NONE {
                        *number = vertices.len() as u32;
                        vertices.push(corner);
                    }
                    *vertex = *number;
                }
                triangle
            }
        };
        self.triangles.push(triangle);
    }

    /// As many triangles as may be held.
    fn limit(&self) -> usize {
        match self.find {
            Find::Place(_) => self.most.whole,
            Find::Square(..) => 2 * self.most.whole,
        }
    }

    /// Puts vertices together until there is room for as many triangles again as a quarter of the limit.
    fn thin(&mut self) {
        loop {
            let grid = match &self.find {
                Find::Place(_) => self.first_grid(),
                Find::Square(grid, _) => Grid::new(self.extent, grid.squares / 4.0),
            };
            self.put_into(grid);
            self.drop_doubles();
            if self.triangles.len() <= 3 * self.most.whole / 2 {
                return;
            }
        }
    }

    /// Puts what has come into squares.
    fn put_into(&mut self, grid: Grid) {
        let (vertices, triangles) = (std::mem::take(&mut self.vertices), std::mem::take(&mut self.triangles));
        self.find = Find::Square(grid, vec![NONE; grid.columns * grid.rows]);
        triangles.iter().for_each(|triangle| self.push(triangle.map(|vertex| vertices[vertex as usize])));
    }

    /// Of triangles between the same squares one is enough.
    fn drop_doubles(&mut self) {
        for [a, b, c] in &mut self.triangles {
            // The lowest first, turned as before.
            [*a, *b, *c] = if a < b && a < c {
                [*a, *b, *c]
            } else if b < c {
                [*b, *c, *a]
            } else {
                [*c, *a, *b]
            };
        }
        self.triangles.sort_unstable();
        self.triangles.dedup();
    }

    /// What was gathered, of a mesh of so many triangles.
    pub(in crate::run) fn finish(mut self, of: u64) -> Scene {
        if let Find::Square(grid, _) = self.find
            && self.triangles.len() as f64 > self.given()
        {
            let fitting = grid.fitting(self.extent, self.given(), || self.vertices.iter().copied());
            if fitting.squares < grid.squares {
                self.put_into(fitting);
            }
        }
        let Gatherer { most, mut vertices, mut triangles, find, left_out, .. } = self;
        let is_copy = matches!(find, Find::Square(..));
        drop(find);
        if is_copy {
            fewer::reduce(&mut vertices, &mut triangles, most.copy);
        }
        Scene { vertices, triangles, of, left_out, is_copy }
    }

    #[cfg(test)]
    pub(super) fn held(&self) -> (usize, usize) {
        (self.triangles.len(), self.vertices.len())
    }
}
