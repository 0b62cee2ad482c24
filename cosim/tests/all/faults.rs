//! Faults from files: their effects, and that these are the same however a run is made.

use cosim::scenario::Scenario;
use cosim::{Algorithm, Overrides, Recording, Result, Run, Snapshot, System, Time};
use tempfile::TempDir;

use crate::distributed::{outcome, results};
use crate::models::Model::{Clock, Gain, Integrator};
use crate::ssd::{Ssd, assert_near};

/// Clock -> gain -> integrator; the second gain is not connected.
fn chain(stop: f64) -> Ssd {
    Ssd::new()
        .add("clock", Clock)
        .add("g", Gain)
        .add("x", Integrator)
        .add("free", Gain)
        .connect("clock.y", "g.u")
        .connect("g.y", "x.u")
        .stop(stop)
}

fn scenario(text: &str) -> Result<Scenario> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("s.toml");
    std::fs::write(&file, text).unwrap();
    Scenario::read(&file)
}

fn play(system: &System, text: &str) -> Recording {
    let (mut scenario, mut recording) = (scenario(text).unwrap(), Recording::new());
    Run::new(system).observe(&mut recording).manipulate(&mut scenario).go().unwrap();
    recording
}

/// Faults of every kind: state, memory, random numbers, several on one variable.
const MANY: &str = r#"
seed = 11
[[fault]]
kind = "white-noise"
on = "g.u"
sigma = 0.1
from = 0.2
[[fault]]
kind = "latency"
on = ["g.u", "g.y"]
delay = 0.2
jitter = 0.3
[[fault]]
kind = "gauss-markov"
on = "x.y"
sigma = 1
tau = 0.5
between = [0.3, 0.8]
[[fault]]
kind = "drop-out"
on = "x.y"
up = 0.3
down = 0.2
[[fault]]
kind = "stuck"
on = "free.y"
from = 1
for = 0.5
[[fault]]
kind = "drift"
on = "free.u"
rate = 2
ramp-in = 0.5
[[fault]]
kind = "reordering"
on = ["g.y", "x.y"]
share = 0.3
delay = 0.25
every = 0.2
[[fault]]
kind = "lag"
on = "g.u"
tau = 0.3
[[fault]]
kind = "reset"
on = "x"
from = 1.1
[[fault]]
kind = "release"
on = "x.y"
from = 1.4
for = 0.3
[[fault]]
kind = "bias"
value = 3
on = "g.y"
when = "clock.y > 0.75"
for = 0.6
[[fault]]
kind = "reset"
on = "x"
when = "clock.y > 1.45"
"#;

#[test]
fn inputs_outputs_and_free_variables_have_faults_in_their_windows() {
    let system = chain(0.6).load(&Overrides::new().start_value("free.u", 2)).unwrap();
    let text = r#"
        [[fault]]
        kind = "override"
        value = 7
        on = "g.u"
        from = 0.1
        until = 0.3
        [[fault]]
        kind = "bias"
        value = 100
        on = "g.y"
        from = 0.4
        [[fault]]
        kind = "scale"
        factor = 2
        on = "g.y"
        from = 0.5
        [[fault]]
        kind = "ramp"
        value = 1
        over = 0.2
        on = "free.u"
        from = 0.1
        for = 0.3
    "#;
    let results = play(&system, text);
    assert_near(results.column("g.y").unwrap(), &[0.0, 0.1, 7.0, 7.0, 0.4, 100.5, 201.2]);
    // A step holds the value of the ramp at its start.
    assert_near(results.column("free.y").unwrap(), &[2.0, 2.0, 2.0, 2.5, 3.0, 2.0, 2.0]);
    assert_near(results.column("x.y").unwrap(), &[0.0, 0.0, 0.01, 0.71, 1.41, 1.45, 11.5]);
}

#[test]
fn a_free_input_that_is_recorded_is_set_all_the_same() {
    let system = chain(0.3).load(&Overrides::new().output_variable("free.*")).unwrap();
    let text = "[[fault]]\nkind = \"bias\"\nvalue = 5\non = \"free.u\"\nfrom = 0.1";
    let results = play(&system, text);
    assert_near(results.column("free.u").unwrap(), &[0.0, 0.0, 5.0, 5.0]);
    assert_near(results.column("free.y").unwrap(), &[0.0, 0.0, 5.0, 5.0]);
}

#[test]
fn a_component_that_is_reset_begins_anew_and_a_release_ends_what_is_before_it() {
    let system = chain(0.6).load(&Overrides::new()).unwrap();
    let text = "[[fault]]\nkind = \"reset\"\non = \"x\"\nfrom = 0.3\n\
                [[fault]]\nkind = \"bias\"\nvalue = 10\non = \"g.y\"\nfrom = 0.1\n\
                [[fault]]\nkind = \"release\"\non = \"g.y\"\nfrom = 0.2\nfor = 0.2";
    let results = play(&system, text);
    assert_near(results.column("g.y").unwrap(), &[0.0, 0.1, 10.2, 0.3, 0.4, 10.5, 10.6]);
    let x = results.column("x.y").unwrap();
    // At 0.3 it is recorded, then reset: the previous state is gone.
    assert_near(x, &[0.0, 0.0, 0.01, 1.03, 0.03, 0.07, 1.12]);
    let wrong = |text: &str, part: &str| {
        let folder = text.replace("KIND", "kind = \"reset\"");
        let error = scenario(&folder).and_then(|mut s| Run::new(&system).manipulate(&mut s).go());
        let error = error.unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
    };
    wrong("[[fault]]\nKIND\non = \"y\"\nfrom = 0.1", "there is no component 'y'");
    wrong("[[fault]]\nKIND\non = \"x\"\nfrom = 0.1\nfor = 1", "no duration");
    wrong("[[fault]]\nKIND\non = \"x\"", "'from', 'between' or 'when'");
    // Once, when it first holds.
    let results =
        play(&system, "[[fault]]\nkind = \"reset\"\non = \"x\"\nwhen = \"clock.y >= 0.3\"");
    assert_near(results.column("x.y").unwrap(), &[0.0, 0.0, 0.01, 0.03, 0.03, 0.07, 0.12]);
}

