//! Authentication and authorization through the binary: a refused client gets the reason, and
//! FMUs can do only what they are allowed to.

mod confined;
mod credentials;
mod rights;

use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Stdio};

use tempfile::TempDir;

use crate::distributed::{cosim, outcome, signal};

/// A process that ends with the test.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        signal(self.0.id(), "-TERM");
        // A stopped process does not receive the signal.
        signal(self.0.id(), "-CONT");
        let _ = self.0.wait();
    }
}

pub(crate) fn start(folder: &Path, arguments: &[&str]) -> Running {
    let mut command = cosim(folder, arguments);
    Running(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

pub(crate) fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Keys of two authorities, `keys` and `others`.
pub(crate) fn keys() -> TempDir {
    let folder = TempDir::new().unwrap();
    for name in ["keys", "others"] {
        let arguments = ["keys", name, "--worker", "left", "--worker", "right"];
        let (code, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(code, 0, "{stderr}");
    }
    folder
}

fn text(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).unwrap()
}

/// Runs `file` on one worker that is started with `lent`: the run's exit code and stderr.
pub(crate) fn on_worker(
    at: &Path,
    file: &Path,
    lent: &[&str],
    environment: &[(&str, &str)],
) -> (i32, String) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let run = ["run", file.to_str().unwrap(), "-o", "there.csv", "--distributed"];
    let run = [&run[..], &["--deadline", "1"]].concat();
    let mut command = cosim(at, &[&run[..], &["--listen", &endpoint]].concat());
    let run = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let worker = ["worker", "--name", "w", "--connect", &endpoint];
    let mut worker = cosim(at, &[&worker[..], lent].concat());
    worker.envs(environment.iter().copied()).stdout(Stdio::null()).stderr(Stdio::null());
    let _worker = Running(worker.spawn().unwrap());
    let output = run.wait_with_output().unwrap();
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
}
