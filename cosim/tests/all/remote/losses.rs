//! Workers that are killed or stopped, and workers that never connect.

use std::time::{Duration, Instant};

use super::{Made, groups, here, programs, set, step, steps, until};
use crate::distributed::signal;
use crate::models::Model::Integrator;

#[test]
fn another_worker_goes_on_from_the_last_state_with_the_same_bits() {
    let made = Made::of(Integrator, &["--save-every", "7"]);
    let left = made.worker("left");
    let mut it = made.started(&[("k", 0.3)]);
    let mut found = steps(&mut it, 0..30);
    let _right = made.worker("right");
    for process in [vec![left.0.id()], groups(&left)].concat() {
        signal(process, "-KILL");
    }
    found.extend(steps(&mut it, 30..60));
    assert_eq!(found, steps(&mut here(Integrator, &[("k", 0.3)]), 0..60));
    let said = made.said().join("\n");
    assert!(said.contains("lost at worker left") && said.contains("at worker right"), "{said}");
}

#[test]
fn a_process_that_is_killed_again_and_again_changes_no_bit() {
    let made = Made::of(Integrator, &["--save-every", "0"]);
    let worker = made.worker("left");
    let mut it = made.started(&[]);
    let mut found = Vec::new();
    for part in 0..4 {
        found.extend(steps(&mut it, part * 10..part * 10 + 10));
        groups(&worker).into_iter().for_each(|process| signal(process, "-KILL"));
    }
    assert_eq!(found, steps(&mut here(Integrator, &[]), 0..40));
}

#[test]
fn a_group_that_is_stopped_is_given_up() {
    let made = Made::of(Integrator, &["--deadline", "0.3"]);
    let worker = made.worker("left");
    let mut it = made.started(&[]);
    let mut found = steps(&mut it, 0..5);
    groups(&worker).into_iter().for_each(|process| signal(process, "-STOP"));
    found.extend(steps(&mut it, 5..10));
    assert_eq!(found, steps(&mut here(Integrator, &[]), 0..10));
}

#[test]
fn no_worker_in_time_is_an_error_that_names_worker_call_and_time() {
    let made = Made::of(Integrator, &["--wait", "1"]);
    let error = made.make().err().unwrap().to_string();
    for part in ["no worker", &made.endpoint, "waited for 1.", "cosim worker --connect"] {
        assert!(error.contains(part), "'{part}' is not in:\n{error}");
    }

    let worker = made.worker("left");
    let mut it = loop {
        if let Ok(instance) = made.make() {
            break instance;
        }
    };
    super::initialize(&mut it, &[]);
    steps(&mut it, 0..5);
    for process in [vec![worker.0.id()], groups(&worker)].concat() {
        signal(process, "-KILL");
    }
    let error = step(&mut it, 5).unwrap_err();
    assert_eq!(error.status(), Some(3), "{error}");
    let said = made.said();
    let lines: Vec<&String> = said.iter().filter(|line| line.starts_with("fmi2DoStep: ")).collect();
    assert_eq!(lines.len(), 1, "{said:?}");
    for part in ["it is lost at worker left", "waited for ", "no worker"] {
        assert!(lines[0].contains(part), "'{part}' is not in:\n{}", lines[0]);
    }
}

#[test]
fn ending_does_not_wait_for_a_worker_that_is_gone() {
    let made = Made::of(Integrator, &["--deadline", "600"]);
    let worker = made.worker("left");
    let before = programs().len();
    let mut it = made.started(&[]);
    steps(&mut it, 0..3);
    set(&mut it, "u", 2.0);
    for process in [groups(&worker), vec![worker.0.id()]].concat() {
        signal(process, "-STOP");
    }
    let begun = Instant::now();
    drop(it);
    assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
    until("programs are left", || programs().len() <= before);
}

#[test]
fn what_computes_ends_with_the_instance() {
    let made = Made::of(Integrator, &[]);
    let worker = made.worker("left");
    let mut it = made.started(&[]);
    steps(&mut it, 0..3);
    assert_eq!(groups(&worker).len(), 1);
    drop(it);
    until("groups are left", || groups(&worker).is_empty());
}
