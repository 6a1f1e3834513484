//! Lines in strips of a raster, for those who cannot hold all of them: pieces as records, and what is done to a strip at a time.
//!
//! A strip is a number of rows of cells over the whole width. Pieces are in the strip of their lower place. Where pieces are led depends on
//! those in the same closed cell and those that touch it, so to lead a strip's pieces once, the next row of cells above and below is
//! needed and nothing else.

use super::levels::{Levels, TwoHeights};
use super::pieces::Piece;
use super::{Beside, Breaklines, LineKind, Place, Set, noding};
use super::{lakes::Lakes, places};
use crate::base::lattice::STEPS;
use crate::base::{LineSet, Polylines};
use std::ops::Range;
use std::sync::Arc;

use super::LinesError;

/// A piece as words, in the same order.
pub(crate) type PieceRecord = [u64; 6];

/// Rows of the lattice that a strip has.
pub(crate) const ROWS: i64 = 64 * STEPS as i64;

/// The most samples across or down: places are written in 32 bits.
pub(crate) const LONGEST: usize = 1 << 29;

impl Piece {
    fn record(&self) -> PieceRecord {
        let word = |place: Place| (place.y as u64) << 32 | place.x as u64;
        let [a, b] = self.ends.map(word);
        let [from, to] = self.heights.map(f64::to_bits);
        [a, b, u64::from(self.set) << 32 | u64::from(self.line), from, to, u64::from(self.times)]
    }

    fn of_record(&[a, b, of, from, to, times]: &PieceRecord) -> Piece {
        let place = |word: u64| Place { y: (word >> 32) as i64, x: i64::from(word as u32) };
        Piece {
            ends: [place(a), place(b)],
            set: (of >> 32) as u8,
            line: of as u32,
            heights: [from, to].map(f64::from_bits),
            times: times as u32,
        }
    }
}

/// The first place of a piece, by rows.
pub(crate) fn low(record: &PieceRecord) -> Place {
    Piece::of_record(record).ends[0]
}

/// The other place of a piece.
pub(crate) fn high(record: &PieceRecord) -> Place {
    Piece::of_record(record).ends[1]
}

/// Cuts the lines of one set after the other into pieces.
pub(crate) struct Cutting {
    sets: Vec<Set>,
}

impl Cutting {
    pub(crate) fn new() -> Cutting {
        Cutting { sets: Vec::new() }
    }

    /// The next set of lines.
    ///
    /// # Errors
    /// [`LinesError`].
    pub(crate) fn begin(&mut self, set: &LineSet) -> Result<(), LinesError> {
        self.sets.push(Set::new(set)?);
        Ok(())
    }

    /// Hands on the pieces of some lines of the set that was begun last, in no order. The number of the first line is given, and the features
    /// of all.
    ///
    /// # Errors
    /// [`LinesError`], and those of `take`.
    pub(crate) fn cut<E: From<LinesError>>(
        &mut self,
        lines: &Polylines,
        (first, feature): (usize, &dyn Fn(usize) -> u64),
        size: (usize, usize),
        take: &mut dyn FnMut(PieceRecord) -> Result<(), E>,
    ) -> Result<(), E> {
        let number = self.sets.len() as u8 - 1;
        let set = self.sets.last_mut().expect("a set was begun");
        let mut take = |pieces: &mut Vec<Piece>| pieces.drain(..).try_for_each(|piece| take(piece.record()));
        places::cut((number, set.kind), lines, (first, feature), size, &mut set.counts, &mut take)
    }

    /// What was cut, held in memory.
    ///
    /// # Errors
    /// The kind of the lines, and [`LinesError`].
    pub(crate) fn in_memory(
        self,
        pieces: Vec<PieceRecord>,
        asked: &[LineSet],
        size: (usize, usize),
    ) -> Result<Breaklines, (LineKind, LinesError)> {
        Breaklines::of_pieces(pieces.iter().map(Piece::of_record).collect(), self.sets, asked, size)
    }

    /// The sets, of whose segments nothing is known yet.
    pub(crate) fn finish(self, asked: &[LineSet], size: (usize, usize)) -> Strips {
        let features = asked.iter().map(|set| set.lines.clone()).collect();
        Strips { sets: self.sets, features, size }
    }
}

/// What is known of lines whose pieces are elsewhere.
#[derive(Debug)]
pub(crate) struct Strips {
    sets: Vec<Set>,
    /// For the features of lines.
    features: Vec<Polylines>,
    size: (usize, usize),
}

