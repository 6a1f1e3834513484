//! Running the program, and what it says.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// The built binary.
const TERRABITE: &str = env!("CARGO_BIN_EXE_terrabite");

/// Runs the binary to its end.
pub(crate) fn terrabite<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Run {
    Run::of(Command::new(TERRABITE).args(arguments))
}

/// Runs the binary where no file may grow beyond `blocks` × 512 bytes: a full disk, for one process. The signal that
/// comes with the limit is ignored, so that writes fail as they do on a full disk.
pub(crate) fn terrabite_with_file_limit<S: AsRef<OsStr>>(blocks: u32, arguments: impl IntoIterator<Item = S>) -> Run {
    let limited = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    Run::of(Command::new("sh").arg("-c").arg(limited).arg(TERRABITE).args(arguments))
}

/// Runs the binary in a control group, from its first page on.
pub(crate) fn terrabite_in_group<S: AsRef<OsStr>>(group: &Path, arguments: impl IntoIterator<Item = S>) -> Run {
    let join = "echo $$ > \"$0\" && exec \"$@\"";
    let processes = group.join("cgroup.procs");
    Run::of(Command::new("sh").arg("-c").arg(join).arg(processes).arg(TERRABITE).args(arguments))
}

/// Starts the binary, sends it `signal` (`INT`, `TERM`) as soon as `ready` says so, and waits for its end.
pub(crate) fn terrabite_stopped<S: AsRef<OsStr>>(
    signal: &str,
    arguments: impl IntoIterator<Item = S>,
    ready: impl Fn() -> bool,
) -> Run {
    let mut child = started(arguments);
    wait_for(&mut child, ready);
    let sent = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    Run::from(child.wait_with_output().unwrap())
}

/// Runs the binary with a fault (`ACTION:POINT:N`) in its way.
pub(crate) fn terrabite_with_fault<S: AsRef<OsStr>>(fault: &str, arguments: impl IntoIterator<Item = S>) -> Run {
    terrabite_in_environment(&[("TERRABITE_FAULT", fault)], arguments)
}

/// Runs the binary with environment variables.
pub(crate) fn terrabite_in_environment<S: AsRef<OsStr>>(
    variables: &[(&str, &str)],
    arguments: impl IntoIterator<Item = S>,
) -> Run {
    Run::of(Command::new(TERRABITE).args(arguments).envs(variables.iter().copied()))
}

/// A run that stands still at a point of the test's choice.
pub(crate) struct Halted(Option<Child>);

impl Halted {
    /// Starts the binary and waits until it has come to `point` for the `count`th time.
    pub(crate) fn at<S: AsRef<OsStr>>(point: &str, count: u32, arguments: impl IntoIterator<Item = S>) -> Halted {
        let mut command = Command::new(TERRABITE);
        command.args(arguments).env("TERRABITE_FAULT", format!("stop:{point}:{count}"));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let stat = format!("/proc/{}/stat", child.id());
        // The state follows the program's name, which is in parentheses.
        while !std::fs::read_to_string(&stat).is_ok_and(|s| s.contains(") T ")) {
            if child.try_wait().unwrap().is_some() {
                panic!("it ended before it came to {point}: {:#?}", Run::from(child.wait_with_output().unwrap()));
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Halted(Some(child))
    }

    pub(crate) fn signal(&self, signal: &str) {
        let id = self.0.as_ref().unwrap().id();
        let sent = Command::new("kill").args([format!("-{signal}"), id.to_string()]).status().unwrap();
        assert!(sent.success());
    }

    /// Lets it go on to its end.
    pub(crate) fn go_on(mut self) -> Run {
        self.signal("CONT");
        Run::from(self.0.take().unwrap().wait_with_output().unwrap())
    }
}

/// A test that fails leaves no process behind.
impl Drop for Halted {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }
}

/// Starts the program, does something to its files while it is busy, and waits for its end. Busy means: it holds two
/// nameless files open, those of the spool or two of what the verifier sorts.
pub(crate) fn terrabite_disturbed<S: AsRef<OsStr>>(
    arguments: impl IntoIterator<Item = S>,
    disturb: impl FnOnce() -> bool,
) -> Run {
    let mut child = started(arguments);
    let files = format!("/proc/{}/fd", child.id());
    let nameless = |path: std::path::PathBuf| path.as_os_str().to_string_lossy().ends_with("(deleted)");
    let busy = || {
        let links = std::fs::read_dir(&files).into_iter().flatten().flatten();
        links.filter_map(|l| l.path().read_link().ok()).filter(|p| nameless(p.clone())).count() >= 2
    };
    wait_for(&mut child, busy);
    assert!(disturb());
    Run::from(child.wait_with_output().unwrap())
}

pub(super) fn started<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Child {
    Command::new(TERRABITE).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn wait_for(child: &mut Child, ready: impl Fn() -> bool) {
    while !ready() {
        assert!(child.try_wait().unwrap().is_none(), "it ended too early");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A run that has ended.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Run {
    pub(crate) fn of(command: &mut Command) -> Run {
        Run::from(command.output().unwrap())
    }

    pub(super) fn from(Output { status, stdout, stderr }: Output) -> Run {
        let text = |bytes| String::from_utf8(bytes).expect("reports and messages are UTF-8");
        Run { code: status.code(), out: text(stdout), err: text(stderr) }
    }

    /// It must have succeeded.
    #[track_caller]
    pub(crate) fn succeeds(self) -> Run {
        assert_eq!(self.code, Some(0), "{self:#?}");
        self
    }

    /// It must have ended with `code`, said each of `words` on standard error, and nothing on standard output.
    #[track_caller]
    pub(crate) fn fails(self, code: i32, words: &[&str]) -> Run {
        assert_eq!(self.code, Some(code), "{self:#?}");
        for word in words {
            assert!(self.err.contains(word), "expected {word:?} in the message of {self:#?}");
        }
        assert!(!self.err.contains("panicked") && self.out.is_empty(), "{self:#?}");
        self
    }

    /// Its report.
    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {self:#?}"))
    }
}
