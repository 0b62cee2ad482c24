//! Manipulators and scenarios.

use cosim::observe::Stop;
use cosim::scenario::Scenario;
use cosim::{
    Algorithm, Controls, Manipulator, Overrides, Recording, Result, Run, Snapshot, System, Time,
};
use tempfile::TempDir;

use crate::models::Model::{Clock, Counter, Gain, Integrator, Lag};
use crate::ssd::{Ssd, assert_near};

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

/// Clock -> gain -> integrator; the second gain is not connected.
fn system(overrides: &Overrides) -> System {
    Ssd::new()
        .add("clock", Clock)
        .add("g", Gain)
        .add("x", Integrator)
        .add("free", Gain)
        .connect("clock.y", "g.u")
        .connect("g.y", "x.u")
        .stop(0.6)
        .load(overrides)
        .unwrap()
}

fn scenario(text: &str) -> Result<Scenario> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("s.json");
    std::fs::write(&file, text).unwrap();
    Scenario::read(&file)
}

pub(crate) fn play(system: &System, text: &str) -> Recording {
    let (mut scenario, mut recording) = (scenario(text).unwrap(), Recording::new());
    Run::new(system).observe(&mut recording).manipulate(&mut scenario).go().unwrap();
    recording
}

/// The recorded value is the one that the next component gets, even where the manipulation is
/// between two values of the type.
#[test]
fn a_manipulated_value_keeps_its_type() {
    let ssd = Ssd::new().add("a", Counter).add("b", Counter).stop(0.4);
    let system = ssd.connect("a.n", "b.m").connect("a.even", "b.odd").load(&Overrides::new());
    let system = system.unwrap();
    let text = r#"{"events": [
        {"time": 0.1, "model": "a", "variable": "n", "action": "bias", "value": 9.7},
        {"time": 0.1, "model": "a", "variable": "even", "action": "override", "value": 0.2}]}"#;
    let results = play(&system, text);
    let column = |name: &str| results.column(name).unwrap();
    assert_eq!(column("a.n"), [0.0, 1.0, 12.0, 13.0, 14.0]);
    assert_eq!(column("b.n"), [0.0, 2.0, 14.0, 16.0, 18.0]);
    assert_eq!(column("a.even"), [1.0; 5]);
    assert_eq!(column("b.even"), [0.0; 5]);
}

#[test]
fn connected_inputs_outputs_and_free_inputs_are_manipulated_and_released() {
    let text = r#"{"defaults": {"action": "override"}, "events": [
        {"time": 0.1, "model": "g", "variable": "u", "value": 7},
        {"time": 0.3, "model": "g", "variable": "u", "action": "reset"},
        {"time": 0.1, "model": "free", "variable": "u", "value": 5},
        {"time": 0.2, "model": "free", "variable": "u", "action": "bias", "value": 0.5},
        {"time": 0.4, "model": "free", "variable": "u", "action": "reset"},
        {"time": 0.4, "model": "g", "variable": "y", "action": "bias", "value": 100}]}"#;
    let overrides = Overrides::new().start_value("free.u", 2);
    let results = play(&system(&overrides), text);
    assert_near(results.column("g.y").unwrap(), &[0.0, 0.1, 7.0, 7.0, 0.4, 100.5, 100.6]);
    assert_near(results.column("free.y").unwrap(), &[2.0, 2.0, 5.0, 2.5, 2.5, 2.0, 2.0]);
    // x holds the value of g at the start of the step; 100.5 is used from 0.5 s on.
    assert_near(results.column("x.y").unwrap(), &[0.0, 0.0, 0.01, 0.71, 1.41, 1.45, 11.5]);
    let jacobi = play(&system(&overrides.algorithm(Algorithm::Jacobi)), text);
    assert_near(jacobi.column("g.y").unwrap(), &[0.0, 0.0, 7.0, 7.0, 0.3, 100.4, 100.5]);
}

