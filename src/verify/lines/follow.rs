//! Whether edges of the mesh lead along a stretch of a line.

use std::collections::HashMap;

use num_bigint::BigInt;
use num_rational::BigRational;

use super::heights::{Crossing, Samples, for_each_crossing};
use super::required::SetBits;
use super::{RequiredLines, Spot};
use crate::verify::exact::rational;

/// What edges along a line are held to.
pub(super) struct Wall<'a> {
    pub(super) samples: &'a Samples,
    pub(super) tolerance: f64,
    pub(super) lines: &'a RequiredLines,
    /// The height of the mesh's vertex at a place of a line.
    pub(super) height: &'a dyn Fn(Spot) -> Option<f64>,
}

/// An interpolated height: Σ weight · height, over the sum of weights.
struct Mean<const N: usize>([(i64, f64); N]);

impl<const N: usize> Mean<N> {
    fn rounded(&self) -> (f64, f64) {
        let all: i64 = self.0.iter().map(|(w, _)| w).sum();
        let sum: f64 = self.0.iter().map(|&(w, z)| w as f64 * z).sum();
        let size: f64 = self.0.iter().map(|&(w, z)| (w as f64 * z).abs()).sum();
        (sum / all as f64, size / all as f64)
    }

    fn exact(&self) -> BigRational {
        let whole = |w: i64| BigRational::from_integer(BigInt::from(w));
        let all: BigRational = self.0.iter().map(|&(w, _)| whole(w)).sum();
        self.0.iter().map(|&(w, z)| whole(w) * rational(z)).sum::<BigRational>() / all
    }
}

/// A bound of what rounding does to the difference of two means, as a share of their sizes.
const DOUBT: f64 = 1e-14;

