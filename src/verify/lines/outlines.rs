//! Outlines that have an inside, as sides that features run over an odd number of times.

use std::collections::{BTreeMap, BTreeSet};

use super::Spot;
use super::inside::Inside;
use super::lakes::Shores;
use super::pieces::Piece;
use crate::base::external::{Queue, Scratch, ScratchError};
use crate::base::{LineKind, LineSet, Polylines};
use crate::verify::VerifyError;

/// The outlines of all sets. Memory: some 150 bytes for each side.
#[derive(Debug)]
pub(super) struct Outlines {
    /// By the number of the set; `None` where it has no inside.
    sets: Vec<Option<OfSet>>,
}

#[derive(Debug)]
struct OfSet {
    /// Which feature of the set each line is of, as they come.
    of_line: Vec<usize>,
    /// Sides with their features. What is run over an even number of times bounds nothing.
    odd: BTreeSet<([Spot; 2], usize)>,
}

/// Which feature each line is of, as they come, and their numbers.
fn features(lines: &Polylines) -> (Vec<usize>, Vec<u64>) {
    let (mut numbers, mut features) = (BTreeMap::new(), Vec::new());
    let of = |line: usize| {
        let feature = lines.feature(line);
        *numbers.entry(feature).or_insert_with(|| {
            features.push(feature);
            features.len() - 1
        })
    };
    let of_line = (0..lines.count()).map(of).collect();
    (of_line, features)
}

impl Outlines {
    /// Those among noded pieces, and all pieces once more.
    pub(super) fn of<'s>(
        pieces: Queue<'s, 6>,
        sets: &[LineSet],
        scratch: &'s Scratch,
    ) -> Result<(Outlines, Queue<'s, 6>), ScratchError> {
        let of_set = |set: &LineSet| {
            let of_line = set.kind.has_inside().then(|| features(&set.lines).0);
            of_line.map(|of_line| OfSet { of_line, odd: BTreeSet::new() })
        };
        let mut found = Outlines { sets: sets.iter().map(of_set).collect() };
        if found.sets.iter().all(Option::is_none) {
            return Ok((found, pieces));
        }
        let mut times: Vec<BTreeMap<([Spot; 2], usize), u64>> = vec![BTreeMap::new(); sets.len()];
        let mut again = Queue::new(scratch);
        for record in pieces.into_records() {
            let record = record?;
            let (piece, more) = Piece::of_record(record);
            if let Some(of_set) = &found.sets[piece.set] {
                *times[piece.set].entry((piece.ends, of_set.of_line[piece.line])).or_default() += more;
            }
            again.push(record)?;
        }
        for (of_set, times) in found.sets.iter_mut().zip(times) {
            let odd = times.into_iter().filter(|(_, times)| times % 2 == 1).map(|(side, _)| side);
            if let Some(of_set) = of_set {
                of_set.odd = odd.collect();
            }
        }
        Ok((found, again))
    }

    /// Whether a piece is no side of an outline, or one that bounds something.
    pub(super) fn have(&self, piece: &Piece) -> bool {
        let of_set = self.sets[piece.set].as_ref();
        of_set.is_none_or(|of_set| of_set.odd.contains(&(piece.ends, of_set.of_line[piece.line])))
    }

    fn of_kind<'a>(&'a self, sets: &'a [LineSet], kind: LineKind) -> Option<(&'a LineSet, &'a OfSet)> {
        let number = sets.iter().position(|set| set.kind == kind)?;
        Some((&sets[number], self.sets[number].as_ref()?))
    }

    /// The lakes of all sets; each feature is one.
    pub(super) fn shores(&self, sets: &[LineSet]) -> Result<Shores, VerifyError> {
        let Some((set, of_set)) = self.of_kind(sets, LineKind::Lakes) else { return Ok(Shores::default()) };
        let (_, features) = features(&set.lines);
        let mut lakes: Vec<(u64, f64)> = features.into_iter().map(|feature| (feature, 0.0)).collect();
        // The first line of a lake tells how high it is.
        for (line, &lake) in of_set.of_line.iter().enumerate().rev() {
            let level = set.lines.heights().and_then(|heights| heights[line].first().copied());
            lakes[lake].1 = level.unwrap_or(0.0);
        }
        Shores::new(lakes, of_set.odd.iter().copied())
    }

    /// The inside of the outlines that the mesh is to end at; each feature is a polygon.
    pub(super) fn inside(&self, sets: &[LineSet], (width, height): (i64, i64)) -> Option<Inside> {
        let (_, of_set) = self.of_kind(sets, LineKind::Cutline)?;
        let sides: Vec<_> = of_set.odd.iter().copied().collect();
        Some(Inside::new(&sides, (width - 1, height - 1)))
    }
}
