//! Lines that cross are joined at places of the lattice, until nothing changes.
//!
//! Hot places are ends of segments, and the places nearest to where two cross. A segment goes through all hot places whose square it
//! meets, half a step around each, lower and right sides left out; in the order of their shadows on it.

use std::collections::HashSet;

use super::Spot;
use super::pieces::Piece;

/// A piece, and how often its line runs over it.
pub(super) type Counted = (Piece, u32);

/// Pieces joined, each once, in order. Memory: some 250 bytes for each.
pub(super) fn noded(all: Vec<Piece>) -> Vec<Counted> {
    let mut pieces = counted(all.into_iter().map(|piece| (piece, 1)).collect());
    loop {
        let mut hot: HashSet<Spot> = pieces.iter().flat_map(|(piece, _)| piece.ends).collect();
        let cell = |[a, b]: [Spot; 2]| (a.0.min(b.0) >> 2, a.1.min(b.1) >> 2);
        let mut by_cell: Vec<(Spot, [Spot; 2])> =
            pieces.iter().map(|(piece, _)| (cell(piece.ends), piece.ends)).collect();
        by_cell.sort_unstable();
        by_cell.dedup();
        for of_cell in by_cell.chunk_by(|s, t| s.0 == t.0) {
            for (i, &(_, s)) in of_cell.iter().enumerate() {
                hot.extend(of_cell[..i].iter().filter_map(|&(_, t)| meeting(s, t)));
            }
        }
        drop(by_cell);
        let mut parts = Vec::with_capacity(pieces.len());
        for &(piece, times) in &pieces {
            parts.extend(led(&piece, &hot).into_iter().map(|part| (part, times)));
        }
        let parts = counted(parts);
        if parts == pieces {
            return pieces;
        }
        pieces = parts;
    }
}

fn counted(mut all: Vec<Counted>) -> Vec<Counted> {
    all.sort_unstable();
    all.dedup_by(|more, piece| {
        let is_same = more.0 == piece.0;
        if is_same {
            piece.1 += more.1;
        }
        is_same
    });
    all
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
