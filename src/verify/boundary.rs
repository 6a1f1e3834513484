//! The mesh's boundary against that of the ground.

use std::iter::Peekable;

use super::VerifyError;
use super::finding::{EdgePlace, Finding};
use super::grid::Grid;
use super::segments::{BoundaryFindings, SegmentRows, Track};
use super::vertices::Vertex;
use crate::base::external::Sorted;
use crate::base::external::{Queue, Scratch};

/// An edge of one face only, inside the raster and along sides or diagonals of cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundaryEdge {
    /// Its ends, the face on the positive side of the way from the first to the second.
    ends: [(u64, (i64, i64)); 2],
    track: Track,
}

/// Words of its record.
pub(super) const EDGE_WORDS: usize = 8;

/// Its record: sorts by first row, then by vertices; the second word tells whether it has been found astray.
pub(super) type EdgeWords = [u64; EDGE_WORDS];

impl BoundaryEdge {
    /// `None` where it cannot be on any ground's boundary.
    pub(super) fn new(grid: &Grid, from: (u64, Vertex), to: (u64, Vertex)) -> Option<BoundaryEdge> {
        let place = |v: Vertex| v.place.filter(|&p| grid.contains(p));
        let ends = [(from.0, place(from.1)?), (to.0, place(to.1)?)];
        let track = Track::new(ends[0].1, ends[1].1)?;
        Some(BoundaryEdge { ends, track })
    }

    pub(super) fn words(&self, astray: bool) -> EdgeWords {
        let [(from, (fx, fy)), (to, (tx, ty))] = self.ends;
        [self.track.rows().0 as u64, u64::from(astray), from, to, fx as u64, fy as u64, tx as u64, ty as u64]
    }

    fn from_words(w: &EdgeWords) -> (BoundaryEdge, bool) {
        let ends = [(w[2], (w[4] as i64, w[5] as i64)), (w[3], (w[6] as i64, w[7] as i64))];
        let track = Track::new(ends[0].1, ends[1].1).expect("records are made of tracks");
        (BoundaryEdge { ends, track }, w[1] != 0)
    }

    fn place(&self, grid: &Grid) -> EdgePlace {
        let [mut a, mut b] = self.ends.map(|(index, place)| (index, Vertex { place: Some(place), z: 0.0 }));
        if a.0 > b.0 {
            (a, b) = (b, a);
        }
        grid.edge(a, b)
    }
}

/// Lays the edges of one face only along the ground's boundary, rows after rows.
///
/// Memory use is constant, because edges come in the order of their first rows, and those that go on below wait in a
/// [`Queue`].
pub(super) struct Boundary<'s> {
    grid: Grid,
    scratch: &'s Scratch,
    coming: Peekable<Sorted<'s, EDGE_WORDS>>,
    waiting: Queue<'s, EDGE_WORDS>,
    pub(super) found: BoundaryFindings,
    /// Edges that do not run along the ground's boundary, or with their face on the wrong side of it: how many, and the
    /// least record. Which is found first depends on the bands.
    astray: (u64, Option<EdgeWords>),
}

impl<'s> Boundary<'s> {
    pub(super) fn new(grid: Grid, edges: Sorted<'s, EDGE_WORDS>, scratch: &'s Scratch) -> Self {
        Boundary {
            grid,
            scratch,
            coming: edges.peekable(),
            waiting: Queue::new(scratch),
            found: BoundaryFindings::default(),
            astray: (0, None),
        }
    }

    /// The edges found astray.
    pub(super) fn astray(&self) -> Finding<EdgePlace> {
        let (count, first) = self.astray;
        Finding { count, first: first.map(|words| BoundaryEdge::from_words(&words).0.place(&self.grid)) }
    }

    /// Lays what there is of edges in the next rows.
    pub(super) fn follow(&mut self, rows: &mut SegmentRows<'_>) -> Result<(), VerifyError> {
        let after = rows.first + rows.rows;
        let mut next = Queue::new(self.scratch);
        for piece in std::mem::replace(&mut self.waiting, Queue::new(self.scratch)).into_pieces() {
            for words in &piece? {
                self.lay(words, rows, &mut next)?;
            }
        }
        while let Some(words) = self.coming.next_if(|e| e.as_ref().map_or(true, |e| (e[0] as i64) < after)) {
            self.lay(&words?, rows, &mut next)?;
        }
        self.waiting = next;
        rows.tell(&mut self.found);
        Ok(())
    }

    fn lay(
        &mut self,
        words: &EdgeWords,
        rows: &mut SegmentRows<'_>,
        next: &mut Queue<'_, EDGE_WORDS>,
    ) -> Result<(), VerifyError> {
        let (edge, known) = BoundaryEdge::from_words(words);
        let astray = rows.lay(&edge.track);
        if astray && !known {
            let (count, first) = self.astray;
            self.astray = (count + 1, Some(first.map_or(*words, |first| first.min(*words))));
        }
        if edge.track.rows().1 >= rows.first + rows.rows {
            next.push(edge.words(astray || known))?;
        }
        Ok(())
    }
}
