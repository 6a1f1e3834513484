//! Progress and cancellation of passes over files.

use crate::base::control::{Control, Stage};

use super::VerifyError;

/// Counts records as they pass: tells the progress, and looks out for cancellation, every [`Pace::STEP`] of them.
pub(super) struct Pace<'c> {
    control: &'c Control<'c>,
    stage: Stage,
    passed: u64,
}

impl<'c> Pace<'c> {
    const STEP: u64 = 1 << 16;

    /// Begins a stage in which `records` records will pass.
    pub(super) fn begin(control: &'c Control<'c>, stage: Stage, records: u64) -> Self {
        control.progress.begin(stage, records / Self::STEP, 0);
        Pace { control, stage, passed: 0 }
    }

    /// One record has passed.
    pub(super) fn tick(&mut self) -> Result<(), VerifyError> {
        self.pass(1)
    }

    /// Several have.
    pub(super) fn pass(&mut self, records: u64) -> Result<(), VerifyError> {
        let before = self.passed / Self::STEP;
        self.passed += records;
        for _ in before..self.passed / Self::STEP {
            self.control.cancel.check()?;
            self.control.progress.step(self.stage, 0);
        }
        Ok(())
    }

    pub(super) fn end(self) -> Result<(), VerifyError> {
        self.control.cancel.check()?;
        self.control.progress.end(self.stage);
        Ok(())
    }
}
