//! Files without an end, and files that never come.

use std::process::{Command, Stdio};

use tempfile::TempDir;

use super::Workspace;
use crate::command::text;
use crate::distributed::{cosim, outcome, signal};
use crate::models::Model;

#[test]
fn a_device_is_no_file_and_what_it_gives_is_bounded() {
    let workspace = Workspace::new();
    for name in ["z.fmu", "z.ssp", "z.ssd", "z.xml", "z.csv", "z.mcap", "z.parquet", "z.toml"] {
        std::os::unix::fs::symlink("/dev/zero", workspace.path(name)).unwrap();
        let verb = match name.rsplit_once('.').unwrap().1 {
            "csv" | "mcap" | "parquet" => format!("verify {name}"),
            "toml" => "campaign".to_owned(),
            _ => "info".to_owned(),
        };
        let (code, shown) = workspace.run_in(4 << 20, &verb, name, b"");
        assert_eq!(code, 3, "{name}: {shown}");
        assert!(shown.contains("error: [") && shown.contains(name), "{name}: {shown}");
    }
}

fn pipe(folder: &TempDir) {
    let made = Command::new("mkfifo").arg(folder.path().join("pipe.csv")).status().unwrap();
    assert!(made.success());
}

#[test]
fn a_pipe_that_nothing_writes_to_is_empty() {
    let folder = TempDir::new().unwrap();
    pipe(&folder);
    let (code, shown) = outcome(folder.path(), &["verify", "pipe.csv", "pipe.csv"]);
    assert_eq!(code, 3, "{shown}");
    assert!(shown.contains("pipe.csv"), "{shown}");
}

#[test]
fn one_signal_ends_a_command_that_waits_for_a_file() {
    let folder = TempDir::new().unwrap();
    pipe(&folder);
    let path = folder.path().join("pipe.csv");
    // Its other end is open, and nothing is written.
    let _writer = std::fs::File::options().read(true).write(true).open(&path).unwrap();
    let fmu = Model::Gain.fmu();
    let arguments = ["simulate", fmu.to_str().unwrap(), "--input-file", "pipe.csv", "-o", "-"];
    let mut command = cosim(folder.path(), &arguments);
    let child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let files = format!("/proc/{}/fd", child.id());
    let reads = || {
        let open = std::fs::read_dir(&files).unwrap().flatten();
        open.flat_map(|file| file.path().read_link()).any(|file| file.ends_with("pipe.csv"))
    };
    while !reads() {
        std::thread::yield_now();
    }
    signal(child.id(), "-TERM");
    let output = child.wait_with_output().unwrap();
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{shown}");
    assert!(shown.contains("[E303]"), "{shown}");
}