impl Wall<'_> {
    /// How many edges lead from the first place of a stretch of these sets to its last, at the fewest. In a ring they may begin at any
    /// place, and lead around to it.
    ///
    /// # Errors
    /// The number of the last place that edges lead to.
    pub(super) fn follow(
        &self,
        stretch: &[Spot],
        sets: SetBits,
        beside: &HashMap<Spot, Vec<Spot>>,
    ) -> Result<u64, usize> {
        let found = self.follow_from_first(stretch, sets, beside);
        let last = stretch.len() - 1;
        if found.is_ok() || stretch[0] != stretch[last] {
            return found;
        }
        // Where the ring's first place is no vertex of the way, an edge passes over it.
        let places = &stretch[..last];
        let numbers: HashMap<Spot, usize> = places.iter().enumerate().map(|(i, spot)| (*spot, i)).collect();
        let ends = |from: usize| {
            let ends = beside.get(&places[from]).into_iter().flatten().filter_map(|spot| numbers.get(spot));
            ends.copied().filter(move |&to| 0 < to && to < from).map(move |to| (from, to))
        };
        let mut over_first: Vec<(usize, usize)> = (1..last).flat_map(ends).collect();
        over_first.sort_unstable_by_key(|&(from, to)| (last - from + to, to));
        let turned = |from: usize| {
            let mut turned = places.to_vec();
            turned.rotate_left(from);
            turned.push(places[from]);
            turned
        };
        let mut tried = None;
        for (from, to) in over_first {
            let turned = turned(from);
            if tried != Some(from) && self.allows(&turned[..=last - from + to], sets) {
                tried = Some(from);
                if let Ok(edges) = self.follow_from_first(&turned, sets, beside) {
                    return Ok(edges);
                }
            }
        }
        found
    }

    /// The same from the first place alone.
    fn follow_from_first(
        &self,
        stretch: &[Spot],
        sets: SetBits,
        beside: &HashMap<Spot, Vec<Spot>>,
    ) -> Result<u64, usize> {
        let last = stretch.len() - 1;
        let mut numbers: HashMap<Spot, usize> = stretch.iter().enumerate().map(|(i, spot)| (*spot, i)).collect();
        // A ring comes back to its first place.
        numbers.insert(stretch[last], last);
        let mut edges = vec![None; last + 1];
        edges[0] = Some(0u64);
        for from in 0..last {
            let Some(so_far) = edges[from] else { continue };
            for to in beside.get(&stretch[from]).into_iter().flatten().filter_map(|spot| numbers.get(spot).copied()) {
                let is_ring = stretch[0] == stretch[last] && from == 0 && to == last;
                let is_shorter = edges[to].is_none_or(|edges| so_far + 1 < edges);
                if to > from && !is_ring && is_shorter && self.allows(&stretch[from..=to], sets) {
                    edges[to] = Some(so_far + 1);
                }
            }
        }
        edges[last].ok_or_else(|| edges.iter().rposition(Option::is_some).unwrap_or(0))
    }

    /// Whether the edge from the first of these places to the last may stand for them.
    fn allows(&self, places: &[Spot], sets: SetBits) -> bool {
        let sets = || (0..).zip(&self.lines.sets).filter(|(set, _)| sets >> set & 1 == 1).map(|(_, set)| set);
        let shift = sets().map(|set| set.shift).fold(f64::INFINITY, f64::min);
        let (a, b) = (places[0], places[places.len() - 1]);
        let (Some(from), Some(to)) = ((self.height)(a), (self.height)(b)) else { return false };
        let mut is_within = self.is_near_target(a, from) && self.is_near_target(b, to);
        is_within = is_within && places.iter().all(|&place| is_near(shift, place, a, b));
        if sets().any(|set| set.has_heights) {
            is_within = is_within && places.iter().all(|&place| self.is_near_level(place, (a, from), (b, to)));
        } else if is_within {
            for_each_crossing(a, b, |crossing| is_within = is_within && self.holds(&crossing, from, to));
        }
        is_within
    }

    /// Whether a vertex is within the tolerance of a line's own height, or where there is none of the bilinear surface.
    fn is_near_target(&self, spot: Spot, height: f64) -> bool {
        match self.lines.levels.get(&spot) {
            Some(&level) => self.is_within(&Mean([(1, level)]), &Mean([(1, height)])),
            None => self.is_near_surface(spot, height),
        }
    }

    /// Whether an edge is within the tolerance of a line's own height at one of its places, where the edge is nearest to it.
    fn is_near_level(&self, place: Spot, (a, from): (Spot, f64), (b, to): (Spot, f64)) -> bool {
        let Some(&level) = self.lines.levels.get(&place) else { return false };
        let (u, v) = ((b.0 - a.0, b.1 - a.1), (place.0 - a.0, place.1 - a.1));
        let all = u.0 * u.0 + u.1 * u.1;
        let done = (u.0 * v.0 + u.1 * v.1).clamp(0, all);
        self.is_within(&Mean([(1, level)]), &Mean([(all - done, from), (done, to)]))
    }

    /// Whether a vertex is within the tolerance of the bilinear surface.
    fn is_near_surface(&self, (x, y): Spot, height: f64) -> bool {
        let ((column, right), (row, below)) = ((x >> 2, x & 3), (y >> 2, y & 3));
        let weights = [
            (0, 0, (4 - right) * (4 - below)),
            (0, 1, right * (4 - below)),
            (1, 0, (4 - right) * below),
            (1, 1, right * below),
        ];
        let mut corners = [(0, 0.0); 4];
        for (corner, (down, across, weight)) in corners.iter_mut().zip(weights).filter(|(_, w)| w.2 > 0) {
            let Some(sample) = self.samples.height(row + down, column + across) else { return false };
            *corner = (weight, sample);
        }
        self.is_within(&Mean(corners), &Mean([(1, height)]))
    }

    fn holds(&self, crossing: &Crossing, from: f64, to: f64) -> bool {
        let &Crossing { sample: (row, column), part: (part, all), done, is_column } = crossing;
        let next = if is_column { (row + 1, column) } else { (row, column + 1) };
        let (before, after) = (self.samples.height(row, column), self.samples.height(next.0, next.1));
        // At a sample the next one does not matter.
        let (Some(before), Some(after)) = (before, if part == 0 { Some(0.0) } else { after }) else { return false };
        self.is_within(&Mean([(all - part, before), (part, after)]), &Mean([(all - done, from), (done, to)]))
    }

    fn is_within<const N: usize, const M: usize>(&self, a: &Mean<N>, b: &Mean<M>) -> bool {
        let ((x, x_size), (y, y_size)) = (a.rounded(), b.rounded());
        let over = (x - y).abs() - self.tolerance;
        if over.abs() > (x_size + y_size + self.tolerance) * DOUBT {
            return over < 0.0;
        }
        let (off, tolerance) = (a.exact() - b.exact(), rational(self.tolerance));
        -&tolerance <= off && off <= tolerance
    }
}

/// Whether a place is within a shift, in cells, of an edge.
fn is_near(shift: f64, place: Spot, a: Spot, b: Spot) -> bool {
    let parts = i128::from((shift * 65536.0).floor() as i64);
    let (u, v) =
        ((i128::from(b.0 - a.0), i128::from(b.1 - a.1)), (i128::from(place.0 - a.0), i128::from(place.1 - a.1)));
    let (length2, along) = (u.0 * u.0 + u.1 * u.1, (u.0 * v.0 + u.1 * v.1));
    // From the nearest point of the edge, all times the square of its length.
    let along = along.clamp(0, length2);
    let off = (v.0 * length2 - along * u.0, v.1 * length2 - along * u.1);
    // Quarter cells against parts of a cell: 16384 parts each.
    let limit = parts * length2;
    (off.0 * off.0 + off.1 * off.1) * (16384 * 16384) <= limit * limit
}
