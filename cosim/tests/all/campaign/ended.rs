//! What ends with a campaign: everything that FMUs started in the processes that make its runs.

use std::path::Path;
use std::process::{Child, Stdio};

use tempfile::TempDir;

use crate::attacks::{attacker, one_component};
use crate::distributed::{children, cosim, remaining, signal};

/// Starts a process that lingers.
const START: &str = "if (!fork()) { setsid(); linger(in_home(\"lingers\")); } \
                     while (access(in_home(\"lingers\"), F_OK)) sched_yield();";
const SPIN: &str = "for (;;) __asm__ volatile(\"\")";

/// A campaign of one component that does this in a step; `more` is about the campaign.
fn prepare(folder: &Path, attack: &str, more: &str) {
    let fmu = attacker(folder, attack);
    std::fs::write(folder.join("s.ssd"), one_component(fmu.to_str().unwrap())).unwrap();
    let figures = "[systems]\na = 's.ssd'\n[figures.f]\nkind = 'max'\nof = 'attacker.y'\n";
    std::fs::write(folder.join("c.toml"), format!("{more}\n{figures}")).unwrap();
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = cosim(folder, arguments);
    command.env("HOME", folder).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

const CAMPAIGN: [&str; 4] = ["campaign", "c.toml", "--jobs", "1"];

/// The process that the FMU started, as soon as there is one.
fn started(folder: &Path) -> u32 {
    loop {
        let text = std::fs::read_to_string(folder.join("lingers"));
        // A file that has just been created is empty.
        if let Some(number) = text.ok().and_then(|text| text.parse().ok()) {
            return number;
        }
        std::thread::yield_now();
    }
}

#[test]
fn a_killed_campaign_leaves_no_process() {
    let folder = TempDir::new().unwrap();
    prepare(folder.path(), &[START, SPIN].concat(), "seeds = 1");
    let mut campaign = start(folder.path(), &CAMPAIGN);
    let lingers = started(folder.path());
    let all = [children(campaign.id()), vec![lingers]].concat();
    campaign.kill().unwrap();
    campaign.wait().unwrap();
    assert_eq!(all.len(), 2);
    assert!(remaining(&all).is_empty());
}

/// The kernel may report the end of a parent once for each of its threads.
#[test]
fn a_process_that_learns_twice_of_the_end_of_its_campaign_leaves_no_process() {
    let folder = TempDir::new().unwrap();
    prepare(folder.path(), &[START, SPIN].concat(), "seeds = 1");
    let mut campaign = start(folder.path(), &CAMPAIGN);
    let lingers = started(folder.path());
    let [maker] = children(campaign.id())[..] else { panic!("there is one process") };
    signal(campaign.id(), "-STOP");
    signal(maker, "-TERM");
    // The first one has been handled when nothing is pending.
    while pending(maker) {
        std::thread::yield_now();
    }
    signal(maker, "-TERM");
    let left = remaining(&[lingers]);
    campaign.kill().unwrap();
    campaign.wait().unwrap();
    assert!(left.is_empty());
}

/// Whether a signal has not been handled yet.
fn pending(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let lines = status.lines().filter_map(|line| line.strip_prefix("ShdPnd:"));
    lines.map(str::trim).any(|signals| signals.bytes().any(|digit| digit != b'0'))
}

#[test]
fn an_interrupted_campaign_leaves_no_process() {
    let folder = TempDir::new().unwrap();
    prepare(folder.path(), START, "seeds = 20000");
    let mut campaign = start(folder.path(), &CAMPAIGN);
    let process = started(folder.path());
    signal(campaign.id(), "-INT");
    assert_eq!(campaign.wait().unwrap().code(), Some(130));
    assert!(remaining(&[process]).is_empty());
}

#[test]
fn a_run_that_takes_too_long_leaves_no_process() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    prepare(at, &[START, SPIN].concat(), "seeds = 1\ntime-limit = 0.5");
    start(at, &CAMPAIGN).wait().unwrap();
    let rows = std::fs::read_to_string(at.join("c_campaign/runs.jsonl")).unwrap();
    assert!(rows.contains("timed-out"), "{rows}");
    assert!(remaining(&[started(at)]).is_empty());
}

/// The process that makes runs continues; what an FMU started in one of them does not.
#[test]
fn a_run_finds_no_process_of_the_one_before() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let look = "int before = 0; FILE *file = fopen(in_home(\"lingers\"), \"r\"); \
                if (file) { fscanf(file, \"%d\", &before); fclose(file); \
                remove(in_home(\"lingers\")); \
                fclose(fopen(in_home(kill(before, 0) ? \"gone\" : \"there\"), \"w\")); }";
    prepare(at, &[look, START].concat(), "seeds = 5");
    assert!(start(at, &CAMPAIGN).wait().unwrap().success());
    assert!(at.join("gone").exists() && !at.join("there").exists());
    // A page makes some runs again, in its own process.
    std::fs::remove_file(at.join("lingers")).unwrap();
    let report = ["report", "c_campaign", "-o", "page.html"];
    assert!(start(at, &report).wait().unwrap().success());
    assert!(remaining(&[started(at)]).is_empty());
}
