//! Progress on standard error: the stage, steps done, samples per second and time left.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::Duration;

use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::{signals, warnings};
use crate::base::control::{Control, Progress, Stage};
use crate::base::warning::Warning;

/// One line per running stage, redrawn a few times a second, and wiped when the stage is done. Silent unless standard
/// error is a terminal.
#[derive(Debug)]
pub(crate) struct Bars {
    all: MultiProgress,
    running: Mutex<Vec<Running>>,
}

#[derive(Debug)]
struct Running {
    stage: Stage,
    steps: u64,
    done: u64,
    found: u64,
    bar: ProgressBar,
}

impl Running {
    fn message(&self) -> String {
        match self.found {
            0 => format!("{}/{}", self.done, self.steps),
            found => format!("{}/{}, {found} were there", self.done, self.steps),
        }
    }
}

impl Bars {
    /// Progress for one run; nothing is drawn when `quiet`.
    pub(crate) fn new(quiet: bool) -> Bars {
        let seen = !quiet && std::io::stderr().is_terminal();
        let target = if seen { ProgressDrawTarget::stderr_with_hz(8) } else { ProgressDrawTarget::hidden() };
        Bars { all: MultiProgress::with_draw_target(target), running: Mutex::default() }
    }

    /// What the library is given: these bars, and the token that Ctrl-C cancels.
    pub(crate) fn control(&self) -> Control<'_> {
        Control { cancel: signals::token(), progress: self }
    }

    /// A panic of another thread while it counted steps leaves nothing worse than a wrong count.
    fn running(&self) -> std::sync::MutexGuard<'_, Vec<Running>> {
        self.running.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Progress for Bars {
    fn begin(&self, stage: Stage, steps: u64, samples: u64) {
        let bar = self.all.add(ProgressBar::new(samples).with_style(style()).with_prefix(title(stage)));
        bar.set_message(format!("0/{steps}"));
        if !self.all.is_hidden() {
            // Tiles may take seconds: the clock runs on between them.
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        self.running().push(Running { stage, steps, done: 0, found: 0, bar });
    }

    fn step(&self, stage: Stage, samples: u64) {
        let mut running = self.running();
        let Some(run) = running.iter_mut().find(|r| r.stage == stage) else { return };
        run.done += 1;
        if !self.all.is_hidden() {
            run.bar.set_message(run.message());
            run.bar.inc(samples);
        }
    }

    fn warn(&self, warning: &Warning) {
        warnings::collect([warning.clone()]);
    }

    fn found(&self, stage: Stage, samples: u64) {
        let mut running = self.running();
        let Some(run) = running.iter_mut().find(|r| r.stage == stage) else { return };
        run.done += 1;
        run.found += 1;
        if !self.all.is_hidden() {
            run.bar.set_message(run.message());
            // The rate and the time left are those of the work there is.
            run.bar.dec_length(samples);
        }
    }

    fn end(&self, stage: Stage) {
        let mut running = self.running();
        if let Some(i) = running.iter().position(|r| r.stage == stage) {
            running.swap_remove(i).bar.finish_and_clear();
        }
    }
}

/// A stage that failed leaves no half line before the message.
impl Drop for Bars {
    fn drop(&mut self) {
        self.running().drain(..).for_each(|r| r.bar.finish_and_clear());
    }
}

fn title(stage: Stage) -> &'static str {
    match stage {
        Stage::Decode => "decoding",
        Stage::Holes => "finding holes",
        Stage::Ranges => "finding ranges",
        Stage::Survey => "surveying",
        Stage::Triangulate => "triangulating",
        Stage::Seams => "over seams",
        Stage::CrossingsAcross => "crossings 1/2",
        Stage::CrossingsDown => "crossings 2/2",
        Stage::Write => "writing",
        Stage::Ground => "finding the ground",
        Stage::Sort => "sorting",
        Stage::Compare => "comparing",
        Stage::Rows => "rows",
    }
}

fn style() -> ProgressStyle {
    ProgressStyle::with_template("{prefix:13} {bar:24} {msg:>13}  {rate:>14}  {left}")
        .expect("a template that is part of the program")
        .with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
            let _ = out.write_str(&rate(state.per_sec()));
        })
        .with_key("left", |state: &ProgressState, out: &mut dyn Write| {
            if state.pos() > 0 {
                let _ = write!(out, "{:#} left", HumanDuration(state.eta()));
            }
        })
}

fn rate(samples_per_second: f64) -> String {
    match samples_per_second {
        r if r >= 1e6 => format!("{:.1} M samples/s", r / 1e6),
        r if r >= 1e3 => format!("{:.1} k samples/s", r / 1e3),
        r => format!("{r:.0} samples/s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_may_overlap_and_end_in_any_order() {
        let bars = Bars::new(true);
        bars.begin(Stage::Decode, 2, 200);
        bars.begin(Stage::Triangulate, 1, 100);
        bars.step(Stage::Decode, 100);
        bars.end(Stage::Decode);
        bars.step(Stage::Decode, 100);
        bars.step(Stage::Triangulate, 100);
        bars.end(Stage::Triangulate);
        assert!(bars.running().is_empty());
    }

    #[test]
    fn rates_as_people_say_them() {
        assert_eq!(rate(12_340_000.0), "12.3 M samples/s");
        assert_eq!(rate(4_400.0), "4.4 k samples/s");
        assert_eq!(rate(17.2), "17 samples/s");
    }
}
