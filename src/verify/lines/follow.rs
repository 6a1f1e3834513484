//! Whether edges of the mesh lead along a stretch of a line.

use super::Spot;
use super::edges::Edge;
use super::required::{Set, SetBits};
use super::wall::{Mean, is_within};
use super::words::spot;

/// A stretch of a line from where it ends or meets another to where it does again.
///
/// Memory: some 50 bytes for each place, and as many for each edge between two of them.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Stretch {
    /// Words. Those of a ring end with the first.
    pub(super) places: Vec<u64>,
    /// Heights of the line's own at its places, where lines have some; NaN where there is none.
    pub(super) levels: Vec<f64>,
    pub(super) sets: SetBits,
    /// Whether it is a ring that meets no other line.
    pub(super) is_ring: bool,
}

impl Stretch {
    /// The same from the end that comes first by rows, or where both are one, the way that does. A ring begins and ends at its first place.
    pub(super) fn in_order(mut self) -> Stretch {
        let is_later = |places: &[u64]| {
            let last = places.len() - 1;
            (places[0], places[1]) > (places[last], places[last - 1])
        };
        if self.is_ring {
            self.places.pop();
            let first = (0..self.places.len()).min_by_key(|at| self.places[*at]).unwrap_or(0);
            self.places.rotate_left(first);
            self.places.push(self.places[0]);
            if !self.levels.is_empty() {
                self.levels.pop();
                self.levels.rotate_left(first);
                self.levels.push(self.levels[0]);
            }
        }
        if is_later(&self.places) {
            self.places.reverse();
            self.levels.reverse();
        }
        self
    }
}

/// Edges of the mesh held against a stretch.
pub(super) struct Follow<'a> {
    stretch: &'a Stretch,
    edges: &'a [Edge],
    tolerance: f64,
    /// In parts of a cell.
    shift: i128,
    has_heights: bool,
    /// The number of the last place.
    last: usize,
    is_loop: bool,
    /// Edges between two places, by the numbers of these; the first place's is 0.
    between: Vec<(usize, usize, usize)>,
}

impl<'a> Follow<'a> {
    /// Edges, among them all that are between two places of the stretch.
    pub(super) fn new(stretch: &'a Stretch, edges: &'a [Edge], sets: &[Set], tolerance: f64) -> Follow<'a> {
        let of = || (0..).zip(sets).filter(|(number, _)| stretch.sets >> number & 1 == 1).map(|(_, set)| set);
        let shift = of().map(|set| set.shift).fold(f64::INFINITY, f64::min);
        let last = stretch.places.len() - 1;
        let is_loop = stretch.places[0] == stretch.places[last];
        let mut numbers: Vec<(u64, usize)> = Vec::new();
        if !edges.is_empty() {
            let places = &stretch.places[..if is_loop { last } else { last + 1 }];
            numbers.extend(places.iter().copied().zip(0..));
            numbers.sort_unstable();
        }
        let number = |place: u64| numbers.binary_search_by_key(&place, |known| known.0).ok().map(|at| numbers[at].1);
        let has_heights = of().any(|set| set.has_heights);
        let usable = edges.iter().enumerate().filter(|(_, edge)| has_heights || edge.is_on_surface);
        let between = usable.filter_map(|(i, edge)| Some((number(edge.ends[0])?, number(edge.ends[1])?, i))).collect();
        let shift = i128::from((shift * 65536.0).floor() as i64);
        Follow { stretch, edges, tolerance, shift, has_heights, last, is_loop, between }
    }

    /// How many edges lead from the first place to the last, at the fewest. In a ring they may begin at any place, and lead around to
    /// it.
    ///
    /// # Errors
    /// The number of the last place that edges lead to.
    pub(super) fn edges(&self) -> Result<u64, usize> {
        let found = self.edges_from(0);
        if found.is_ok() || !self.is_loop {
            return found;
        }
        // Where the ring's first place is no vertex of the way, an edge passes over it.
        let over_first = self.between.iter().map(|&(a, b, edge)| (a.max(b), a.min(b), edge)).filter(|ends| ends.1 > 0);
        let mut over_first: Vec<(usize, usize, usize)> = over_first.collect();
        over_first.sort_unstable_by_key(|&(from, to, edge)| (self.last - from + to, to, edge));
        let mut tried = None;
        for (from, to, edge) in over_first {
            if tried != Some(from) && self.allows(from, (0, self.last - from + to), edge) {
                tried = Some(from);
                if let Ok(edges) = self.edges_from(from) {
                    return Ok(edges);
                }
            }
        }
        found
    }

    /// The same from the first place alone, where a ring begins with one of its places.
    fn edges_from(&self, first: usize) -> Result<u64, usize> {
        let last = self.last;
        let turned = |number: usize| if number < first { number + last - first } else { number - first };
        let mut between: Vec<(usize, usize, usize)> = Vec::with_capacity(self.between.len());
        for &(a, b, edge) in &self.between {
            let (from, to) = (turned(a).min(turned(b)), turned(a).max(turned(b)));
            between.push((from, to, edge));
            // A ring comes back to its first place.
            between.extend((self.is_loop && from == 0).then_some((to, last, edge)));
        }
        between.sort_unstable();
        let mut edges = vec![None; last + 1];
        edges[0] = Some(0u64);
        for (from, to, edge) in between {
            let Some(so_far) = edges[from] else { continue };
            let is_shorter = edges[to].is_none_or(|edges| so_far + 1 < edges);
            if is_shorter && self.allows(first, (from, to), edge) {
                edges[to] = Some(so_far + 1);
            }
        }
        edges[last].ok_or_else(|| edges.iter().rposition(Option::is_some).unwrap_or(0))
    }

    /// Whether an edge may stand for the places from one number to another, where a ring begins with one of its places.
    fn allows(&self, first: usize, (from, to): (usize, usize), edge: usize) -> bool {
        let number = |turned: usize| if self.is_loop { (turned + first) % self.last } else { turned };
        let mut places = (from..=to).map(|turned| (spot(self.stretch.places[number(turned)]), number(turned)));
        let Edge { ends, heights, .. } = self.edges[edge];
        let [a, b] = ends.map(spot);
        places.all(|(place, number)| {
            let is_near = is_near(self.shift, place, a, b);
            is_near && (!self.has_heights || self.is_near_level((place, number), (a, heights[0]), (b, heights[1])))
        })
    }

    /// Whether an edge is within the tolerance of a line's own height at one of its places, where the edge is nearest to it.
    fn is_near_level(&self, (place, number): (Spot, usize), (a, from): (Spot, f64), (b, to): (Spot, f64)) -> bool {
        let level = self.stretch.levels.get(number).copied().filter(|level| !level.is_nan());
        let Some(level) = level else { return false };
        let (u, v) = ((b.0 - a.0, b.1 - a.1), (place.0 - a.0, place.1 - a.1));
        let all = u.0 * u.0 + u.1 * u.1;
        let done = (u.0 * v.0 + u.1 * v.1).clamp(0, all);
        is_within(self.tolerance, &Mean([(1, level)]), &Mean([(all - done, from), (done, to)]))
    }
}

