//! Records by their first rows, batch by batch, for the bands of rows that they reach into.

use std::iter::Peekable;

use crate::base::external::{Queue, Scratch, ScratchError, Sorted};

/// Records in a batch: as many as in a piece that waits, so that what comes is added to the last of those alone.
const BATCH: usize = Queue::<1>::BUFFER;

/// A piece of a [`Queue`].
type Piece<const N: usize> = Result<Vec<[u64; N]>, ScratchError>;

/// Records whose first word is the first row they reach into. Each band of rows is given all that reach into it, in
/// batches: those of the bands above first, then those that begin in it. So each row sees them in one order, whatever the
/// bands.
///
/// Memory use is that of the sort and of a [`Queue`] that is emptied while another is filled. Their buffers go round.
pub(super) struct Feed<'s, const N: usize> {
    scratch: &'s Scratch,
    coming: Peekable<Sorted<'s, N>>,
    /// Those of bands above that this band has not been given yet.
    waiting: Box<dyn Iterator<Item = Piece<N>> + Send + 's>,
    /// Those that the next band is to be given.
    next: Queue<'s, N>,
    /// The buffer of a queue to come.
    spare: Vec<[u64; N]>,
}

impl<'s, const N: usize> Feed<'s, N> {
    pub(super) fn new(sorted: Sorted<'s, N>, scratch: &'s Scratch) -> Self {
        let (coming, waiting) = (sorted.peekable(), Box::new(std::iter::empty()));
        Feed { scratch, coming, waiting, next: Queue::new(scratch), spare: Vec::new() }
    }

    /// Begins the next band of rows.
    pub(super) fn begin(&mut self) {
        let next = Queue::reusing(self.scratch, std::mem::take(&mut self.spare));
        self.waiting = Box::new(std::mem::replace(&mut self.next, next).into_pieces());
    }

    /// The next batch for the band that ends before row `after`: all of [`BATCH`] records but the last, which has fewer, or none. Those
    /// that `goes_on` finds are given to the next band, too. `batch` is one that has been used.
    pub(super) fn next(
        &mut self,
        mut batch: Vec<[u64; N]>,
        after: i64,
        goes_on: impl Fn(&[u64; N]) -> bool,
    ) -> Piece<N> {
        batch.clear();
        if let Some(piece) = self.waiting.next() {
            self.spare = std::mem::replace(&mut batch, piece?);
        }
        batch.reserve_exact(BATCH - batch.len());
        let in_band = |record: &Result<[u64; N], _>| record.as_ref().map_or(true, |r| (r[0] as i64) < after);
        while batch.len() < BATCH
            && let Some(record) = self.coming.next_if(in_band)
        {
            batch.push(record?);
        }
        batch.iter().filter(|record| goes_on(record)).try_for_each(|record| self.next.push(*record))?;
        Ok(batch)
    }

    /// Whether a batch is the last of its band.
    pub(super) fn is_last(batch: &[[u64; N]]) -> bool {
        batch.len() < BATCH
    }
}