#[test]
fn integers_booleans_and_model_exchange_are_manipulated() {
    let ssd = Ssd::new().add("c", Counter).add("lag", Lag).stop(0.3);
    let system = ssd.load(&Overrides::new()).unwrap();
    let text = r#"{"defaults": {"action": "override"}, "end": 0.25, "events": [
        {"time": 0.1, "model": "c", "variable": "odd", "value": true},
        {"time": 0.1, "model": "c", "variable": "m", "value": 40},
        {"time": 0.1, "model": "lag", "variable": "odd", "value": true},
        {"time": 0.1, "model": "lag", "variable": "u", "value": 1}]}"#;
    let results = play(&system, text);
    // The end at 0.25 s comes after the output instant 0.2 s.
    assert_near(results.time(), &[0.0, 0.1, 0.2]);
    assert_near(results.column("c.n").unwrap(), &[0.0, 1.0, 42.0]);
    assert_near(results.column("c.even").unwrap(), &[1.0, 1.0, 0.0]);
    // The discrete input is an event, and u moves the indicator: n counts both and the start.
    assert_near(results.column("lag.n").unwrap(), &[1.0, 1.0, 3.0]);
    assert!(results.column("lag.y").unwrap()[2] > 0.09);
}

#[test]
fn a_scenario_is_checked_before_the_run() {
    let system = system(&Overrides::new());
    let refused = |event: &str, part: &str| {
        let mut scenario = scenario(&format!("{{\"events\": [{event}]}}")).unwrap();
        let mut recording = Recording::new();
        let run = Run::new(&system).observe(&mut recording).manipulate(&mut scenario);
        let error = run.go().unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
        assert!(recording.names().is_empty(), "nothing was run");
    };
    let event = |model: &str, variable: &str| {
        format!(
            "{{\"time\": 0.5, \"action\": \"override\", \"value\": 1, \"model\": \"{model}\", \
             \"variable\": \"{variable}\"}}"
        )
    };
    refused(&event("gg", "u"), "did you mean 'g'");
    refused(&event("g", "uu"), "did you mean 'u'");
    refused(&event("g", "k"), "tunable");
    refused(&event("g", "text"), "String");
}

#[test]
fn a_resumed_run_keeps_what_was_manipulated_and_does_not_do_it_again() {
    let system = system(&Overrides::new());
    let text = r#"{"defaults": {"model": "g", "variable": "u"}, "events": [
        {"time": 0.1, "action": "bias", "value": 1},
        {"time": 0.3, "model": "free", "action": "override", "value": 4},
        {"time": 0.5, "action": "reset"}]}"#;
    let (mut whole, mut kept) = (Recording::new(), Vec::new());
    let mut keep = |snapshot: Snapshot| {
        kept.push(snapshot);
        Ok(())
    };
    let mut first = scenario(text).unwrap();
    let run = Run::new(&system).observe(&mut whole).manipulate(&mut first);
    run.snapshots(Some(seconds(0.1)), &[], &mut keep).go().unwrap();
    for snapshot in &kept[..5] {
        let (mut rest, mut again) = (Recording::new(), scenario(text).unwrap());
        let run = Run::new(&system).observe(&mut rest).manipulate(&mut again).resume(snapshot);
        run.go().unwrap();
        for (name, values) in rest.columns() {
            let all = whole.column(name).unwrap();
            assert_eq!(values, &all[all.len() - values.len()..], "{name} {}", snapshot.time());
        }
    }
}

#[test]
fn a_manipulator_of_ones_own_acts_when_it_wants_and_may_end_the_run() {
    struct Stutter(Time, u32);
    impl Manipulator for Stutter {
        fn next(&self) -> Option<Time> {
            Some(self.0)
        }
        fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()> {
            self.1 += 1;
            controls.set("free.u", f64::from(self.1))?;
            if self.1 == 5 {
                controls.end(Stop::Enough);
            }
            self.0 = now + seconds(0.05);
            Ok(())
        }
    }
    let system = system(&Overrides::new());
    let (mut stutter, mut recording) = (Stutter(seconds(0.0), 0), Recording::new());
    let run = Run::new(&system).observe(&mut recording).manipulate(&mut stutter);
    let summary = run.go().unwrap();
    assert_eq!((summary.stopped, summary.simulated), (Some(Stop::Enough), 0.2));
    assert_near(recording.column("free.y").unwrap(), &[0.0, 2.0, 4.0]);
}

#[test]
fn an_end_after_the_last_output_instant_ends_the_run_there() {
    let system = system(&Overrides::new().output_interval(0.4));
    let mut scenario = scenario(r#"{"events": [], "end": 0.5}"#).unwrap();
    let summary = Run::new(&system).manipulate(&mut scenario).go().unwrap();
    assert_eq!((summary.stopped, summary.simulated), (Some(Stop::Enough), 0.5));
}
