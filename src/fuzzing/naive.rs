//! Every sample against every triangle, in whole numbers of any size: nothing here is shared with engines or verifier.

use std::collections::BTreeSet;

use num_bigint::BigInt;

type Place = (i64, i64);

/// Samples row by row: NaN where there is no height. No weights where all errors weigh 1.
pub(super) struct Ground<'a> {
    width: usize,
    height: usize,
    heights: &'a [f64],
    weights: &'a [f64],
    /// Samples of bridged holes: on the ground, at any height.
    bridged: BTreeSet<Place>,
    /// What is at most so many columns and rows from a missing sample may be bare.
    trim: i64,
}

/// Vertices on the lattice of quarter cells, faces counter-clockwise on a north-up map.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub(super) places: Vec<Place>,
    pub(super) heights: Vec<f64>,
    pub(super) faces: Vec<[usize; 3]>,
}

/// The lattice point nearest to map coordinates of the default geotransform.
pub(super) fn place(x: f64, y: f64) -> Place {
    (((x - 0.5) * 4.0).round() as i64, ((-y - 0.5) * 4.0).round() as i64)
}

fn orient(a: Place, b: Place, c: Place) -> i128 {
    let difference = |p: Place, q: Place| (i128::from(q.0) - i128::from(p.0), i128::from(q.1) - i128::from(p.1));
    let ((ux, uy), (vx, vy)) = (difference(a, b), difference(a, c));
    ux * vy - uy * vx
}

/// A double times 2¹⁰⁷⁴, which is a whole number.
fn scaled(value: f64) -> BigInt {
    let (bits, sign) = (value.abs().to_bits(), if value < 0.0 { -1 } else { 1 });
    let (exponent, fraction) = (bits >> 52, bits & ((1 << 52) - 1));
    let (mantissa, shift) = if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 52, exponent - 1) };
    (BigInt::from(mantissa) << shift) * sign
}

