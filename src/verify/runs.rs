//! Samples next to each other in a row, as the passes before the sweep tell of them.

use std::iter::Peekable;

use super::VerifyError;
use crate::base::external::ScratchError;

/// Row, first column, first column after: sorts by rows.
pub(super) type Run = [u64; 3];

type Runs<'s> = Box<dyn Iterator<Item = Result<Run, ScratchError>> + Send + 's>;

/// Sets flags of samples by runs that come in the order of their rows.
pub(super) struct RunFlags<'s> {
    runs: Peekable<Runs<'s>>,
    flag: u8,
}

impl<'s> RunFlags<'s> {
    pub(super) fn new(runs: impl Iterator<Item = Result<Run, ScratchError>> + Send + 's, flag: u8) -> RunFlags<'s> {
        let runs: Runs<'s> = Box::new(runs);
        RunFlags { runs: runs.peekable(), flag }
    }

    /// Sets the flag in rows of `width` samples, the rows after those of the call before; gives the runs in them to `each`.
    pub(super) fn set(
        &mut self,
        first_row: usize,
        width: usize,
        flags: &mut [u8],
        mut each: impl FnMut(Run) -> Result<(), VerifyError>,
    ) -> Result<(), VerifyError> {
        let after = (first_row + flags.len() / width) as u64;
        while let Some(run) = self.runs.next_if(|run| run.as_ref().map_or(true, |run| run[0] < after)) {
            let run @ [row, first, end] = run?;
            let line = (row as usize - first_row) * width;
            flags[line + first as usize..line + end as usize].iter_mut().for_each(|f| *f |= self.flag);
            each(run)?;
        }
        Ok(())
    }
}

impl std::fmt::Debug for RunFlags<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RunFlags").field("flag", &self.flag).finish_non_exhaustive()
    }
}

/// The runs of samples in a row that `is_in`: first column, first column after.
pub(super) fn runs_of<T>(row: &[T], is_in: impl Fn(&T) -> bool) -> impl Iterator<Item = (usize, usize)> {
    let mut column = 0;
    std::iter::from_fn(move || {
        let first = column + row[column..].iter().position(&is_in)?;
        column = row[first..].iter().position(|s| !is_in(s)).map_or(row.len(), |length| first + length);
        Some((first, column))
    })
}
