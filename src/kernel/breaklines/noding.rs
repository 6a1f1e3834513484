//! Lines that cross are joined: iterated snap rounding on the lattice of quarter cells.
//!
//! A place is *hot* if a segment ends there, or if it is the nearest to where two segments cross. Every segment is led through the
//! hot places whose square it meets: the square of a place is half a step around it, without its right and lower sides. That is done
//! until nothing changes. Segments lie in one closed cell each and so do all places that they are led through, so cells have
//! nothing to do with each other but for the hot places on their common sides.
//!
//! It ends: a segment that is led elsewhere becomes shorter ones, by the longer of its two extents or else by their sum, and both are
//! whole numbers.

use super::pieces::Piece;
use super::{Place, Segment, SetBits};
use crate::base::lattice::STEPS;

/// All pieces noded, in their order, each once.
pub(super) fn node(mut pieces: Vec<Piece>) -> Vec<Piece> {
    let in_order = |pieces: &mut Vec<Piece>| {
        pieces.sort_unstable_by_key(Piece::key);
        pieces.dedup_by(|next, piece| {
            let is_same = next.key() == piece.key();
            if is_same {
                piece.times += next.times;
            }
            is_same
        });
    };
    in_order(&mut pieces);
    loop {
        let mut next = lead_once(&pieces, &pieces);
        in_order(&mut next);
        if next == pieces {
            return pieces;
        }
        pieces = next;
    }
}

/// Pieces led once through the hot places of all that are near, in no order.
pub(super) fn lead_once(pieces: &[Piece], near: &[Piece]) -> Vec<Piece> {
    let hot = hot_places(&segments(near));
    let mut led = Vec::with_capacity(pieces.len());
    let mut way = Vec::new();
    for piece in pieces {
        lead(piece.ends, &hot, &mut way);
        led.extend(piece.led(&way));
    }
    led
}

/// The segments of pieces, which are in their order, each once, and the sets that each is of.
pub(super) fn with_sets(pieces: &[Piece]) -> (Vec<Segment>, Vec<SetBits>) {
    let bits = |group: &[Piece]| group.iter().fold(0, |bits, piece| bits | 1 << piece.set);
    pieces.chunk_by(|a, b| a.ends == b.ends).map(|group| (group[0].ends, bits(group))).unzip()
}

/// The segments of pieces, which are in their order, each once.
pub(super) fn segments(pieces: &[Piece]) -> Vec<Segment> {
    let mut segments: Vec<Segment> = pieces.iter().map(|piece| piece.ends).collect();
    segments.dedup();
    segments
}

/// All of them, in their order.
fn hot_places(segments: &[Segment]) -> Vec<Place> {
    let mut hot: Vec<Place> = segments.as_flattened().to_vec();
    let cell = |s: &Segment| (s[0].y.div_euclid(i64::from(STEPS)), s[0].x.min(s[1].x).div_euclid(i64::from(STEPS)));
    let mut by_cell: Vec<((i64, i64), Segment)> = segments.iter().map(|s| (cell(s), *s)).collect();
    by_cell.sort_unstable();
    for group in by_cell.chunk_by(|a, b| a.0 == b.0) {
        for (i, (_, s)) in group.iter().enumerate() {
            hot.extend(group[i + 1..].iter().filter_map(|(_, t)| crossing(*s, *t)));
        }
    }
    hot.sort_unstable();
    hot.dedup();
    hot
}

/// The place nearest to where two segments cross in the midst of both; of two the lower or the one to the right.
fn crossing([a, b]: Segment, [c, d]: Segment) -> Option<Place> {
    let sides = |p: Place, q: Place, r: Place, s: Place| turn(p, q, r).signum() * turn(p, q, s).signum() < 0;
    if !sides(a, b, c, d) || !sides(c, d, a, b) {
        return None;
    }
    let all = (b.x - a.x) * (d.y - c.y) - (b.y - a.y) * (d.x - c.x);
    let done = (c.x - a.x) * (d.y - c.y) - (c.y - a.y) * (d.x - c.x);
    let (all, done) = (all.abs(), done * all.signum());
    let nearest = |from: i64, to: i64| (2 * (from * all + (to - from) * done) + all).div_euclid(2 * all);
    Some(Place { y: nearest(a.y, b.y), x: nearest(a.x, b.x) })
}

/// Twice the area of a triangle, with a sign.
pub(super) fn turn(a: Place, b: Place, c: Place) -> i64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// The places that a segment is led through, both ends among them.
fn lead(segment: Segment, hot: &[Place], way: &mut Vec<Place>) {
    let [a, b] = segment;
    way.clear();
    for y in a.y..=b.y {
        for x in a.x.min(b.x)..=a.x.max(b.x) {
            let place = Place { y, x };
            let is_end = place == a || place == b;
            if is_end || meets(segment, place) && hot.binary_search(&place).is_ok() {
                way.push(place);
            }
        }
    }
    way.sort_by_key(|p| ((p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y), *p));
}

/// A bound of the share of the way along a segment: a fraction, and whether it is itself within.
#[derive(Clone, Copy)]
struct Bound {
    share: (i64, i64),
    is_within: bool,
}

/// Whether a segment meets the square of a place.
fn meets([a, b]: Segment, place: Place) -> bool {
    let (mut from, mut to) =
        ([Bound { share: (0, 1), is_within: true }; 3], [Bound { share: (1, 1), is_within: true }; 3]);
    for (i, (start, end, at)) in [(a.x, b.x, place.x), (a.y, b.y, place.y)].into_iter().enumerate() {
        // In halves of a step: from `low` on, up to before `high`.
        let (start, run, low, high) = (2 * start, 2 * (end - start), 2 * at - 1, 2 * at + 1);
        if run == 0 {
            if !(low..high).contains(&start) {
                return false;
            }
            continue;
        }
        let share = |side: i64| ((side - start) * run.signum(), run.abs());
        let low = Bound { share: share(low), is_within: true };
        let high = Bound { share: share(high), is_within: false };
        (from[i], to[i]) = if run > 0 { (low, high) } else { (high, low) };
    }
    let is_before = |f: &Bound, t: &Bound| {
        let (left, right) = (f.share.0 * t.share.1, t.share.0 * f.share.1);
        left < right || left == right && f.is_within && t.is_within
    };
    from.iter().all(|f| to.iter().all(|t| is_before(f, t)))
}
