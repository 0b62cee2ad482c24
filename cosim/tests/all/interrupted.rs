//! Signals to a run with an FMU: when it ends, with which results, and what is left.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use tempfile::TempDir;

use crate::attacks::attacker;
use crate::distributed::{cosim, remaining, signal};

/// A signal ends a run in an FMU that does not return; its results are kept.
#[test]
fn one_signal_ends_a_run_in_an_fmu_that_spins() {
    let folder = TempDir::new().unwrap();
    let fmu = attacker(folder.path(), "REPORT(0); for (;;) __asm__ volatile(\"\")");
    for more in [&[][..], &["--isolate"]] {
        let arguments = ["simulate", fmu.to_str().unwrap(), "-o", "out.csv", "--debug-logging"];
        let mut command = cosim(folder.path(), &[&arguments, more].concat());
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        assert!(lines.any(|line| line.contains("attack: done")));
        signal(child.id(), "-TERM");
        let shown: Vec<String> = lines.collect();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{shown:?}");
        assert!(shown.iter().any(|line| line.contains("[E303]")), "{shown:?}");
        let results = cosim::Recording::read_csv(folder.path().join("out.csv"));
        assert!(!more.is_empty() || results.unwrap().time().len() >= 2, "{shown:?}");
    }
}

/// Starts a process that lingers, then never returns.
const LEAVES_A_CHILD: &str = "if (!fork()) { setsid(); linger(in_home(\"lingers\")); } \
                              while (access(in_home(\"lingers\"), F_OK)) sched_yield(); \
                              REPORT(0); for (;;) __asm__ volatile(\"\")";

/// What FMUs have started ends with the run even then.
#[test]
fn a_second_signal_ends_a_run_at_once_with_all_its_processes() {
    let home = TempDir::new().unwrap();
    let fmu = attacker(home.path(), LEAVES_A_CHILD);
    let arguments = ["simulate", fmu.to_str().unwrap(), "-o", "out.csv", "--debug-logging"];
    let mut command = cosim(home.path(), &arguments);
    command.env("HOME", home.path()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("attack: done")));
    // Those that are there when the process looks count as one, so there have to be more.
    let mut shown = Vec::new();
    std::thread::scope(|scope| {
        let read = scope.spawn(|| lines.collect::<Vec<String>>());
        while !read.is_finished() {
            signal(child.id(), "-TERM");
        }
        shown = read.join().unwrap();
    });
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130), "{shown:?}");
    assert!(shown.iter().any(|line| line.contains("a second signal has arrived")), "{shown:?}");
    let lingers = std::fs::read_to_string(home.path().join("lingers")).unwrap();
    assert!(remaining(&[lingers.parse().unwrap()]).is_empty());
}

/// timeout(1) sends a signal to the process, and then to its group.
#[test]
fn signals_that_arrive_together_end_a_run_with_its_results() {
    let folder = TempDir::new().unwrap();
    let fmu = attacker(folder.path(), "REPORT(0)");
    let arguments = ["simulate", fmu.to_str().unwrap(), "-o", "out.csv", "--debug-logging"];
    let paced = ["--real-time", "--stop-time", "1000"];
    let mut command = cosim(folder.path(), &[&arguments[..], &paced].concat());
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("attack: done")));
    ["-STOP", "-TERM", "-INT", "-HUP", "-CONT"].iter().for_each(|what| signal(child.id(), what));
    let shown: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{shown:?}");
    assert!(shown.iter().any(|line| line.contains("s after its start")), "{shown:?}");
}

/// Only the process of the run defers signals.
#[test]
fn a_signal_ends_a_child_that_an_fmu_has_forked() {
    let folder = TempDir::new().unwrap();
    let fmu = attacker(
        folder.path(),
        "const int child = fork(); if (!child) { alarm(20); pause(); _exit(0); } int status; \
         kill(child, SIGTERM); waitpid(child, &status, 0); REPORT(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM ? 0 : -1)",
    );
    let arguments = ["simulate", fmu.to_str().unwrap(), "-o", "out.csv", "--debug-logging"];
    let output = cosim(folder.path(), &arguments).output().unwrap();
    let shown = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && shown.contains("attack: done"), "{shown}");
}
