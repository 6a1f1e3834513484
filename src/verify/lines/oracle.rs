//! What rows, rounds and strips are held against: the same over the whole raster at once.

use std::collections::{HashMap, HashSet};

use super::edges::Edge;
use super::finder::Finder;
use super::follow::Stretch;
use super::heights::Samples;
use super::noding::{counted, hot_places, lead};
use super::pieces::{Counted, Piece};
use super::required::{Segment, SetBits};
use super::wall::Wall;
use super::words::{spot, word};
use super::{Grid, RequiredLines, Spot};
use crate::base::Band;
use crate::base::control::CancelToken;
use crate::formats::MeshReader;
use crate::verify::VerifyError;

/// Pieces led through hot places until nothing changes.
pub(super) fn noded(all: Vec<Piece>) -> Vec<Counted> {
    let mut pieces = counted(all.into_iter().map(|piece| (piece, 1)).collect());
    loop {
        let (hot, mut parts, mut way) = (hot_places(&pieces), Vec::new(), Vec::new());
        for (piece, times) in &pieces {
            lead(piece, &hot, &mut way);
            let level = |spot: Spot| (spot, piece.height_near(spot));
            let part = |pair: &[Spot]| Piece::new((piece.set, piece.line), level(pair[0]), level(pair[1]));
            parts.extend(way.windows(2).map(part).map(|part| (part, *times)));
        }
        let parts = counted(parts);
        if parts == pieces {
            return pieces;
        }
        pieces = parts;
    }
}

/// All stretches of segments, those that have an end first, by the places that they begin with.
pub(super) fn stretches(segments: &[Segment]) -> Vec<Stretch> {
    let mut beside: HashMap<u64, Vec<(u64, SetBits)>> = HashMap::new();
    for &([a, b], sets) in segments {
        beside.entry(word(a)).or_default().push((word(b), sets));
        beside.entry(word(b)).or_default().push((word(a), sets));
    }
    let mut ways: Vec<(u64, u64, SetBits)> = Vec::new();
    for (&from, to) in &beside {
        ways.extend(to.iter().map(|&(to, sets)| (from, to, sets)));
    }
    ways.sort_unstable();
    let goes_on = |place: u64| beside[&place].len() == 2 && beside[&place][0].1 == beside[&place][1].1;
    let (mut taken, mut found) = (HashSet::new(), Vec::new());
    for is_ring in [false, true] {
        for &(from, to, sets) in &ways {
            if taken.contains(&(from, to)) || !is_ring && goes_on(from) {
                continue;
            }
            let mut places = vec![from, to];
            loop {
                let [before, at] = [places[places.len() - 2], places[places.len() - 1]];
                taken.extend([(before, at), (at, before)]);
                if at == from || !goes_on(at) {
                    break;
                }
                let next = beside[&at].iter().find(|next| next.0 != before).expect("two ways");
                places.push(next.0);
            }
            found.push(Stretch { places, levels: Vec::new(), sets, is_ring });
        }
    }
    found
}

/// What is found out about stretches.
pub(super) fn found<'a>(
    raster: &Band,
    mesh: &mut dyn MeshReader,
    max_error: f64,
    (grid, lines): (&'a Grid, &'a RequiredLines),
) -> Finder<'a> {
    let mut places = HashMap::new();
    mesh.for_each_vertex(|vertex, [x, y, z]| {
        let place = grid.lattice(x, y).filter(|spot| grid.contains(*spot));
        places.extend(place.filter(|_| z.is_finite()).map(|spot| (vertex, (word(spot), grid.frame.height(z)))));
        Ok::<(), VerifyError>(())
    })
    .expect("vertices");
    let mut edges = Vec::new();
    mesh.for_each_face(|_, [a, b, c]| {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if let (Some(&a), Some(&b)) = (places.get(&a), places.get(&b)) {
                let (a, b) = if a.0 < b.0 { (a, b) } else { (b, a) };
                edges.push(Edge { ends: [a.0, b.0], heights: [a.1, b.1], is_on_surface: true });
            }
        }
        Ok::<(), VerifyError>(())
    })
    .expect("faces");
    edges.retain(|edge| edge.ends[0] != edge.ends[1]);
    edges.sort_unstable_by_key(Edge::record);
    edges.dedup();
    let rows = 0..raster.height() as i64;
    let segments: Vec<Segment> = lines.segments(rows.clone()).expect("segments").collect();
    let (all, ends): (Vec<_>, Vec<_>) =
        (segments.iter().map(|s| s.0).collect(), edges.iter().map(|edge| edge.ends.map(spot)).collect());
    let samples = Samples::read(raster, &all, (&ends, &rows), &CancelToken::default()).expect("samples");
    let levels = lines.levels(rows.clone()).expect("levels");
    let wall = Wall { samples: &samples, levels: &levels, tolerance: max_error };
    edges.retain_mut(|edge| wall.judge(edge, &rows));
    let mut finder = Finder::new((grid, lines), max_error);
    let is_ground = |segment: &[Spot; 2]| samples.has_cell(*segment, |cell| lines.asks(*segment, cell));
    let on_ground: Vec<Segment> = segments.iter().filter(|segment| is_ground(&segment.0)).copied().collect();
    finder.off_ground = (segments.len() - on_ground.len()) as u64;
    let known: HashMap<u64, f64> = levels.into_iter().collect();
    for stretch in stretches(&on_ground) {
        let levels = stretch.places.iter().map(|place| known.get(place).copied().unwrap_or(f64::NAN)).collect();
        finder.add(Stretch { levels, ..stretch }, &edges);
    }
    finder
}
