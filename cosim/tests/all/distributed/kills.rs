//! Whatever is killed or stopped: the run continues, with the same bytes, and leaves nothing
//! behind.

use std::io::{BufRead, BufReader};

use super::*;

/// A run of `system` that is disturbed by `disturb`; returns its messages. Its bytes are those of
/// an ordinary run, and nothing of it is left behind.
fn survives(system: &str, workers: &str, disturb: impl FnOnce(&mut Child)) -> String {
    let folder = TempDir::new().unwrap();
    let here = undisturbed(folder.path(), system);
    let arguments = ["run", system, "-o", "there.csv", "--workers", workers];
    let mut run = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
    disturb(&mut run);
    let started = below(run.id());
    let output = run.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    assert!(here == results(folder.path(), "there.csv"), "{stderr}");
    assert!(remaining(&started).is_empty(), "{stderr}");
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
    stderr
}

/// A system in which one group waits in the middle of the run for the disturbance.
fn waiting(folder: &TempDir) -> String {
    with(folder.path(), 2.0, &["FIRST_INCARNATION=wait_for_the_end()"], |description| description)
}

#[test]
fn killed_groups_and_workers_change_no_byte_and_leave_nothing() {
    let file = chain(2000.0);
    let reported = survives(file.write().to_str().unwrap(), "3", |run| {
        let mut dice = Dice(3);
        for round in 0..12 {
            let groups = groups_below(run, 1);
            std::thread::sleep(Duration::from_millis(dice.below(120)));
            let victims = if round % 4 == 3 { children(run.id()) } else { groups };
            if let Some(&victim) = victims.get(dice.below(victims.len() as u64) as usize) {
                signal(victim, "-KILL");
            }
        }
    });
    assert!(reported.contains("went on at worker"), "{reported}");
    assert!(reported.contains("was killed by SIGKILL"), "{reported}");
}

#[test]
fn the_only_worker_is_started_again() {
    let folder = TempDir::new().unwrap();
    let reported = survives(&waiting(&folder), "1", |run| {
        assert!(!groups_below(run, 1).is_empty());
        let workers = children(run.id());
        waiting_below(&workers);
        workers.into_iter().for_each(|worker| signal(worker, "-KILL"));
    });
    assert!(reported.contains("went on at worker worker-1"), "{reported}");
}

#[test]
fn a_stopped_group_is_named_and_replaced() {
    let folder = TempDir::new().unwrap();
    let reported = survives(&waiting(&folder), "2", |run| {
        assert!(!groups_below(run, 2).is_empty());
        signal(waiting_below(&children(run.id())), "-STOP");
    });
    assert!(reported.contains("its process is stopped"), "{reported}");
}

#[test]
fn a_stopped_worker_is_harmless_when_it_comes_back() {
    let folder = TempDir::new().unwrap();
    let system = waiting(&folder);
    let here = undisturbed(folder.path(), &system);
    let place = endpoint();
    let arguments = ["run", &system, "-o", "there.csv", "--distributed", "--listen", &place];
    let more = ["--min-workers", "2", "--wait", "20"];
    let arguments = [&arguments[..], &more].concat();
    let mut run = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let left = Kept::worker(folder.path(), "left", &place);
    let right = Kept::worker(folder.path(), "right", &place);
    let group = waiting_below(&[left.id(), right.id()]);
    let (worker, other) = match status(group) {
        Some((_, parent)) if parent == left.id() => (parent, "right"),
        _ => (right.id(), "left"),
    };
    // With everything it started, as if its machine had been disconnected.
    let cut = [worker, group];
    cut.iter().for_each(|&process| signal(process, "-STOP"));
    let mut messages = BufReader::new(run.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(messages.any(|line| line.contains(&format!("went on at worker {other}"))));
    cut.iter().for_each(|&process| signal(process, "-CONT"));
    let rest: Vec<String> = messages.collect();
    assert!(run.wait().unwrap().success(), "{rest:?}");
    assert!(here == results(folder.path(), "there.csv"), "{rest:?}");
    // The worker has ended its work for a run that is over.
    assert!(remaining(&[group]).is_empty());
}

#[test]
fn an_interrupted_run_leaves_no_process_and_no_folder() {
    let (file, folder) = (chain(1e6), TempDir::new().unwrap());
    let file = file.write();
    for name in ["-INT", "-KILL"] {
        let arguments = ["run", file.to_str().unwrap(), "-q", "-o", "x.csv", "--workers", "2"];
        let mut run = cosim(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap();
        assert!(!groups_below(&run, 2).is_empty());
        let started = below(run.id());
        signal(run.id(), name);
        run.wait().unwrap();
        assert!(remaining(&started).is_empty(), "{name}");
        if name == "-INT" {
            assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
        }
    }
}
