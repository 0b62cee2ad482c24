//! Remote FMUs that are loaded and unloaded many times, and hosts that are killed.

use std::path::PathBuf;
use std::process::Command;

use cosim::fmi::{Fmu, Instance, Logging};

use super::{Made, groups, initialize, step, until};
use crate::command::text;
use crate::distributed::{children, remaining, signal};
use crate::export::lifecycles::allocated;
use crate::locked::start;
use crate::models::Model::Integrator;

/// Number of lives, and what each may leave (bytes): some lists of the dynamic linker grow for a
/// while.
const LIVES: usize = 40;
const LEFT: usize = 1024;
/// Names the FMU to the child process.
const VARIABLE: &str = "COSIM_TEST_LIVES_OF";

#[test]
fn lives_of_a_remote_fmu_leave_nothing() {
    let made = Made::of(Integrator, &[]);
    let worker = made.worker("left");
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "remote::lives::lives", "--ignored", "--nocapture"])
        .env(VARIABLE, &made.fmu)
        .output()
        .unwrap();
    let (reported, why) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success() && reported.contains("1 passed"), "{reported}{why}");
    until("groups are left", || groups(&worker).is_empty());
}

#[test]
#[ignore = "counts what its process has: the test above starts it in one of its own"]
fn lives() {
    let Some(fmu) = std::env::var_os(VARIABLE).map(PathBuf::from) else { return };
    let live = || {
        let fmu = Fmu::open(&fmu).unwrap();
        let mut instance = Instance::new(fmu, "it", &Logging::default()).unwrap();
        initialize(&mut instance, &[]);
        step(&mut instance, 0).unwrap();
    };
    let count = |folder: &str| std::fs::read_dir(folder).unwrap().count();
    let has = || (count("/proc/self/fd"), count("/proc/self/task"));
    (0..LIVES).for_each(|_| live());
    let (bytes, before) = (allocated(), has());
    (0..LIVES).for_each(|_| live());
    let left = allocated().saturating_sub(bytes);
    assert!(left <= LEFT * LIVES, "{left} bytes are left of {LIVES} lives");
    assert_eq!(has(), before, "files or threads are left");
    until("processes are left", || children(std::process::id()).is_empty());
}

#[test]
fn nothing_outlives_a_host_that_is_killed() {
    let made = Made::of(Integrator, &[]);
    let worker = made.worker("left");
    let fmu = made.fmu.to_str().unwrap();
    let spans = [
        "--execution-tool",
        "--stop-time",
        "1e6",
        "--step-size",
        "0.1",
        "--output-interval",
        "1e5",
    ];
    let arguments = [&["simulate", fmu, "-o", "out.csv"][..], &spans].concat();
    let host = start(made.folder.path(), &arguments);
    until("nothing computes", || groups(&worker).len() == 1);
    let started = children(host.0.id());
    assert!(!started.is_empty());
    signal(host.0.id(), "-KILL");
    let left = remaining(&started);
    assert!(left.is_empty(), "{left:?}");
    until("groups are left", || groups(&worker).is_empty());
}
