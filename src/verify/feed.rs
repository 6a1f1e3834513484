//! Records by their first rows, batch by batch, for the bands of rows that they reach into.

use std::iter::Peekable;

use crate::base::external::{Queue, Scratch, ScratchError, Sorted};

/// Records in a batch, at most.
const BATCH: usize = 16 << 10;

/// A piece of a [`Queue`].
type Piece<const N: usize> = Result<Vec<[u64; N]>, ScratchError>;

/// Records whose first word is the first row they reach into. Each band of rows is given all that reach into it, in
/// batches: those of the bands above first, then those that begin in it. So each row sees them in one order, whatever the
/// bands.
///
/// Memory use is that of the sort and of a [`Queue`] that is emptied while another is filled.
pub(super) struct Feed<'s, const N: usize> {
    scratch: &'s Scratch,
    coming: Peekable<Sorted<'s, N>>,
    /// Those of bands above that this band has not been given yet.
    waiting: Box<dyn Iterator<Item = Piece<N>> + Send + 's>,
    /// Those that the next band is to be given.
    next: Queue<'s, N>,
}

impl<'s, const N: usize> Feed<'s, N> {
    pub(super) fn new(sorted: Sorted<'s, N>, scratch: &'s Scratch) -> Self {
        Feed { scratch, coming: sorted.peekable(), waiting: Box::new(std::iter::empty()), next: Queue::new(scratch) }
    }

    /// Begins the next band of rows.
    pub(super) fn begin(&mut self) {
        self.waiting = Box::new(std::mem::replace(&mut self.next, Queue::new(self.scratch)).into_pieces());
    }

    /// The next batch for the band that ends before row `after`; an empty one where there is no more. Those that `goes_on`
    /// finds are given to the next band, too. `batch` is one that has been used.
    pub(super) fn next(
        &mut self,
        mut batch: Vec<[u64; N]>,
        after: i64,
        goes_on: impl Fn(&[u64; N]) -> bool,
    ) -> Piece<N> {
        if let Some(piece) = self.waiting.next() {
            batch = piece?;
        } else {
            batch.clear();
            batch.reserve_exact(BATCH);
            let in_band = |record: &Result<[u64; N], _>| record.as_ref().map_or(true, |r| (r[0] as i64) < after);
            while batch.len() < BATCH
                && let Some(record) = self.coming.next_if(in_band)
            {
                batch.push(record?);
            }
        }
        batch.iter().filter(|record| goes_on(record)).try_for_each(|record| self.next.push(*record))?;
        Ok(batch)
    }
}
