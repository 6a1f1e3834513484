//! A run on a thread of its own, watched by the thread that calls.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use terrabite::base::control::{CancelToken, Control, Progress, Stage};
use terrabite::run::RunError;

use crate::errors::{Cancelled, exception};

/// How often the calling thread looks at signals, the cancel flag and progress.
const LOOK: Duration = Duration::from_millis(50);

/// What a caller may give to watch and stop a run.
#[derive(Default)]
pub(crate) struct Watch {
    /// An object with `is_set()`, such as `threading.Event`.
    pub(crate) cancel: Option<Py<PyAny>>,
    /// Called with the name of a stage, steps done and steps in all.
    pub(crate) progress: Option<Py<PyAny>>,
}

/// Stages in the order in which they began, and how far they are.
#[derive(Default)]
struct Stages(Mutex<Vec<State>>);

#[derive(Clone, Copy)]
struct State {
    stage: Stage,
    steps: u64,
    done: u64,
    is_told: bool,
}

impl Stages {
    fn with<T>(&self, change: impl FnOnce(&mut Vec<State>) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn last(&self, stage: Stage, change: impl FnOnce(&mut State)) {
        self.with(|states| {
            if let Some(state) = states.iter_mut().rev().find(|state| state.stage == stage) {
                change(state);
                state.is_told = false;
            }
        });
    }

    /// What has changed since it was last asked.
    fn news(&self) -> Vec<State> {
        self.with(|states| {
            let news = states.iter().copied().filter(|state| !state.is_told).collect();
            states.iter_mut().for_each(|state| state.is_told = true);
            news
        })
    }
}

impl Progress for Stages {
    fn begin(&self, stage: Stage, steps: u64, _samples: u64) {
        self.with(|states| states.push(State { stage, steps, done: 0, is_told: false }));
    }

    fn step(&self, stage: Stage, _samples: u64) {
        self.last(stage, |state| state.done = (state.done + 1).min(state.steps));
    }

    fn end(&self, stage: Stage) {
        self.last(stage, |state| state.done = state.steps);
    }
}

impl Watch {
    /// Lets Python's signal handlers run, asks the flag and tells progress.
    fn look(&self, py: Python<'_>, stages: &Stages) -> PyResult<()> {
        py.check_signals()?;
        if let Some(cancel) = &self.cancel
            && cancel.bind(py).call_method0("is_set")?.is_truthy()?
        {
            return Err(Cancelled::new_err("stopped before the end: the cancel flag was set"));
        }
        self.tell(py, stages)
    }

    fn tell(&self, py: Python<'_>, stages: &Stages) -> PyResult<()> {
        let Some(progress) = &self.progress else { return Ok(()) };
        for State { stage, done, steps, .. } in stages.news() {
            let name = serde_json::to_value(stage).ok();
            let name = name.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default();
            progress.bind(py).call1((name, done, steps))?;
        }
        Ok(())
    }
}

/// Does `work` without the interpreter, on a thread of its own. What the calling thread meets meanwhile (a signal whose handler
/// raises, the cancel flag, an exception of the callback) stops the work, and is raised once it has stopped.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    watch: &Watch,
    work: impl FnOnce(&Control<'_>) -> Result<T, RunError> + Send,
) -> PyResult<T> {
    let (stages, cancel) = (Stages::default(), CancelToken::default());
    watch.look(py, &stages)?;
    let (found, met) = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            let control = Control { cancel: cancel.clone(), progress: &stages };
            let worker = scope.spawn(move || {
                let found = work(&control);
                drop(done);
                found
            });
            let mut met = None;
            while is_done.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if met.is_none() {
                    // Where the interpreter ends, nobody waits for the mesh.
                    met = Python::try_attach(|py| watch.look(py, &stages).err())
                        .unwrap_or_else(|| Some(Cancelled::new_err("the interpreter has ended")));
                    if met.is_some() {
                        cancel.cancel();
                    }
                }
            }
            (worker.join().unwrap_or_else(|panic| resume_unwind(panic)), met)
        })
    });
    match met {
        Some(met) => Err(met),
        None => {
            let found = found.map_err(|error| exception(&error))?;
            watch.tell(py, &stages)?;
            Ok(found)
        }
    }
}
