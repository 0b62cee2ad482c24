//! States of a whole system: saved, restored, serialized, and refused if they are wrong.

use cosim::Time;
use cosim::fmi::{Instance, Place};

use super::{Exported, export, get, seconds, set, step};
use crate::models::Model::{Counter, Gain, Picky};
use crate::ssd::{Ssd, zoo};

const NAMES: [&str; 7] = ["mass.y", "slow.y", "p.y", "swing.y", "ball.y", "lag.y", "saw.y"];

fn on(instance: &mut Instance, from: u32, to: u32) -> [f64; 7] {
    (from..to).for_each(|k| step(instance, f64::from(k) * 0.05, f64::from(k + 1) * 0.05));
    NAMES.map(|name| get(instance, name))
}

#[test]
fn a_run_goes_on_from_its_state_here_and_elsewhere() {
    let exported = export(&zoo().write(), &[]);
    let mut first = exported.started();
    // In the middle of the steps of some components.
    let half = on(&mut first, 0, 13);
    first.save(Place::Snapshot).unwrap();
    let bytes = first.serialize().unwrap();
    let end = on(&mut first, 13, 30);
    assert_ne!(half, end);
    first.restore(Place::Snapshot, seconds(0.65)).unwrap();
    assert_eq!(NAMES.map(|name| get(&mut first, name)), half);
    assert_eq!(on(&mut first, 13, 30), end);
    let mut second = exported.started();
    on(&mut second, 0, 3);
    second.deserialize(&bytes, seconds(0.65)).unwrap();
    assert_eq!(on(&mut second, 13, 30), end);
    assert_eq!(second.serialize().unwrap(), first.serialize().unwrap());
}

#[test]
fn what_was_set_is_part_of_the_state() {
    let exported = export(&Ssd::new().add("g", Gain).write(), &[]);
    let mut first = exported.started();
    set(&mut first, "g.u", 4.0);
    let pending = first.serialize().unwrap();
    step(&mut first, 0.0, 0.1);
    let mut second = exported.instance();
    set(&mut second, "g.k", 2.0);
    second.enter_initialization(Time::ZERO, seconds(1.0)).unwrap();
    second.exit_initialization().unwrap();
    second.deserialize(&pending, Time::ZERO).unwrap();
    step(&mut second, 0.0, 0.1);
    assert_eq!(["g.u", "g.y", "g.k"].map(|name| get(&mut second, name)), [4.0, 4.0, 1.0]);
}

#[test]
fn a_discarded_step_is_made_again_from_a_state() {
    let system = Ssd::new().add_with("picky", Picky, &[("second", 0.1)], None);
    let exported = export(&system.write(), &["--step", "picky=0.1"]);
    let mut instance = exported.instance();
    instance.enter_initialization(Time::ZERO, seconds(1.0)).unwrap();
    instance.exit_initialization().unwrap();
    instance.save(Place::Retry).unwrap();
    step(&mut instance, 0.0, 0.1);
    let strict = Ssd::new().add_with("picky", Picky, &[("second", 0.05)], None);
    let exported = export(&strict.write(), &[]);
    let mut instance = exported.started();
    instance.save(Place::Retry).unwrap();
    for _ in 0..2 {
        assert!(instance.try_step(Time::ZERO, seconds(0.1)).unwrap() < seconds(0.1));
        instance.restore(Place::Retry, Time::ZERO).unwrap();
    }
    assert_eq!(instance.try_step(Time::ZERO, seconds(0.05)).unwrap(), seconds(0.05));
}

fn refused(exported: &Exported, bytes: &[u8], part: &str) {
    let error = exported.started().deserialize(bytes, Time::ZERO).unwrap_err().to_string();
    assert!(error.contains(part), "'{part}' is not in:\n{error}");
}

#[test]
fn bytes_that_are_no_state_of_this_system_are_refused() {
    let exported = export(&Ssd::new().add("g", Gain).write(), &[]);
    let bytes = exported.started().serialize().unwrap();
    refused(&exported, &bytes[..bytes.len() - 1], "hold");
    refused(&exported, b"nonsense", "too few");
    let mut altered = bytes.clone();
    altered[30] ^= 1;
    refused(&exported, &altered, "altered");
    let other = export(&Ssd::new().add("g", Counter).write(), &[]);
    refused(&other, &bytes, "another FMU");
}

#[test]
fn one_component_without_states_leaves_the_whole_without() {
    let folder = tempfile::TempDir::new().unwrap();
    let fmu = Gain.varied(folder.path(), "canSerializeFMUstate=\"true\"", "");
    let system = Ssd::new().add("a", Gain).add("b", Gain);
    let exported = export(&system.write(), &["--replace", &format!("b={}", fmu.display())]);
    assert!(!exported.description().contains("FMUstate"));
}
