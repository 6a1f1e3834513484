//! Faults on purpose, so that tests can end a run at a moment of their choice.
//!
//! The environment variable `TERRABITE_FAULT=ACTION:POINT:N` makes the process do ACTION when POINT is reached for the
//! Nth time, counted over all threads: `kill` ends it as a power cut would (SIGKILL: no cleaning up), `stop` halts it
//! (SIGSTOP) until it is continued or killed. The command looks at the variable ([`arm`]), no other program. The hooks
//! are part of every build, so that what is tested is what is shipped; without the variable each costs one load and one branch.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// The moments of a run that can be chosen, in the order of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Point {
    /// A work dir's folder is made, and nothing in it.
    WorkDirMade,
    /// A work dir's manifest is written, under a temporary name.
    ManifestWritten,
    /// The temporary name of the output is noted, and nothing has it.
    OutputAnnounced,
    /// An empty file has it, which tells the permissions of new files.
    OutputProbed,
    /// The output has it.
    OutputStaged,
    /// A part of the raster is about to be decoded.
    DecodeUnit,
    /// A tile is begun.
    TileBegun,
    /// A finished tile's chunk is written and synced, under a temporary name.
    ChunkWritten,
    /// A chunk has its name.
    ChunkRenamed,
    /// The vertices of a chunk are in the output.
    Vertices,
    /// The triangles of a chunk are in the output.
    Triangles,
    /// The output is complete, under a temporary name.
    OutputWritten,
    /// A file beside the output has its name, the output not yet.
    CompanionPlaced,
    /// The output has its name.
    OutputRenamed,
    /// A finished job's chunks are removed from its work dir, and nothing else yet.
    ChunksRemoved,
    /// Its manifest, too.
    ManifestRemoved,
    /// All that was in it, and the folder is still there.
    LockRemoved,
}

impl Point {
    const ALL: [(&'static str, Point); 17] = [
        ("work-dir-made", Point::WorkDirMade),
        ("manifest-written", Point::ManifestWritten),
        ("output-announced", Point::OutputAnnounced),
        ("output-probed", Point::OutputProbed),
        ("output-staged", Point::OutputStaged),
        ("decode-unit", Point::DecodeUnit),
        ("tile-begun", Point::TileBegun),
        ("chunk-written", Point::ChunkWritten),
        ("chunk-renamed", Point::ChunkRenamed),
        ("vertices", Point::Vertices),
        ("triangles", Point::Triangles),
        ("output-written", Point::OutputWritten),
        ("companion-placed", Point::CompanionPlaced),
        ("output-renamed", Point::OutputRenamed),
        ("chunks-removed", Point::ChunksRemoved),
        ("manifest-removed", Point::ManifestRemoved),
        ("lock-removed", Point::LockRemoved),
    ];
}

/// What is done to the process at the chosen moment. It must take effect before whoever does it returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// It ends as by a power cut.
    Kill,
    /// It halts until it is continued or killed.
    Stop,
}

#[derive(Debug)]
struct Fault {
    action: Action,
    point: Point,
    left: AtomicU64,
}

/// Does to the process what is asked for.
pub type Act = fn(Action);

static ARMED: OnceLock<(Act, Option<Fault>)> = OnceLock::new();

/// Says that the run has come to `point`.
pub fn reach(point: Point) {
    let Some((act, Some(fault))) = ARMED.get() else { return };
    if fault.point == point && fault.left.fetch_sub(1, Ordering::Relaxed) == 1 {
        act(fault.action);
    }
}

/// Lets the environment variable work from now on, and makes sure that it means something if it is set: a test would
/// believe that it tests. `act` does what is asked for. For the command; the library by itself ends no process.
///
/// # Errors
/// What was expected, and what was found.
pub fn arm(act: Act) -> Result<(), String> {
    ARMED.get_or_init(|| (act, from_environment()));
    match std::env::var_os(VARIABLE) {
        Some(text) if text.to_str().and_then(parse).is_none() => {
            Err(format!("{VARIABLE}: expected ACTION:POINT:N in the environment, found {text:?}"))
        }
        _ => Ok(()),
    }
}

const VARIABLE: &str = "TERRABITE_FAULT";

fn from_environment() -> Option<Fault> {
    parse(&std::env::var(VARIABLE).ok()?)
}

fn parse(text: &str) -> Option<Fault> {
    let mut words = text.split(':');
    let action = match words.next()? {
        "kill" => Action::Kill,
        "stop" => Action::Stop,
        _ => return None,
    };
    let name = words.next()?;
    let (_, point) = *Point::ALL.iter().find(|(n, _)| *n == name)?;
    let count: u64 = words.next()?.parse().ok().filter(|&n| n > 0)?;
    words.next().is_none().then_some(Fault { action, point, left: AtomicU64::new(count) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn actions_points_and_counts() {
        let fault = parse("kill:chunk-written:7").unwrap();
        assert_eq!((fault.action, fault.point, fault.left.into_inner()), (Action::Kill, Point::ChunkWritten, 7));
        for wrong in ["", "kill", "kill:tile-begun", "kill:tile-begun:0", "kill:nowhere:1", "stop:tile-begun:1:2"] {
            assert!(parse(wrong).is_none(), "{wrong}");
        }
    }
}
