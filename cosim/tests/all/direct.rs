//! Direct steps, which begin after the timed instants, give the same results as steps by the
//! slaves.

use std::sync::Arc;

use cosim::fmi::Trace;
use cosim::scenario::Scenario;
use cosim::{Algorithm, Overrides, Recording, Run};
use tempfile::TempDir;

use crate::models::Model::{Clock, Counter, Failing, Gain, Integrator, Lag};
use crate::ssd::Ssd;

/// Calls that are followed are made by the slaves.
fn followed(overrides: &Overrides) -> Overrides {
    overrides.clone().trace(Arc::new(Trace::new(std::io::sink(), true)))
}

/// Slow and fast components, model exchange in between, an input that is overridden for a while.
fn play(overrides: &Overrides) -> Recording {
    let ssd = Ssd::new()
        .add("clock", Clock)
        .add_with("slow", Gain, &[("k", 3.0)], Some(0.2))
        .add("lag", Lag)
        .add("x", Integrator)
        .add("counter", Counter)
        .connect("clock.y", "slow.u")
        .connect("slow.y", "lag.u")
        .connect("lag.y", "x.u")
        .connect("x.y", "counter.u")
        .stop(40.0);
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("s.json");
    let text = r#"{"defaults": {"action": "override"}, "events": [
        {"time": 20, "model": "slow", "variable": "u", "value": 7},
        {"time": 30, "model": "slow", "variable": "u", "action": "reset"}]}"#;
    std::fs::write(&file, text).unwrap();
    let (mut scenario, mut recording) = (Scenario::read(&file).unwrap(), Recording::new());
    let system = ssd.load(overrides).unwrap();
    Run::new(&system).observe(&mut recording).manipulate(&mut scenario).go().unwrap();
    recording
}

#[test]
fn they_give_the_same_bits() {
    for algorithm in [Algorithm::GaussSeidel, Algorithm::Jacobi] {
        let overrides = Overrides::new().algorithm(algorithm);
        let (direct, by_slave) = (play(&overrides), play(&followed(&overrides)));
        assert_eq!(direct, by_slave);
        let last = |name: &str| *direct.column(name).unwrap().last().unwrap();
        assert_eq!(last("counter.y"), 400.0);
        assert_eq!(direct.column("slow.y").unwrap()[250], 21.0);
        assert!(last("slow.y") > 119.0 && last("x.y") > 100.0);
    }
}

#[test]
fn a_late_failure_says_when_and_why() {
    let ssd = Ssd::new().add("clock", Clock).add_with("pump", Failing, &[("second", 25.05)], None);
    let ssd = ssd.connect("clock.y", "pump.u").stop(40.0);
    let fail = |overrides: &Overrides| {
        let system = ssd.load(overrides).unwrap();
        let mut recording = Recording::new();
        let error = system.run(&mut [&mut recording]).unwrap_err().to_string();
        (error, recording)
    };
    let (error, results) = fail(&Overrides::new());
    for part in ["fmi2DoStep of 'pump'", "t = 25 s", "returned Error", "the tank is empty"] {
        assert!(error.contains(part), "{part} in {error}");
    }
    assert_eq!(results, fail(&followed(&Overrides::new())).1);
    assert_eq!(results.time().len(), 251);
}
