//! FMUs that end the process which runs them, wherever their code is called: the command never
//! looks successful.

use std::path::Path;

use tempfile::TempDir;

use crate::attacks::one_component;
use crate::distributed::cosim;
use crate::models::Model;

/// Where code of an FMU is called.
pub(crate) const PLACES: [&str; 8] = [
    "constructor",
    "version",
    "instantiation",
    "initialization",
    "step",
    "termination",
    "end",
    "destructor",
];

/// An FMU that does something at a place, and `s.ssd` with it.
pub(crate) fn doing(folder: &Path, place: &str, what: &str) -> String {
    let defines = [format!("DOES_AT=\"{place}\""), format!("DOES={what}")];
    let fmu = Model::Gain.variant(
        &folder.join("doing.fmu"),
        &defines.each_ref().map(String::as_str),
        |text| text,
    );
    std::fs::write(folder.join("s.ssd"), one_component(fmu.to_str().unwrap())).unwrap();
    fmu.to_str().unwrap().to_owned()
}

/// The exit code, and what is shown.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = cosim(folder, arguments).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn no_exit_of_an_fmu_is_a_success() {
    let folder = TempDir::new().unwrap();
    for place in PLACES {
        for how in ["exit(0)", "_exit(0)", "quick_exit(0)"] {
            let fmu = doing(folder.path(), place, how);
            let mut commands = vec![
                vec!["simulate", &fmu, "-o", "out.csv"],
                vec!["simulate", &fmu, "-o", "out.csv", "--isolate"],
                vec!["run", "s.ssd", "-o", "out.csv"],
                vec!["run", "s.ssd", "-o", "out.csv", "--workers", "1", "--recoveries", "2"],
            ];
            if ["constructor", "version", "destructor"].contains(&place) {
                commands.push(vec!["validate", &fmu]);
            }
            if ["constructor", "version"].contains(&place) {
                commands.push(vec!["export", "s.ssd", "-o", "whole.fmu"]);
            }
            for command in commands {
                let (code, shown) = run(folder.path(), &command);
                // A worker ends its FMUs when the results are complete.
                let late = ["termination", "end", "destructor"].contains(&place);
                let over = command.contains(&"--workers") && late;
                let what = format!("{place} {how} {command:?}: {code:?} {shown}");
                assert!(code == Some(1) || over && code == Some(0), "{what}");
                assert!(over || shown.contains("error: ["), "{what}");
            }
        }
    }
}

/// What an FMU registers for the end of the process is not called once its run is over.
#[test]
fn what_an_fmu_registers_for_the_end_does_not_change_the_exit_code() {
    let folder = TempDir::new().unwrap();
    for how in ["atexit(leave)", "at_quick_exit(leave)"] {
        doing(folder.path(), "instantiation", how);
        let failing = ["run", "s.ssd", "-o", "out.csv", "--stop-when", "attacker.nothing > 1"];
        let (code, shown) = run(folder.path(), &failing);
        assert_ne!(code, Some(0), "{how}: {shown}");
        assert!(shown.contains("error: ["), "{how}: {shown}");
    }
}

#[test]
fn a_run_of_a_campaign_that_exits_is_a_row_and_fails_again() {
    let folder = TempDir::new().unwrap();
    doing(folder.path(), "step", "exit(0)");
    let file = "seeds = 1\n[systems]\na = 's.ssd'\n[figures.f]\nkind = 'max'\nof = 'attacker.y'\n";
    std::fs::write(folder.path().join("c.toml"), file).unwrap();
    run(folder.path(), &["campaign", "c.toml", "--output-dir", "results"]);
    let log = std::fs::read_to_string(folder.path().join("results/runs.jsonl")).unwrap();
    assert!(log.contains("\"crashed\""), "{log}");
    let (code, shown) = run(folder.path(), &["replay", "results", "0"]);
    assert_eq!(code, Some(1), "{shown}");
    assert!(shown.contains("an FMU ended the process"), "{shown}");
}