#[test]
fn a_fault_that_waits_for_a_condition_begins_after_it_held() {
    let system = chain(0.6).load(&Overrides::new()).unwrap();
    let text = "[[fault]]\nkind = \"override\"\nvalue = 9\non = \"g.y\"\nfor = 0.2\n\
                when = \"clock.y >= 0.2\"";
    let results = play(&system, text);
    assert_near(results.column("g.y").unwrap(), &[0.0, 0.1, 0.2, 9.0, 9.0, 0.5, 0.6]);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_others() {
    let system = chain(2.0).load(&Overrides::new()).unwrap();
    let first = play(&system, MANY);
    assert_eq!(first, play(&system, MANY));
    let other = play(&system, &MANY.replace("seed = 11", "seed = 12"));
    for name in ["g.y", "x.y"] {
        assert_ne!(first.column(name).unwrap(), other.column(name).unwrap(), "{name}");
    }
}

#[test]
fn how_often_is_recorded_changes_nothing() {
    let often = play(&chain(2.0).load(&Overrides::new()).unwrap(), MANY);
    // Conditions are checked at output instants, so this uses only faults without them.
    let text = &MANY[..MANY.find("[[fault]]\nkind = \"bias\"").unwrap()];
    let often_without = play(&chain(2.0).load(&Overrides::new()).unwrap(), text);
    let seldom = play(&chain(2.0).load(&Overrides::new().output_interval(0.5)).unwrap(), text);
    for (name, values) in seldom.columns() {
        let wanted: Vec<f64> =
            often_without.column(name).unwrap().iter().step_by(5).copied().collect();
        assert_eq!(values, wanted, "{name}");
    }
    assert_ne!(often.column("g.y").unwrap(), often_without.column("g.y").unwrap());
}

#[test]
fn a_resumed_run_has_the_faults_and_the_chances_of_the_whole_one() {
    for algorithm in [Algorithm::GaussSeidel, Algorithm::Jacobi] {
        let system = chain(2.0).load(&Overrides::new().algorithm(algorithm)).unwrap();
        let (mut whole, mut kept) = (Recording::new(), Vec::new());
        let mut keep = |snapshot: Snapshot| {
            kept.push(snapshot);
            Ok(())
        };
        let mut first = scenario(MANY).unwrap();
        let run = Run::new(&system).observe(&mut whole).manipulate(&mut first);
        let every = Time::from_seconds(0.1);
        run.snapshots(Some(every), &[], &mut keep).go().unwrap();
        for snapshot in &kept[..19] {
            let (mut rest, mut again) = (Recording::new(), scenario(MANY).unwrap());
            let run = Run::new(&system).observe(&mut rest).manipulate(&mut again);
            run.resume(snapshot).go().unwrap();
            for (name, values) in rest.columns() {
                let all = whole.column(name).unwrap();
                let wanted = &all[all.len() - values.len()..];
                assert_eq!(values, wanted, "{name} from {}", snapshot.time());
            }
        }
    }
}

#[test]
fn a_distributed_run_has_the_bytes_of_one_process() {
    let folder = TempDir::new().unwrap();
    let system = chain(2.0);
    let file = system.write();
    std::fs::write(folder.path().join("many.toml"), MANY).unwrap();
    let run = |name: &str, more: &[&str]| {
        let file = file.to_str().unwrap();
        let run = ["run", file, "-q", "-o", name, "--scenario", "many.toml"];
        let (code, stderr) = outcome(folder.path(), &[&run[..], more].concat());
        assert_eq!(code, 0, "{stderr}");
        results(folder.path(), name)
    };
    let here = run("here.csv", &[]);
    assert_eq!(here, run("there.csv", &["--workers", "2"]));
    assert_ne!(here, run("none.csv", &["--start-value", "free.u=9"]));
}

#[test]
fn faults_that_do_not_fit_the_run_are_refused_before_it() {
    let system = chain(0.6).load(&Overrides::new()).unwrap();
    let text = r#"
        [[fault]]
        kind = "stuck"
        on = ["g.yy", "y.*"]
        [[fault]]
        kind = "zero"
        on = "g.y"
        from = 2
        [[fault]]
        kind = "nan"
        on = "g.y"
        when = "clock.z > 1"
    "#;
    let mut scenario = scenario(text).unwrap();
    let error = Run::new(&system).manipulate(&mut scenario).go().unwrap_err();
    let text = error.to_string();
    for part in ["did you mean 'y'", "'y.*' matches no", "fault 2: it begins at 2", "'clock.y'"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert_eq!(error.problems().count(), 4);
}
