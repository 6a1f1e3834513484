//! Lines that cross are joined at places of the lattice, until nothing changes.
//!
//! Hot places are ends of segments, and the places nearest to where two cross. A segment goes through all hot places whose square it
//! meets, half a step around each, lower and right sides left out; in the order of their shadows on it.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::Spot;
use super::pieces::Piece;

/// Pieces joined, each once, with how often its line runs over it.
pub(super) fn noded(all: Vec<Piece>) -> BTreeMap<Piece, u32> {
    let counted = |all: &mut dyn Iterator<Item = (Piece, u32)>| {
        let mut pieces: BTreeMap<Piece, u32> = BTreeMap::new();
        all.for_each(|(piece, times)| *pieces.entry(piece).or_default() += times);
        pieces
    };
    let mut pieces = counted(&mut all.into_iter().map(|piece| (piece, 1)));
    loop {
        let mut hot: HashSet<Spot> = pieces.keys().flat_map(|piece| piece.ends).collect();
        let mut by_cell: BTreeMap<Spot, Vec<[Spot; 2]>> = BTreeMap::new();
        let segments: BTreeSet<[Spot; 2]> = pieces.keys().map(|piece| piece.ends).collect();
        for &[a, b] in &segments {
            by_cell.entry((a.0.min(b.0) >> 2, a.1.min(b.1) >> 2)).or_default().push([a, b]);
        }
        for cell in by_cell.values() {
            for (i, &s) in cell.iter().enumerate() {
                hot.extend(cell[..i].iter().filter_map(|&t| meeting(s, t)));
            }
        }
        let parts = |(piece, times): (&Piece, &u32)| {
            led(piece, &hot).into_iter().map(|part| (part, *times)).collect::<Vec<_>>()
        };
        let led = counted(&mut pieces.iter().flat_map(parts));
        if led == pieces {
            return pieces;
        }
        pieces = led;
    }
}

/// The place nearest to where two segments cross, if they do so strictly inside of both; of two the one on the right, or below.
fn meeting([a, b]: [Spot; 2], [c, d]: [Spot; 2]) -> Option<Spot> {
    let ((ux, uy), (vx, vy), (wx, wy)) = ((b.0 - a.0, b.1 - a.1), (d.0 - c.0, d.1 - c.1), (c.0 - a.0, c.1 - a.1));
    // a + s/n·u = c + t/n·v
    let (mut n, mut s, mut t) = (ux * vy - uy * vx, wx * vy - wy * vx, wx * uy - wy * ux);
    if n < 0 {
        (n, s, t) = (-n, -s, -t);
    }
    let is_inside = |share: i64| 0 < share && share < n;
    let nearest = |over: i64| (2 * over + n).div_euclid(2 * n);
    (is_inside(s) && is_inside(t)).then(|| (a.0 + nearest(ux * s), a.1 + nearest(uy * s)))
}

/// What a piece becomes.
fn led(piece: &Piece, hot: &HashSet<Spot>) -> Vec<Piece> {
    let [a, b] = piece.ends;
    let (u, mut way) = ((b.0 - a.0, b.1 - a.1), vec![a, b]);
    for x in a.0.min(b.0)..=a.0.max(b.0) {
        for y in a.1.min(b.1)..=a.1.max(b.1) {
            if (x, y) != a && (x, y) != b && hot.contains(&(x, y)) && meets(a, u, (x, y)) {
                way.push((x, y));
            }
        }
    }
    way.sort_by_key(|p| ((p.0 - a.0) * u.0 + (p.1 - a.1) * u.1, p.1, p.0));
    let part = |pair: &[Spot]| {
        let [from, to] = [pair[0], pair[1]].map(|spot| (spot, piece.height_near(spot)));
        Piece::new((piece.set, piece.line), from, to)
    };
    way.windows(2).map(part).collect()
}

/// Whether a + share·u is in the square of a place for a share from 0 to 1. If so, then at one where the segment ends or comes to a
/// side's line, or in the middle between two such.
fn meets(a: Spot, u: Spot, place: Spot) -> bool {
    let mut shares = vec![(0, 1), (1, 1)];
    for (from, run, at) in [(a.0, u.0, place.0), (a.1, u.1, place.1)] {
        for side in [2 * at - 1, 2 * at + 1] {
            let over = (side - 2 * from) * run.signum();
            if run != 0 && (0..=2 * run.abs()).contains(&over) {
                shares.push((over, 2 * run.abs()));
            }
        }
    }
    let is_in = |(over, under): (i64, i64)| {
        [(a.0, u.0, place.0), (a.1, u.1, place.1)].into_iter().all(|(from, run, at)| {
            let doubled = 2 * (from * under + run * over);
            ((2 * at - 1) * under..(2 * at + 1) * under).contains(&doubled)
        })
    };
    let middles = shares.iter().flat_map(|p| shares.iter().map(move |q| (p.0 * q.1 + q.0 * p.1, 2 * p.1 * q.1)));
    shares.iter().copied().chain(middles).any(is_in)
}
