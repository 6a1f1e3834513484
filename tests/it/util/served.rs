//! A server, while it runs.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command};

use super::run::{Run, started};

/// A server that runs until it is told to end.
pub(crate) struct Served {
    child: Option<Child>,
    address: String,
}

impl Served {
    /// Starts the binary, and waits for the address that it prints.
    pub(crate) fn start<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Served {
        let mut child = started(arguments);
        let mut address = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut address).unwrap();
        Served { child: Some(child), address: address.trim().to_string() }
    }

    /// Its port, and the path after it.
    pub(crate) fn address(&self) -> (u16, String) {
        let (port, path) = self.address.strip_prefix("http://127.0.0.1:").unwrap().split_once('/').unwrap();
        (port.parse().unwrap(), format!("/{path}"))
    }

    /// Interrupts it, as Ctrl-C does.
    pub(crate) fn interrupted(mut self) -> Run {
        let child = self.child.take().unwrap();
        let sent = Command::new("kill").args(["-INT".to_string(), child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        Run::from(child.wait_with_output().unwrap())
    }
}

/// A test that fails leaves no process behind.
impl Drop for Served {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }
}
