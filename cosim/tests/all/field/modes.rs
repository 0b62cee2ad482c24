//! When FMUs accept values, provide them, and end their steps.

use cosim::{Overrides, Recording, System};
use tempfile::TempDir;

use super::{run, with};
use crate::command::{cosim, text};
use crate::formats::{Folder, component, connection, ssd, system};
use crate::manipulations::play;
use crate::models::Model::{Clock, Counter, Gain};
use crate::ssd::Ssd;

fn values() -> Overrides {
    Overrides::new().start_value("k", 3.0).start_value("u", 2.0)
}

#[test]
fn values_are_given_in_the_mode_that_takes_them() {
    let folder = TempDir::new().unwrap();
    for mode in ["SETS_ONLY_IN=0", "SETS_ONLY_IN=1"] {
        let (recording, warnings) = run(&with(&folder, Gain, mode), &values());
        assert_eq!(recording.column("y").unwrap()[0], 6.0, "{mode}");
        assert!(warnings.is_empty(), "{mode}: {warnings:?}");
    }
}

#[test]
fn a_value_that_is_refused_in_every_mode_is_an_error() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "SETS_ONLY_IN=9");
    let output = cosim(folder.path(), &["simulate", fmu.to_str().unwrap(), "--start-value=k=2"]);
    let reported = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{reported}");
    assert!(reported.contains("fmi2SetReal of 'GAIN' failed at t = 0 s"), "{reported}");
}

#[test]
fn outputs_that_cannot_be_read_before_the_first_step_are_named_only_where_they_are_needed() {
    let folder = Folder::new();
    for status in ["2", "3"] {
        let define = format!("READS_ONLY_AFTER={status}");
        let fmu = Gain.variant(&folder.path("late.fmu"), &[&define], |text| text);
        let (recording, warnings) = run(&fmu, &values());
        assert_eq!(recording.column("y").unwrap()[0], 6.0);
        assert!(warnings.is_empty(), "{warnings:?}");
        let ports = "u:input:Real y:output:Real";
        let elements = [component("a", &fmu, ports, ""), component("b", &fmu, ports, "")];
        let text = ssd(&system(&elements.concat(), &connection("a.y", "b.u", "")), "");
        let error = folder.load(&text).unwrap().run(&mut []).unwrap_err().to_string();
        assert!(error.contains("fmi2GetReal of 'a' failed at t = 0 s"), "{error}");
    }
}

#[test]
fn warnings_and_a_failing_end_do_not_fail_a_run() {
    let folder = TempDir::new().unwrap();
    let defines = ["WARNS_ALWAYS", "TERMINATE_FAILS"];
    let fmu = Gain.variant(&folder.path().join("w.fmu"), &defines, |text| text);
    let output = cosim(folder.path(), &["simulate", fmu.to_str().unwrap(), "--start-value=k=2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn an_fmu_that_refuses_to_log_runs_all_the_same() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "REFUSES_DEBUG");
    let output = cosim(folder.path(), &["simulate", fmu.to_str().unwrap(), "--log-category=all"]);
    let reported = text(&output.stderr);
    assert!(output.status.success(), "{reported}");
    assert!(reported.contains("fmi2SetDebugLogging is refused"), "{reported}");
}

#[test]
fn no_step_ends_behind_the_stop_time_that_the_fmu_knows() {
    let folder = TempDir::new().unwrap();
    let defines = ["ENDS_AT_STOP", "NEEDS_STOP"];
    let fmu = Clock.variant(&folder.path().join("e.fmu"), &defines, |text| text);
    // 0.2 + 0.1 is more than 0.3.
    for (step, stop, rows) in
        [(0.1, 0.3, 4), (0.1, 1.0, 11), (0.007, 0.1, 16), (1.0 / 3.0, 7.0, 22)]
    {
        let overrides = Overrides::new().step("", step).stop_time(stop);
        let (recording, _) = run(&fmu, &overrides);
        assert_eq!(recording.time().len(), rows, "{step}");
    }
}

#[test]
fn true_is_whatever_is_not_zero() {
    let folder = Folder::new();
    let fmu = Counter.variant(&folder.path("b.fmu"), &["TRUE_IS_MINUS_ONE"], |text| {
        text.replace("<Boolean start=\"false\"/>", "<Boolean start=\"0\"/>")
    });
    let ports = "odd:input:Boolean even:output:Boolean";
    let elements = [component("a", &fmu, ports, ""), component("b", &fmu, ports, "")];
    let text = ssd(&system(&elements.concat(), &connection("a.even", "b.odd", "")), "");
    let mut recording = Recording::new();
    folder.load(&text).unwrap().run(&mut [&mut recording]).unwrap();
    assert!(recording.column("a.even").unwrap().iter().all(|even| *even == 1.0));
    assert!(recording.column("b.even").unwrap()[1..].iter().all(|even| *even == 0.0));
}

#[test]
fn strings_may_be_missing_or_in_another_encoding() {
    let folder = TempDir::new().unwrap();
    for (define, wanted) in [
        ("STRING_IS_NULL", ""),
        ("STRING_IS_LATIN_1", "caf\u{fffd}"),
        ("STRING_IS_ONE", "(not a readable string)"),
    ] {
        let fmu = with(&folder, Gain, define);
        let system = System::single(&fmu, &Overrides::new().output_variable("text"), None).unwrap();
        let mut recording = Recording::new();
        system.run(&mut [&mut recording]).unwrap();
        assert_eq!(&*recording.text("text").unwrap()[0], wanted);
    }
}

#[test]
fn addresses_of_messages_need_not_be_valid() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "LOGS_ONE");
    let system = System::single(&fmu, &Overrides::new(), None).unwrap();
    let summary = system.run(&mut []).unwrap();
    let wanted = "GAIN: OK ((not a readable string)): (not a readable string)";
    assert_eq!(summary.messages.last().map(String::as_str), Some(wanted));
}

#[test]
fn an_fmu_may_call_step_finished() {
    let folder = TempDir::new().unwrap();
    let (recording, _) = run(&with(&folder, Gain, "CALLS_STEP_FINISHED"), &values());
    assert_eq!(recording.column("y").unwrap().len(), 11);
}

#[test]
fn a_tunable_parameter_changes_during_the_run() {
    let folder = TempDir::new().unwrap();
    let fixed = "causality=\"parameter\" variability=\"fixed\"><Real start=\"1\"";
    let tunable = Gain.varied(folder.path(), fixed, &fixed.replace("fixed", "tunable"));
    let ssd = Ssd::new().add("g", Gain).stop(0.4);
    let system = ssd.load(&Overrides::new().replace("g", tunable).start_value("g.u", 2)).unwrap();
    let events = r#"{"events": [{"time": 0.2, "model": "g", "variable": "k", "value": 5,
        "action": "override"}]}"#;
    // A fixed one is refused: manipulations::a_scenario_is_checked_before_the_run.
    assert_eq!(play(&system, events).column("g.y").unwrap(), [2.0, 2.0, 2.0, 10.0, 10.0]);
}
