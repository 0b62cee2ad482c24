//! Runs on workers through the binary: the same bytes, whatever is killed, and nothing left behind.

mod bits;
mod faults;
mod kills;
mod orchestrator;
mod refusals;
mod verify;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::models::Model;
use crate::ssd::Ssd;

/// A chain with several rates.
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

/// A chain in which the FMU of `b` was compiled with `defines` and its description changed.
fn with(folder: &Path, stop: f64, defines: &[&str], change: impl Fn(String) -> String) -> String {
    let ssd = Ssd::new()
        .add("clock", Model::Clock)
        .add("b", Model::Gain)
        .add("x", Model::Integrator)
        .connect("clock.y", "b.u")
        .connect("b.y", "x.u")
        .stop(stop);
    let clumsy = Model::Gain.variant(&folder.join("clumsy.fmu"), defines, change);
    let good = Model::Gain.fmu();
    let text = ssd.text().replace(good.to_str().unwrap(), clumsy.to_str().unwrap());
    let file = folder.join("test.ssd");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
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

/// The bytes of a run in one process.
fn undisturbed(folder: &Path, system: &str) -> Vec<u8> {
    let (code, stderr) = outcome(folder, &["run", system, "-q", "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    results(folder, "here.csv")
}

/// State and parent of a process.
fn status(process: u32) -> Option<(char, u32)> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let (_, after) = stat.rsplit_once(") ")?;
    let mut words = after.split(' ');
    Some((words.next()?.chars().next()?, words.next()?.parse().ok()?))
}

/// A process no longer computes, although it may not have been waited for yet.
fn is_over(process: u32) -> bool {
    status(process).is_none_or(|(state, _)| state == 'Z' || state == 'X')
}

/// A process that has not ended by then does not end; a machine may be that slow.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until all of these have ended; returns those that do not.
pub(crate) fn remaining(processes: &[u32]) -> Vec<u32> {
    let begun = Instant::now();
    loop {
        let left: Vec<u32> = processes.iter().copied().filter(|p| !is_over(*p)).collect();
        if left.is_empty() || begun.elapsed() > PATIENCE {
            return left;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The processes whose parent is `parent`.
pub(crate) fn children(parent: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").unwrap().flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    numbers
        .filter(|number| status(*number).is_some_and(|(state, p)| p == parent && state != 'Z'))
        .collect()
}

pub(crate) fn signal(process: u32, name: &str) {
    // It may have ended by itself.
    let _ = Command::new("kill").args([name, &process.to_string()]).stderr(Stdio::null()).status();
}

/// Every process started by `root`, and their descendants.
fn below(root: u32) -> Vec<u32> {
    let workers = children(root);
    let groups: Vec<u32> = workers.iter().flat_map(|&worker| children(worker)).collect();
    [workers, groups].concat()
}

/// Waits until `count` groups are computing below a run, or below its local workers.
fn groups_of(roots: &[u32], count: usize) -> Vec<u32> {
    let mut groups: Vec<u32> = Vec::new();
    for _ in 0..4000 {
        groups = roots.iter().flat_map(|&root| children(root)).collect();
        if groups.len() >= count {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    groups
}

/// The groups of a run with local workers.
fn groups_below(run: &Child, count: usize) -> Vec<u32> {
    let mut groups = Vec::new();
    for _ in 0..200 {
        groups = groups_of(&children(run.id()), 0);
        if groups.len() >= count || is_over(run.id()) {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    groups
}

/// Waits until a group below one of these workers is in the middle of its run, where its FMU was
/// compiled to wait; returns the group.
fn waiting_below(workers: &[u32]) -> u32 {
    let waits = |group: &u32| {
        let threads = std::fs::read_dir(format!("/proc/{group}/task")).into_iter().flatten();
        threads.flatten().any(|thread| {
            std::fs::read_to_string(thread.path().join("comm"))
                .is_ok_and(|name| name == "waiting\n")
        })
    };
    loop {
        let mut groups = workers.iter().flat_map(|&worker| children(worker));
        if let Some(group) = groups.find(waits) {
            return group;
        }
        assert!(!workers.iter().all(|&worker| is_over(worker)), "no group waits");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn leftovers(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    all.filter(|path| path.is_dir()).collect()
}

/// An unused endpoint on this machine.
fn endpoint() -> String {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    format!("tcp/{}", free.local_addr().unwrap())
}

/// Random numbers that are the same in every test run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) % limit.max(1)
    }
}

/// A process that ends with the test.
struct Kept(Child);

impl Kept {
    fn worker(folder: &Path, name: &str, endpoint: &str) -> Self {
        let arguments = ["worker", "--name", name, "--connect", endpoint, "--allow-upload"];
        Self(cosim(folder, &arguments).stderr(Stdio::null()).spawn().unwrap())
    }

    fn id(&self) -> u32 {
        self.0.id()
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        signal(self.id(), "-CONT");
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
