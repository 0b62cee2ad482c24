//! Messages of FMUs and calls to them, as a user follows them.

use std::path::Path;

use cosim::Time;
use cosim::fmi::{Fmu, Instance, Logging};
use tempfile::TempDir;

use crate::command::{cosim, text};
use crate::models::Model;
use crate::ssd::Ssd;

const CATEGORIES: &str = "<LogCategories><Category name=\"logAll\"/><Category name=\"logEvents\"/>\
                          </LogCategories><DefaultExperiment";

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn with_categories(folder: &TempDir) -> std::path::PathBuf {
    Model::Gain.variant(&folder.path().join("gain.fmu"), &[], |description| {
        description.replace("<DefaultExperiment", CATEGORIES)
    })
}

#[test]
fn messages_are_what_printf_makes_of_them() {
    let folder = TempDir::new().unwrap();
    let fmu = folder.path().join("formats.fmu");
    let fmu = Model::Gain.variant(&fmu, &["PRINTF"], |description| description);
    let output =
        cosim(folder.path(), &["simulate", path(&fmu), "--log-fmi-calls", "--stop-time=0.1", "-q"]);
    let shown = text(&output.stderr);
    assert!(output.status.success(), "{shown}");
    let message = |line: &str, category: &str| {
        line.strip_prefix(&format!("GAIN: logger: OK ({category}): ")).map(str::to_owned)
    };
    let expected: Vec<String> = shown.lines().filter_map(|l| message(l, "expected")).collect();
    let rendered: Vec<String> = shown.lines().filter_map(|l| message(l, "rendered")).collect();
    assert_eq!(expected.len(), 13, "{shown}");
    assert_eq!(rendered, expected);
    for line in [
        "(null): (null) and 5",
        "(count): a(%n refused)b 5",
        "(unknown): 5 %y %d",
        "(end): 100%",
        "a status that FMI 2.0 does not have (): \n",
    ] {
        assert!(shown.contains(line), "{line} in {shown}");
    }
    let wild = shown.lines().find(|line| line.contains("(wild)")).unwrap();
    assert!(wild.contains("(not a readable string)"), "{wild}");
    for (category, length) in [("(long)", 16_500), ("(wide)", 1_100)] {
        let line = shown.lines().find(|line| line.contains(category)).unwrap();
        assert!(line.len() < length, "{} bytes of {category}", line.len());
    }
}

#[test]
fn every_instance_logs_for_itself() {
    let folder = TempDir::new().unwrap();
    let ssd = Ssd::new().add("a", Model::Gain).add("b", Model::Gain).stop(0.2);
    let file = ssd.write();
    let output = cosim(folder.path(), &["run", path(&file), "--debug-logging"]);
    let shown = text(&output.stderr);
    for line in ["a: logger: OK (logAll): step to 0.1 s", "b: logger: OK (logAll): step to 0.2 s"] {
        // Once: what was shown immediately is not repeated at the end.
        assert_eq!(shown.matches(line).count(), 1, "{shown}");
    }
    let only = ["run", path(&file), "--debug-logging", "--log-instance=b"];
    let shown = text(&cosim(folder.path(), &only).stderr);
    assert!(shown.contains("b: logger") && !shown.contains("a: logger"), "{shown}");
    let output = cosim(folder.path(), &["run", path(&file), "--debug-logging", "--log-instance=c"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
}

#[test]
fn without_being_asked_an_fmu_says_nothing() {
    let folder = TempDir::new().unwrap();
    let output = cosim(folder.path(), &["simulate", path(&Model::Gain.fmu())]);
    assert!(!text(&output.stderr).contains("step to"));
}

#[test]
fn categories_are_passed_on_and_checked() {
    let folder = TempDir::new().unwrap();
    let fmu = with_categories(&folder);
    let run = |category: &str| {
        let category = format!("--log-category={category}");
        let output = cosim(folder.path(), &["simulate", path(&fmu), "-q", &category]);
        (output.status.code().unwrap(), text(&output.stderr))
    };
    let (code, shown) = run("logEvents");
    assert_eq!(code, 0, "{shown}");
    assert!(shown.contains("(logEvents): category 1 of 1"), "{shown}");
    let (code, shown) = run("logEvent");
    assert_eq!(code, 3);
    assert!(shown.contains("'logEvent'") && shown.contains("'logEvents'?"), "{shown}");
}

#[test]
fn calls_are_written_with_names_values_and_status() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("calls.txt");
    let ssd = Ssd::new().add("clock", Model::Clock).add("g", Model::Gain).connect("clock.y", "g.u");
    let ssd = ssd.stop(0.2);
    let calls = format!("--log-fmi-calls={}", path(&file));
    let system = ssd.write();
    let arguments = ["run", path(&system), &calls, "--output-variable=g.y"];
    let output = cosim(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(!text(&output.stderr).contains("fmi2"));
    let calls = std::fs::read_to_string(&file).unwrap();
    for line in [
        "g: fmi2Instantiate(\"g\", co-simulation, \"{test}\", \"file:///",
        "g: fmi2SetupExperiment(false, 0.0, 0.0, true, 0.2) -> OK\n",
        "g: fmi2EnterInitializationMode() -> OK\n",
        "g: fmi2SetReal(u = 0.1) -> OK\n",
        "g: fmi2DoStep(0.1, 0.1, true) -> OK\n",
        "g: fmi2GetReal(y) -> OK (0.2)\n",
        "g: fmi2Terminate() -> OK\n",
        "g: fmi2FreeInstance() -> OK\n",
    ] {
        assert!(calls.contains(line), "{line} in {calls}");
    }
}

#[test]
fn a_message_in_the_middle_of_a_call_and_a_failure() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Failing.fmu();
    let arguments = ["simulate", path(&fmu), "--log-fmi-calls", "--start-value=second=0.15"];
    let output = cosim(folder.path(), &arguments);
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        shown.contains(
            "FAILING: fmi2DoStep(0.1, 0.1, true)\n\
             FAILING: logger: Error (logStatusError): the tank is empty\n\
             FAILING: ... fmi2DoStep -> Error\n"
        ),
        "{shown}"
    );
    assert!(shown.contains("[E301] fmi2DoStep of 'FAILING' failed at t = 0.1"), "{shown}");
}

#[test]
fn model_exchange_is_followed_too() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Ball.fmu();
    let arguments = ["simulate", path(&fmu), "--log-fmi-calls", "--stop-time=0.5"];
    let shown = text(&cosim(folder.path(), &arguments).stderr);
    for part in
        ["fmi2SetTime(0.", "fmi2GetDerivatives() -> OK (", "fmi2NewDiscreteStates() -> OK (E"]
    {
        assert!(shown.contains(part), "{part} in {shown}");
    }
}

#[test]
fn messages_reach_the_instance_that_they_came_from() {
    let fmu = Fmu::open(&Model::Logging.fmu()).unwrap();
    let make = |name| Instance::new(fmu.clone(), name, &Logging::default()).unwrap();
    let (mut a, b) = (make("a"), make("b"));
    let stop = Time::from_seconds(1.0);
    a.enter_initialization(Time::ZERO, stop).unwrap();
    a.exit_initialization().unwrap();
    let step = Time::from_seconds(0.1);
    let mut time = Time::ZERO;
    while a.do_step(time, step).is_ok() {
        time = time + step;
    }
    assert!(b.messages().is_empty());
}
