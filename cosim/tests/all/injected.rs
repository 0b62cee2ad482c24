//! Faults that are injected into a running simulation, and the scenario that repeats them.

use cosim::scenario::{Injected, Scenario};
use cosim::{Controls, Manipulator, Overrides, Recording, Result, Run, Snapshot, System, Time};
use serde_json::{Map, Value, json};
use tempfile::TempDir;

use crate::models::Model::{Clock, Gain, Integrator};
use crate::ssd::Ssd;

fn chain() -> System {
    let ssd = Ssd::new().add("clock", Clock).add("g", Gain).add("x", Integrator).add("free", Gain);
    let ssd = ssd.connect("clock.y", "g.u").connect("g.y", "x.u").stop(2.0);
    ssd.load(&Overrides::new()).unwrap()
}

/// A user who injects faults, the next one last.
struct Person {
    faults: Vec<(Time, Map<String, Value>)>,
    injected: Injected,
    refused: Vec<String>,
}

impl Person {
    fn new(faults: &[(f64, Value)]) -> Self {
        let fault = |(seconds, fault): &(f64, Value)| {
            (Time::from_seconds(*seconds), fault.as_object().unwrap().clone())
        };
        let faults = faults.iter().rev().map(fault).collect();
        Self { faults, injected: Injected::default(), refused: Vec::new() }
    }
}

impl Manipulator for Person {
    fn next(&self) -> Option<Time> {
        self.faults.last().map(|(time, _)| *time)
    }

    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()> {
        while let Some((_, fault)) = self.faults.pop_if(|(time, _)| *time <= now) {
            if let Err(error) = self.injected.inject(&fault, now, controls) {
                self.refused.push(error.to_string());
            }
        }
        Ok(())
    }
}

fn run(system: &System, manipulator: &mut dyn Manipulator) -> Recording {
    let mut recording = Recording::new();
    Run::new(system).observe(&mut recording).manipulate(manipulator).go().unwrap();
    recording
}

fn read(text: &str) -> Scenario {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("s.toml");
    std::fs::write(&file, text).unwrap();
    Scenario::read(&file).unwrap()
}

#[test]
fn the_scenario_of_what_was_injected_makes_the_same_run() {
    let system = chain();
    let mut person = Person::new(&[
        // It remembers values from before its start, if it was installed then.
        (0.4, json!({ "kind": "latency", "on": "g.u", "delay": 0.25, "jitter": 0.2 })),
        (0.4, json!({ "kind": "white-noise", "on": ["g.*"], "sigma": 0.5, "for": 0.7 })),
        (0.7, json!({ "kind": "reset", "on": "x" })),
        (0.9, json!({ "kind": "lag", "on": "g.y", "tau": 0.3 })),
        (1.1, json!({ "kind": "override", "on": "free.u", "value": -2, "until": 1.6 })),
        (1.3, json!({ "kind": "gauss-markov", "on": "x.y", "sigma": 1, "tau": 0.4 })),
    ]);
    let touched = run(&system, &mut person);
    assert_eq!(person.refused, Vec::<String>::new());
    let text = person.injected.text().unwrap();
    let again = run(&system, &mut read(text));
    assert_eq!(touched, again);
    // Faults that are installed from the start see more.
    let early: String =
        text.lines().filter(|l| !l.starts_with("installed")).map(|l| format!("{l}\n")).collect();
    assert_ne!(touched, run(&system, &mut read(&early)));
    assert_ne!(touched, run(&system, &mut Person::new(&[])));

    // A resumed run injects only what is still to come, and nothing twice.
    let (mut snapshots, at) = (Vec::new(), [Time::from_seconds(0.8)]);
    let mut keep = |snapshot: Snapshot| {
        snapshots.push(snapshot);
        Ok(())
    };
    Run::new(&system).manipulate(&mut read(text)).snapshots(None, &at, &mut keep).go().unwrap();
    let (mut rest, mut scenario) = (Recording::new(), read(text));
    let run = Run::new(&system).observe(&mut rest).manipulate(&mut scenario);
    run.resume(&snapshots[0]).go().unwrap();
    for (name, values) in rest.columns() {
        let whole = touched.column(name).unwrap();
        assert_eq!(values, &whole[whole.len() - values.len()..], "{name}");
    }
}

#[test]
fn what_cannot_be_injected_is_reported_and_changes_nothing() {
    let system = chain();
    let mut person = Person::new(&[
        (0.2, json!({ "kind": "bias", "on": "g.yy", "value": 1 })),
        (0.2, json!({ "kind": "byas", "on": "g.y", "value": 1 })),
        (0.2, json!({ "kind": "bias", "on": "g.y" })),
        (0.2, json!({ "kind": "bias", "on": "g.y", "value": 1, "from": 0.5 })),
        (0.2, json!({ "kind": "bias", "on": "g.y", "value": 1, "when": "x.y > 1" })),
        (0.2, json!({ "kind": "bias", "on": "g.y", "value": null })),
        (0.2, json!({ "kind": "bias\"\non = \"x.y", "on": "g.y", "value": 1 })),
        (0.2, json!({ "kind": "bias", "on": "g.y", "value": 1, "x]\n[y": 2 })),
    ]);
    let left = run(&system, &mut person);
    let parts = [
        "did you mean 'y'",
        "'bias'",
        "'value' is missing",
        "'from'",
        "'when'",
        "not a number",
        "no fault",
        "is unknown",
    ];
    assert_eq!(person.refused.len(), parts.len());
    for (part, reported) in parts.iter().zip(&person.refused) {
        assert!(reported.contains(part), "{part}: {reported}");
    }
    assert_eq!(person.injected.text(), None);
    assert_eq!(left, run(&system, &mut Person::new(&[])));
}