/// Whether a place is within a shift, in parts of a cell, of an edge.
fn is_near(parts: i128, place: Spot, a: Spot, b: Spot) -> bool {
    /// Parts in a quarter cell, squared.
    const QUARTER2: i128 = 16384 * 16384;
    let wide = |from: Spot, to: Spot| (i128::from(to.0 - from.0), i128::from(to.1 - from.1));
    let (u, v) = (wide(a, b), wide(a, place));
    let (length2, along) = (u.0 * u.0 + u.1 * u.1, u.0 * v.0 + u.1 * v.1);
    if !(0..=length2).contains(&along) {
        let end = if along < 0 { v } else { wide(b, place) };
        return (end.0 * end.0 + end.1 * end.1) * QUARTER2 <= parts * parts;
    }
    // How far it is from the edge, times the length of the edge. Squares of what is larger are beyond any shift.
    let off = u.0 * v.1 - u.1 * v.0;
    off.abs() < 1 << 49 && off * off * QUARTER2 <= parts * parts * length2
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn spots() -> impl Strategy<Value = [Spot; 3]> {
        let near = prop::array::uniform3((0i64..40, 0i64..40));
        let far = prop::array::uniform3((0i64..1 << 32, 0i64..1 << 32));
        prop_oneof![3 => near, 1 => far]
    }

    proptest! {
        #[test]
        fn places_are_near_as_the_nearest_point_of_an_edge_tells([place, a, b] in spots(), parts in 0i128..1 << 20) {
            prop_assume!(a != b);
            let whole = |number: i64| num_bigint::BigInt::from(number);
            let (u, v) = ((whole(b.0 - a.0), whole(b.1 - a.1)), (whole(place.0 - a.0), whole(place.1 - a.1)));
            let length2 = &u.0 * &u.0 + &u.1 * &u.1;
            let along = (&u.0 * &v.0 + &u.1 * &v.1).clamp(whole(0), length2.clone());
            // Times the square of the length.
            let off = (&v.0 * &length2 - &along * &u.0, &v.1 * &length2 - &along * &u.1);
            let limit = num_bigint::BigInt::from(parts) * length2;
            let is_within = (&off.0 * &off.0 + &off.1 * &off.1) * whole(16384 * 16384) <= &limit * &limit;
            prop_assert_eq!(is_near(parts, place, a, b), is_within);
        }
    }
}