impl Strips {
    /// The pieces of a strip, led once through the places that are hot, in order, each once. `above` and `below` are the pieces next to it,
    /// a row of cells at the least. What comes to lie on the line to the next strip is among them.
    pub(crate) fn lead(above: &[PieceRecord], strip: &[PieceRecord], below: &[PieceRecord]) -> Vec<PieceRecord> {
        let all: Vec<Piece> = [above, strip, below].into_iter().flatten().map(Piece::of_record).collect();
        let led = noding::lead_once(&all[above.len()..above.len() + strip.len()], &all);
        led.iter().map(Piece::record).collect()
    }

    /// Puts records of pieces in order, and joins those that are the same but for how often.
    pub(crate) fn join(records: &mut Vec<PieceRecord>) {
        records.sort_unstable();
        records.dedup_by(|next, kept| {
            let is_same = next[..5] == kept[..5];
            if is_same {
                kept[5] += next[5];
            }
            is_same
        });
    }

    /// Lines with these noded pieces, in any order.
    pub(crate) fn lines(&self, records: &[PieceRecord]) -> Breaklines {
        let mut pieces: Vec<Piece> = records.iter().map(Piece::of_record).collect();
        pieces.sort_unstable_by_key(Piece::key);
        let (segments, of) = noding::with_sets(&pieces);
        let levels = Levels::new(&pieces, &Lakes::default(), |piece| {
            let number = usize::from(piece.set);
            let set = &self.sets[number];
            set.has_heights.then(|| (set.kind, self.features[number].feature(piece.line as usize)))
        });
        let beside = Beside::of_lines(&levels, Lakes::default(), (&segments, &of), &self.sets, self.size);
        let (segments, of, levels, beside) = (Arc::new(segments), Arc::new(of), Arc::new(levels), Arc::new(beside));
        Breaklines { segments, of, sets: self.sets.clone(), levels, beside, inside: None }
    }
}

/// What all of the lines come to, reckoned strip by strip from the top.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    hashers: [crc32fast::Hasher; 3],
    segments: u64,
    range: Option<[f64; 2]>,
    differences: Vec<TwoHeights>,
}

impl Tally {
    /// The next strip, which has these rows of the lattice, with the pieces above it that touch it.
    pub(crate) fn add(&mut self, strips: &mut Strips, rows: Range<i64>, records: &[PieceRecord]) {
        let lines = strips.lines(records);
        let is_in = |place: Place| rows.contains(&place.y);
        let first = lines.segments.partition_point(|[low, _]| low.y < rows.start);
        let [places, of, heights] = &mut self.hashers;
        for (segment, bits) in lines.segments[first..].iter().zip(&lines.of[first..]) {
            segment.iter().for_each(|place| super::hash_place(places, *place));
            of.update(&[*bits]);
            super::count(*bits, &mut strips.sets);
        }
        self.segments += (lines.segments.len() - first) as u64;
        for (_, height) in lines.levels.all().iter().filter(|(place, _)| is_in(*place)) {
            heights.update(&height.to_le_bytes());
            let [low, high] = self.range.get_or_insert([*height; 2]);
            (*low, *high) = (low.min(*height), high.max(*height));
        }
        // The first that is too large for a tolerance is larger than all before it.
        for found in lines.levels.differences().iter().filter(|found| is_in(found.place())) {
            if self.differences.last().is_none_or(|last| found.is_larger(last)) {
                self.differences.push(*found);
            }
        }
    }

    /// What they come to.
    pub(crate) fn finish(self, strips: &Strips) -> Summary {
        let [mut hasher, of, heights] = self.hashers;
        hasher.combine(&of);
        hasher.combine(&heights);
        let lines = Breaklines { levels: Arc::new(Levels::told(self.differences)), ..strips.lines(&[]) };
        let named = lines.named_as(self.segments, hasher.finalize());
        Summary { lines, range: self.range, named }
    }
}

/// What is told of lines without a look at their pieces.
#[derive(Debug)]
pub(crate) struct Summary {
    /// Without segments.
    pub(crate) lines: Breaklines,
    /// As [`Breaklines::height_range`].
    pub(crate) range: Option<[f64; 2]>,
    /// As [`Breaklines::named`].
    pub(crate) named: [String; 2],
}
