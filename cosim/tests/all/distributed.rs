//! Runs on workers through the binary: the same bytes, whatever is killed, and nothing left over.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use tempfile::TempDir;

use crate::models::Model;
use crate::ssd::Ssd;

pub(crate) fn chain(stop: f64) -> Ssd {
    Ssd::new()
        .add("clock", Model::Clock)
        .add_with("x", Model::Integrator, &[], Some(0.2))
        .add_with("g", Model::Gain, &[("k", 0.3)], None)
        .add_with("a", Model::Affine, &[("k", 0.7)], None)
        .connect("clock.y", "g.u")
        .connect("g.y", "a.u")
        .connect("a.y", "x.u")
        .stop(stop)
}

pub(crate) fn cosim(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.args(arguments).current_dir(folder).env("NO_COLOR", "1").env("TMPDIR", folder);
    command
}

/// Runs to the end: exit code, stderr.
pub(crate) fn outcome(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = cosim(folder, arguments).output().unwrap();
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
}

pub(crate) fn results(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

/// The processes whose parent is `parent`.
pub(crate) fn children(parent: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").unwrap().flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    numbers
        .filter(|number| {
            let stat = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
            let after = stat.rsplit_once(") ").map_or("", |(_, after)| after);
            after.split(' ').nth(1) == Some(parent.to_string().as_str())
        })
        .collect()
}

pub(crate) fn signal(process: u32, name: &str) {
    // It may have ended by itself.
    let _ = Command::new("kill").args([name, &process.to_string()]).stderr(Stdio::null()).status();
}

/// Every process that `root` started, and those that they started.
fn below(root: u32) -> Vec<u32> {
    let workers = children(root);
    let groups: Vec<u32> = workers.iter().flat_map(|&worker| children(worker)).collect();
    [workers, groups].concat()
}

/// Waits until groups are at work.
fn groups_of(run: &Child) -> Vec<u32> {
    for _ in 0..3000 {
        let groups: Vec<u32> =
            children(run.id()).iter().flat_map(|&worker| children(worker)).collect();
        if !groups.is_empty() {
            return groups;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Vec::new()
}

fn leftovers(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    all.filter(|path| path.is_dir()).collect()
}

#[test]
fn any_number_of_workers_gives_the_same_bytes() {
    let (file, folder) = (chain(5.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let (code, stderr) = outcome(folder.path(), &["run", path, "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    for workers in ["1", "2", "3"] {
        let arguments = ["run", path, "-o", "there.csv", "--workers", workers];
        let (code, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(code, 0, "{stderr}");
        assert_eq!(results(folder.path(), "here.csv"), results(folder.path(), "there.csv"));
    }
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn killed_groups_and_workers_change_no_byte_and_leave_nothing() {
    let (file, folder) = (chain(1000.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let (code, stderr) = outcome(folder.path(), &["run", path, "-q", "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    let arguments = ["run", path, "-o", "there.csv", "--workers", "3"];
    let run = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut dice = 3_u64;
    for _ in 0..6 {
        let groups = groups_of(&run);
        dice = dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        std::thread::sleep(Duration::from_millis((dice >> 33) % 300));
        if let Some(&group) = groups.get((dice >> 40) as usize % groups.len().max(1)) {
            signal(group, "-KILL");
        }
    }
    if let Some(&worker) = children(run.id()).first() {
        signal(worker, "-KILL");
    }
    let started = below(run.id());
    let output = run.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("went on at worker"), "{stderr}");
    assert_eq!(results(folder.path(), "here.csv"), results(folder.path(), "there.csv"));
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
    assert!(started.iter().all(|p| !Path::new(&format!("/proc/{p}")).exists()));
}

#[test]
fn an_interrupted_run_leaves_no_process_and_no_folder() {
    let (file, folder) = (chain(1e6), TempDir::new().unwrap());
    let file = file.write();
    for name in ["-INT", "-KILL"] {
        let arguments = ["run", file.to_str().unwrap(), "-q", "-o", "x.csv", "--workers", "2"];
        let mut run = cosim(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap();
        assert!(!groups_of(&run).is_empty());
        let started = below(run.id());
        std::thread::sleep(Duration::from_millis(200));
        signal(run.id(), name);
        run.wait().unwrap();
        std::thread::sleep(Duration::from_millis(500));
        assert!(started.iter().all(|p| !Path::new(&format!("/proc/{p}")).exists()), "{name}");
        if name == "-INT" {
            assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
        }
    }
}

#[test]
fn what_cannot_be_is_told_before_anything_runs() {
    let (file, folder) = (chain(1.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let busy = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp/{}", busy.local_addr().unwrap());
    for (more, code, part) in [
        (&["--workers", "2", "--place", "gg=worker-1"][..], 2, "did you mean 'g'?"),
        (&["--workers", "2", "--place", "g=worker-7", "--wait", "2"], 2, "did you mean 'worker-"),
        (&["--distributed", "--listen", "tcp/0.0.0.0:0"], 1, "--insecure"),
        (&["--distributed", "--listen", "tls/127.0.0.1:0"], 1, "--credentials"),
        (&["--distributed", "--listen", &endpoint], 1, "E504"),
    ] {
        let arguments = [&["run", path, "-q"], more].concat();
        let (found, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(found, code, "{more:?}: {stderr}");
        assert!(stderr.contains(part), "{more:?}: {stderr}");
    }
}