impl<'a> Ground<'a> {
    pub(super) fn new((width, height): (usize, usize), heights: &'a [f64], weights: &'a [f64]) -> Ground<'a> {
        Ground { width, height, heights, weights, bridged: BTreeSet::new(), trim: 0 }
    }

    /// The same with holes of at most so many samples bridged: missing samples, eight neighbours to each, none on the edge.
    pub(super) fn bridging(mut self, most: usize) -> Ground<'a> {
        let mut left: BTreeSet<Place> = self.places().filter(|&(c, r)| !self.is_valid(c, r)).collect();
        while let Some(start) = left.pop_first() {
            let (mut hole, mut open) = (vec![start], vec![start]);
            while let Some((column, row)) = open.pop() {
                let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (column + dx, row + dy)));
                let found: Vec<Place> = around.filter(|place| left.remove(place)).collect();
                hole.extend(&found);
                open.extend(found);
            }
            let at_edge = |&(column, row): &Place| {
                column == 0 || row == 0 || column == self.width as i64 - 1 || row == self.height as i64 - 1
            };
            if hole.len() <= most && !hole.iter().any(at_edge) {
                self.bridged.extend(hole);
            }
        }
        self
    }

    /// The same with a rim that may be trimmed by so many cells.
    pub(super) fn trimmed(self, cells: u32) -> Ground<'a> {
        Ground { trim: i64::from(cells), ..self }
    }

    fn places(&self) -> impl Iterator<Item = Place> + use<> {
        let (width, height) = (self.width as i64, self.height as i64);
        (0..height).flat_map(move |row| (0..width).map(move |column| (column, row)))
    }

    fn has_height(&self, column: i64, row: i64) -> bool {
        !self.heights[row as usize * self.width + column as usize].is_nan()
    }

    /// Whether a sample counts as there: with a height, or bridged.
    pub(super) fn is_valid(&self, column: i64, row: i64) -> bool {
        let inside = column >= 0 && row >= 0 && column < self.width as i64 && row < self.height as i64;
        inside && (self.has_height(column, row) || self.bridged.contains(&(column, row)))
    }

    /// Whether a sample may be bare although it is on the ground.
    fn is_in_strip(&self, (column, row): Place) -> bool {
        let mut around = (-self.trim..=self.trim).flat_map(|dy| (-self.trim..=self.trim).map(move |dx| (dx, dy)));
        let is_missing = |column: i64, row: i64| {
            let inside = column >= 0 && row >= 0 && column < self.width as i64 && row < self.height as i64;
            inside && !self.is_valid(column, row)
        };
        self.trim > 0 && around.any(|(dx, dy)| is_missing(column + dx, row + dy))
    }

    /// Whether none of a cell may be bare.
    fn is_core(&self, cell: Place) -> bool {
        self.valid_corners(cell) == 4 && !Self::corners(cell).iter().any(|&corner| self.is_in_strip(corner))
    }

    /// Corners of a cell, around.
    fn corners((c, r): Place) -> [Place; 4] {
        [(c, r), (c + 1, r), (c + 1, r + 1), (c, r + 1)]
    }

    fn valid_corners(&self, cell: Place) -> usize {
        Self::corners(cell).iter().filter(|p| self.is_valid(p.0, p.1)).count()
    }

    fn cells(&self) -> impl Iterator<Item = Place> {
        let (width, height) = (self.width as i64 - 1, self.height as i64 - 1);
        (0..height).flat_map(move |row| (0..width).map(move |column| (column, row)))
    }

    /// Whether a sample has a height and lies in a cell with three.
    pub(super) fn is_ground(&self, column: i64, row: i64) -> bool {
        let around = [(column, row), (column - 1, row), (column, row - 1), (column - 1, row - 1)];
        self.is_valid(column, row) && around.iter().any(|&cell| self.valid_corners(cell) >= 3)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.cells().all(|cell| self.valid_corners(cell) < 3)
    }

    /// What is wrong with a surface over this ground.
    pub(super) fn check(&self, surface: &Surface, tolerance: f64) -> Result<(), String> {
        let Surface { places, heights, faces } = surface;
        if let Some(wrong) = heights.iter().find(|z| !z.is_finite()) {
            return Err(format!("a vertex at height {wrong}"));
        }
        // Rows run down, so the map's sense of turning is not the lattice's.
        let turned: Vec<[usize; 3]> = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
        self.check_shape(places, &turned)?;
        self.check_cover(places, &turned)?;
        let tolerance = scaled(tolerance);
        for (row, column) in (0..self.height as i64).flat_map(|r| (0..self.width as i64).map(move |c| (r, c))) {
            let (p, mut covered) = ((4 * column, 4 * row), false);
            for face in &turned {
                let [a, b, c] = face.map(|v| places[v]);
                let weights = [orient(p, b, c), orient(a, p, c), orient(a, b, p)];
                if weights.iter().any(|w| *w < 0) {
                    continue;
                }
                if !self.is_valid(column, row) {
                    return Err(format!("sample {column}, {row} has no height and is covered"));
                }
                covered = true;
                let index = row as usize * self.width + column as usize;
                if !self.has_height(column, row) {
                    continue;
                }
                let area = BigInt::from(orient(a, b, c));
                let terms = weights.iter().zip(face).map(|(&w, &v)| scaled(heights[v]) * BigInt::from(w));
                let error = terms.sum::<BigInt>() - scaled(self.heights[index]) * &area;
                let error = if error < BigInt::ZERO { -error } else { error };
                let limit = &tolerance * area;
                let is_within = match self.weights.get(index) {
                    None => error <= limit,
                    Some(&weight) => error * scaled(weight) <= limit << 1074,
                };
                if !is_within {
                    return Err(format!("sample {column}, {row} is too far"));
                }
            }
            if covered != self.is_ground(column, row) && (covered || !self.is_in_strip((column, row))) {
                return Err(format!("sample {column}, {row} is covered: {covered}"));
            }
        }
        Ok(())
    }

    /// Turns, area, edges and vertices.
    fn check_shape(&self, places: &[Place], faces: &[[usize; 3]]) -> Result<(), String> {
        let (mut edges, mut area) = (BTreeSet::new(), 0);
        for &[a, b, c] in faces {
            let turn = orient(places[a], places[b], places[c]);
            if turn <= 0 {
                return Err(format!("a face that turns by {turn}"));
            }
            area += turn;
            for edge in [(a, b), (b, c), (c, a)] {
                if !edges.insert(edge) {
                    return Err(format!("edge {edge:?} twice"));
                }
            }
        }
        let ground: i128 = self.cells().map(|cell| [0, 0, 0, 16, 32][self.valid_corners(cell)]).sum();
        let core = 32 * self.cells().filter(|&cell| self.is_core(cell)).count() as i128;
        let least = if self.trim == 0 { ground } else { core };
        if !(least..=ground).contains(&area) {
            return Err(format!("an area of {area} instead of {least} to {ground}"));
        }
        for &(a, b) in edges.iter().filter(|&&(a, b)| !edges.contains(&(b, a))) {
            let (p, q) = (places[a], places[b]);
            let between = |v: &Place| {
                let (along, back) = ((q.0 - p.0) * (v.0 - p.0) + (q.1 - p.1) * (v.1 - p.1), (p.0 - q.0, p.1 - q.1));
                orient(p, q, *v) == 0 && along > 0 && back.0 * (v.0 - q.0) + back.1 * (v.1 - q.1) > 0
            };
            if let Some(v) = places.iter().find(|v| between(v)) {
                return Err(format!("vertex {v:?} in the midst of edge {p:?} {q:?}"));
            }
        }
        let used: BTreeSet<usize> = faces.iter().flatten().copied().collect();
        let apart: BTreeSet<Place> = places.iter().copied().collect();
        if used.len() != places.len() || apart.len() != places.len() {
            return Err(format!("{} vertices at {} places, {} in use", places.len(), apart.len(), used.len()));
        }
        Ok(())
    }

    /// Points near the corners of every cell are in one face, or in none where there is no ground.
    fn check_cover(&self, places: &[Place], faces: &[[usize; 3]]) -> Result<(), String> {
        const FINE: i64 = 1000;
        let fine: Vec<Place> = places.iter().map(|&(x, y)| (FINE * x, FINE * y)).collect();
        for cell in self.cells() {
            let corners = Self::corners(cell);
            let missing: Vec<usize> = (0..4).filter(|&i| !self.is_valid(corners[i].0, corners[i].1)).collect();
            for (i, &(column, row)) in corners.iter().enumerate() {
                let expected = match missing[..] {
                    [] => 1,
                    [m] if m == i => 0,
                    [m] if (m + 2) % 4 == i => 1,
                    // Along the half cell's long side.
                    [_] => continue,
                    _ => 0,
                };
                let (dx, dy) = [(857, 691), (-857, 691), (-857, -691), (857, -691)][i];
                let p = (4 * FINE * column + dx, 4 * FINE * row + dy);
                let turns = |f: &[usize; 3]| {
                    let [a, b, c] = f.map(|v| fine[v]);
                    [orient(p, b, c), orient(a, p, c), orient(a, b, p)]
                };
                if faces.iter().any(|f| turns(f).iter().all(|t| *t >= 0) && turns(f).contains(&0)) {
                    continue;
                }
                let found = faces.iter().filter(|f| turns(f).iter().all(|t| *t > 0)).count();
                let is_trimmed = found == 0 && self.trim > 0 && !self.is_core(cell);
                if found != expected && !is_trimmed {
                    return Err(format!("{found} faces instead of {expected} at corner {i} of cell {cell:?}"));
                }
            }
        }
        Ok(())
    }
}
